#!/bin/sh
# Charts what accuracy each way to represent a boundary buys for its time:
#     accuracy.sh [--quick] [--only SCENE,...] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves accuracy.csv, accuracy.txt and, with gnuplot, accuracy.svg.
# --only flies these scenes and no others.
#     accuracy.sh --draw CSV SVG
# draws a result again (a name that ends in .png: as PNG). bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
draw_again accuracy "$@"
quick= only=
options quick "only program out" "$@"
need_program
need python3

python3 -B "$here/accuracy.py" "$program" "$out" $quick ${only:+--only "$only"}
draw_result accuracy
