#!/bin/sh
# Tests that the light kept by a backing appears wherever totals appear: tables of sweeps, plan, --tolerance. stat.backings
# judges the numbers.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

value() { # KEY FILE: of the JSON line, the first of that name
    grep -o "\"$1\":[^],}]*" "$2" | sed 's/.*://;q'
}
scene() { # NAME BACKING
    printf '1.0\n1\n%s A\n20000\n0.01 0.02\n20 20 10\n1\n1.0\nb 3 0.02 0.1 0.01 0.1 0 1\n1.4 0.5 50 0.8 0.05\nb 3 0.01 0.1 0 0.1 0 1\n%s\n1.0\n' \
        "$1" "$2" >"$work/${1%.*}.mci"
}
scene b.mco "backing 0.7 lambertian"

# A sweep has columns in the .csv and arrays in the .h5, with the values of the rows' files.
mkdir "$work/rows"
printf 'layer1.mua\n0.5\n2\n' >"$work/table.csv"
expect_code 0 "$work/b.mci" --sweep "$work/table.csv" -o "$work/rows" --quiet
test "$(head -1 "$work/rows/b.sweep.csv")" = \
    "row,layer1.mua,photons,seed,Rsp,Rsp_se,Rd,Rd_se,A,A_se,Tt,Tt_se,A_backing,A_backing_se,layer1.A,layer1.A_se,lost,file" ||
    complain "the header: $(head -1 "$work/rows/b.sweep.csv")"
for row in 1 2; do
    for at in 13:A_backing 14:se_A_backing; do
        wanted=$(whole "$work/rows/b-000$row.mco" | awk -v key="${at#*:}" '$1 == key { getline; print $1; exit }')
        found=$(awk -F, -v row=$row -v at="${at%:*}" '$1 == row { printf "%.9G", $at }' "$work/rows/b.sweep.csv")
        awk -v a="$wanted" -v b="$found" 'BEGIN { exit !(a > 0 && (a - b) ^ 2 < 1e-10 * a * a) }' ||
            complain "row $row: ${at#*:} is $found in the table, $wanted in the file"
    done
done
if test -e "$work/rows/b.sweep.h5" && /usr/bin/python3 -c 'import h5py' 2>"$work/err"; then
    /usr/bin/python3 tests/lib/h5_text.py "$work/rows/b.sweep.h5" >"$work/h5"
    grep -q 'A_backing_se' "$work/h5" || complain "the .h5 of the sweep: $(head -30 "$work/h5")"
fi

# check names the backing of the flat scene.
expect_code 0 check "$work/b.mci" --json
grep -q '"flat":{"Rsp":[0-9.e-]*,"Rd":[0-9.]*,"A":[0-9.]*,"Tt":[0-9.e-]*,"A_backing":0\.[0-9]*,"error"' "$work/out" ||
    complain "check --json: $(cat "$work/out")"

# The printed summary has no Tt and no limit of Tt. It lists the light of each detector, and the rows of a sweep with all
# totals.
scene seen.mco "backing 0.5"
sed -i '4s/$/\ndetector disk 0.1\ndetector ring 0.1 0.3 name=far/' "$work/seen.mci"
sed -e '/^b /d' -e '/^detector/d' "$work/seen.mci" >"$work/plain.mci"
expect_code 0 exact "$work/plain.mci"
grep -qx '  Tt   0.000000000 +- 0' "$work/out" || complain "exact: $(cat "$work/out")"
expect_code 0 "$work/seen.mci" -o "$work"
cp "$work/out" "$work/summary"
expect_code 0 "$work/seen.mci" --json -o "$work"
for name in 1 far; do
    seen=$(printf '  detector %s %.6f +- %.6f' $name "$(value detector_$name "$work/out")" "$(value detector_${name}_se "$work/out")")
    grep -qxF "$seen" "$work/summary" || complain "no line $seen: $(cat "$work/summary")"
done
expect_code 0 check "$work/seen.mci"
grep -q '^  detector 1: disk of radius 0.1 cm at (0 0 0) cm, top$' "$work/out" && grep -q '^  detector far: ring of radii 0.1 and 0.3 cm' "$work/out" ||
    complain "detectors of check: $(cat "$work/out")"
printf 'layer1.mua\n0.5\n' >"$work/one.csv"
expect_code 0 "$work/plain.mci" --sweep "$work/one.csv" -o "$work"
grep -Eq 'layer1.mua=0.5  Rsp 0\.[0-9]+ \+- 0\.[0-9]+, Rd 0\.[0-9]+ \+- .*, Tt 0.000000 \+- 0.000000, A_backing 0\.[0-9]+ \+- 0\.[0-9]+$' "$work/out" ||
    complain "the row: $(cat "$work/out")"

# plan: nothing is transmitted, and its estimates of other totals hold to a factor of 1.5.
expect_code 0 plan "$work/b.mci" --photons 4096 --target-error 0.003 --json
grep -q '"Tt":{"photons":null,"seconds":null}' "$work/out" || complain "plan: $(cat "$work/out")"
photons=$(sed 's/.*"engine":"cpu","sampling":"random"[^}]*"Rd":{"photons":\([0-9.e+]*\).*/\1/' "$work/out")
expect_code 0 "$work/b.mci" --sampling random --photons "${photons%.*}" --json -o "$work"
awk -v e="$(value Rd_se "$work/out")" -v v="$(value Rd "$work/out")" 'BEGIN { r = e / v / 0.003; exit !(r > 1 / 1.5 && r < 1.5) }' ||
    complain "plan: $photons photons: $(cat "$work/out")"

# --tolerance tries the backing's shape as a plane.
scene bump.mco "backing 0.1"
sed -i -e 's/^b 3 0.02.*//' -e 's/^1.4 0.5 50 0.8 0.05/1.4 0.01 1 0 0.2/' -e 's/^b 3 0.01.*/b 2 0.15 0.1 0 0.1/' "$work/bump.mci"
expect_code 0 check "$work/bump.mci" --tolerance 0.02
grep -Eq 'boundary 1: cone at .*, as a plane [A-Z][a-z_]* is off by more than 0.02\)' "$work/out" || complain "bump: $(cat "$work/out")"
sed -i 's/^b 2 0.15/b 2 0.0001/' "$work/bump.mci"
expect_code 0 check "$work/bump.mci" --tolerance 0.02
grep -Eq 'boundary 1: plane at .*as a plane [A-Z][a-z_]* is off by at most' "$work/out" || complain "level: $(cat "$work/out")"
finish
