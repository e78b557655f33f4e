#!/bin/sh
# Charts what accuracy each way to represent a boundary buys for its time:
#     accuracy.sh [--quick] [--only SCENE,...] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves accuracy.csv, accuracy.txt and, with gnuplot, accuracy/SCENE.svg.
# --only flies these scenes and no others.
#     accuracy.sh --draw CSV DIRECTORY
# draws a result again, a page for each scene. bench/accuracy/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
draw() { # CSV DIRECTORY
    python3 -B "$here/accuracy_table.py" "$1" --series "$work"
    mkdir -p "$2"
    for scene in $(cat "$work/scenes"); do
        gnuplot -e "work='$work'; scene='$scene'; out='$2/$scene.svg'" "$here/accuracy.gp"
        python3 -B "$lib/shrink_svg.py" "$2/$scene.svg"
    done
}
draw_again DIRECTORY "$@"
quick= only=
options quick "only program out" "$@"
need_program
need python3

python3 -B "$here/accuracy.py" "$program" "$out" $quick ${only:+--only "$only"}
draw_result "$out/accuracy.csv" "$out/accuracy"
