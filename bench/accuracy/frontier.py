#!/usr/bin/env python3
"""Charts the time that each way to fly a scene takes to an error, against its bias, before and after lattice sampling and the roulette window:

    frontier.py [--quick] [--only SCENE,...] [--rounds N] [--mcml PATH] [--program PATH] [--out DIR]

By default the program is build/clustermcml and DIR is bench/out. Leaves frontier.csv, frontier.txt and, with matplotlib, frontier.svg. --mcml is a
binary of original MCML, which is timed on the same scenes without their shapes. --only selects scenes, and draws nothing.

    frontier.py --draw CSV SVG

draws a result again. bench/accuracy/README.md explains the chart.

`before` is MCML's own sampling and roulette, `after` the program's defaults. Every round runs both, one after the other, on one thread. Times are
processor times of the flight, and ratios are formed within a round.

SPDX-License-Identifier: MIT
"""
import concurrent.futures
import math
import os
import shutil
import statistics
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import chart
import command
import frontier_chart
import frontier_scenes
import frontier_table
import runs
import tables

VARIANTS = {"before": ["--sampling", "random", "--roulette", "mcml"], "after": []}
TOTALS = ("Rd", "A", "Tt")
PROFILES = ("A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a")
ERROR, SMALL_ERROR = 1e-3, 1e-4
LEAST = 1e-2  # share of the light below which totals are left out of the worst one
LEAST_BIN = 1e3  # bins count if the variance of a packet over the square of the mean is smaller: content of some 1e-3
PAIRS = 16  # number of independent streams for biases
CORES = 2
TRIAL = 2000


class Series:
    """All runs of one method on one scene: a list per variant, and one longer run to the smaller error."""

    def __init__(self, scene, method):
        self.scene, self.method = scene, method
        self.photons, self.runs = {}, {"before": [], "after": [], "mcml": []}
        self.small, self.bias, self.mcml_start = None, None, 0.0


# ---- runs

def sections_of(path):
    """Returns (value, standard error) of every bin of every profile. Grids over two variables, which are long, are not parsed."""
    with open(path) as stream:
        text = stream.read()
    bins = []
    for name in PROFILES:
        both = []
        for key in (name, "se_" + name):
            begin = text.find("\n%s " % key)
            lines = text[text.index("\n", begin + 1):].split("\n", 20000) if begin >= 0 else []
            end = lines.index("", 1) if "" in lines[1:] else len(lines)
            both.append([float(line) for line in lines[1:end]])
        if len(both[0]) == len(both[1]):
            bins += zip(*both)
    return bins


