#!/bin/sh
# Studies a scene on a Slurm cluster: a job that plans, a job array that renders the shards, and a job that merges them.
#
#   scripts/slurm/study.sh FOLDER SHARDS SCENE [FLAG...]
#   scripts/slurm/study.sh FOLDER
#
# FLAGs are those of `etendue study`; --budget is the time of each shard. FOLDER is made; all nodes have to share it, and see
# SCENE. It gets `plan.json`, a `part-K.exr` and a log for each shard, the pages of the study, and at last the file `done`, or
# `failed` with the reason. Given a FOLDER alone, the script submits again what is missing there. Times are measured, so a
# node should run nothing else: SBATCH_OPTIONS="--exclusive".
#
# Environment: ETENDUE, the program (default: etendue). SBATCH_OPTIONS, more options for every job, such as
# "--partition=short --cpus-per-task=8".
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu

# Runs one step of the study as a job: --plan, --shard or --merge.
run_step() {
    step=$1
    folder=$2
    # shellcheck disable=SC1091
    [ ! -e "$folder/settings" ] || . "$folder/settings"
    set --
    while IFS= read -r word; do
        set -- "$@" "$word"
    done <"$folder/command"
    set -- study "$@" --out "$folder" --threads "${SLURM_CPUS_PER_TASK:-${SLURM_CPUS_ON_NODE:-1}}" --quiet
    case $step in
    --plan)
        [ ! -e "$folder/plan.json" ] || exit 0
        # Shards of another plan.
        rm -f "$folder"/part-*.exr
        exec "${ETENDUE:-etendue}" "$@" --shards "$(cat "$folder/shards")"
        ;;
    --shard)
        [ ! -e "$folder/part-$SLURM_ARRAY_TASK_ID.exr" ] || exit 0
        exec "${ETENDUE:-etendue}" "$@" --shard "$SLURM_ARRAY_TASK_ID/$(cat "$folder/shards")"
        ;;
    esac
    rm -f "$folder/done" "$folder/failed"
    trap 'exit 1' TERM
    trap '[ -e "$folder/done" ] || [ -e "$folder/failed" ] || echo "the job that merges ended early: see $folder/log-*.txt" >"$folder/failed"' EXIT
    if "${ETENDUE:-etendue}" "$@" --merge; then
        date >"$folder/done"
    else
        echo "see $folder/log-*.txt; study.sh $folder submits again what is missing" >"$folder/failed"
        exit 1
    fi
}

# Submits a job of this script; prints its number.
submit() {
    # shellcheck disable=SC2086
    job=$(sbatch --parsable ${SBATCH_OPTIONS:-} --kill-on-invalid-dep=yes "$@") || return 1
    echo "${job%%;*}"
}

# The array indices of the shards that are not there, separated by commas.
missing() {
    index=0
    separator=
    count=$(cat "$folder/shards")
    while [ "$index" -lt "$count" ]; do
        if [ ! -e "$folder/part-$index.exr" ]; then
            printf '%s%s' "$separator" "$index"
            separator=,
        fi
        index=$((index + 1))
    done
}

case ${1:-} in
--plan | --shard | --merge)
    run_step "$1" "$2"
    exit
    ;;
esac
here=$(cd "$(dirname "$0")" && pwd)
if [ $# -ge 3 ]; then
    mkdir -p "$1"
    folder=$(cd "$1" && pwd)
    [ ! -e "$folder/command" ] || { echo "study.sh: $folder has a study already" >&2; exit 2; }
    shards=$2
    scene=$(cd "$(dirname "$3")" && pwd)/$(basename "$3")
    shift 3
    for word in "$@"; do
        case $word in
        --shard* | --merge* | --partial* | --out* | -o* | --threads* | -t* | --quiet | -q | --json)
            echo "study.sh: $word is no flag of studies in shards" >&2
            exit 2
            ;;
        esac
    done
    echo "$shards" >"$folder/shards"
    # Jobs may start with another environment.
    export -p | grep -E '^(export|declare -x) (ETENDUE|SBATCH_OPTIONS)=' >"$folder/settings" || true
    printf '%s\n' "$scene" "$@" >"$folder/command"
elif [ $# -eq 1 ] && [ -e "$1/command" ]; then
    folder=$(cd "$1" && pwd)
    # shellcheck disable=SC1091
    [ ! -e "$folder/settings" ] || . "$folder/settings"
else
    sed -n '2,5p' "$0" >&2
    exit 2
fi
rm -f "$folder/done" "$folder/failed"
set --
if [ ! -e "$folder/plan.json" ]; then
    plan=$(submit --job-name=etendue-plan --output="$folder/log-plan.txt" "$here/study.sh" --plan "$folder")
    set -- "--dependency=afterok:$plan"
fi
if [ -n "$(missing)" ]; then
    array=$(submit --job-name=etendue-study --array="$(missing)" --output="$folder/log-%a.txt" "$@" \
        "$here/study.sh" --shard "$folder")
    set -- "--dependency=afterany:$array"
fi
submit --job-name=etendue-merge --output="$folder/log-merge.txt" "$@" "$here/study.sh" --merge "$folder" >/dev/null
echo "submitted: wait for $folder/done or $folder/failed"
