#!/usr/bin/env python3
"""Tests if results are unbiased, and if their errors are true:

    unbiased.py [--runs N] [--photons N] [--reference N] [--scene NAME] [--build DIR] [--out DIR]

Makes N (2000) independent runs of N (1e4) photons of S1 to S6a, three shapes and a rough scan, with the program in build/ and its defaults. Means
are compared with adding-doubling and with stored profiles if tests/reference has them, else with N (1e8) photons of random sampling and MCML's
roulette. The shares of runs within one and two of their own errors are counted there, and in as many runs of 1000 and 12345 photons. Leaves
unbiased.md, a row per scene, unbiased-sizes.md, a row per size of runs, with the verdict, and a CSV of every scene in bench/out. Exit code 1 if a
mean or an error is wrong.

    unbiased.py --table OUT

only reads the results in OUT.

SPDX-License-Identifier: MIT
"""
import csv
import io
import math
import os
import statistics
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

SCENES = {**{name: cases.SCENES[name] for name in ("S1", "S2", "S3", "S4", "S5", "S6a")},
          **{name: f"samples/shapes/{name}.mci" for name in ("hihill", "hicrater", "lonoise")}, "scan": "samples/scan.mci"}
OTHER_PHOTONS = (1000, 12345)  # numbers of photons of further runs, for the coverage of errors
STORED = ("S1", "S2", "S3")  # profiles of tests/reference, from 1.2e8 photons and more of original MCML's transport code
STORED_DR, STORED_BINS = 0.005, 200
LEVEL = 1e-4  # probability that honest results fail, for each of the two kinds of test
PACKETS = 300  # packets in a run below which a bin's error, from 64 batches, is not judged
WITHIN = (0.679, 0.950)  # shares of Student deviates with 63 degrees of freedom within 1 and 2
ALLOWED = (0.03, 0.02)


def sidak(tests, level=LEVEL):
    return statistics.NormalDist().inv_cdf(1 + math.expm1(math.log1p(-level) / tests) / 2)


def tail_of_squares(squares, number, independent):
    """Returns the probability that `number` unit deviates, worth `independent` ones, have a larger sum of squares (Wilson-Hilferty)."""
    spread = 2 / (9 * independent)
    return statistics.NormalDist().cdf(-((squares / number) ** (1 / 3) - 1 + spread) / math.sqrt(spread))


def write_scene(name, work):
    """Writes the sample with at least 20 depth bins and with 10 angle bins, into any folder."""
    source = os.path.join(cases.ROOT, SCENES[name])
    lines = [line.replace('m "', f'm "{os.path.dirname(source)}/') for line in cases.lines_of(source)]
    (dz, dr), (nz, nr, _) = (lines[i].split() for i in (4, 5))
    factor = max(1, math.ceil(20 / int(nz)))
    lines[4:6] = [f"{float(dz) / factor} {dr}", f"{factor * int(nz)} {nr} 10"]
    path = os.path.join(work, name + ".mci")
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines) + "\n")
    return path


def put_stored(name, rows):
    """Puts radial profiles of tests/reference, as weight per packet, in place of those simulated here."""
    table = cases.rows_of(f"profiles/{name}.csv")
    rings = [2 * math.pi * (i + 0.5) * STORED_DR**2 for i in range(STORED_BINS)]
    for row in rows:
        if row["quantity"] not in ("Rd_r", "Tt_r"):
            continue
        bins = range(int(row["first"]), int(row["last"]) + 1)
        row["reference"] = sum(float(table[i][row["quantity"]]) * rings[i] for i in bins)
        row["reference_error"] = math.hypot(*(float(table[i][row["quantity"] + "_sem"]) * rings[i] for i in bins))


def fly(program, path, runs, photons, reference):
    """Returns rows of bench_unbiased: numbers except for the first column, None in empty columns."""
    done = subprocess.run([program, path, str(runs), str(photons), str(reference)], capture_output=True, text=True,
                          check=False)
    if done.returncode:
        sys.exit(done.stderr.strip())
    return [{key: value if key == "quantity" else float(value) if value else None for key, value in row.items()}
            for row in csv.DictReader(io.StringIO(done.stdout))]


def score(row):
    """Returns the deviate of a row against its reference."""
    spread = math.hypot(row["mean_error"], row["reference_error"])
    return (row["mean"] - row["reference"]) / spread if spread > 0 else 0.0