def fly(program, scene, method, variant, photons, seed, profiles=True):
    """Makes one run on one thread. Returns its record, with the bins of profiles if profiles=True."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, scene.path, "--json", "--threads", "1", "--photons", str(int(photons)), "--seed", str(seed), "-o", out,
                   "--checkpoint", "off"] + method.options + VARIANTS[variant] + ([] if profiles else ["--ignore-absorption"])
        (record,) = runs.records(command)
        record["bins"] = sections_of(record["output"]) if profiles else []
        return record


# ---- numbers of a run

def relative(run, total):
    return run[total + "_se"] / run[total]


def seconds_to(run, total, error=ERROR):
    return run["cpu_s"] * (relative(run, total) / error) ** 2


def mean_error(run):
    """Returns the geometric mean of the relative errors of the totals."""
    return math.exp(statistics.fmean(math.log(relative(run, total)) for total in TOTALS))


def counting_bins(run):
    """Returns the indices of bins with enough content to compare standard errors."""
    return [i for i, (value, error) in enumerate(run["bins"])
            if value > 0 < error and run["photons"] * (error / value) ** 2 < LEAST_BIN]


def bin_seconds(run, bins):
    """Returns the geometric mean over bins of the seconds to ERROR."""
    logs = [math.log(run["bins"][i][1] / run["bins"][i][0] / ERROR) for i in bins if run["bins"][i][1] > 0 < run["bins"][i][0]]
    return run["cpu_s"] * math.exp(2 * statistics.fmean(logs)) if logs else math.nan


# ---- measuring

def calibrate(program, series, target):
    """Sets the photons of a run: as many as ERROR needs with `after`, but at most twice `target` seconds. `before` gets as many, so that costs that
    do not depend on length weigh equally in both."""
    wanted = TRIAL
    for _ in range(3):  # errors do not fall exactly with the root of the photons
        run = fly(program, series.scene, series.method, "after", wanted, 1)
        limits = run["photons"] / run["cpu_s"] * target
        wanted = int(min(max(run["photons"] * (mean_error(run) / ERROR) ** 2, 0.1 * limits, TRIAL), 2 * limits))
    series.photons["before"] = series.photons["after"] = wanted


def measure_round(program, mcml, series, index):
    for variant in ("before", "after") if index % 2 == 0 else ("after", "before"):
        series.runs[variant].append(fly(program, series.scene, series.method, variant, series.photons[variant], index + 2))
    if "mcml" in series.photons:
        seconds = runs.fly_mcml(mcml, series.scene.flat, series.photons["mcml"])[0] - series.mcml_start
        series.runs["mcml"].append(seconds / series.photons["mcml"])


def measure_small(program, series, target):
    """Makes one run towards SMALL_ERROR, as far as the time allows. Flat scenes, whose bias it shows, get three times as much time."""
    target *= 3 if series.scene.exact else 1
    last = series.runs["after"][-1]
    photons = min(last["photons"] * (mean_error(last) / SMALL_ERROR) ** 2, last["photons"] / last["cpu_s"] * target)
    series.small = fly(program, series.scene, series.method, "after", max(photons, TRIAL), 100, profiles=False)


# ---- biases

def against_exact(series):
    """Returns {total: (relative bias, its error)} of each variant against adding-doubling, from all runs."""
    found, truth = {}, series.scene.exact
    for variant in VARIANTS:
        runs = series.runs[variant] + [series.small] * (variant == "after")
        photons = sum(run["photons"] for run in runs)
        means = {total: sum(run["photons"] * run[total] for run in runs) / photons for total in TOTALS}
        errors = {total: math.hypot(*(run["photons"] * run[total + "_se"] for run in runs)) / photons for total in TOTALS}
        found[variant] = {total: (means[total] / truth[total] - 1, errors[total] / truth[total]) for total in TOTALS}
    return found


def paired(program, scene, all_series, budget, pool):
    """Returns biases of the scene's methods against its truth, from differences of the same packets in PAIRS streams."""
    trial = fly(program, scene, scene.truth, "after", 200, 1, False)
    photons = max(200, 200 * budget / trial["cpu_s"] / PAIRS)
    methods = [scene.truth] + [series.method for series in all_series]
    begun = [[pool.submit(fly, program, scene, method, "after", photons, 1000 + seed, False) for seed in range(PAIRS)]
             for method in methods]
    truth, *others = [[future.result() for future in futures] for futures in begun]
    for series, runs in zip(all_series, others):
        found = {}
        for total in TOTALS:
            known = statistics.fmean(run[total] for run in truth)
            differences = [(run[total] - other[total]) / known for run, other in zip(runs, truth)]
            found[total] = (statistics.fmean(differences), statistics.stdev(differences) / PAIRS ** 0.5)
        series.bias = dict.fromkeys(VARIANTS, found)


# ---- rows

def ratios(series, seconds):
    """Returns the median, least and largest ratio of the times before and after, formed in each round."""
    values = [seconds(a) / seconds(b) for a, b in zip(series.runs["before"], series.runs["after"])]
    return statistics.median(values), min(values), max(values)


def of_totals(run):
    return run["cpu_s"] * (mean_error(run) / ERROR) ** 2


def gains(series):
    """Returns the columns gain_*: the ratio of the times to equal error, before over after."""
    bins = [i for i in counting_bins(series.runs["before"][0]) if series.runs["after"][0]["bins"][i][1] > 0]
    columns = [(total, lambda run, total=total: seconds_to(run, total)) for total in TOTALS]
    columns += [("totals", of_totals), ("profiles", lambda run: bin_seconds(run, bins))]
    row = {"bins": len(bins)}
    for name, seconds in columns:
        median, least, most = ratios(series, seconds)
        row.update({"gain_" + name: median, "gain_%s_min" % name: least, "gain_%s_max" % name: most})
    return row


def mcml_gains(series):
    """Returns the ratio of original MCML's time to equal error, from its time per photon and the variance of `before`."""
    row = {}
    for total in TOTALS:
        values = [per_photon * run["photons"] * (relative(run, total) / ERROR) ** 2 / seconds_to(after, total)
                  for per_photon, run, after in zip(series.runs["mcml"], series.runs["before"], series.runs["after"])]
        row["mcml_" + total] = statistics.median(values) if values else ""
    return row


def worst(values, runs):
    """Returns the total, among those above LEAST, with the largest value."""
    return max((total for total in TOTALS if runs[0][total] > LEAST), key=values)


def row_of(series, variant):
    runs = series.runs[variant]
    bias = series.bias[variant]
    slowest = worst(lambda total: statistics.median(seconds_to(run, total) for run in runs), runs)
    biased = worst(lambda total: abs(bias[total][0]), runs)
    boundary = runs[0]["boundaries"][0]
    row = {"scene": series.scene.name, "method": series.method.name, "variant": variant, "kind": boundary["kind"],
           "primitives": boundary["primitives"], "photons": runs[0]["photons"],
           "ns_per_photon": statistics.median(1e9 * run["cpu_s"] / run["photons"] for run in runs),
           "steps_per_photon": sum(run["steps"] for run in runs) / sum(run["photons"] for run in runs)}
    for total in TOTALS:
        row["s_" + total] = statistics.median(seconds_to(run, total) for run in runs)
    far = series.small if variant == "after" else runs[0]
    row.update(slowest=slowest, s_worst=row["s_" + slowest], s_worst_small=seconds_to(far, slowest, SMALL_ERROR)
               if variant == "after" else 100 * row["s_" + slowest], flown_error=relative(far, slowest), bias=bias[biased][0],
               bias_se=bias[biased][1], biased=biased, truth="adding-doubling" if series.scene.exact else "reference")
    return row


