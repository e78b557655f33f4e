#!/bin/sh
# Tests the command furnace: its table, its verdict and its refusals. stat.furnace_command tests that light is even in all
# samples.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
sample=samples/mixed.mci

# Volumes by hand: 0.3 9.1^2 and a pyramid, 0.125 0.5^2 / 3; 0.2 9.1^2 less pi/3 times 0.009075, the sum over the rings of a
# hill.
expect_code 0 furnace $sample --photons 2000
grep -q '^mixed.mco: 2000 photons of diffuse light from above and below, on 9.1 x 9.1 cm, without absorption$' "$work/out" &&
    grep -q '^  layer 3  *24.8534 ' "$work/out" && grep -q '^  layer 1  *16.5525 ' "$work/out" && grep -q '^p = .* (Sidak over 4 tests)$' "$work/out" || complain "$(cat "$work/out")"
expect_code 0 furnace samples/wedge.mci --photons 2000
grep -q '^  layer 1  *2.52733 not tested: clear$' "$work/out" || complain "$(cat "$work/out")"
expect_code 0 furnace $sample --photons 2000 --quiet
test ! -s "$work/out" || complain "quiet: $(cat "$work/out")"

# The verdict is the same for any number of threads and for any options of the scene; a level that no light reaches is named.
expect_code 0 furnace $sample --photons 2000 --json --threads 1
cp "$work/out" "$work/one"
sed "s#\"\.\./meshes#\"$PWD/meshes#; s/^\(90 200 1 .*\)/\1\nfluence\ntime 10 2\nbeam disk 0.1 angle=30/" $sample >"$work/mixed.mci"
expect_code 0 furnace "$work/mixed.mci" --photons 2000 --json --threads 3
sed 's/"scene":"[^"]*"//' "$work/one" >"$work/a"
sed 's/"scene":"[^"]*"//' "$work/out" | cmp -s "$work/a" - || complain "threads or tallies count: $(cat "$work/a" "$work/out")"
expect_code 1 furnace $sample --photons 2000 --quiet --alpha 0.999999
grep -q '^clustermcml: mixed.mco: light is not even: p = .*, z = .* in ' "$work/err" || complain "$(cat "$work/err")"

sed 's/^1.0  *# n below/backing 0.5\n&/' "$work/mixed.mci" >"$work/backed.mci"
line=$(grep -n '^backing' "$work/backed.mci" | cut -d: -f1)
expect_error 2 "$work/backed.mci:$line: a backing (expected none in a furnace: light comes from there)" furnace "$work/backed.mci"
expect_error 2 "mixed.mco: layer 3: mus d = 90000 (expected at most 10000 in a furnace: light would stay for ever)" \
    furnace $sample --set layer3.mus=3e5
expect_error 2 "furnace: --no-reentry does not apply (it belongs to: run, plan, check, trace, crosscheck)" furnace $sample --no-reentry
finish
