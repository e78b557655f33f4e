"""How close the flat scenes come to their vector loops: bounds.py PROGRAM STAGES.csv

STAGES.csv is what bench_stages prints. The bound of a scene is the time of the loops that its packets cannot do
without, each with a packet in every lane that has something to do: a pass per interaction, a plane per boundary event,
a launch and an exit per photon. What a run takes beyond that are lanes that wait, branches, and caches. Prints CSV.

SPDX-License-Identifier: MIT
"""
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile

import cases

PLANE = ("reach planes", "turn", "look behind", "fly again")
ONCE = ("launch", "exit")
ROUNDS, SECONDS = 5, 0.5


def stage_times(path):
    """ns per lane of every stage, by the first words of its name."""
    with open(path, newline="") as stream:
        return {row["stage"]: float(row["ns_alone"]) for row in csv.DictReader(stream)}


def total(stages, names):
    """The stages whose names begin with one of these."""
    found = [time for stage, time in stages.items() if stage.startswith(tuple(names))]
    if len(found) != len(names):
        sys.exit("bounds.py: the stages are not those that are looked for")
    return sum(found)


def fly(program, scene, photons, folder):
    """The program's own account of a run on one thread."""
    command = [program, "run", scene, "--photons", str(photons), "--threads", "1", "-o", folder]
    command += ["--checkpoint", "off", "--json"]
    return json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


def measure(program, scene, folder):
    """Medians over ROUNDS runs of about SECONDS: ns, interactions and boundary events per photon."""
    first = fly(program, scene, 20000, folder)
    photons = max(20000, int(20000 * SECONDS / first["cpu_s"]))
    runs = [fly(program, scene, photons, folder) for _ in range(ROUNDS)]
    return [statistics.median(1e9 * run["cpu_s"] / photons for run in runs)] + [
        statistics.median(run[what] / photons for run in runs) for what in ("steps", "crossings")]


def main():
    program, stages = sys.argv[1], stage_times(sys.argv[2])
    print("scene,steps_per_photon,boundary_events_per_photon,bound_ns_per_step,ns_per_step,share")
    with tempfile.TemporaryDirectory() as folder:
        for name, path in cases.SCENES.items():
            ns, steps, events = measure(program, os.path.join(cases.ROOT, path), folder)
            bound = stages["whole pass"] * steps + total(stages, PLANE) * events + total(stages, ONCE)
            print(f"{name},{steps:.2f},{events:.2f},{bound / steps:.2f},{ns / steps:.2f},{bound / ns:.2f}", flush=True)


if __name__ == "__main__":
    main()
