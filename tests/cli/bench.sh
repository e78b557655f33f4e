#!/bin/sh
# What a user of bench/*.sh types wrong: one line, exit code 2, nothing measured or written.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_refusal() { # "TEXT" SCRIPT ARGUMENTS...
    text=$1
    shift
    code=0
    sh "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
    test "$code" -eq 2 || complain "$*: exit $code, not 2"
    test "$(wc -l <"$work/err")" -eq 1 || complain "$*: not one line: $(cat "$work/err")"
    grep -qF -- "$text" "$work/err" || complain "$*: not \"$text\": $(cat "$work/err")"
    test ! -s "$work/out" || complain "$*: wrote to standard output"
}

scripts=0
for script in bench/*.sh; do
    case $script in */lib.sh) continue ;; esac # has no options of its own
    scripts=$((scripts + 1))
    case $script in
    */figure.sh) expect_refusal usage "$script" --nonsense && continue ;;
    */atlas.sh | */parts.sh | */unbiased.sh) place=--build ;;
    *) place=--program ;;
    esac
    expect_refusal "unknown option --nonsense" "$script" --nonsense
    expect_refusal "unknown option --quick;id" "$script" "--quick;id"
    expect_refusal "nonsense: not an option" "$script" nonsense
    expect_refusal "$place needs a value" "$script" "$place"
    expect_refusal "$work/none" "$script" $place "$work/none" # neither a program nor a build folder
    sh "$script" --help >"$work/out" || complain "$script --help: exit $?"
    grep -q "$(basename "$script") .*--" "$work/out" || complain "$script --help: no usage: $(cat "$work/out")"
done
test "$scripts" -ge 8 || complain "only $scripts scripts in bench"
expect_refusal "--photons 1e: not a number" bench/scaling.sh --photons 1e
expect_refusal "--rounds 0: not a number" bench/speed.sh --rounds 0
expect_refusal "--runs x: not a number" bench/unbiased.sh --runs x
expect_refusal "--mmc is missing" bench/mmc.sh --program "$program"
expect_refusal "$work/none is no program" bench/mmc.sh --program "$program" --mmc "$work/none"
expect_refusal "$work is no program" bench/speed.sh --program "$work"
expect_refusal "$work/none is no program" bench/frontier.sh --program "$program" --mcml "$work/none"
for chart in accuracy frontier; do
    expect_refusal "none.csv: cannot be read" bench/$chart.sh --draw none.csv "$work/none.svg"
done
expect_refusal "--only ripples: no scene" bench/accuracy.sh --only lens,ripples --program "$program" --out "$work/none"
test ! -e "$work/none" || complain "accuracy.sh --only ripples: wrote $(ls "$work/none")"

# the chart of a result: three panels per scene, and small enough to keep
if command -v gnuplot >/dev/null; then
    csv=bench/results/accuracy-amd-epyc-2core.csv
    sh bench/accuracy.sh --draw $csv "$work/chart.svg" >"$work/out" 2>&1 || complain "accuracy.sh --draw: $(cat "$work/out")"
    python3 - "$work/chart.svg" <<'END' || complain "accuracy.sh --draw: wrong chart"
import sys
import xml.etree.ElementTree as tree
text = "".join(tree.parse(sys.argv[1]).getroot().itertext())
panels = [text.count(words) for words in (": relative bias", ": total error", ": failures")]
assert panels == [15, 15, 15], panels
END
    test "$(wc -c <"$work/chart.svg")" -lt 300000 || complain "accuracy.sh --draw: $(wc -c <"$work/chart.svg") bytes"

    # a panel per scene, and every mark of the key
    sh bench/frontier.sh --draw bench/results/frontier-intel-xeon-2core.csv "$work/frontier.svg" >"$work/out" 2>&1 ||
        complain "frontier.sh --draw: $(cat "$work/out")"
    python3 - "$work/frontier.svg" <<'END' || complain "frontier.sh --draw: wrong chart"
import sys
import xml.etree.ElementTree as tree
text = "".join(tree.parse(sys.argv[1]).getroot().itertext())
counts = [text.count(words) for words in ("processor seconds", "original MCML", "S5 (skin7), flat", "hihill", "S2, rough scan on top")]
assert counts == [8, 1, 1, 1, 1], counts
END
fi
finish
