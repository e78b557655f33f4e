#!/bin/sh
# Tests scans: the same mesh as .obj, as .stl (text, binary) and as .ply (ascii, both orders of bytes) gives the same bytes of
# results, as a boundary and as a body. Coordinates are floats, so that binary files round nothing, and vertices stand in the
# order in which faces use them, as an .stl without vertices has them. weld= joins what the refusal says.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

cat >"$work/make.py" <<'P'
import random, sys
sys.path.insert(0, "tests/lib")
import scan_files
work, n, dice = sys.argv[1], 8, random.Random(1)

def write(name, mesh, faces):
    """Writes all formats, with vertices in the order of their first use."""
    used = list(dict.fromkeys(k for face in faces for k in face))
    vertices, faces = [mesh[k] for k in used], [[used.index(k) for k in face] for face in faces]
    for form, writer in scan_files.WRITERS.items():
        with open(f"{work}/{form}.{name}.{form[:3]}", "wb") as file:
            file.write(writer(vertices, faces))
    return vertices, faces

grid = [(x / 64, y / 64, 0 if x in (0, n) or y in (0, n) else dice.randrange(9) / 1024) for y in range(n + 1) for x in range(n + 1)]
cells = [y * (n + 1) + x for y in range(n) for x in range(n)]
vertices, faces = write("skin", grid, [face for k in cells for face in ([k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1])])
ball = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
corners, sides = write("stone", [tuple(x / 32 for x in v) for v in ball], [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
# Faces with corners of their own, up to 3e-6 cm from where they belong: as an exporter with few digits leaves them.
loose = [tuple(x + 1.5e-6 * dice.uniform(-1, 1) for x in vertices[k]) for face in faces for k in face]
with open(f"{work}/loose.stl", "wb") as file:
    file.write(scan_files.stl_text(loose, [[3 * f, 3 * f + 1, 3 * f + 2] for f in range(len(faces))]))
apart = [tuple(x + 1.5e-6 * dice.uniform(-1, 1) for x in corners[k]) for side in sides for k in side]
with open(f"{work}/apart.stl", "wb") as file:
    file.write(scan_files.stl_binary(apart, [[3 * f, 3 * f + 1, 3 * f + 2] for f in range(len(sides))]))
with open(f"{work}/quads.obj", "wb") as file:
    file.write(scan_files.obj(grid, [[k, k + 1, k + n + 2, k + n + 1] for k in cells]))
with open(f"{work}/quads.ply", "wb") as file:
    file.write(scan_files.ply_binary(">", grid, [[k, k + 1, k + n + 2, k + n + 1] for k in cells]))
P
python3 -B "$work/make.py" "$work" || complain "no meshes"

scene() { # SKIN STONE [KEYS] [KEYS OF THE STONE]
    printf '1.0\n1\na.mco A\nfacets\nbeam pencil at=0.03,0.04\n2000\n0.01 0.01\n20 10 3\n1\n1.0\nm "%s" %s\n1.4 1 60 0.8 0.3\ni "%s" 1.5 5 20 0.7 shift=0.0625,0.0625,-0.125 %s\n1.0\n' \
        "$1" "${3-}" "$2" "${4-}" >"$work/scene.mci"
}
# Flies the scene and writes the meshes as the program has them. Only time, name and check sums of the input differ.
results() { # FOLDER
    expect_code 0 "$work/scene.mci" --quiet -o "$work/$1"
    whole "$work/$1/a.mco" >"$work/$1/whole"
    expect_code 0 mesh "$work/scene.mci" --quiet -o "$work/$1"
    (cd "$work/$1" && sed '/^# User time/d; /\.\(obj\|stl\|ply\)/d' whole && sed '/^#/d' ./*.obj) >"$work/$1.all"
}
for form in obj stl-text stl-binary ply-ascii ply-little ply-big; do
    ending=${form%%-*}
    scene "$form.skin.$ending" "$form.stone.$ending"
    results "$form"
    test "$(wc -l <"$work/$form.all")" -gt 500 || complain "$form: too little is compared"
    cmp "$work/obj.all" "$work/$form.all" || complain "$form: other results than those of .obj"
done
scene quads.obj stl-text.stone.stl
results quads
scene quads.ply ply-big.stone.ply 'normals=vertex up=z'
expect_code 0 view "$work/scene.mci" -o "$work/view.svg"
grep -q 'quads.ply' "$work/view.svg" || complain "view does not name the .ply: $(cat "$work/out")"
scene quads.ply ply-big.stone.ply
results quads-ply
cmp "$work/quads.all" "$work/quads-ply.all" || complain "polygons of a .ply are cut in another way than those of an .obj"

# The refusal of loose faces names the distance; with it the faces join.
scene loose.stl stl-text.stone.stl
expect_code 2 check "$work/scene.mci"
weld=$(sed -n 's/.* corners nearly meet others, up to [1-3][.0-9]*e-06 cm away at (.*) cm: \(weld=[.0-9]*e-06\) joins them$/\1/p' "$work/err")
test -n "$weld" || complain "no weld= is named: $(cat "$work/err")"
scene loose.stl stl-text.stone.stl "$weld skirt=0.1"
expect_code 0 check "$work/scene.mci"
grep -q '128 triangles, edges' "$work/out" || grep -q 'mesh at z = 0 cm, [0-9]* triangles' "$work/out" || complain "$(cat "$work/out")"
grep -q "boundary 0: 303 corners were joined with others, up to [1-4][.0-9]*e-06 cm away ($weld)" "$work/out" || complain "joined: $(cat "$work/out")"
scene loose.stl stl-text.stone.stl weld=1e-9
expect_code 2 check "$work/scene.mci"
# A body is refused and joined likewise. A weld= that joins too much is named.
scene obj.skin.obj apart.stl
expect_code 2 check "$work/scene.mci"
weld=$(sed -n 's/.*body 1: .*apart.stl: the body is open: .*; 24 corners nearly meet others, .* cm: \(weld=[.0-9]*e-06\) joins them$/\1/p' "$work/err")
test -n "$weld" || complain "no weld= is named for a body: $(cat "$work/err")"
scene obj.skin.obj apart.stl '' "$weld"
expect_code 0 check "$work/scene.mci"
grep -q "^    body 1: 18 corners were joined with others, up to [1-4][.0-9]*e-06 cm away ($weld)" "$work/out" || complain "joined: $(cat "$work/out")"
expect_code 0 "$work/scene.mci" -o "$work/apart"
grep -q "^    body 1: 18 corners were joined with others" "$work/out" || complain "joined: $(cat "$work/out")"
scene obj.skin.obj apart.stl '' weld=1
expect_code 2 check "$work/scene.mci"
grep -q 'every face of the mesh has zero area; weld=1 has joined 23 corners, .* cm away: it may be too large$' "$work/err" || complain "too large: $(cat "$work/err")"

# The budget counts the triangles of each format before they take memory.
for form in stl-text stl-binary ply-ascii ply-big; do
    scene "$form.skin.${form%%-*}" obj.stone.obj
    expect_code 2 check "$work/scene.mci" --mesh-budget 127
    grep -q 'boundary 0 needs 128 triangles, .* (expected at most 127, or a coarser mesh or a larger --mesh-budget)$' "$work/err" ||
        complain "$form: the budget: $(cat "$work/err")"
done
scene quads.ply obj.stone.obj
expect_code 2 check "$work/scene.mci" --mesh-budget 127
grep -q 'boundary 0 needs 128 triangles' "$work/err" || complain "polygons: the budget: $(cat "$work/err")"
expect_error 2 "$work/stl-text.skin.stl:1: file version = solid (expected 1.0; this is a mesh, which an m line of a scene names)" "$work/stl-text.skin.stl"
finish
