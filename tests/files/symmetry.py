"""Tests that a symmetric scene has a map that is symmetric within noise, and that an asymmetric scene has not.

The scenes are a hill of cones lit along its axis, and a wedge of clear gel on the same slab. Every pixel with at least 200 packets is compared with
its mirror images in x, in y and across the diagonal, by the pixels' own standard errors. For the hill, the mean of z^2 is 1 (within 4 of its own
standard deviations, level 6e-5). For the wedge mirrored in x, it is far above. N = 1e6."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py, numpy  # noqa: E402

MESH = os.path.join(os.path.dirname(cml.TESTS), "meshes", "wedge.obj")
PHOTONS, PIXELS, SIZE = 1000000, 21, 0.05  # the number is odd, so that light on the axis falls into the middle of a pixel, not on an edge


def fly(surface, keep):
    text = cml.mci(["1.34 0 0 0 0.15", "1.4 0.2 40 0.8 0.3"], photons=PHOTONS, surfaces={0: surface},
                   extra=[f"map {PIXELS} {PIXELS} {SIZE} {SIZE}"])
    record = cml.run(text, "--ignore-absorption", "--seed", 11, keep=keep)[0]
    with h5py.File(record["output"].replace(".mco", ".h5")) as file:
        return {name: file[name][:].astype(float) for name in ("Rd_xy", "Rd_xy_se", "Tt_xy", "Tt_xy_se")}


def compare(maps, name, mirror):
    """Returns z of every pair of mirrored pixels and the relative difference. Each pair counts once."""
    a, s = maps[name], maps[name + "_se"]
    b, t = mirror(a), mirror(s)
    index = numpy.arange(a.size).reshape(a.shape)
    few = 200 / PHOTONS / SIZE**2
    chosen = (index < mirror(index)) & (a > few) & (b > few)
    z = ((a - b) / numpy.hypot(s, t))[chosen]
    return z, (abs(a - b) / (a + b))[chosen]


def main():
    verdict = cml.Verdict("symmetry")
    mirrors = {"x": lambda m: m[:, ::-1], "y": lambda m: m[::-1, :], "diagonal": lambda m: m.T}
    with tempfile.TemporaryDirectory() as keep:
        hill, wedge = fly("b 3 0.1 0.2 0.05 0.3 0 0", keep), fly(f'm "{MESH}"', keep)
    for name in ("Rd_xy", "Tt_xy"):
        for which, mirror in mirrors.items():
            z, _ = compare(hill, name, mirror)
            excess = ((z**2).mean() - 1) / numpy.sqrt(2 / z.size)
            print(f"hill {name} across {which}: {z.size} pairs, mean z^2 {(z**2).mean():.3f}, worst {abs(z).max():.2f}")
            verdict.check(f"hill {name} {which}", z.size > 50 and abs(excess) < 4, f"{excess:.2f} deviations")
        z, difference = compare(wedge, name, mirrors["x"])
        print(f"wedge {name} across x: {z.size} pairs, mean z^2 {(z**2).mean():.1f}, worst {abs(z).max():.1f}, mean "
              f"difference {difference.mean():.3f} of the mean")
        verdict.check(f"wedge {name}", (z**2).mean() > 5 and difference.mean() > 0.05)
    verdict.finish()


main()
