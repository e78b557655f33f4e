#!/bin/sh
# The atlas of what fails where: atlas.sh [--quick] [--full] [--build DIR] [--out DIR]
# by default of build/ into bench/out, within 30 minutes on two cores; --quick within 3; --full adds 1e6 and 1e7
# triangles. Leaves atlas.csv and atlas.md. tests/stability/README.md says what is flown and counted.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
build=$here/../build
out=$here/out
usage() { sed -n 's/^# The atlas.*: //p' "$0"; exit "$1"; }
seconds=5 full=
while [ $# -gt 0 ]; do
    case $1 in
    --quick) seconds=0.2 ;;
    --full) full=--full ;;
    --build | --out)
        [ $# -ge 2 ] || usage 2
        case $1 in --build) build=$2 ;; --out) out=$2 ;; esac
        shift
        ;;
    -h | --help) usage 0 ;;
    *) usage 2 >&2 ;;
    esac
    shift
done
for program in "$build/clustermcml" "$build/tests/stability_atlas"; do
    [ -x "$program" ] || { echo "$program is no program: build it first (see README.md)" >&2; exit 2; }
done
mkdir -p "$out"
python3 -B "$here/../tests/stability/atlas.py" "$build/clustermcml" "$build/tests/stability_atlas" \
    --crossings 1e8 --seconds "$seconds" --out "$out/atlas.csv" $full
python3 -B "$here/atlas_table.py" "$out/atlas.csv" >"$out/atlas.md"
cat "$out/atlas.md"
