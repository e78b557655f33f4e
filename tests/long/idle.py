"""Tests that ranks hardly wait: 2 ranks on S6a with 1e7 photons are idle for at most 2 % of their time, and asking for ranges
and summing takes at most 1 %.

A rank that is ten times slower, because it is stopped for nine tenths of the time, costs the other one at most one range
(0.75 s). Needs two free cores. Standard library only."""
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
ROW = re.compile(r"^ +(\d+) +(\d+) +([\d.]+) +([\d.]+) +([\d.]+) +([\d.]+)$", re.M)


def children(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return [int(word) for word in file.read().split()]


def slow_down(pid, finished):
    """Lets a process work for ten milliseconds in a hundred."""
    try:
        while not finished.is_set():
            os.kill(pid, signal.SIGSTOP)
            time.sleep(0.09)
            os.kill(pid, signal.SIGCONT)
            time.sleep(0.01)
    except ProcessLookupError:
        pass


def fly(photons, slow):
    """Returns rows (rank, photons, flying, idle, asking, sums; shares in percent), and the seconds that the shares refer to."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.Popen(["mpiexec", "-n", "2", PROGRAM, "samples/thick.mci", "--photons", photons, "--threads",
                                "1", "--verbose", "-o", folder], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                               text=True)
        while not run.stdout.readline().startswith("  boundary 1"):
            pass
        finished = threading.Event()
        helper = threading.Thread(target=slow_down, args=(max(children(run.pid)), finished))
        if slow:
            helper.start()
        begin = time.monotonic()
        output = run.stdout.read()
        seconds = time.monotonic() - begin
        finished.set()
        if slow:
            helper.join()
        if run.wait() != 0:
            sys.exit(f"exit {run.returncode}")
    print(output)
    return [tuple(map(float, row)) for row in ROW.findall(output)], seconds


def main():
    if not shutil.which("mpiexec") or len(os.sched_getaffinity(0)) < 2:
        print("needs mpiexec and two cores")
        sys.exit(77)
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    rows, _ = fly("1e7", False)
    idle = sum(row[3] for row in rows) / len(rows)
    communication = sum(row[4] + row[5] for row in rows) / len(rows)
    slow_rows, seconds = fly("2e6", True)
    waited = slow_rows[0][3] / 100 * seconds
    ratio = slow_rows[0][1] / slow_rows[1][1]
    print(f"idle {idle:.2f} %, communication {communication:.2f} %; beside a rank {ratio:.1f} times slower rank 0 "
          f"waited {waited:.2f} s of {seconds:.1f} s")
    sys.exit(0 if idle <= 2 and communication <= 1 and waited <= 0.75 and ratio > 5 else 1)


main()
