"""Tests of media over wavelength. Values equal those that were published elsewhere; spectra equal single runs; fits find the parameters that made
the data, and their errors are true."""
import os
import sys
import tempfile
import unittest
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc, np, xr  # noqa: E402

M = mc.media
SKIN = M.TISSUES["skin"]


class Media(unittest.TestCase):
    def test_published_values(self):
        """Tables and formulas equal values of other sources: absorbers at amount 1, within a share."""
        for name, nm, published, share, source in (
                ("HbO2", 660, 2.303 * 319.6, 1e-6, "Prahl's table"), ("Hb", 660, 2.303 * 3226.56, 1e-6, "Prahl's table"),
                ("HbO2", 800, 2.303 * 780, 0.06, "omlc.org: near 800 nm both are equal"), ("Hb", 800, 2.303 * 780, 0.06, "the same"),
                ("HbO2", 700, 2.303 * 320, 0.12, "Moaveni, Schmitt: omlc.org/spectra/hemoglobin/moaveni.html"), ("Hb", 700, 2.303 * 2160, 0.2, "the same"),
                ("water", 699.84198, 4e7 * np.pi * 3.3480362e-8 / 699.84198, 0.01, "k of Segelstein, refractiveindex.info"),
                ("water", 974.98966, 4e7 * np.pi * 3.4800873e-6 / 974.98966, 0.01, "the same"), ("water", 750, 4e7 * np.pi * 1.56e-7 / 750, 0.01, "k of Hale and Querry"),
                ("water", 650, 4e7 * np.pi * 1.64e-8 / 650, 0.05, "the same"), ("fat", 1070, 0.05065, 1e-3, "van Veen's 5.065 1/m"),
                ("bilirubin", 450.8, 2.303 * 55000, 0.01, "Agati and Fusi (1990)"), ("carotene", 451, 2.303 * 139500, 0.03, "Zechmeister (1962)"),
                ("melanosome", 450, 1.7e12 * 450**-3.48, 0.05, "omlc.org/spectra/melanin/mua.html"), ("melanosome", 700, 1.7e12 * 700**-3.48, 0.1, "the same")):
            found = float(M.absorber(name)([nm])[0])
            self.assertLessEqual(abs(found - published), share * published, (name, nm, found, source))
            self.assertIn(M.absorber(name).amount, ("mol/L", "share of volume"))
            self.assertGreater(len(M.absorber(name).source), 20)
        for name, nm, published, error in (("water", 589.3, 1.3330, 5e-4), ("fused silica", 587.6, 1.4585, 5e-5), ("epidermis", 633, 1.433, 1e-3),
                                           ("epidermis", 850, 1.4165, 0.01), ("dermis", 532, 1.3795, 0.01), ("dermis", 1064, 1.380, 0.01)):
            self.assertLess(abs(float(M.index(name, [nm])[0]) - published), error, (name, nm))

    def test_amounts_add_up(self):
        """mua is the sum of amounts times absorbers; mus follows the power law, with a share of Rayleigh scattering."""
        ink = M.Absorber("ink", [400, 700], [1.0, 4.0])
        medium = M.Medium({**M.blood(0.1, 0.7, 120), "water": 0.5, ink: 2}, a=20, b=1.2, rayleigh=0.3, g=0.75, n="water")
        found = medium.columns([500, 620])
        for i, (nm, oxygenated, other) in enumerate(((500, 20932.8, 20862), (620, 942, 6509.6))):  # Prahl's table
            mua = 2.303 * 12 / 64500 * (0.7 * oxygenated + 0.3 * other) + 0.5 * M.absorber("water")(nm) + 2 * (1 + (nm - 400) / 100)
            self.assertAlmostEqual(found["mua"][i], float(mua), 10)
            self.assertAlmostEqual(found["mus"][i], 20 * (0.3 * (nm / 500) ** -4 + 0.7 * (nm / 500) ** -1.2) / 0.25, 10)
        np.testing.assert_allclose(found["n"], M.index("water", [500, 620]))
        self.assertEqual(sorted(M.Medium(a=1, b=0, g=0).columns([500])), ["g", "mus"])
        self.assertEqual(M.Medium().columns([500]), {})

    def test_an_absorber_of_a_table(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "dye.csv")
            with open(path, "w", encoding="utf-8") as file:
                file.write("# my dye\nnm, blue, red\n400, 1, 5\n600, 3, 7\n")
            self.assertEqual(M.read_absorber(path, "dye", "red")([500]).tolist(), [6])
            with self.assertRaisesRegex(mc.InputError, "^column = 'green' .expected one of nm blue red.$"):
                M.read_absorber(path, "green")

    def test_refusals(self):
        for call, text in ((lambda: M.absorber("ink"), "^absorber = 'ink' .expected one of HbO2 Hb water fat"), (lambda: M.absorber("fat")([1200]), r"^nm = 1200.0 .expected 429 to 1098 nm, where fat is known.$"),
                           (lambda: M.index("water", [100]), "^nm = 100.0 .expected 182 to 1129 nm, where the index of water is known.$"),
                           (lambda: M.Medium({"ink": 1}), "absorber = 'ink'"), (lambda: M.Medium({"water": -1}), r"Medium.absorbers\['water'\] = -1 .expected a number >= 0"),
                           (lambda: M.Medium(a=10, b=1), "Medium.g = None .expected a number from -1 to below 1"), (lambda: M.Medium(a=10, b=1, g=1), "Medium.g = 1 "),
                           (lambda: M.Medium(a=10, g=0), "Medium.b = None"), (lambda: M.Medium(b=1), "Medium.b = 1 .expected None without a"), (lambda: M.Medium(n="ice"), "Medium.n = 'ice'"),
                           (lambda: M.Medium(rayleigh=2), "Medium.rayleigh = 2"), (lambda: M.Medium(["water"]), "Medium.absorbers = "), (lambda: M.blood(2, 0.5), "share = 2"),
                           (lambda: M.blood(0.1, 50), "saturation = 50"), (lambda: M.Absorber("a", [500, 400], [1, 2]), "Absorber.nm = .500, 400. .expected a list of rising"),
                           (lambda: M.Absorber("a", [400, 500], [1]), "Absorber.mua = .1. .expected 2 numbers >= 0, one for each wavelength")):
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))


