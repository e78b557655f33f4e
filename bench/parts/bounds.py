"""Where the time of the flat scenes goes: bounds.py BENCH_BUSY STAGES.csv

STAGES.csv is what bench_stages prints: the time of every loop per lane. bench_busy says how many lanes go through the
loops for a photon, and how long it takes. Both together account for a photon's time, in ns: the loops of a pass, those of
the planes, a launch and an exit of those that are flown (`launched`: the others are ballistic, and only counted). What is
left are random numbers drawn for all, single lanes (layers entered, roulette), branches, and caches. `busy` is the share of
lanes that had something to do there; `all_busy` is the time if all had. Prints CSV.

SPDX-License-Identifier: MIT
"""
import csv
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases

PLANE = ("reach planes", "reflect", "fly again")
ONCE = ("launch", "exit")
ROUNDS = 5


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


def measure(bench, scene):
    """What bench_busy says of a scene, in the fastest of ROUNDS runs: the stages are the least of several tries, too."""
    runs = []
    for _ in range(ROUNDS):
        out = subprocess.run([bench, scene], capture_output=True, check=True, text=True).stdout
        runs.append({what: float(value) for what, value in list(csv.DictReader(out.splitlines()))[0].items() if what != "scene"})
    return min(runs, key=lambda run: run["ns"])


def main():
    bench, stages = sys.argv[1], stage_times(sys.argv[2])
    step, plane, once = stages["whole pass"], total(stages, PLANE), total(stages, ONCE)
    print("scene,launched,interactions,busy_in_passes,boundary_events,busy_at_planes,passes_ns,planes_ns,launch_exit_ns,left_ns,ns,"
          "all_busy_ns")
    for name, path in cases.SCENES.items():
        run = measure(bench, os.path.join(cases.ROOT, path))
        launched, interactions = run["launched"], run["interactions"]
        events = run["boundary_events"] - (1 - launched)
        passes, planes, ends = step * run["lanes_in_passes"], plane * run["lanes_at_planes"], once * launched
        print(f"{name},{launched:.3f},{interactions:.2f},{interactions / run['lanes_in_passes']:.2f},{events:.2f},"
              f"{events / run['lanes_at_planes']:.2f},{passes:.1f},{planes:.1f},{ends:.1f},"
              f"{run['ns'] - passes - planes - ends:.1f},{run['ns']:.1f},"
              f"{step * interactions + plane * events + ends:.1f}", flush=True)


if __name__ == "__main__":
    main()
