#!/usr/bin/env python3
"""Measures the speed of clustermcml:

    speed.py [--quick] [--irregular] [--rounds N] [--mcml PATH] [--program PATH] [--out DIR]

By default the program is build/clustermcml and DIR is bench/out. --mcml is a binary of original MCML, which is timed on the flat scenes in the same
rounds. --irregular runs only irregular and overhanging tops, with the regular grids and planes beside them. Leaves speed.csv, speed.txt and, with
matplotlib, speed.svg.

    speed.py --draw CSV SVG

draws a result again. bench/speed/README.md explains the results.

Every round runs every case once, and every second round runs them in reverse order, so that a machine that slows down or is shared affects all
cases alike. Ratios are formed within a round. Medians are reported, with minimum and maximum.

SPDX-License-Identifier: MIT
"""
import os
import shutil
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import chart
import command
import results
import runs
import speed_chart
import tables

THREADS_TARGET = 3  # factor by which runs on several threads are longer, because their ratio is within a tenth of its bound


def calibrate(program, mcml, case, target):
    """Sets the numbers of photons that take about `target` seconds."""
    runs.calibrate(program, case, target)
    if mcml and case.surface == "flat" and case.threads == 1:
        case.mcml_start, case.mcml_photons = runs.calibrate_mcml(mcml, cases.data_lines(case.medium), target)


def measure(program, mcml, todo, rounds):
    for index in range(rounds):
        for case in todo if index % 2 == 0 else todo[::-1]:
            print("\rround %d of %d: %-24s" % (index + 1, rounds, case.name), end="", file=sys.stderr)
            # every round has a new seed, so that all rounds together give one better Rd
            case.runs.append(runs.fly_alone(program, case, case.photons, index + 1))
            if case.mcml_photons:
                seconds, rd, disturbed = runs.fly_mcml(mcml, cases.data_lines(case.medium), case.mcml_photons)
                case.mcml_runs.append((max(seconds - case.mcml_start, 1e-3) / case.mcml_photons, rd))
                case.mcml_disturbed += disturbed
    print(file=sys.stderr)


def draw(csv, target):
    speed_chart.draw(results.series(tables.read_csv(csv)[1]), target)


def main():
    parser = command.parser(__doc__, "quick irregular", rounds=(5, 5))
    parser.add_argument("--mcml", type=command.built)
    command.instead(parser, "--draw", ("CSV", "SVG"), draw, "matplotlib")
    arguments = parser.parse_args()
    target = 0.25 if arguments.quick else 0.7
    begin = time.time()
    with tempfile.TemporaryDirectory() as work:
        # a copy, which nobody rebuilds between two rounds
        program = shutil.copy(arguments.program, os.path.join(work, "clustermcml"))
        todo = cases.all_cases(work, arguments.quick)
        if arguments.irregular:
            todo = cases.beside_grids(todo)
        for case in todo:
            print("\rcalibrating: %-24s" % case.name, end="", file=sys.stderr)
            calibrate(program, arguments.mcml, case, target * (THREADS_TARGET if case.threads > 1 else 1))
        print(file=sys.stderr)
        measure(program, arguments.mcml, todo, arguments.rounds)
    machine = tables.machine(arguments.program, arguments.rounds)
    disturbed = sum(record["disturbed"] for case in todo for record in case.runs)
    theirs = sum(case.mcml_disturbed for case in todo)
    machine.append(("runs disturbed by other programs", "%d, original MCML's %d" % (disturbed, theirs) if arguments.mcml else str(disturbed)))
    rows = results.rows(todo)
    kept = os.path.join(arguments.out, "speed")
    tables.write_csv(kept + ".csv", machine, rows)
    tables.keep(kept + ".txt", results.lines(machine, rows))
    print("%.0f s, results in %s" % (time.time() - begin, arguments.out), file=sys.stderr)
    chart.draw_result(draw, kept + ".csv", kept + ".svg")


if __name__ == "__main__":
    main()
