#!/bin/sh
# Tests meshes as scanners and modelling tools write them: check and run report the repairs, the position of the mesh, and how
# far beam and map miss it. Boxes, counts and distances are worked out by hand.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_line() { # TEXT: a line of standard output, after leading blanks
    sed 's/^ *//' "$work/out" | grep -qxF -- "$1" || complain "no line \"$1\": $(cat "$work/out")"
}

scene() { # MESH-LINE [LINE OF OPTIONS]...
    {
        printf '1.0\n1\na.mco A\n1000\n0.01 0.02\n20 20 10\n1\n1.0\n%s\n1.4 0.5 50 0.8 0.3\n1.0\n' "$1" |
            awk -v more="${2-}" 'NR == 5 && more != "" { print more } { print }'
    } >"$work/scene.mci"
}

# A roof, 4 x 2 mm in x and y of the file, y up, along the file's x axis, with bent gable quads.
cat >"$work/roof.obj" <<'END'
v 0 0 0
v 4 0 0
v 4 0 -2
v 0 0 -2
v 1 0.4 -1
v 3 0.4 -1.2
f 1 2 6 5
f 3 4 5 6
f 2 3 6
f 4 1 5
END
scene 'm "roof.obj" up=y units=mm' 'beam pencil at=0.1,0.1'
expect_code 0 check "$work/scene.mci"
expect_line "mesh of boundary 0: x 0..0.4, y 0..0.2, z -0.04..0 cm"
expect_line "boundary 0: 2 faces lie in no plane and were cut into triangles, corners up to 0.00271 cm off the face's mean plane"
grep -q warning "$work/out" && complain "a warning without reason: $(cat "$work/out")"
grep -q beyond "$work/err" && complain "a note without reason: $(cat "$work/err")"
expect_code 0 "$work/scene.mci" --photons 100 -o "$work"
grep -q 'boundary 0: 2 faces lie in no plane' "$work/out" || complain "run does not say that faces were cut"
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work"
test ! -s "$work/out" || complain "--quiet speaks"

# The roof is turned by a quarter, then moved: (x, y) -> (-y, x) + (0.2, 0).
scene 'm "roof.obj" up=y units=mm rotate=90 shift=0.2,0,0.01' 'map 10 10 0.01 0.01'
expect_code 0 check "$work/scene.mci"
expect_line "mesh of boundary 0: x 0..0.2, y 0..0.4, z -0.05..-0.01 cm"
grep -q "^clustermcml: note: $work/scene.mci:[0-9]*: the map, 0.1 x 0.1 cm, reaches beyond the mesh of boundary 0$" "$work/err" ||
    complain "no note of the map: $(cat "$work/err")"
scene 'm "roof.obj" up=y units=mm shift=-0.2,-0.1,0' 'map 40 20 0.01 0.01
beam pencil at=-0.2,0 angle=45'
expect_code 0 check "$work/scene.mci"
grep -q "the map" "$work/err" && complain "a map as large as the mesh lies beyond it"
scene 'm "roof.obj" up=y units=mm shift=-0.2,-0.1,0.1' 'beam pencil at=-0.05,0 angle=60'
beyond="clustermcml: note: $work/scene.mci:10: the beam's axis passes boundary 0 at x = -0.223205, y = 0 cm, beyond its mesh"
for command in "check $work/scene.mci" "check $work/scene.mci --json" "$work/scene.mci --photons 100 --quiet -o $work"; do
    rm -f "$work/a.mco" # replacing it is noted
    expect_code 0 $command
    test "$(cat "$work/err")" = "$beyond" || complain "$command: no note of the beam: $(cat "$work/err")"
done

# A border that is level in single precision is levelled; one that is not level gets a skirt.
sed 's/^v 4 0 0/v 4 0.000001 0/' "$work/roof.obj" >"$work/single.obj"
scene 'm "single.obj" up=y units=mm'
expect_code 0 check "$work/scene.mci"
expect_line "boundary 0: the mesh's border was levelled, its heights differed by 1e-07 cm"
sed 's/^v 4 0 /v 4 0.2 /' "$work/roof.obj" >"$work/tilted.obj"
scene 'm "tilted.obj" up=y units=mm'
expect_error 2 "$work/scene.mci:9: boundary 0: $work/tilted.obj:9: the border is not horizontal: its height spans 0.02 cm, the highest point is (0.4, 0.2, \
height 0.02) cm (expected a border on one horizontal plane, or skirt=WIDTH)" check "$work/scene.mci"
scene 'm "tilted.obj" up=y units=mm skirt=0.05'
expect_code 0 check "$work/scene.mci"
expect_line "mesh of boundary 0: x -0.05..0.45, y -0.05..0.25, z -0.04..0 cm"
expect_line "boundary 0: skirt of 0.05 cm around the mesh to its border's mean height 0.01 cm: 8 triangles, up to 0.01 cm"
expect_code 0 "$work/scene.mci" --photons 1e4 -o "$work"
grep -q 'boundary 0: skirt of 0.05 cm' "$work/out" || complain "run does not say that a skirt was added"

# A mushroom whose cap hangs lower than its stem's foot. The foot is not level, and a skirt would pass through the cap.
cat >"$work/lid.obj" <<'END'
v -1 -1 0.1
v 1 -1 0
v 1 1 0
v -1 1 0
v -1.5 -1.5 -0.1
v 1.5 -1.5 -0.1
v 1.5 1.5 -0.1
v -1.5 1.5 -0.1
v 0 0 0.25
f 1 2 6
f 1 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5
f 4 5 8
f 5 6 9
f 6 7 9
f 7 8 9
f 8 5 9
END
scene 'm "lid.obj" skirt=1'
expect_code 2 check "$work/scene.mci"
grep -q '^clustermcml: .*scene.mci:9: boundary 0 \(crosses\|touches\) itself at (.*) cm: triangles .*, of its skirt (expected another skirt=)$' \
    "$work/err" || complain "a skirt through its mesh: $(cat "$work/err")"
finish
