#!/bin/sh
# Tests heightmaps repeated over the whole plane: the words of check, mesh, plot and crosscheck, and refusals. A level one is
# the plane to the byte, Embree and the walk over cells agree, and facets are those of one period.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
scene() { # NAME LINE [BEFORE]
    printf '1.0\n1\n%s.mco A\n20000\n0.01 0.01\n20 20 5\nbeam disk 0.1 angle=30\n%s\n1\n1\n%s\n1.4 1 50 0.8 0.3\n1\n' \
        "$1" "${3:-# no map}" "$2" >"$work/$1.mci"
}
plain() { sed -e '/^# User time/d' -e '/^# boundary/d' -e '/output file name/d' "$1"; }

expect_code 0 check samples/furrows.mci
grep -q 'heightmap repeated every 0.16 x 0.16 cm, a sheet' "$work/out" || complain "check does not name the period"
grep -q 'tile of boundary 0: 64 x 64 heights, 0.0025 x 0.0025 cm apart, repeated every 0.16 x 0.16 cm over the whole plane' \
    "$work/out" || complain "check does not describe the tile"
grep -q 'the beam does not repeat' "$work/out" || complain "check does not say that the beam does not repeat"
grep -q 'skirt' "$work/out" && complain "check names a skirt"

# Heights every 0.05 mm go into the period of a mirrored map: 2 (60 - 1) x 2 (40 - 1) cells of 0.05 mm.
scene mirror "m \"$PWD/meshes/grooves.asc\" units=mm tile=mirror"
expect_code 0 check "$work/mirror.mci"
grep -q '60 x 40 heights, 0.005 x 0.005 cm apart, mirrored and repeated every 0.59 x 0.39 cm' "$work/out" ||
    complain "a mirrored tile: $(grep tile "$work/out")"

# A period of two by two samples has one high sample. The mean height of the triangles is a third or a sixth of it, depending
# on the ends of the diagonals: here diagonals meet in it. A layer as thick as the mean is named, and its flat scene has the
# volume.
printf 'ncols 2 nrows 2 cellsize 0.1\n0 0\n0.06 0\n' >"$work/peak.asc"
scene peak 'm "peak.asc" units=cm tile'
expect_code 0 check "$work/peak.mci"
grep -q '^  boundary 0: mean height 0.02 cm over a period$' "$work/out" &&
    grep -q '^  note: layer 1 is 0.32 cm thick in the mean, 6.67 % more than its d; the flat scene of that volume: --ignore-heightfields --set layer1.d=0.32$' \
        "$work/out" || complain "the mean of a tile: $(grep mean "$work/out")"
expect_code 0 check "$work/peak.mci" --json
python3 -c 'import json, sys; told = json.load(sys.stdin); print(told["layers"][0]["mean_d"], told["boundaries"][0]["mean_height"])' <"$work/out" >"$work/means"
awk '{ exit !(($1 - 0.32) ^ 2 < 1e-24 && ($2 - 0.02) ^ 2 < 1e-24) }' "$work/means" || complain "means in JSON: $(cat "$work/means")"
expect_code 0 check "$work/peak.mci" --ignore-heightfields --set layer1.d=0.32
grep -q 'in the mean' "$work/out" && complain "planes differ from their mean: $(cat "$work/out")"
scene peak 'm "peak.asc" units=cm tile shift=0,0,-0.02'
expect_code 0 check "$work/peak.mci"
grep -q '^  note: layer' "$work/out" && complain "a tile about its mean: $(grep mean "$work/out")"
# A cone of 0.06 cm over a radius of 0.2 cm fills a third of its cylinder. A roof is a half prism, on a plane 0.01 cm up.
scene peak 'b 2 0.06 0.2 0 1'
expect_code 0 check "$work/peak.mci"
grep -q '^  boundary 0: mean height 0.02 cm over its 0.1257 cm2$' "$work/out" || complain "the mean of a cone: $(cat "$work/out")"
printf 'v %s\n' '0.2 0.1 0' '-0.2 0.1 0' '-0.2 -0.1 0' '0.2 -0.1 0' '0 0.1 0.03' '0 -0.1 0.03' >"$work/tent.obj"
printf 'f %s\n' '1 5 6 4' '2 3 6 5' >>"$work/tent.obj"
printf 'v %s\n' '-0.2 0.2 0' '0.2 0.2 0' '-0.2 -0.2 0' '0.2 -0.2 0' >>"$work/tent.obj"
printf 'f %s\n' '2 7 5' '7 8 5' '8 1 5' '3 9 6' '9 10 6' '10 4 6' >>"$work/tent.obj"
scene peak 'm "tent.obj" shift=0,0,0.01' # the prism, and slopes to both ends: pyramids of a third
expect_code 0 check "$work/peak.mci"
grep -q '^  boundary 0: mean height 0.0225 cm over its 0.16 cm2$' "$work/out" || complain "the mean of a mesh: $(grep -e mean -e error "$work/out")"

