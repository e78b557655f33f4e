#!/usr/bin/env python3
"""Times clustermcml against MMC on one core: mmc.py --mmc PATH [--rounds N] [--program PATH] [--out DIR].

The scene is a slab with ten scatterings per cm below rough tops: regular grids of 1e3, 1e4 and 1e5 triangles, and 1e5 irregular and steeper ones;
peers.py has overhangs. Both programs tally the absorbed light with the same roulette. Only flights count: reading, building and writing are left
out. The programs take turns, a run that others disturbed is repeated, and ratios are formed within a round. Beside the speed stands the absorbed
share of the light that entered, which must be equal. PATH is MMC's program, built by its own Makefile; tetgen fills the slab with tetrahedra for
it. Leaves mmc.md in DIR. `mmc.py --readme MMC.md README.md` puts this result into README.

SPDX-License-Identifier: MIT
"""
import math
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import runs
import tables
import slab

# medium, kind of rough.py, triangles
TOPS = (("A", "mesh", "1e3"), ("A", "mesh", "1e4"), ("A", "mesh", "1e5"), ("A", "kept", "1e5"))
TRACER = "S"  # the fastest tracer of MMC
ALIKE = ["--no-reentry", "--sampling", "random", "--roulette", "mcml"]  # options that make both programs alike: light that leaves MMC's tetrahedra is gone, and MMC samples at random
SECONDS = 0.7  # length of a run [s]
INSIDE = 1e-5  # distance of the start of MMC's packets below the surface [cm]: 0.001 mean free paths of skin
ROULETTE = "1e-4"  # weight below which roulette is played, as in MCML
TITLES = ("medium", "top", "triangles", "tetrahedra", "photons/s", "MMC's", "ratio", "absorbed of what entered", "by MMC",
          "lost")


class Pair:
    """A slab in the formats of both programs, and their runs."""

    def __init__(self, medium, kind, triangles, work):
        self.top = "regular" if kind == "mesh" else kind
        self.case = cases.top_case(medium, kind, triangles, cases.AMPLITUDE_A, work)
        self.case.options = ALIKE
        self.stem = os.path.join(work, "slab-%s-%s-%s" % (medium, kind, triangles))
        self.tetrahedra = 0
        self.mmc_photons = 10000
        self.mmc_runs = []  # (photons per second, absorbed share, whether others disturbed it)


def entry(program, scene):
    """Returns (position [cm], direction) of a packet that has just entered, moved a little further inside."""
    text = subprocess.run([program, "trace", scene, "0"], capture_output=True, text=True, check=True).stdout
    events = [line.split() for line in text.split("\n") if line and line[0] != "#"]
    words = next(event for event in events if event[1] == "transmit" or event[1:3] == ["launch", "1"])  # launched below a plane
    position, direction = ([float(word) for word in words[first:first + 3]] for first in (3, 6))
    return [x + INSIDE * u for x, u in zip(position, direction)], direction


def prepare(program, pair):
    layer = [float(word) for word in cases.data_lines(pair.case.medium)[cases.ABOVE + 1].split()]
    mesh = slab.fill(pair.case.mesh, layer[-1], pair.stem)
    pair.tetrahedra = len(mesh[1])
    slab.write_mmc(mesh, [layer[:4]], *entry(program, pair.case.path), pair.stem + ".json")


