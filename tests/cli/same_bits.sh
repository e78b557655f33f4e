#!/bin/sh
# Tests that the .mco is the same, byte by byte but for its line of time, for any number of threads and any size of chunks.
# The .h5, .vti and .vtp, which hold no time, are the same in all bytes.
# SPDX-License-Identifier: MIT
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

result() { # scene, then options: prints a checksum of all lines but the time
    rm -f "$scratch"/*
    "$CLUSTERMCML" "$@" --photons 5000 --quiet -o "$scratch"
    cat "$scratch"/*.mco | grep -v '^# User time' | sha256sum
}

timed=$(mktemp -d)
trap 'rm -rf "$scratch" "$timed"' EXIT
# A fluence of so many bins that threads share its array.
sed "s/^90 200 1/90 400 1/; s/^\(.*# nz, nr, na\)/\1\ntime 100 200 radii\ndirections 9 12\nfluence\ndetector ring 0.1 2 na=0.6\ndetector disk 1 side=bottom/; s#\"\.\./meshes#\"$PWD/meshes#" samples/mixed.mci >"$timed/mixed.mci"
grep -q "^time" "$timed/mixed.mci" && grep -q "^90 400" "$timed/mixed.mci"

for scene in samples/mcml_sample.mci samples/shapes/hinoise.mci "$timed/mixed.mci"; do
    expected=$(result "$scene" --threads 1)
    for options in "--threads 2" "--threads 3" "--threads 7" "--threads 32" "--chunk 1" "--chunk 1000 --threads 3" "--chunk 1e6"; do
        # shellcheck disable=SC2086 # several options on purpose
        [ "$(result "$scene" $options)" = "$expected" ] || { echo "$scene differs with $options"; exit 1; }
    done
    [ "$(result "$scene" --seed 2)" != "$expected" ] || { echo "$scene: the seed has no effect"; exit 1; }
    echo "$scene: same bits"
done

# Compares all files of a run with maps, also when the program is called from another folder. In the .h5 the command line and
# the input's path, 4096 bytes each, are masked; every other byte counts, and the size, too.
masked() { # FILE COMMAND INPUT
    python3 -c '
import sys
data = open(sys.argv[1], "rb").read()
for text in sys.argv[2:]:
    at = data.index(text.encode() + b"\0")
    data = data[:at] + bytes(4096) + data[at + 4096:]
sys.stdout.buffer.write(data)' "$@"
}
maps() { # FOLDER SCENE OPTIONS...
    folder=$1
    shift
    rm -f "$scratch"/*
    command="$CLUSTERMCML $* --photons 5000 --quiet -o $scratch"
    # shellcheck disable=SC2086 # words on purpose
    (cd "$folder" && exec $command)
    masked "$scratch"/*.h5 "$command" "$1" >"$scratch/h5"
    cat "$scratch"/h5 "$scratch"/*.vti "$scratch"/*.vtp | sha256sum
}
scene=samples/skinmap.mci
expected=$(maps . "$scene" --threads 1)
for options in "--threads 2" "--threads 3" "--threads 7" "--threads 32" "--threads 2 --chunk 1000"; do
    # shellcheck disable=SC2086 # several options on purpose
    [ "$(maps . "$scene" $options)" = "$expected" ] || { echo "$scene differs with $options"; exit 1; }
done
[ "$(maps samples skinmap.mci --threads 1)" = "$expected" ] || { echo "$scene differs from its own folder"; exit 1; }
[ "$(maps . "$scene" --threads 1 --seed 2)" != "$expected" ] || { echo "$scene: the seed has no effect"; exit 1; }
[ "$(ls "$scratch" | wc -l)" -eq 6 ] || { echo "$scene: not all files"; exit 1; }
echo "$scene: same bits in all files"
