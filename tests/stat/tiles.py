"""Tests a tile of straight waves along x against one along y, which is the same scene turned by 90 degrees. Also tests
half-flat grooves in slanted light.

Light at normal incidence, so that the beam turns with the scene. N = 4e5 each, totals Rsp, Rd, A and Tt, different random
numbers; level 1e-4 over the four differences. The totals would differ if the periods of x and y were exchanged in one place,
or the slopes of one axis taken twice: a wave of twice the height is told apart, too, as the last line shows.

In slanted light Rsp of `beam rectangle tile` is the same for any position of the beam, along x and along y: N = 4e5 at each
of four places, level 1e-4 over six differences from the first. A rectangle as wide as the period covers 1.41 periods at 45
degrees, and is told apart."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS = 400000
CELLS, SPACING = 32, 0.1 / 32


def write_waves(path, height, along_x):
    waves = [height * math.sin(2 * math.pi * i / CELLS) for i in range(CELLS)]
    with open(path, "w", encoding="ascii") as file:
        rows = 8 if along_x else CELLS
        file.write(f"ncols {CELLS if along_x else 8}\nnrows {rows}\ncellsize {SPACING!r}\n")
        for j in range(rows):
            file.write(" ".join(repr(h) for h in (waves if along_x else [waves[j]] * 8)) + "\n")
    return f'm "{path}" units=cm tile'


def write_grooves(path, along_x):
    """Writes grooves: half of the period is flat, half a groove of slopes up to 1."""
    heights = [-0.25 * SPACING * CELLS / math.pi * max(0, math.sin(2 * math.pi * i / CELLS)) for i in range(CELLS)]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ncols {CELLS if along_x else 8}\nnrows {8 if along_x else CELLS}\ncellsize {SPACING!r}\n")
        for j in range(8 if along_x else CELLS):
            file.write(" ".join(map(repr, heights if along_x else [heights[j]] * 8)) + "\n")
    return f'm "{path}" units=cm tile'


def check_slanted(verdict, folder):
    """Tests slanted light over a medium that absorbs all light that enters: Rsp is the light that the surface reflects."""
    period, short = CELLS * SPACING, 8 * SPACING
    for axis, azimuth in (("x", 0), ("y", 270)):
        line = write_grooves(os.path.join(folder, "grooves" + axis + ".asc"), axis == "x")

        def places(shape, line=line, axis=axis, azimuth=azimuth):
            beams = [f"beam {shape} angle=45 azimuth={azimuth} at={f'{at},0' if axis == 'x' else f'0,{at}'}"
                     for at in (0, 0.2 * period, 0.4 * period, 0.7 * period)]
            return [cml.run(cml.mci(["1.4 1e4 0 0 0.5"], photons=PHOTONS, surfaces={0: line}, extra=[beam]), "--seed", seed)[0]
                    for seed, beam in enumerate(beams, 1)]

        even = places("rectangle tile")
        for other in even[1:]:
            verdict.z("slanted, grooves along " + axis, other["Rsp"], other["Rsp_se"], even[0]["Rsp"], even[0]["Rsp_se"])
        uneven = places(f"rectangle {period} {short}")
        most = max(abs(a["Rsp"] - b["Rsp"]) / math.hypot(a["Rsp_se"], b["Rsp_se"]) for a in uneven for b in uneven)
        print(axis, [r["Rsp"] for r in even], [r["Rsp"] for r in uneven])
        verdict.check("a rectangle that is no period is seen", most > 6, f"{most:.1f} errors")


def main():
    verdict = cml.Verdict("tiles")
    with tempfile.TemporaryDirectory() as folder:
        records = []
        for name, height, along_x, seed in (("x", 0.02, True, 1), ("y", 0.02, False, 2), ("high", 0.04, True, 3)):
            line = write_waves(os.path.join(folder, name + ".asc"), height, along_x)
            text = cml.mci(["1.4 0.5 20 0.8 0.5"], photons=PHOTONS, surfaces={0: line}, extra=["beam disk 0.05"])
            records.append(cml.run(text, "--seed", seed)[0])
            cml.check_balance(verdict, name, records[-1])
        check_slanted(verdict, folder)
    x, y, high = records
    for key in ("Rsp", "Rd", "A", "Tt"):
        verdict.z(key, x[key], x[key + "_se"], y[key], y[key + "_se"])
    told = max(abs(x[key] - high[key]) / math.hypot(x[key + "_se"], high[key + "_se"]) for key in ("Rsp", "Rd", "A", "Tt"))
    verdict.check("twice the height is seen", told > 6, f"{told:.1f} errors")
    verdict.finish()


if __name__ == "__main__":
    main()