def plain(text):
    """Returns the text without colours."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text)


def version(mmc):
    text = subprocess.run([mmc, "--version"], capture_output=True, text=True, check=False).stdout  # MMC exits with 1
    found = re.search(r"\$Rev::[ $]*(v[\w.]+)", plain(text))
    return found.group(1) if found else "?"


def fly_mmc(mmc, stem, photons, seed, tracer=TRACER):
    """Returns (photons per second, absorbed share of the light), as MMC prints them, and whether others disturbed the run."""
    line = [mmc, "-f", stem + ".json", "-c", "sse", "-G", "-1", "-M", tracer, "-b", "1", "-e", ROULETTE, "-D", "T", "-S", "0",
               "-d", "0", "-n", str(photons), "-E", str(seed)]
    text, _, disturbed = runs.run_alone(line, os.path.dirname(stem), environment=dict(os.environ, OMP_NUM_THREADS="1"))
    rate, absorbed = (re.search(pattern, plain(text)) for pattern in (r"([\d.]+) photon/ms", r"absorbed: +([\d.]+)%"))
    if not rate or not absorbed:
        sys.exit("%s: printed no photons per ms, or no absorbed share:\n%s" % (mmc, text))
    return 1e3 * float(rate.group(1)), float(absorbed.group(1)) / 100, disturbed


def calibrate(program, mmc, pair):
    runs.calibrate(program, pair.case, SECONDS)
    pair.mmc_photons = runs.two_digits(SECONDS * fly_mmc(mmc, pair.stem, pair.mmc_photons, 1)[0])


def measure(program, mmc, pairs, rounds):
    for index in range(rounds):
        for pair in pairs if index % 2 == 0 else pairs[::-1]:
            pair.case.runs.append(runs.fly_alone(program, pair.case, pair.case.photons, index + 1))
            pair.mmc_runs.append(fly_mmc(mmc, pair.stem, pair.mmc_photons, index + 1))


def absorbed(pair):
    """Returns ((share, standard error) of this program, the same of MMC) of the absorption, relative to the light that entered."""
    n = len(pair.case.runs)
    shares = [run["A"] / (1 - run["Rsp"]) for run in pair.case.runs]
    error = math.sqrt(sum((run["A_se"] / (1 - run["Rsp"])) ** 2 for run in pair.case.runs)) / n
    theirs = [share for _, share, _ in pair.mmc_runs]
    return (statistics.fmean(shares), error), (statistics.fmean(theirs), statistics.stdev(theirs) / math.sqrt(n))


def row(pair):
    ours, theirs = [run["photons_per_s"] for run in pair.case.runs], [rate for rate, _, _ in pair.mmc_runs]
    ratios = [a / b for a, b in zip(ours, theirs)]
    return [pair.case.medium, pair.top, str(pair.case.runs[0]["boundaries"][0]["primitives"]), str(pair.tetrahedra),
            "%.3g" % statistics.median(ours), "%.3g" % statistics.median(theirs),
            "%.1f (%.1f-%.1f)" % (statistics.median(ratios), min(ratios), max(ratios)),
            *("%.5f ± %.5f" % share for share in absorbed(pair)), str(sum(run["lost"] for run in pair.case.runs))]


def report(program, mmc, pairs, rounds):
    ours = sum(run["disturbed"] for pair in pairs for run in pair.case.runs)
    theirs = sum(run[2] for pair in pairs for run in pair.mmc_runs)
    yield tables.measured(tables.machine(program, rounds)) + (
        "; MMC %s; median (least-most) of %d rounds, one thread; disturbed by others: %d of our runs, %d of MMC's." % (
            version(mmc), rounds, ours, theirs))
    yield ""
    yield from tables.table(TITLES, [row(pair) for pair in pairs])


def bench(arguments):
    with tempfile.TemporaryDirectory() as work:
        program = shutil.copy(arguments.program, os.path.join(work, "clustermcml"))  # a copy, which nobody rebuilds meanwhile
        pairs = [Pair(*top, work) for top in TOPS]
        for pair in pairs:
            prepare(program, pair)
            calibrate(program, arguments.mmc, pair)
        measure(program, arguments.mmc, pairs, arguments.rounds)
        return list(report(arguments.program, arguments.mmc, pairs, arguments.rounds))


def main():
    parser = command.parser(__doc__, rounds=(5, 5))
    command.instead(parser, "--readme", ("RESULT", "README"), lambda path, readme: tables.put(path, readme, "peers/mmc.py"))
    parser.add_argument("--mmc", type=command.built, required=True)
    arguments = parser.parse_args()
    tables.keep(os.path.join(arguments.out, "mmc.md"), bench(arguments))


if __name__ == "__main__":
    main()
