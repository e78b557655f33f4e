#!/bin/sh
# Tests a line `phase` of a scene: its description in results and `check`, and a hint where the #@ mark is missing. A run
# whose table was changed is not continued. Rows of a sweep have the bytes of runs with --set. Results do not depend on the
# number of threads.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
mkdir "$work/a" "$work/b"
scene() { # OUTPUT PHASE
    printf '1.0\n1\n%s A\n20000\n0.01 0.02\n20 20 10\n2\n1.0\n1.4 1 50 0.8 0.1\n%s\n1.4 1 20 0.5 0.1\n1.0\n' "$1" "$2"
}
table() { # PEAK: a density of mean cosine 0.8 but for 1e-3
    awk -v k="$1" 'BEGIN { for (i = 0; i <= 720; i++) { t = 180 * (i / 720) ^ 2
        printf "%.9f %.9g\n", t, k * (1.64 - 1.6 * cos(t * 3.14159265358979 / 180)) ^ -1.5 } }'
}
scene p.mco 'phase gk 0.8 0.5' >"$work/gk.mci"
scene p.mco 'phase hg2 0.8 0.8 0.25' >"$work/hg2.mci"
scene p.mco 'phase table "t.txt"' >"$work/table.mci"
table 1 >"$work/t.txt"

# One function written in three ways gives the same light, in other digits.
for kind in gk hg2 table; do
    expect_code 0 "$work/$kind.mci" --json -o "$work/a" --threads 1
    sed 's/.*"Rd":\(0\.[0-9]\{3\}\).*/\1/' "$work/out" >>"$work/Rd"
done
test "$(sort -u "$work/Rd" | wc -l)" -eq 1 || complain "Rd: $(cat "$work/Rd")"

# Descriptions of the phase function in results and check.
expect_code 0 "$work/gk.mci" --quiet -o "$work/a"
grep -qx '# phase of layer 1: gk 0.8 0.5' "$work/a/p.mco" || complain "the .mco: $(grep phase "$work/a/p.mco")"
expect_code 0 check "$work/table.mci"
grep -qx "  phase of layer 1: table of 721 rows from $work/t.txt" "$work/out" || complain "check: $(grep phase "$work/out")"
expect_code 0 check "$work/hg2.mci" --json
grep -q '"d":0.1[0-9]*,"mean_d":0.1[0-9]*,"phase":"hg2 0.8 0.8 0.25"},{"n":1.3[^}]*"mean_d":0.1[0-9]*}\]' "$work/out" || complain "check --json: $(cat "$work/out")"
expect_code 0 trace "$work/gk.mci" 3
grep -qx '# phase of layer 1: gk 0.8 0.5' "$work/out" || complain "trace: $(head -3 "$work/out")"

# Bytes do not depend on threads.
sed '/^# User time/d' "$work/a/p.mco" >"$work/two"
expect_code 0 "$work/gk.mci" --quiet -o "$work/a" --threads 1 --chunk 100
sed '/^# User time/d' "$work/a/p.mco" | cmp -s - "$work/two" || complain "one thread, other bytes"

# A changed table makes another run.
expect_code 0 "$work/table.mci" --quiet --keep -o "$work/b"
table 2 >"$work/t.txt"
expect_code 2 "$work/table.mci" --quiet --more 100 -o "$work/b"
grep -q 't.txt' "$work/err" || complain "a changed table: $(cat "$work/err")"

# Sweeps and --set; both numbers must fit.
printf 'layer1.g,layer1.phase.g1,layer1.phase.w\n0.5,0.4,0.75\n0.65,0.2,0.25\n' >"$work/rows.csv"
expect_code 0 "$work/hg2.mci" --quiet --sweep "$work/rows.csv" -o "$work/a"
expect_code 0 "$work/hg2.mci" --quiet --set layer1.g=0.65 --set layer1.phase.g1=0.2 --set layer1.phase.w=0.25 -o "$work/b"
for file in "$work/a/p-0002.mco" "$work/b/p.mco"; do sed -e '/^# User time/d' -e 's/^[^ ]* \tA\t/NAME /' "$file" >"$file.bare"; done
cmp -s "$work/a/p-0002.mco.bare" "$work/b/p.mco.bare" || complain "a row is not the run with --set: $(diff "$work/a/p-0002.mco.bare" "$work/b/p.mco.bare" | head -4)"
expect_error 2 "$work/hg2.mci:10: layer 1: phase: mean cosine = 0.65 (expected the medium's g = 0.8 to 1e-3)" \
    "$work/hg2.mci" --set layer1.phase.g1=0.2 --quiet -o "$work/b"
expect_error 2 "--set: layer1.phase.a = 1 (expected a name that the run in line 3 knows: photons, above.n, below.n, layer1 with .n .mua .mus .g .d .phase.g1 .phase.g2 .phase.w, layer2 with .n .mua .mus .g .d, beam with .x .y .angle .azimuth)" \
    "$work/hg2.mci" --set layer1.phase.a=1 --quiet -o "$work/b"

scene p.mco '#phase rayleigh' >"$work/hint.mci"
expect_code 0 check "$work/hint.mci"
grep -q 'a comment: #phase rayleigh (did you mean #@ phase rayleigh?)' "$work/err" || complain "no hint: $(cat "$work/err")"
finish
