"""Compares Rd(r) and Tt(r) with profiles made by other programs, per bin or in groups of bins.

Errors come from 64 batches, ranges of photon indices. A z-score therefore follows Student's t with 63 degrees of freedom, and the limit allows for
this. The last bin also holds all light beyond the grid, and is left out.
"""
import csv
import math
import os
import tempfile

import cml


def student_limit(tests, level=1e-4, freedom=63):
    """Returns the limit by Sidak for Student deviates (Cornish-Fisher expansion of the normal quantile)."""
    z = cml.sidak_limit(tests, level)
    first = (z**3 + z) / (4 * freedom)
    second = (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
    return z + first + second


def reference(name):
    """Returns the columns of a reference profile as lists of floats."""
    with open(os.path.join(cml.REFERENCE, "profiles", name), encoding="utf-8") as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {key: [float(row[key]) for row in table] for key in table[0]}


def simulate(scene, photons, *options):
    """Runs a sample. Returns its JSON record and the sections of its .mco."""
    with tempfile.TemporaryDirectory() as keep:
        record = cml.run(os.path.join(cml.SAMPLES, scene), "--photons", photons, "--seed", 7, "--ignore-absorption",
                         *options, keep=keep)[0]
        return record, cml.read_sections(record["output"])


def ring_sums(values, dr, group):
    """Returns sums over groups of bins of value * ring area, without the last bin."""
    weights = [value * 2 * math.pi * (i + 0.5) * dr * dr for i, value in enumerate(values[:-1])]
    return [sum(weights[i:i + group]) for i in range(0, len(weights), group)]


def ring_errors(errors, dr, group):
    squares = [(error * 2 * math.pi * (i + 0.5) * dr * dr) ** 2 for i, error in enumerate(errors[:-1])]
    return [math.sqrt(sum(squares[i:i + group])) for i in range(0, len(squares), group)]


def compare(verdict, name, photons, sections, truth, truth_errors, group=1, dr=0.005):
    """Compares a run with a profile. truth: {'Rd_r': [...], 'Tt_r': [...]}; truth_errors: the same, or a factor on the run's own errors.

    If few packets arrive in a bin, the error from batches is unreliable, and the bound E[w^2] <= E[w] for weights up to 1 is used."""
    for key in ("Rd_r", "Tt_r"):
        ours, errors = ring_sums(sections[key], dr, group), ring_errors(sections["se_" + key], dr, group)
        theirs = ring_sums(truth[key], dr, group)
        few = 1000 / photons
        errors = [e if t > few else max(e, math.sqrt((t + 1 / photons) / photons)) for e, t in zip(errors, theirs)]
        if isinstance(truth_errors, float):
            spread = [truth_errors * error for error in errors]
        else:
            spread = ring_errors(truth_errors[key], dr, group)
        for i, (a, e, b, s) in enumerate(zip(ours, errors, theirs, spread)):
            verdict.z(f"{name} {key} bins {i * group}..{i * group + group - 1}", a, e, b, s)