def difference(series):
    """Returns (after - before) over its error, for the total that differs most. The sampling must not change results."""
    def z(total):
        means = [statistics.fmean(run[total] for run in series.runs[variant]) for variant in VARIANTS]
        squares = sum(run[total + "_se"] ** 2 for variant in VARIANTS for run in series.runs[variant])
        return (means[1] - means[0]) * len(series.runs["after"]) / math.sqrt(squares)
    return max((z(total) for total in TOTALS), key=abs)


def rows_of(series):
    """Returns two rows, before and after, and a row of original MCML if it was timed. That row has the bias of the plane, and a hundred times the
    time for a tenth of the error."""
    before, after = row_of(series, "before"), row_of(series, "after")
    blank = dict.fromkeys(list(gains(series)) + ["z_before"] + list(mcml_gains(series)), "")
    after_row = {**after, **gains(series), "z_before": difference(series), **mcml_gains(series)}
    rows = [{**before, **blank}, after_row]
    if series.runs["mcml"]:
        per_photon = 1e9 * statistics.median(series.runs["mcml"])
        times = per_photon / before["ns_per_photon"]
        slower = {key: times * before[key] for key in before if key.startswith("s_")}
        plane = {key: after[key] for key in ("bias", "bias_se", "biased")}
        rows.append({**before, **blank, **slower, **plane, "variant": "mcml", "ns_per_photon": per_photon,
                     "photons": series.photons["mcml"]})
    return rows


def measure(program, mcml, scenes, target, rounds):
    """Measures all series in runs of about `target` seconds, and returns them."""
    begin = time.time()
    everything = [Series(scene, method) for scene in scenes for method in scene.methods]
    say = lambda text: print("%4.0f s  %s" % (time.time() - begin, text), file=sys.stderr, flush=True)  # noqa: E731
    say("calibrating")
    for series in everything:
        calibrate(program, series, target)
        if mcml and series.method.name == "plane":
            series.mcml_start, series.photons["mcml"] = runs.calibrate_mcml(mcml, series.scene.flat, target)
    for index in range(rounds):
        say("round %d of %d" % (index + 1, rounds))
        for series in everything if index % 2 == 0 else everything[::-1]:
            measure_round(program, mcml, series, index)
    say("errors of %g" % SMALL_ERROR)
    for series in everything:
        measure_small(program, series, 10 * target)
    with concurrent.futures.ThreadPoolExecutor(CORES) as pool:
        for scene in scenes:
            say("biases of %s" % scene.name)
            mine = [series for series in everything if series.scene is scene]
            if scene.truth:
                paired(program, scene, mine, 10 * target, pool)
            else:
                mine[0].bias = against_exact(mine[0])
    return everything


def draw(csv, target):
    frontier_chart.draw(tables.read_csv(csv)[1], target)


def main():
    parser = command.parser(__doc__, "quick")
    parser.add_argument("--only", default="", metavar="SCENE,...")
    parser.add_argument("--rounds", type=command.count)
    parser.add_argument("--mcml", type=command.built)
    command.instead(parser, "--draw", ("CSV", "SVG"), draw, "matplotlib")
    arguments = parser.parse_args()
    names = command.only(arguments.only, frontier_scenes.NAMES, parser)
    begin, busy = time.time(), runs.busy_seconds()
    target, rounds = (0.1, 5) if arguments.quick else (0.25, 7)
    rounds = arguments.rounds or rounds
    with tempfile.TemporaryDirectory() as work:
        program = shutil.copy(arguments.program, work)  # a copy, which nobody rebuilds between two rounds
        scenes = [scene for scene in frontier_scenes.all_scenes(work) if scene.name in names]
        everything = measure(program, arguments.mcml, scenes, target, rounds)
    header = tables.machine(arguments.program, rounds)
    header += [("length", "quick" if arguments.quick else "full"), ("original MCML", "timed" if arguments.mcml else "not timed"),
               ("seconds", "%.0f" % (time.time() - begin))]
    if busy is not None:
        header.append(("cores busy", "%.1f of %d" % ((runs.busy_seconds() - busy) / (time.time() - begin), os.cpu_count())))
    rows = [row for series in everything for row in rows_of(series)]
    kept = os.path.join(arguments.out, "frontier")
    tables.write_csv(kept + ".csv", header, rows)
    tables.keep(kept + ".txt", frontier_table.lines(header, rows))
    if not arguments.only:
        chart.draw_result(draw, kept + ".csv", kept + ".svg")


if __name__ == "__main__":
    main()
