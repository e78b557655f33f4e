"""Tests expected values of --aim (P15) and flights in windows (P19), against adding-doubling, and under shapes against
counted light. usage: tail.py [long|plain N]

Flat stacks, with the level just below z = 0: N = 10000, z of Tt_expected and of each A_l_expected below the level against
`exact`. The two share the method of responses but not their directions, and the result depends on all flights above the
level; Tt goes down to 3e-9.
The same stacks with --aim Tt_r: N = 20000, z of Rd, A and Tt, which is counted then.
Shapes, bodies, light inside: N = 40000, z of the difference from the counts of a flight with another seed. Rough and tiled
scenes and bodies at the bottom: all totals of flights in windows.
Detectors as aims: N = 5000, against the light of equal detectors on a circle about z with N = 40000 without --aim.
Level 1e-4 over all.
plain N: only N plain photons of rough, tiled and body scenes that are thin and dark, at most 2 us each, against 2e7 in
windows for Tt_r, A_l and a detector: all totals, layers and the detector.
long: 40 more flat stacks at random, and 25 times the photons under shapes; 1e8 plain photons of rough, tiled and body scenes
against 2e7 in windows, half an hour of a processor. Of 400 runs of 1000 photons, 68 +- 5 % must lie within their own error of
the exact value, for Tt and for A of the layer below, and their mean within its own error. In windows the same holds of 400
runs of 4000 for Tt, and of 400 of 1000 for a fibre's light, about their mean."""
import functools
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

# name, layers, index above, index below, beam
FLAT = [
    ("1e-6", ["1.4 0.5 100 0.9 3.2"], 1.0, 1.0, "pencil"),
    ("1e-9", ["1.4 0.5 100 0.9 4.95"], 1.0, 1.0, "pencil angle=50"),
    ("g 0", ["1.5 1 90 0 0.3"], 1.0, 1.2, "disk 0.1"),
    ("dense above", ["1.33 0.3 20 -0.3 0.5"], 1.6, 1.0, "pencil angle=30"),
    ("steps", ["1.53 0.2 300 0.9 0.02", "1.34 0.15 100 0.85 0.1", "1.4 0.7 60 0.8 0.3"], 1.0, 1.4, "pencil"),
    ("clear between", ["1.4 1 80 0.8 0.05", "1.5 0 0 0 0.1", "1.37 2 0 0 0.2", "1.45 0.5 40 0.7 0.1"], 1.0, 1.0, "pencil"),
    ("glass", ["1.5 0 0 0 0.1", "1.4 1 20 0.5 0.4"], 1.0, 1.0, "pencil"),
]
FURROWS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "meshes", "furrows.gsf")
HILL = "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1"
SHAPES = [
    ("hill", {"layers": ["1.4 1 60 0.8 0.4", "1.5 2 20 0.5 0.1"], "surfaces": {0: HILL}}),
    ("bodies", {"layers": ["1.4 1 20 0.8 0.2\ni sphere 0 0 0.1 0.08 1.6 5 10 0", "1.33 3 40 0.8 0.1", "1.4 0 5 0 0.1"]}),
    ("light inside", {"layers": ["1.4 0.5 50 0.8 0.2", "1.4 0.2 20 0.8 0.5"], "extra": ["beam pencil z=0.1 light=isotropic"]}),
    ("two hills", {"layers": ["1.4 1 30 0.8 0.4", "1.6 1 10 0.8 0.5"], "surfaces": {0: HILL, 1: HILL}}),
]


ROUGH = [
    ("rough bottom", {"layers": ["1.4 1 60 0.8 0.8"], "surfaces": {1: HILL}}),
    ("tiled top", {"layers": ["1.4 1 60 0.8 0.5"], "surfaces": {0: f'm "{FURROWS}" tile'}}),
    ("body at the bottom", {"layers": ["1.4 2 40 0.8 0.4", "1.33 1 40 0.8 0.3\ni sphere 0 0 0.55 0.149 1.6 5 10 0"]}),
]


def thin(layers, surfaces=None):
    return {"layers": layers, "surfaces": surfaces or {}, "extra": ["detector disk 0.05 at=0.3,0 name=near"]}


