#!/bin/sh
# Tests options, operands and exit codes of the command line.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
sample=samples/fig5.mci
try="(try clustermcml --help)"

expect_error 2 "no scene (expected clustermcml scene.mci; clustermcml help lists all commands)"
expect_error 2 "usage: clustermcml run scene.mci (try clustermcml help run)" run
expect_error 2 "usage: clustermcml trace scene.mci N (try clustermcml help trace)" trace $sample
expect_error 2 "usage: clustermcml check scene.mci (try clustermcml help check)" check
expect_error 2 "usage: clustermcml mesh scene.mci (try clustermcml help mesh)" mesh
expect_error 2 "plot: the following arguments are required: FILE (try clustermcml plot --help)" plot
expect_error 2 "plot stands behind other words (expected clustermcml plot ...)" -- plot a.mco
expect_error 2 "usage: clustermcml devices (try clustermcml help devices)" devices 1
one="(a file may hold several runs; for several files call it once for each)"
expect_error 2 "run takes one scene, not a.mci and b.mci $one" a.mci b.mci
expect_error 2 "run takes one scene, not a.mci and b.mci $one" run a.mci b.mci
expect_error 2 "check takes one scene, not a.mci and b.mci $one" check a.mci b.mci
expect_error 2 "unknown command chek (did you mean check?)" chek a.mci
expect_error 2 "unknown command cross (did you mean crosscheck?)" cross a.mci
expect_error 2 "unknown command devcies (did you mean devices?)" devcies
expect_error 2 "plann.mci: cannot be read: No such file or directory (expected a file)" plann.mci

# Option names must be written in full; a message proposes the closest one.
expect_error 2 "unknown option --fotons (did you mean --photons?)" $sample --fotons 3
expect_error 2 "unknown option --phot (did you mean --photons?)" $sample --phot 3
expect_error 2 "unknown option --phot (did you mean --photons?)" $sample --phot=3
expect_error 2 "unknown option --r $try" $sample --r 3
expect_error 2 "unknown option --wavelength $try" $sample --wavelength 600
expect_error 2 "--quiet takes no value $try" $sample --quiet=yes
expect_error 2 "unknown option -photons (did you mean --photons?)" $sample -photons 10
expect_error 2 "unknown option -seed=2 (did you mean --seed?)" $sample -seed=2
expect_error 2 "unknown option -x $try" -xh
expect_error 2 "unknown option -q $try" $sample -qz -o x
expect_error 2 "unknown option -z $try" $sample -hz
expect_error 2 "-o is missing its value $try" $sample -ho
expect_error 2 "--photons is missing its value $try" $sample --photons
expect_error 2 "--photons 0 (expected a whole number from 1 to 281474976710656)" $sample --photons 0
expect_error 2 "--photons 1.5 (expected a whole number from 1 to 281474976710656)" $sample --photons 1.5
expect_error 2 "--photons many (expected a whole number from 1 to 281474976710656)" $sample --photons many
expect_error 2 "--seed -1 (expected a whole number from 0 to 9007199254740992)" $sample --seed -1
expect_error 2 '--seed \xff\xc2\x9b31m\xe2\x80\xaeé (expected a whole number from 0 to 9007199254740992)' $sample --seed "$(printf '\377\302\23331m\342\200\256\303\251')"
expect_error 2 "--threads 0 (expected a whole number from 1 to 4096)" $sample --threads 0
expect_error 2 "--engine gpu (expected cpu, reference or opencl)" $sample --engine gpu
expect_error 2 "--boundaries round (expected one of plane cone mesh auto)" $sample --boundaries round
expect_error 2 "--tolerance 1 (expected a number from 1e-12 to 0.1)" $sample --tolerance 1
expect_error 2 "--tolerance nan (expected a number from 1e-12 to 0.1)" $sample --tolerance nan
expect_error 2 "--mesh-budget 0 (expected a whole number from 1 to 67108864)" $sample --mesh-budget 0
expect_error 2 "--normals none (expected one of facet vertex analytic)" $sample --normals none
expect_error 2 "--rings wide (expected one of area inscribed)" $sample --rings wide
expect_error 2 "--mesh-search grid (expected one of auto tree embree)" $sample --mesh-search grid
expect_error 2 "trace: photon x (expected an index from 0)" trace $sample x

