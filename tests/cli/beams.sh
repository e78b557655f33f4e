#!/bin/sh
# Tests lines `beam` of a scene: their description in results, check, trace and --json; radial=beam; photons of second and
# later beams. stat.sources judges the light, cli.bad_input the refusals.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

scene() { # NAME, then lines of beams
    name=$1
    shift
    { printf '1.0\n1\n%s.mco A\n1000\n' "$name"
        printf '%s\n' "$@"
        printf '0.02 0.02\n20 20 5\n2\n1.0\n1.4 1 50 0.8 0.1\n1.5 2 10 0.5 0.1\n1.0\n'; } >"$work/$name.mci"
}
body() { sed -e '/^# User time/d' -e '/^# beam/d' -e '/^[^ ]* \tA\t/d' "$work/$1.mco"; }

# With radial=beam on planes, all profiles equal those of a beam in the middle, bit for bit. Without it they differ.
for line in "disk 0.05 angle=30 azimuth=40" "ring 0.02 0.05 light=na:0.4" "pencil z=0.05 light=isotropic"; do
    scene middle "beam $line"
    scene aside "beam $line at=0.25,-0.5 radial=beam"
    scene axis "beam $line at=0.25,-0.5"
    for name in middle aside axis; do expect_code 0 "$work/$name.mci" --quiet -o "$work"; body $name >"$work/$name"; done
    cmp -s "$work/middle" "$work/aside" || complain "radial=beam, $line: $(diff "$work/middle" "$work/aside" | head -4)"
    ! cmp -s "$work/middle" "$work/axis" || complain "r counts from the z axis, $line"
done
grep -qx '# beam pencil at (0.25 -0.5 0.05) cm, angle 0, azimuth 0 degrees, light isotropic, r about its place' "$work/aside.mco" ||
    complain "the .mco of radial=beam: $(grep beam "$work/aside.mco")"

# Light that leaves at once takes no step, so no time per step is printed.
scene away "beam pencil z=-0.1 angle=180"
expect_code 0 "$work/away.mci" --engine reference -o "$work"
grep -Eq '^  .* photons/s, 0 steps on 1 thread$' "$work/out" || complain "no steps: $(cat "$work/out")"

# With several beams, the results name all of them, and the JSON record stays one object on one line, with their settings.
scene three "beam pencil" "beam disk 0.1 at=0.5,0 z=0.05 angle=180 share=3" "#@ beam ring 0.1 0.2 light=na:0.5 share=0.5"
expect_code 0 "$work/three.mci" --json --set beam2.angle=170 --set beam3.na=0.6 -o "$work"
test "$(wc -l <"$work/out")" -eq 1 && grep -q '"set":{"beam2.angle":170.0,"beam3.na":0.5999*[0-9]*}' "$work/out" && python3 -m json.tool "$work/out" >"$work/json" ||
    complain "JSON: $(cat "$work/out")"
cat >"$work/expected" <<'END'
# beam pencil at (0 0) cm, angle 0, azimuth 0 degrees, share 1
# beam disk of radius 0.1 cm at (0.5 0 0.05) cm, angle 170, azimuth 0 degrees, share 3
# beam ring of radii 0.1 and 0.2 cm at (0 0) cm, angle 0, azimuth 0 degrees, light na:0.6, share 0.5
END
grep '^# beam' "$work/three.mco" | cmp -s - "$work/expected" || complain "the .mco: $(grep '^# beam' "$work/three.mco")"
expect_code 0 check "$work/three.mci" --json
python3 -m json.tool "$work/out" >"$work/json" || complain "check --json: $(cat "$work/out")"

# trace: photon indices of beam k begin at (k - 1) 2^48. Of 1000 photons the three beams have 222, 667 and 111.
launch() { # PHOTON: place and direction of its launch
    expect_code 0 trace "$work/three.mci" "$1"
    awk '$2 == "launch" { print $4, $5, $6, $9 }' "$work/out"
}
test "$(launch 3)" = "0 0 0 1.000000000" || complain "photon 3: $(cat "$work/out")"
test ! -s "$work/err" || complain "photon 3: $(cat "$work/err")"
launch 281474976710656 | awk '{ exit !(($1 - 0.5) ^ 2 + $2 ^ 2 <= 0.01 && ($3 - 0.05) ^ 2 < 1e-12 && $4 == -1) }' ||
    complain "the first photon of beam 2: $(cat "$work/out")"
grep -q '^# beam disk of radius 0.1 cm' "$work/out" && test ! -s "$work/err" || complain "beam 2: $(cat "$work/out" "$work/err")"
launch 562949953421315 | awk '{ r = $1 ^ 2 + $2 ^ 2; exit !(r >= 0.00999 && r <= 0.04001 && $4 > 0.86) }' ||
    complain "a photon of beam 3: $(cat "$work/out")"
for photon in 900 281474976711400 562949953421500; do
    expect_code 0 trace "$work/three.mci" $photon
    grep -qx "clustermcml: note: photon $photon is not among those of three.mco (1000 of 3 beams, those of beam k from (k - 1) 2^48 on, unless --photons says more)" "$work/err" ||
        complain "photon $photon: $(cat "$work/err")"
done
expect_code 0 trace "$work/three.mci" 900 --set photons=1e5
test ! -s "$work/err" || complain "photon 900 of 1e5: $(cat "$work/err")"
expect_code 2 trace "$work/three.mci" 844424930131968
grep -qx 'clustermcml: trace: photon 844424930131968 (expected an index of one of 3 beams: that of beam k begins at (k - 1) 2^48)' "$work/err" ||
    complain "a fourth beam: $(cat "$work/err")"

