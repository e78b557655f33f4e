"""Rough layers in a furnace: diffuse light from both sides, nothing absorbs, so radiance over n^2 is one number everywhere.

Shares of the beams: n^2 of their side, n0^2 above and nL^2 below. Then, whatever the shape of the boundaries:
- n0^2 / (n0^2 + nL^2) of the light leaves above, the rest below;
- what leaves below obeys the cosine law, bin by bin of the angle;
- the mean path in a layer is 4 V n^2 / (S0 n0^2 + SL nL^2), V over one period of its tile, S0 and SL the level areas of the
  beams. The mean number of interactions is the sum of mus times path over the layers. Its error is the spread of the runs.
A refraction, a crossing or a free path that is wrong shows. A reflectance that is wrong alike from both sides does not.
N = 40 runs of 3000 a scene; statistic: z from the spread of the runs (39 degrees of freedom), level 1e-4 over all."""
import math
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

RUNS, PHOTONS, NA = 40, 3000, 6
CELLS, CELL = 8, 0.05
PERIOD = CELLS * CELL


def heights(amplitude):
    """A period whose mean is not 0, so that it counts in the thickness of the layers beside it."""
    return [[amplitude * (0.4 + math.sin(2.1 * x + 0.3 * y * y) * math.cos(1.3 * y)) for x in range(CELLS)] for y in range(CELLS)]


def write_tile(path, rows):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ncols {CELLS}\nnrows {CELLS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL}\n")
        file.write("".join(" ".join(repr(h) for h in row) + "\n" for row in rows))


def furnace(verdict, name, layers, amplitudes, n_below=1.0, n_above=1.0):
    """layers: (n, mus, g, d); amplitudes: of the boundaries that are tiles. A column of triangles of equal size has the mean
    height of its corners, and each corner of the grid has as many, so the mean over the period is that of the numbers."""
    with tempfile.TemporaryDirectory() as keep:
        surfaces, lift = {}, [0.0] * (len(layers) + 1)
        for b, amplitude in amplitudes.items():
            rows = heights(amplitude)
            write_tile(os.path.join(keep, f"{b}.asc"), rows)
            surfaces[b] = f'm "{b}.asc" tile=as-is units=cm'
            lift[b] = statistics.fmean(map(statistics.fmean, rows))
        up, down = n_above**2 / (n_above**2 + n_below**2), n_below**2 / (n_above**2 + n_below**2)
        beam = f"beam rectangle {PERIOD} {PERIOD} light=lambertian"
        text = cml.repeated(RUNS, [f"{n} 0 {mus} {g} {d}" for n, mus, g, d in layers], photons=PHOTONS, bins=f"1 1 {NA}",
                            surfaces=surfaces, n_above=n_above, n_below=n_below,
                            extra=[f"{beam} share={up!r}", f"{beam} z=3 angle=180 share={down!r}"])
        records = cml.run(text, "--seed", 5, keep=keep)
        below = [cml.read_sections(record["output"])["Tt_a"] for record in records]
    for record in records:
        cml.check_balance(verdict, name, record)
    spread(verdict, f"{name}: above", [record["Rsp"] + record["Rd"] for record in records], up)
    da = math.pi / 2 / NA
    for i in range(NA):
        law = math.sin((i + 1) * da) ** 2 - math.sin(i * da) ** 2
        width = 2 * math.pi * math.sin((i + 0.5) * da) * da
        spread(verdict, f"{name}: below, angle {i}", [angles[i] * width for angles in below], down * law)
    law = sum(4 * n * n * mus * (d + lift[i] - lift[i + 1]) for i, (n, mus, _, d) in enumerate(layers))
    spread(verdict, f"{name}: interactions", [(record["steps"] - record["crossings"]) / PHOTONS for record in records],
           law / (n_above**2 + n_below**2))


def spread(verdict, name, values, truth):
    verdict.z(name, statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values)), truth)


def main():
    verdict = cml.Verdict("furnace")
    furnace(verdict, "planes", [(1.4, 30, 0.7, 0.1)], {})
    furnace(verdict, "rough top", [(1.4, 30, 0.7, 0.1)], {0: 0.05})
    furnace(verdict, "rough bottom", [(1.5, 20, 0.0, 0.15)], {1: 0.08})
    furnace(verdict, "all rough, on glass", [(1.3, 10, 0.8, 0.3), (1.5, 40, 0.5, 0.2)], {0: 0.06, 1: 0.05, 2: 0.09}, n_below=1.6)
    verdict.finish(limit=5.5)  # of Student's distribution, 32 values at 1e-4 in all


if __name__ == "__main__":
    main()
