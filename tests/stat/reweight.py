"""Tests rows of a sweep that come from one flight (--reweight). Plane scenes are compared with adding-doubling. Scenes with
rings, a backing, bodies or a beam from the side are compared with flights of each row: totals, absorption in layers and
bodies, and profiles.

N = 2e5 packets a flight. Statistic: z of Rd, A, Tt and of the absorption in layers and bodies, and the sum of squares of z of
the bins of a profile, as a normal deviate; level 1e-4 over all. Errors of rows from one flight are correlated, so every scene
has its own seed."""
import itertools
import math
import os
import re
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS = 200000
FLAT = cml.mci(["1.5 0.5 0 0 0.02", "1.37 0.5 50 0.8 0.05", "1.4 0.2 30 0.9 0.3"], photons=PHOTONS, bins="10 20 5", grid="0.05 0.05")
FLAT_ROWS = ["layer1.mua,layer2.mua,layer3.mua", "0.5,0.5,0.2", "2,1,2", "0.7,5,0.3", "3,0.5,10", "1,20,1"]
PLACES = ("Rd_t", "Tt_t", "A_t", "detector_near_t", "detector_far_t", "Rd_dir", "Tt_dir")
SEEN = ("detector_near", "detector_far", "Rd_t_later", "Tt_t_later", "A_t_later") + tuple(
    f"detector_{name}_{mean}" for name in ("near", "far") for mean in ("path", "interactions", "deepest"))
SURFACE = "b 4 0.05 0.1 0.15 0.05 0.04 0.02 -0.03 0"
ROUGH = cml.mci(["1.4 0.5 20 0.8 0.2", "1.33 0.3 30 0.9 0.4\ni sphere 0.02 0 0.35 0.08 1.5 1 30 0.5"], photons=PHOTONS, bins="10 20 5",
                grid="0.05 0.05", surfaces={0: SURFACE}, n_below=1.5,
                extra=["beam disk 0.2 angle=30", "time 60 12", "directions 3 4", "detector ring 0 0.15 name=near", "detector disk 0.3 na=0.8 at=0.4,0 name=far"])
ROUGH_ROWS = ["layer1.mua,layer2.mua,body1.mua", "0.5,3,20", "3,0.3,1", "6,6,60"]
BACKED = cml.mci(["1.4 0 10 0.5 0.2", "1.33 0.1 20 0.5 0.2\nbacking 0.7 lambertian"], photons=PHOTONS, bins="10 20 5", grid="0.05 0.05",
                 surfaces={1: SURFACE})
BACKED_ROWS = ["layer1.mua,layer2.mua,photons", f"0.2,4,{PHOTONS}", f"2,0.1,{PHOTONS}", f"1,1,{PHOTONS + 1}"]


def settings(rows, row):
    """Returns the options --set of a row."""
    names, values = rows[0].split(","), rows[1 + row].split(",")
    return [word for name, value in zip(names, values, strict=True) for word in ("--set", f"{name}={value}")]


def reweighted(text, rows, keep, *options):
    """Returns the records of the rows, and the sections of each row's file."""
    table = os.path.join(keep, "table.csv")
    with open(table, "w", encoding="utf-8") as file:
        file.write("\n".join(rows) + "\n")
    records = cml.run(text, "--sweep", table, "--reweight", *options, keep=keep)
    return [(record, cml.read_sections(record["output"])) for record in records]


def absorbed(sections):
    """Returns a list of (name, value, error) of the absorption in each layer and body."""
    return [(f"{key} {i + 1}", value, error) for key in ("A_l", "A_body") if key in sections
            for i, (value, error) in enumerate(zip(sections[key], sections["se_" + key], strict=True))]


def against_exact(verdict):
    with tempfile.TemporaryDirectory() as keep:
        for i, (record, sections) in enumerate(reweighted(FLAT, FLAT_ROWS, keep, "--seed", 7)):
            truth = cml.exact(FLAT, *settings(FLAT_ROWS, i))
            cml.check_balance(verdict, f"flat {i + 1}", record)
            for key in ("Rd", "A", "Tt"):
                verdict.z(f"flat {i + 1} {key}", record[key], record[key + "_se"], truth[key], truth[key + "_error"])
            for (name, value, error), layer in zip(absorbed(sections), truth["A_l"], strict=True):
                verdict.z(f"flat {i + 1} {name}", value, error, layer)
            own = cml.run(FLAT, "--seed", 8, *settings(FLAT_ROWS, i), keep=keep)[0]
            verdict.check(f"flat {i + 1}", record["Rd_se"] < 1.4 * own["Rd_se"], f"{record['Rd_se']} and {own['Rd_se']}")
            depths_z(verdict, f"flat {i + 1}", record, sections, cml.read_sections(own["output"]))