# check names the medium in which light starts, and notes light that starts beyond all layers and never returns. A start on a
# surface, but for rounding, is refused: beside a plane, on a rim, on a corner and a face of a box.
started() { # LINE MEDIUM NOTE: what check says of a beam
    scene start "$1"
    expect_code 0 check "$work/start.mci"
    grep -q "^  $(echo "$1" | sed 's/^beam \([a-z]*\).*/beam \1/').*, medium: $2\$" "$work/out" || complain "$1: $(cat "$work/out")"
    test "$(cat "$work/err")" = "${3:+clustermcml: note: $work/start.mci:5: $3}" || complain "$1: $(cat "$work/err")"
}
started "beam pencil z=0.15 light=isotropic" "layer 2" ""
started "beam pencil z=0.25 light=na:0.5 angle=60" below "beam 1 starts below all layers and shines down: none of its light meets them"
started "beam pencil z=0.25 light=na:0.6 angle=60" below ""
started "beam disk 0.1 z=-0.2 light=lambertian angle=180" above "beam 1 starts above all layers and shines up: none of its light meets them"
started "beam disk 0.1 z=-0.2 light=lambertian" above ""
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n' >"$work/box.obj"
for place in "0.05,0 z=0.12" "-0.05,0 z=0.13" "0.3,0.1 z=0.15" "0.30000000000000004,0.05 z=0.12" "0.25,0.05 z=0.12000000000000001" "0,0 z=1e-15"; do
    scene edge "beam pencil at=$place light=isotropic"
    sed -i '$d' "$work/edge.mci"
    printf 'i cylinder 0 0 0.12 0 0 0.17 0.05 1.3 1 9 0.8\ni "box.obj" 1.3 1 9 0.8 scale=0.1 shift=0.2,0,-0.22\n1.0\n' >>"$work/edge.mci"
    sed -i 's/^1.5 2 10 0.5 0.1/1.5 2 10 0.5 0.2/' "$work/edge.mci"
    expect_code 2 check "$work/edge.mci"
    grep -q "^clustermcml: $work/edge.mci:5: beam: at z = .* (expected a place inside a medium, more than [0-9.e-]* cm from its surface; it lies on one)" "$work/err" ||
        complain "$place: $(cat "$work/err")"
done

# A clear layer traps light that both its planes reflect totally. A rough plane lets it out, and a backing absorbs a part.
printf '1.0\n1\nclear.mco A\n1000\nbeam pencil z=0.05 light=isotropic\n1 1\n1 1 1\n1\n1.0\n1.4 0 0 0 0.1\n1.0\n' >"$work/clear.mci"
expect_code 0 check "$work/clear.mci"
grep -qF "$work/clear.mci:5: beam 1 starts in layer 1, which is clear" "$work/err" || complain "no note of a trap: $(cat "$work/err")"
sed 's/^1.4 .*/&\nrough ggx 0.1/' "$work/clear.mci" >"$work/rough_clear.mci"
expect_code 0 "$work/rough_clear.mci" --json -o "$work"
test ! -s "$work/err" && grep -q '"trapped":0,' "$work/out" || complain "a trap over a rough boundary: $(cat "$work/err" "$work/out")"
rm "$work/clear.mco"
sed -i 's/^1.4 .*/&\nbacking 0.5/' "$work/clear.mci"
expect_code 0 "$work/clear.mci" --json -o "$work"
test ! -s "$work/err" && grep -q '"trapped":0,' "$work/out" || complain "a trap over a backing: $(cat "$work/err" "$work/out")"

# A share too small for one photon is noted. For `exact`, a lamp above flat layers is light from above, too.
printf '1.0\n1\nlamp.mco A\n20000\nbeam disk 0.1 share=1e-5 z=-0.5 light=na:0.2 angle=30\nbeam disk 0.3 z=-1 light=lambertian\n1 1\n1 1 1\n1\n1.0\n1.4 1 10 0.5 0.1\n1.0\n' >"$work/lamp.mci"
expect_code 0 exact "$work/lamp.mci"
cp "$work/out" "$work/with"
sed 's/ z=[^ ]*//' "$work/lamp.mci" >"$work/above.mci"
expect_code 0 exact "$work/above.mci"
sed -i "s/above/lamp/" "$work/out"
cmp -s "$work/out" "$work/with" || complain "exact of a lamp: $(cat "$work/out" "$work/with")"
expect_code 0 "$work/lamp.mci" -o "$work"
grep -q "note: beam 1 has none of the 20000 photons: its share is too small" "$work/err" || complain "no note of a dark beam: $(cat "$work/err")"
grep -q '^  Rd .* exact 0' "$work/out" || complain "a lamp has no exact: $(cat "$work/out")"
for beam in "beam pencil z=-0.5 angle=90" "beam disk 0.1 z=-0.5 light=na:0.6 angle=60" "beam pencil z=0.05" "beam pencil z=-1 light=isotropic"; do
    sed -e "s/^beam disk 0.3.*/$beam/" "$work/lamp.mci" >"$work/aside.mci"
    expect_code 2 exact "$work/aside.mci"
    grep -q "aside.mci:6: beam: z = .* (expected light that comes down from above all layers" "$work/err" || complain "$beam: $(cat "$work/err")"
done
# A table of light has a limit of rows, because adding-doubling would take minutes for more.
seq 0 0.005 50 | awk '{ print $1, 1 }' >"$work/many.txt"
sed -e 6d -e 's/^beam disk.*/beam disk 0.1 light="many.txt"/' "$work/lamp.mci" >"$work/many.mci"
expect_code 2 check "$work/many.mci"
grep -q "many.txt:10001: row = 10001 (expected at most 10000 rows)" "$work/err" || complain "a long table: $(cat "$work/err")"
sed -i '$d' "$work/many.txt"
expect_code 0 check "$work/many.mci"
finish
