#!/bin/sh
# Tests the picture of a scene: it has the expected texts, no two texts overlap, and it shows the right run of a file.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
warm_python

draw() { # NAME SCENE TEXT...: draws NAME.svg; every TEXT stands in it
    picture=$work/$1.svg
    expect_code 0 view "$2" -o "$picture"
    grep -qxF -- "$picture" "$work/out" || complain "view does not name its picture: $(cat "$work/out")"
    "$CLUSTERMCML_PYTHON" tests/lib/svg_text.py "$picture" >"$work/texts" 2>&1 || complain "$(cat "$work/texts")"
    name=$1
    shift 2
    for text; do grep -qF -- "$text" "$picture" || complain "$name: no \"$text\""; done
}

draw mixed samples/mixed.mci 'mixed.mco, seen along y' 'above, n = 1<' 'layer 1, n = 1.4<' 'layer 3, n = 1.45<' 'below, n = 1<' \
    'pencil<' 'Boundary 1: heightfield. Boundary 2: pyramid.obj.' 'depth z [cm]' 'x [cm]'
grep -q 'map,' "$work/mixed.svg" && complain "a map where there is none"
draw skinmap samples/skinmap.mci 'map, ' ', angle ' 'Boundary 0: '
draw scan samples/scan.mci 'Boundary 0: skin.gsf. Boundary 1: grooves.asc.'
test -z "${ALL_CASES:-}" || draw skin7 samples/skin7.mci 'layer 1, n = 1.53' 'layer 2, n = 1.34' 'layer 3, n = 1.4' 'layer 4, n = 1.39' 'layer 7, n = 1.44'

# More layers than lines of text, beams at the edge and nearly level ones, layers as deep as the sea.
{
    printf '1.0\n1\nmany.mco A\n1000\nbeam gaussian 0.3 at=0.9,0.2 angle=80 azimuth=180\n0.01 0.02\n20 50 10\n60\n1.0\n'
    for i in $(seq 60); do printf '1.%d 1 10 0.8 0.00%d\n' $((30 + i)) $((1 + i % 3)); done
    printf '1.0\n'
} >"$work/many.mci"
draw many "$work/many.mci" 'layer 4, n = 1.34' 'layer 60, n = 1.9' 'at y = 0.2 cm'
# The largest number of layers, which takes ten seconds.
awk 'BEGIN { print "1.0\n1\nmost.mco A\n1000\n0.01 0.02\n20 50 10\n100000\n1.0"
    for (i = 0; i < 100000; i++) print "1.4 1 10 0.8 1e-5"
    print "1.0" }' >"$work/most.mci"
test -z "${ALL_CASES:-}" || draw most "$work/most.mci" 'layer 5001, n = 1.4'
for beam in 'disk 0.02 at=-0.9,0 angle=60' 'disk 0.02 at=0.9,0 angle=89 azimuth=180' 'pencil angle=45 azimuth=90' 'pencil at=-5,0' \
    'gaussian 3 angle=60 azimuth=180'; do
    case ${ALL_CASES:+all}:$beam in :*azimuth=90 | :*at=-0.9* | :*at=-5,0) continue ;; esac
    printf '1.0\n1\nsea.mco A\n1000\nbeam %s\nmap 10 10 0.2 0.2\n0.01 0.02\n20 50 10\n2\n1.0\n%s\n%s\n1.33 1 10 0.8 1e9\n1.0\n' \
        "$beam" "m \"$PWD/meshes/spikes.obj\" scale=0.0001 shift=0.9,0,0" '1.4 1 10 0.8 0.0001' >"$work/sea.mci"
    draw sea "$work/sea.mci" 'layer 1, n = 1.4' 'layer 2, n = 1.33' 'map, 10 x 10'
    grep -q 'below, n' "$work/sea.svg" && complain "what lies below the sea is in the picture"
done

draw paint samples/paint.mci 'layer 1, n = 1.5<' '>lambertian, R = 0.8<'
draw foil samples/foil.mci '>metal, 1.37+7.62i<'
# The widest rays of an aperture are those in the medium of the source, whatever lies above; those of a table are at half its
# maximum.
told() { "$program" check "$1" --json | sed 's/.*"spread":\([^,}]*\).*/\1/'; }
for n in 1.0 1.4; do
    printf '1.0\n1\nna.mco A\n1000\nbeam pencil light=na:0.7 z=0.05\n0.01 0.02\n20 50 10\n1\n%s\n1.4 1 10 0.8 0.1\n1.0\n' "$n" >"$work/na.mci"
    test "$(told "$work/na.mci")" = 30.0 || complain "na:0.7 in n = 1.4 below $n: $(told "$work/na.mci") degrees"
