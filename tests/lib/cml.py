"""Parts that all statistical tests share: running the program, reading .mco files, z-scores with limits by Sidak.

Every test states N, statistic and level, uses a fixed seed, and prints the offending bins when it fails. The environment variable CLUSTERMCML names
the program. Only the standard library is needed.
"""
import functools
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
REFERENCE = os.path.join(TESTS, "reference")
SAMPLES = os.path.join(os.path.dirname(TESTS), "samples")


def repeats(count):
    """Returns the number of packets to simulate out of `count`: all if the environment has ALL_CASES (ctest -L long), else a quarter."""
    return count if "ALL_CASES" in os.environ else count // 4


def sidak_limit(tests, level=1e-4):
    """Returns the |z| that the largest of `tests` independent normal deviates exceeds with probability `level`."""
    each = -math.expm1(math.log1p(-level) / tests)
    return statistics.NormalDist().inv_cdf(1 - each / 2)


def mci(layers, name="out.mco", photons=1000, grid="0.01 0.01", bins="10 10 1", n_above=1.0, n_below=1.0, surfaces=None,
        extra=()):
    """Returns the text of an .mci file. layers: strings 'n mua mus g d' (slashes allowed); surfaces: {boundary: b or m line}."""
    surfaces = surfaces or {}
    lines = ["1.0", "1", f"{name} A", f"{photons}", *extra, grid, bins, str(len(layers)), str(n_above)]
    for i, layer in enumerate(layers):
        if i in surfaces:
            lines.append(surfaces[i])
        lines.append(layer.replace("/", " "))
    if len(layers) in surfaces:
        lines.append(surfaces[len(layers)])
    return "\n".join(lines + [str(n_below)]) + "\n"


def repeated(runs, layers, name="run", kind=".mco", **scene):
    """Returns the text of an .mci file that has the scene `runs` times, named run0.mco, run1.mco ... Each run has random numbers of its own."""
    text = ["1.0", str(runs)]
    for i in range(runs):
        text.append("\n".join(mci(layers, name=f"{name}{i}{kind}", **scene).split("\n")[2:]))
    return "\n".join(text)


