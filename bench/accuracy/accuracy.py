#!/usr/bin/env python3
"""Charts the accuracy that each way to represent a boundary gives for its time:

    accuracy.py [--quick] [--only SCENE,...] [--program PATH] [--out DIR]

By default the program is build/clustermcml and DIR is bench/out. Leaves accuracy.csv, accuracy.txt and, with matplotlib, accuracy/SCENE.svg. --only
selects scenes.

    accuracy.py --draw CSV DIRECTORY

draws a result again, a page for each scene. bench/accuracy/README.md explains the charts.

Every method flies the same photon streams (seed, run, index) as the reference, cones in double precision. Differences are therefore paired, and the
rest of their noise is estimated from independent streams, usually 16. Time is processor time of the flight, so that other programs on the machine
count little.

SPDX-License-Identifier: MIT
"""
import concurrent.futures
import os
import statistics
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import accuracy_chart
import accuracy_scenes
import accuracy_table
import cases
import chart
import command
import runs
import tables

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import cml  # noqa: E402

TRIAL = 100  # packets per run of a trial that measures the speed of the reference
MORE = 24  # factor of packets if noise hides a bias
GROUPS = 10  # groups of radial bins, for the bias of the profile
CORES = 2
TOTALS = ("Rd", "A", "Tt")
LEAST = 1e-2  # share of the light below which totals are left out of the worst relative bias


class Flight:
    """All runs of one method on one scene."""

    def __init__(self, records):
        self.records = records
        self.profiles = [profile(record["output"]) for record in records]

    def sum(self, key):
        return sum(record[key] for record in self.records)


