#!/bin/sh
# Are results unbiased, and their errors true?
#     unbiased.sh [--runs N] [--photons N] [--reference N] [--scene NAME] [--build DIR] [--out DIR]
# Flies N (2000) independent runs of N (1e4) photons of S1 to S6a, three shapes and a rough scan, in build/, as the program
# does by default. Their means are compared with adding-doubling and with stored profiles where tests/reference has them,
# else with N (1e8) photons of random sampling and MCML's roulette. How often runs lie within one and two of their own
# errors is counted there and in as many runs of 1000 and 12345 photons. Leaves unbiased.md, unbiased-sizes.md and a CSV of every scene in
# bench/out; exit code 1 when a mean or an error is wrong.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
runs=2000 photons=1e4 reference=1e8 scene=
options "" "runs photons reference scene build out" "$@"
need_number --runs "$runs"
need_number --photons "$photons"
need_number --reference "$reference"
[ -f "$build/CMakeCache.txt" ] || fail "$build: no build folder of cmake"
need python3 cmake
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cmake --build "$build" --target bench_unbiased >"$log" 2>&1 || { cat "$log" >&2; exit 2; }
mkdir -p "$out"
python3 -B "$here/unbiased.py" "$build/bench_unbiased" "$out" "$runs" "$photons" "$reference" ${scene:+"$scene"}
