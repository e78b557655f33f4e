"""Meshes and what auto takes keep the bias that --tolerance allows, against cones on the same photon streams.

lohill, hinoise and a ripple that auto makes a plane; 16 streams of N = 8000 packets each, flown in both ways, give paired
differences of Rd, A and Tt. The statistic is what the difference exceeds the tolerance by, in its own standard errors
(Student, 15 degrees of freedom), level 1e-4 over all numbers. Loose tolerances, so that the test would see a factor of
two: a mesh at five times the tolerance must fail it, which is tried, too."""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import profiles  # noqa: E402

RUNS, PHOTONS, TOTALS = 16, 8000, ("Rd", "A", "Tt")


def repeated(scene, lower=1):
    """The scene RUNS times in one file: every run has its own streams. lower: divides all heights."""
    with open(os.path.join(cml.SAMPLES, "shapes", scene + ".mci"), encoding="utf-8") as file:
        lines = [line for line in (line.split("#")[0].strip() for line in file) if line]
    for i, words in [(i, line.split()) for i, line in enumerate(lines) if line.startswith("b ")]:
        words[2::2] = [repr(float(word) / lower) for word in words[2::2]]
        lines[i] = " ".join(words)
    return "\n".join(["1.0", str(RUNS)] + [line for run in range(RUNS) for line in [f"out{run}.mco A"] + lines[3:]]) + "\n"


def sections_of(text, *options):
    """(records, profiles in groups of 20 rings) of all runs."""
    with tempfile.TemporaryDirectory() as keep:
        records = cml.run(text, "--photons", PHOTONS, "--ignore-absorption", "--threads", 2, *options, keep=keep)
        rings = []
        for record in records:
            sections = cml.read_sections(record["output"])
            rings.append([value for key in ("Rd_r", "Tt_r") for value in profiles.ring_sums(sections[key], 0.005, 20)])
        return records, rings


def excess(ours, truth, tolerance):
    """Largest (|difference| - tolerance * truth) / standard error over the totals, and its name."""
    worst = (-math.inf, "")
    for key in TOTALS:
        differences = [a[key] - b[key] for a, b in zip(ours, truth)]
        error = statistics.stdev(differences) / math.sqrt(RUNS)
        most = tolerance * statistics.fmean(record[key] for record in truth)
        worst = max(worst, ((abs(statistics.fmean(differences)) - most) / max(error, 1e-12), key))
    return worst


def profile_distance(ours, truth):
    """Relative L2 distance of the mean profiles, the noise's share taken out."""
    square = norm = 0.0
    for a, b in zip(zip(*ours), zip(*truth)):
        differences = [x - y for x, y in zip(a, b)]
        square += statistics.fmean(differences) ** 2 - statistics.variance(differences) / RUNS
        norm += statistics.fmean(b) ** 2
    return math.sqrt(max(square, 0.0) / norm)


def main():
    verdict = cml.Verdict("tolerance")
    limit = profiles.student_limit(4 * len(TOTALS), freedom=RUNS - 1)
    cases = [("lohill", 1, 1e-2, ["--boundaries", "mesh"]), ("hinoise", 1, 1e-2, ["--boundaries", "mesh"]),
             ("hinoise", 1, 1e-3, []), ("lohill", 100, 1e-2, [])]
    cones = {}
    for scene, lower, tolerance, options in cases:
        text = repeated(scene, lower)
        if (scene, lower) not in cones:
            cones[scene, lower] = sections_of(text, "--boundaries", "cone")
        truth, true_rings = cones[scene, lower]
        ours, rings = sections_of(text, "--tolerance", tolerance, *options)
        over, key = excess(ours, truth, tolerance)
        distance = profile_distance(rings, true_rings)
        name = f"{scene}/{lower} {tolerance:g} {ours[0]['boundaries'][0]['kind']}"
        print(f"{name}: {key} exceeds the tolerance by {over:+.1f} errors, profile differs by {distance:.2g}")
        verdict.check(name, over < limit and distance < tolerance, f"{key} by {over:.1f} errors, profile {distance:.2g}")
        verdict.check(name, all(record["lost"] == 0 and record["residue"] == 0 for record in ours), "books")
        if scene == "lohill" and lower > 1:
            verdict.check(name, ours[0]["boundaries"][0]["kind"] == "plane", "is no plane")
    _, rings = sections_of(repeated("hinoise"), "--boundaries", "mesh", "--tolerance", 0.05)
    verdict.check("a coarse mesh is seen", profile_distance(rings, cones["hinoise", 1][1]) > 0.01)
    verdict.finish(limit)


main()
