#!/usr/bin/env python3
"""Compares smooth faces, faces with statistical roughness, and reliefs of any length:

    roughness.py [--quick] [--program PATH] [--out DIR]

Simulates slabs with both faces smooth, `rough beckmann ALPHA`, and `m gaussian ALPHA LENGTH tile` of several lengths. The truth is the relief of
the shortest length. Leaves roughness.csv, roughness_lobes.csv, roughness.md and roughness.svg in DIR; 9 minutes of processor time.

    roughness.py --draw CSV DIRECTORY

makes table and picture of a result again. Needs h5py and matplotlib. bench/accuracy/README.md explains them.

SPDX-License-Identifier: MIT
"""
import concurrent.futures
import itertools
import math
import os
import shutil
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import command
import picture
import runs
import tables

SLABS = {"mismatched": (1.0, 1.5), "matched": (1.33, 1.4)}  # n around the slab, n of the slab
SHOWN = {"mismatched": "n 1.5 in air", "matched": "n 1.4 in water"}
MUA, MUS, G, D = 1, 20, 0.8, 0.5
FREE_PATH = 1 / (MUA + MUS)  # cm
ALPHAS, ANGLES = (0.2, 0.5, 1.0), (0, 60)
LENGTHS = (0.002, 0.01, 0.024, 0.06, 0.1, 0.2)  # cm
POINTS, SEEDS = 128, 6
NT, NP = 30, 24  # bins of direction
TOTALS = ("Rsp", "Rd", "A", "Tt")
JUDGED = TOTALS[1:]  # Rsp of the matched slab is a thousandth of the light
PHOTONS = {"smooth": 2000000, "statistics": 2000000, "fine": 200000, "relief": 70000}  # number of photons of one flight


# ---- measuring

def boundary(method, alpha, length, seed):
    return {"smooth": "# smooth", "statistics": "rough beckmann %g" % alpha,
            "relief": "m gaussian %g %g tile points=%d seed=%d" % (alpha, length, POINTS, seed)}[method]


def scene(slab, angle, method, alpha, length, seed):
    """Returns the text of a scene. Both faces have reliefs of their own. The light is spread over whole periods of the upper one."""
    around, inside = SLABS[slab]
    width = length / 10 * POINTS if method == "relief" else 0.1
    top, bottom = (boundary(method, alpha, length, 2 * seed + k) for k in (0, 1))
    return "1.0\n1\nroughness.h5 B\n1000\n0.1 1\n5 1 1\nbeam rectangle %.9g %.9g angle=%g\ndirections %d %d\n1\n%g\n%s\n%g %g %g %g %g\n%s\n%g\n" % (
        width, width, angle, NT, NP, around, top, inside, MUA, MUS, G, D, bottom, around)


def cases():
    for slab, angle in itertools.product(SLABS, ANGLES):
        yield slab, angle, "smooth", 0.0, 0.0
        for alpha in ALPHAS:
            yield slab, angle, "statistics", alpha, 0.0
            for length in LENGTHS:
                if alpha * length < 0.12:  # with longer reliefs, both faces would meet
                    yield slab, angle, "relief", alpha, length


