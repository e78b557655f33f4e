#!/bin/sh
# What the program says in cases that are seldom: notes and warnings of check, mesh, compare and plot, refusals that only
# one command has, and the progress bar, which needs a terminal.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_line() { # TEXT: a line of standard output, after leading blanks
    sed 's/^ *//' "$work/out" | grep -qxF -- "$1" || complain "no line \"$1\": $(cat "$work/out")"
}

scene() { # OUTPUT BOUNDARY-LINE [LINE OF OPTIONS]
    printf '1.0\n1\n%s A\n1000\n%s\n0.01 0.02\n20 20 10\n1\n1.0\n%s\n1.4 0.5 50 0.8 0.1\n1.0\n' "$1" "${3-}" "$2" >"$work/scene.mci"
}

# A pyramid 2 m wide over a layer of 1 mm. One vertex stands twice, one is not used; one triangle has no area, one is
# turned round.
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
expect_line "boundary 0: plane at z = 0 cm (flat) from $work/pyramid.obj"
expect_error 2 "$work/scene.mci:10: --boundaries cone cannot represent a mesh (expected auto or mesh)" \
    run "$work/scene.mci" --boundaries cone --quiet -o "$work"
# 1e-6 of the width between two vertices: 16 roundings of single precision
sed 's/^v 0 0 1/v 0.999999 0.9999995 0.0000001/' "$work/pyramid.obj" >"$work/flat.obj"
scene p.mco 'm "flat.obj" units=cm'
expect_code 0 check "$work/scene.mci"
grep -q "warning: single precision resolves 2.4e-07 cm here, more than 1e-4 of the shortest edge" "$work/out" ||
    complain "no warning of precision: $(cat "$work/out")"

expect_code 0 mesh samples/fig5.mci -o "$work"
expect_line "boundary 0: plane z = 0 cm, no file"
expect_error 2 "crosscheck: samples/two_runs.mci has 2 runs (expected one with --dump)" \
    crosscheck samples/two_runs.mci --dump "$work/dump"
expect_code 0 -h
grep -q '^usage: clustermcml ' "$work/out" || complain "-h shows no usage"
expect_error 2 "--group 0 (expected a whole number from 1 to 65536)" samples/fig5.mci --engine opencl --group 0
expect_code 0 samples/fig5.mci --photons 10 --quiet --output-dir "$work"

# compare: other layers, no absorption, packets too few for profiles, or for anything
scene one.mco ''
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work"
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work" --ignore-absorption --seed 2
sed 's/^one.mco/bare.mco/' "$work/scene.mci" >"$work/bare.mci"
expect_code 0 "$work/bare.mci" --photons 100 --quiet -o "$work" --ignore-absorption --seed 2
expect_code 0 "$work/scene.mci" --photons 100 --quiet -o "$work"
expect_code 0 compare "$work/one.mco" "$work/bare.mco"
expect_line "note: A_z is left out: one of the runs did not tally it"
grep -q '^A_z .*not tested: too few packets$' "$work/out" || complain "A_z: $(cat "$work/out")"
sed -e 's/^one.mco/two.mco/' -e '8s/1/2/' -e 's/^1.4 .*/&\n&/' "$work/scene.mci" >"$work/two.mci"
expect_code 0 "$work/two.mci" --photons 100 --quiet -o "$work"
code=0
"$program" compare "$work/one.mco" "$work/two.mco" >"$work/out" 2>&1 || code=$?
test $code -le 1 && grep -q '^note: 1 and 2 layers$' "$work/out" || complain "other layers: exit $code: $(cat "$work/out")"

# plot: too few bins, no light on one side
sed -e 's/^20 20 10/20 2 10/' -e 's/^one.mco/few.mco/' "$work/scene.mci" >"$work/few.mci"
expect_code 0 "$work/few.mci" --photons 100 --quiet -o "$work"
expect_error 2 "$work/few.mco: nr = 2 (expected 3 or more bins for a curve over r)" plot "$work/few.mco" -o "$work/few.svg"
if command -v gnuplot >/dev/null; then
    sed -e 's/^1.4 .*/1.4 1e4 0 0 1/' -e 's/^one.mco/dark.mco/' "$work/scene.mci" >"$work/dark.mci"
    expect_code 0 "$work/dark.mci" --photons 100 --quiet -o "$work"
    expect_code 0 plot "$work/dark.mco" -o "$work/dark.svg"
    grep -q 'no light' "$work/dark.svg" || complain "a picture without light says nothing of it"
fi

# On a terminal a bar stands on one line, which is empty at the end.
python3 - "$program" "$work" <<'END' || complain "the progress bar"
import os, pty, re, subprocess, sys
program, work = sys.argv[1:]
ours, theirs = pty.openpty()
run = subprocess.Popen([program, "samples/thick.mci", "--photons", "2e4", "--threads", "1", "-o", work], stdout=subprocess.DEVNULL, stderr=theirs)
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
bar = rb"\r\[#*\.*\] +\d+ %  [\d.e+]+ photons/s  \d+ s left   "
bars = re.findall(bar, text)
ok = run.wait() == 0 and bars and all(len(b.split(b"]")[0]) == 32 for b in bars) and b"[" + 30 * b"#" + b"] 100 %" in bars[-1]
ok = ok and text.endswith(b"\r\x1b[K") and not re.sub(bar, b"", text).replace(b"\r\x1b[K", b"")
if not ok:
    print(repr(text))
sys.exit(not ok)
END
finish
