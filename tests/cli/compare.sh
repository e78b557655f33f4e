#!/bin/sh
# Tests compare: exit codes, words, JSON and picture, for files of this program and for files like those of original MCML.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
warm_python
mkdir "$work/1" "$work/2" "$work/3"
for seed in 1 2; do
    expect_code 0 samples/mcml_sample.mci --photons 2e4 --seed $seed --quiet -o "$work/$seed"
done
sed 's/^1.37 *1 *100/1.37 1 130/; s/^1.37\t1\t100/1.37\t1\t130/' samples/mcml_sample.mci >"$work/other.mci"
expect_code 0 "$work/other.mci" --photons 2e4 --seed 3 --quiet -o "$work/3"
a=$work/1/mcml_sample.mco b=$work/2/mcml_sample.mco c=$work/3/mcml_sample.mco
plain() { sed -e 's/   Last line: # end.*//' -e '/^# clustermcml /,$d' "$1"; } # what original MCML writes: nothing behind Tt_ra
plain "$a" >"$work/plain_a.mco"
plain "$b" >"$work/plain_b.mco"

expect_code 0 compare "$a" "$b"
grep -q '^p = .* no difference at the level 0.01$' "$work/out" || complain "no verdict: $(tail -1 "$work/out")"
grep -q '^A_rz .* at r = [0-9.]* cm, z = [0-9.]* cm' "$work/out" || complain "the place in A_rz: $(grep '^A_rz' "$work/out")"
expect_code 0 compare "$a" "$a"
grep -q '^note: both runs have seed 1: ' "$work/out" || complain "a common seed is not noticed"
expect_code 0 compare "$a" "$work/plain_b.mco"
grep -q 'no standard errors: upper bounds (--sampling random in the other would find more)$' "$work/out" ||
    complain "an even spread lends errors"
sed 's/^# sampling lattice/# sampling random/' "$a" >"$work/random_a.mco"
expect_code 0 compare "$work/random_a.mco" "$work/plain_b.mco"
grep -q 'no standard errors: variances of the other file$' "$work/out" || complain "borrowed errors are not named"
expect_code 0 compare "$work/plain_a.mco" "$work/plain_b.mco"
grep -c 'no standard errors: upper bounds$' "$work/out" | grep -qx 2 || complain "bounds are not named"

expect_code 1 compare "$a" "$c"
grep -q '^note: layer 1: mus = 100 and 130$' "$work/out" || complain "the other layer is not named"
grep -q 'they differ at the level 0.01$' "$work/out" || complain "no verdict: $(tail -1 "$work/out")"
grep -q "^clustermcml: $a and $c differ: p = " "$work/err" || complain "$(cat "$work/err")"
for radius in 0.1 0.2; do
    printf '1.0\n1\nx.h5 B\n300\n0.01 0.01\n3 3 1\nbeam disk %s\n1\n1\n1.4 1 50 0.8 0.1\n1\n' "$radius" >"$work/disk.mci"
    expect_code 0 "$work/disk.mci" --quiet --output "$work/disk$radius.h5"
done
"$program" compare "$work/disk0.1.h5" "$work/disk0.2.h5" >"$work/out" 2>&1
grep -q '^note: beam .* of radius 0.1 cm.* and beam .* of radius 0.2 cm' "$work/out" || complain "beams that differ: $(grep note "$work/out")"
expect_code 1 compare "$work/plain_a.mco" "$c" --quiet
test ! -s "$work/out" || complain "--quiet was not quiet"
expect_code 1 compare "$a" "$c" --json
test "$(wc -l <"$work/out")" -eq 1 && grep -q '^{"a":.*"agree":false' "$work/out" || complain "$(cat "$work/out")"
expect_code 0 compare "$a" "$b" --json --alpha 1e-6
grep -q '"agree":true' "$work/out" || complain "--alpha: $(cat "$work/out")"

