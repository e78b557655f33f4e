#!/bin/sh
# What the parts of the cpu engine cost on this machine:
#     parts.sh [--build DIR] [--out DIR]
# Builds the benches in build/, runs bench_stages, bench_busy, bench_curved, bench_asked and bench_queries and leaves
# parts.txt in bench/out: the vector loops alone and left out, where the time of the flat scenes goes, then, below rough
# tops and rings where light is scattered often (S6a) and seldom (S2), where it goes there, how often regular, irregular
# and spiked tops are asked and met, and what a step near the boundary costs by itself.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
options "" "build out" "$@"
[ -f "$build/CMakeCache.txt" ] || fail "$build: no build folder of cmake"
need python3 cmake
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --build "$build" --target benches >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 2; }
mkdir -p "$out"

python3 -B "$lib/rough.py" mesh 3e5 0.018 "$work/rough.obj"
python3 -B "$lib/rough.py" rings 50 0.018 "$work/rings.txt"
python3 -B "$lib/rough.py" rings 1000 0.018 "$work/rings-1000.txt"
PYTHONPATH=$lib python3 -B -c '
import sys, cases
for medium in ("S6a", "S2"):
    cases.write_scene(medium, sys.argv[1] + "/" + medium + "-rough.mci", surface="m \"rough.obj\"")
    for rings in ("rings", "rings-1000"):
        cases.write_scene(medium, f"{sys.argv[1]}/{medium}-{rings}.mci", surface=f"b \"{rings}.txt\"")
for medium, amplitude in (("S2", cases.AMPLITUDE), ("A", cases.AMPLITUDE_A), ("S6a", cases.AMPLITUDE)):
    for kind in ("mesh", *cases.IRREGULAR):
        print(cases.top_case(medium, kind, cases.QUICK, amplitude, sys.argv[1]).path)' "$work" >"$work/tops"

{
    echo "# $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1); load $(cut -d' ' -f1-3 /proc/loadavg)"
    "$build/bench_stages" >"$work/stages.csv"
    cat "$work/stages.csv"
    echo "# flat scenes: per photon, what happens, and where the time goes"
    python3 -B "$here/bounds.py" "$build/bench_busy" "$work/stages.csv"
    echo "# curved tops: per photon, where the time goes"
    python3 -B "$here/curved.py" "$build/bench_curved" "$work"
    echo "# regular and irregular tops: steps of a photon, rays asked of the boundary per step, and those that met it"
    xargs "$build/bench_asked" <"$work/tops" | sed "s|$work/||; s|[.]mci||"
    for scene in S6a-rough S6a-rings S6a-rings-1000 S2-rough S2-rings; do
        echo "# $scene"
        "$build/bench_queries" "$work/$scene.mci"
    done
    for medium in S6a S2; do
        echo "# $medium-rings as a mesh"
        "$build/bench_queries" "$work/$medium-rings.mci" --mesh
    done
} >"$out/parts.txt"
cat "$out/parts.txt"
