#!/bin/sh
# Measures the speed of clustermcml: speed.sh [--quick] [--rounds N] [--mcml PATH] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. --mcml is a binary of original MCML, timed on the flat scenes in the
# same rounds. Leaves speed.csv, speed.txt and, with gnuplot, speed.svg. bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$here/../build/clustermcml
out=$here/out
usage() { sed -n 's/^# Measures.*: //p' "$0"; exit "$1"; }
quick= rounds=5 mcml=
while [ $# -gt 0 ]; do
    case $1 in
    --quick) quick=--quick ;;
    --rounds | --mcml | --program | --out)
        [ $# -ge 2 ] || usage 2
        case $1 in --rounds) rounds=$2 ;; --mcml) mcml=$2 ;; --program) program=$2 ;; --out) out=$2 ;; esac
        shift
        ;;
    -h | --help) usage 0 ;;
    *) usage 2 >&2 ;;
    esac
    shift
done
[ -x "$program" ] || { echo "$program is no program: build it first (see README.md)" >&2; exit 2; }
[ -z "$mcml" ] || [ -x "$mcml" ] || { echo "$mcml is no program" >&2; exit 2; }
command -v python3 >/dev/null || { echo "python3 is missing" >&2; exit 2; }

python3 -B "$here/speed.py" "$program" "$out" --rounds "$rounds" $quick ${mcml:+--mcml "$mcml"}
if command -v gnuplot >/dev/null; then
    sh "$here/figure.sh" "$out/speed.csv" "$out/speed.svg"
else
    echo "no gnuplot, no figure" >&2
fi