def profile_z(verdict, name, ours, theirs, key):
    """Compares a profile: the bins with noise on both sides, together, as a chi square that is converted to a normal deviate
    (Wilson and Hilferty)."""
    squares = [(a - b) ** 2 / (x * x + y * y) for a, b, x, y in
               zip(ours[key], theirs[key], ours["se_" + key], theirs["se_" + key], strict=True)
               if x > 0 and y > 0 and a > 5 * x]
    n = len(squares)
    verdict.check(name, n >= 3, f"{key}: {n} bins")
    cube, spread = (sum(squares) / n) ** (1 / 3), (2 / (9 * n)) ** 0.5
    verdict.z(f"{name} {key}", cube, spread, 1 - spread * spread)


def read_A_rz(path):
    with open(path, encoding="utf-8") as file:
        body = re.split(r"^A_rz.*$", file.read(), maxsplit=1, flags=re.MULTILINE)[1]
    return [float(word) for word in itertools.takewhile(lambda word: not word[0].isalpha() and word[0] != "#", body.split())]


def depths_z(verdict, name, record, ours, theirs):
    """Compares A(z), and A(r,z) by its sums over 20 radii for each of 10 depths, all 0.05 cm apart."""
    profile_z(verdict, name, ours, theirs, "A_z")
    grid = read_A_rz(record["output"])
    by_depth = [2 * math.pi * 0.05 ** 2 * sum((k + 0.5) * grid[k * 10 + j] for k in range(20)) for j in range(10)]
    worst = max(abs(a / b - 1) for a, b in zip(by_depth, ours["A_z"], strict=True) if b)
    verdict.check(f"{name} A_rz", worst < 1e-4, f"sums over r differ from A_z by {worst}")
    errors = [b / a for a, b in zip(theirs["se_A_z"], ours["se_A_z"], strict=True) if a > 0]
    print(f"{name}: errors of A_z {statistics.median(errors):.2f} times those of a flight of its own")


def against_own(verdict, name, text, rows, seed):
    with tempfile.TemporaryDirectory() as keep, tempfile.TemporaryDirectory() as other:
        for i, (record, sections) in enumerate(reweighted(text, rows, keep, "--seed", seed)):
            own = cml.run(text, "--seed", seed + 100 + i, *settings(rows, i), keep=other)[0]
            theirs = cml.read_sections(own["output"])
            cml.check_balance(verdict, f"{name} {i + 1}", record)
            for key in ("Rsp", "Rd", "A", "Tt", "A_backing"):
                if record.get(key):
                    verdict.z(f"{name} {i + 1} {key}", record[key], record[key + "_se"], own[key], own[key + "_se"])
            for (what, value, error), (_, truth, truth_error) in zip(absorbed(sections), absorbed(theirs), strict=True):
                verdict.z(f"{name} {i + 1} {what}", value, error, truth, truth_error)
            for key in SEEN if SEEN[0] in theirs else ():
                for k, (value, error, truth, truth_error) in enumerate(
                        zip(*(one[before + key] for one in (sections, theirs) for before in ("", "se_")), strict=True)):
                    if error or truth_error:  # without errors there is no light in this medium, and nothing to compare
                        verdict.z(f"{name} {i + 1} {key} {k}", value, error, truth, truth_error)
            depths_z(verdict, f"{name} {i + 1}", record, sections, theirs)
            for key in ("Rd_r", "Rd_a") + (("Tt_r", "Tt_a") if record["Tt"] else ()) + (PLACES if PLACES[0] in theirs else ()):
                profile_z(verdict, f"{name} {i + 1}", sections, theirs, key)


def main():
    verdict = cml.Verdict("reweight")
    against_exact(verdict)
    against_own(verdict, "rough", ROUGH, ROUGH_ROWS, 11)
    against_own(verdict, "backed", BACKED, BACKED_ROWS, 13)
    verdict.finish()


main()
