#!/usr/bin/env python3
"""Measures the cost of more ranks, on 1 to 8 ranks of this machine, and predicts it for more: scaling.py [--photons N] [--program PATH] [--out
DIR]. Leaves scaling.txt in DIR.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import command
import runs
import tables

RANKS = (1, 2, 4, 8)
ROUNDS = 3            # the least of each figure counts, because other programs can only add to it
GRIDS = ((100, 100), (1000, 1000), (2000, 3000))  # nz nr: 1e4, 1e6 and 6e6 bins
RUN_SECONDS = 3600    # length of the predicted runs
CHECKPOINT = 60       # seconds between meetings of the ranks, at least 20 times the length of the last meeting (run.c)
SERVICE = 5e-6        # assumed cost of one question for the attendant of rank 0 [s]
BANDWIDTH = 1.25e9    # assumed bytes per second between two hosts, 10 Gbit/s
CELL = 16             # bytes of a cell

SCENE = """1.0
1
scaling.mco A
1000
0.01 0.01
{nz} {nr} 1
1
1.0
1.4 0.1 90 0 0.5
1.0
"""


def cells(nz, nr):
    """Returns the number of cells of a result: grid, exits, layers, and 64 batches of profiles (tally.c)."""
    return nz * nr + 2 * nr + 3 + 64 * (2 * nr + 2 + nz)


def fly(program, photons, ranks, grid):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scaling.mci")
        with open(path, "w", encoding="ascii") as file:
            file.write(SCENE.format(nz=grid[0], nr=grid[1]))
        line = ["mpiexec", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", program, path, "--photons",
                   str(photons), "--threads", "1", "--checkpoint", "off", "--json", "-o", folder]
        return runs.records(line)[0]


def costs(record):
    """Returns seconds, idle share, communication share, seconds per question, seconds of the last meeting."""
    others = record["rank_s"][1:]
    questions = sum(rank["ranges"] + 1 for rank in others)
    latency = sum(rank["asking"] for rank in others) / questions if others else 0.0
    meeting = statistics.fmean(rank["sums"] for rank in record["rank_s"])
    return record["seconds"], record["idle"], record["communication"], latency, meeting


def measure(program, photons):
    """Returns rows (ranks, cells, *costs)."""
    rows = []
    for grid in GRIDS:
        for ranks in RANKS:
            rounds = [costs(fly(program, photons, ranks, grid)) for _ in range(ROUNDS)]
            rows.append((ranks, cells(*grid), *map(min, zip(*rounds))))
    return rows


def fit_meeting(rows):
    """Fits meeting = log2(ranks) (a + b cells) by least squares. Returns a and b."""
    points = [(n, m / math.log2(p)) for p, n, *_, m in rows if p > 1]
    mean_n, mean_m = (statistics.fmean(column) for column in zip(*points))
    b = sum((n - mean_n) * (m - mean_m) for n, m in points) / sum((n - mean_n) ** 2 for n, _ in points)
    b = max(b, 0.0)
    return max(mean_m - b * mean_n, 0.0), b


def predict(ranks, bins, latency, a, b):
    """Returns the predicted shares of a run's time: asking, meetings, end, pieces; see bench/speed/README.md."""
    n = bins + 64 * 3 * math.sqrt(bins)
    overhead = n * 3 * 8 / 5e9  # clearing and adding two tallies at 5 GB/s
    target = max(0.5, 1e-4 * ranks, 50 * overhead)
    load = ranks * SERVICE / target
    asking = (latency + SERVICE / (1 - load)) / target
    meeting = math.log2(ranks) * (a + n * (b + CELL / BANDWIDTH))
    meetings = meeting / max(CHECKPOINT, 20 * meeting) + meeting / RUN_SECONDS
    end = target / 16 / RUN_SECONDS
    pieces = overhead / (target / min(4, target / (25 * overhead)))
    return asking, meetings, end, pieces


def lines(program, photons):
    """Yields the table of measurements, and the table of the model."""
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMP_WAIT_POLICY="passive")
    yield (tables.measured(tables.machine(program, ROUNDS)) + f"; load {os.getloadavg()[0]:.1f}; {photons:.0e} photons of a thick slab, one thread per rank")
    yield (f"{'ranks':>5} {'cells':>9} {'s':>7} {'idle %':>7} {'comm. %':>8} {'question ms':>12} {'meeting ms':>11}")
    rows = measure(program, photons)
    for ranks, n, seconds, idle, communication, latency, meeting in rows:
        yield (f"{ranks:5d} {n:9d} {seconds:7.2f} {100 * idle:7.2f} {100 * communication:8.2f} {1e3 * latency:12.2f} "
              f"{1e3 * meeting:11.2f}")
    a, b = fit_meeting(rows)
    # with more ranks than cores, a question waits for a core, which does not happen on a cluster
    latency = statistics.median(row[5] for row in rows if 1 < row[0] <= max(2, os.cpu_count()))
    yield (f"meeting = log2(ranks) ({1e3 * a:.2f} ms + {1e9 * b:.2f} ns per cell), question {1e3 * latency:.2f} ms")
    yield (f"{'ranks':>6} {'bins':>6} {'asking %':>9} {'meetings %':>11} {'end %':>6} {'pieces %':>9} {'efficiency %':>13}")
    for ranks in (100, 1000, 10000):
        for bins in (1e4, 1e8):
            shares = predict(ranks, bins, latency, a, b)
            yield (f"{ranks:6d} {bins:6.0e} {100 * shares[0]:9.3f} {100 * shares[1]:11.3f} {100 * shares[2]:6.3f} "
                  f"{100 * shares[3]:9.3f} {100 * (1 - sum(shares)):13.2f}")


def main():
    arguments = command.parser(__doc__, photons=2000000).parse_args()
    tables.keep(os.path.join(arguments.out, "scaling.txt"), list(lines(arguments.program, arguments.photons)))


main()
