#!/bin/sh
# Tests rare messages: notes and warnings of check, mesh and compare, refusals that only one command has, and the progress
# bar, which needs a terminal.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_line() { # TEXT: a line of standard output, after leading blanks
    sed 's/^ *//' "$work/out" | grep -qxF -- "$1" || complain "no line \"$1\": $(cat "$work/out")"
}

scene() { # OUTPUT BOUNDARY-LINE [LINE OF OPTIONS]
    printf '1.0\n1\n%s A\n1000\n%s\n0.01 0.02\n20 20 10\n1\n1.0\n%s\n1.4 0.5 50 0.8 0.1\n1.0\n' "$1" "${3-}" "$2" >"$work/scene.mci"
}

# A pyramid 2 m wide over a layer of 1 mm. The mesh has a doubled vertex, an unused one, a triangle without area, and a
# flipped one.
cat >"$work/pyramid.obj" <<'END'
v 1 1 0
v -1 1 0
v -1 -1 0
v 1 -1 0
v 0 0 1
v 1 1 0
v 7 7 7
f 1 2 5
f 2 3 5
f 5 4 3
f 4 6 5
f 1 6 5
END
scene p.mco 'm "pyramid.obj" units=m' 'map 4 3 0.1 0.2 angles volume'
expect_code 0 check "$work/scene.mci"
expect_line "welded 1 bit-equal vertices, dropped 1 degenerate triangles and 1 unused vertices, turned 1 triangles"
expect_line "warning: the mesh is 200 cm wide and 100 cm high over layers of 0.1 cm: is units= right?"
expect_line "map: nx 4 x 0.1 cm, ny 3 x 0.2 cm, na angle bins in each pixel, and nz layers of voxels"
grep -q "single precision" "$work/out" && complain "a warning of precision: $(cat "$work/out")"
expect_code 0 check "$work/scene.mci" --boundaries plane
expect_line "boundary 0: plane at z = 0 cm (shape ignored) from $work/pyramid.obj"
expect_error 2 "$work/scene.mci:10: --boundaries cone cannot represent a mesh (expected auto or mesh)" \
    run "$work/scene.mci" --boundaries cone --quiet -o "$work"
# Two vertices lie 1e-6 of the width apart: 16 roundings of single precision.
sed 's/^v 0 0 1/v 0.999999 0.9999995 0.0000001/' "$work/pyramid.obj" >"$work/flat.obj"
scene p.mco 'm "flat.obj" units=cm'
expect_code 0 check "$work/scene.mci"
grep -q "warning: single precision resolves 2.4e-07 cm here, more than 1e-4 of the shortest edge" "$work/out" ||
    complain "no warning of precision: $(cat "$work/out")"

# The corners of the file, whose heights are positive upwards.
expect_code 0 check samples/vein.mci
expect_line "mesh of body 1: x -0.091393..0.062454, y -0.405566..0.403847, z 0.014012..0.057993 cm"
expect_code 0 mesh samples/fig5.mci -o "$work"
expect_line "boundary 0: plane z = 0 cm, no file"
expect_error 2 "crosscheck: samples/two_runs.mci has 2 runs (expected one with --dump)" \
    crosscheck samples/two_runs.mci --dump "$work/dump"
expect_code 0 -h
grep -q '^usage: clustermcml ' "$work/out" || complain "-h shows no usage"
expect_error 2 "--group 0 (expected a whole number from 1 to 65536)" samples/fig5.mci --engine opencl --group 0
expect_code 0 samples/fig5.mci --photons 10 --quiet --output-dir "$work"

# compare notes other layers, missing absorption, and too few packets for profiles or for any test.
scene one.mco ''
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work"
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work" --ignore-absorption --seed 2
sed 's/^one.mco/bare.mco/' "$work/scene.mci" >"$work/bare.mci"
expect_code 0 "$work/bare.mci" --photons 100 --quiet -o "$work" --ignore-absorption --seed 2
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work"
expect_code 0 compare "$work/one.mco" "$work/bare.mco"
expect_line "A_z   not tested: b did not tally it"
sed -e 's/^one.mco/two.mco/' -e '8s/1/2/' -e 's/^1.4 .*/&\n&/' "$work/scene.mci" >"$work/two.mci"
expect_code 0 "$work/two.mci" --photons 100 --quiet -o "$work"
code=0
"$program" compare "$work/one.mco" "$work/two.mco" >"$work/out" 2>&1 || code=$?
test $code -le 1 && grep -q '^note: 1 and 2 layers$' "$work/out" || complain "other layers: exit $code: $(cat "$work/out")"