def fly_scene(name, program, out, runs, photons, reference):
    """Writes the rows of all runs of a scene into OUT, with the best available reference."""
    path = write_scene(name, out)
    exact = cases.exact_of(cases.lines_of(path)) or {}
    rows = []
    for n in (photons, *OTHER_PHOTONS):
        for row in fly(program, path, runs, n, round(reference / 1e5) if n == photons else 0):
            rows.append({"runs": runs, "photons": n, "referred": int(n == photons), "exact": int(bool(exact)), **row})
    for row in rows:
        if row["quantity"] in exact:
            row["reference"], row["reference_error"] = exact[row["quantity"]], 1e-6
    if name in STORED:
        put_stored(name, rows)
    with open(os.path.join(out, f"unbiased-{name}.csv"), "w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def judge_means(rows):
    """Returns cells of a scene for the table, and True if all means agree with the reference."""
    judged = [row for row in rows if row["referred"] and row["mean_error"] > 0]
    worst = max(judged, key=lambda row: abs(score(row)))
    tails = {}
    for quantity in {row["quantity"] for row in judged}:
        scores = [score(row) for row in judged if row["quantity"] == quantity]
        numbers = next(row["independent"] for row in judged if row["quantity"] == quantity)
        if len(scores) > 1:
            tails[quantity] = tail_of_squares(sum(z * z for z in scores), len(scores), numbers)
    least = min(tails, key=tails.get)
    limit = sidak(len(judged))
    totals = max(abs(score(row)) for row in judged if "_" not in row["quantity"])
    good = abs(score(worst)) <= limit and totals <= 4 and tails[least] >= LEVEL / len(tails)
    place = worst["quantity"] + (f"[{worst['first']:.0f}]" if "_" in worst["quantity"] else "")
    return ["yes" if worst["exact"] else "", len(judged), f"{totals:.2f}", f"{score(worst):+.2f} of {place}", f"{limit:.2f}",
            f"{tails[least]:.2g} of {least}"], good


def spread_of(shares):
    return f"{100 * statistics.fmean(shares):.1f} ({100 * min(shares):.1f} to {100 * max(shares):.1f})" if shares else ""


def judge_errors(rows):
    """Returns cells for runs of one size: the short cell, those of the long table, and True if errors are true. A single share may be off by
    chance: by three of its own standard deviations more than the mean."""
    good, cells, every = True, [], []
    for profile in (False, True):
        kind = [row for row in rows if row["reported"] is not None and row["packets"] >= PACKETS
                and ("_" in row["quantity"]) == profile]
        every += kind
        cells.append(len(kind))
        for key, share, allowed in zip(("within_1", "within_2"), WITHIN, ALLOWED):
            shares = [row[key] for row in kind]
            cells.append(spread_of(shares))
            chance = 3 * math.sqrt(share * (1 - share) / rows[0]["runs"])
            good &= all(abs(x - share) <= allowed + chance for x in shares)
            good &= not shares or abs(statistics.fmean(shares) - share) <= allowed
    means = [f"{100 * statistics.fmean(row[key] for row in every):.1f}" for key in ("within_1", "within_2")]
    return ", ".join(means) + f" of {len(every)}", cells, good


def read_scene(out, name):
    with open(os.path.join(out, f"unbiased-{name}.csv"), encoding="utf-8") as stream:
        return [{key: value if key == "quantity" else float(value) if value else None for key, value in row.items()}
                for row in csv.DictReader(stream)]


def judged(out, names):
    """Returns lines of the short table and of the long one, and the names of failures."""
    short, long, failed = [], [], []
    for name in names:
        rows = read_scene(out, name)
        means, fine = judge_means(rows)
        sizes = sorted({row["photons"] for row in rows})
        errors = [judge_errors([row for row in rows if row["photons"] == size]) for size in sizes]
        short.append([name, *means, *(cell for cell, _, _ in errors)])
        long += [[name, f"{size:.0f}", *cells] for size, (_, cells, _) in zip(sizes, errors)]
        failed += [f"means of {name}"] * (not fine) + [f"errors of {name}"] * (not all(good for _, _, good in errors))
    heads = ["scene", "exact totals", "numbers", "totals", "worst of all", "limit", "least p of a profile"]
    first = list(tables.table([*heads, *(f"errors at {size:.0f}" for size in sizes)], short))
    second = list(tables.table(["scene", "photons", "totals", "within 1", "within 2", "bins", "within 1", "within 2"], long))
    return first, second, failed


def judge(out, names=SCENES):
    """Judges the scenes whose results are in OUT."""
    names = [name for name in names if os.path.exists(os.path.join(out, f"unbiased-{name}.csv"))]
    first, second, failed = judged(out, names)
    rows = read_scene(out, names[0])
    tables.keep(os.path.join(out, "unbiased.md"), [
        f"Measured: {time.strftime('%Y-%m-%d')}; {rows[0]['runs']:.0f} runs of {rows[0]['photons']:.0f} photons of each scene.", "", *first])
    tables.keep(os.path.join(out, "unbiased-sizes.md"), [*second, "", "Wrong: " + (", ".join(failed) or "nothing")])
    sys.exit(1 if failed else 0)


def main():
    parser = command.parser(__doc__, place=command.BUILD, runs=2000, photons=10000, reference=100000000)
    parser.add_argument("--scene", choices=SCENES, metavar="NAME")
    command.instead(parser, "--table", ("OUT",), judge)
    arguments = parser.parse_args()
    command.build(parser, arguments.build, "bench_unbiased")
    os.makedirs(arguments.out, exist_ok=True)
    names = [arguments.scene] if arguments.scene else list(SCENES)
    for name in names:
        fly_scene(name, os.path.join(arguments.build, "bench_unbiased"), arguments.out, arguments.runs, arguments.photons, arguments.reference)
    judge(arguments.out, names)


main()
