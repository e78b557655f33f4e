#!/usr/bin/env python3
"""Tests if threads wait for threads that the system does not let run: busy_machine.py [--rounds N] [--loops N] [--against PATH] [--program PATH]

Every round runs every case on one thread and on two, beside N (2) busy loops. --against is another clustermcml, run in the same rounds. --loops 0
means an idle machine, with threads bound to cores. Prints medians: wall and processor seconds of the process, and the ratios of two threads to one.

SPDX-License-Identifier: MIT
"""
import os
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command

CASES = [("thick.mci", 20000), ("thick.mci", 1000000), ("shapes/hinoise.mci", 1000000)]
LOOP = ["sh", "-c", "while :; do :; done"]


def measure(program, scene, photons, threads, folder, bound):
    """Returns the wall and processor seconds of one run."""
    environment = dict(os.environ)
    if bound:
        environment["OMP_PROC_BIND"] = "true"
    line = [program, "run", os.path.join(cases.ROOT, "samples", scene), "--photons", str(photons), "--threads", str(threads),
               "--checkpoint", "off", "--quiet", "-o", folder]
    begin = time.monotonic()
    process = subprocess.Popen(line, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"busy_machine.py: {' '.join(line)}: exit {process.returncode}")
    return time.monotonic() - begin, usage.ru_utime + usage.ru_stime


def take_turns(rounds, programs, folder, bound):
    """Runs all cases in turns. Returns {(case, program, threads): (wall, processor) of each round}. Compared runs follow one another."""
    runs = {(case, program, threads): [] for case in CASES for program in programs for threads in (1, 2)}
    for number in range(rounds):
        order = list(runs) if number % 2 == 0 else list(reversed(runs))
        for case, program, threads in order:
            runs[case, program, threads].append(measure(program, *case, threads, folder, bound))
    return runs


def print_table(runs, programs):
    print(f"{'scene':20} {'photons':>8} {'program':24} {'wall 1':>8} {'wall 2':>8} {'2/1':>6} {'cpu 1':>8} {'cpu 2':>8} {'2/1':>6}")
    for case in CASES:
        for program in programs:
            one, two = ([statistics.median(values) for values in zip(*runs[case, program, threads])] for threads in (1, 2))
            figures = " ".join(f"{one[k]:8.3f} {two[k]:8.3f} {two[k] / one[k]:6.2f}" for k in (0, 1))
            print(f"{case[0]:20} {case[1]:8} {program[-24:]:24} {figures}")


def main():
    parser = command.parser(__doc__, rounds=5)
    parser.add_argument("--loops", type=lambda text: 0 if text == "0" else command.count(text), default=2)
    parser.add_argument("--against", type=command.built)
    arguments = parser.parse_args()
    programs = [arguments.program] + [arguments.against] * bool(arguments.against)
    busy = [subprocess.Popen(LOOP) for _ in range(arguments.loops)]
    try:
        with tempfile.TemporaryDirectory() as work:
            print(f"{len(busy)} busy loops on {os.cpu_count()} cores, medians of {arguments.rounds} rounds, seconds", flush=True)
            print_table(take_turns(arguments.rounds, programs, work, not busy), programs)
    finally:
        for loop in busy:
            loop.kill()


main()
