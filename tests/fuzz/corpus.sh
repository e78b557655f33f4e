#!/bin/sh
# Makes first inputs of the fuzzers, one folder per target: corpus.sh PROGRAM FOLDER. They come from the samples, the meshes,
# the refused inputs of tests/cli and short runs of the program, so that nothing is stored twice.
# SPDX-License-Identifier: MIT
set -eu
program=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
cd "$(dirname "$0")/../.."
for target in mci fly obj stl ply heightmap mco options checkpoint sweep; do mkdir -p "$out/$target"; done

# Joins a scene and the files that it names into one input, in the order in which they are read (FUZZ_CUT of fuzz.h).
join() {
    cat "$1"
    grep -o '"\.\./meshes/[^"]*"' "$1" | tr -d '"' | while read -r file; do
        printf '\n%%%%%%%%\n'
        cat "samples/$file"
    done
}
for scene in samples/*.mci samples/shapes/*.mci; do join "$scene" >"$out/mci/$(basename "$scene")"; done

# Refused inputs: kind, message, then the file. Tables of a beam's light, and of detectors, are no inputs by themselves.
awk -v out="$out" '
    /^@(table|seen)/ { n++; file = "/dev/null"; next }
    /^@/ { n++; file = sprintf("%s/%s/refused%03d", out, substr($1, 2), n); printf "" > file; next }
    n    { print > file }' tests/cli/bad_input.cases

cp meshes/*.obj "$out/obj"
cp meshes/*.gsf meshes/*.asc "$out/heightmap"
printf 'ncols 3\nnrows 2\ncellsize 0.1\nNODATA_value -9999\n1 2 3\n4 5 6\n' >"$out/heightmap/small.asc"
printf 'Gwyddion Simple Field 1.0\nXRes = 2\nYRes = 2\nXReal = 1\nYReal = 1\nXYUnits = cm\nZUnits = cm\n\0\0\0\0' |
    head -c 92 >"$out/heightmap/small.gsf"
printf '\0\0\0\77\0\0\200\77\0\0\0\0\0\0\0\100' >>"$out/heightmap/small.gsf"

cat >"$out/obj/octahedron" <<'END'
v 1 0 0
v -1 0 0
v 0 1 0
v 0 -1 0
v 0 0 1
v 0 0 -1
f 1 3 5
f 3 2 5
f 2 4 5
f 4 1 5
f 3 1 6
f 2 3 6
f 4 2 6
f 1 4 6
END

# Meshes of the corpus as .stl and .ply, text and binary.
for mesh in meshes/pyramid.obj meshes/prism.obj "$out/obj/octahedron"; do
    python3 tests/lib/scan_files.py "$mesh" "$out/stl/$(basename "$mesh")" stl-text stl-binary
    python3 tests/lib/scan_files.py "$mesh" "$out/ply/$(basename "$mesh")" ply-ascii ply-little ply-big
done

# Writes small scenes that fly in no time: one of every kind of line, on small grids.
scene() { # NAME RUN ABOVE BELOW FILES: lines for the whole run, then for both boundaries
    {
        printf '1.0\n1\n%s.mco A\n64\n0.1 0.1\n3 4 2\n%b1\n1\n%b1.4 0.5 20 0.8 1\n%b1.5\n' "$1" "$2" "$3" "$4"
        shift 4
        for file in "$@"; do printf '\n%%%%%%%%\n'; cat "$file"; done
    } >"$out/fly/$name"
}
name=plane; scene plane '' '' ''
name=maps; scene maps 'beam disk 0.1 at=0.1,0 angle=30 azimuth=10\nmap 4 3 0.1 0.1 angles volume top=0\nfacets\n' '' ''
name=hill; scene hill 'beam gaussian 0.1\nfacets\n' 'b 3 0.06 0.1 0.02 0.2 0 1\n' 'b 2 -0.1 0.2 0 1\n'
name=pyramid; scene pyramid 'facets\n' 'm "p.obj"\n' '' meshes/pyramid.obj
name=prism; scene prism '' 'm "p.obj" scale=0.5 up=z normals=vertex\n' 'm "w.obj" units=mm\n' meshes/prism.obj meshes/wedge.obj
name=scan; scene scan '' 'm "s.gsf"\n' 'm "s.asc" units=mm\n' "$out/heightmap/small.gsf" "$out/heightmap/small.asc"
name=tile; scene tile 'facets\n' 'm "s.asc" units=mm tile=mirror\n' '' "$out/heightmap/small.asc"
name=balls; scene balls 'facets\n' '' 'i sphere 0 0 0.5 0.3 1.33 1 10 0.9\ni sphere 0.05 0 0.5 0.1 1.5 0 0 0\n'
name=rod; scene rod '' '' 'i cylinder -1 0 0.3 1 0.1 0.4 0.2 1.6 0.1 5 0\n'
name=implant; scene implant '' '' 'i "o.obj" 1.5 0.2 9 0.7 scale=0.2 shift=0,0,-0.5\n' "$out/obj/octahedron"
cp "$out"/fly/* "$out/mci"
for scene in samples/*.mci samples/shapes/*.mci; do # as they are, but on small grids
    small=$out/fly/$(basename "$scene")
    join "$scene" | sed -E 's/^[0-9]+ [0-9]+ [0-9]+/9 8 2/' >"$small"
    [ "$(wc -c <"$small")" -le 8192 ] || rm "$small" # what is longer would be cut within a mesh
done

# Results, maps and checkpoints of the program itself.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for name in plane maps hill; do
    "$program" "$out/fly/$name" --quiet --threads 1 -o "$scratch"
    cp "$scratch/$name.mco" "$out/mco"
done

# This scene has the grid of fuzz_checkpoint.c, which puts zeros for the cells that are cut off here. The run is ended as soon
# as it has left a checkpoint, however slow the machine is.
sed 's/3 4 2/1 1 1/' "$out/fly/plane" >"$scratch/one.mci"
"$program" "$scratch/one.mci" --photons 1e12 --checkpoint 0.1 --quiet --threads 1 -o "$scratch" &
run=$!
until test -e "$scratch/plane.mco.checkpoint" || ! kill -0 $run; do sleep 0.05; done
kill -KILL $run
wait $run 2>/dev/null || true
head -c 2300 "$scratch/plane.mco.checkpoint" >"$out/checkpoint/partial"

# Command lines from the help text, and the examples of the manual.
printf 'run\nscene.mci\n--photons\n1e7\n--seed=2\n-o\nresults\n' >"$out/options/run"
printf 'trace\nscene.mci\n7\n--run\n2\n--engine\nreference\n--boundaries=mesh\n--normals\nfacet\n--rings\narea\n' >"$out/options/trace"
printf -- '--checkpoint\noff\n--patience\n1e3\n--target-error\n.01\n--tolerance\n1e-3\n--threads\n2\n--device\n0,1\n' >"$out/options/machine"

# Tables of sweeps: one of each kind.
printf 'layer1.mua, photons\n1, 100\n2e0, 200 # two\n' >"$out/sweep/two"
printf 'seed,layer2.g,beam.angle,body1.n\r\n9007199254740992,-1,45,1.1\r\n' >"$out/sweep/seed"
printf 'boundary0.scale,boundary0.height,above.n\n0.5,0.1,1.2\n-1,0,nan\n' >"$out/sweep/shape"
printf '"nm, ""a"" #",layer1.mua\n"450, x",1 # one\n500,"2"\n' >"$out/sweep/labels"
