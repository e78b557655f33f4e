#!/bin/sh
# Measures the speed of clustermcml:
#     speed.sh [--quick] [--irregular] [--rounds N] [--mcml PATH] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. --mcml is a binary of original MCML, timed on the flat scenes in the
# same rounds. --irregular flies irregular and overhanging tops only, with the regular grids and planes beside them. Leaves speed.csv, speed.txt and, with gnuplot, speed.svg. bench/speed/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
quick= irregular= rounds=5 mcml=
options "quick irregular" "rounds mcml program out" "$@"
need_number --rounds "$rounds"
need_program
[ ! "$mcml" ] || need_built "$mcml"
need python3

python3 -B "$here/speed.py" "$program" "$out" --rounds "$rounds" $quick $irregular ${mcml:+--mcml "$mcml"}
if command -v gnuplot >/dev/null; then
    sh "$here/figure.sh" "$out/speed.csv" "$out/speed.svg"
else
    echo "no gnuplot, no figure" >&2
fi
