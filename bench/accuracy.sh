#!/bin/sh
# Charts what accuracy each way to represent a boundary buys for its time:
#     accuracy.sh [--quick] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves accuracy.csv, accuracy.txt and, with gnuplot, accuracy.svg.
#     accuracy.sh --draw CSV SVG
# draws a result again (a name that ends in .png: as PNG). bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
draw() { # CSV SVG
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    python3 -B "$here/accuracy_table.py" "$1" --series "$work"
    case $2 in *.png) kind=pngcairo ;; *) kind=svg ;; esac
    gnuplot -e "work='$work'; out='$2'; kind='$kind'" "$here/accuracy.gp"
    [ $kind = pngcairo ] || python3 -B "$here/shrink_svg.py" "$2"
}
if [ "${1-}" = --draw ]; then
    [ $# -eq 3 ] || fail "--draw needs CSV and SVG"
    need python3 gnuplot
    [ -r "$2" ] || fail "$2: cannot be read"
    draw "$2" "$3"
    exit
fi
quick=
options quick "program out" "$@"
need_program
need python3

mkdir -p "$out"
python3 -B "$here/accuracy.py" "$program" "$out" $quick >"$out/accuracy.txt"
cat "$out/accuracy.txt"
if command -v gnuplot >/dev/null; then
    draw "$out/accuracy.csv" "$out/accuracy.svg"
else
    echo "no gnuplot, no figure" >&2
fi
