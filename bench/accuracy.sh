#!/bin/sh
# Charts what accuracy each way to represent a boundary buys for its time: accuracy.sh [--quick] [--program PATH] [--out DIR]
# by default of build/clustermcml into bench/out. Leaves accuracy.csv, accuracy.txt and, with gnuplot, accuracy.svg.
# accuracy.sh --draw CSV SVG draws a result again. bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$here/../build/clustermcml
out=$here/out
quick=
usage() { sed -n 's/^# Charts.*: //p' "$0"; exit "$1"; }
draw() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    python3 -B "$here/accuracy_table.py" "$1" --series "$work"
    gnuplot -e "work='$work'; out='$2'" "$here/accuracy.gp"
}
while [ $# -gt 0 ]; do
    case $1 in
    --quick) quick=--quick ;;
    --draw)
        [ $# -eq 3 ] || usage 2 >&2
        draw "$2" "$3"
        exit
        ;;
    --program | --out)
        [ $# -ge 2 ] || usage 2 >&2
        case $1 in --program) program=$2 ;; --out) out=$2 ;; esac
        shift
        ;;
    -h | --help) usage 0 ;;
    *) usage 2 >&2 ;;
    esac
    shift
done
[ -x "$program" ] || { echo "$program is no program: build it first (see README.md)" >&2; exit 2; }
command -v python3 >/dev/null || { echo "python3 is missing" >&2; exit 2; }

mkdir -p "$out"
python3 -B "$here/accuracy.py" "$program" "$out" $quick >"$out/accuracy.txt"
cat "$out/accuracy.txt"
if command -v gnuplot >/dev/null; then
    draw "$out/accuracy.csv" "$out/accuracy.svg"
else
    echo "no gnuplot, no figure" >&2
fi
