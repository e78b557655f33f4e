"""Tests of strange arguments: each makes an object that can be written, or an InputError of one line that says what was expected.

No other exception leaves the package, and no wrong value reaches the program silently."""
import dataclasses
import decimal
import os
import sys
import tempfile
import unittest
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import h5py, mc, np, xr  # noqa: E402

STRANGE = [None, True, 0, -1, 2**53 + 1, 10**400, float("nan"), float("inf"), 1j, "", "x", "a\nb", "a\u2028b", "a\rb", "\0", "\ud800", "\udc80",
           b"x", [], [None], [1, "x"], ["\ud800"], (), {}, {"\ud800": 1}, {1, 2}, object(), decimal.Decimal("sNaN"), np.nan, np.array([]),
           np.array([np.nan]), np.zeros((2, 2)), np.ma.masked, np.datetime64("NaT"), xr.DataArray(np.zeros((3, 2)), dims=("x", "y")), lambda: 1, mc.Layer]
OF_CALLS = [float("nan"), 1j, "a\nb", "\0", "\ud800", "\udc80", b"x", [None], ["\ud800"], {"\ud800": 1}, object(), STRANGE[-3]]
LAYER = mc.Layer(n=1.4, mua=1, mus=20, g=0.5, d=0.1)
SOUND = [
    LAYER, mc.Heightfield([0, 0.1], [0.02, 0]), mc.Heightmap(np.zeros((3, 2)), dx=0.1, dy=0.1), mc.Sphere(0, 0, 0.05, 0.01, n=1.4, mua=1, mus=2, g=0),
    mc.Cylinder(0, 0, 0.05, 0.1, 0, 0.05, 0.01, n=1.4, mua=1, mus=2, g=0), mc.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    mc.Phase("hg2", g1=0.9, g2=-0.4, w=0.95), mc.Phase("table", angles=[0, 180], densities=[1, 1]), mc.Beam("disk", 0.5), mc.Beam("ring", r1=0.1, r2=0.2),
    mc.Map(3, 3, 0.1, 0.1, volume=True), mc.Time(100, 5), mc.Directions(2, 2), mc.Backing("metal", n=0.2, k=3.0), mc.Backing("mirror", R=0.5),
    mc.Face(0.5, "ring", r1=0.1, r2=0.2), mc.Face(law="metal", n=2.5, k=3.4), mc.Port("disk", radius=0.1, n=1.46, name="core"), mc.Beam("port", port="core"),
    mc.Detector("port", port="core"), mc.Fibre(0.01, na=0.22, cladding=0.011), mc.Detector("disk", radius=0.1, na=0.2), mc.Detector("map", nx=2, ny=2, dx=0.1, dy=0.1), mc.Saved("exits"), mc.Scene([LAYER], photons=100)]
CALLS = {  # each call with the arguments that stay, and those that become strange
    mc.run: ({"scene": mc.Scene([LAYER], photons=100)}, ("scene", "output_dir", "seed", "photons", "set", "roulette", "engine", "target_error", "resume")),
    mc.sweep: ({"scene": mc.Scene([LAYER], photons=100), "parameters": {"layer1.mua": [1, 2]}}, ("parameters", "dim", "coords", "variables", "output_dir")),
    mc.check: ({"scene": mc.Scene([LAYER], photons=100)}, ("scene", "sweep")),
    mc.trace: ({"scene": mc.Scene([LAYER], photons=100), "photon": 1}, ("photon", "seed")),
    mc.mesh: ({"scene": mc.Scene([LAYER], photons=100)}, ("output_dir",)),
    mc.view: ({"scene": mc.Scene([LAYER], photons=100), "output": "x.svg"}, ("output", "run", "style")),
    mc.compare: ({"a": "none", "b": "none"}, ("a", "alpha", "output")),
    mc.merge: ({"results": ["none", "none"]}, ("results",)),
    mc.read: ({}, ("path",)),
    mc.read_photons: ({}, ("path",)),
    mc.fit: ({"scene": mc.Scene([LAYER], photons=100), "parameters": {"layer1.mua": (0.1, 10)}, "measured": {"Rd": (0.3, 0.01)}},
             ("scene", "parameters", "measured", "flights")),
}


