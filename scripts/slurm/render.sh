#!/bin/sh
# Renders a scene on a Slurm cluster: a job array of shards, a job that merges them, and again for what is missing or, with
# ERROR, until the image is as good as that.
#
#   scripts/slurm/render.sh FOLDER SHARDS SPP SCENE [FLAG...]
#   scripts/slurm/render.sh FOLDER
#
# Given a FOLDER alone, a render that failed or was cancelled goes on: what is missing is submitted again.
#
# FLAGs are those of `etendue render` that affect samples, or --layers. FOLDER is made; all nodes have to share it, and
# see SCENE. It gets `image.exr`, a `part-A..B.etd` and a log for each shard, `report.json` of the last merge, and at last
# the file `done`, or `failed` with the reason. All of it is kept between jobs in files: `settings` (the environment below),
# `command` (scene and flags, one a line), `round` (the ranges of samples of the current array, one a line), `spp`, `shards`,
# `tries`, `rounds`, `choices.json` (of pilots, for all shards); of an adaptive render, `pilot` (its samples), `pilot-spp` (SPP, which
# its length follows from) and `pilot.etd`. With --adaptive, the pilot is the first round; it distributes the samples of all later
# rounds.
#
# Environment: ETENDUE, the program (default: etendue). ERROR, the error to reach, such as 1%. ROUNDS, how often samples are
# added to reach it (default: 8). IMAGE, the output (default: FOLDER/image.exr). TRIES, how often shards that are missing are
# submitted again (default: 3). EVERY, the time between two checkpoints (default: 60s). SBATCH_OPTIONS, more options for every
# job, such as "--partition=short --cpus-per-task=8". CONFIDENCE, that of the bound of the error (default: 95%).
#SBATCH --requeue
set -eu
here=$(cd "$(dirname "$0")" && pwd)

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

# Replaces the current round by the samples $1..$2. Whole or not at all: a job that is queued again reads it.
begin_round() {
    divide "$1" "$2" "$(cat "$folder/shards")" >"$folder/round.new"
    echo "${TRIES:-3}" >"$folder/tries"
    mv "$folder/round.new" "$folder/round"
}

# The samples of the pilot of an adaptive render of $1 samples, as `etendue render` has them.
pilot_of() {
    long=$((($1 + 15) / 16))
    short=$((($1 + 3) / 4))
    short=$((short < 64 ? short : 64))
    echo $((((long > short ? long : short) + 3) / 4 * 4))
}

# The array indices of the shards that are not there: ranges, separated by commas.
missing() {
    index=0
    first=
    separator=
    {
        cat "$folder/round"
        echo end
    } | while IFS= read -r range; do
        if [ "$range" != end ] && [ ! -e "$folder/part-$range.etd" ]; then
            first=${first:-$index}
        elif [ -n "$first" ]; then
            printf '%s%s' "$separator" "$first"
            [ "$first" = $((index - 1)) ] || printf -- '-%s' $((index - 1))
            separator=,
            first=
        fi
        index=$((index + 1))
    done
}

# Submits the array of what is missing, if anything is, and the job that goes on after it: both or none. A job that is queued
# again after that submits nothing.
submit() {
    # Ended between the array and the file that says so, this job would submit the array again.
    trap '' TERM
    after=
    if [ -n "$(missing)" ]; then
        # shellcheck disable=SC2086
        array=$(sbatch --parsable ${SBATCH_OPTIONS:-} --array="$(missing)" --output="$folder/log-%a.txt" \
            "$folder/shard.sh" "$folder") || return 1
        array=${array%%;*}
        after=--dependency=afterany:$array
        echo "$array" >"$folder/array"
    fi
    # shellcheck disable=SC2086
    if ! sbatch --parsable ${SBATCH_OPTIONS:-} --job-name=etendue-merge ${after:+"$after"} \
        --output="$folder/log-merge.txt" --open-mode=append "$folder/next.sh" --next "$folder" >/dev/null; then
        [ -z "$after" ] || scancel "$array"
        return 1
    fi
    : >"$folder/submitted-${SLURM_JOB_ID:-0}"
}

