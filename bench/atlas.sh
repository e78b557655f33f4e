#!/bin/sh
# The atlas of what fails where:
#     atlas.sh [--quick] [--full] [--build DIR] [--out DIR]
# by default of build/ into bench/out, within 30 minutes on two cores; --quick within 3; --full adds 1e6 and 1e7
# triangles. Leaves atlas.csv and atlas.md. tests/stability/README.md says what is flown and counted.
# SPDX-License-Identifier: MIT
set -eu
. "$(dirname "$0")/lib.sh"
quick= full=
options "quick full" "build out" "$@"
need_built "$build/clustermcml" "$build/tests/stability_atlas"
need python3
seconds=5
[ ! "$quick" ] || seconds=0.2
mkdir -p "$out"
python3 -B "$here/../tests/stability/atlas.py" "$build/clustermcml" "$build/tests/stability_atlas" \
    --crossings 1e8 --seconds "$seconds" --out "$out/atlas.csv" $full
python3 -B "$here/atlas_table.py" "$out/atlas.csv" >"$out/atlas.md"
cat "$out/atlas.md"