def run(text, *options, keep=None):
    """Runs the text of an .mci file, or a path to one; returns the list of JSON records. keep: directory for output."""
    with tempfile.TemporaryDirectory() as scratch:
        path = text
        if "\n" in text:
            path = os.path.join(keep or scratch, "scene.mci")
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        command = [PROGRAM, "run", path, "--json", "-o", keep or scratch, *map(str, options)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
        return [json.loads(line) for line in done.stdout.splitlines()]


def exact(text, *options):
    """Returns the record that `exact` prints for the text of an .mci file."""
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return json.loads(subprocess.run([PROGRAM, "exact", path, "--json", *map(str, options)], capture_output=True,
                                         text=True, check=True).stdout)


READS_H5 = """
import h5py, json, sys
for words in iter(sys.stdin.readline, ""):
    path, wanted = json.loads(words)
    with h5py.File(path, locking=False) as file:
        arrays = {name: file[name] for name in file if wanted is None or name in wanted}
        print(json.dumps({name: array[()].ravel().tolist() for name, array in arrays.items() if isinstance(array, h5py.Dataset)}), flush=True)
"""


@functools.lru_cache(maxsize=None)
def h5_reader():
    """Returns a process of a Python that has h5py, which the Python of this test may lack. The process lives as long as the test, because starting
    takes longer than reading."""
    python = os.environ.get("CLUSTERMCML_PYTHON", "/usr/bin/python3")
    return subprocess.Popen([python, "-c", READS_H5], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def read_h5(path, wanted=None):
    """Reads an .h5 file. Returns its arrays, or only those in `wanted`, as flat lists: {name: [values]}."""
    reader = h5_reader()
    print(json.dumps([path, wanted]), file=reader.stdin, flush=True)
    return json.loads(reader.stdout.readline())


def read_sections(path, wanted=None):
    """Reads the sections of an .mco file that have one number per line, and arrays that only the .h5 beside it has, or of these only `wanted`:
    {key: [values]}. Errors of X are se_X."""
    sections, key, more = {}, None, False
    with open(path, encoding="utf-8") as file:
        for line in file:
            more |= line.startswith("# more of this run stands in the .h5")
            word = line.split("#")[0].split()
            if not word:
                key = None if not line.strip() else key
            elif word[0][0].isalpha() and word[0].lower() != "nan":
                key = word[0]
                sections[key] = []
            elif key:
                sections[key].append(float(word[0]))
    beside = read_h5(os.path.splitext(path)[0] + ".h5", wanted) if more else {}
    for total in ("Rsp", "Rd", "A", "Tt"):  # sections RAT and se_RAT hold these totals
        beside.pop(total, None), beside.pop(total + "_se", None)
    for name, values in beside.items():
        sections.setdefault("se_" + name[:-3] if name.endswith("_se") else name, values)
    return sections


def joined(ours, theirs):
    """Returns bins in their order, joined until the oracle has 100 packets in each: (first, last, ours, error, theirs, error)."""
    parts, now = [], None
    for i, (a, b) in enumerate(zip(ours, theirs)):
        now = now or [i, i, 0, 0, 0, 0]
        now = [now[0], i, now[2] + a[0], math.hypot(now[3], a[1]), now[4] + b[0], math.hypot(now[5], b[1])]
        if now[4] > 0 and (now[5] == 0 or (now[4] / now[5]) ** 2 >= 100):
            parts.append(now)
            now = None
    if now and parts:
        last = parts.pop()
        now = [last[0], now[1], last[2] + now[2], math.hypot(last[3], now[3]), last[4] + now[4], math.hypot(last[5], now[5])]
    return parts + ([now] if now else [])


def error_of(value, error, packets):
    """Returns an error that also holds for few packets: weights up to 1 have at least this, and one packet could always have
    come."""
    return max(error, math.sqrt(max(value, 1 / packets) / packets)) if value * packets < 100 else error


class Verdict:
    """Collects z-scores, then passes or fails the test as a whole."""

    def __init__(self, title, level=1e-4):
        self.title, self.level, self.rows, self.failures = title, level, [], []

    def z(self, name, value, error, truth, truth_error=0.0):
        spread = math.hypot(error, truth_error)
        score = (value - truth) / spread if spread > 0 else (0.0 if value == truth else math.inf)
        self.rows.append((abs(score), f"{name}: {value:.7g} +- {error:.2g}, expected {truth:.7g}, z = {score:+.2f}"))

    def check(self, name, holds, detail=""):
        if not holds:
            self.failures.append(f"{name} {detail}")

    def finish(self, limit=None):
        self.rows.sort(reverse=True)
        if self.rows:
            limit = limit or sidak_limit(len(self.rows), self.level)
            self.failures += [text for score, text in self.rows if not score <= limit]
            rms = math.sqrt(statistics.fmean(score * score for score, _ in self.rows))
            print(f"{self.title}: {len(self.rows)} z-scores, limit {limit:.2f}, worst {self.rows[0][0]:.2f}, "
                  f"rms {rms:.3f}")
            print("  worst:", self.rows[0][1])
        for failure in self.failures:
            print("  FAILED", failure)
        sys.exit(1 if self.failures else 0)


def total_error(record, key, truth):
    """Returns the standard error of a total. If few packets arrive, the measured error is no estimate, and the bound E[w^2] <= E[w] for weights up
    to 1 is used."""
    photons = record["photons"]
    if truth * photons > 1000:
        return record[key + "_se"]
    return math.sqrt((truth + 1 / photons) / photons)


def check_balance(verdict, name, record):
    """Checks rules P9 and P10: no packet is lost, and the weight balances exactly."""
    verdict.check(name, record["lost"] == 0, f"lost {record['lost']}")
    verdict.check(name, record["residue"] == 0, f"residue {record['residue']}")


if __name__ == "__main__":  # for scripts: prints an .mco file, and after it, as sections, the arrays that only the .h5 beside it has
    with open(sys.argv[1], encoding="utf-8") as whole:
        text = whole.read()
    print(text)
    for name, values in read_sections(sys.argv[1]).items():
        if f"\n{name} " not in text and f"\n{name}\n" not in text:
            print(f"{name} #", *(f"{value:.9G}".replace("nan", "NAN") for value in values), "", sep="\n")
