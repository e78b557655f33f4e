#!/bin/sh
# Tests what `exact`, `run` and `check` print of totals by adding-doubling. unit.exact and stat.exact judge the numbers.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

shows() { # WHAT PATTERN: a line of standard output
    grep -Eq "$2" "$work/out" || complain "$1: no '$2' in: $(cat "$work/out")"
}

value() { # KEY: of the JSON line
    sed -n "s/.*\"$1\":\([^],}]*\).*/\1/p" "$work/out"
}

# The value of tests/reference/layers.csv for this stack, without its specular part.
expect_code 0 exact samples/mcml_sample.mci
shows "head" '^mcml_sample\.mco \(samples/mcml_sample\.mci:5\): adding-doubling, order [0-9]+$'
shows "Rsp" '^  Rsp  0\.024372875 \+- [0-9]e-16$'
shows "Rd" '^  Rd   0\.2378562[0-9]* \+- [0-9]e-08$'
shows "A" '^  A    0\.6417231'
shows "Tt" '^  Tt   0\.0960477'
shows "layers" '^  A of layer 3 0\.2310313'
test "$(wc -l <"$work/out")" -eq 8 || complain "exact: $(cat "$work/out")"

# Each run of the file has a line.
expect_code 0 exact samples/two_runs.mci --json
test "$(wc -l <"$work/out")" -eq 2 || complain "two runs: $(cat "$work/out")"
expect_code 0 exact samples/mcml_sample.mci --json
for key in Rsp Rd A Tt; do
    awk -v e="$(value ${key}_error)" 'BEGIN { exit !(e > 0 && e <= 1e-7) }' || complain "$key: error $(value ${key}_error)"
done
test "$(value converged)" = true || complain "not converged: $(cat "$work/out")"
awk -v a="$(value Rsp)" -v b="$(value Rd)" -v c="$(value A)" -v d="$(value Tt)" \
    'BEGIN { s = a + b + c + d - 1; exit !(s * s < 1e-24) }' || complain "totals do not add up: $(cat "$work/out")"

# Every shape counts as a plane.
expect_code 0 exact samples/shapes/hihill.mci
shows "hill" '^  boundary 0 counts as a plane$'
shows "hill" '^  boundary 1 counts as a plane$'
expect_code 0 exact samples/shapes/hihill.mci --json
grep -q '"planes":\[0,1\],' "$work/out" || complain "planes: $(cat "$work/out")"
expect_code 0 exact samples/wedge.mci
shows "wedge" 'counts as a plane$'

# A run prints exact totals if its scene is flat; check prints those of the flat twin.
expect_code 0 samples/mcml_sample.mci --photons 1e3 -o "$work"
shows "run" '^  Rd   0\.[0-9]{6} \+- 0\.[0-9]{6}   exact 0\.23[0-9]{5} \+- [0-9.e-]+$'
expect_code 0 samples/mcml_sample.mci --photons 1e3 -o "$work" --json
awk -v a="$(value Rd_exact)" -v e="$(value exact_error)" 'BEGIN { d = a - 0.2378563; exit !(e > 0 && d * d <= (e + 1e-7) ^ 2) }' ||
    complain "run --json: $(cat "$work/out")"
expect_code 0 samples/shapes/hihill.mci --photons 100 -o "$work"
grep -q '   exact 0' "$work/out" && complain "a hill has exact totals: $(cat "$work/out")"
expect_code 0 samples/shapes/hihill.mci --photons 100 -o "$work" --json
test "$(value Rd_exact)" = null || complain "a hill has exact totals: $(cat "$work/out")"
expect_code 0 samples/shapes/hihill.mci --photons 100 --ignore-heightfields -o "$work"
shows "flattened" '^  Tt .*   exact 0\.166'

# A flat field lies at its height, not at its nominal depth: this layer is twice as thick as its line says.
printf '1.0\n1\nx.mco A\n1000\n0.1 0.1\n2 2 1\n1\n1.0\n%s\n1.4 1 10 0.5 %s\n1.0\n' 'b 2  0.1 1  0.1 1' 0.1 >"$work/high.mci"
printf '1.0\n1\nx.mco A\n1000\n0.1 0.1\n2 2 1\n1\n1.0\n1.4 1 10 0.5 0.2\n1.0\n' >"$work/thick.mci"
expect_code 0 exact "$work/thick.mci" --json
thick=$(value Tt)
expect_code 0 "$work/high.mci" -o "$work" --json
awk -v a="$(value Tt_exact)" -v b="$thick" -v e="$(value exact_error)" 'BEGIN { d = a - b; exit !(d * d <= (e + 1e-7) ^ 2) }' ||
    complain "a high flat field: not $thick: $(cat "$work/out")"

# A lamp above this field has the exact totals of light from above, a lamp in it has none. exact and check have planes at z =
# 0 for both.
for z in -0.5 -0.05; do
    sed "4a beam pencil z=$z" "$work/high.mci" >"$work/lamp.mci"
    expect_code 0 "$work/lamp.mci" -o "$work" --json
    if test $z = -0.5; then
        awk -v a="$(value Tt_exact)" -v b="$thick" 'BEGIN { exit !(a > 0 && (a - b) ^ 2 < 1e-12) }' || complain "a lamp at $z: not $thick: $(cat "$work/out")"
    else
        test "$(value Tt_exact)" = null || complain "a lamp at $z has exact totals: $(cat "$work/out")"
    fi
    expect_code 0 exact "$work/lamp.mci" --json
    flat=$(value Tt)
    expect_code 0 check "$work/lamp.mci" --json
    awk -v a="$(value Tt)" -v b="$flat" 'BEGIN { exit !(b > 0 && (a - b) ^ 2 < 1e-12) }' || complain "check of a lamp at $z: not $flat: $(cat "$work/out")"
done

expect_code 0 check samples/shapes/hihill.mci
shows "check" "with planes in place of all shapes, by adding-doubling: Rsp 0\.0170132 Rd 0\.0618193 A 0\.754994[0-9] Tt 0\.1661734"

# No file depends on the exact totals.
"$program" samples/mcml_sample.mci --photons 1e3 -o "$work" --quiet
grep -qi 'exact\b.*adding' "$work/mcml_sample.mco" && complain "exact totals stand in the .mco"

expect_error 2 "usage: clustermcml exact scene.mci (try clustermcml help exact)" exact
expect_code 2 exact "$work/missing.mci"
# Small totals keep their digits in a summary, in check and in rows of a sweep.
printf '1.0\n1\nsmall.mco A\n20000\n0.01 0.01\n20 20 10\n1\n1.0\n1.4 5 100 0.8 0.6\n1.0\n' >"$work/small.mci"
expect_code 0 "$work/small.mci" -o "$work"
shows "summary" '^  Tt .*   exact 1\.2944e-05 \+- [0-9.e-]+$'
expect_code 0 check "$work/small.mci"
shows "check" ' Tt 1\.2944e-05,'
printf 'layer1.mua\n5\n' >"$work/small.csv"
expect_code 0 "$work/small.mci" --sweep "$work/small.csv" -o "$work"
shows "sweep" ' Tt [0-9.]+e-0[56] \+- [0-9.]+e-0[56]$'
finish
