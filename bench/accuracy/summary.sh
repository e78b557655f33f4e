#!/bin/sh
# The one chart of accuracy against speed, three scenes and at most six ways to fly each:
#     summary.sh [--quick] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves summary.csv and, with gnuplot, summary.svg. A minute.
#     summary.sh --draw CSV SVG
# draws a result again. bench/accuracy/README.md says how to read it.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
draw() { # CSV SVG
    python3 -B "$here/summary.py" series "$1" "$work"
    gnuplot -e "work='$work'; out='$2'" "$here/summary.gp"
    python3 -B "$lib/shrink_svg.py" "$2"
}
draw_again SVG "$@"
quick=
options quick "program out" "$@"
need_program
need python3
mkdir -p "$out"
python3 -B "$here/summary.py" measure "$program" "$out" $quick
draw_result "$out/summary.csv" "$out/summary.svg"
