#!/bin/sh
# The picture of check: what must stand in it, that no two texts overlap, and which run of a file it shows.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
command -v gnuplot >/dev/null || { echo "gnuplot is missing"; exit 77; }

draw() { # NAME SCENE TEXT...: draws NAME.svg; every TEXT stands in it
    picture=$work/$1.svg
    expect_code 0 check "$2" -o "$picture"
    tail -1 "$work/out" | grep -qxF -- "  -> $picture" || complain "check does not name its picture: $(cat "$work/out")"
    python3 tests/lib/svg_text.py "$picture" >"$work/texts" 2>&1 || complain "$(cat "$work/texts")"
    name=$1
    shift 2
    for text; do grep -qF -- "$text" "$picture" || complain "$name: no \"$text\""; done
}

draw mixed samples/mixed.mci 'mixed.mco, seen along y' 'above, n = 1<' 'layer 1, n = 1.4<' 'layer 3, n = 1.45<' 'below, n = 1<' \
    'pencil<' 'Boundary 1: heightfield. Boundary 2: pyramid.obj.' 'depth z [cm]' 'x [cm]'
grep -q 'map,' "$work/mixed.svg" && complain "a map where there is none"
draw skinmap samples/skinmap.mci 'map, ' ', angle ' 'Boundary 0: '
draw scan samples/scan.mci 'Boundary 0: skin.gsf. Boundary 1: grooves.asc.'
draw skin7 samples/skin7.mci 'layer 1, n = 1.53' 'layer 2, n = 1.34' 'layer 3, n = 1.4' 'layer 4, n = 1.39' 'layer 7, n = 1.44'

# More layers than lines, beams at the edge, nearly level ones, layers as deep as the sea.
{
    printf '1.0\n1\nmany.mco A\n1000\nbeam gaussian 0.3 at=0.9,0.2 angle=80 azimuth=180\n0.01 0.02\n20 50 10\n60\n1.0\n'
    for i in $(seq 60); do printf '1.%d 1 10 0.8 0.00%d\n' $((30 + i)) $((1 + i % 3)); done
    printf '1.0\n'
} >"$work/many.mci"
draw many "$work/many.mci" 'layer 4, n = 1.34' 'layer 60, n = 1.9' 'at y = 0.2 cm'
# As many as there may be: gnuplot looks through all names that it knows for each.
awk 'BEGIN { print "1.0\n1\nmost.mco A\n1000\n0.01 0.02\n20 50 10\n100000\n1.0"
    for (i = 0; i < 100000; i++) print "1.4 1 10 0.8 1e-5"
    print "1.0" }' >"$work/most.mci"
draw most "$work/most.mci" 'layer 5001, n = 1.4'
for beam in 'disk 0.02 at=-0.9,0 angle=60' 'disk 0.02 at=0.9,0 angle=89 azimuth=180' 'pencil angle=45 azimuth=90' 'pencil at=-5,0' \
    'gaussian 3 angle=60 azimuth=180'; do
    printf '1.0\n1\nsea.mco A\n1000\nbeam %s\nmap 10 10 0.2 0.2\n0.01 0.02\n20 50 10\n2\n1.0\n%s\n%s\n1.33 1 10 0.8 1e9\n1.0\n' \
        "$beam" "m \"$PWD/meshes/spikes.obj\" scale=0.0001 shift=0.9,0,0" '1.4 1 10 0.8 0.0001' >"$work/sea.mci"
    draw sea "$work/sea.mci" 'layer 1, n = 1.4' 'layer 2, n = 1.33' 'map, 10 x 10'
    grep -q 'below, n' "$work/sea.svg" && complain "what lies below the sea is in the picture"
done

draw paint samples/paint.mci 'layer 1, n = 1.5<' '>lambertian, R = 0.8<'
draw foil samples/foil.mci '>metal, 1.37+7.62i<'
# The widest rays of an aperture are those in the medium where it lies, whatever is above.
for n in 1.0 1.4; do
    printf '1.0\n1\nna.mco A\n1000\nbeam pencil light=na:0.7 z=0.05\n0.01 0.02\n20 50 10\n1\n%s\n1.4 1 10 0.8 0.1\n1.0\n' "$n" >"$work/na.mci"
    draw na "$work/na.mci" 'pencil, na:0.7<'
    grep '<path' "$work/na.svg" >"$work/rays$n"
done
test "$(wc -l <"$work/rays1.0")" -gt 5 && cmp -s "$work/rays1.0" "$work/rays1.4" || complain "the medium above decides how wide an aperture inside is"

# So are those of a table at half its maximum, however far its tail reaches.
for tail in '46.66666666666667 0' '40 0.2\n90 0'; do
    printf '0 1\n20 0.8\n%b\n' "$tail" >"$work/lamp.txt"
    printf '1.0\n1\nlamp.mco A\n1000\nbeam pencil light="lamp.txt" z=-0.2\n0.01 0.02\n20 50 10\n1\n1.0\n1.4 1 10 0.8 0.1\n1.0\n' >"$work/lamp.mci"
    draw lamp "$work/lamp.mci" 'light of a table (rays: half its maximum)<'
    grep '<path' "$work/lamp.svg" >"$work/rays"
    test ! -e "$work/rays.before" || cmp -s "$work/rays" "$work/rays.before" || complain "the tail of a table is drawn"
    mv "$work/rays" "$work/rays.before"
done

# Bodies: all of them are in the picture, each with its name, in it or beside it.
printf '1.0\n1\nbodies.mco A\n1000\n0.02 0.02\n20 20 5\n1\n1.0\n1.4 1 50 0.8 1e9\ni sphere 0.1 0 0.3 0.2 1.5 2 10 0.5\n' >"$work/bodies.mci"
printf 'i cylinder -0.4 -1 2.5 -0.4 1 2.5 0.02 1.6 2 10 0.5\ni sphere 0.1 0 0.3 0.1 1.3 2 10 0.5\n1.0\n' >>"$work/bodies.mci"
draw bodies "$work/bodies.mci" '>body 1, n = 1.5<' '>body 2, n = 1.6<' '>body 3, n = 1.3<' ' 2.5<'
draw glow samples/glow.mci '>body 1, n = 1.37<'

# One run of a file with several.
draw first samples/two_runs.mci "$(awk 'NR > 3 && / A/ { print $1; exit }' samples/two_runs.mci), seen along y"
expect_code 0 check samples/two_runs.mci --run 2 -o "$work/second.svg" --quiet
cmp -s "$work/first.svg" "$work/second.svg" && complain "--run 2 draws the first run"
expect_code 2 check samples/two_runs.mci --run 3 -o "$work/third.svg"
grep -qxF "clustermcml: --run 3 (expected 1 to 2, the runs of samples/two_runs.mci)" "$work/err" || complain "$(cat "$work/err")"
test ! -e "$work/third.svg" || complain "a picture of no run"
expect_error 2 "--output $work/a.txt (expected a name that ends in .svg, .png, .pdf or .eps)" check samples/mixed.mci -o "$work/a.txt"
expect_code 0 check samples/mixed.mci -o "$work/mixed.png" --quiet
head -c 8 "$work/mixed.png" | grep -q PNG || complain "the PNG is none"
expect_code 0 check samples/mixed.mci -o "$work/json.svg" --json
test "$(wc -l <"$work/out")" -eq 1 && test -s "$work/json.svg" || complain "--json with a picture: $(cat "$work/out")"
finish
