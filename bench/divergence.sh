#!/bin/sh
# How long lanes of a GPU wait for each other, and how often they add to one bin, counted without a GPU:
#     divergence.sh [--stages CSV] [--build DIR] [--out DIR]
# Builds bench_divergence in build/, which flies the packets of S1 to S6 and of the hill, and lets 32 lanes do their steps in
# several orders of work. CSV (results/gpu-stages.csv): instructions of each stage, from gpu_static.sh. Leaves divergence.csv
# in DIR (bench/out), and prints its tables.
#     python3 bench/divergence.py --readme CSV bench/README.md
# writes them into the text.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
stages=$here/results/gpu-stages.csv
options "" "stages build out" "$@"
[ -f "$build/CMakeCache.txt" ] || fail "$build: no build folder of cmake"
[ -r "$stages" ] || fail "$stages: cannot be read"
need python3 cmake
mkdir -p "$out"
cmake --build "$build" --target bench_divergence >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 2; }
rm "$out/log"
cd "$root/samples"
"$build/bench_divergence" "$stages" fig5.mci fig6.mci fig7text.mci mcml_sample.mci skin7.mci thick.mci ../bench/scenes/S6b.mci \
    shapes/hihill.mci >"$out/divergence.csv"
python3 -B "$here/divergence.py" "$out/divergence.csv"