# A level tile becomes a plane.
printf 'ncols 3 nrows 2 cellsize 1\n0 0 0\n0 0 0\n' >"$work/level.asc"
scene level 'm "level.asc" units=cm tile'
scene plane ''
expect_code 0 "$work/level.mci" --quiet -o "$work"
expect_code 0 "$work/plane.mci" --quiet -o "$work"
plain "$work/level.mco" | grep -v '^# more of this run' >"$work/a"
plain "$work/plane.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "a level tile is not the plane: $(diff "$work/a" "$work/b" | head -5)"

# Slopes above 5000 are refused, in a tile and in a heightmap with a skirt: light that steeper grooves turn back would count
# as trapped.
printf 'ncols 3 nrows 2 cellsize 1e-4\n0 0.3 0.79\n0 0.3 0.79\n' >"$work/steep.asc"
scene steep 'm "steep.asc" units=cm tile=mirror'
expect_code 0 check "$work/steep.mci"
printf 'ncols 3 nrows 2 cellsize 1e-4\n0 0.3 0.81\n0 0.3 0.81\n' >"$work/steep.asc"
where="$work/steep.mci:11: boundary 0, $work/steep.asc"
why="(expected at most 5000: light that a steeper groove turns back would count as trapped)"
expect_error 2 "$where: slope 5100 at x = 0, y = -5e-05 cm $why" check "$work/steep.mci"
scene steep 'm "steep.asc" units=cm'
expect_error 2 "$where: slope 5100 at x = 0.0001, y = 5e-05 cm $why" check "$work/steep.mci"

# Embree's triangles instead of the walk over cells give the same light within errors.
expect_code 0 "$work/mirror.mci" --quiet --photons 1e5 --seed 4 -o "$work"
mv "$work/mirror.mco" "$work/walked.mco"
expect_code 0 "$work/mirror.mci" --quiet --photons 1e5 --seed 5 --mesh-search embree -o "$work"
expect_code 0 compare "$work/walked.mco" "$work/mirror.mco" --quiet

# mesh writes one period as OBJ; its facets are those that are scored in any copy.
expect_code 0 mesh samples/furrows.mci -o "$work"
grep -q 'boundary 0: 8192 triangles' "$work/out" || complain "mesh writes another sheet: $(cat "$work/out")"
expect_code 0 samples/furrows.mci --quiet --photons 5e3 -o "$work"
scene facets "m \"$PWD/meshes/furrows.gsf\" tile" facets
expect_code 0 "$work/facets.mci" --quiet --photons 5e3 -o "$work"
grep -q 'NumberOfPolys="8192"' "$work/facets.boundary0.vtp" || complain "facets are not those of one period"

expect_code 0 trace samples/furrows.mci 7
grep -q 'boundary\|reflect\|transmit' "$work/out" || complain "trace shows no boundary event"
expect_code 0 view samples/furrows.mci -o "$work/section.svg"
check_texts
expect_code 2 "$work/mirror.mci" --engine opencl -o "$work"
grep -q 'boundary 0 is a mesh' "$work/err" || complain "opencl: $(cat "$work/err")"
expect_code 2 "$work/mirror.mci" --boundaries cone -o "$work"
grep -q ':11: --boundaries cone cannot represent a mesh' "$work/err" || complain "cones: $(cat "$work/err")"

# The step at the seam may be the largest by chance: check and run note it. A step of more than three times the others is
# refused, but not with as-is.
seam() { # HEIGHT OPTION: of the last column, behind steps of 1
    printf 'ncols 4 nrows 2 cellsize 1\n0 1 2 %s\n0 1 2 2\n' "$1" >"$work/seam.asc"
    scene seam "m \"seam.asc\" units=mm $2"
}
seam 3 tile
for command in "check $work/seam.mci" "$work/seam.mci --photons 10 --quiet -o $work"; do
    expect_code 0 $command
    test "$(cat "$work/err")" = "clustermcml: note: $work/seam.mci:11: boundary 0: tile: a step of 0.3 cm across the seam along x, 0.1 cm inside (tile=as-is if that is meant, else tile=mirror)" ||
        complain "$command: $(cat "$work/err")"