class StrangeValues(unittest.TestCase):
    def attempt(self, what, make):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                return make()
            except mc.ClustermcmlError as error:
                self.assertEqual(len(str(error).splitlines()), 1, f"{what}: {error}")
                str(error).encode("utf-8")
            except Exception as error:  # any exception but InputError is a failure
                self.fail(f"{what}: {type(error).__name__}: {error}")
        return None

    def test_an_object_is_made_or_refused(self):
        for sound in SOUND:
            for field in dataclasses.fields(sound):
                for value in STRANGE:
                    what = f"{type(sound).__name__}.{field.name} = {value!r}"
                    with self.subTest(what):
                        made = self.attempt(what, lambda: dataclasses.replace(sound, **{field.name: value}))
                        if isinstance(made, mc.Scene):
                            self.attempt(what, lambda: made.text("a.mco", self.folder))
                        elif hasattr(made, "line"):
                            words = (self.folder, "a") if isinstance(made, (mc.Heightfield, mc.Heightmap, mc.Mesh, mc.Phase, mc.Sphere, mc.Cylinder)) else ()
                            line = self.attempt(what, lambda: made.line(*words))
                            self.assertEqual(len((line or "x").splitlines()), 1, what)

    def test_a_call_is_refused(self):
        for call, (fixed, names) in CALLS.items():
            for name in names:
                for value in OF_CALLS:
                    what = f"{call.__name__}({name}={value!r})"
                    with self.subTest(what):
                        self.attempt(what, lambda: call(**{**fixed, name: value}))

    def test_whole_numbers_are_not_rounded(self):
        scene = mc.Scene([LAYER], photons=100)
        for seed in (2**53 + 1, np.int64(2**53 + 1), -2**53 - 1):
            with self.assertRaises(mc.InputError):
                mc.sweep(scene, {"seed": [1, seed]})
        with self.assertRaises(mc.InputError):
            mc.trace(scene, 2**53 + 1)

    def test_a_table_of_packets_with_holes_is_refused(self):
        path = os.path.join(self.folder, "holes.photons.h5")
        mc.run(mc.Scene([LAYER], photons=200, saved=mc.Saved("holes")), output_dir=self.folder)
        self.assertEqual(str(mc.read_photons(path).index.dtype), "int64")
        for name in ("index", "side", "interactions"):
            with h5py.File(path, "r+") as file:
                kept = file[name][()]
                file[name][...] = np.full(kept.shape, np.nan)
            with self.assertRaisesRegex(mc.InputError, "^.*holes.photons.h5: not an .h5 file of saved photons [^\n]*$"):
                mc.read_photons(path)
            with h5py.File(path, "r+") as file:
                file[name][...] = kept

    def test_a_map_is_turned_by_its_dimensions(self):
        heights = np.arange(6.0).reshape(2, 3)
        upright = xr.DataArray(heights, dims=("y", "x"), coords={"x": [0, 1, 2]})
        self.assertTrue(np.array_equal(mc.Heightmap(upright.T, dx=0.1).heights, heights))
        self.assertTrue(np.array_equal(mc.Heightmap(xr.DataArray(heights), dx=0.1).heights, heights))
        for wrong in (upright.rename(y="row"), upright.isel(x=[2, 1, 0])):
            with self.assertRaisesRegex(mc.InputError, "the dimensions y and x, with rising coordinates"):
                mc.Heightmap(wrong, dx=0.1)

    def run(self, result=None):
        here = os.getcwd()
        with tempfile.TemporaryDirectory() as self.folder:
            os.chdir(self.folder)
            try:
                return super().run(result)
            finally:
                os.chdir(here)


if __name__ == "__main__":
    unittest.main()
