#!/bin/sh
# The same .mco, byte by byte but for its line of time, whatever the number of threads and the size of chunks; and the
# same .h5, .vti and .vtp, which hold no time at all.
# SPDX-License-Identifier: MIT
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

result() { # scene, then options: prints a checksum of all lines but the time
    rm -f "$scratch"/*
    "$CLUSTERMCML" "$@" --photons 20000 --quiet -o "$scratch"
    cat "$scratch"/*.mco | grep -v '^# User time' | sha256sum
}

for scene in samples/mcml_sample.mci samples/shapes/hinoise.mci samples/mixed.mci; do
    expected=$(result "$scene" --threads 1)
    for options in "--threads 2" "--threads 3" "--threads 7" "--threads 32" "--chunk 1" "--chunk 1000 --threads 3" "--chunk 1e6"; do
        # shellcheck disable=SC2086 # several options on purpose
        [ "$(result "$scene" $options)" = "$expected" ] || { echo "$scene differs with $options"; exit 1; }
    done
    [ "$(result "$scene" --seed 2)" != "$expected" ] || { echo "$scene: the seed has no effect"; exit 1; }
    echo "$scene: same bits"
done

# All files of a run with maps. The .h5 knows the command line, so the threads come from the environment.
scene=samples/skinmap.mci
expected=$(OMP_NUM_THREADS=1 result "$scene" && cat "$scratch"/*.vti "$scratch"/*.vtp "$scratch"/*.h5 | sha256sum)
for threads in 2 3 7 32; do
    found=$(OMP_NUM_THREADS=$threads result "$scene" && cat "$scratch"/*.vti "$scratch"/*.vtp "$scratch"/*.h5 | sha256sum)
    [ "$found" = "$expected" ] || { echo "$scene differs with $threads threads"; exit 1; }
done
[ "$(ls "$scratch" | wc -l)" -eq 5 ] || { echo "$scene: not all files"; exit 1; }
echo "$scene: same bits in all files"
