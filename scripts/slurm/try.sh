#!/bin/sh
# Tries the scripts on a Slurm of one node on this machine: 16 shards, of which one is cancelled and one killed, have the bits
# of one render, those of an adaptive render too, rounds go on until an error is reached, also by an adaptive render, and a study
# is merged. Needs Debian's slurm-wlm and munge, and root.
#
#   scripts/slurm/try.sh PROGRAM     such as target/release/etendue
set -eu
here=$(cd "$(dirname "$0")" && pwd)
ETENDUE=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
export ETENDUE
scene=$here/../../scenes/cornell-box/cornell-box.toml
command -v sbatch >/dev/null || { echo "try.sh: install slurm-wlm and munge" >&2; exit 1; }
folder=$(mktemp -d)
"$here/one-node.sh" start "$folder/slurm"
SLURM_CONF=$folder/slurm/slurm.conf
export SLURM_CONF
trap '"$here/one-node.sh" stop "$folder/slurm"; rm -rf "$folder"' EXIT
# A shell that a signal ends runs no EXIT trap.
trap 'exit 1' INT TERM
export EVERY=0.2s TRIES=3

# Waits until a command succeeds, for at most two minutes.
wait_for() {
    tenths=0
    until "$@"; do
        tenths=$((tenths + 1))
        [ "$tenths" -lt 1200 ] || { echo "try.sh: waited in vain for: $*" >&2; squeue; cat "$folder"/*/log-*.txt; exit 1; }
        sleep 0.1
    done
}
ended() { [ -e "$1/done" ] || [ -e "$1/failed" ]; }
# The processes of the shards that are being rendered. They are found by their folder.
shards() { pgrep -f "render .*$1/part-" || true; }
several() { [ "$(shards "$1" | wc -l)" -ge 1 ] && [ -n "$(ls "$1" | grep checkpoint)" ]; }

# A task of the array that is running.
running() {
    task=$(squeue --noheader --states=RUNNING --job="$array" --array --format=%i | tail -n 1)
    [ -n "$task" ]
}

render=$folder/bits
IMAGE=$render/image.pfm "$here/render.sh" "$render" 16 4096 "$scene" --size 128x128
wait_for several "$render"
victim=$(shards "$render" | head -n 1)
kill -KILL "$victim"
echo "killed process $victim"
array=$(cat "$render/array")
wait_for running
scancel "$task"
echo "cancelled task $task"
wait_for ended "$render"
cat "$render/failed" 2>/dev/null && exit 1
"$ETENDUE" render "$scene" --size 128x128 --spp 4096 --quiet --out "$folder/whole.pfm"
cmp "$folder/whole.pfm" "$render/image.pfm"
echo "16 shards, one killed and one cancelled, have the bits of one render"

render=$folder/adaptive
IMAGE=$render/image.pfm "$here/render.sh" "$render" 4 256 "$scene" --size 128x128 --adaptive
wait_for ended "$render"
cat "$render/failed" 2>/dev/null && exit 1
"$ETENDUE" render "$scene" --size 128x128 --spp 256 --adaptive --quiet --out "$folder/adaptive.pfm"
cmp "$folder/adaptive.pfm" "$render/image.pfm"
echo "an adaptive render in shards has the bits of one render"

render=$folder/error
ERROR=1.5% "$here/render.sh" "$render" 4 64 "$scene" --size 128x128
wait_for ended "$render"
cat "$render/failed" 2>/dev/null && exit 1
cat "$render/report.json" "$render/done"
grep -q '"reached": true' "$render/report.json"
[ "$(cat "$render/spp")" -gt 64 ] || { echo "try.sh: 64 samples were enough, so that no round was tried" >&2; exit 1; }
echo "the error was reached after $(ls "$render"/part-*.etd | wc -l) shards"

render=$folder/adaptive-error
ERROR=3% IMAGE=$render/image.pfm "$here/render.sh" "$render" 4 64 "$scene" --size 128x128 --adaptive
wait_for ended "$render"
cat "$render/failed" 2>/dev/null && exit 1
grep -q '"reached": true' "$render/report.json"
[ "$(cat "$render/spp")" -gt 64 ] || { echo "try.sh: 64 samples were enough, so that no round was tried" >&2; exit 1; }
"$ETENDUE" render "$scene" --size 128x128 --spp 64 --adaptive --quiet --out "$folder/begun.etd"
"$ETENDUE" render "$scene" --size 128x128 --spp "$(cat "$render/spp")" --adaptive --quiet --resume "$folder/begun.etd" \
    --out "$folder/adaptive-error.pfm"
cmp "$folder/adaptive-error.pfm" "$render/image.pfm"
echo "an adaptive render reached its error after $(cat "$render/spp") samples, with the bits of one that was continued"

study=$folder/study
"$here/study.sh" "$study" 3 "$scene" --size 64x64 --budget 6s
wait_for ended "$study"
cat "$study/failed" "$study"/log-*.txt 2>/dev/null || true
[ -e "$study/done" ]
rm "$study/part-1.exr"
"$here/study.sh" "$study"
wait_for ended "$study"
[ -e "$study/done" ] && [ -e "$study/part-1.exr" ]
grep 'An error of 1 %' "$study/study.md"
echo "a study in three shards is merged, also after one was lost"
