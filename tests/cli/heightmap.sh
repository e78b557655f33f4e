#!/bin/sh
# Tests scans (heightmaps) as boundaries: the words of check, the flight, and that the mesh written by `mesh` is the one
# flown.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
plain() { sed -e '/^# User time/d' -e '/^# boundary/d' -e '/^# engine/d' "$1"; }

expect_code 0 check samples/scan.mci
grep -q 'heightmap of 96 x 64 heights, 0.0025 x 0.0025 cm apart: rms height [0-9.e-]* cm, rms slope [0-9.]*, peak to valley ' \
    "$work/out" || complain "check does not measure the scan"
grep -q 'simplified to [0-9]* of 11970 triangles, height error <= [0-9.e-]* cm (tolerance 2.06e-06 cm), rms slope error' \
    "$work/out" || complain "check does not state the bound: $(grep simplified "$work/out")"
grep -q "skirt of 0.0025 x 0.0025 cm around it to the rim's mean height" "$work/out" || complain "check does not name the skirt"

# The cpu engine walks over the grid of a scan, merged or not, unless an option forbids it. Results do not depend on it.
[ "$(grep -c 'and a skirt, a sheet)' "$work/out")" = 2 ] || complain "check does not name the sheets"
expect_code 0 check samples/scan.mci --mesh-search embree
grep -q 'a sheet' "$work/out" && complain "--mesh-search embree walks a sheet"
expect_code 0 samples/scan.mci --photons 1e5 --seed 4 --quiet -o "$work"
mv "$work/scan.mco" "$work/walked.mco"
expect_code 0 samples/scan.mci --photons 1e5 --seed 5 --quiet --mesh-search embree -o "$work"
expect_code 0 compare "$work/walked.mco" "$work/scan.mco" --quiet

# A coarser tolerance takes fewer triangles, and the stated bound holds.
expect_code 0 check samples/scan.mci --tolerance 0.05
sed -n 's/.*simplified to \([0-9]*\) of 11970.*error <= \([^ ]*\) cm (tolerance \([^ ]*\) cm.*/\1 \2 \3/p' "$work/out" |
    awk '{ exit !($1 < 6000 && $2 <= $3 && $2 > 0) }' || complain "tolerance 0.05: $(grep simplified "$work/out")"

# The mesh written as OBJ and read again gives the same bits.
expect_code 0 mesh samples/scan.mci -o "$work"
expect_code 0 samples/scan.mci --photons 2e4 --quiet -o "$work"
mv "$work/scan.mco" "$work/map.mco"
sed -e 's|"../meshes/skin.gsf"|"scan.mco.boundary0.obj"|' -e 's|"../meshes/grooves.asc" units=mm|"scan.mco.boundary1.obj"|' \
    samples/scan.mci >"$work/obj.mci"
expect_code 0 "$work/obj.mci" --photons 2e4 --quiet -o "$work"
plain "$work/map.mco" >"$work/a"
plain "$work/scan.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "the mesh that was written is not the one that flew: $(diff "$work/a" "$work/b" | head -5)"

# Results of the default tolerance cannot be told from those of the exact mesh.
expect_code 0 samples/scan.mci --photons 2e5 --seed 2 --quiet -o "$work"
mv "$work/scan.mco" "$work/default.mco"
expect_code 0 samples/scan.mci --photons 2e5 --seed 3 --quiet --tolerance 1e-9 -o "$work"
expect_code 0 compare "$work/default.mco" "$work/scan.mco" --quiet

# A level scan becomes a plane.
{
    printf 'ncols 3\nnrows 4\ncellsize 1\n'
    printf '0 0 0\n0 0 0\n0 0 0\n0 0 0\n'
} >"$work/flat.asc"
sed -e 's|"../meshes/skin.gsf"|"flat.asc" units=mm|' -e '/grooves/d' samples/scan.mci >"$work/flat.mci"
expect_code 0 check "$work/flat.mci"
grep -q 'boundary 0: plane at z = 0 cm (flat mesh)' "$work/out" || complain "a level scan is no plane"

# Units: an ESRI grid has none, a .gsf field has its own.
sed 's|"flat.asc" units=mm|"flat.asc"|' "$work/flat.mci" >"$work/none.mci"
expect_error 2 "$work/none.mci:13: boundary 0: $work/flat.asc: an ESRI grid has no units (expected units=cm, mm, um or m on the m line)" check "$work/none.mci"
cp meshes/skin.gsf "$work"
sed 's|"flat.asc" units=mm|"skin.gsf" units=mm|' "$work/flat.mci" >"$work/two.mci"
expect_error 2 "$work/two.mci:13: boundary 0: $work/skin.gsf: the file has its own units (expected no units= beside it)" check "$work/two.mci"
sed -i '6s/0 0 0/0 -9999 0/' "$work/flat.asc"
expect_error 2 "$work/flat.mci:13: boundary 0: $work/flat.asc: 1 of 12 heights are missing, the first in row 3, column 2 (expected a height in every cell: fill the holes first)" \
    "$work/flat.mci" -o "$work"
finish