done
printf 'ncols 5 nrows 2 cellsize 1\n0 1 2 3 4\n0 1 2 2 1\n' >"$work/seam.asc"
expect_error 2 "$work/seam.mci:11: boundary 0: tile = a step of 0.4 cm across the seam along x, 0.1 cm inside (expected at most three \
times the largest step inside; tile=mirror repeats any map, tile=as-is this one)" check "$work/seam.mci"
scene seam 'm "seam.asc" units=mm tile=as-is'
expect_code 0 check "$work/seam.mci"
test ! -s "$work/err" || complain "tile=as-is: $(cat "$work/err")"
grep -q 'largest step across the seam 0.4 cm along x' "$work/out" || complain "tile=as-is: $(cat "$work/out")"

# `beam rectangle tile` is as large as one period at the beam's angle, which may be set. A beam that does not light whole
# periods is noted.
lit() { # BEAM LINE [LAYER AND LINE]: a scene with that light and that boundary
    printf '1.0\n1\nlit.mco A\n1000\n0.01 0.01\n20 20 5\nbeam %s\n%s\n1\n%s\n1.4 1 50 0.8 0.3\n1\n' "$1" "$(test $# -eq 2 && echo 1 || echo 2)" \
        "$2${3:+
$3}" >"$work/lit.mci"
}
tile='m "lit.asc" units=cm tile'
lights() { # SIZE BEAM ARGUMENTS...: what check says of it, without a note
    size=$1
    lit "$2" "$tile"
    shift 2
    expect_code 0 check "$work/lit.mci" "$@"
    grep -q "^  beam rectangle of $size cm at " "$work/out" && test ! -s "$work/err" || complain "$size: $(grep beam "$work/out") $(cat "$work/err")"
}
printf 'ncols 4 nrows 2 cellsize 0.1\n0 0.05 0.1 0.05\n0 0.05 0.1 0.05\n' >"$work/lit.asc"
lights '0.4 x 0.2' 'rectangle tile'
lights '0.2 x 0.2' 'rectangle tile angle=60 azimuth=180'
lights '0.1 x 0.4' 'rectangle tile angle=60 azimuth=-90 at=1,2'
lights '0.4 x 0.4' 'rectangle tile' --set beam.angle=60 --set boundary0.scale=2
lights '0.2 x 0.2' 'rectangle tile angle=60' --ignore-heightfields
lights '0.4 x 0.2' 'rectangle tile light=lambertian'
lights '0.8 x 0.2' 'rectangle 0.8 0.2'
lit 'rectangle 0.4 0.2 angle=45' "$tile"
expect_code 0 check "$work/lit.mci"
test "$(cat "$work/err")" = "clustermcml: note: $work/lit.mci:7: beam 1 lights 1.414 x 1 periods of the tile of boundary 0, not evenly (for whole \
periods at any angle: beam rectangle tile)" || complain "1.4 periods: $(cat "$work/err")"
lit 'rectangle 0.4 0.2 azimuth=30' "$tile"
expect_code 0 check "$work/lit.mci"
grep -q 'a rectangle at azimuth 30 degrees, lights the tile of boundary 0 unevenly' "$work/err" || complain "aslant: $(cat "$work/err")"

refused() { # VALUE (EXPECTED), then as lit
    message=$1
    shift
    lit "$@"
    expect_error 2 "$work/lit.mci:7: beam: $message" check "$work/lit.mci"
}
refused 'azimuth = 30 (expected a multiple of 90 degrees beside rectangle tile, whose sides lie along x and y)' 'rectangle tile azimuth=30' "$tile"
refused 'angle = 45 (expected 0 beside rectangle tile with z= or light=: other light is not even over a period)' \
    'rectangle tile angle=45 light=na:0.1' "$tile"
refused 'rectangle = tile (expected a boundary with `tile` in its line, or W H)' 'rectangle tile' '# a plane'
refused 'rectangle = tile, with 0.4 x 0.2 cm at boundary 0, 0.2 x 0.1 cm at boundary 1 (expected tiles of one period, or W H)' \
    'rectangle tile' "$tile" '1.4 1 50 0.8 0.3
m "lit.asc" units=cm tile scale=0.5'
lit 'rectangle tile' "$tile"
expect_code 2 check "$work/lit.mci" --set beam.w=0.5

exit "$failures"
