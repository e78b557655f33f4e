"""Tests of mc.mie. Without miepython, its refusal; with it, published numbers of Mie's theory, and a scene that flies a table.

SPDX-License-Identifier: MIT
"""
import importlib.util
import os
import sys
import types
import unittest
import unittest.mock

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc, np  # noqa: E402

PRESENT = importlib.util.find_spec("miepython") is not None
POLYSTYRENE = {"n": 1.5721, "n_medium": 1.3316, "wavelength_nm": 632.8}


class Refusals(unittest.TestCase):
    def test_a_missing_package_is_one_sentence_with_the_cure(self):
        """The package may be missing, or be of version 2, which has other names."""
        for found in (None, types.ModuleType("miepython")):
            with unittest.mock.patch.dict(sys.modules, {"miepython": found}), self.assertRaises(mc.ClustermcmlError) as caught:
                mc.mie(1, volume_fraction=0.01, **POLYSTYRENE)
            self.assertEqual((str(caught.exception), caught.exception.exit_code),
                             ("miepython 3 or later is missing (expected it for mc.mie: pip install 'miepython>=3')", 5))

    def test_arguments(self):
        good = {"diameter_um": 1, "volume_fraction": 0.01, **POLYSTYRENE}
        for values, text in (({"diameter_um": 0}, "diameter_um = 0 .expected a number > 0"), ({"n": "glass"}, "n = 'glass' .expected a refractive index"),
                             ({"n_medium": 0}, "n_medium = 0 "), ({"wavelength_nm": -1}, "wavelength_nm = -1 "), ({"volume_fraction": 1.5}, "from 0 to 1"),
                             ({"number_density": 1e9}, "not both"), ({"volume_fraction": None}, "not both"), ({"diameter_um": [1, 2]}, "weights = None"),
                             ({"diameter_um": [1, 2], "weights": [1]}, "one for each diameter: 2"), ({"weights": [0]}, "not all 0")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.mie(**{**good, **values})


@unittest.skipUnless(PRESENT, "miepython is missing")
class Numbers(unittest.TestCase):
    def one(self, x, m, **values):
        """Returns Qsca, Qabs and what mc.mie says of one sphere of 1 cm2 cross section in 1 cm3, by its size parameter."""
        diameter = np.sqrt(4 / np.pi) * 1e4
        found = mc.mie(diameter, m, 1, np.pi * diameter / x * 1000, number_density=1, **values)
        return found.mus, found.mua, found

    def test_published_efficiencies(self):
        """W. J. Wiscombe, Appl. Opt. 19, 1505 (1980), and NCAR/TN-140+STR (1979): Qsca and g of test cases of MIEV0. Bohren and Huffman (1983),
        Appendix A, test case of BHMIE: Qsca."""
        for m, x, extinct, scattered, g in ((1.33 - 0.00001j, 1, None, 0.093923, 0.184517), (1.33 - 0.00001j, 100, None, 2.096594, 0.868959),
                                            (1.5 - 1j, 1, None, 0.6634538, 0.192136), (1.5 - 1j, 100, 2.097502, 1.283697, 0.850252)):
            mus, mua, found = self.one(x, m)
            self.assertAlmostEqual(mus, scattered, 5, (m, x))
            self.assertAlmostEqual(found.g, g, 5, (m, x))
            if extinct is not None:
                self.assertAlmostEqual(mus + mua, extinct, 5)
        self.assertAlmostEqual(self.one(np.pi * 1.05 / 0.6328, 1.55)[0], 3.10543, 4)
        self.assertEqual(self.one(1, 1.5 - 1j)[:2], self.one(1, 1.5 + 1j)[:2])

    def test_the_phase_function_is_the_published_one(self):
        """Bohren and Huffman, Appendix A: S11 of the test case, divided by S11 forward. The table in file has the same mean cosine."""
        found = self.one(np.pi * 1.05 / 0.6328, 1.55)[2]
        at = np.interp(np.cos(np.radians([9, 18, 27, 36, 45, 90])), np.cos(np.radians(found.phase.angles))[::-1], (found.phase.densities / found.phase.densities[0])[::-1])
        np.testing.assert_allclose(at, [0.785390, 0.356897, 0.0766119, 0.0355355, 0.0701845, 0.0124601], rtol=2e-3)

    def test_polystyrene_of_a_published_example(self):
        """S. L. Jacques and S. A. Prahl, course ECE532 (1998): spheres of 0.304 um, 0.1 % of the volume, mus 9.723/cm and g 0.6608."""
        found = mc.mie(0.304, volume_fraction=0.001, **POLYSTYRENE)
        self.assertAlmostEqual(found.mus, 9.723, 2)
        self.assertAlmostEqual(found.g, 0.6608, 3)
        self.assertEqual(found.mua, 0)
        density = 0.001 / (np.pi / 6 * 0.304e-4**3)
        self.assertAlmostEqual(mc.mie(0.304, number_density=density, **POLYSTYRENE).mus, found.mus, 9)

    def test_a_mixture_is_the_sum_of_its_parts(self):
        """Two sizes: mus are sums, and g is a mean by scattered light."""
        density, weights = 1e9, [3, 1]
        parts = [mc.mie(d, number_density=density * w / 4, **POLYSTYRENE) for d, w in zip((0.5, 1.0), weights)]
        both = mc.mie([0.5, 1.0], number_density=density, weights=weights, **POLYSTYRENE)
        self.assertAlmostEqual(both.mus, sum(part.mus for part in parts), 9)
        self.assertAlmostEqual(both.g, sum(part.mus * part.g for part in parts) / both.mus, 12)
        volume = np.pi / 6 * density * 1e-12 * (0.75 * 0.5**3 + 0.25)
        self.assertAlmostEqual(mc.mie([0.5, 1.0], volume_fraction=volume, weights=weights, **POLYSTYRENE).mus, both.mus, 9)

    def test_a_scene_flies_the_table(self):
        """Totals of a thin slab equal those of adding-doubling, which reads the same table; Henyey and Greenstein's differ by more."""
        found = mc.mie(1.0, volume_fraction=0.001, **POLYSTYRENE)
        scene = mc.Scene([mc.Layer(n=1.3316, mua=0, mus=found.mus, g=found.g, d=0.05, phase=found.phase)], n_above=1.3316, n_below=1.3316, photons=1e5)
        result, exact = mc.run(scene), mc.exact(scene)[0]
        self.assertLess(abs(float(result.Rd) - exact["Rd"]), 4 * float(result.Rd_se))
        scene.layers[0].phase = None
        self.assertGreater(abs(mc.exact(scene)[0]["Rd"] - exact["Rd"]), 10 * float(result.Rd_se))


if __name__ == "__main__":
    unittest.main()
