"""A tile of straight waves along x against one along y: the same scene, turned by 90 degrees.

Light at normal incidence, so that the beam turns with it. N = 4e5 each, totals Rsp, Rd, A and Tt, other random numbers;
level 1e-4 over the four differences. With the periods of x and y exchanged in one place, or the slopes of one axis taken
twice, they differ: a wave of twice the height is told apart, too, as the last line shows."""
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


def main():
    verdict = cml.Verdict("tiles")
    with tempfile.TemporaryDirectory() as folder:
        records = []
        for name, height, along_x, seed in (("x", 0.02, True, 1), ("y", 0.02, False, 2), ("high", 0.04, True, 3)):
            line = write_waves(os.path.join(folder, name + ".asc"), height, along_x)
            text = cml.mci(["1.4 0.5 20 0.8 0.5"], photons=PHOTONS, surfaces={0: line}, extra=["beam disk 0.05"])
            records.append(cml.run(text, "--seed", seed)[0])
            cml.check_balance(verdict, name, records[-1])
    x, y, high = records
    for key in ("Rsp", "Rd", "A", "Tt"):
        verdict.z(key, x[key], x[key + "_se"], y[key], y[key + "_se"])
    told = max(abs(x[key] - high[key]) / math.hypot(x[key + "_se"], high[key + "_se"]) for key in ("Rsp", "Rd", "A", "Tt"))
    verdict.check("twice the height is seen", told > 6, f"{told:.1f} errors")
    verdict.finish()


if __name__ == "__main__":
    main()
