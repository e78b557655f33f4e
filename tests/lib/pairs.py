"""Tests that `compare` is honest: runs that differ only in their random numbers may be told apart at a level of 0.05 in at most 5 % of pairs.

This must hold whatever errors the files carry, however few packets they have, and however the packets were drawn.

Scenes: thin (97 % unscattered, which is one bin; few packets elsewhere), dark (weights spread over decades, correlated depth bins), white (almost
no absorption). The first file of a pair comes from a run with defaults (--sampling lattice), the second from a run like original MCML's. Four kinds
of pairs: both files with standard errors, only the first, only the second, none (cut off after Tt_ra, as original MCML writes). Two default runs
with their errors are a fifth kind. Limit: the binomial quantile at 1e-4 for a true rate of 0.05. The second half tests power: a run with mus 1 %
higher must be found."""
import functools
import json
import math
import os
import re
import subprocess
import tempfile

import cml

SCENES = {"thin": (["1.34 0.1 1 0.5 0.1"], "50 100 30", "0.01 0.01"),
          "dark": (["1.4 5 50 0.8 1"], "100 200 10", "0.01 0.005"),
          "white": (["1 0.01 100 0 0.2"], "50 100 20", "0.01 0.01")}
FILES = {"both": (), "first": ("b",), "second": ("a",), "none": ("a", "b")}
AS_MCML = ("--sampling", "random", "--roulette", "mcml")


def fly(keep, tag, layers, bins, grid, photons, runs, seed, *options):
    """Makes `runs` results TAG0.mco, TAG1.mco ... The runs of one file have random numbers of their own."""
    text = cml.repeated(runs, layers, tag, photons=photons, grid=grid, bins=bins)
    cml.run(text, "--seed", seed, *options, keep=keep)


def cut(path, out):
    """Writes the part of a result that original MCML would have written."""
    with open(path, encoding="utf-8") as file, open(out, "w", encoding="utf-8") as plain:
        plain.write(file.read().replace("   Last line: # end", "").split("\n# clustermcml ")[0])


COMPARES = """
import json, sys, clustermcml
for pairs in iter(sys.stdin.readline, ""):
    print(json.dumps([clustermcml.compare(a, b) for a, b in json.loads(pairs)]), flush=True)
"""


@functools.lru_cache(maxsize=None)
def comparer():
    """Returns a process that answers `compare --json`. It lives as long as the test, because starting takes longer than comparing."""
    package = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "python")
    return subprocess.Popen([os.environ.get("CLUSTERMCML_PYTHON", "python3"), "-c", COMPARES], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                            text=True, env={**os.environ, "PYTHONPATH": package})


def compare_all(paths):
    """Returns the answer of `compare --json` for each pair."""
    process = comparer()
    print(json.dumps(paths), file=process.stdin, flush=True)
    return json.loads(process.stdout.readline())


def quantile(n, p, level):
    """Returns the least k that a binomial count exceeds with a probability of at most `level`."""
    tail, k = 1.0, -1
    while tail > level:
        k += 1
        tail -= math.comb(n, k) * p**k * (1 - p)**(n - k)
    return k


def count_alarms(verdict, name, paths):
    """Counts the pairs that `compare` tells apart. paths: of both files of every pair."""
    records = compare_all(paths)
    alarms, tests = sum(record["p"] < 0.05 for record in records), sum(record["tests"] for record in records)
    most = quantile(len(paths), 0.05, 1e-4)
    print(f"{name}: {alarms} alarms in {len(paths)} pairs, {tests / len(paths):.0f} tests each")
    verdict.check(name, alarms <= most, f"{alarms} alarms, expected at most {most}")
    verdict.check(name, tests > 10 * len(paths), f"{tests} tests in {len(paths)} pairs")
    return records


def false_alarms(verdict, scene, photons, pairs):
    """Tests pairs of a scene. photons: numbers for the first and the second file of each pair."""
    layers, bins, grid = SCENES[scene]
    with tempfile.TemporaryDirectory() as keep:
        fly(keep, "a", layers, bins, grid, photons[0], pairs, 11)
        fly(keep, "b", layers, bins, grid, photons[1], pairs, 12, *AS_MCML)
        path = {(tag, i): os.path.join(keep, f"{tag}{i}.mco") for tag in "ab" for i in range(pairs)}
        for name in path.values():
            cut(name, name + ".cut")
        for files, without in FILES.items():
            paths = [[path[tag, i] + (".cut" if tag in without else "") for tag in "ab"] for i in range(pairs)]
            count_alarms(verdict, f"{scene} {photons} errors in {files}", paths)
        count_alarms(verdict, f"{scene} {photons[0]} two lattices", [[path["a", i - 1], path["a", i]] for i in range(1, pairs, 2)])


def false_alarms_of_arrays(verdict, photons, pairs):
    """Tests pairs of .h5 files: voxels, maps, facets, pixels, absorption of bodies, means of detectors, derivatives."""
    asks = ["map 12 12 0.02 0.02 angles volume", "fluence", "facets", "directions 4 6",
            "detector map 8 8 0.05 0.05 na=0.9 name=camera", "detector ring 0.05 0.3 name=far"]
    layers = ["1.4 2 60 0.7 0.1", "1.5 5 90 0.8 0.1\ni sphere 0.02 0 0.15 0.03 1.6 9 40 0.6"]
    with tempfile.TemporaryDirectory() as keep:
        text = cml.repeated(2 * pairs, layers, "a", ".h5", photons=photons, grid="0.02 0.01", bins="10 20 5", extra=asks, surfaces={0: "b 3  0.15 0.02  0.05 0.04  0 0.05"})
        cml.run(re.sub(r"(\.h5) A\n", r"\1 B\n", text), "--seed", 31, "--derivatives", keep=keep)
        paths = [[os.path.join(keep, f"a{i}.h5") for i in (2 * k, 2 * k + 1)] for k in range(pairs)]
        tested = count_alarms(verdict, f"arrays {photons}", paths)[0]["quantities"]
        for name in ("A_xyz", "phi_xyz", "Rd_xya", "detector_camera_map", "boundary0_irradiance_above", "body_exitance_inside", "A_l", "A_body", "detector_far_path", "dRd_dmua"):
            verdict.check("arrays", tested.get(name, {"tests": 0})["tests"] > 0, f"{name} is not tested")


def power(verdict, photons):
    """Tests that `compare` finds 1 % more scattering in a slab of 2 mean free paths, with every kind of file. The unscattered light, which is a bin
    of its own, is 2 % less."""
    layers, bins, grid = ["1.4 0.5 20 0.8 0.1"], "20 100 30", "0.005 0.01"
    with tempfile.TemporaryDirectory() as keep:
        fly(keep, "a", layers, bins, grid, photons, 1, 21)
        fly(keep, "b", [layers[0].replace(" 20 ", " 20.2 ")], bins, grid, photons, 1, 22, *AS_MCML)
        cut(keep + "/a0.mco", keep + "/a0.cut")
        cut(keep + "/b0.mco", keep + "/b0.cut")
        kinds = [("mco", "mco"), ("cut", "mco"), ("mco", "cut"), ("cut", "cut")]
        for (a, b), record in zip(kinds, compare_all([[f"{keep}/a0.{a}", f"{keep}/b0.{b}"] for a, b in kinds])):
            worst = record["worst"][0]
            print(f"mus + 1 %, {photons} packets, {a} against {b}: p = {record['p']:.2g}, z of {worst['quantity']}"
                  f"[{worst['first']}..{worst['last']}] {worst['z']:+.2f}")
            verdict.check(f"power {a} {b}", record["p"] < 1e-3, f"p = {record['p']}")