GENTLE = "b 4 0.02 0.1 0.01 0.2 -0.01 0.3 0.01 0.1"
THIN = [
    ("thin, rough", thin(["1.4 8 12 0.5 0.35"], {0: GENTLE}), "Tt_r", "near"),
    ("thin, tiled", thin(["1.4 8 12 0.5 0.35"], {0: f'm "{FURROWS}" tile'}), "Tt_r", "near"),
    ("thin, body", thin(["1.4 8 12 0.5 0.2\ni sphere 0 0 0.1 0.05 1.6 20 10 0", "1.33 10 10 0.5 0.15"]), "Tt_r", "A_l:2", "near"),
]
# name, scene; detectors: number, radius of their circle, shape, options. In a symmetric scene, disks score arcs and squares
# do not.
FIBRES = [
    ("fibre", {"layers": ["1.4 1 60 0.8 0.8"], "surfaces": {0: GENTLE}}, (24, 0.7, "disk 0.04", "")),
    ("fibre below", {"layers": ["1.4 1 60 0.8 0.2", "1.33 0.2 30 0.8 0.2"], "surfaces": {0: GENTLE, 2: HILL}}, (24, 0.6, "rectangle 0.06 0.06", "side=bottom na=0.6")),
]


def by_lot(count):
    dice = random.Random(7)
    for k in range(count):
        layers = [f"{dice.choice([1.33, 1.37, 1.4, 1.5])} {10 ** dice.uniform(-2, 0.5):.4g} {10 ** dice.uniform(0.5, 2.3):.4g} "
                  f"{dice.choice([-0.3, 0, 0.5, 0.8, 0.9])} {10 ** dice.uniform(-1.5, -0.2):.4g}" for _ in range(dice.randint(1, 4))]
        yield (f"lot {k}", layers, dice.choice([1.0, 1.33, 1.5]), dice.choice([1.0, 1.33, 1.5]), f"pencil angle={dice.randint(0, 60)}")


@functools.lru_cache
def exact(text):
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return json.loads(subprocess.run([cml.PROGRAM, "exact", path, "--json"], capture_output=True, text=True,
                                         check=True).stdout)


def fly(verdict, name, text, *options):
    record = cml.run(text, *options)[0]
    cml.check_balance(verdict, name, record)
    return record


def below(record):
    """Returns the layers with an expected value, from 0; their numbers are not counted ones. The level lies in the layer
    above."""
    expected = record.get("A_l_expected_se", [])
    return [l for l in range(1, len(expected)) if expected[l] != record["A_l_se"][l]]


def check_flat(verdict, name, layers, above, below_all, beam):
    text = cml.mci(layers, photons=10000, n_above=above, n_below=below_all, extra=[f"beam {beam}"])
    record, truth = fly(verdict, name, text, "--aim", "Tt", "--seed", 7), exact(text)
    verdict.z(f"{name} Tt", record["Tt_expected"], record["Tt_expected_se"], truth["Tt"], truth["Tt_error"] + 1e-5 * truth["Tt"])
    verdict.check(name, record["Tt_expected_se"] < 0.05 * truth["Tt"], "large error")
    for l in below(record):
        verdict.z(f"{name} A_l {l + 1}", record["A_l_expected"][l], record["A_l_expected_se"][l], truth["A_l"][l],
                  truth["A_l_error"][l] + 1e-5 * truth["A_l"][l])


def check_windows(verdict, name, layers, above, below_all, beam):
    text = cml.mci(layers, photons=10000, n_above=above, n_below=below_all, extra=[f"beam {beam}"])
    record, truth = fly(verdict, f"{name}, windows", text, "--aim", "Tt_r", "--seed", 8, "--photons", 20000), exact(text)
    verdict.check(name, record["unsplit"] == 0, "unsplit")
    for key in ("Rd", "A", "Tt"):
        verdict.z(f"{name}, windows, {key}", record[key], record[key + "_se"], truth[key], truth[key + "_error"])


def check_rough(verdict, name, scene, photons, *options):
    record = fly(verdict, name, cml.mci(photons=min(photons, 20000000), **scene), "--seed", 11, "--aim", "Tt_r", *options)
    plain = fly(verdict, name, cml.mci(photons=photons, **scene), "--seed", 12, *options)
    for key in ("Rd", "A", "Tt"):
        verdict.z(f"{name}, {key}", record[key], record[key + "_se"], plain[key], plain[key + "_se"])


def check_plain(verdict, photons, name, scene, *aims):
    plain = fly(verdict, name, cml.mci(photons=photons, **scene), "--seed", 15, "--ignore-absorption")
    for aim in aims:
        record = fly(verdict, name, cml.mci(photons=min(photons, 20000000), **scene), "--seed", 16, "--aim", aim, "--ignore-absorption")
        for key in ("Rd", "A", "Tt", "detector_near"):
            verdict.z(f"{name}, {aim}, {key}", record[key], record[key + "_se"], plain[key], plain[key + "_se"])
        for l in range(len(plain["A_l"])):
            verdict.z(f"{name}, {aim}, A_l {l + 1}", record["A_l"][l], record["A_l_se"][l], plain["A_l"][l], plain["A_l_se"][l])


