#!/usr/bin/env python3
"""Which roulette? The measurement by which its default was chosen: roulette.py [--rounds N] [--only SCENE,...]
[--program PATH]

Flies S1 to S6b, the seven shapes and a thick absorber with MCML's rule and with windows WR,WS, and compares their figures
of merit, 1 / (variance x cost), with MCML's: of Rd, Tt and A; of each profile, the geometric mean over its bins with a
relative error below one half, the last bin (with all that lies beyond) left out; and of the deepest quarter of these
bins of A(z). Variances are the squares of printed standard errors, means over the rounds, which differ in their seeds; in a
round all rules fly the same seed, one after the other. Cost is steps, the same on every machine; beside them stands the
processor time, the median over rounds of its ratio to MCML's. Prints the table, the least figure of every window (by
either cost), and the largest window that, counted in steps, loses no tenth of any figure. The outermost quarters of the
bins of Rd(r) and Tt(r) are printed, not judged. bench/README.md has its output.
SPDX-License-Identifier: MIT
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import cases

MCML = "mcml"
WINDOWS = ("0.003,0.01", "0.01,0.03", "0.03,0.1", "0.1,0.3")
SHAPES = ("hihill", "hicrater", "hinoise", "lohill", "locrater", "lonoise", "flat50")
SCENES = {name: path for name, path in cases.SCENES.items() if name != "A"}
SCENES.update({name: "samples/shapes/%s.mci" % name for name in SHAPES}, absorber="bench/scenes/absorber.mci")
STEPS, STEPS_CURVED = 5e7, 1e7  # of a run; a step near a curved boundary takes longer
PILOT = 1000
TOTALS, PROFILES = ("Rd", "Tt", "A"), ("A_z", "Rd_r", "Tt_r", "Rd_a", "Tt_a")
END = {"A_z": "deep A_z", "Rd_r": "outer Rd_r", "Tt_r": "outer Tt_r"}  # the last quarter of a profile's bins
UNJUDGED = (END["Rd_r"], END["Tt_r"])
COLUMNS = TOTALS + ("A_z", END["A_z"], "Rd_r", END["Rd_r"], "Tt_r", END["Tt_r"])
LEAST_BINS = 4
KEPT = 0.9  # of a figure


class Rule:
    """What a scene gave under one rule: lists with an entry per round."""

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


def read_profiles(path):
    """The profiles of an .mco file and their errors: {key: [values]}."""
    wanted = PROFILES + tuple("se_" + key for key in PROFILES)
    sections, key = {}, None
    with open(path, encoding="utf-8") as file:
        for line in file:
            word = line.split("#")[0].split()
            if word and word[0][0].isalpha():
                key = word[0]
                sections[key] = []
            elif word and key in wanted:
                sections[key].append(float(word[0]))
    return sections


def fly(program, scene, rule, photons, seed, folder):
    """(record, profiles) of one run on one thread."""
    command = [program, os.path.join(cases.ROOT, SCENES[scene]), "--roulette", rule, "--photons", str(photons), "--seed",
               str(seed), "--threads", "1", "--json", "--quiet", "-o", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("roulette.py: %s: exit %d: %s" % (" ".join(command), done.returncode, done.stderr.strip()))
    record = json.loads(done.stdout)
    return record, read_profiles(record["files"][0])


def measure(program, scene, rounds):
    """{rule: Rule}."""
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
    """Bins of a profile but the last with a relative error below one half."""
    pairs = list(zip(rule.variance(key), rule.mean(key)))[:-1]
    return [i for i, (variance, mean) in enumerate(pairs) if 0 < variance < (mean / 2) ** 2]


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def figures(mcml, rule):
    """{name: figure of merit over MCML's}, of what is not 0."""
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
    """Steps and processor time over MCML's."""
    return (sum(rule.steps) / sum(mcml.steps),
            statistics.median(ours / theirs for ours, theirs in zip(rule.cpu, mcml.cpu)))


def print_rule(scene, name, steps, time, found):
    cells = ["%.2f" % found[key] if key in found else "" for key in COLUMNS]
    print("| %s | %s | %.2f | %.2f | %s |" % (scene, name, steps, time, " | ".join(cells)), flush=True)


def print_heads(heads):
    print("| %s |" % " | ".join(heads))
    print("|%s" % ("---|" * len(heads)), flush=True)


def print_verdict(all_found):
    """all_found: {window: [(figure, figure by time, scene, name)]}."""
    print()
    print_heads(("window", "least figure", "of", "least by time", "of", "geometric mean of all"))
    chosen = "none"
    for window, found in all_found.items():
        least, by_time = min(found), min(found, key=lambda row: row[1])
        print("| %s | %.2f | %s, %s | %.2f | %s, %s | %.2f |" % (
            window, least[0], *least[2:], *by_time[1:], geometric_mean(row[0] for row in found)))
        chosen = window if least[0] >= KEPT else chosen
    print("\nlargest that keeps %g of every figure: %s" % (KEPT, chosen))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--only", default=",".join(SCENES))
    parser.add_argument("--program", default=os.path.join(cases.ROOT, "build", "clustermcml"))
    arguments = parser.parse_args()
    scenes = arguments.only.split(",")
    if arguments.rounds < 1 or not set(scenes) <= set(SCENES) or not os.path.exists(arguments.program):
        parser.error("needs rounds, a built program, and scenes out of " + ",".join(SCENES))
    print_heads(("scene", "window", "steps", "time") + COLUMNS)
    all_found = {window: [] for window in WINDOWS}
    for scene in scenes:
        rules = measure(arguments.program, scene, arguments.rounds)
        for window in WINDOWS:
            found = figures(rules[MCML], rules[window])
            steps, time = costs(rules[MCML], rules[window])
            print_rule(scene, window, steps, time, found)
            all_found[window] += [(figure, figure * steps / time, scene, name) for name, figure in found.items()
                                  if name not in UNJUDGED]
    print_verdict(all_found)


if __name__ == "__main__":
    main()