# An option belongs to some commands, and some options to one engine only. A command that is not named is run.
belongs() { # COMMAND OPTION OWNERS ARGUMENTS...
    refused="$1: $2 does not apply (it belongs to: $3)"
    shift 3
    expect_error 2 "$refused" "$@"
}
belongs run --run trace $sample --run 2
belongs run --run trace --run 2 run $sample
belongs run --alpha furnace $sample --alpha 0.1 --photons 10 -o "$work"
belongs check --resume run check $sample --resume
belongs check --photons "run, plan, crosscheck, furnace" --photons 3 check $sample
belongs plan -o "run, mesh, merge" plan $sample -o "$work"
belongs plan --output-dir "run, mesh, merge" plan $sample --output-dir "$work"
belongs plan --output run plan $sample --output "$work"
belongs exact --engine "run, check, trace, furnace" exact $sample --engine cpu
belongs devices --json "run, plan, check, exact, crosscheck, furnace, merge" devices --json
only="(it belongs to: opencl)"
expect_error 2 "run: --device does not apply to engine cpu $only" $sample --device 7 --photons 10 -o "$work"
expect_error 2 "run: --group does not apply to engine reference $only" $sample --group 64 --engine reference
expect_error 2 "trace: --build-options does not apply to engine cpu $only" trace $sample 1 --build-options x
expect_error 2 "run: --mesh-search does not apply to engine reference (it belongs to: cpu)" \
    $sample --mesh-search embree --engine reference
test ! -e "$work/fig5.mco" || complain "an option was refused after the run"
# With --help no known option is refused.
expect_code 0 check --resume --help

expect_code 2 "$work/missing.mci"
expect_code 2 "$work"
expect_code 5 $sample --photons 10 -o $sample/missing

printf '\377\3761\0.\0000\0\n\0' >"$work/utf16.mci"
expect_error 2 "$work/utf16.mci: cannot be read: it is UTF-16 (expected a text file in UTF-8)" "$work/utf16.mci"
printf 'v 0 0 0\n' >"$work/mesh.obj"
expect_error 2 "$work/mesh.obj:1: file version = v (expected 1.0; this is a mesh, which an m line of a scene names)" "$work/mesh.obj"
expect_error 2 "run: -o $work/none.mco (expected a folder; --output names the result)" $sample -o "$work/none.mco"

# With wrong input no file is written, and standard output is empty.
printf '1.0\n1\nx.mco A\nten\n' >"$work/wrong.mci"
expect_code 2 "$work/wrong.mci" -o "$work"
grep -q "^clustermcml: $work/wrong.mci:4: " "$work/err" || complain "no file and line: $(cat "$work/err")"
test ! -e "$work/x.mco" && test ! -s "$work/out" || complain "a wrong file had results"

expect_code 0 --help
grep -q '^usage: clustermcml ' "$work/out" || complain "--help shows no usage"
for word in run plan check exact mesh trace crosscheck furnace compare plot view brdf profile devices help options input output recipes 'exit codes' 75; do
    grep -q -e "^ *\\[*$word" "$work/out" || complain "--help does not mention $word"
done
cp "$work/out" "$work/list"
expect_code 0 help
cmp -s "$work/list" "$work/out" || complain "help and --help are two things"

# help COMMAND prints the same as COMMAND --help.
sed -n '/^commands/,/^$/s/^  \[*\([a-z][a-z]*\).*/\1/p' "$work/list" >"$work/commands"
test "$(wc -l <"$work/commands")" -ge 10 || complain "--help lists few commands"
while read -r command; do
    expect_code 0 help "$command"
    cp "$work/out" "$work/text"
    grep -q "^usage: clustermcml $command " "$work/text" || complain "help $command shows no usage"
    grep -A1 '^examples$' "$work/text" | grep -q "^  clustermcml " || complain "help $command has no example"
    case $command in brdf | compare | plot | profile | view) continue ;; esac # the package has their options
    expect_code 0 "$command" --help
    cmp -s "$work/text" "$work/out" || complain "$command --help and help $command are two things"
done <"$work/commands"

# The help of a command lists its options, and no others.
expect_code 0 help exact
test "$(grep -o -e '^  [-a-z, ]*--[a-z-]*' "$work/out" | tr -d '\n')" = \
    "  --set  --tolerance  --mesh-budget  --json  --quiet  -h, --help  --version" || complain "help exact: $(cat "$work/out")"
expect_code 0 help options
test "$(grep -c -e '^  [-a-z, ]*--[a-z-]*' "$work/out")" -ge 35 || complain "help options: $(cat "$work/out")"

