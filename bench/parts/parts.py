#!/usr/bin/env python3
"""Measures the cost of the cpu engine's parts on this machine:

    parts.py [--build DIR] [--out DIR]

Builds the benches in build/, runs bench_stages, bench_busy, bench_curved, bench_asked and bench_queries, and leaves parts.txt in bench/out. Its
sections: the vector loops alone and left out; the time of the flat scenes; the time below rough tops and rings, with much scattering (S6a) and
little (S2); how often regular, irregular and spiked tops are asked and met; the cost of a step near the boundary by itself.

SPDX-License-Identifier: MIT
"""
import csv
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

PLANE = ("reach planes", "reflect", "fly again")
ONCE = ("launch", "exit")
MEDIA = ("S2", "S6a")
TRIANGLES = ("1e3", "1e5", "3e5")
RINGS = {"rings": 50, "rings-1000": 1000}
ROUNDS = 5
FLAT = ("scene", "launched", "interactions", "busy_in_passes", "boundary_events", "busy_at_planes", "passes_ns", "planes_ns",
        "launch_exit_ns", "left_ns", "ns", "all_busy_ns")


def printed(*words):
    """Runs a bench and returns its lines. If it fails, the bench has printed the reason."""
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(done.returncode)
    return done.stdout.splitlines()


def fastest(runs):
    return min(runs, key=lambda run: float(run["ns"]))


def first_row(*words):
    return next(csv.DictReader(printed(*words)))


def total(stages, names):
    """Returns the sum of the stages whose names begin with one of these."""
    found = [time for stage, time in stages.items() if stage.startswith(names)]
    if len(found) != len(names):
        sys.exit("parts.py: the stages are not those that are looked for")
    return sum(found)


def flat_lines(bench, stage_lines):
    """Yields the parts of the time of the flat scenes, in ns per photon.

    bench_stages prints the time of every loop per lane, bench_busy the number of lanes that a photon takes through the loops, and its time.
    Together they account for a photon's time: the loops of a pass, those of the planes, a launch and an exit of packets that are flown (`launched`;
    others are ballistic, and only counted). The rest is random numbers drawn for all lanes, single lanes (layers entered, roulette), branches, and
    caches. `busy` is the share of lanes that had work in a loop, `all_busy` the time if all had. The fastest of ROUNDS runs counts, because stages
    are the least of several tries, too."""
    stages = {row["stage"]: float(row["ns_alone"]) for row in csv.DictReader(stage_lines)}
    step, plane, once = stages["whole pass"], total(stages, PLANE), total(stages, ONCE)
    yield ",".join(FLAT)
    for name, path in cases.SCENES.items():
        run = fastest([first_row(bench, os.path.join(cases.ROOT, path)) for _ in range(ROUNDS)])
        launched, interactions, in_passes, at_planes, ns = (float(run[key]) for key in (
            "launched", "interactions", "lanes_in_passes", "lanes_at_planes", "ns"))
        events = float(run["boundary_events"]) - (1 - launched)
        passes, planes, ends = step * in_passes, plane * at_planes, once * launched
        yield (f"{name},{launched:.3f},{interactions:.2f},{interactions / in_passes:.2f},{events:.2f},{events / at_planes:.2f},"
               f"{passes:.1f},{planes:.1f},{ends:.1f},{ns - passes - planes - ends:.1f},{ns:.1f},"
               f"{step * interactions + plane * events + ends:.1f}")


def curved_tops(medium, work):
    """Returns the curved tops of speed.py that are flown as cones, or walked as a mesh, without the largest."""
    found = [cases.level_case(medium, work)]
    found += cases.rough_cases(medium, TRIANGLES, cases.AMPLITUDE, work) + cases.ring_cases(medium, work)
    return [case for case in found if "embree" not in case.options and (case.surface != "rings" or "cone" in case.options)]


def curved_lines(bench, work):
    """Yields the parts of the time below curved boundaries, in the fastest of ROUNDS runs, one top after the other: ns per photon."""
    runs = {case: [] for medium in MEDIA for case in curved_tops(medium, work)}
    for _ in range(ROUNDS):
        for case, of_case in runs.items():
            of_case.append(first_row(bench, case.path, "cone" if case.surface == "rings" else "mesh"))
    for i, (case, of_case) in enumerate(runs.items()):
        run = fastest(of_case)
        del run["scene"]
        if i == 0:
            yield ",".join(["top", *run])
        yield ",".join([case.name, *run.values()])


def lines(bench, work):
    """Yields all lines of parts.txt. bench: returns the path of a bench by its name."""
    yield "# %s; load %.2f %.2f %.2f" % (tables.processor(), *os.getloadavg())
    stages = printed(bench("stages"))
    yield from stages
    yield "# flat scenes: per photon, what happens, and where the time goes"
    yield from flat_lines(bench("busy"), stages)
    yield "# curved tops: per photon, where the time goes"
    yield from curved_lines(bench("curved"), work)
    yield "# regular and irregular tops: steps of a photon, rays asked of the boundary per step, and those that met it"
    asked = [cases.top_case(medium, kind, cases.QUICK, amplitude, work).path for medium, amplitude in (
        ("S2", cases.AMPLITUDE), ("A", cases.AMPLITUDE_A), ("S6a", cases.AMPLITUDE)) for kind in ("mesh", *cases.IRREGULAR)]
    yield from (line.replace(work + "/", "", 1).replace(".mci", "", 1) for line in printed(bench("asked"), *asked))
    for scene in ("S6a-rough", "S6a-rings", "S6a-rings-1000", "S2-rough", "S2-rings"):
        yield "# " + scene
        yield from printed(bench("queries"), os.path.join(work, scene + ".mci"))
    for medium in ("S6a", "S2"):
        yield "# %s-rings as a mesh" % medium
        yield from printed(bench("queries"), os.path.join(work, medium + "-rings.mci"), "--mesh")


def write_scenes(work):
    """Writes the scenes of bench_queries."""
    cases.make_surface("mesh", "3e5", cases.AMPLITUDE, os.path.join(work, "rough.obj"))
    for medium in MEDIA:
        cases.write_scene(medium, os.path.join(work, medium + "-rough.mci"), surface='m "rough.obj"')
    for name, count in RINGS.items():
        cases.make_surface("rings", count, cases.AMPLITUDE, os.path.join(work, name + ".txt"))
        for medium in MEDIA:
            cases.write_scene(medium, os.path.join(work, "%s-%s.mci" % (medium, name)), surface='b "%s.txt"' % name)


def main():
    parser = command.parser(__doc__, place=command.BUILD)
    arguments = parser.parse_args()
    command.build(parser, arguments.build, "benches")
    with tempfile.TemporaryDirectory() as work:
        write_scenes(work)
        tables.keep(os.path.join(arguments.out, "parts.txt"),
                    list(lines(lambda name: os.path.join(arguments.build, "bench_" + name), work)))


if __name__ == "__main__":
    main()