done
draw na "$work/na.mci" 'pencil, na:0.7<'
for tail in '46.66666666666667 0' '40 0.2\n90 0'; do
    printf '0 1\n20 0.8\n%b\n' "$tail" >"$work/lamp.txt"
    printf '1.0\n1\nlamp.mco A\n1000\nbeam pencil light="lamp.txt" z=-0.2\n0.01 0.02\n20 50 10\n1\n1.0\n1.4 1 10 0.8 0.1\n1.0\n' >"$work/lamp.mci"
    told "$work/lamp.mci" | awk '{ exit !($1 > 29.99 && $1 < 30.01) }' || complain "a table with $tail: $(told "$work/lamp.mci") degrees"
done
draw lamp "$work/lamp.mci" 'light of a table (rays: half its maximum)<'
draw camera samples/camera.mci '>detector cam<'
test -z "${ALL_CASES:-}" || draw fibres samples/fibres.mci '>detector near<' '>detector far<'

# Detectors are drawn to scale, and their names lie in the frame, before the texts beside it.
printf '1.0\n1\nd.mco A\n1000\n0.01 0.01\n50 60 10\ndetector disk 0.1 at=0.5,0 name=near\ndetector rectangle 0.2 0.1 at=0.7,0 name=the_rightmost_one\n1\n1.0\n1.4 1 10 0.8 0.1\n1.0\n' >"$work/d.mci"
draw d "$work/d.mci" '>detector near<' 'times as high as x is wide'
"$CLUSTERMCML_PYTHON" - "$work/d.svg" <<'END' || complain "detectors"
import sys
import xml.etree.ElementTree as tree
sys.path[:0] = ["src/python", "tests/lib"]
import svg_text
from clustermcml.view import _reach
boxes = dict(svg_text.texts_of(tree.parse(sys.argv[1]).getroot()))
assert boxes["detector the_rightmost_one"][2] < boxes["layer 1, n = 1.4"][0] - 10, boxes
for shape, size, nx, half in (("disk", (0, 0.03), 1, 0.03), ("ring", (0.1, 0.2), 1, 0.2), ("rectangle", (0.2, 0.1), 1, 0.1), ("map", (0.1, 0.1), 8, 0.4)):
    assert abs(_reach({"shape": shape, "size": size, "nx": nx, "ny": 1}) - half) < 1e-12, shape
END

# All bodies are in the picture, each with its name inside or beside it.
printf '1.0\n1\nbodies.mco A\n1000\n0.02 0.02\n20 20 5\n1\n1.0\n1.4 1 50 0.8 1e9\ni sphere 0.1 0 0.3 0.2 1.5 2 10 0.5\n' >"$work/bodies.mci"
printf 'i cylinder -0.4 -1 2.5 -0.4 1 2.5 0.02 1.6 2 10 0.5\ni sphere 0.1 0 0.3 0.1 1.3 2 10 0.5\n1.0\n' >>"$work/bodies.mci"
draw bodies "$work/bodies.mci" '>body 1, n = 1.5<' '>body 2, n = 1.6<' '>body 3, n = 1.3<'
test -z "${ALL_CASES:-}" || draw glow samples/glow.mci '>body 1, n = 1.37<'

# A file with several runs: the picture shows one of them.
draw first samples/two_runs.mci "$(awk 'NR > 3 && / A/ { print $1; exit }' samples/two_runs.mci), seen along y"
expect_code 0 view samples/two_runs.mci --run 2 -o "$work/second.svg" --quiet
cmp -s "$work/first.svg" "$work/second.svg" && complain "--run 2 draws the first run"
expect_error 2 "--run 3 (expected 1 to 2, the runs of samples/two_runs.mci)" view samples/two_runs.mci --run 3 -o "$work/third.svg"
test ! -e "$work/third.svg" || complain "a picture of no run"
expect_error 2 "--output $work/a.txt (expected a name that ends in .svg, .png, .pdf or .eps)" view samples/mixed.mci -o "$work/a.txt"
expect_code 0 view samples/two_runs.mci -o "$work/again.svg" --quiet
cmp -s "$work/first.svg" "$work/again.svg" || complain "the same scene has other bytes"

# The cut by the plane is drawn where it is known: a pyramid has its slopes, and goes on as a plane.
"$CLUSTERMCML_PYTHON" - <<'END' || complain "sections"
import sys
sys.path.insert(0, "src/python")
from clustermcml.view import _boundary_pieces, _read_obj
points, facets = _read_obj("meshes/pyramid.obj")
pieces = _boundary_pieces({"z": 2.0, "outer_z": 2.0}, "meshes/pyramid.obj", -9.0, 9.0)
x, z = pieces[..., 0], pieces[..., 1]
assert x.min() == -9 and x.max() == 9 and z.max() == 2 and abs(z.min() - (2 - points[:, 2].max())) < 1e-12, (x, z)
length = sum(abs(b[0] - a[0]) for a, b in pieces)
assert abs(length - 18) < 1e-12, length
END
finish