# Scenes that can be read but were perhaps not meant: missing #@ marks, thicknesses in mm, runs beyond the announced number.
cat >"$work/odd.mci" <<'END'
1.0
1
odd.mco A
10
#beam disk 0.1
# beam disk 0.2 is for later
#map 4 3 0.1 0.2
#beam here is narrow
#facets
0.01 0.02
20 20 10
4
1.0
#b 2 0.1 0.1 0 0.1
#b without numbers
1.4 0.5 50 0.8 0.1
#m "skin.obj" units=mm
1.4 0.5 50 0.8 50
1.4 0.5 50 0.8 50.1
1.4 0.5 50 0.8 1e8
1.0
second.mco A
10
END
expect_code 0 check "$work/odd.mci"
cat >"$work/expected" <<END
clustermcml: note: $work/odd.mci:5: a comment: #beam disk 0.1 (did you mean #@ beam disk 0.1?)
clustermcml: note: $work/odd.mci:7: a comment: #map 4 3 0.1 0.2 (did you mean #@ map 4 3 0.1 0.2?)
clustermcml: note: $work/odd.mci:9: a comment: #facets (did you mean #@ facets?)
clustermcml: note: $work/odd.mci:14: a comment: #b 2 0.1 0.1 0 0.1 (did you mean #@ b 2 0.1 0.1 0 0.1?)
clustermcml: note: $work/odd.mci:17: a comment: #m "skin.obj" units=mm (did you mean #@ m "skin.obj" units=mm?)
clustermcml: note: $work/odd.mci:19: layer 3: d = 50.1 cm (lengths are in cm: was it meant in mm?)
clustermcml: note: $work/odd.mci:22: the run second.mco and what follows it is not read: the number of runs is 1
END
cmp -s "$work/expected" "$work/err" || complain "notes on the input: $(diff "$work/expected" "$work/err")"
# mua and mus that were perhaps exchanged are noted; media without scattering are not.
sed -e 's/^1.4 .* 50 0.8 50$/1.4 410.1 20.5 0.8 50/' -e 's/^1.4 .* 0.1$/1.4 410 20.5 0.8 0.1\ni sphere 0 0 0.05 0.01 1.4 9 0.4 0\ni sphere 1 0 0.05 0.01 1.4 9 0 0/' \
    -e '/^second/d' -e '/^#/d' -e 's/50.1/50/' "$work/odd.mci" >"$work/swapped.mci"
expect_code 0 check "$work/swapped.mci"
cat >"$work/expected" <<END
clustermcml: note: $work/swapped.mci:12: layer 2: mua = 410.1 and mus = 20.5 1/cm (were the two swapped?)
clustermcml: note: $work/swapped.mci:10: body 1: mua = 9 and mus = 0.4 1/cm (were the two swapped?)
END
cmp -s "$work/expected" "$work/err" || complain "mua and mus swapped: $(diff "$work/expected" "$work/err")"
sed '/^second/d; /^#/d; s/50.1/50/' "$work/odd.mci" >"$work/even.mci"
expect_code 0 check "$work/even.mci"
test ! -s "$work/err" || complain "a number behind the last run, and nothing else, is noted: $(cat "$work/err")"

# A total of 0 has an error of 0. The summary says what that means, unless a backing lets nothing pass.
printf '1.0\n1\ndeep.mco A\n200\n0.1 0.1\n5 5 1\n1\n1\n1.4 9 50 0.8 5\n1\n' >"$work/deep.mci"
expect_code 0 "$work/deep.mci" -o "$work"
grep -q '^  Tt   0.000000 +- 0.000000   exact .*   no packet came: below 0.015 at 95 %$' "$work/out" && test "$(grep -c 'no packet' "$work/out")" -eq 1 ||
    complain "no word of a total that nothing came to: $(cat "$work/out")"
sed 's/^1$/&/; $s/.*/backing 0.5\n1/' "$work/deep.mci" >"$work/backed.mci"
expect_code 0 "$work/backed.mci" --output backed -o "$work"
grep -q 'no packet came' "$work/out" && complain "light below a backing: $(cat "$work/out")"

# A pencil beam sees only one point of a mesh or heightmap, and a note names it. Points by hand: on a roof of slope 0.5, 0.2
# cm high, 0.1 cm from its ridge; in slanted light where 0.25 + h = x and h = 0.2 - x / 2; on a map two periods from its
# middle.
{
    printf 'v 0.4 0.4 0\nv -0.4 0.4 0\nv -0.4 -0.4 0\nv 0.4 -0.4 0\nv 0 0.3 0.2\nv 0 -0.3 0.2\n'
    printf 'f 1 5 6 4\nf 2 3 6 5\nf 1 2 5\nf 3 4 6\n'
} >"$work/roof.obj"
printf 'ncols 4 nrows 2 cellsize 0.1\n0 0.05 0.1 0.05\n0 0.05 0.1 0.05\n' >"$work/roof.asc"
pencil() { # LINE BOUNDARY HEIGHT ARGUMENTS...: the one note, which advises a beam $wide
    expected="clustermcml: note: $work/scene.mci:$1: a pencil meets boundary $2 at one point: height $3 cm, slope 0.5 \
(for what the whole surface does: a beam over $wide)"
    shift 3
    rm -f "$work"/n.* # replacing it is noted
    expect_code 0 "$@"
    test "$(cat "$work/err")" = "$expected" || complain "$*: $(cat "$work/err")"
}
no_pencil() { # ARGUMENTS...
    expect_code 0 "$@"
    test ! -s "$work/err" || complain "$*: $(cat "$work/err")"
}
printf 'layer1.g\n0.1\n0.2\n' >"$work/g.csv"
wide="whole periods, beam rectangle W H"
scene n.mco 'm "roof.obj" units=cm' 'beam pencil at=0.1,0.05'
for command in check "check --json" "run -o $work --photons 10 --quiet" "run -o $work --photons 10 --json" \
    "run -o $work --photons 10 --quiet --sweep $work/g.csv"; do
    pencil 10 0 0.15 $command "$work/scene.mci"