def skin(**values):
    return mc.Scene([mc.Layer(1.4, 1, 100, 0.8, 0.006, name="epidermis"), mc.Layer(1.4, 1, 100, 0.8, 0.1, bodies=[mc.Sphere(0, 0, 0.05, 0.02, 1.4, 1, 100, 0.9)])],
                    **{"photons": 500, "nr": 3, "nz": 2, "na": 2, **values})


class Spectra(unittest.TestCase):
    def test_each_wavelength_is_a_run(self):
        """Each wavelength has the bytes of a run with its numbers, for layers, a body, an index and a thickness."""
        nm = [500, 560, 650]
        media = {"epidermis": M.Medium({"melanosome": 0.03, "bloodless skin": 0.97}, **SKIN, g=0.8, n="epidermis"), "layer2": M.Medium({"bloodless skin": 1}, **SKIN, g=0.8),
                 "body1": M.Medium(M.blood(1, 0.6)), "layer2.d": 0.12, "below.n": [1.4, 1.41, 1.42]}
        found = mc.spectrum(skin(), media, nm)
        self.assertEqual(found.Rd.dims, ("nm",))
        self.assertEqual((found.nm.attrs["units"], found["epidermis.n"].dims), ("nm", ("nm",)))
        for i in range(3):
            row = found.isel(nm=i)
            layer, other, body = (media[name].columns(nm) for name in ("epidermis", "layer2", "body1"))
            alone = mc.Scene([mc.Layer(layer["n"][i], layer["mua"][i], layer["mus"][i], 0.8, 0.006, name="epidermis"),
                              mc.Layer(1.4, other["mua"][i], other["mus"][i], 0.8, 0.12, bodies=[mc.Sphere(0, 0, 0.05, 0.02, 1.4, body["mua"][i], 100, 0.9)])],
                             n_below=media["below.n"][i], photons=500, nr=3, nz=2, na=2)
            xr.testing.assert_equal(row.drop_vars(set(row.coords) - set(row.dims) - {"r", "z", "alpha", "layer", "boundary", "body", "medium"}), mc.run(alone))

    def test_wavelengths_share_a_flight(self):
        """All wavelengths come of one flight where mua alone depends on them, unless an option needs more."""
        nm = np.linspace(500, 600, 5)
        media = {"layer2": M.Medium(M.blood(0.02, 0.5))}
        found = mc.spectrum(skin(), media, nm)
        table = {"layer2.mua": media["layer2"].columns(nm)["mua"]}
        warnings.filterwarnings("ignore", ".* counts from above")
        xr.testing.assert_equal(found, mc.sweep(skin(), table, dim="nm", coords={"nm": nm}, reweight=True))
        own = mc.sweep(skin(), table, dim="nm", coords={"nm": nm})
        self.assertFalse(found.Rd.equals(own.Rd))
        xr.testing.assert_equal(mc.spectrum(skin(), media, nm, reweight=False), own)
        self.assertIn("dRd_dmua", mc.spectrum(skin(), media, nm, derivatives=True))
        self.assertEqual(list(mc.spectrum(skin(), media, nm, variables=["Rd"]).data_vars), ["Rd"])

    def test_refusals(self):
        medium = M.Medium(M.blood(0.02, 0.5))
        for media, nm, text in (({"layer2": medium}, [600, 500], "^wavelengths = .600, 500. .expected a list of rising wavelengths"), ({"layer2": medium}, [], "^wavelengths = "),
                                ({"layer2": 1.4}, [500], r"^media\['layer2'\] = 1.4 "), ({"layer2.d": [1, 2]}, [500], r"^media\['layer2.d'\] = \[1, 2\]"), ({}, [500], "^media = {} "),
                                ({"layer2": medium, "layer2.mua": 1}, [500], "^media = 'layer2.mua' .expected each number once"), ({"layer2": M.Medium()}, [500], "at least one number"),
                                ({"dermis": medium}, [500], "dermis.mua"), ({"layer2": medium}, [1200], "^nm = 1200.0 .expected 250 to 1000 nm, where HbO2 is known")):
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                mc.spectrum(skin(), media, nm)
            self.assertNotIn("\n", str(caught.exception))


