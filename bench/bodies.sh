#!/bin/sh
# What do bodies cost? Measures clustermcml on scenes with a body and without it:
#     bodies.sh [--rounds N] [--against PATH] [--program PATH] [--out DIR]
# by default build/clustermcml, 5 rounds, into bench/out. --against is another clustermcml, run in the same rounds. Prints
# medians: processor time per step, and steps per second over those of the same scene without bodies.
# bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
rounds=5 against=
options "" "rounds against program out" "$@"
need_number --rounds "$rounds"
need_program
[ ! "$against" ] || need_built "$against"
need python3

exec python3 -B "$here/bodies.py" "$out" "$rounds" "$program" ${against:+"$against"}