done
no_pencil check "$work/scene.mci" --boundaries plane
scene n.mco 'm "roof.obj" units=cm' 'beam pencil at=0.25,0.05 angle=45 azimuth=180'
pencil 10 0 0.05 check "$work/scene.mci"
scene n.mco 'm "roof.asc" units=cm tile' 'beam pencil at=0.8,0.02'
wide="one period, beam rectangle tile" pencil 10 0 0.075 check "$work/scene.mci"
scene n.mco 'm "roof.asc" units=cm tile' 'beam disk 0.1'
no_pencil check "$work/scene.mci"
scene n.mco 'b 2 0.1 0.1 0 0.1' 'beam pencil at=0.1,0.05'
no_pencil check "$work/scene.mci"
# below a clear layer, and below one that scatters
for mus in 0 50; do
    sed -i "10,11d; 9s/.*/1.0\n1.4 0 $mus 0 0.3\nm \"roof.obj\" units=cm\n1.4 0.5 50 0.8 0.1/; 8s/1/2/" "$work/scene.mci"
    if test $mus -eq 0; then pencil 11 1 0.15 check "$work/scene.mci"; else no_pencil check "$work/scene.mci"; fi
    scene n.mco 'b 2 0.1 0.1 0 0.1' 'beam pencil at=0.1,0.05'
done

# On a terminal, a progress bar occupies one line, which is empty at the end. The bar is one column shorter than the terminal
# is wide.
python3 - "$program" "$work" <<'END' || complain "the progress bar"
import fcntl, os, pty, re, struct, subprocess, sys, termios
program, work = sys.argv[1:]
TIME = rb"[\d.]+ (?:s|min|h|d)"
WHOLE = rb" *\d+ %  [\d.e+]+ photons/s  " + TIME + b", " + TIME + b" left"


def shown(columns):
    """What is drawn on a terminal of that width (0: unknown), one string for every time."""
    ours, theirs = pty.openpty()
    if os.path.exists(f"{work}/thick.mco"):
        os.remove(f"{work}/thick.mco") # replacing it is noted
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24 if columns else 0, columns, 0, 0))
    run = subprocess.Popen([program, "samples/thick.mci", "--photons", "2e4", "--threads", "1", "-o", work],
                           stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    text = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError: # the other end is closed
            break
        if not part:
            break
        text += part
    drawn = [line.replace(b"\x1b[K", b"") for line in text.split(b"\r")]
    drawn, ends = [line for line in drawn if line], text.startswith(b"\r") and text.endswith(b"\r\x1b[K")
    if run.wait() != 0 or not ends or not drawn or b"100 %"[:columns - 1 if columns else 5] not in drawn[-1]:
        sys.exit(f"{columns} columns: {text!r}")
    return drawn


for columns, bar in ((0, 79), (80, 79), (60, 59), (200, None), (30, None), (8, None)):
    for line in shown(columns):
        full = re.fullmatch(rb"\[#*\.*\] +" + WHOLE, line)
        if bar and not (full and len(line) == bar):
            sys.exit(f"{columns} columns: {line!r}")
        if columns == 200 and not (full and line.index(b"]") == 61):
            sys.exit(f"a bar of more than 60: {line!r}")
        if 0 < columns < 60 and (len(line) > columns - 1 or b"photons" in line):
            sys.exit(f"{columns} columns: {line!r}")
END

# Arrays of gates and media have at most 65536 cells. With 3 media and one gate for later light, 21844 gates fit; one more
# leaves out the arrays, with a note.
for gates in 21844 21845; do
    scene times.mco "" "time 100 $gates"
    sed -i '/^$/d' "$work/scene.mci"
    expect_code 0 "$work/scene.mci" --photons 10 -o "$work/times"
    test "$(grep -c 'no A_lt and A_body_t: 3 media' "$work/err")" -eq $((gates - 21844)) || complain "$gates gates: $(cat "$work/err")"
done
finish
