"""Is `compare` honest? Pairs of runs that differ in nothing but their random numbers must be told apart at a level of
0.05 in at most 5 % of the cases, whatever errors their files carry and however few packets they have.

Scenes: thin (97 % unscattered, which is one bin; few packets elsewhere), dark (weights spread over decades, correlated
depth bins), white (no absorption to speak of). Files: both with standard errors, one without, the other without,
neither (cut off behind Tt_ra, as original MCML writes them). Limit: the binomial quantile at 1e-4 for a true rate of
0.05. The second half, power: a run with mus 1 % higher must be found."""
import json
import math
import os
import subprocess
import tempfile

import cml

SCENES = {"thin": (["1.34 0.1 1 0.5 0.1"], "50 100 30", "0.01 0.01"),
          "dark": (["1.4 5 50 0.8 1"], "100 200 10", "0.01 0.005"),
          "white": (["1 0.01 100 0 0.2"], "50 100 20", "0.01 0.01")}
FILES = {"both": (), "first": ("b",), "second": ("a",), "none": ("a", "b")}


def fly(keep, tag, layers, bins, grid, photons, runs, seed):
    """`runs` results TAG0.mco, TAG1.mco ...: the runs of one file have random numbers of their own."""
    text = ["1.0", str(runs)]
    for i in range(runs):
        scene = cml.mci(layers, name=f"{tag}{i}.mco", photons=photons, grid=grid, bins=bins)
        text.append("\n".join(scene.split("\n")[2:]))
    cml.run("\n".join(text), "--seed", seed, keep=keep)


def cut(path, out):
    """What original MCML would have written."""
    with open(path, encoding="utf-8") as file, open(out, "w", encoding="utf-8") as plain:
        plain.write(file.read().split("\n# clustermcml ")[0])


def compare(a, b):
    done = subprocess.run([cml.PROGRAM, "compare", a, b, "--json"], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def quantile(n, p, level):
    """Least k that a binomial count exceeds with probability `level` at most."""
    tail, k = 1.0, -1
    while tail > level:
        k += 1
        tail -= math.comb(n, k) * p**k * (1 - p)**(n - k)
    return k


def false_alarms(verdict, scene, photons, pairs):
    """photons: of the first and of the second of each pair."""
    layers, bins, grid = SCENES[scene]
    with tempfile.TemporaryDirectory() as keep:
        for tag, number, seed in zip("ab", photons, (11, 12)):
            fly(keep, tag, layers, bins, grid, number, pairs, seed)
        for files, without in FILES.items():
            alarms, tests = 0, 0
            for i in range(pairs):
                paths = {tag: os.path.join(keep, f"{tag}{i}.mco") for tag in "ab"}
                for tag in without:
                    cut(paths[tag], paths[tag] + ".cut")
                    paths[tag] += ".cut"
                record = compare(paths["a"], paths["b"])
                alarms += record["p"] < 0.05
                tests += record["tests"]
            most = quantile(pairs, 0.05, 1e-4)
            print(f"{scene} {photons} errors in {files}: {alarms} alarms in {pairs} pairs, {tests / pairs:.0f} tests each")
            verdict.check(f"{scene} {photons} {files}", alarms <= most, f"{alarms} alarms, expected at most {most}")
            verdict.check(f"{scene} {photons} {files}", tests > 10 * pairs, f"{tests} tests in {pairs} pairs")


def power(verdict, photons):
    """1 % more scattering in a slab of 2 mean free paths: 2 % less unscattered light, which is a bin of its own. Every
    kind of file must show it."""
    layers, bins, grid = ["1.4 0.5 20 0.8 0.1"], "20 100 30", "0.005 0.01"
    with tempfile.TemporaryDirectory() as keep:
        fly(keep, "a", layers, bins, grid, photons, 1, 21)
        fly(keep, "b", [layers[0].replace(" 20 ", " 20.2 ")], bins, grid, photons, 1, 22)
        cut(keep + "/a0.mco", keep + "/a0.cut")
        cut(keep + "/b0.mco", keep + "/b0.cut")
        for a, b in (("mco", "mco"), ("cut", "mco"), ("mco", "cut"), ("cut", "cut")):
            record = compare(f"{keep}/a0.{a}", f"{keep}/b0.{b}")
            worst = record["worst"][0]
            print(f"mus + 1 %, {photons} packets, {a} against {b}: p = {record['p']:.2g}, z of {worst['quantity']}"
                  f"[{worst['first']}..{worst['last']}] {worst['z']:+.2f}")
            verdict.check(f"power {a} {b}", record["p"] < 1e-3, f"p = {record['p']}")