def around(count, radius, shape, options):
    """Returns the lines of detectors on a circle about z, named d0, d1 ..."""
    turns = [2 * math.pi * k / count for k in range(count)]
    return [f"detector {shape} at={radius * math.cos(t):.17g},{radius * math.sin(t):.17g} {options} name=d{k}" for k, t in enumerate(turns)]


def check_detector(verdict, name, scene, place, photons, *options):
    """Tests an aim at one of several equal detectors: its light is their mean without --aim, and its error is smaller."""
    count = place[0]
    text = cml.mci(photons=photons, extra=around(*place), **scene)
    record = fly(verdict, name, text, "--seed", 13, "--aim", "d0", "--photons", photons // 8, *options)
    plain = fly(verdict, name, text, "--seed", 14, *options)
    seen = [plain[f"detector_d{k}"] for k in range(count)]
    verdict.z(f"{name}, detector", record["detector_d0"], record["detector_d0_se"], statistics.fmean(seen), statistics.stdev(seen) / count**0.5)
    verdict.check(name, record["detector_d0_se"] < 0.7 * statistics.stdev(seen), "no gain")
    for key in ("Rd", "A", "Tt"):
        verdict.z(f"{name}, {key}", record[key], record[key + "_se"], plain[key], plain[key + "_se"])


def check_shape(verdict, name, scene, photons, *options):
    text = cml.mci(photons=photons, **scene)
    record = fly(verdict, name, text, "--seed", 9, "--aim", "Tt", *options)
    counted = fly(verdict, name, text, "--seed", 10, *options)
    verdict.z(f"{name} Tt", record["Tt_expected"], record["Tt_expected_se"], counted["Tt"], counted["Tt_se"])
    for l in below(record):
        verdict.z(f"{name} A_l {l + 1}", record["A_l_expected"][l], record["A_l_expected_se"][l], counted["A_l"][l], counted["A_l_se"][l])
    verdict.check(name, record["Tt_expected_se"] < record["Tt_se"], "no gain")


def within(verdict, name, records, true):
    inside = sum(abs(record[name] - true) <= record[name + "_se"] for record in records) / len(records)
    print(f"{100 * inside:.1f} % of {len(records)} runs lie within their error of {name} = {true:.3g}")
    verdict.check("coverage", abs(inside - 0.68) <= 0.05, f"{name}: {inside}")
    values = [record[name] for record in records]
    verdict.z(f"mean of runs, {name}", statistics.fmean(values), statistics.stdev(values) / len(values)**0.5, true)


def check_coverage(verdict):
    layers, n = ["1.4 0.5 40 0.8 0.1", "1.4 2 60 0.8 1"], {"n_above": 1.4, "n_below": 1.4}
    truth = exact(cml.mci(layers, **n))
    records = cml.run(cml.repeated(400, layers=layers, photons=1000, **n), "--aim", "Tt", "--seed", 3)
    within(verdict, "Tt_expected", records, truth["Tt"])
    within(verdict, "A_2", [{"A_2": r["A_l_expected"][1], "A_2_se": r["A_l_expected_se"][1]} for r in records], truth["A_l"][1])
    records = cml.run(cml.repeated(400, layers=layers, photons=4000, **n), "--aim", "Tt_r", "--seed", 4)
    within(verdict, "Tt", records, truth["Tt"])
    fibre = {"layers": ["1.4 1 60 0.8 0.8"], "extra": ["detector disk 0.04 at=0.7,0 name=fibre"]}
    records = cml.run(cml.repeated(400, photons=1000, **fibre), "--aim", "fibre", "--seed", 5)
    within(verdict, "detector_fibre", records, statistics.fmean(record["detector_fibre"] for record in records))


def main():
    verdict, long = cml.Verdict("tail"), sys.argv[1:] == ["long"]
    if sys.argv[1:2] == ["plain"]:
        for scene in THIN:
            check_plain(verdict, int(float(sys.argv[2])), *scene)
        verdict.finish()
    for scene in FLAT + list(by_lot(40 if long else 0)):
        check_flat(verdict, *scene)
        check_windows(verdict, *scene)
    for name, scene in ROUGH:
        check_rough(verdict, name, scene, 100000000 if long else 20000)
    for name, scene, place in FIBRES:
        check_detector(verdict, name, scene, place, 1000000 if long else 40000)
    check_rough(verdict, "reference, rough", ROUGH[0][1], 2000, "--engine", "reference")
    for name, scene in SHAPES:
        check_shape(verdict, name, scene, 1000000 if long else 40000)
    check_shape(verdict, "reference", SHAPES[0][1], 4000, "--engine", "reference")
    if long:
        check_coverage(verdict)
    verdict.finish()


main()
