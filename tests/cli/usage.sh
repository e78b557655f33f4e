#!/bin/sh
# Options, operands and exit codes of the command line.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
sample=samples/fig5.mci
try="(try clustermcml --help)"

expect_error 2 "usage: clustermcml run scene.mci $try"
expect_error 2 "usage: clustermcml run scene.mci $try" run
expect_error 2 "usage: clustermcml run scene.mci $try" run a.mci b.mci
expect_error 2 "usage: clustermcml trace scene.mci N $try" trace $sample
expect_error 2 "usage: clustermcml check scene.mci $try" check
expect_error 2 "usage: clustermcml mesh scene.mci $try" mesh
expect_error 2 "usage: clustermcml plot a.mco [b.mco ...] or a.map.vti [b.map.vti ...] $try" plot
expect_error 2 "unknown option --fotons $try" $sample --fotons 3
expect_error 2 "unknown option -x $try" -xh
expect_error 2 "unknown option -q $try" $sample -qz -o x
expect_error 2 "unknown option -z $try" $sample -hz
expect_error 2 "-o is missing its value $try" $sample -ho
expect_error 2 "--photons is missing its value $try" $sample --photons
expect_error 2 "--photons 0 (expected a whole number from 1 to 281474976710656)" $sample --photons 0
expect_error 2 "--photons 1.5 (expected a whole number from 1 to 281474976710656)" $sample --photons 1.5
expect_error 2 "--photons many (expected a whole number from 1 to 281474976710656)" $sample --photons many
expect_error 2 "--seed -1 (expected a whole number from 0 to 9007199254740992)" $sample --seed -1
expect_error 2 "--threads 0 (expected a whole number from 1 to 4096)" $sample --threads 0
expect_error 2 "--engine gpu (expected cpu, reference or opencl)" $sample --engine gpu
expect_error 2 "--boundaries round (expected one of plane cone mesh auto)" $sample --boundaries round
expect_error 2 "--tolerance 1 (expected a number from 1e-12 to 0.1)" $sample --tolerance 1
expect_error 2 "--tolerance nan (expected a number from 1e-12 to 0.1)" $sample --tolerance nan
expect_error 2 "--mesh-budget 0 (expected a whole number from 1 to 67108864)" $sample --mesh-budget 0
expect_error 2 "--normals none (expected one of facet vertex analytic)" $sample --normals none
expect_error 2 "--rings wide (expected one of area inscribed)" $sample --rings wide
expect_error 2 "--mesh-search grid (expected one of auto embree)" $sample --mesh-search grid
expect_error 2 "trace: photon x (expected an index from 0)" trace $sample x
expect_code 2 "$work/missing.mci"
expect_code 2 "$work"
expect_code 5 $sample --photons 10 -o "$work/missing"

# Nothing is written, and nothing said on standard output, when the input is wrong.
printf '1.0\n1\nx.mco A\nten\n' >"$work/wrong.mci"
expect_code 2 "$work/wrong.mci" -o "$work"
grep -q "^clustermcml: $work/wrong.mci:4: " "$work/err" || complain "no file and line: $(cat "$work/err")"
test ! -e "$work/x.mco" && test ! -s "$work/out" || complain "a wrong file had results"

expect_code 0 --help
grep -q '^usage: clustermcml ' "$work/out" || complain "--help shows no usage"
for word in run check exact mesh trace plot --photons --seed --threads --boundaries --json --output-dir 'exit codes'; do
    grep -q -e "$word" "$work/out" || complain "--help does not mention $word"
done
expect_code 0 --version
grep -Eq '^clustermcml [0-9]+\.[0-9]+\.[0-9]+( \([^)]*\))?$' "$work/out" || complain "--version: $(cat "$work/out")"

# The command's name may be left out; - is standard input; --json prints one line and nothing else.
expect_code 0 check $sample
expect_code 0 $sample --photons 1e3 --json -o "$work"
test "$(wc -l <"$work/out")" -eq 1 && test ! -s "$work/err" || complain "--json printed more than one line"
cp "$work/fig5.mco" "$work/first.mco"
"$program" - --photons 1e3 --json -o "$work" <$sample >/dev/null || complain "standard input was not read"
sed '/^# User time/d' "$work/first.mco" >"$work/a"
sed '/^# User time/d' "$work/fig5.mco" >"$work/b"
cmp -s "$work/a" "$work/b" || complain "standard input gives another result than the file"
expect_code 0 $sample --photons 1e3 --quiet -o "$work"
test ! -s "$work/out" && test ! -s "$work/err" || complain "--quiet was not quiet"
finish
