#!/usr/bin/env bash
# Makes each planted bug (tests/planted/table.rs) live in turn and runs the test that has to find it. Writes which test killed
# which bug to out/mutants/mutants.md, and fails if a bug survives. Without a live bug these tests have to pass.
#
#   scripts/mutants.sh         all of them
#   scripts/mutants.sh NAME    this one
#
# Where the named test fails to find its bug, all other tests are run, to tell whether one of them does.
# Variables: CARGO (default: cargo), OUT (default: out).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly table="${OUT:-out}/mutants/mutants.md"
readonly log="${OUT:-out}/mutants/last.log"
readonly most_seconds=1200
mkdir -p "$(dirname "$table")"
# The packages of this workspace alone are built anew; see the wrapper.
export RUSTC_WORKSPACE_WRAPPER="$PWD/scripts/rustc-with-mutants.sh"
unset ETENDUE_MUTANT
# Every case of a test runs: any of them may be the one that finds the bug.
export ETENDUE_NIGHTLY=1
# Failures that are meant to be leave no notes in the sources.
export PROPTEST_DISABLE_FAILURE_PERSISTENCE=1

# Builds test targets, all if none are named, and notes their programs.
declare -A program
build() {
    local arguments=() target line
    for target in "$@"; do
        if [ "$target" = lib ]; then arguments+=(--lib); else arguments+=(--test "$target"); fi
    done
    [ $# -gt 0 ] || arguments=(--tests)
    "${CARGO:-cargo}" test --no-run "${arguments[@]}" 2>&1 | tee "$log" >&2
    while read -r line; do
        case "$line" in
            *"Executable unittests src/lib.rs ("*/etendue-*) target=lib ;;
            *"Executable tests/"*) target="${line#*tests/}" target="${target%%.rs *}" target="${target%/main}" ;;
            *) continue ;;
        esac
        line="${line##*(}"
        program[$target]="${line%)}"
    done <"$log"
}

# Runs one test, or all of a target: succeeds if they pass.
passes() {
    local target="$1"
    shift
    timeout "$most_seconds" "${program[$target]}" "$@" >"$log" 2>&1 </dev/null
}

# The first test that the log says failed.
first_failure() {
    sed -n 's/^test \(.*\) \.\.\. FAILED$/\1/p' "$log" | head -n 1
}

# The first test of all that fails, as target::test.
search() {
    local target
    for target in $(printf '%s\n' "${!program[@]}" | sort); do
        if ! passes "$target"; then
            printf '%s::%s' "$target" "$(first_failure)"
            return
        fi
    done
}

# The table's lines that are asked for: name, killer and what is wrong, between tabs.
wanted() {
    local name killer wrong
    while IFS=$'\t' read -r name killer wrong; do
        case "$mode" in
            all | "$name") ;;
            *) continue ;;
        esac
        printf '%s\t%s\t%s\n' "$name" "$killer" "$wrong"
    done
}

mode="${1:-all}"
build planted
if ! passes planted --nocapture --test-threads 1; then
    cat "$log" >&2
    exit 1
fi
bugs=$(sed -n 's/^planted\t//p' "$log" | wanted)
[ -n "$bugs" ] || {
    echo "no planted bug is called $mode" >&2
    exit 2
}
# shellcheck disable=SC2046 # one word a target
build $(cut -f2 <<<"$bugs" | sed 's/::.*//' | sort -u)

# A test tells something only if it is there, and passes where nothing is wrong.
while IFS=$'\t' read -r _ killer _; do
    target="${killer%%::*}"
    passes "$target" --exact "${killer#*::}" && grep -q '^test result: ok. 1 passed' "$log" || {
        cat "$log" >&2
        echo "without a bug, $killer should pass" >&2
        exit 1
    }
done < <(sort -u -t$'\t' -k2,2 <<<"$bugs")

survivors=0 killed=0
printf '| planted bug | what is wrong | killed by | seconds |\n|---|---|---|---|\n' >"$table"
while IFS=$'\t' read -r name killer wrong; do
    target="${killer%%::*}"
    export ETENDUE_MUTANT="$name"
    start=$(date +%s.%N) status=0
    passes "$target" --exact "${killer#*::}" || status=$?
    seconds=$(awk "BEGIN { printf \"%.1f\", $(date +%s.%N) - $start }")
    # 101 is a failed test; whatever else ends it, such as the limit of time, tells nothing.
    if [ "$status" = 101 ]; then
        killed=$((killed + 1))
        printf '| %s | %s | `%s` | %s |\n' "$name" "$wrong" "$killer" "$seconds" | tee -a "$table"
    else
        survivors=$((survivors + 1))
        echo "$name SURVIVES $killer (status $status): $wrong" >&2
        unset ETENDUE_MUTANT
        build
        export ETENDUE_MUTANT="$name"
        found=$(search)
        echo "  found by ${found:-no test}" >&2
    fi
    unset ETENDUE_MUTANT
done <<<"$bugs"

echo "$killed planted bugs killed, $survivors survived: $table"
[ "$survivors" = 0 ]