def lobe(values, errors, angle):
    """Returns (values, errors) over the angle to the vertical, from behind the beam (negative) to ahead of it.

    Bins within 15 degrees of the plane of incidence count, or all azimuths if light comes from straight above."""
    sides = [[NP // 2 - 1, NP // 2], [0, NP - 1]] if angle else [list(range(NP))] * 2
    behind, ahead = ((values[:, bins].mean(axis=1).tolist(), ((errors[:, bins]**2).sum(axis=1)**0.5 / len(bins)).tolist()) for bins in sides)
    return [[*one[::-1], *other] for one, other in zip(behind, ahead)]


def fly(program, case, seed, photons):
    """Returns the record of one flight, with the lobes of light that leaves upwards."""
    import h5py
    with tempfile.TemporaryDirectory() as work:
        path = os.path.join(work, "roughness.mci")
        with open(path, "w", encoding="ascii") as stream:
            stream.write(scene(*case, seed))
        record = runs.records([program, path, "--json", "--quiet", "--threads", "1", "--seed", str(seed), "--photons", str(photons), "-o", work])[0]
        with h5py.File(os.path.join(work, "roughness.h5")) as file:
            record["lobes"] = {name: lobe(file[name + "_dir"][()], file[name + "_dir_se"][()], case[1]) for name in ("Rsp", "Rd")}
    return record


def pooled(values, errors):
    """Returns the mean of several flights and its error: the error that flights report, or the one from their spread, whichever is larger."""
    count = len(values)
    reported = math.sqrt(sum(error**2 for error in errors)) / count
    spread = statistics.stdev(values) / math.sqrt(count) if count > 1 else 0.0
    return statistics.fmean(values), max(reported, spread)


def row_of(case, flights):
    slab, angle, method, alpha, length = case
    photons = sum(flight["photons"] for flight in flights)
    row = {"slab": slab, "angle": angle, "method": method, "alpha": alpha, "length": length, "photons": photons, "flights": len(flights),
           "core_s_per_1e6": 1e6 * sum(flight["cpu_s"] for flight in flights) / photons, "lost": sum(flight["lost"] for flight in flights)}
    for name in TOTALS:
        row[name], row[name + "_se"] = pooled([flight[name] for flight in flights], [flight[name + "_se"] for flight in flights])
    return row


def lobes_of(case, flights):
    """Yields rows of the lobes of the statistics and of the shortest relief."""
    slab, angle, method, alpha, _ = case
    for k in range(2 * NT):
        row = {"slab": slab, "angle": angle, "method": method, "alpha": alpha, "theta": (k - NT + 0.5) * 90 / NT}
        for name in ("Rsp", "Rd"):
            row[name], row[name + "_se"] = pooled(*([flight["lobes"][name][of][k] for flight in flights] for of in (0, 1)))
        yield row


def measure(program, quick):
    """Returns (rows of totals, rows of lobes)."""
    rows, lobes, wanted = [], [], list(cases())
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        def start(case):
            kind = "fine" if case[4] == LENGTHS[0] else case[2]
            photons = PHOTONS[kind] // (50 if quick else 1)
            seeds = range(1, 1 + (SEEDS if case[2] == "relief" else 1))
            return [pool.submit(fly, program, case, seed, photons) for seed in seeds]
        for case, flights in [(case, start(case)) for case in wanted]:
            flights = [flight.result() for flight in flights]
            rows.append(row_of(case, flights))
            if case[2] == "statistics" or case[4] == LENGTHS[0]:
                lobes += lobes_of(case, flights)
            print("%s: %.4f" % (" ".join(map(str, case)), rows[-1]["Rd"]), file=sys.stderr, flush=True)
    return rows, lobes


# ---- reading a result

class Result:
    """Rows of a result by slab, angle, method, alpha and length."""

    def __init__(self, rows):
        self.rows = {(row["slab"], int(row["angle"]), row["method"], float(row["alpha"]), float(row["length"])): row for row in rows}

    def row(self, slab, angle, method, alpha, length=0.0):
        return self.rows.get((slab, angle, method, alpha, length) if method != "smooth" else (slab, angle, method, 0.0, 0.0))

    def ratio(self, row, truth, name):
        """Returns (relative difference from the truth, its error) of one total."""
        value, error, true, true_error = (float(one[key]) for one in (row, truth) for key in (name, name + "_se"))
        return value / true - 1, math.hypot(error / true, value * true_error / true**2)

    def bias(self, slab, angle, alpha, method, name, length=0.0):
        """Returns the bias against the shortest relief, or None if there is no such row."""
        row = self.row(slab, angle, method, alpha, length)
        return row and self.ratio(row, self.row(slab, angle, "relief", alpha, LENGTHS[0]), name)

    def relief(self, slab, angle, alpha, name, lengths):
        """Returns a row with the mean of one total over the reliefs of these lengths, weighted by their errors, or nothing without rows."""
        rows = [row for row in (self.row(slab, angle, "relief", alpha, length) for length in lengths) if row]
        weights = [float(row[name + "_se"])**-2 for row in rows]
        return rows and {name: sum(w * float(row[name]) for w, row in zip(weights, rows)) / sum(weights), name + "_se": sum(weights)**-0.5}

    def off(self, slab, lengths):
        """Yields (relative difference, error, total, alpha, angle) of the statistics from the reliefs of these lengths."""
        for angle, alpha, name in itertools.product(ANGLES, ALPHAS, JUDGED):
            relief = self.relief(slab, angle, alpha, name, lengths)
            if relief:
                yield (*self.ratio(self.row(slab, angle, "statistics", alpha), relief, name), name, alpha, angle)


def per_cent(bias):
    return "%+.1f ± %.1f" % (100 * bias[0], 100 * bias[1]) if bias else "-"


def largest(off):
    """Returns the difference farthest from 0, in words."""
    bias, error, name, alpha, angle = max(off, key=lambda one: abs(one[0]))
    return "%+.1f ± %.1f %% (%s, alpha %g, %d degrees)" % (100 * bias, 100 * error, name, alpha, angle)


def sentences(result):
    """Yields sentences with the figures of the rule."""
    half = [length for length in LENGTHS if length <= 0.51 * FREE_PATH]
    for slab in SLABS:
        off = list(result.off(slab, half))
        rms, noise = (100 * math.sqrt(statistics.fmean(one[k]**2 for one in off)) for k in (0, 1))
        yield ("%s, statistics against the mean of reliefs of at most half a mean free path: %d totals (Rd, A, Tt) differ by %.2f %% in root mean "
               "square, with errors of %.2f %%. The largest difference is %s." % (SHOWN[slab], len(off), rms, noise, largest(off)))
        yield "%s, statistics against longer reliefs, the largest difference by length / mean free path. %s." % (SHOWN[slab], ". ".join(
            "At %.1f: %s" % (length / FREE_PATH, largest(result.off(slab, [length]))) for length in LENGTHS if length not in half))
        yield "%s, smooth faces: the worst of Rd, A and Tt is off by %s." % (SHOWN[slab], "; ".join("%.1f %% at alpha %g" % (
            100 * max(abs(result.bias(slab, angle, alpha, "smooth", name)[0]) for angle in ANGLES for name in JUDGED), alpha) for alpha in ALPHAS))


def chi_squares(lobes, name):
    """Yields, in words and by slab, chi square of the statistics against the shortest relief, over the bins of lobes with any light."""
    for slab, words in SHOWN.items():
        sides = [[row for row in lobes if row["slab"] == slab and row["method"] == method] for method in ("statistics", "relief")]
        pairs = [[(float(row[name]), float(row[name + "_se"])) for row in pair] for pair in zip(*sides)]
        z = [(a - b) / math.hypot(e, f) for (a, e), (b, f) in pairs if e > 0 or f > 0]
        yield "%.0f for %d bins (%s)" % (sum(x * x for x in z), len(z), words)


def seconds(result, slab, angle, alpha):
    """Returns core seconds of 1e6 packets: smooth, statistics, the shortest relief."""
    rows = (result.row(slab, angle, "smooth", alpha), result.row(slab, angle, "statistics", alpha),
            result.row(slab, angle, "relief", alpha, LENGTHS[0]))
    return ", ".join("%.1f" % float(row["core_s_per_1e6"]) for row in rows)


def table(header, rows, lobes):
    result = Result(rows)
    titles = ["slab", "alpha", "angle", "Rsp", "Rd", "A", "Tt", "smooth", "statistics",
              *("relief %.2g" % (length / FREE_PATH) for length in LENGTHS[1:]), "core s"]
    cells = []
    for slab, alpha, angle in itertools.product(SLABS, ALPHAS, ANGLES):
        truth = result.row(slab, angle, "relief", alpha, LENGTHS[0])
        cells.append([SHOWN[slab], alpha, angle, *("%.4f ± %.4f" % (float(truth[name]), float(truth[name + "_se"])) for name in TOTALS),
                      *(per_cent(result.bias(slab, angle, alpha, method, "Rd", length)) for method, length in (
                          ("smooth", 0.0), ("statistics", 0.0), *(("relief", length) for length in LENGTHS[1:]))),
                      seconds(result, slab, angle, alpha)])
    yield tables.measured(header) + "; %d packets lost." % sum(int(row["lost"]) for row in rows)
    yield ""
    yield from tables.table(titles, cells)
    yield ""
    for sentence in sentences(result):
        yield "- " + sentence
    for name, words in (("Rd", "light from inside, Rd_dir"), ("Rsp", "gloss, Rsp_dir")):
        yield "- Lobes of %s, statistics against the shortest relief, all alphas and angles: chi square %s." % (words, ", ".join(chi_squares(lobes, name)))


# ---- the picture

def draw_lengths(axes, result, slab, angle):
    """Draws the bias of Rd over the length. Statistics and smooth faces have no length and stand at the sides."""
    for k, alpha in enumerate(ALPHAS):
        found = [(length / FREE_PATH, result.bias(slab, angle, alpha, "relief", "Rd", length)) for length in LENGTHS]
        found = [(x, *bias) for x, bias in found if bias]
        colour, shift = picture.COLOURS[k], 1.08 ** (k - 1)
        picture.bars(axes, [x * shift for x, _, _ in found], [100 * b for _, b, _ in found], [100 * e for _, _, e in found], colour, line="-")
        for method, mark, x in (("statistics", "s", 0.014), ("smooth", "^", 12.0)):
            bias, error = result.bias(slab, angle, alpha, method, "Rd")
            picture.bars(axes, [x * shift], [100 * bias], [100 * error], colour, mark, 5)
    axes.axvline(0.5, color="#888888", linewidth=0.8, linestyle=":")
    axes.set(xscale="log", xlim=(0.01, 20), title="%s, %d degrees" % (SHOWN[slab], angle), xlabel="corr. length / mean free path")
    axes.set_xticks([0.1, 1], ["0.1", "1"])
    axes.set_xticks([], minor=True)


def draw_times(axes, result, slab, angle):
    """Draws the size of the bias over time. A bias below its error stands at its error, with a hollow mark."""
    marks = [("smooth", "^", 0.0), ("statistics", "s", 0.0), *(("relief", "o", length) for length in LENGTHS[1:])]
    for (k, alpha), (method, mark, length) in itertools.product(enumerate(ALPHAS), marks):
        bias = result.bias(slab, angle, alpha, method, "Rd", length)
        if bias:
            size, error = 100 * abs(bias[0]), 100 * bias[1]
            axes.plot([float(result.row(slab, angle, method, alpha, length)["core_s_per_1e6"])], [max(size, error)], mark,
                      color=picture.COLOURS[k], markersize=3 + 4 * length ** 0.5 / 0.2 ** 0.5 if method == "relief" else 6,
                      markerfacecolor="none" if size < error else picture.COLOURS[k])
    axes.set(xscale="log", yscale="log", xlim=(0.3, 60), ylim=(0.05, 40), xlabel="core seconds per 1e6 packets")
    axes.set_xticks([1, 10], ["1", "10"])
    axes.set_yticks([0.1, 1, 10], ["0.1", "1", "10"])
    axes.set_xticks([], minor=True)
    axes.set_yticks([], minor=True)


def draw_lobes(axes, lobes, angle, name, words):
    for k, alpha in enumerate(ALPHAS):
        def of(method):
            some = [row for row in lobes if row["slab"] == "mismatched" and int(row["angle"]) == angle and row["method"] == method
                    and float(row["alpha"]) == alpha]
            return [[float(row[key]) for row in some] for key in ("theta", name, name + "_se")]
        picture.band(axes, *of("statistics"), picture.COLOURS[k])
        theta, value, error = of("relief")
        picture.bars(axes, theta[::2], value[::2], error[::2], picture.COLOURS[k], size=2.5)
    axes.set(xlim=(-90, 90), ylim=(0, None), xticks=[-60, 0, 60], xlabel="angle to the vertical [degrees]",
             title="%s, %d degrees" % (words, angle))


def draw(csv, directory):
    plt = picture.begin()
    header, rows = tables.read_csv(csv)
    lobes = tables.read_csv(csv.removesuffix(".csv") + "_lobes.csv")[1]
    result, views = Result(rows), list(itertools.product(SLABS, ANGLES))
    figure, axes = plt.subplots(3, 4, figsize=(12.4, 9.4))
    for column, (slab, angle) in enumerate(views):
        draw_lengths(axes[0][column], result, slab, angle)
        draw_times(axes[1][column], result, slab, angle)
        name, words = (("Rsp", "surface, Rsp_dir"), ("Rd", "diffuse, Rd_dir"))[column % 2]
        draw_lobes(axes[2][column], lobes, ANGLES[column // 2], name, words)
    axes[0][0].set_ylabel("relative bias of Rd [%]")
    axes[1][0].set_ylabel("|relative bias| of Rd [%]")
    axes[2][0].set_ylabel("reflected share [1/sr]")
    handles = [plt.Line2D([], [], color=picture.COLOURS[k], linewidth=4, label="alpha %g" % alpha) for k, alpha in enumerate(ALPHAS)]
    handles += [plt.Line2D([], [], color="#444444", marker=mark, linestyle="none", label=words) for mark, words in (
        ("s", "statistics (rough beckmann)"), ("o", "relief (m gaussian)"), ("^", "smooth"))]
    handles.append(plt.Line2D([], [], color="#444444", linewidth=1.2, label="bottom: statistics (lines), relief (dots)"))
    figure.legend(handles=handles, loc="upper center", ncol=7, fontsize=9)
    figure.tight_layout(rect=(0, 0, 1, 0.96), w_pad=1.5, h_pad=1.5)
    os.makedirs(directory, exist_ok=True)
    picture.save(figure, os.path.join(directory, "roughness.svg"))
    tables.keep(os.path.join(directory, "roughness.md"), list(table(header, rows, lobes)))


def main():
    parser = command.parser(__doc__, "quick")
    command.instead(parser, "--draw", ("CSV", "DIRECTORY"), lambda csv, directory: (picture.need(parser, "matplotlib"), draw(csv, directory)))
    arguments = parser.parse_args()
    picture.need(parser, "h5py", "matplotlib")
    with tempfile.TemporaryDirectory() as work:
        rows, lobes = measure(shutil.copy(arguments.program, work), arguments.quick)  # a copy, which nobody rebuilds meanwhile
    header = tables.machine(arguments.program, SEEDS) + [("load", "%.1f of %d cores" % (os.getloadavg()[1], os.cpu_count()))]
    csv = os.path.join(arguments.out, "roughness.csv")
    tables.write_csv(csv, header, rows)
    tables.write_csv(csv.removesuffix(".csv") + "_lobes.csv", header, lobes)
    draw(csv, arguments.out)


if __name__ == "__main__":
    main()
