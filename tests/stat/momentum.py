"""Tests the momentum transfer of detected light (P13): the sum of 1 - cosine of its scattering angles, by medium.

- Nothing absorbs and detectors see all light. The number of scatterings of a photon is a stopping time, so by Wald's identity
  the mean of the sum is 1 - g times the mean number, with either engine, also with a table of a phase function.
- Two layers that absorb, with the index of air: light in rings and on the other side is compared with a small Monte Carlo of
  this file, which draws by Henyey and Greenstein's formula and weighs by exp(-mua path). Means by medium.
- Saved packets have the same sums as the detectors that saw them.
Statistic: z, level 1e-4 over all."""
import math
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

LAYERS = ((0.5, 30.0, 0.8, 0.1), (0.2, 50.0, 0.9, 0.15))  # mua, mus, g, d of each layer
RINGS = ((0.0, 0.1), (0.1, 0.3))


def wald(verdict, phase, g, engine):
    lines = ["detector disk 1e6 name=up", "detector disk 1e6 side=bottom name=down"]
    with tempfile.TemporaryDirectory() as folder:
        text = cml.mci([f"1.0 0 40 {g} 0.2" + ("\n" + phase if phase else "")], photons=20000, extra=lines)
        record = cml.run(text, "--engine", engine, keep=folder)[0]
        found = cml.read_sections(record["output"])
    seen = {name: record[f"detector_{name}"] for name in ("up", "down")}
    verdict.check(engine, abs(sum(seen.values()) - 1) < 1e-9, f"{seen} is not all the light")
    for name, share in seen.items():
        verdict.check(engine, all(found[f"detector_{name}_momentum"][i] == 0 for i in (0, 2)), "momentum outside")
    means = [sum(share * found[f"detector_{name}_{mean}"][1] for name, share in seen.items()) for mean in ("momentum", "interactions")]
    errors = [math.hypot(*(share * found[f"se_detector_{name}_{mean}"][1] for name, share in seen.items())) for mean in ("momentum", "interactions")]
    # both errors count in full: the numbers of one packet are correlated, so this bound is rather too wide
    verdict.z(f"{engine}, g {g}", means[0], errors[0], (1 - g) * means[1], (1 - g) * errors[1])


def walk(photons, dice):
    """Flies photons of this file. Returns packets that leave: side (0 up, 1 down), radius, weight, momentum by layer."""
    floor, ended = [0, LAYERS[0][3], LAYERS[0][3] + LAYERS[1][3]], []
    for _ in range(photons):
        x = y = z = 0.0
        way, layer, path, moved = (0.0, 0.0, 1.0), 0, [0.0, 0.0], [0.0, 0.0]
        left = -math.log(1 - dice.random())
        while 0 <= layer <= 1:
            mua, mus, g, _ = LAYERS[layer]
            border = (floor[layer + 1] - z if way[2] > 0 else floor[layer] - z) / (way[2] or -1e-300)
            step = min(left / mus, border)
            x, y, z = x + step * way[0], y + step * way[1], z + step * way[2]
            path[layer] += step
            if step == border:
                left -= step * mus
                layer += 1 if way[2] > 0 else -1
                continue
            left = -math.log(1 - dice.random())
            cosine = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * dice.random())) ** 2) / (2 * g)
            moved[layer] += 1 - cosine
            way = turned(way, cosine, 2 * math.pi * dice.random())
        ended.append((int(layer > 1), math.hypot(x, y), math.exp(-sum(layer[0] * flown for layer, flown in zip(LAYERS, path))), moved))
    return ended


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def turned(way, cosine, turn):
    """Returns the unit vector at the angle of `cosine` to `way`, turned about `way` by `turn`."""
    first = cross(way, (1, 0, 0) if abs(way[0]) < 0.6 else (0, 1, 0))
    size, sine = math.hypot(*first), math.sqrt(max(0, 1 - cosine * cosine))
    second = cross(way, first)
    return tuple(cosine * w + sine * (math.cos(turn) * f + math.sin(turn) * s) / size for w, f, s in zip(way, first, second))


def mean_of(values, weights):
    """Returns the mean by weight, and its standard error."""
    total = sum(weights)
    mean = sum(v * w for v, w in zip(values, weights)) / total
    return mean, math.sqrt(sum((w * (v - mean)) ** 2 for v, w in zip(values, weights))) / total


def own(verdict, engine, packets):
    """Compares the program with packets of walk()."""
    lines = [f"detector ring {a} {b} name=r{i}" for i, (a, b) in enumerate(RINGS)] + ["detector disk 1e6 side=bottom name=under", 'photons "all"']
    with tempfile.TemporaryDirectory() as folder:
        text = cml.mci([f"1.0 {mua} {mus} {g} {d}" for mua, mus, g, d in LAYERS], photons=60000, extra=lines)
        record = cml.run(text, "--engine", engine, keep=folder)[0]
        found = cml.read_sections(record["output"])
        saved = cml.read_h5(os.path.join(folder, "all.photons.h5"))
    for k, name in enumerate(("r0", "r1", "under")):
        seen = [packet for packet in packets if (packet[0] == 1 if name == "under" else packet[0] == 0 and RINGS[k][0] <= packet[1] < RINGS[k][1])]
        rows = [row for row, detector in enumerate(saved["detector"]) if detector == k + 1]
        for layer in (0, 1):
            mean, error = mean_of([packet[3][layer] for packet in seen], [packet[2] for packet in seen])
            value = found[f"detector_{name}_momentum"][layer + 1]
            verdict.z(f"{engine}, {name}, layer {layer + 1}", value, found[f"se_detector_{name}_momentum"][layer + 1], mean, error)
            of_rows = mean_of([saved["momentum"][4 * row + layer + 1] for row in rows], [saved["weight"][row] for row in rows])[0]
            verdict.check(f"{engine}, {name}", abs(of_rows - value) < 2e-5 + 1e-5 * value, f"saved packets have {of_rows}, the detector {value}")


def main():
    verdict = cml.Verdict("momentum")
    for engine in ("cpu", "reference"):
        wald(verdict, None, 0.8, engine)
    wald(verdict, None, -0.3, "cpu")
    wald(verdict, "phase rayleigh", 0, "cpu")
    packets = walk(30000, random.Random(11))
    for engine in ("cpu", "reference"):
        own(verdict, engine, packets)
    verdict.finish()


main()
