#!/bin/sh
# Makes docs/study.md: studies of five scenes, one after the other, by a built program.
#
# Usage: scripts/studies.sh PROGRAM [BUDGET]    (from the root; the budget is that of each scene, default 15m)
# Nothing else should run on the machine meanwhile. Pages and numbers of each go to out/study-SCENE/.
set -eu

program=$1
budget=${2:-15m}

one() {
    scene=$1
    shift
    "$program" study "scenes/$scene/$scene.toml" --budget "$budget" "$@" -o "out/study-$scene" >/dev/null
}

one cornell-box --vary sampler=independent,sobol
one suzanne-room --vary sampler=independent,sobol
one shaded-lamps --vary integrator=path,bdpt,mlt --reference bdpt
one ajar-door --vary integrator=path,bdpt,mlt --reference bdpt
one environment --vary sampler=independent,sobol

{
    echo '<!-- Made by scripts/studies.sh; this page is what each `etendue study` writes to study.md. -->'
    for scene in cornell-box suzanne-room shaded-lamps ajar-door environment; do
        # The command as anybody would type it, without the folder of this build.
        sed "s|\`[^\` ]*etendue study|\`etendue study|" "out/study-$scene/study.md"
    done
} >docs/study.md
