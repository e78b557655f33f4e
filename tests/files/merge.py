"""Tests mc.merge on .h5 files, .mco files and Datasets. Every array of two runs becomes their mean, weighted by photons.

Errors become the root of the sum of squares. Sums are added, and arrays of the scene stay. Maps, volumes, facets and detectors are included, and a
mean can be merged again. A result of one packet has no error, and is taken to scatter like the others. Results that do not belong together are
refused with the first difference. Formulas are written out here."""
import os
import shutil
import sys
import tempfile
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from python_package import mc, np as numpy  # noqa: E402

SCENE = """1.0
1
{name} {format}
3000
0.05 0.05
6 7 2
beam disk 0.2 at=0.1,0
map 30 20 0.05 0.05 angles volume top=-0.1
facets
time 100 4
detector disk 0.3 name=near
detector disk 0.01 at=40,40 name=blind
{lines}1
1
b 3 0.06 0.1 0.02 0.2 0 1
1.4 {mua} 50 0.8 0.3
i sphere 0 0 0.15 0.05 1.4 5 20 0.5
1.5
"""
EQUAL = ("layer_", "body_n", "body_mu", "body_g", "body_of_facet")


def fly(name, photons, seed, *options, mua=0.5, lines=""):
    """Runs a scene. Returns the path of the result."""
    with open("scene.mci", "w", encoding="utf-8") as file:
        file.write(SCENE.format(name=name, format="B" if name.endswith(".h5") else "A", mua=mua, lines=lines))
    cml.run("scene.mci", "--photons", photons, "--seed", seed, *options, keep=".")
    return name


def expected(name, one, two, shares, light):
    """Returns the expected merged value from both values, their shares of photons, and the light that a detector has seen, in packets."""
    a, b = shares
    if name.startswith(EQUAL) or name.endswith("area"):
        return one
    if name in ("lost", "residue"):
        return one + two
    if light is not None:
        with numpy.errstate(invalid="ignore", divide="ignore"):
            a, b = light / light.sum()
    return numpy.hypot(a * one, b * two) if name.endswith("_se") else a * one + b * two


def check(verdict, what, files, merged, shares):
    one, two = (mc.read(file) if isinstance(file, str) else file for file in files)
    verdict.check(what, sorted(one) == sorted(merged), str(set(one) ^ set(merged)))
    for name in merged.data_vars:
        detector = next((d for d in ("detector_near", "detector_blind") if name.startswith(tuple(f"{d}_{mean}" for mean in ("path", "interactions", "momentum", "deepest")))), None)
        light = detector and shares * [float(one[detector]), float(two[detector])]
        values = expected(name, one[name].values.astype(float), two[name].values.astype(float), shares, light)
        close = 1e-12 if one[name].dtype == float else 1e-6
        verdict.check(name, numpy.allclose(merged[name], values, rtol=close, atol=0, equal_nan=True), f"{what}: {merged[name].values.ravel()[:5]}")
        verdict.check(name, merged[name].attrs == one[name].attrs and merged[name].dims == one[name].dims, f"{what}: attributes or axes")
    verdict.check(what, numpy.isnan(merged.detector_blind_path).all() and (merged.detector_near_path > 0).any(), "means of detectors")


def single_packets(verdict):
    """Checks results of one packet: three of them have their spread as error; one beside 3000 packets has the error of those."""
    paths = [fly(f"one{seed}.h5", 1, seed) for seed in (4, 5, 6)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        three, more = mc.merge(paths), mc.merge([paths[0], "a.h5"])
    for name in ("Rd", "A", "Tt", "A_z", "Rd_r", "A_xyz", "Rd_xy"):
        values = numpy.stack([mc.read(path)[name].values.astype(float) for path in paths])
        verdict.check("one packet", numpy.allclose(three[name + "_se"], values.std(0, ddof=1) / 3**0.5, rtol=1e-6, atol=0), name)
        own = mc.read("a.h5")[name + "_se"].values.astype(float)
        verdict.check("one packet", numpy.allclose(more[name + "_se"], own * (3000 / 3001) ** 0.5, rtol=1e-6, atol=0), f"{name} beside 3000")


def refused(verdict):
    fly("other.h5", 100, 9, mua=0.6)
    fly("exits.h5", 100, 9, "--no-reentry")
    fly("set.h5", 100, 9, "--set", "boundary0.height=0.5")
    fly("grid.h5", 100, 9, lines="directions 4 4\n")
    fly("dark.mco", 100, 9, "--ignore-absorption")
    for files, text in ((["a.h5", "a.h5"], "a.h5: seed = 1, run 1 (expected a seed that a.h5 does not have)"),
                        (["a.h5", "other.h5"], "other.h5: input = 1.4 0.6 50 0.8 0.3 (expected 1.4 0.5 50 0.8 0.3, as in a.h5)"), (["a.h5", "exits.h5"], "exits.h5: reentry = 0 (expected 1, as in a.h5)"),
                        (["a.h5", "set.h5"], "set.h5: "), (["a.h5", "grid.h5"], "grid.h5: "), (["a.mco", "dark.mco"], "dark.mco: absorption by place = off (expected on, as in a.mco)"), (["a.h5"], "results = "), ("a.h5", "results = 'a.h5'"),
                        (["a.h5", "none.h5"], "results[1] = 'none.h5' (expected the path of a file that is there)")):
        try:
            mc.merge(files)
            verdict.check("refused", False, f"{files} were merged")
        except mc.InputError as error:
            said = str(error)
            verdict.check("refused", text in said and "\n" not in said, f"{files}: {said}")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        merged = mc.merge(["a.h5", shutil.copy("c.mco", "alone.mco")])
    said = [str(warning.message) for warning in caught]
    verdict.check("lacks", "alone.h5 is missing or of another run: only" in said[0], str(said))
    verdict.check("left out", len(said) == 2 and said[1].startswith("merge: left out what not all results have: A_body, A_body_se, A_body_t, ") and " A_outside, " in said[1], str(said))
    verdict.check("left out", "Rd_xy" not in merged and "A_rz_se" in merged and merged.photons == 4000, "a map")


def main():
    verdict = cml.Verdict("merge")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for ending in ("h5", "mco"):
            files = [fly(f"{name}.{ending}", photons, seed) for name, photons, seed in (("a", 3000, 1), ("b", 6000, 2))]
            merged = mc.merge(files)
            check(verdict, ending, files, merged, numpy.array([1 / 3, 2 / 3]))
            verdict.check(ending, merged.photons == 9000 and merged.merged == "seed 1, run 1\nseed 2, run 1\n" and "seed" not in merged.attrs, str(merged.attrs))
            again = [merged, fly(f"c.{ending}", 1000, 3)]
            twice = mc.merge(again)
            check(verdict, "again", again, twice, numpy.array([0.9, 0.1]))
            verdict.check("again", twice.merged.endswith("seed 3, run 1\n") and twice.photons == 10000, str(twice.attrs))
        for name in ("A_xyz", "boundary0_irradiance_above", "body_irradiance_outside", "A_body"):
            verdict.check(name, mc.merge(["a.h5", "b.h5"])[name].sum() > 0, "light")
        single_packets(verdict)
        refused(verdict)
        os.chdir("/")
    verdict.finish()


main()
