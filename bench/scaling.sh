#!/bin/sh
# Measures what ranks cost each other, and predicts what a thousand would:
#     scaling.sh [--photons N] [--program PATH] [--out DIR]
# by default 2e6 photons with build/clustermcml into bench/out. Leaves scaling.txt. bench/README.md says how to read it.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
photons=2e6
options "" "photons program out" "$@"
need_number --photons "$photons"
need_program
need python3 mpiexec
mkdir -p "$out"
python3 -B "$here/scaling.py" "$program" "$photons" | tee "$out/scaling.txt"
