#!/bin/sh
# Tests check --json: one object per run on one line and nothing else. It holds what check prints for people and the totals of
# exact.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_code 0 check samples/two_runs.mci --json
test "$(wc -l <"$work/out")" -eq 2 && test ! -s "$work/err" || complain "not one line per run: $(cat "$work/out" "$work/err")"
cp "$work/out" "$work/two.json"
expect_code 0 exact samples/two_runs.mci --json
cp "$work/out" "$work/exact.json"
expect_code 0 check samples/mixed.mci
cp "$work/out" "$work/mixed.txt"
expect_code 0 check samples/mixed.mci --json
cp "$work/out" "$work/mixed.json"
expect_code 0 check samples/mixed.mci --json --boundaries mesh
cp "$work/out" "$work/mesh.json"
expect_code 0 check samples/skinmap.mci --json
cp "$work/out" "$work/map.json"
# Totals of very many different layers take too long to compute; check says so.
awk 'BEGIN { print "1.0\n1\nmany.mco B\n1e7\n0.1 0.1\n1 1 1\n4000\n1"
             for (i = 0; i < 4000; i++) print 1.3 + i / 1e5, "1 10 0.5 0.01"; print 1 }' >"$work/many.mci"
expect_code 0 check "$work/many.mci"
grep -q '^  no totals of the flat scene: ' "$work/out" || complain "check knows the totals of 4000 layers: $(tail -n 1 "$work/out")"
expect_code 0 check "$work/many.mci" --json
cp "$work/out" "$work/many.json"
printf '1.0\n1\nlit.mco A\n100\nbeam ring 0.1 0.2 at=1,-2 angle=30 azimuth=90\nbeam disk 0.3 z=0.1 light=na:0.5 share=2.5\n1 1\n1 1 1\n1\n1\n1.4 1 9 0.8 1\nbacking metal 0.2 3\n1\n' >"$work/lit.mci"
expect_code 0 check "$work/lit.mci" --json
cp "$work/out" "$work/lit.json"
expect_code 0 run "$work/lit.mci" --photons 9 --json -o "$work"
cp "$work/out" "$work/flown.json"
sed -i 's/metal 0.2 3/0.5 lambertian/' "$work/lit.mci"
expect_code 0 check "$work/lit.mci" --json
cp "$work/out" "$work/white.json"

python3 - "$work" <<'END' || complain "the objects"
import json, math, re, sys
work = sys.argv[1]


def read(name):
    with open(f"{work}/{name}.json") as file:
        return [json.loads(line) for line in file]


for run, exact in zip(read("two"), read("exact")):
    flat = run["flat"]
    for total in "Rsp", "Rd", "A", "Tt":
        assert abs(flat[total] - exact[total]) <= flat["error"] + exact[total + "_error"], (total, run, exact)
    assert flat["error"] < 1e-5 and run["output"] == exact["output"] and run["scene"] == exact["scene"]
assert [(run["output"], run["line"]) for run in read("two")] == [("two_runs_flat.mco", 6), ("two_runs_hill.mco", 16)]

mixed, = read("mixed")
with open(f"{work}/mixed.txt") as file:
    text = file.read()
assert mixed["photons"] == 5e5 and mixed["format"] == "A" and mixed["map"] is None and mixed["facets"] is False
assert (mixed["n_above"], mixed["n_below"]) == (1, 1)
assert mixed["layers"][1] == {"n": 1.33, "mua": 0.1, "mus": 5, "g": 0.5, "d": 0.4, "mean_d": mixed["layers"][1]["mean_d"]} and len(mixed["layers"]) == 3
assert mixed["grid"] == {"dz": 0.01, "dr": 0.01, "nz": 90, "nr": 200, "na": 1}
for b, (kind, reason) in enumerate(re.findall(r"boundary \d: (\w+) at .*?\(([^)]*)\)", text)):
    assert (mixed["boundaries"][b]["kind"], mixed["boundaries"][b]["reason"]) == (kind, reason), b
assert [b["kind"] for b in mixed["boundaries"]] == ["plane", "cone", "mesh", "plane"]
assert [b["primitives"] for b in mixed["boundaries"]] == [1, 4, 4, 1]
heights = [b["mean_height"] for b in mixed["boundaries"]]  # of both shapes, over areas of their own
assert heights[0] == heights[3] == 0 and abs(heights[2] - 1 / 24) < 1e-12 and 0.01 < heights[1] < 0.02
assert [round(l["mean_d"] - l["d"] - b, 12) for l, b in zip(mixed["layers"], (-heights[1], None, heights[2])) if b is not None] == [0, 0]
for key in "build_s", "MiB", "bias", "query_ns", "deviation":
    assert all(key in b for b in mixed["boundaries"])
most = float(re.search(r"memory: at most (\d+) MiB", text).group(1))
assert 0.8 * most < mixed["memory_bytes"] / 2 ** 20 < 1.25 * most, (most, mixed["memory_bytes"])
assert read("mesh")[0]["boundaries"][1]["kind"] == "mesh"
skin, = read("map")
assert skin["map"] == {"nx": 81, "ny": 61, "dx": 0.012, "dy": 0.012, "angles": False, "volume": True} and skin["facets"] is True
assert mixed["backing"] is None and len(mixed["beams"]) == 1 and mixed["beams"][0]["photons"] == 500000
lit, = read("lit")
assert lit["backing"] == {"kind": "metal", "n": 0.2, "k": 3} and read("white")[0]["backing"] == {"kind": "lambertian", "R": 0.5}
first = {"shape": "ring", "size": [0.1, 0.2], "x": 1, "y": -2, "z": None, "angle": 30, "azimuth": 90, "light": "parallel", "na": None,
         "radial": False, "share": 1, "photons": 29, "spread": 0}  # 100 / 3.5 = 28.57: by largest remainder
second = {"shape": "disk", "size": [0.3], "x": 0, "y": 0, "z": 0.1, "angle": 0, "azimuth": 0, "light": "na", "na": 0.5, "radial": False,
          "share": 2.5, "photons": 71}
assert abs(lit["beams"][1].pop("spread") - math.degrees(math.asin(0.5 / 1.4))) < 1e-9  # half the angle of na in layer 1
assert [beam.pop("medium") for beam in lit["beams"]] == [None, "layer 1"] and lit["beams"] == [first, second], lit["beams"]
flown, = read("flown")
assert [beam["photons"] for beam in flown["beams"]] == [3, 6] and flown["backing"] == lit["backing"], flown["beams"]
many, = read("many")
assert many["flat"] is None and many["format"] == "B" and many["photons"] == 10 ** 7 and len(many["layers"]) == 4000
END
finish
