#!/usr/bin/env python3
"""Measures the speed of clustermcml: speed.py PROGRAM DIRECTORY [--quick] [--irregular] [--rounds N] [--mcml PATH].

Every round runs every case once, and every second round runs them backwards, so that a machine that slows down or is
shared hits all of them alike. Ratios are taken within a round; reported are medians, with minimum and maximum.
Writes DIRECTORY/speed.csv and DIRECTORY/speed.txt. bench/README.md explains the columns.
SPDX-License-Identifier: MIT
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

import cases
import results

CALIBRATE_S = 0.1  # a run shorter than this says too little about the photons per second
FOREIGN = 0.05  # of a core that others may take from a run before it is repeated
REPEATS = 3
THREADS_TARGET = 3  # runs on several threads are so much longer, for their ratio is within a tenth of its bound
MOST_PHOTONS = 50000000


def busy_seconds():
    """Core seconds that the whole machine has worked so far, or None where no /proc/stat tells."""
    try:
        with open("/proc/stat") as stream:
            ticks = [int(word) for word in stream.readline().split()[1:9]]
    except (OSError, ValueError):
        return None
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")  # without idle and iowait


def run(command, directory, threads=1, environment=None):
    """(standard output, resource usage, whether others took the cores that it needs) of a child; exit codes 0 and 4, numerical
    trouble, go on."""
    with tempfile.TemporaryFile("w+") as out:
        begin, before = time.monotonic(), busy_seconds()
        child = subprocess.Popen(command, cwd=directory, env=environment, stdout=out)
        _, status, usage = os.wait4(child.pid, 0)
        wall, after = time.monotonic() - begin, busy_seconds()
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode not in (0, 4):
            sys.exit("%s: exit code %d" % (" ".join(command), child.returncode))
        out.seek(0)
        foreign = 0.0 if before is None or after is None else after - before - usage.ru_utime - usage.ru_stime
        return out.read(), usage, foreign > (os.cpu_count() - threads + FOREIGN) * wall + 0.02  # ticks are 0.01 s


def run_alone(command, directory, threads=1, environment=None):
    """Like run, for ours and for others alike: again, a few times, when other programs took the cores that it needs."""
    for _ in range(REPEATS):
        result = run(command, directory, threads, environment)
        if not result[2]:
            break
        time.sleep(1)
    return result


def fly_alone(program, case, photons, seed):
    """One run of the program: its JSON record, with the process's memory, and whether others disturbed it."""
    environment = dict(os.environ)
    if case.threads > 1:
        environment["OMP_PROC_BIND"] = "true"
    command = [program, case.path, "--json", "--threads", str(case.threads), "--seed", str(seed),
               "--photons", str(photons)] + case.options
    text, usage, disturbed = run_alone(command, os.path.dirname(case.path), case.threads, environment)
    return {**json.loads(text), "rss": usage.ru_maxrss / 1024, "disturbed": disturbed}


def fly_mcml(mcml, case, photons):
    """(user seconds, Rd, whether others disturbed it) of original MCML on the flat scene."""
    directory = os.path.join(os.path.dirname(case.path), "mcml")
    os.makedirs(directory, exist_ok=True)
    scene = os.path.join(directory, case.name + ".mci")
    cases.write_scene(case.medium, scene, photons=photons)
    _, usage, disturbed = run_alone([mcml, os.path.basename(scene)], directory)
    output = os.path.join(directory, cases.data_lines(case.medium)[2].split()[0])
    with open(output, errors="replace") as stream:
        rd = [line.split()[0] for line in stream if "#Diffuse reflectance" in line]
    os.remove(output)
    return usage.ru_utime, float(rd[0]), disturbed


def two_digits(photons):
    digits = "%.1e" % min(max(photons, 100), MOST_PHOTONS)
    return int(float(digits))


def calibrate(program, mcml, case, target):
    """Numbers of photons that take about target seconds."""
    photons = 2000
    while True:
        seconds = fly_alone(program, case, photons, 1)["seconds"]
        if seconds > CALIBRATE_S or photons >= MOST_PHOTONS:
            break
        photons = min(MOST_PHOTONS, int(photons * min(20.0, 1.5 * CALIBRATE_S / max(seconds, 1e-4))) + 1)
    case.photons = two_digits(photons * target / seconds)
    if not (mcml and case.surface == "flat" and case.threads == 1):
        return
    # what it takes to start and to write its file, which is no flight of photons
    case.mcml_start = min(fly_mcml(mcml, case, 1)[0] for _ in range(3))
    photons, seconds = 500, 0.0
    while seconds < CALIBRATE_S:
        photons *= 4
        seconds = fly_mcml(mcml, case, photons)[0] - case.mcml_start
    case.mcml_photons = two_digits(photons * target / seconds)


def measure(program, mcml, todo, rounds):
    for index in range(rounds):
        for case in todo if index % 2 == 0 else todo[::-1]:
            print("\rround %d of %d: %-24s" % (index + 1, rounds, case.name), end="", file=sys.stderr)
            # a new seed per round: the rounds then also add up to one better Rd
            case.runs.append(fly_alone(program, case, case.photons, index + 1))
            if case.mcml_photons:
                seconds, rd, disturbed = fly_mcml(mcml, case, case.mcml_photons)
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
    machine = results.machine(arguments.program, todo[0].runs[0]["version"], arguments.rounds)
    disturbed = sum(record["disturbed"] for case in todo for record in case.runs)
    theirs = sum(case.mcml_disturbed for case in todo)
    machine.append(("runs disturbed by other programs", "%d, original MCML's %d" % (disturbed, theirs) if mcml else str(disturbed)))
    rows = results.rows(todo)
    results.write_csv(os.path.join(arguments.directory, "speed.csv"), machine, rows)
    text = results.text(machine, rows)
    with open(os.path.join(arguments.directory, "speed.txt"), "w") as stream:
        stream.write(text)
    print(text)
    print("%.0f s, results in %s" % (time.time() - begin, arguments.directory), file=sys.stderr)


if __name__ == "__main__":
    main()