TRUTH = {"saturation": 0.7, "blood": 0.02, "a": 46}
BOUNDS = {"saturation": (0, 1), "blood": (0.005, 0.1), "a": (20, 100)}
NM = np.array([540, 560, 578, 600])


def perfused(saturation, blood, a, d=0.1):
    return {"layer1": M.Medium({**M.blood(blood, saturation), "bloodless skin": 1 - blood}, a=a, b=1.4, g=0.8), "layer1.d": d}


def slab(**values):
    return mc.Scene([mc.Layer(1.4, 1, 100, 0.8, 0.1)], nr=1, nz=1, na=1, **{"photons": 1000, **values})


def noisy(seen, names, share, seed):
    """Returns data of a spectrum with noise of a share of the values."""
    dice = np.random.default_rng(seed)
    return {name: (seen[name].values * (1 + share * dice.standard_normal(len(seen.nm))), share * seen[name].values) for name in names}


class Fits(unittest.TestCase):
    def test_errors_are_true(self):
        """Twenty measurements with 2 % noise give back the parameters of the model, and z, their distance in standard errors, is normal."""
        seen = mc.spectrum(slab(), perfused(**TRUTH), NM, photons=1e5, seed=77, ignore_absorption=True)
        z, chi2 = [], []
        for k in range(20):
            fit = mc.fit(slab(), BOUNDS, noisy(seen, ("Rd", "Tt"), 0.02, k), media=perfused, wavelengths=NM, seed=100 + k)
            z.append([(fit.values[name] - value) / fit.errors[name] for name, value in TRUTH.items()])
            chi2.append(fit.chi2)
            self.assertEqual(fit.degrees, 5)
            self.assertLess(fit.errors["saturation"], 0.1)
            self.assertLess(fit.errors["blood"], 0.001)
            self.assertLess(fit.errors["a"], 3)
        z = np.array(z)
        print("\nmean z", z.mean(axis=0).round(2), "rms", np.sqrt((z**2).mean(axis=0)).round(2), "chi square", np.mean(chi2).round(2))
        self.assertLess(np.abs(z).max(), 4.5)
        self.assertTrue((np.abs(z.mean(axis=0)) < 4 / 20**0.5).all(), z.mean(axis=0))
        self.assertTrue(((z**2).sum(axis=0) > 5.9).all() and ((z**2).sum(axis=0) < 45.3).all(), z)  # chi square of 20 degrees, 1 in 1000 on either side
        self.assertTrue(65 < np.sum(chi2) < 150, chi2)  # the same with 100 degrees

    def test_a_thickness_and_a_detector(self):
        """A thickness has no derivative: it is moved. A ring, Rd and Tt, with a wavelength at which one of them is not known."""
        scene = slab(detectors=[mc.Detector("ring", r1=0.01, r2=0.1, name="ring")], photons=5000)
        seen = mc.spectrum(scene, perfused(**TRUTH, d=0.08), NM, photons=1e5, seed=78, ignore_absorption=True)
        data = noisy(seen, ("detector_ring", "Rd", "Tt"), 0.01, 1)
        data["Tt"][0][1] = np.nan
        bounds = {"saturation": (0, 1), "a": (20, 100), "d": (0.05, 0.15)}
        fit = mc.fit(scene, bounds, data, media=lambda saturation, a, d: perfused(saturation, 0.02, a, d), wavelengths=NM)
        for name, value in {"saturation": 0.7, "a": 46, "d": 0.08}.items():
            self.assertLess(abs(fit.values[name] - value), 4 * fit.errors[name], name)
            self.assertLess(fit.errors[name], 0.1 * value, name)
        self.assertEqual(fit.words, "")
        self.assertEqual(([len(values) for values in fit.measured.values()], fit.degrees, fit.flights % 12), ([4, 4, 3], 8, 0))
        np.testing.assert_array_equal(fit.places["Tt"], NM[[0, 2, 3]])
        np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance)), list(fit.errors.values()))
        self.assertRegex(str(fit), r"correlation of d and a: -0\.\d\d \+- 0\.\d\d\n")
        with tempfile.TemporaryDirectory() as folder:
            fit.plot(os.path.join(folder, "fit.svg"))
            with open(os.path.join(folder, "fit.svg"), encoding="utf-8") as file:
                drawn = file.read()
        for text in (">detector_ring, measured<", ">Tt, model<", ">wavelength [nm]<", "saturation = "):
            self.assertIn(text, drawn)

    def test_what_the_data_cannot_tell_is_said(self):
        """A parameter without effect has no error, one at a bound is named, and so are data that no parameter explains."""
        scene, one = slab(), [560.0, 600.0]
        fit = mc.fit(scene, {"saturation": (0, 1), "idle": (1, 2)}, {"Rd": ([0.3, 0.3], 0.003)}, media=lambda saturation, idle: perfused(saturation, 0.02, 46), wavelengths=one, photons=500, flights=3)
        self.assertEqual(fit.errors["idle"], np.inf)
        self.assertRegex(fit.words, "The data do not tell idle: ")
        fit = mc.fit(scene, {"saturation": (0, 1)}, {"Rd": ([0.1, 0.6], 0.003)}, media=lambda saturation: perfused(saturation, 0.02, 46), wavelengths=one, photons=500, flights=4)
        self.assertRegex(fit.words, "does not explain the data: chi square .* is no chance")

    def test_refusals(self):
        data, nm = {"Rd": ([0.3, 0.3], 0.01)}, [560, 600]
        for bounds, measured, media, wavelengths, text in (
                (BOUNDS, data, perfused, None, "^wavelengths = None"), (BOUNDS, data, None, nm, "^media = None .expected a function"), (BOUNDS, data, perfused(**TRUTH), nm, "^media = {"),
                ({"saturation": (0, 1)}, data, perfused, nm, "expected a function of saturation that returns media; perfused.. missing 2"), ({"a": (2, 1)}, data, perfused, nm, "below the upper one"),
                ({"a": 1}, data, perfused, nm, "a lower and an upper bound"), ({}, data, perfused, nm, "^parameters = {}"), (BOUNDS, {}, perfused, nm, "^measured = {}"),
                (BOUNDS, {"Rd": ([0.3], 0.01)}, perfused, nm, "one for each wavelength"), (BOUNDS, {"Rd_r": ([0.3, 0.3], 0.01)}, perfused, nm, "totals or detectors"),
                (BOUNDS, {"Rd": ([0.3, 30], 0.01)}, perfused, nm, r"^measured\['Rd'\] at 600 nm: value = 30"), (BOUNDS, {"Rd": ([0.3, 0.3], 0)}, perfused, nm, "error = 0"),
                (BOUNDS, {"detector_x": ([0.3, 0.3], 0.01)}, perfused, nm, "detectors of the scene"), (BOUNDS, {**data, "R": ([0.3, 0.3], 0.01)}, perfused, nm, "one of them"),
                ({"saturation": (0, 2)}, data, lambda saturation: perfused(saturation, 0.02, 46), nm, "^saturation = 2.0 .expected an oxygenation"),
                (BOUNDS, {"Tt": ([0.01, 0.01], 0.01)}, lambda **values: perfused(**values, d=3), nm, "^photons = 100 .expected more: no packet tells Tt at 560 nm.$")):
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                mc.fit(slab(), bounds, measured, media=media, wavelengths=wavelengths, photons=100)
            self.assertNotIn("\n", str(caught.exception))
        with self.assertRaisesRegex(mc.InputError, "^photons = 63 .expected at least 64"):
            mc.fit(slab(), BOUNDS, data, media=perfused, wavelengths=nm, photons=63)


if __name__ == "__main__":
    unittest.main()
