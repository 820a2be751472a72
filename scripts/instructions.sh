#!/bin/sh
# Counts the instructions that one sample of the Cornell box takes, by callgrind: what start and end of the program take
# is the same at both sample counts and falls out of the difference. Unlike seconds, they do not depend on the machine's
# mood.
#
#   scripts/instructions.sh PROGRAM [FLAG...]     such as target/release/etendue --kernel everything
set -eu
scene=$(dirname "$0")/../scenes/cornell-box/cornell-box.toml
command -v valgrind >/dev/null || { echo "instructions: install valgrind" >&2; exit 1; }
program=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
side=64
few=4
many=36

count() {
    spp=$1
    shift
    valgrind --tool=callgrind --callgrind-out-file="$folder/calls" "$program" render "$scene" \
        --size ${side}x$side --spp "$spp" --max-bounces 8 --sampler independent --precision fast \
        --threads 1 --quiet --out "$folder/image.pfm" "$@" 2>"$folder/log" || {
        cat "$folder/log" >&2
        exit 1
    }
    sed -n 's/.*refs: *//p' "$folder/log" | tr -d ,
}

low=$(count $few "$@")
high=$(count $many "$@")
samples=$((side * side * (many - few)))
echo "$((($high - $low) / samples)) instructions a sample: $program $*"
