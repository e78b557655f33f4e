"""Tests that --tolerance keeps its promise in 40 random scenes over tolerance, angle, index, free path, layers, grid, slope
and height, with radial heightfields and heightmaps.

If `auto` makes a boundary a plane, the bias of the plane is measured against the curved scene: RUNS streams of N packets,
paired (tests/lib/paired_planes.py). The statistic is the excess of a total, a profile (tests/lib/paired_planes.py defines its
difference) or a bin over the tolerance, in its own standard errors from 16 streams: none may reach 3. SEED draws other
scenes. Shared with the program: random numbers and physics; the program's own trial has another seed and about as many
packets."""
import math
import os
import random
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import paired_planes  # noqa: E402

SCENES = int(os.environ.get("SCENES", "40"))
PHOTONS = int(os.environ.get("PHOTONS", "100000"))  # packets per stream


def between(dice, least, most):
    """Returns a random number, uniform in the logarithm."""
    return least * (most / least) ** dice.random()


def heights(dice, n, spacing, slope):
    """Returns n heights that end at 0 and have this largest slope: a tip, a lens, a ripple, or the noise of a scan."""
    kind = dice.choice(("tip", "lens", "ripple", "noise"))
    radii = [i / (n - 1) for i in range(n)]
    if kind == "tip":
        shape = [1 - r for r in radii]
    elif kind == "lens":
        shape = [1 - r * r for r in radii]
    elif kind == "ripple":
        shape = [(n - 1 - i) % 2 for i in range(n)]
    else:
        shape = [dice.gauss(0, 1) for _ in radii]
        shape[-1] = 0
    steepest = max(abs(a - b) for a, b in zip(shape, shape[1:])) / spacing
    sign = dice.choice((-1, 1))
    return kind, [sign * slope * value / steepest for value in shape]


def radial(dice, slope):
    n, spacing = dice.randint(3, 60), between(dice, 0.002, 0.1)
    kind, h = heights(dice, n, spacing, slope)
    return kind, f"b {n} " + " ".join(f"{value:.9g} {spacing:.6g}" for value in h)


def heightmap(dice, slope, folder, index):
    """Writes noise on a grid as an ESRI file whose rim is at 0."""
    n, spacing = dice.randint(5, 30), between(dice, 0.01, 0.1)
    rows = [[dice.gauss(0, slope * spacing / 2) if 0 < i < n - 1 and 0 < j < n - 1 else 0.0 for j in range(n)]
            for i in range(n)]
    path = os.path.join(folder, f"map{index}.asc")
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ncols {n}\nnrows {n}\nxllcorner 0\nyllcorner 0\ncellsize {spacing:.6g}\n")
        file.writelines(" ".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
    return "map", f'm "{path}" units=cm'


def layer(dice):
    mut = between(dice, 0.5, 100)
    albedo = dice.choice((dice.random(), 1 - between(dice, 1e-3, 0.1)))
    g = dice.choice((0, 0.5, 0.9))
    return f"{dice.uniform(1, 1.6):.4g} {mut * (1 - albedo):.6g} {mut * albedo:.6g} {g} {between(dice, 0.5, 30) / mut:.6g}"


def draw(dice, folder, index):
    """Returns a random scene and the tolerance to ask for."""
    tolerance = dice.choice((0.1, 0.05, 0.03, 0.01, 0.003, 0.001))
    slope = tolerance * between(dice, 1e-2, 10)
    layers = [layer(dice) for _ in range(dice.randint(1, 2))]
    if dice.random() < 0.25:
        layers.insert(0, f"{dice.uniform(1, 1.6):.4g} 0 0 0 {between(dice, 0.01, 10):.6g}")
    n_above, n_first = dice.choice((1.0, 1.0, 1.0, 1.5)), float(layers[0].split()[0])
    angle = dice.choice((0, dice.uniform(0, 80), 90 - between(dice, 0.5, 10)))
    if n_above > n_first:  # near total reflection, where slopes matter
        angle = math.degrees(math.asin(n_first / n_above) + dice.uniform(-5, 5) * slope)
        angle = min(max(angle, 1), 89)
    width = between(dice, 0.05, 1) * math.cos(math.radians(angle))  # the light must meet the curved part
    beam = dice.choice(("pencil", f"disk {width:.4g}", f"gaussian {width:.4g}"))
    beam += f" at={dice.choice((0, 1)) * dice.uniform(-width, width):.4g},0"
    kind, surface = heightmap(dice, slope, folder, index) if dice.random() < 0.25 else radial(dice, slope)
    bins = dice.choice(("50 50 10", "100 100 30", "20 20 1"))
    at = dice.choice((0, 0, dice.randint(0, len(layers))))
    scene = paired_planes.Scene(
        f"{index}: {kind} of slope {slope:.2g}, boundary {at} of {len(layers)} layers, {beam} at {angle:.1f} degrees",
        surface, layers, at=at, beam=f"{beam} angle={angle:.6g}", n_above=n_above,
        n_below=dice.choice((1.0, 1.5)), bins=bins,
        grid=f"{between(dice, 0.002, 0.05):.4g} {between(dice, 0.002, 0.05):.4g}")
    return scene, tolerance


def choice(scene, tolerance):
    """Returns the boundary's record of a short run; None if boundaries cross."""
    try:
        return cml.run(scene.text(scene.surface), "--photons", 1000, "--tolerance", tolerance)[0]["boundaries"][scene.at]
    except RuntimeError as refused:
        if " cross at " not in str(refused):
            raise
        return None


def main():
    verdict, dice = cml.Verdict("tolerance_scenes"), random.Random(int(os.environ.get("SEED", "20")))
    gains = []
    with tempfile.TemporaryDirectory() as folder:
        for index in range(SCENES):
            boundary = None
            while boundary is None:
                scene, tolerance = draw(dice, folder, index)
                boundary = choice(scene, tolerance)
            print(f"{scene.name}, T = {tolerance:g}: {boundary['kind']} ({boundary['reason']})", flush=True)
            if boundary["kind"] != "plane":
                continue
            bias = paired_planes.Bias(scene, PHOTONS)
            series, bins = bias.excess(tolerance)
            flat = cml.run(scene.text(scene.surface), "--photons", PHOTONS, "--boundaries", "plane")[0]
            gains.append(bias.seconds / flat["cpu_s"])
            key = max(bias.series, key=lambda key: bias.series[key][0])
            print("    %s %.2g +- %.1g; largest excess %+.1f errors (%s), of a bin %+.1f (%s); %.1f times as fast" %
                  (key, *bias.series[key], *series, *bins, gains[-1]), flush=True)
            verdict.check(scene.name, bias.clean, "books")
            for over, key in (series, bins):
                verdict.check(scene.name, over < 3, f"{key} exceeds {tolerance:g} by {over:.1f} errors")
    verdict.check("planes", len(gains) >= SCENES // 5, f"only {len(gains)} of {SCENES} scenes")
    if gains:
        print(f"{len(gains)} of {SCENES} scenes became planes, {statistics.geometric_mean(gains):.2f} times as fast "
              f"({min(gains):.2f} to {max(gains):.2f})")
    verdict.finish()


main()
