#!/usr/bin/env python3
"""Measures roulette rules, for the choice of the default: roulette.py [--rounds N] [--only SCENE,...] [--program PATH] [--out DIR]

S1 to S6b, the seven shapes and a thick absorber are simulated with MCML's rule and with windows WR,WS. Figures of merit, 1 / (variance x cost), are
compared with MCML's: for Rd, Tt and A; for each profile, as the geometric mean over its bins with a relative error below one half, without the last
bin (with all light beyond); and for the deepest quarter of these bins of A(z). Variances are squares of printed standard errors, averaged over the
rounds, which differ in their seeds. In a round all rules use the same seed, one after the other. Cost is steps, equal on every machine. Beside it
stands the processor time, as the median over rounds of its ratio to MCML's.

Leaves roulette-scenes.md and roulette.md in DIR. roulette.md has the least figure of every window (by either cost), and the largest window that,
counted in steps, loses no tenth of any figure. The outermost quarters of the bins of Rd(r) and Tt(r) are printed but not judged.

SPDX-License-Identifier: MIT
"""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import runs
import tables

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import cml  # noqa: E402

MCML = "mcml"
WINDOWS = ("0.003,0.01", "0.01,0.03", "0.03,0.1", "0.1,0.3")
SHAPES = ("hihill", "hicrater", "hinoise", "lohill", "locrater", "lonoise", "flat50")
SCENES = {name: path for name, path in cases.SCENES.items() if name != "A"}
SCENES.update({name: "samples/shapes/%s.mci" % name for name in SHAPES}, absorber="bench/lib/scenes/absorber.mci")
STEPS, STEPS_CURVED = 5e7, 1e7  # steps of a run; a step near a curved boundary takes longer
PILOT = 1000
TOTALS, PROFILES = ("Rd", "Tt", "A"), ("A_z", "Rd_r", "Tt_r", "Rd_a", "Tt_a")
END = {"A_z": "deep A_z", "Rd_r": "outer Rd_r", "Tt_r": "outer Tt_r"}  # the last quarter of a profile's bins
UNJUDGED = (END["Rd_r"], END["Tt_r"])
COLUMNS = TOTALS + ("A_z", END["A_z"], "Rd_r", END["Rd_r"], "Tt_r", END["Tt_r"])
LEAST_BINS = 4
KEPT = 0.9  # least share of a figure that a window must keep


class Rule:
    """The results of a scene under one rule: lists with an entry per round."""

    def __init__(self):
        self.steps, self.cpu, self.variances, self.means = [], [], {}, {}

    def add(self, record, sections):
        self.steps.append(record["steps"])
        self.cpu.append(record["cpu_s"])
        for key in TOTALS:
            self.variances.setdefault(key, []).append([record[key + "_se"] ** 2])
        for key in PROFILES:
            if len(sections[key]) > LEAST_BINS:
                self.variances.setdefault(key, []).append([error ** 2 for error in sections["se_" + key]])
                self.means.setdefault(key, []).append(sections[key])

    def variance(self, key):
        return [statistics.fmean(values) for values in zip(*self.variances[key])]

    def mean(self, key):
        return [statistics.fmean(values) for values in zip(*self.means[key])]


def fly(program, scene, rule, photons, seed, folder):
    """Returns (record, profiles) of one run on one thread."""
    (record,) = runs.records([program, os.path.join(cases.ROOT, SCENES[scene]), "--roulette", rule, "--photons", str(photons),
                              "--seed", str(seed), "--threads", "1", "--json", "--quiet", "-o", folder])
    return record, cml.read_sections(record["files"][0])


def measure(program, scene, rounds):
    """Returns {rule: Rule} of a scene."""
    rules = {name: Rule() for name in (MCML,) + WINDOWS}
    with tempfile.TemporaryDirectory() as folder:
        pilot, _ = fly(program, scene, MCML, PILOT, 1, folder)
        curved = any(boundary["kind"] != "plane" for boundary in pilot["boundaries"])
        photons = int((STEPS_CURVED if curved else STEPS) / pilot["steps"] * PILOT)
        for seed in range(1, rounds + 1):
            for name, rule in rules.items():
                rule.add(*fly(program, scene, name, photons, seed, folder))
    return rules


def bins_that_count(rule, key):
    """Returns the bins of a profile with a relative error below one half, without the last bin."""
    pairs = list(zip(rule.variance(key), rule.mean(key)))[:-1]
    return [i for i, (variance, mean) in enumerate(pairs) if 0 < variance < (mean / 2) ** 2]


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def figures(mcml, rule):
    """Returns {name: figure of merit over MCML's} of numbers that are not 0."""
    cheaper, found = sum(mcml.steps) / sum(rule.steps), {}
    for key in TOTALS:
        (before,), (after,) = mcml.variance(key), rule.variance(key)
        if before > 0:
            found[key] = cheaper * before / after
    for key in mcml.means:
        bins, before, after = bins_that_count(mcml, key), mcml.variance(key), rule.variance(key)
        ratios = [cheaper * before[i] / after[i] for i in bins if after[i] > 0]
        if len(ratios) >= LEAST_BINS:
            found[key] = geometric_mean(ratios)
            if key in END:
                found[END[key]] = geometric_mean(ratios[-(len(ratios) // 4):])
    return found


def costs(mcml, rule):
    """Returns the ratios of steps and of processor time to MCML's."""
    return (sum(rule.steps) / sum(mcml.steps),
            statistics.median(ours / theirs for ours, theirs in zip(rule.cpu, mcml.cpu)))


def row(scene, name, steps, time, found):
    return [scene, name, "%.2f" % steps, "%.2f" % time, *("%.2f" % found[key] if key in found else "" for key in COLUMNS)]


def verdict(all_found):
    """Returns the lines of the second table and of its conclusion. all_found: {window: [(figure, figure by time, scene, name)]}."""
    rows, chosen = [], "none"
    for window, found in all_found.items():
        least, by_time = min(found), min(found, key=lambda one: one[1])
        rows.append([window, "%.2f" % least[0], "%s, %s" % least[2:], "%.2f" % by_time[1], "%s, %s" % by_time[2:],
                     "%.2f" % geometric_mean(one[0] for one in found)])
        chosen = window if least[0] >= KEPT else chosen
    yield from tables.table(("window", "least figure", "of", "least by time", "of", "geometric mean of all"), rows)
    yield ""
    yield "Largest that keeps %g of every figure: %s." % (KEPT, chosen)


def main():
    parser = command.parser(__doc__, rounds=4)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    rows, all_found = [], {window: [] for window in WINDOWS}
    for scene in command.only(arguments.only, SCENES, parser):
        rules = measure(arguments.program, scene, arguments.rounds)
        for window in WINDOWS:
            found = figures(rules[MCML], rules[window])
            steps, time = costs(rules[MCML], rules[window])
            rows.append(row(scene, window, steps, time, found))
            all_found[window] += [(figure, figure * steps / time, scene, name) for name, figure in found.items()
                                  if name not in UNJUDGED]
    about = [tables.measured(tables.machine(arguments.program, arguments.rounds)) + "; %d rounds." % arguments.rounds, ""]
    scenes = tables.table(("scene", "window", "steps", "time") + COLUMNS, rows)
    tables.keep(os.path.join(arguments.out, "roulette-scenes.md"), about + list(scenes))
    tables.keep(os.path.join(arguments.out, "roulette.md"), about + list(verdict(all_found)))


if __name__ == "__main__":
    main()
