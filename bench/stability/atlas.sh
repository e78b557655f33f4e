#!/bin/sh
# The atlas of what fails where:
#     atlas.sh [--quick] [--full] [--only WORD,...] [--build DIR] [--out DIR]
#     atlas.sh --natural [--crossings N] [--full] [--only WORD,...] [--build DIR] [--out DIR]
# by default of build/ into bench/out, within 30 minutes on two cores; --quick within 3; --full adds 1e6 and 1e7
# triangles, --only leaves situations with a WORD in their name. Leaves atlas.csv and atlas.md. --natural: N (1e9) crossings
# in all of packets aimed at nothing in particular, within 20 minutes; leaves natural.csv and natural.md.
# tests/stability/README.md says what is flown and counted.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/../lib/lib.sh"
quick= full= natural= crossings=1e9 only= table=atlas
options "quick full natural" "build out crossings only" "$@"
need_number --crossings "$crossings"
need_built "$build/clustermcml" "$build/tests/stability_atlas"
need python3
seconds=5
[ ! "$quick" ] || seconds=0.2
if [ "$natural" ]; then
    table=natural seconds=0
else
    crossings=1e8 # a cell, which ends by its seconds
fi
mkdir -p "$out"
python3 -B "$root/tests/stability/atlas.py" "$build/clustermcml" "$build/tests/stability_atlas" \
    --crossings "$crossings" --seconds "$seconds" --out "$out/$table.csv" --only "$only" $natural $full
python3 -B "$here/atlas_table.py" "$out/$table.csv" $natural >"$out/$table.md"
cat "$out/$table.md"
