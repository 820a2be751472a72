#!/bin/sh
# Renders one shard of a render on Slurm, as a task of a job array; render.sh submits it.
#
#   sbatch --array=0-15 scripts/slurm/shard.sh FOLDER
#
# FOLDER is shared by all nodes and has the files that render.sh describes. A task that is submitted or queued again goes
# on from its checkpoint, and ends at once if its shard is there. A checkpoint that is damaged is kept under another name, which
# the log tells, and the shard begins anew. `settings` there may name ETENDUE, the program, and EVERY, the
# time between two checkpoints.
#SBATCH --job-name=etendue-shard
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu
folder=$1
# shellcheck disable=SC1091
[ ! -e "$folder/settings" ] || . "$folder/settings"
line=$((SLURM_ARRAY_TASK_ID + 1))
range=$(sed -n "${line}p" "$folder/round")
part=$folder/part-$range.etd
checkpoint=$folder/checkpoint-$range.etd
if [ -e "$part" ]; then
    exit 0
fi
set --
while IFS= read -r word; do
    set -- "$@" "$word"
done <"$folder/command"
spp=$folder/spp
pilot=$(cat "$folder/pilot" 2>/dev/null || echo 0)
if [ "${range%%..*}" -lt "$pilot" ]; then
    spp=$folder/pilot-spp
elif [ -e "$folder/pilot.etd" ]; then
    set -- "$@" --pilot "$folder/pilot.etd"
fi
if [ -e "$checkpoint" ]; then
    set -- "$@" --resume "$checkpoint" --set-damaged-aside
fi
# The program takes the place of the shell, so that SIGTERM reaches it, and its checkpoint has all that was done.
exec "${ETENDUE:-etendue}" render "$@" --spp "$(cat "$spp")" --shard "$range" --out "$part" \
    --choices "$folder/choices.json" --checkpoint "$checkpoint" --every "${EVERY:-60s}" \
    --threads "${SLURM_CPUS_PER_TASK:-${SLURM_CPUS_ON_NODE:-1}}" --quiet