def fly(program, scene, method, photons):
    """Runs a method on a scene. Returns a Flight, or None with a note if the program has no such engine."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, scene.path_of(method), "--json", "--threads", "1", "--photons", str(photons), "-o", out,
                   "--ignore-absorption", "--checkpoint", "off"] + method.options
        lacking = (2, 3) if method.group == "opencl" else ()
        flown = runs.records(command, allowed=(0, 4) + lacking)
        return Flight(flown) if flown else print("skipped " + method.name, file=sys.stderr)


def profile(path):
    """Returns the weight in GROUPS groups of radial bins, first reflected, then transmitted."""
    sections = cml.read_sections(path)
    groups = []
    for key in ("Rd_r", "Tt_r"):
        weights = [value * (2 * i + 1) for i, value in enumerate(sections[key][:-1])]  # times dr^2 pi, which is left out
        size = -(-len(weights) // GROUPS)
        groups += [sum(weights[i:i + size]) for i in range(0, len(weights), size)]
    return groups


def mean_and_error(values):
    return statistics.fmean(values), statistics.stdev(values) / len(values) ** 0.5


def biases(flight, reference):
    """Returns the relative bias of every total and its standard error, from paired differences, and the packets that resolve 1e-4."""
    row, packets = {}, flight.sum("photons")
    worst = (0.0, 0.0, "")
    for key in TOTALS:
        truth = statistics.fmean(record[key] for record in reference.records)
        bias, error = mean_and_error([a[key] - b[key] for a, b in zip(flight.records, reference.records)])
        row["bias_" + key], row["se_" + key] = (bias / truth, error / truth) if truth > 0 else (0.0, 0.0)
        row["packets_1e-4_" + key] = packets * (3 * error / 1e-4) ** 2
        if truth > LEAST and abs(bias) / truth >= abs(worst[0]):
            worst = (bias / truth, error / truth, key)
    row["bias"], row["bias_se"], row["worst"] = worst
    return row


def profile_bias(flight, reference):
    """Returns the relative L2 distance of the profiles without the share of noise, and the distance that noise alone makes."""
    square = noise = 0.0
    for ours, theirs in zip(zip(*flight.profiles), zip(*reference.profiles)):
        bias, error = mean_and_error([a - b for a, b in zip(ours, theirs)])
        square += bias ** 2 - error ** 2
        noise += error ** 2
    norm = sum(statistics.fmean(values) ** 2 for values in zip(*reference.profiles)) ** 0.5
    return {"profile_bias": max(square, 0.0) ** 0.5 / norm, "profile_se": noise ** 0.5 / norm}


def speed(flight, row, reference):
    """Returns ns per step, and the times to an error of 1 % and to the knee, for the total with the largest bias."""
    seconds, packets = flight.sum("cpu_s"), flight.sum("photons")
    key = row["worst"] or "A"
    truth = statistics.fmean(record[key] for record in reference.records)  # a plane may give 0 without any noise
    variance = statistics.fmean((record[key + "_se"] / truth) ** 2 * record["photons"] for record in flight.records)
    rate = packets / seconds
    left = 1e-4 - row["bias"] ** 2
    return {"ns_per_step": 1e9 * seconds / flight.sum("steps"), "packets_per_s": rate, "variance": variance,
            "build_s": statistics.median(sum(b["build_s"] for b in record["boundaries"]) for record in flight.records),
            "s_to_1pc": variance / (rate * left) if left > 0 else float("inf"),
            "knee_s": variance / (rate * row["bias"] ** 2) if row["bias"] else float("inf")}


def row_of(scene, method, flight, reference):
    boundaries = flight.records[0]["boundaries"]
    row = {"scene": scene.name, "method": method.name, "group": method.group, "tolerance": method.tolerance,
           "kinds": "|".join(b["kind"] for b in boundaries), "primitives": sum(b["primitives"] for b in boundaries),
           "packets": flight.sum("photons")}
    row.update(biases(flight, reference))
    row.update(profile_bias(flight, reference))
    row.update(speed(flight, row, reference))
    crossings = flight.sum("crossings")
    row.update(lost=flight.sum("lost"), overruled=flight.sum("shading_overruled"), crossings=crossings,
               failures_per_1e9=1e9 * flight.sum("lost") / crossings, failures_limit=3e9 / crossings)
    deviation = max(b["deviation"] for b in boundaries)
    row.update(deviation=deviation, expected=sum(b["bias"] or 0 for b in boundaries), queries=flight.sum("queries"),
               cpu_s=flight.sum("cpu_s"), steps=flight.sum("steps"))
    row.update(scene.bound(method.group, deviation))
    return row


def photons_for(program, scene, budget):
    """Returns the packets per run with which all runs of the reference take about `budget` processor seconds."""
    trial = fly(program, scene, scene.methods[0], TRIAL)
    return max(TRIAL, int(TRIAL * budget / trial.sum("cpu_s")))


def rows_of(program, scene, methods, photons, pool):
    """Returns the rows of all methods that the program has, each compared with the first."""
    begun = [pool.submit(fly, program, scene, method, photons) for method in methods]
    flights = [(method, future.result()) for method, future in zip(methods, begun)]
    for method, flight in flights:
        if flight and len(flight.records) != len(flights[0][1].records):
            sys.exit("%s, %s: the program ended before its last run; it loses too many packets" % (scene.name, method.name))
    return [row_of(scene, method, flight, flights[0][1]) for method, flight in flights if flight]


def measure(program, scene, budget, pool):
    """Returns the rows of one scene, the reference first. Automatic choices whose bias is hidden by noise are run again, once, with more packets."""
    photons = photons_for(program, scene, budget)
    rows = rows_of(program, scene, scene.methods, photons, pool)
    hidden = [row["method"] for row in accuracy_table.automatic(rows) if not accuracy_table.is_kept(row)]
    if hidden:
        methods = scene.methods[:1] + [method for method in scene.methods if method.name in hidden]
        again = {row["method"]: row for row in rows_of(program, scene, methods, MORE * photons, pool)[1:]}
        rows = [again.get(row["method"], row) for row in rows]
    return rows


def draw(csv, folder):
    """Draws a page for each scene."""
    os.makedirs(folder, exist_ok=True)
    for scene, found, times in accuracy_table.pages(tables.read_csv(csv)[1]):
        accuracy_chart.draw(scene, found, times, os.path.join(folder, scene + ".svg"))


def main():
    parser = command.parser(__doc__, "quick")
    parser.add_argument("--only", default="", metavar="SCENE,...")
    command.instead(parser, "--draw", ("CSV", "DIRECTORY"), draw, "matplotlib")
    arguments = parser.parse_args()
    makers = accuracy_scenes.makers(arguments.quick)
    budget = 0.35 if arguments.quick else 6.0
    begin, rows = time.time(), []
    with tempfile.TemporaryDirectory() as work, concurrent.futures.ThreadPoolExecutor(CORES) as pool:
        for name in command.only(arguments.only, makers, parser):
            print("%4.0f s  %s" % (time.time() - begin, name), file=sys.stderr, flush=True)
            rows += measure(arguments.program, makers[name](work), budget, pool)
    header = tables.machine(arguments.program, accuracy_scenes.RUNS)
    header.append(("length", "quick" if arguments.quick else "full"))
    header.append(("seconds", "%.0f" % (time.time() - begin)))
    if arguments.only:
        header.append(("only", arguments.only))
    accuracy_table.mark_front(rows)
    kept = os.path.join(arguments.out, "accuracy")
    tables.write_csv(kept + ".csv", header, rows)
    tables.keep(kept + ".txt", accuracy_table.lines(header, rows))
    chart.draw_result(draw, kept + ".csv", kept)


if __name__ == "__main__":
    main()