# Submits the next jobs of a render that has begun.
submit_again() {
    submit || fail "sbatch refused a job: see $folder/log-merge.txt"
}

fail() {
    echo "$1" >"$folder/failed"
    exit 1
}

# Whether shards are missing, among them those of earlier rounds that a merge has set aside as damaged.
is_incomplete() {
    for file in "$folder"/part-*.etd.damaged*; do
        range=${file##*/part-}
        range=${range%%.etd*}
        if [ -e "$file" ] && [ ! -e "$folder/part-$range.etd" ]; then
            grep -qxF "$range" "$folder/round" || echo "$range" >>"$folder/round"
        fi
    done
    [ -n "$(missing)" ]
}

# Merges the pilot again if all of its shards are there: a damaged pilot fails every shard of the later rounds.
merge_pilot_again() {
    [ -e "$folder/pilot.etd" ] || return 0
    pilot=$(cat "$folder/pilot")
    samples=0
    set --
    for part in "$folder"/part-*.etd; do
        range=${part##*/part-}
        range=${range%.etd}
        if [ "${range%%..*}" -lt "$pilot" ]; then
            set -- "$@" "$part"
            samples=$((samples + ${range##*..} - ${range%%..*}))
        fi
    done
    [ "$samples" = "$pilot" ] || return 0
    # The samples after the pilot are missing.
    "$etendue" merge --partial --quiet "$@" --out "$folder/pilot.etd" ||
        echo "the pilot stays as it is" >&2
}

# Submits what is missing again.
try_again() {
    tries=$(($(cat "$folder/tries") - 1))
    [ "$tries" -ge 0 ] || fail "shards $(missing) are missing: see $folder/log-*.txt"
    echo "$tries" >"$folder/tries"
    merge_pilot_again
    submit_again
}

# Goes on after an array: again what is missing, or the merge, or another round. A merge that finds a damaged shard sets it
# aside, so that it is missing.
next() {
    if [ -n "$(missing)" ]; then
        try_again
        return
    fi
    # What is whole needs no checkpoint.
    rm -f "$folder"/checkpoint-*.etd "$folder"/.etendue-*.part
    first=$(head -n 1 "$folder/round")
    if [ -e "$folder/pilot" ] && [ "${first%%..*}" = 0 ]; then
        # Later rounds need the pilot's file, too.
        code=0
        "$etendue" merge --set-damaged-aside --partial --quiet "$folder"/part-*.etd --out "$folder/pilot.etd" || code=$?
        if is_incomplete; then
            rm -f "$folder/pilot.etd"
            try_again
            return
        fi
        [ "$code" = 0 ] || fail "the pilot was not merged: see $folder/log-merge.txt"
        pilot=$(cat "$folder/pilot")
        if [ "$pilot" -lt "$(cat "$folder/spp")" ]; then
            begin_round "$pilot" "$(cat "$folder/spp")"
            submit_again
            return
        fi
    fi
    code=0
    "$etendue" merge --set-damaged-aside "$folder"/part-*.etd --out "${IMAGE:-$folder/image.exr}" --json ${ERROR:+--error "$ERROR"} \
        ${CONFIDENCE:+--confidence "$CONFIDENCE"} \
        >"$folder/report.json" || code=$?
    if is_incomplete; then
        try_again
        return
    fi
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
    rounds=$(($(cat "$folder/rounds") - 1))
    [ "$rounds" -ge 0 ] || fail "the image is written, but its error is above $ERROR after ${ROUNDS:-8} more rounds: see $folder/report.json"
    # What was merged, not what was asked for: this job may have been queued again after the next round was begun.
    spp=$(sed -n 's/^ *"spp": *\([0-9][0-9]*\).*/\1/p' "$folder/report.json")
    needed=$(sed -n 's/^ *"needed_spp": *\([0-9][0-9]*\).*/\1/p' "$folder/report.json")
    needed=${needed:-$((2 * spp))}
    least=$((spp + (spp + 15) / 16 * 4))
    needed=$((needed > least ? needed : least))
    needed=$((needed < 4 * spp ? needed : 4 * spp))
    echo "$needed" >"$folder/spp"
    begin_round "$spp" "$needed"
    echo "$rounds" >"$folder/rounds"
    submit_again
}

# Says so if this job ends before its work is done: nobody would go on.
note_end() {
    [ -n "${is_done:-}" ] || [ -e "$folder/failed" ] ||
        echo "the job that merges ended early: see $folder/log-merge.txt" >"$folder/failed"
}

if [ "${1:-}" = --next ]; then
    folder=$2
    [ -z "${SLURM_JOB_ID:-}" ] || [ ! -e "$folder/submitted-$SLURM_JOB_ID" ] || exit 0
    # shellcheck disable=SC1091
    [ ! -e "$folder/settings" ] || . "$folder/settings"
    etendue=${ETENDUE:-etendue}
    # A job that was ended and queued again goes on.
    rm -f "$folder/failed"
    trap note_end EXIT
    trap 'exit 1' TERM
    next
    is_done=1
    exit
fi
if [ $# -eq 1 ] && [ -e "$1/round" ]; then
    folder=$(cd "$1" && pwd)
    # shellcheck disable=SC1091
    [ ! -e "$folder/settings" ] || . "$folder/settings"
    rm -f "$folder/failed" "$folder/done"
    echo "${TRIES:-3}" >"$folder/tries"
    echo "${ROUNDS:-8}" >"$folder/rounds"
    submit
    echo "submitted: wait for $folder/done or $folder/failed"
    exit
fi
if [ $# -lt 4 ]; then
    sed -n '2,6p' "$0" >&2
    exit 2
fi
mkdir -p "$1"
folder=$(cd "$1" && pwd)
[ ! -e "$folder/round" ] || { echo "render.sh: $folder has a render already: render.sh $folder goes on with it" >&2; exit 2; }
rm -f "$folder/pilot" "$folder/pilot-spp" "$folder/pilot.etd" "$folder/choices.json"
shards=$2
# Rounds of four: later rounds begin where this one ends.
spp=$((($3 + 3) / 4 * 4))
shift 3
scene=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
shift
end=$spp
for word in "$@"; do
    case $word in
    --adaptive | --adaptive=two-phase)
        end=$(pilot_of "$spp")
        echo "$end" >"$folder/pilot"
        echo "$spp" >"$folder/pilot-spp"
        ;;
    --spp* | --time* | --max-time* | --error* | --shard* | --pilot* | --checkpoint* | --every* | --resume* | --out* | -o* | \
        --denoise* | --exposure* | --confidence* | --stats* | --json | --threads* | -t* | --quiet | -q | --adaptive=greedy)
        echo "render.sh: $word is no flag of shards" >&2
        exit 2
        ;;
    stratified | --sampler=stratified)
        if [ -n "${ERROR:-}" ]; then
            echo "render.sh: the strata follow from the number of samples, so that no round can be added: leave out ERROR" >&2
            exit 2
        fi
        ;;
    esac
done
printf '%s\n' "$scene" "$@" >"$folder/command"
# Jobs may start with another environment.
export -p | grep -E '^(export|declare -x) (ETENDUE|ERROR|CONFIDENCE|ROUNDS|IMAGE|TRIES|EVERY|SBATCH_OPTIONS)=' >"$folder/settings" || true
echo "$shards" >"$folder/shards"
echo "$spp" >"$folder/spp"
echo "${ROUNDS:-8}" >"$folder/rounds"
begin_round 0 "$end"
# Slurm copies a script when it is submitted; these copies are submitted again and again.
cp "$here/render.sh" "$folder/next.sh"
cp "$here/shard.sh" "$folder/shard.sh"
# What was refused may be submitted again.
submit || { rm -f "$folder/round"; exit 1; }
echo "submitted: wait for $folder/done or $folder/failed"