# The significance level decides: p of these two files lies between the levels tried.
p=$("$program" compare "$a" "$b" --json | sed 's/.*"p":\([^,]*\),"alpha.*/\1/')
expect_code 1 compare "$a" "$b" --quiet --alpha "$(awk -v p="$p" 'BEGIN { print (1 + p) / 2 }')"

sed 's/0.01\t0.01\t\t# dz, dr/0.01\t0.02\t\t# dz, dr/' "$b" >"$work/wide.mco"
expect_error 2 "$work/wide.mco: dr = 0.02 (expected 0.01, as in $a)" compare "$a" "$work/wide.mco"
expect_code 2 compare "$a"
expect_code 2 compare "$a" "$b" "$c"
expect_error 2 "--alpha 0 (expected a number above 0 and below 1)" compare "$a" "$b" --alpha 0
expect_error 2 "--alpha x (expected a number above 0 and below 1)" compare "$a" "$b" --alpha x
expect_error 2 "--output z.jpg (expected a name that ends in .svg, .png, .pdf or .eps)" compare "$a" "$b" -o z.jpg
expect_code 2 compare "$a" "$work/missing.mco"
expect_code 2 compare "$a" samples/mcml_sample.mci

expect_code 1 compare "$a" "$c" -o "$work/z.svg"
tail -3 "$work/z.svg" | grep -q '</svg>' || complain "the picture has no end"
for name in A_z Rd_r Rd_a Tt_r Tt_a; do
    grep -q "z of $name" "$work/z.svg" || complain "the picture lacks $name"
done
grep -q 'They differ: among [0-9]* tests chance alone makes such a difference with p = ' "$work/z.svg" ||
    complain "the picture has no verdict"
grep -q 'worst z' "$work/z.svg" || complain "the picture does not name what lies beyond its frame"
check_texts
expect_code 5 compare "$a" "$c" -o "$work/missing/z.svg"

# Arrays that only .h5 files have: voxels that differ in a body are listed by their places. Arrays without errors, or with
# other bins, are named.
if "$program" --version | grep -q "HDF5 yes"; then
    for mua in 1 9; do
        mkdir "$work/v$mua"
        printf '1.0\n1\nv.h5 B\n2e4\nmap 8 8 0.05 0.05 volume\nfluence\n0.02 0.05\n10 8 1\n1\n1\n1.4 1 50 0.7 0.2\ni sphere 0.1 0.1 0.1 0.05 1.4 %s 50 0.7\n1\n' $mua >"$work/v$mua/v.mci"
        expect_code 0 "$work/v$mua/v.mci" --seed $mua --quiet -o "$work/v$mua"
    done
    a=$work/v1/v.h5 b=$work/v9/v.h5
    # The sum of a map may differ although each of its pixels is within its noise.
    cp "$a" "$work/bright.h5"
    "$CLUSTERMCML_PYTHON" -c 'import h5py, sys; map = h5py.File(sys.argv[1], "r+")["Rd_xy"]; map[...] = 1.5 * map[...]' "$work/bright.h5"
    expect_code 1 compare "$a" "$work/bright.h5"
    grep -q '^Rd_xy 64 bins in .* at the sum$' "$work/out" || complain "no sum: $(grep Rd_xy "$work/out")"
    expect_code 1 compare "$a" "$b"
    grep -q '^A_xyz 640 bins in [0-9]* tests, worst z -[0-9.]* at z = [0-9.]* cm, y = -*[0-9.]* cm, x = -*[0-9.]* cm' "$work/out" || complain "no voxels: $(grep xyz "$work/out")"
    grep -q '^phi_xyz 640 bins in ' "$work/out" || complain "no fluence of voxels"
    sed 's/8 8 0.05 0.05/8 8 0.06 0.05/' "$work/v1/v.mci" >"$work/other.mci"
    expect_code 0 "$work/other.mci" --seed 3 --quiet -o "$work/3"
    expect_code 0 compare "$a" "$work/3/v.h5"
    grep -q '^note: without errors, or with other bins: A_xyz, Rd_xy, Tt_xy, phi_xyz$' "$work/out" || complain "other voxels are not named: $(grep note "$work/out")"

    # Gates of absorbed light share their noise, because light that stays is in many gates.
    printf '1.0\n1\ngates.h5 B\n1e5\ntime 1000 50\n0.1 0.2\n8 8 1\n1\n1\n1.4 0.1 50 0.8 3\n1\n' >"$work/gates.mci"
    for seed in 1 2 3; do expect_code 0 "$work/gates.mci" --seed $seed --quiet -o "$work/$seed"; done
    for pair in "1 2" "2 3"; do
        expect_code 0 compare "$work/${pair% *}/gates.h5" "$work/${pair#* }/gates.h5"
        grep -q '^A_t   50 bins in ' "$work/out" || complain "no gates: $(cat "$work/out")"
        grep -q ' at $' "$work/out" && complain "a place without words: $(grep ' at $' "$work/out")"
    done
