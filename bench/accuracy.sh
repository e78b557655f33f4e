#!/bin/sh
# Charts what accuracy each way to represent a boundary buys for its time:
#     accuracy.sh [--quick] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves accuracy.csv, accuracy.txt and, with gnuplot, accuracy.svg.
#     accuracy.sh --draw CSV SVG
# draws a result again (a name that ends in .png: as PNG). bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
draw_again accuracy "$@"
quick=
options quick "program out" "$@"
need_program
need python3

mkdir -p "$out"
python3 -B "$here/accuracy.py" "$program" "$out" $quick >"$out/accuracy.txt"
cat "$out/accuracy.txt"
draw_result accuracy