# Pages of help are those of the sources, by name, by the last part of it, or by folder.
for page in input/index input/beams output/standard-errors recipes/fit options glossary; do
    last=${page##*/}
    test $last != index || last=${page%/index}
    for name in $page $last; do
        test $name != options || continue # the program's own list
        expect_code 0 help $name
        cmp -s samples/manual/$page.md "$work/out" || complain "help $name is not samples/manual/$page.md"
    done
done
expect_error 2 "fit: a command of the Python package (expected python3 -m clustermcml fit; clustermcml help fit says more)" \
    fit scene.mci measured.csv layer1.mua=1:2 --flights 3
expect_code 0 help keys # a table for each line of a scene
test "$(grep -c '^| key | unit | range | default | meaning |$' "$work/out")" -eq "$(grep -c '^\*\*' "$work/out")" &&
    test "$(grep -c '^| `[^|]* | [^|]* | [^|]* | [^|]* | [^|]* |$' "$work/out")" -gt 100 &&
    grep -q '^| `mua`, `layer1.mua` | 1/cm | 0 to 1e30 | required | ' "$work/out" &&
    grep -q '^| `limit` | - | 1 to 1e9, whole | 1e6 | ' "$work/out" || complain "help keys: $(cat "$work/out")"
# help WORD finds sections of the manual whose heading names the word, rows of tables, and the glossary.
says() { # WORD PATTERN MOST_LINES
    expect_code 0 help -- "$1"
    grep -q -e "$2" "$work/out" && test "$(wc -l <"$work/out")" -le "$3" || complain "help $1: $(cat "$work/out")"
}
for word in beam detector fluence photons m b i rough backing phase; do
    says $word "^## .*\`$word" 120
done
for word in layer1.mua layer12.d detector2.na boundary0.height Rd_r mua g n d light InParm; do
    says $word '^| `' 12
done
for word in fibre wavelength Spectrum roughness BRDF gloss oximetry; do
    says $word "^| .*[a-z].* | \[" 120
done
for option in set aim derivatives more keep resume no-clobber checkpoint; do
    says "--$option" "^  --$option" 90
    test "$(wc -l <"$work/out")" -ge 5 || complain "help --$option: $(cat "$work/out")"
done
expect_error 2 "--aim Tt_r (expected it once, several names with commas)" $sample --aim Tt --aim Tt_r
expect_error 2 "--error-of b (expected it once)" $sample --target-error 0.1 --error-of a --error-of b
for option in aim error-of dump; do # without dashes, where nothing else has that name
    expect_code 0 help "--$option"
    mv "$work/out" "$work/text"
    expect_code 0 help $option
    cmp -s "$work/text" "$work/out" || complain "help $option: $(cat "$work/out")"
done
# Options of the commands that Python does are known, too.
for option in $(grep -oh '("--[a-z][a-z-]*"' src/python/clustermcml/plot.py src/python/clustermcml/view.py src/python/clustermcml/compare.py src/python/clustermcml/brdf.py src/python/clustermcml/profile.py | tr -d '("' | sort -u); do
    expect_code 0 help "$option"
    test "$(grep -c -e "$option" "$work/out")" -ge 1 || complain "help $option: $(cat "$work/out")"
done
expect_code 0 help percentile
grep -q '^| `--percentile P` ' "$work/out" || complain "help percentile: $(cat "$work/out")"
expect_error 2 "unknown option --colour (try clustermcml --help)" help --colour
expect_error 2 "help: no text on \"\" (try clustermcml help)" help ""
expect_error 2 "help: no text on print (try clustermcml help)" help print # a line of an example in Python
expect_error 2 "help: no text on layer1.mux (try clustermcml help)" help layer1.mux
expect_error 2 "unknown option --sett (did you mean --set?)" help --sett
expect_error 2 "help: no text on inputs (did you mean input?)" help inputs
expect_error 2 "help: no text on everything (try clustermcml help)" help everything

# A reader that closes the pipe early is no error.
for words in help --help "help input"; do
    { sleep 0.1; "$program" $words 2>"$work/err"; } | true
    test ! -s "$work/err" || complain "$words without a reader: $(cat "$work/err")"
done

expect_code 0 --version
grep -Eq '^clustermcml [0-9]+\.[0-9]+\.[0-9]+( \([^)]*\))?$' "$work/out" &&
    grep -Eqx 'MPI (yes|no), HDF5 (yes|no), OpenCL (yes|no)' "$work/out" || complain "--version: $(cat "$work/out")"

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
