"""Expected values of --aim (P15) against adding-doubling, and under shapes against what is counted. tail.py [long]

Flat stacks, whose level lies just below z = 0: N = 10000, z of Tt_expected and of each A_l_expected below the level
against `exact`, which shares the responses' method but not their directions, and against which all flights above the
level count; down to a Tt of 3e-9. Shapes, bodies, light inside: N = 40000, z of the difference to what a flight with
another seed counts. Level 1e-4 over all. long: 40 more flat stacks, drawn by lot, and 25 times the photons
under shapes; of 400 runs of 1000 photons 68 +- 5 % must lie within their own error of the exact value, for Tt and for A
of the layer below, and their mean within its own."""
import json
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
HILL = "b 4 0.1 0.1 0.08 0.2 -0.02 0.2 -0.1 0.1"
SHAPES = [
    ("hill", {"layers": ["1.4 1 60 0.8 0.4", "1.5 2 20 0.5 0.1"], "surfaces": {0: HILL}}),
    ("bodies", {"layers": ["1.4 1 20 0.8 0.2\ni sphere 0 0 0.1 0.08 1.6 5 10 0", "1.33 3 40 0.8 0.1", "1.4 0 5 0 0.1"]}),
    ("light inside", {"layers": ["1.4 0.5 50 0.8 0.2", "1.4 0.2 20 0.8 0.5"], "extra": ["beam pencil z=0.1 light=isotropic"]}),
    ("two hills", {"layers": ["1.4 1 30 0.8 0.4", "1.6 1 10 0.8 0.5"], "surfaces": {0: HILL, 1: HILL}}),
]


def by_lot(count):
    dice = random.Random(7)
    for k in range(count):
        layers = [f"{dice.choice([1.33, 1.37, 1.4, 1.5])} {10 ** dice.uniform(-2, 0.5):.4g} {10 ** dice.uniform(0.5, 2.3):.4g} "
                  f"{dice.choice([-0.3, 0, 0.5, 0.8, 0.9])} {10 ** dice.uniform(-1.5, -0.2):.4g}" for _ in range(dice.randint(1, 4))]
        yield (f"lot {k}", layers, dice.choice([1.0, 1.33, 1.5]), dice.choice([1.0, 1.33, 1.5]), f"pencil angle={dice.randint(0, 60)}")


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
    """Layers with an expected value, from 0: those whose numbers are not as counted. The level lies in the one above."""
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


def check_shape(verdict, name, scene, photons, *options):
    text = cml.mci(photons=photons, **scene)
    record = fly(verdict, name, text, "--seed", 9, "--aim", "Tt", *options)
    counted = fly(verdict, name, text, "--seed", 10, *options)
    verdict.z(f"{name} Tt", record["Tt_expected"], record["Tt_expected_se"], counted["Tt"], counted["Tt_se"])
    for l in below(record):
        verdict.z(f"{name} A_l {l + 1}", record["A_l_expected"][l], record["A_l_expected_se"][l], counted["A_l"][l], counted["A_l_se"][l])
    verdict.check(name, record["Tt_expected_se"] < record["Tt_se"], "no gain")


def check_coverage(verdict):
    runs, layers = 400, ["1.4 0.5 40 0.8 0.1", "1.4 2 60 0.8 1"]
    records = cml.run(cml.repeated(runs, layers=layers, photons=1000, n_above=1.4, n_below=1.4), "--aim", "Tt", "--seed", 3)
    truth = exact(cml.mci(layers, n_above=1.4, n_below=1.4))
    for name, value, error, true in [("Tt", [r["Tt_expected"] for r in records], [r["Tt_expected_se"] for r in records], truth["Tt"]),
                                     ("A_l", [r["A_l_expected"][1] for r in records], [r["A_l_expected_se"][1] for r in records], truth["A_l"][1])]:
        within = sum(abs(v - true) <= e for v, e in zip(value, error)) / runs
        print(f"{100 * within:.1f} % of {runs} runs lie within their error of {name} = {true:.3g}")
        verdict.check("coverage", abs(within - 0.68) <= 0.05, f"{name}: {within}")
        verdict.z(f"mean of runs, {name}", statistics.fmean(value), statistics.stdev(value) / runs**0.5, true)


def main():
    verdict, long = cml.Verdict("tail"), sys.argv[1:] == ["long"]
    for scene in FLAT + list(by_lot(40 if long else 0)):
        check_flat(verdict, *scene)
    for name, scene in SHAPES:
        check_shape(verdict, name, scene, 1000000 if long else 40000)
    check_shape(verdict, "reference", SHAPES[0][1], 4000, "--engine", "reference")
    if long:
        check_coverage(verdict)
    verdict.finish()


main()
