#!/usr/bin/env python3
"""Measures the speed of clustermcml: speed.py PROGRAM DIRECTORY [--quick] [--irregular] [--rounds N] [--mcml PATH].

Every round runs every case once, and every second round runs them backwards, so that a machine that slows down or is
shared hits all of them alike. Ratios are taken within a round; reported are medians, with minimum and maximum.
Writes DIRECTORY/speed.csv and DIRECTORY/speed.txt. bench/speed/README.md explains the columns.
SPDX-License-Identifier: MIT
"""
import argparse
import os
import shutil
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import results
import runs
import tables

THREADS_TARGET = 3  # runs on several threads are so much longer, for their ratio is within a tenth of its bound


def calibrate(program, mcml, case, target):
    """Numbers of photons that take about target seconds."""
    runs.calibrate(program, case, target)
    if mcml and case.surface == "flat" and case.threads == 1:
        case.mcml_start, case.mcml_photons = runs.calibrate_mcml(mcml, cases.data_lines(case.medium), target)


def measure(program, mcml, todo, rounds):
    for index in range(rounds):
        for case in todo if index % 2 == 0 else todo[::-1]:
            print("\rround %d of %d: %-24s" % (index + 1, rounds, case.name), end="", file=sys.stderr)
            # a new seed per round: the rounds then also add up to one better Rd
            case.runs.append(runs.fly_alone(program, case, case.photons, index + 1))
            if case.mcml_photons:
                seconds, rd, disturbed = runs.fly_mcml(mcml, cases.data_lines(case.medium), case.mcml_photons)
                case.mcml_runs.append((max(seconds - case.mcml_start, 1e-3) / case.mcml_photons, rd))
                case.mcml_disturbed += disturbed
    print(file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description="Measures the speed of clustermcml.")
    parser.add_argument("program")
    parser.add_argument("directory")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--irregular", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--mcml")
    arguments = parser.parse_args()
    if arguments.rounds < 5:
        parser.error("fewer than 5 rounds make no median")
    target = 0.25 if arguments.quick else 0.7
    os.makedirs(arguments.directory, exist_ok=True)
    begin = time.time()
    with tempfile.TemporaryDirectory() as work:
        # a copy: nobody rebuilds it between two rounds
        program = shutil.copy(arguments.program, os.path.join(work, "clustermcml"))
        mcml = os.path.abspath(arguments.mcml) if arguments.mcml else None
        todo = cases.all_cases(work, arguments.quick)
        if arguments.irregular:
            todo = cases.beside_grids(todo)
        for case in todo:
            print("\rcalibrating: %-24s" % case.name, end="", file=sys.stderr)
            calibrate(program, mcml, case, target * (THREADS_TARGET if case.threads > 1 else 1))
        print(file=sys.stderr)
        measure(program, mcml, todo, arguments.rounds)
    machine = tables.machine(arguments.program, arguments.rounds)
    disturbed = sum(record["disturbed"] for case in todo for record in case.runs)
    theirs = sum(case.mcml_disturbed for case in todo)
    machine.append(("runs disturbed by other programs", "%d, original MCML's %d" % (disturbed, theirs) if mcml else str(disturbed)))
    rows = results.rows(todo)
    tables.write_csv(os.path.join(arguments.directory, "speed.csv"), machine, rows)
    text = results.text(machine, rows)
    with open(os.path.join(arguments.directory, "speed.txt"), "w") as stream:
        stream.write(text)
    print(text)
    print("%.0f s, results in %s" % (time.time() - begin, arguments.directory), file=sys.stderr)


if __name__ == "__main__":
    main()
