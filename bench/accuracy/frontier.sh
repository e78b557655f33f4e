#!/bin/sh
# Charts how long each way to fly a scene takes to an error, against its bias, before and after lattice sampling and the roulette
# window:
#     frontier.sh [--quick] [--only SCENE,...] [--rounds N] [--mcml PATH] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves frontier.csv, frontier.txt and, with gnuplot, frontier.svg. --mcml is a
# binary of original MCML, which is then timed on the same scenes without their shapes. --only flies the scenes that it
# names, and draws nothing.
#     frontier.sh --draw CSV SVG
# draws a result again (a name that ends in .png: as PNG). bench/accuracy/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
draw() { # CSV SVG
    python3 -B "$here/frontier_table.py" "$1" --series "$work"
    case $2 in *.png) kind=pngcairo ;; *) kind=svg ;; esac
    gnuplot -e "work='$work'; out='$2'; kind='$kind'" "$here/frontier.gp"
    [ $kind = pngcairo ] || python3 -B "$lib/shrink_svg.py" "$2"
}
draw_again SVG "$@"
quick= mcml= only= rounds=
options quick "mcml only rounds program out" "$@"
[ -z "$rounds" ] || need_number --rounds "$rounds"
need_program
[ -z "$mcml" ] || need_built "$mcml"
need python3

mkdir -p "$out"
python3 -B "$here/frontier.py" "$program" "$out" $quick ${mcml:+--mcml "$mcml"} ${only:+--only "$only"} \
    ${rounds:+--rounds "$rounds"} >"$out/frontier.txt"
cat "$out/frontier.txt"
[ -n "$only" ] || draw_result "$out/frontier.csv" "$out/frontier.svg"
