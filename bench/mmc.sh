#!/bin/sh
# Times clustermcml against MMC (Mesh-based Monte Carlo, https://github.com/fangq/mmc) below rough tops:
#     mmc.sh --mmc PATH [--rounds N] [--program PATH] [--out DIR]
# by default build/clustermcml into bench/out. PATH is MMC's program, built by its own Makefile; tetgen fills the slab
# with tetrahedra for it. Leaves mmc.md. bench/README.md says how to read it.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
rounds=5 mmc=
options "" "rounds mmc program out" "$@"
need_number --rounds "$rounds"
need_program
[ "$mmc" ] || fail "--mmc is missing: the program to compare with"
need_built "$mmc"
need python3 tetgen

python3 -B "$here/mmc.py" "$program" "$mmc" "$out" --rounds "$rounds"
