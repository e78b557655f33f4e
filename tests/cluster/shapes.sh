#!/bin/sh
# Tests that results have the same bytes for any number of ranks and threads, but for the line of time.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh

one_shape() { # SCENE RANKS THREADS
    rm -rf "$work/here"
    mkdir "$work/here"
    ranks "$2" "samples/$1.mci" --photons 6000 --threads "$3" --quiet -o "$work/here" 2>"$work/err" ||
        complain "$1 on $2 ranks: $(cat "$work/err")"
    for file in "$work/alone"/*.mco "$work/alone"/*.vt?; do
        test ! -e "$file" || expect_bits "$1 on $2 x $3" "$work/here/${file##*/}" "$file"
    done
    test "$(ls "$work/here")" = "$(ls "$work/alone")" || complain "$1 on $2 x $3: $(ls "$work/here")"
}

for scene in shapes/hinoise mixed two_runs pulse skinmap; do
    rm -rf "$work/alone"
    mkdir "$work/alone"
    expect_code 0 "samples/$scene.mci" --photons 6000 --threads 1 --quiet -o "$work/alone"
    one_shape $scene 1 2
    one_shape $scene 4 1
    test $scene = mixed || test -n "${ALL_CASES:-}" || continue
    one_shape $scene 1 1
    one_shape $scene 2 1
done

# Surfaces that are rough: a mesh, a body, a tile and a mirror.
printf '1.0\n1\nrough.mco A\n20000\n0.02 0.02\n20 20 5\n2\n1.0\nrough ggx 0.4\nm "%s"\n1.4 1 50 0.8 0.4\n%s\n%s\n%s\n1.3 1 20 0.8 0.2\n%s\nbacking 0.8 mirror\n1.0\n' \
    "$PWD/meshes/overhang.obj" 'i sphere 0 0 0.2 0.1 1.5 2 10 0.5 rough=ggx,1' 'rough beckmann 0.3' 'm gaussian 0.4 0.02 tile points=16 normals=vertex' \
    'rough ggx 1' >"$work/rough.mci"
expect_code 0 "$work/rough.mci" --threads 1 --quiet -o "$work"
mv "$work/rough.mco" "$work/expected"
for shape in "1 2" "2 1" "3 1"; do
    ranks "${shape% *}" "$work/rough.mci" --threads "${shape#* }" --quiet -o "$work" || complain "rough on ${shape% *} x ${shape#* }"
    expect_bits "rough on ${shape% *} x ${shape#* }" "$work/rough.mco" "$work/expected"
done

# Beams with shares start above, inside and in a body: their photons are dealt to all ranks.
printf '1.0\n1\nbeams.mco A\n20001\n%s\n%s\n%s\n0.02 0.02\n20 20 5\n1\n1.0\n1.4 1 50 0.8 0.5\ni sphere 0 0 0.2 0.1 1.5 2 10 0.5\n1.0\n' \
    "beam disk 0.2 light=na:0.5" "beam pencil z=0.2 light=isotropic share=0.7" "beam ring 0.05 0.15 z=0.2 angle=70 share=1.9" \
    >"$work/beams.mci"
expect_code 0 "$work/beams.mci" --threads 1 --quiet -o "$work"
mv "$work/beams.mco" "$work/expected"
for count in 2 3; do
    ranks $count "$work/beams.mci" --quiet -o "$work" || complain "beams on $count ranks"
    expect_bits "beams on $count ranks" "$work/beams.mco" "$work/expected"
done

# A probe in contact: light of a port, and light of a wide beam that a face stops in part.
printf '1.0\n1\nprobe.mco A\n20001\nbeam port in light=na:0.3\nbeam disk 0.3\ndetector port out\n0.02 0.02\n20 20 5\n1\n1.0\n%s\n%s\n%s\n1.4 1 50 0.8 0.5\n1.0\n' \
    "face ring 0.05 0.2 0.5 lambertian" "port disk 0.05 n=1.46 name=in" "port disk 0.05 n=1.5 name=out at=0.15,0" >"$work/probe.mci"
