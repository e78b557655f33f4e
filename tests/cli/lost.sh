#!/bin/sh
# Tests numerical errors: lost packets are counted, reported and end with exit code 4. A mesh of 1e5 rough triangles loses no
# packet. Directions of smooth normals that contradict their facet are counted, too.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

scene() { # NAME "SURFACE" "LAYER" [BEAM]: one layer below the surface
    printf '1.0\n1\n%s.mco A\n20000\n%s\n0.01 0.01\n1 1 1\n1\n1\n%s\n%s\n1\n' "$1" "${4-}" "$2" "$3" >"$work/$1.mci"
}

# A packet is totally reflected for ever in a medium that absorbs next to nothing. It is not trapped but stuck, hence lost.
# The first packet enters the flank of the cone.
scene stuck "b 2 0.17320508075688773 0.1 0 0" "2 1e-30 0 0 0.5" "beam pencil at=0.05,0"
expect_code 4 "$work/stuck.mci" --photons 1 -o "$work"
grep -q '^clustermcml: stuck.mco: 1 of 1 packets lost (at most 1 in 1e6 may be)$' "$work/err" ||
    complain "a lost packet is not an error: $(cat "$work/err")"
grep -q 'residue 0, .*lost 1$' "$work/out" || complain "a lost packet is not in the summary: $(cat "$work/out")"
grep -q '1 packets lost: stuck$' "$work/out" || complain "no cause: $(cat "$work/out")"
test "$(sed -n '/^lost #/,/^$/p' "$work/stuck.mco" | sed '1d;/^$/d' | tr '\n' ' ')" = "1 0 " ||
    complain "no index in the result: $(sed -n '/^lost #/,$p' "$work/stuck.mco" | head -n 4)"
python=${CLUSTERMCML_PYTHON:-/usr/bin/python3}
if test -e "$work/stuck.h5" && "$python" -c "import h5py" 2>/dev/null; then
    index=$("$python" -c 'import h5py, sys; print(h5py.File(sys.argv[1])["/"].attrs["lost_indices"].decode())' "$work/stuck.h5" 2>&1)
    test "$index" = 0 || complain "the index in the .h5: $index"
fi

expect_sound() { # NAME: $work/out is the JSON line of a run without loss
    grep -q '"lost":0,' "$work/out" && grep -q '"residue":0[,.}]' "$work/out" || complain "$1: $(cat "$work/out")"
}

# Light that interacts within a rounding of the tip of a cone, before it has left the axis, leaves on the side to which it
# flies.
scene tip "b 4 0.02 0.1 0.01 0.2 -0.01 0.3 0.01 0.1" "1.4 8 12 0.5 0.35"
expect_code 0 trace "$work/tip.mci" 1088599 --seed 22 --set photons=1e8
tail -n 1 "$work/out" | grep -q '^# .* after [0-9]* interactions and [0-9] boundary events' ||
    complain "light at the tip of a cone: $(tail -n 1 "$work/out")"

python3 bench/lib/rough.py mesh 1e5 0.03 "$work/rough.obj" || complain "no rough mesh"
scene rough 'm "rough.obj"' "1.34 0.1 10 0.5 0.5"
for options in "" "--mesh-search embree"; do
    # shellcheck disable=SC2086 # several options on purpose
    expect_code 0 "$work/rough.mci" --json -o "$work" $options
    expect_sound "1e5 triangles $options"
    grep -Eq '"primitives":(9|10)[0-9]{4},' "$work/out" || complain "not 1e5 triangles: $(cat "$work/out")"
done

scene smooth "m \"$PWD/meshes/ridges.obj\" normals=vertex" "1.4 0.1 10 0.5 0.5" "beam disk 0.8"
expect_code 0 "$work/smooth.mci" --json -o "$work"
expect_sound "smooth normals"
grep -q '"shading_overruled":[1-9]' "$work/out" || complain "no smooth normal was overruled: $(cat "$work/out")"

# Light may run into a groove between vertex normals for ever. At the bottom the facets turn it back, in both precisions
# alike, as trace shows.
for engine in cpu reference; do
    expect_code 0 trace samples/shapes/hinoise.mci 782539 --sampling random --roulette mcml --boundaries mesh --tolerance 1e-1 \
        --normals vertex --engine $engine
    tail -n 1 "$work/out" | grep -q '^# reflected after 6 interactions and 32 boundary events' ||
        complain "light in a groove, $engine: $(tail -n 1 "$work/out")"
done
# A gently rough plate holds light back for more than 10000 boundary events, and lets it out before absorbing it. Such light
# has left: no packet is trapped outside.
awk 'BEGIN { print "ncols 16\nnrows 16\ncellsize 0.02"; for (j = 0; j < 16; j++) for (i = 0; i < 16; i++)
    printf "%.8f%s", 5e-4 * cos(i * atan2(0, -1) / 8 + 1) * cos(j * atan2(0, -1) / 8), i < 15 ? " " : "\n" }' >"$work/gentle.asc"
printf '1.0\n1\ngentle.mco A\n60\n0.02 0.02\n5 5 1\nbeam rectangle 0.32 0.32 z=0.1 light=isotropic\n1\n1\n%s\n1.5 1e-4 0 0 0.2\n%s shift=0.1,0.02,0\n1\n' \
    'm "gentle.asc" tile units=cm' 'm "gentle.asc" tile units=cm' >"$work/gentle.mci"
expect_code 0 trace "$work/gentle.mci" 20 --sampling random
tail -n 1 "$work/out" | grep -Eq '^# (reflected|transmitted) after 0 interactions and 28288 boundary events' || complain "light that left late: $(tail -n 1 "$work/out")"
expect_code 0 "$work/gentle.mci" --json -o "$work"
expect_sound "light that left late"
grep -q '"trapped":0,' "$work/out" || complain "light outside is trapped: $(cat "$work/out")"
expect_error 2 "--run 3 (expected 1 to 2, the runs of samples/two_runs.mci)" trace samples/two_runs.mci 1 --run 3

# The program needs no input and prints little: standard input is closed, output goes to files, and a line of progress appears
# only after 10 seconds.
"$program" "$work/smooth.mci" -o "$work" <&- >"$work/out" 2>"$work/err" || complain "a closed standard input: exit $?"
test "$(wc -l <"$work/err")" -le 10 || complain "a flood of $(wc -l <"$work/err") lines: $(tail -n 3 "$work/err")"
test "$(cat "$work/out" "$work/err" | tr -d '\n' | tr -dc '\r' | wc -c)" -eq 0 || complain "a progress bar without a terminal"
finish
