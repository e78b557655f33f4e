#!/bin/sh
# The one chart of accuracy against speed, three scenes and at most six ways to fly each:
#     summary.sh [--quick] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves summary.csv and, with gnuplot, summary.svg. Ten minutes, --quick: three.
#     summary.sh --draw CSV SVG
# draws a result again. bench/README.md says how to read it.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
draw_summary() { # CSV SVG
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    python3 -B "$here/summary.py" series "$1" "$work"
    gnuplot -e "work='$work'; out='$2'" "$here/summary.gp"
    python3 -B "$here/shrink_svg.py" "$2"
}
if [ "${1-}" = --draw ]; then
    [ $# -eq 3 ] || fail "--draw needs CSV and SVG"
    need python3 gnuplot
    [ -r "$2" ] || fail "$2: cannot be read"
    draw_summary "$2" "$3"
    exit
fi
quick=
options quick "program out" "$@"
need_program
need python3
mkdir -p "$out"
python3 -B "$here/summary.py" measure "$program" "$out" $quick
command -v gnuplot >/dev/null || { echo "no gnuplot, no figure" >&2; exit; }
draw_summary "$out/summary.csv" "$out/summary.svg"
