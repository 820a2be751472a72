#!/bin/sh
# Renders a scene on a Slurm cluster: a job array of shards, a job that merges them, and again for what is missing or, with
# ERROR, until the image is as good as that.
#
#   scripts/slurm/render.sh FOLDER SHARDS SPP SCENE [FLAG...]
#
# FLAGs are those of `etendue render` that affect samples, or --layers. FOLDER is made; all nodes have to share it, and
# see SCENE. It gets `image.exr`, a `part-A..B.etd` and a log for each shard, `report.json` of the last merge, and at last
# the file `done`, or `failed` with the reason. All of it is kept between jobs in files: `command` (scene and flags, one a
# line), `round` (the ranges of samples of the current array, one a line), `spp`, `shards`, `tries`.
#
# Environment: ETENDUE, the program (default: etendue). ERROR, the error to reach, such as 1%. IMAGE, the output (default:
# FOLDER/image.exr). TRIES, how often shards that are missing are submitted again (default: 3). EVERY, the time between two
# checkpoints (default: 60s). SBATCH_OPTIONS, more options for every job, such as "--partition=short --cpus-per-task=8".
set -eu
here=$(cd "$(dirname "$0")" && pwd)
etendue=${ETENDUE:-etendue}

# Divides the samples $1..$2 into at most $3 ranges of whole rounds of four.
divide() {
    rounds=$((($2 - $1 + 3) / 4))
    count=$(($3 < rounds ? $3 : rounds))
    index=0
    while [ "$index" -lt "$count" ]; do
        first=$(($1 + rounds * index / count * 4))
        end=$(($1 + rounds * (index + 1) / count * 4))
        echo "$first..$((end < $2 ? end : $2))"
        index=$((index + 1))
    done
}

# The array indices of the shards that are not there, separated by commas.
missing() {
    index=0
    while IFS= read -r range; do
        [ -e "$folder/part-$range.etd" ] || printf '%s%s' "${separator:-}" "$index"
        [ -e "$folder/part-$range.etd" ] || separator=,
        index=$((index + 1))
    done <"$folder/round"
}

# Submits the array of what is missing, and the job that goes on after it: both or none.
submit() {
    # shellcheck disable=SC2086
    array=$(sbatch --parsable ${SBATCH_OPTIONS:-} --array="$(missing)" --output="$folder/log-%a.txt" \
        "$here/shard.sh" "$folder") || return 1
    array=${array%%;*}
    # shellcheck disable=SC2086
    if ! sbatch --parsable ${SBATCH_OPTIONS:-} --job-name=etendue-merge --dependency="afterany:$array" \
        --output="$folder/log-merge.txt" --open-mode=append "$folder/next.sh" --next "$folder" >/dev/null; then
        scancel "$array"
        return 1
    fi
    echo "$array" >"$folder/array"
}

# Submits the next jobs of a render that has begun.
submit_again() {
    submit || fail "sbatch refused a job: see $folder/log-merge.txt"
}

fail() {
    echo "$1" >"$folder/failed"
    exit 1
}

# Goes on after an array: again what is missing, or the merge, or another round.
next() {
    if [ -n "$(missing)" ]; then
        tries=$(($(cat "$folder/tries") - 1))
        [ "$tries" -ge 0 ] || fail "shards $(missing) are missing: see $folder/log-*.txt"
        echo "$tries" >"$folder/tries"
        submit_again
        return
    fi
    code=0
    "$etendue" merge "$folder"/part-*.etd --out "${IMAGE:-$folder/image.exr}" --json ${ERROR:+--error "$ERROR"} \
        >"$folder/report.json" || code=$?
    case $code in
    0) echo "$(cat "$folder/spp") samples per pixel" >"$folder/done" ;;
    5) another_round ;;
    6) fail "the image is written, but too many of its samples were not finite: see $folder/log-merge.txt" ;;
    *) fail "the merge failed: see $folder/log-merge.txt" ;;
    esac
}

# Submits the samples that the error still takes, by the merge's forecast: at least a quarter more, at most four times as
# many, since a forecast from far is rough. An error in doubt gives none.
another_round() {
    spp=$(cat "$folder/spp")
    needed=$(sed -n 's/.*"needed_spp": *\([0-9][0-9]*\).*/\1/p' "$folder/report.json")
    needed=${needed:-$((2 * spp))}
    least=$((spp + (spp + 15) / 16 * 4))
    needed=$((needed > least ? needed : least))
    needed=$((needed < 4 * spp ? needed : 4 * spp))
    echo "$needed" >"$folder/spp"
    divide "$spp" "$needed" "$(cat "$folder/shards")" >"$folder/round"
    echo "${TRIES:-3}" >"$folder/tries"
    submit_again
}

# Says so if this job ends before its work is done: nobody would go on.
note_end() {
    [ -n "${is_done:-}" ] || [ -e "$folder/failed" ] ||
        echo "the job that merges ended early: see $folder/log-merge.txt" >"$folder/failed"
}

if [ "${1:-}" = --next ]; then
    folder=$2
    here=$(cat "$folder/scripts")
    trap note_end EXIT
    trap 'exit 1' TERM
    next
    is_done=1
    exit
fi
if [ $# -lt 4 ]; then
    sed -n '2,5p' "$0" >&2
    exit 2
fi
mkdir -p "$1"
folder=$(cd "$1" && pwd)
[ ! -e "$folder/round" ] || { echo "render.sh: $folder has a render already" >&2; exit 2; }
shards=$2
# Rounds of four: later rounds begin where this one ends.
spp=$((($3 + 3) / 4 * 4))
shift 3
scene=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
shift
printf '%s\n' "$scene" "$@" >"$folder/command"
echo "$shards" >"$folder/shards"
echo "$spp" >"$folder/spp"
echo "${TRIES:-3}" >"$folder/tries"
echo "$here" >"$folder/scripts"
divide 0 "$spp" "$shards" >"$folder/round"
# Slurm copies a script when it is submitted; this copy is submitted again and again.
cp "$here/render.sh" "$folder/next.sh"
# What was refused may be submitted again.
submit || { rm -f "$folder/round"; exit 1; }
echo "submitted: wait for $folder/done or $folder/failed"