expect_code 0 "$work/probe.mci" --threads 1 --quiet -o "$work"
mv "$work/probe.mco" "$work/expected"
for count in 2 3; do
    ranks $count "$work/probe.mci" --quiet -o "$work" || complain "a probe on $count ranks"
    expect_bits "a probe on $count ranks" "$work/probe.mco" "$work/expected"
done

# A run with fewer photons than ranks, and standard input, which only rank 0 has.
expect_code 0 samples/fig5.mci --photons 2 --quiet -o "$work"
mv "$work/fig5.mco" "$work/expected"
ranks 4 - --photons 2 --quiet -o "$work" <samples/fig5.mci || complain "standard input on 4 ranks"
expect_bits "2 photons on 4 ranks" "$work/fig5.mco" "$work/expected"

# Every rank finds out by itself which boundaries --tolerance makes planes.
printf '1.0\n1\nripple.mco A\n1000\n0.02 0.02\n50 50 10\n1\n1.0\n%s\n1.4 1 10 0 0.5\n1.0\n' \
    "b 5 0 0.1 1e-5 0.1 0 0.1 1e-5 0.1 0 0.1" >"$work/ripple.mci"
expect_code 0 "$work/ripple.mci" --tolerance 0.05 --photons 20000 --threads 1 --quiet -o "$work"
grep -q 'boundary 0: plane at z = 0 cm (radial heightfield, as a plane' "$work/ripple.mco" || complain "ripple is no plane"
mv "$work/ripple.mco" "$work/expected"
ranks 3 "$work/ripple.mci" --tolerance 0.05 --photons 20000 --quiet -o "$work" || complain "ripple on 3 ranks"
expect_bits "ripple on 3 ranks" "$work/ripple.mco" "$work/expected"

# All ranks together print one banner, one line of JSON, one table of ranks.
ranks 3 samples/fig5.mci --photons 1e4 -o "$work" --json >"$work/out" 2>"$work/err"
test "$(wc -l <"$work/out")" -eq 1 && grep -q '"ranks":3' "$work/out" || complain "JSON of 3 ranks: $(cat "$work/out")"
ranks 3 samples/fig5.mci --photons 1e4 -o "$work" --verbose >"$work/out" 2>/dev/null
flown=$(awk '/rank  *photons/ { on = 1; next } /all ranks/ { on = 0 } on { sum += $2 } END { print sum }' "$work/out")
test "$flown" = 10000 || complain "the ranks' photons are $flown: $(cat "$work/out")"
test "$(grep -c '^clustermcml' "$work/out")" -eq 1 || complain "more than one banner: $(cat "$work/out")"
ranks 2 check samples/fig5.mci >"$work/out" || complain "check on 2 ranks"
test "$(grep -c fig5.mco "$work/out")" -eq 1 || complain "check spoke twice"

ranks 2 plan samples/fig5.mci --photons 4096 --threads 1 >"$work/out" 2>"$work/err" || complain "plan on 2 ranks: $(cat "$work/err")"
test "$(grep -c ', on 2 ranks of 1 thread$' "$work/out")" -eq 1 || complain "plan on 2 ranks: $(cat "$work/out")"

# A rank may use all cores that it was given, wherever OpenMP bound its main thread.
cores=$(nproc)
(export OMP_PROC_BIND=true OMP_NUM_THREADS="$cores"; unset OMP_PLACES
    ranks 2 samples/fig5.mci --photons 1e4 -o "$work" --json >"$work/out" 2>"$work/err")
grep -q "\"threads\":$cores[,}]" "$work/out" || complain "bound by OpenMP: $(cat "$work/out" "$work/err")"
! grep 'threads on' "$work/err" || complain "bound by OpenMP to $cores cores"
finish
