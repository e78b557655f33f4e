#!/bin/sh
# Do threads wait for threads that the system does not let run? Measures clustermcml beside busy loops:
#     busy_machine.sh [--rounds N] [--loops N] [--against PATH] [--program PATH]
# by default build/clustermcml, 5 rounds, beside 2 loops. Every round runs every case on one thread and on two; --against
# is another clustermcml, run in the same rounds. --loops 0: an idle machine, threads bound to cores
# (OMP_PROC_BIND=true). Prints medians: wall and processor seconds of the process, on two threads also over those on
# one. bench/README.md says how to read them.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
rounds=5 loops=2 against=
options "" "rounds loops against program" "$@"
need_number --rounds "$rounds"
[ "$loops" = 0 ] || need_number --loops "$loops"
need_program
[ ! "$against" ] || need_built "$against"
need python3

exec python3 -B "$here/busy_machine.py" "$rounds" "$loops" "$program" ${against:+"$against"}