fi

# Absorption was not tallied: the grid is the same in both files, and A_z is not tested because neither file has it.
printf '1.0\n1\nbare.mco A\n2e4\n0.02 0.05\n10 8 1\n1\n1\n1.4 1 50 0.7 0.2\n1\n' >"$work/bare.mci"
sed 's/mco A/h5 B/' "$work/bare.mci" >"$work/binary.mci"
untallied() { # WORDS A B
    expect_code 0 compare "$2" "$3"
    grep -qx "A_z   not tested: $1" "$work/out" && ! grep -q '^note' "$work/out" || complain "expected A_z: $1, got $(cat "$work/out" "$work/err")"
}
expect_code 0 "$work/bare.mci" --seed 1 --quiet -o "$work"
expect_code 0 "$work/bare.mci" --seed 2 --ignore-absorption --quiet -o "$work/2"
expect_code 0 "$work/bare.mci" --seed 3 --ignore-absorption --quiet -o "$work/3"
untallied "b did not tally it" "$work/bare.mco" "$work/2/bare.mco"
untallied "a did not tally it" "$work/2/bare.mco" "$work/bare.mco"
untallied "neither run tallied it" "$work/2/bare.mco" "$work/3/bare.mco"
if "$program" --version | grep -q "HDF5 yes"; then
    expect_code 0 "$work/binary.mci" --seed 3 --ignore-absorption --quiet -o "$work"
    untallied "neither run tallied it" "$work/2/bare.mco" "$work/bare.h5"
fi

# With one packet, quantities that cannot be compared are not mentioned.
printf '1.0\n1\none.mco A\n1\n0.1 0.1\n2 4 2\nbeam pencil angle=45\n1\n1\n1.4 0 10 0.5 0.1\n1\n' >"$work/one.mci"
for seed in 1 5; do # transmitted, reflected
    mkdir "$work/$seed"
    expect_code 0 "$work/one.mci" --seed $seed --quiet -o "$work/$seed"
done
a=$work/1/one.mco b=$work/5/one.mco
expect_error 2 "compare: $a and $b: 1 and 1 packets (expected more packets: no number has enough to be compared)" compare "$a" "$b"

# Numbers that no run writes are refused, because no z can tell them apart.
expect_code 0 samples/thick.mci --photons 1000 --quiet -o "$work"
for number in 1e160 -0.8; do
    awk -v n=$number '/^RAT/ { n_th = NR + 2 } NR == n_th { $0 = n } { print }' "$work/thick.mco" >"$work/odd.mco"
    expect_code 2 compare "$work/thick.mco" "$work/odd.mco"
    grep -q "odd.mco: Rd = .* (expected a number from 0 to 1e+100)$" "$work/err" || complain "Rd of $number: $(cat "$work/out" "$work/err")"
done
finish
