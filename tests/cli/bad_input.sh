#!/bin/sh
# Tests that every input of bad_input.cases is refused with exactly its one line and exit code 2, and that nothing is written.
# SPDX-License-Identifier: MIT
set -u
cases=$PWD/tests/cli/bad_input.cases
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# One directory per case: kind, expected message, the file itself.
awk -v out="$scratch" '
    /^@/ { n++; dir = sprintf("%s/%03d", out, n); system("mkdir -p " dir); kind = substr($1, 2)
           file = dir "/" (kind == "mci" ? "scene.mci" : kind == "table" ? "angles.txt" : kind == "seen" ? "seen.txt" : "mesh." kind); printf "" > file
           sub(/^@[a-z]+ /, ""); print > (dir "/expected"); next }
    n    { print > file }' "$cases"

sound_scene='1.0\n1\na.mco A\n100\n0.1 0.2\n3 4 5\n1\n1\nm "mesh.obj"\n1.4 1 2 0.9 1\n1\n'
sound_mesh='v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 .1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n'
lamp_scene='1.0\n1\na.mco A\nbeam pencil light="angles.txt"\n100\n0.1 0.2\n3 4 5\n1\n1\n1.4 1 2 0.9 1\n1\n'
seen_scene='1.0\n1\na.mco A\ndetector disk 1 name=a\ndetector table "seen.txt"\n100\n0.1 0.2\n3 4 5\n1\n1\n1.4 1 2 0.9 1\n1\n'
number=0
failed=0
for dir in "$scratch"/*/; do
    number=$((number + 1))
    [ ! -f "$dir/angles.txt" ] || printf "$lamp_scene" >"$dir/scene.mci"
    [ ! -f "$dir/seen.txt" ] || printf "$seen_scene" >"$dir/scene.mci"
    for kind in stl ply; do [ ! -f "$dir/mesh.$kind" ] || printf "$sound_scene" | sed "s/mesh.obj/mesh.$kind/" >"$dir/scene.mci"; done
    [ -f "$dir/scene.mci" ] || printf "$sound_scene" >"$dir/scene.mci"
    [ -f "$dir/mesh.obj" ] || printf "$sound_mesh" >"$dir/mesh.obj"
    mkdir "$dir/results"
    code=0
    (cd "$dir" && "$CLUSTERMCML" scene.mci -o results >stdout 2>stderr) || code=$?
    if [ "$code" -ne 2 ] || [ -s "$dir/stdout" ] || [ -n "$(ls "$dir/results")" ] ||
        ! cmp -s "$dir/stderr" "$dir/expected"; then
        failed=$((failed + 1))
        echo "exit code $code, files: $(ls "$dir/results")"
        diff "$dir/expected" "$dir/stderr"
    fi
done
echo "$((number - failed)) of $number inputs refused as they should be"
[ "$failed" -eq 0 ] && [ "$number" -ge 60 ]
