#!/bin/sh
# Tests the bench scripts with wrong arguments: one line, exit code 2, nothing measured or written. Also tests that their kept
# tables and pictures can be made again.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
warm_python

expect_refusal() { # "TEXT" PROGRAM ARGUMENTS...
    text=$1
    shift
    code=0
    "$CLUSTERMCML_PYTHON" -B "$@" >"$work/out" 2>"$work/err" </dev/null || code=$?
    test "$code" -eq 2 || complain "$*: exit $code, not 2"
    test "$(wc -l <"$work/err")" -eq 1 || complain "$*: not one line: $(cat "$work/err")"
    grep -qF -- "$text" "$work/err" || complain "$*: not \"$text\": $(cat "$work/err")"
    test ! -s "$work/out" || complain "$*: wrote to standard output"
}

scripts=0
for script in $(grep -l '^import command$' bench/*/*.py); do
    scripts=$((scripts + 1))
    place=--program good=$program peer= no=" is no program"
    case $script in
    */gpu_static.py) place=--kernels good=kernels no=": no folder of kernels" ;;
    */atlas.py) place=--build good=$(dirname "$program") no="/clustermcml is no program" ;;
    */parts.py | */unbiased.py) place=--build good=$(dirname "$program") no=": no build folder" ;;
    */views.py | */rough_faces.py | */appearance.py) ;;
    bench/peers/*) peer="--mmc $program" ;;
    esac
    expect_refusal "unrecognized arguments: --nonsense word" "$script" $place "$good" $peer --nonsense word
    expect_refusal "$place: expected one argument" "$script" $place
    expect_refusal "$work/none$no" "$script" $place "$work/none"
    "$CLUSTERMCML_PYTHON" -B "$script" --help >"$work/out" || complain "$script --help: exit $?"
    grep -q "$(basename "$script") .*--" "$work/out" || complain "$script --help: no usage: $(cat "$work/out")"
done
# The numbers that summary.py takes from other benches are in the tables kept here.
PYTHONPATH=bench/accuracy:bench/lib "$CLUSTERMCML_PYTHON" -B -c 'import summary
(kept,) = summary.tables.read_csv(summary.kept("accuracy/results/summary-amd-epyc-2core.csv"))[1][-2:-1]
assert kept["method"] == "MMC" and abs(summary.mmc_row()[1] - float(kept["bias"])) < 1e-8, (kept, summary.mmc_row())' ||
    complain "summary.py: reads other numbers of MMC than it did"
test "$scripts" -ge 22 || complain "only $scripts scripts in bench"
expect_refusal "--photons: 1e: not a number" bench/speed/scaling.py --program "$program" --photons 1e
expect_refusal "--rounds: 4: fewer than 5" bench/speed/speed.py --program "$program" --rounds 4
expect_refusal "--seconds: 0: not a number" bench/speed/opencl.py --program "$program" --seconds 0
expect_refusal "--runs: x: not a number" bench/accuracy/unbiased.py --build "$(dirname "$program")" --runs x
expect_refusal "--only S9: no scene; there are S1" bench/choices/roulette.py --program "$program" --only S1,S9
expect_refusal "--runs: 3: fewer than 4" bench/accuracy/body_bias.py --program "$program" --runs 3
expect_refusal "arguments are required: --mmc" bench/peers/mmc.py --program "$program"
expect_refusal "$work/none is no program" bench/peers/mmc.py --program "$program" --mmc "$work/none"
expect_refusal "$work is no program" bench/speed/speed.py --program "$work"
expect_refusal "$work/none is no program" bench/accuracy/frontier.py --program "$program" --mcml "$work/none"
for chart in accuracy/accuracy accuracy/frontier accuracy/roughness accuracy/summary speed/speed; do
    expect_refusal "none.csv: cannot be read" bench/$chart.py --draw none.csv "$work/none.svg"
done
expect_refusal "--draw: expected 2 arguments" bench/accuracy/accuracy.py --draw none.csv
expect_refusal "--draw needs CSV and DIRECTORY and nothing else" bench/accuracy/accuracy.py --draw none.csv "$work/none" --quick
expect_refusal "--only ripples: no scene" bench/accuracy/accuracy.py --only lens,ripples --program "$program" --out "$work/none"
test ! -e "$work/none" || complain "accuracy.py --only ripples: wrote $(ls "$work/none")"

# The table of roughness.py follows from its kept numbers, and its picture has a panel for each.
if "$CLUSTERMCML_PYTHON" -c "import matplotlib" 2>/dev/null; then
    "$CLUSTERMCML_PYTHON" -B bench/accuracy/roughness.py --draw bench/accuracy/results/roughness.csv "$work/rough" >"$work/out" 2>&1 ||
        complain "roughness.py --draw: $(cat "$work/out")"
    cmp "$work/rough/roughness.md" bench/accuracy/results/roughness.md || complain "roughness.py --draw: another table"
    grep -c 'length / mean free path</text>' "$work/rough/roughness.svg" | grep -qx 4 || complain "roughness.py --draw: no four panels"
    "$CLUSTERMCML_PYTHON" tests/lib/svg_text.py "$work/rough/roughness.svg" || complain "roughness.py --draw: texts overlap"
fi

# The charts of a result are a page per scene with three panels, 18 cm wide, in letters of 10 pt (exponents: 7), and small
# enough to keep.
if "$CLUSTERMCML_PYTHON" -c "import matplotlib" 2>/dev/null; then
    csv=bench/accuracy/results/accuracy-amd-epyc-2core.csv
    "$CLUSTERMCML_PYTHON" -B bench/accuracy/accuracy.py --draw $csv "$work/pages" >"$work/out" 2>&1 || complain "accuracy.py --draw: $(cat "$work/out")"
    "$CLUSTERMCML_PYTHON" - $csv "$work"/pages/*.svg <<'END' || complain "accuracy.py --draw: wrong charts"
import csv
import os
import re
import sys
import xml.etree.ElementTree as tree
with open(sys.argv[1]) as file:
    scenes = {row["scene"] for row in csv.DictReader(line for line in file if not line.startswith("#"))}
assert {os.path.basename(path) for path in sys.argv[2:]} == {scene + ".svg" for scene in scenes} and len(scenes) == 15
for path in sys.argv[2:]:
    root = tree.parse(path).getroot()
    texts = ["".join(text.itertext()) for text in root.iter("{http://www.w3.org/2000/svg}text")]
    sizes = [float(size) for size in re.findall(r"font(?:-size)?: ([\d.]+)px", open(path).read())]
    begins = os.path.basename(path)[:-4] + ":", "bias (bars", "total error (noise", "lost packets ("
    assert [sum(text.startswith(words) for text in texts) for words in begins] == [1, 1, 1, 1], (path, texts)
    assert "knee (noise equals bias)" in texts or not path.endswith("hihill.svg"), texts  # the last line of the key
    assert float(root.get("width").removesuffix("pt")) <= 511 and os.path.getsize(path) < 64000, (path, root.get("width"))
    assert sizes and min(sizes) >= 7 and min(size for size in sizes if size != 7) >= 10, (path, sizes)
END

    # The picture has a panel per scene and every mark of the key.
    "$CLUSTERMCML_PYTHON" -B bench/accuracy/frontier.py --draw bench/accuracy/results/frontier-amd-epyc-2core.csv "$work/frontier.svg" >"$work/out" 2>&1 ||
        complain "frontier.py --draw: $(cat "$work/out")"
    "$CLUSTERMCML_PYTHON" - "$work/frontier.svg" <<'END' || complain "frontier.py --draw: wrong chart"
import sys
import xml.etree.ElementTree as tree
text = "".join(tree.parse(sys.argv[1]).getroot().itertext())
counts = [text.count(words) for words in ("core seconds", "original MCML", "S5 (skin7), flat", "hihill", "S2, rough scan on top")]
assert counts == [8, 1, 1, 1, 1], counts
END
fi
finish
