"""Where the time below curved boundaries goes: curved.py BENCH_CURVED DIRECTORY

Makes the curved tops of speed.py in DIRECTORY, has bench_curved take the parts of each, ROUNDS times, one after the other, and
prints the fastest run of each as CSV: ns per photon.

SPDX-License-Identifier: MIT
"""
import csv
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases

MEDIA = ("S2", "S6a")
TRIANGLES = ("1e3", "1e5", "3e5")
ROUNDS = 5


def tops(medium, directory):
    """The curved tops of speed.py that are flown as cones or walked as a mesh, without the largest."""
    found = [cases.level_case(medium, directory)]
    found += cases.rough_cases(medium, TRIANGLES, cases.AMPLITUDE, directory) + cases.ring_cases(medium, directory)
    return [case for case in found if "embree" not in case.options and (case.surface != "rings" or "cone" in case.options)]


def measure(bench, case):
    kind = "cone" if case.surface == "rings" else "mesh"
    out = subprocess.run([bench, case.path, kind], capture_output=True, check=True, text=True).stdout
    return list(csv.DictReader(out.splitlines()))[0]


def main():
    bench, directory = sys.argv[1:]
    todo = [case for medium in MEDIA for case in tops(medium, directory)]
    runs = [[] for _ in todo]
    for _ in range(ROUNDS):
        for case, of_case in zip(todo, runs):
            of_case.append(measure(bench, case))
    print(",".join(["top"] + [name for name in runs[0][0] if name != "scene"]))
    for case, of_case in zip(todo, runs):
        fastest = min(of_case, key=lambda run: float(run["ns"]))
        print(",".join([case.name] + [value for name, value in fastest.items() if name != "scene"]), flush=True)


if __name__ == "__main__":
    main()
