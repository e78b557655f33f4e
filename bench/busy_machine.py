"""busy_machine.py ROUNDS LOOPS PROGRAM...: one and two threads beside busy loops (bench/busy_machine.sh).
SPDX-License-Identifier: MIT"""
import os
import statistics
import subprocess
import sys
import tempfile
import time

SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "samples")
CASES = [("thick.mci", 20000), ("thick.mci", 1000000), ("shapes/hinoise.mci", 1000000)]
LOOP = ["sh", "-c", "while :; do :; done"]


def measure(program, scene, photons, threads, folder):
    """Wall and processor seconds of one run."""
    environment = dict(os.environ)
    if not BUSY:
        environment["OMP_PROC_BIND"] = "true"
    command = [program, "run", os.path.join(SAMPLES, scene), "--photons", str(photons), "--threads", str(threads),
               "--checkpoint", "off", "--quiet", "-o", folder]
    begin = time.monotonic()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"busy_machine.py: {' '.join(command)}: exit {process.returncode}")
    return time.monotonic() - begin, usage.ru_utime + usage.ru_stime


def take_turns(rounds, programs, folder):
    """[case, program, threads]: (wall, processor) of each round; what is compared runs one behind the other."""
    runs = {(case, program, threads): [] for case in CASES for program in programs for threads in (1, 2)}
    for number in range(rounds):
        order = list(runs) if number % 2 == 0 else list(reversed(runs))
        for case, program, threads in order:
            runs[case, program, threads].append(measure(program, *case, threads, folder))
    return runs


def print_table(runs, programs):
    print(f"{'scene':20} {'photons':>8} {'program':24} {'wall 1':>8} {'wall 2':>8} {'2/1':>6} {'cpu 1':>8} {'cpu 2':>8} {'2/1':>6}")
    for case in CASES:
        for program in programs:
            one, two = ([statistics.median(values) for values in zip(*runs[case, program, threads])] for threads in (1, 2))
            figures = " ".join(f"{one[k]:8.3f} {two[k]:8.3f} {two[k] / one[k]:6.2f}" for k in (0, 1))
            print(f"{case[0]:20} {case[1]:8} {program[-24:]:24} {figures}")


rounds, programs = int(float(sys.argv[1])), sys.argv[3:]
BUSY = [subprocess.Popen(LOOP) for _ in range(int(float(sys.argv[2])))]
try:
    with tempfile.TemporaryDirectory() as work:
        print(f"{len(BUSY)} busy loops on {os.cpu_count()} cores, medians of {rounds} rounds, seconds", flush=True)
        print_table(take_turns(rounds, programs, work), programs)
finally:
    for loop in BUSY:
        loop.kill()
