"""Tests that meshes, and the surfaces that `auto` chooses, keep the bias that --tolerance allows, against cones on the same
photon streams.

Meshes of lohill and hinoise: 16 streams of N = 8000 packets each, flown in both ways, give paired differences of Rd, A and
Tt. The statistic is the excess of the difference over the tolerance, in its own standard errors (Student, 15 degrees of
freedom), level 1e-4 over all numbers. Tolerances are loose, so that the test would see a factor of two: a mesh at five times
the tolerance is tried, too, and must fail.

Planes (tests/lib/paired_planes.py, 16 streams of N = 4000): grazing light on a slope, light near the critical angle, a lens
above a long clear layer. Height times mut plus slope, a rule of former versions, is below the tolerance in these scenes. The
change by a plane is above it by more than 6 errors, and auto must keep the cones. Two ripples must become planes, and no
total, profile or bin of theirs may exceed the tolerance by 3 errors."""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import paired_planes  # noqa: E402
import profiles  # noqa: E402

RUNS, PHOTONS, TOTALS = 16, 8000, ("Rd", "A", "Tt")


def repeated(scene):
    """Returns the scene RUNS times in one file: every run has its own streams."""
    with open(os.path.join(cml.SAMPLES, "shapes", scene + ".mci"), encoding="utf-8") as file:
        lines = [line for line in (line.split("#")[0].strip() for line in file) if line]
    return "\n".join(["1.0", str(RUNS)] + [line for run in range(RUNS) for line in [f"out{run}.mco A"] + lines[3:]]) + "\n"


def sections_of(text, *options):
    """Returns (records, profiles in groups of 20 rings) of all runs."""
    with tempfile.TemporaryDirectory() as keep:
        records = cml.run(text, "--photons", PHOTONS, "--ignore-absorption", "--threads", 2, *options, keep=keep)
        rings = []
        for record in records:
            sections = cml.read_sections(record["output"])
            rings.append([value for key in ("Rd_r", "Tt_r") for value in profiles.ring_sums(sections[key], 0.005, 20)])
        return records, rings


def excess(ours, truth, tolerance):
    """Returns the largest (|difference| - tolerance * truth) / standard error over the totals, and its name."""
    worst = (-math.inf, "")
    for key in TOTALS:
        differences = [a[key] - b[key] for a, b in zip(ours, truth)]
        error = statistics.stdev(differences) / math.sqrt(RUNS)
        most = tolerance * statistics.fmean(record[key] for record in truth)
        worst = max(worst, ((abs(statistics.fmean(differences)) - most) / max(error, 1e-12), key))
    return worst


def profile_distance(ours, truth):
    """Returns the relative L2 distance of the mean profiles, without the part of the noise."""
    square = norm = 0.0
    for a, b in zip(zip(*ours), zip(*truth)):
        differences = [x - y for x, y in zip(a, b)]
        square += statistics.fmean(differences) ** 2 - statistics.variance(differences) / RUNS
        norm += statistics.fmean(b) ** 2
    return math.sqrt(max(square, 0.0) / norm)


def ripple(n, height, spacing):
    return f"b {n} " + " ".join(f"{height * ((n - 1 - i) % 2):.9g} {spacing:.9g}" for i in range(n))


# Scenes and tolerances that a plane in place of the ripple keeps.
HARMLESS = [
    (paired_planes.Scene("ripple", ripple(51, 2e-5, 0.01), ["1.4 1 10 0.8 0.5"]), 0.03),
    (paired_planes.Scene("slanted", ripple(51, 2e-5, 0.01), ["1.4 1 10 0 1"], beam="disk 0.2 angle=60",
                         grid="0.02 0.02", bins="25 25 1"), 0.03),
]


def boundary_of(scene, tolerance):
    """Returns the record of a scene's curved boundary, with the surface that auto chooses."""
    return cml.run(scene.text(scene.surface), "--photons", 100, "--tolerance", tolerance)[0]["boundaries"][scene.at]


def check_planes(verdict):
    for scene, tolerance in paired_planes.DECEPTIVE:
        boundary = boundary_of(scene, tolerance)
        bias = paired_planes.Bias(scene, 4000)
        (over, key), _ = bias.excess(tolerance)
        print(f"{scene.name} {tolerance:g}: {boundary['kind']}; a plane changes {key} by {bias.series[key][0]:.2g}")
        verdict.check(scene.name, over > 6, f"a plane exceeds {tolerance:g} by {over:.1f} errors only")
        verdict.check(scene.name, boundary["kind"] == "cone" and "as a plane" in boundary["reason"], boundary["reason"])
    for scene, tolerance in HARMLESS:
        boundary = boundary_of(scene, tolerance)
        bias = paired_planes.Bias(scene, 4000)
        worst = bias.excess(tolerance)
        print(f"{scene.name} {tolerance:g}: {boundary['kind']}, expected {boundary['bias']:.2g}, excess {worst}")
        verdict.check(scene.name, boundary["kind"] == "plane" and 0 < boundary["bias"] <= tolerance, boundary["reason"])
        verdict.check(scene.name, max(worst)[0] < 3, worst)
        verdict.check(scene.name, bias.clean, "books")


def main():
    verdict = cml.Verdict("tolerance")
    limit = profiles.student_limit(2 * len(TOTALS), freedom=RUNS - 1)
    check_planes(verdict)
    tolerance, cones = 1e-2, {}
    for scene in ("lohill", "hinoise"):
        text = repeated(scene)
        truth, true_rings = cones[scene] = sections_of(text, "--boundaries", "cone")
        ours, rings = sections_of(text, "--tolerance", tolerance, "--boundaries", "mesh")
        over, key = excess(ours, truth, tolerance)
        distance = profile_distance(rings, true_rings)
        name = f"{scene} {tolerance:g} {ours[0]['boundaries'][0]['kind']}"
        print(f"{name}: {key} exceeds the tolerance by {over:+.1f} errors, profile differs by {distance:.2g}")
        verdict.check(name, over < limit and distance < tolerance, f"{key} by {over:.1f} errors, profile {distance:.2g}")
        verdict.check(name, all(record["lost"] == 0 and record["residue"] == 0 for record in ours), "books")
    _, rings = sections_of(repeated("hinoise"), "--boundaries", "mesh", "--tolerance", 0.05)
    verdict.check("a coarse mesh is seen", profile_distance(rings, cones["hinoise"][1]) > 0.01)
    verdict.finish(limit)


main()
