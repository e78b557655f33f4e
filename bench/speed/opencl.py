#!/usr/bin/env python3
"""Measures the photons per second of the opencl engine:

    opencl.py [--device I] [--seconds S] [--rounds N] [--cpu] [--program PATH]

Prints one row per scene: S1 to S6, the shape flat50, and the hill as plane and as cones. The first run of a scene builds the kernel and is not
timed. The number of photons is then raised until a run takes S seconds (default 2). The median of N runs (default 5) is printed with its least and
most. --cpu times the cpu engine in the same rounds.

SPDX-License-Identifier: MIT
"""
import os
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import runs
import tables

MOST_PHOTONS = 100000000000
CASES = {**{name: [path] for name, path in cases.SCENES.items() if name != "A"}, "flat50": [cases.shape_path("flat50")],
         "flat50-cones": [cases.shape_path("flat50"), "--boundaries", "cone"], "hihill": [cases.shape_path("hihill")],
         "hinoise": [cases.shape_path("hinoise")]}


def calibrate(fly, seconds):
    """Returns the photons of a run that takes about that many seconds, at most MOST_PHOTONS."""
    photons = 10000
    while photons < MOST_PHOTONS:
        took = fly(photons)["seconds"]
        if took >= seconds / 2:
            break
        photons = round(photons * min(20, 1.2 * seconds / took if took > 0 else 20))
    return photons


def spread(values):
    return "%.3g (%.3g-%.3g)" % (statistics.median(values), min(values), max(values))


def row_of_each(arguments, name, scene, work):
    """Returns the cells of every engine."""
    engines = {"opencl": ["--device", arguments.device] if arguments.device else [], **({"cpu": []} if arguments.cpu else {})}

    def fly(engine, photons, *options):
        (record,) = runs.records([arguments.program, *scene, *engines[engine], "--engine", engine, "--photons", str(photons), "--json",
                                  "-o", work, *options], cases.ROOT)
        return record
    photons, flown = {}, {engine: [] for engine in engines}
    for engine in engines:
        fly(engine, 1000)
        photons[engine] = calibrate(lambda n, engine=engine: fly(engine, n), arguments.seconds)
    for seed in range(1, arguments.rounds + 1):
        for engine in engines:
            flown[engine].append(fly(engine, photons[engine], "--seed", str(seed)))
    return [[name, engine, photons[engine], *(spread([record[key] for record in records]) for key in ("photons_per_s", "ns_per_step")),
             sum(record["lost"] for record in records)] for engine, records in flown.items()]


def main():
    parser = command.parser(__doc__, "cpu", seconds=2.0, rounds=5)
    parser.add_argument("--device")
    arguments = parser.parse_args()
    for words in (["--version"], ["devices"]):
        subprocess.run([arguments.program, *words], check=False)
    print("\n" + "\n".join(tables.table(("case", "engine", "photons", "photons/s", "ns/step", "lost"), [])), flush=True)
    with tempfile.TemporaryDirectory() as work:
        for name, scene in CASES.items():
            for row in row_of_each(arguments, name, scene, work):
                print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    main()
