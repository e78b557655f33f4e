"""Tests of results in watts and joules. Totals times the power must be equal to the last bit, units right, and sums conserved.

SPDX-License-Identifier: MIT
"""
import os
import re
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np, xr  # noqa: E402
from clustermcml import plot  # noqa: E402


def scene(**values):
    """Returns a scene that tallies every kind of array except those over time."""
    bodies = [mc.Sphere(0, 0, 0.05, 0.01, 1.5, 3, 40, 0.9)]
    return mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, bodies=bodies)], bottom=mc.Heightfield([0, 0.1], [0.02, 0]), photons=2000, nr=7, nz=5, dr=0.05,
                    dz=0.03, map=mc.Map(4, 3, 0.1, 0.2, volume=True, angles=True), facets=True, fluence=True, directions=mc.Directions(nt=3, np=4),
                    detectors=[mc.Detector("disk", radius=0.2, name="area")], **values)


class Watts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.kept.cleanup)
        cls.result = mc.run(scene(), output_dir=cls.kept.name)
        cls.path = os.path.join(cls.kept.name, "scene.h5")

    def test_light_has_watts_and_the_scene_keeps_its_units(self):
        """Every array is either light in watts, with its errors, or stands in the manual among numbers of the scene, counts and means."""
        scaled = mc.scale(self.result, power=0.25)
        with open(os.path.join(TOP, "samples", "manual", "output", "h5.md"), encoding="utf-8") as file:
            text = file.read()
        scenery = set(re.findall(r"`(\w+)`", text[text.index("## Numbers of the scene"):text.index("## Attributes")]))
        scenery |= {"boundary0_area", "body_area", "body_of_facet", "residue", "lost", *(f"detector_NAME_{of}" for of in ("path", "interactions", "momentum", "deepest"))}
        for name in map(str, self.result.data_vars):
            before, after = self.result[name], scaled[name]
            kept = re.sub(r"^boundary\d+_", "boundary0_", re.sub(r"^detector_area_", "detector_NAME_", name.removesuffix("_se"))) in scenery
            np.testing.assert_array_equal(after.values, before.values * (1 if kept else 0.25), name)
            self.assertEqual("W" in after.attrs["units"], not kept, name)
            self.assertEqual((after.dims, after.attrs["long_name"]), (before.dims, before.attrs["long_name"]))
            if not kept:
                self.assertEqual(re.sub("^W", "1", after.attrs["units"]).replace("1/sr", "sr-1"), before.attrs["units"].replace("1/sr", "sr-1"), name)
        units = {name: scaled[name].attrs["units"] for name in ("A_rz", "phi_rz", "phi_rz_se", "Rd_r", "A", "Rd_dir", "boundary1_irradiance_above", "detector_area")}
        self.assertEqual(units, {"A_rz": "W/cm3", "phi_rz": "W/cm2", "phi_rz_se": "W/cm2", "Rd_r": "W/cm2", "A": "W", "Rd_dir": "W/sr",
                                 "boundary1_irradiance_above": "W/cm2", "detector_area": "W"})

    def test_sums_are_conserved(self):
        """The power in all fates, in rings, and in voxels sums to what was launched."""
        scaled = mc.scale(self.result, power=0.25)
        area = 2 * np.pi * scaled.r * 0.05
        self.assertAlmostEqual(float((scaled.Rd_r * area).sum()), float(scaled.Rd), 12)
        self.assertAlmostEqual(float(scaled.A_xyz.sum() * 0.1 * 0.2 * 0.03 + scaled.A_outside), float(scaled.A), 8)  # voxels have single precision
        fates = float(scaled.Rsp + scaled.Rd + scaled.A + scaled.Tt + scaled.book_roulette + scaled.book_trapped + scaled.book_lost - scaled.book_gained)
        self.assertAlmostEqual(fates, 0.25, 12)

    def test_a_pulse_has_joules(self):
        pulse = mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=2000, nr=5, dr=0.1, time=mc.Time(end=50, n=10, radii=True)))
        scaled = mc.scale(pulse, energy=1e-3)
        self.assertEqual([scaled[name].attrs["units"] for name in ("Rd_t", "Rd_t_se", "Rd_t_later", "Rd_rt")], ["J/ps", "J/ps", "J", "J/(cm2 ps)"])
        self.assertAlmostEqual(float(scaled.Rd_t.sum() * 5 + scaled.Rd_t_later), float(scaled.Rd), 15)
        with self.assertRaisesRegex(mc.InputError, r"^power = 'of \w+_\w*t in 1/.*ps\)?' \(expected energy, because arrays over time are those of a pulse\)$"):
            mc.scale(pulse, power=1)

    def test_a_sweep_has_a_power_for_each_row(self):
        spectrum = mc.sweep(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=500), {"layer1.mua": [1, 3], "layer1.mus": [50, 100]}, variables=["Rd", "Rd_se", "A_rz"])
        lamp = xr.DataArray([0.5, 2.0], dims="layer1.mua", coords={"layer1.mua": [1, 3]})
        scaled = mc.scale(spectrum, power=lamp)
        np.testing.assert_array_equal(scaled.A_rz.sel({"layer1.mua": 3}), 2 * spectrum.A_rz.sel({"layer1.mua": 3}))
        np.testing.assert_array_equal(scaled.Rd_se.sel({"layer1.mua": 1}), 0.5 * spectrum.Rd_se.sel({"layer1.mua": 1}))
        self.assertEqual(scaled.A_rz.dims, spectrum.A_rz.dims)
        for other in (lamp.assign_coords({"layer1.mua": [1, 4]}), lamp.rename({"layer1.mua": "nm"}), -lamp):
            with self.assertRaisesRegex(mc.InputError, "expected numbers > 0 over a dimension of the result: layer1.mua layer1.mus"):
                mc.scale(spectrum, power=other)

    def test_refusals(self):
        for values, text in (({}, "a power or an energy, not both"), ({"power": 1, "energy": 1}, "a power or an energy, not both"),
                             ({"power": 0}, "power = 0 .expected a number > 0"), ({"energy": "1 J"}, "energy = '1 J' .expected a number > 0")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.scale(self.result, **values)
        for result in (mc.scale(self.result, power=1), {"Rd": 1}):
            with self.assertRaisesRegex(mc.InputError, "^result = .*expected a Dataset of a run, which is not scaled"):
                mc.scale(result, power=1)

    def test_pictures_in_watts(self):
        """Curves, maps and meshes have the numbers and labels of light in watts."""
        def drawn(*words):
            figures, save = [], plot.save
            plot.save = lambda figure, path: (figure.draw_without_rendering(), figures.append(figure))
            try:
                plot.main([self.path, *words, "--quiet"])
            finally:
                plot.save = save
            return figures[0]
        one, two = (drawn("--of", "Rd_r", *words).axes[0] for words in ((), ("--power", "0.25")))
        np.testing.assert_allclose(two.lines[0].get_ydata(), 0.25 * one.lines[0].get_ydata(), rtol=1e-12)
        self.assertRegex(two.get_ylabel(), r"^Rd_r  \[W/cm²\]")
        self.assertRegex(drawn("--energy", "2").axes[0].get_ylabel(), r"^r·Rd_r\(r\)  \[J/cm\]$")
        self.assertRegex(drawn().axes[0].get_ylabel(), r"^r·Rd_r\(r\)  \[1/cm\]$")
        one, two = (drawn("--of", "phi_rz", *words) for words in ((), ("--power", "0.25")))
        np.testing.assert_allclose(two.axes[0].images[0].get_array(), 0.25 * one.axes[0].images[0].get_array(), rtol=1e-12)
        self.assertIn("phi_rz  [W/cm²]", [axes.get_ylabel() for panel in two.axes for axes in (panel, *panel.child_axes)])
        ends = [drawn("--of", "body_irradiance_outside", *words).axes[-1].get_ylim() for words in ((), ("--power", "0.25"))]
        np.testing.assert_allclose(ends[1], 0.25 * np.array(ends[0]), rtol=1e-12)
        for words, text in ((("--power", "0"), "--power 0 (expected a number > 0 [W])"), (("--power", "1", "--energy", "1"), "--power 1 (expected with results, .h5 or .mco, and one of")):
            with self.assertRaises(mc.InputError) as caught:
                plot.main([self.path, *words])
            self.assertIn(text, str(caught.exception))


if __name__ == "__main__":
    unittest.main()
