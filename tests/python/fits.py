"""Tests of fits of mua and mus. Flat scenes are compared with an inversion of adding-doubling, rough ones with the values that made the data. A fit
must say if the data cannot tell a parameter.

With the argument `long N`: N simulated measurements of each of six scenes, flat and rough, totals and profiles. Fits must be unbiased, and 95 %
intervals must hold the truth in 95 +- 3 % of cases."""
import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np  # noqa: E402
from clustermcml.__main__ import main  # noqa: E402

BOUNDS = {"layer1.mua": (0.1, 2), "layer1.mus": (50, 200)}
TRUTH = {"layer1.mua": 0.5, "layer1.mus": 100}
HILL = mc.Heightfield(r=[0, 0.05, 0.1, 0.15], h=[0.03, -0.02, 0.02, 0])


def slab(top=None, **values):
    return mc.Scene([mc.Layer(n=1.4, mua=0.5, mus=100, g=0.9, d=0.2, top=top)], photons=20000, **{"nr": 10, "dr": 0.03, **values})


def inverted(measured, start):
    """Returns mua and mus whose Rd and Tt by adding-doubling are `measured`: Newton steps in logarithms, with the slopes of the first step."""
    def totals(u):
        found = mc.exact(slab(), set=dict(zip(TRUTH, np.exp(u))))[0]
        return np.log([found["Rd"], found["Tt"]])
    u = np.log(list(start))
    here = totals(u)
    slopes = np.stack([(totals(u + 0.01 * e) - here) / 0.01 for e in np.eye(2)], axis=1)
    for _ in range(3):
        u = u + np.linalg.solve(slopes, np.log(measured) - here)
        here = totals(u)
    return np.exp(u)


class Fits(unittest.TestCase):
    def test_a_flat_slab_is_that_of_adding_doubling(self):
        """The fit of a flat slab equals the inversion of adding-doubling within 4 errors, which come from the flights' noise of 1 %."""
        measured = [0.30, 0.36]
        fit = mc.fit(slab(), BOUNDS, {"Rd": (measured[0], 1e-5), "Tt": (measured[1], 1e-5)}, photons=1e5)
        for name, value in zip(TRUTH, inverted(measured, fit.values.values())):
            self.assertLess(abs(fit.values[name] - value), 4 * fit.errors[name], name)
            self.assertLess(fit.errors[name], 0.03 * value)
        self.assertEqual((fit.degrees, fit.words), (0, ""))
        self.assertLess(fit.chi2, 1e-6)
        self.assertAlmostEqual(fit.prediction["Rd"], measured[0], 4)
        self.assertLessEqual(fit.flights, 6)
        self.assertLess(fit.correlation[0, 1], 0)
        self.assertTrue(0.005 < fit.correlation_errors[0, 1] < 0.5, fit.correlation_errors)
        self.assertRegex(str(fit), r"correlation of layer1.mus and layer1.mua: -0\.\d\d \+- 0\.\d\d\n")

    def test_what_was_put_into_a_rough_slab_comes_out(self):
        """Fits find the parameters of a rough slab from R and Tt, and from a profile without its last bin. Seven numbers leave five degrees of
        freedom."""
        scene = slab(top=HILL)
        truth = mc.run(scene, seed=5, photons=2e5)
        fit = mc.fit(scene, BOUNDS, {"R": (float(truth.Rd + truth.Rsp), 0.01), "Tt": (float(truth.Tt), 0.01)})
        profile = np.where(np.arange(10) < 6, truth.Rd_r, np.nan)
        again = mc.fit(scene, BOUNDS, {"Rd_r": (profile, 0.05 * truth.Rd_r), "Tt": (float(truth.Tt), 0.01)})
        for found, degrees in ((fit, 0), (again, 5)):
            for name, value in TRUTH.items():
                self.assertLess(abs(found.values[name] - value), 4 * found.errors[name], name)
                self.assertLess(found.errors[name], 0.2 * value, name)
            self.assertEqual(found.degrees, degrees)
        self.assertLess(again.chi2, 22)  # chi square with 5 degrees of freedom is above 22 in 1 of 2000 cases
        self.assertEqual(again.prediction["Rd_r"].shape, (6,))
        self.look_at_the_picture(again)

    def test_what_two_detectors_see_tells_both(self):
        """Two rings on a rough slab, the outer one with an aperture, and Tt tell mua and mus. The last flight has derivatives."""
        rings = [mc.Detector("ring", r1=0.02, r2=0.05, name="near"), mc.Detector("ring", r1=0.05, r2=0.15, na=0.8, name="far")]
        scene = slab(top=HILL, detectors=rings)
        truth = mc.run(scene, seed=9, photons=1e5)
        seen = {name: (float(truth[name]), 0.02 * float(truth[name])) for name in ("detector_near", "detector_far", "Tt")}
        fit = mc.fit(scene, BOUNDS, seen)
        for name, value in TRUTH.items():
            self.assertLess(abs(fit.values[name] - value), 4 * fit.errors[name], name)
            self.assertLess(fit.errors[name], 0.1 * value, name)
        for measured, text in (({"detector_off": (0.1, 0.01)}, "detectors of the scene, detector_near detector_far"),
                               ({"detector_near": (0.1, 0.01), "Rd_r": (np.ones(10), 1)}, "one of them, as the same packets tell both")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.fit(scene, BOUNDS, measured)

    def look_at_the_picture(self, fit):
        """The picture shows six bins of the model and of the data, and below them the parameters and Tt. Totals alone have no picture."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "fit.svg")
            fit.plot(path)
            with open(path, encoding="utf-8") as file:
                drawn = file.read()
        for text in (">model<", ">measured<", "reflectance by radius", str(fit).splitlines()[0].replace("+-", "±"),
                     f"Tt: model {fit.prediction['Tt']:.4g}, measured"):
            self.assertIn(text, drawn)
        np.testing.assert_allclose(fit.places["Rd_r"], 0.015 + 0.03 * np.arange(6))
        with self.assertRaisesRegex(mc.InputError, "of = 'Tt_r' .expected a profile that was measured: Rd_r"):
            fit.plot(path, of="Tt_r")

    def test_what_the_data_cannot_tell_is_said(self):
        fit = mc.fit(slab(), BOUNDS, {"Rd": (0.33, 0.003)}, photons=2000, flights=2)
        self.assertRegex(str(fit), "\nno freedom to judge the fit: measured numbers 1, parameters 2, 2 flights\nThe data do not tell layer1.mua and layer1.mus: 1 number for 2 parameters")
        self.assertEqual(fit.errors["layer1.mua"], np.inf)
        self.assertRegex(str(mc.fit(slab(), {"layer1.mua": (1, 2)}, {"Tt": (0.35, 0.001)}, photons=2000)), "A bound stopped layer1.mua at 1:")

    def test_a_layer_is_fitted_by_its_name(self):
        one = mc.fit(slab(), {"layer1.mua": (0.1, 10), "layer1.mus": (50, 200)}, {"Rd": (0.3, 0.003), "Tt": (0.36, 0.003)}, photons=2000, flights=3)
        scene = slab()
        scene.layers[0].name = "gel"
        other = mc.fit(scene, {"gel.mua": (0.1, 10), "gel.mus": (50, 200)}, {"Rd": (0.3, 0.003), "Tt": (0.36, 0.003)}, photons=2000, flights=3)
        self.assertEqual([one.values["layer1.mua"], one.values["layer1.mus"]], [other.values["gel.mua"], other.values["gel.mus"]])
        for bounds, message in (({"oil.mua": (1, 2)}, "parameters = 'oil.mua'"), ({"gel.mua": (1, 2), "layer1.mua": (1, 2)}, "each number once")):
            with self.assertRaisesRegex(mc.InputError, message):
                mc.fit(scene, bounds, {"Rd": (0.3, 0.003)})

    def test_values_have_the_digits_of_their_errors(self):
        fields = dict.fromkeys(("correlation", "correlation_errors", "prediction", "prediction_errors", "measured", "measured_errors", "places"), {})
        fit = mc.Fit(values={"layer1.mua": 5.21656, "layer1.mus": 123456.0}, errors={"layer1.mua": 1.6, "layer1.mus": 4321.0},
                     **{**fields, "correlation": np.eye(2), "correlation_errors": np.eye(2)}, chi2=1.0, degrees=2, words="", flights=1)
        self.assertEqual(str(fit).splitlines()[:2], ["layer1.mua = 5.2 +- 1.6", "layer1.mus = 123500 +- 4300"])
        self.assertRegex(str(fit), ", 1 flight$")

    def test_data_that_no_parameter_explains_are_said_to_be_so(self):
        fit = mc.fit(slab(), {"layer1.mua": (0.1, 2)}, {"Rd": (0.5, 0.002), "Tt": (0.36, 0.002)}, photons=2000)
        self.assertRegex(fit.words, "does not explain the data: chi square .* is no chance")

    def test_noise_of_slopes_does_not_pass_for_what_the_data_tell(self):
        """Data of 7 % hardly tell a thin layer's mua from the mus below. The noise of the flights' slopes must not pass for information, such as
        mua 3.4 +- 1.0 for a true 1."""
        scene = mc.Scene([mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.03), mc.Layer(n=1.4, mua=1, mus=50, g=0.9, d=0.5)], nr=12, dr=0.015, photons=5e4)
        seen = mc.run(scene, seed=103).Rd_r.values
        fit = mc.fit(scene, {"layer1.mua": (0.1, 10), "layer1.mus": (25, 400), "layer2.mus": (12, 200)}, {"Rd_r": (seen, 0.07 * seen)}, seed=3, flights=4)
        for name, value in {"layer1.mua": 1, "layer1.mus": 100, "layer2.mus": 50}.items():
            self.assertLess(abs(fit.values[name] - value), 2 * fit.errors[name], name)
        self.assertRegex(fit.words, "seem to tell of layer1.mua and .*layer2.mus is noise of the flights' slopes: more photons")

    def test_photons_of_which_no_errors_come(self):
        """Fewer than 64 photons, from the option or the scene, are refused for totals and for profiles."""
        for photons, scene in ((1, slab()), (3, slab()), (63, slab()), (None, mc.Scene(slab().layers, photons=2, nr=10, dr=0.03))):
            for measured in ({"Rd": (0.31, 0.003)}, {"Rd_r": (np.ones(10), 1)}):
                with self.assertRaisesRegex(mc.InputError, rf"^photons = {photons or 2} .expected at least 64: errors come of so many batches.$"):
                    mc.fit(scene, {"layer1.mua": (0.1, 2)}, measured, photons=photons)

    def test_refusals(self):
        for parameters, measured, text in (
                ({"layer1.g": (0, 1)}, {"Rd": (0.3, 0.01)}, "names like layer1.mua"), ({"layer1.mua": (2, 1)}, {"Rd": (0.3, 0.01)}, "below the upper"),
                ({"layer1.mua": 1}, {"Rd": (0.3, 0.01)}, "a lower and an upper bound"), (BOUNDS, {"Rd": 0.3}, "a value and its standard error"),
                (BOUNDS, {"A": (0.3, 0.01)}, "names among"), (BOUNDS, {"Rd_r": ([1, 2], 0)}, "standard error > 0"), (BOUNDS, {}, "measured = {}"),
                (BOUNDS, {"Rd_r": ([1, 2, 3], [1, 1, 1])}, r"3 values' \(expected 10, as many as the scene has bins"),
                (BOUNDS, {"Rd_r": ([np.nan] * 9 + [1], 1)}, "other bins than the last"),
                (BOUNDS, {"Rd": (-0.3, 0.07)}, r"measured..Rd..: value = -0.3 .expected a number from 0 to 1, or at most 4 standard errors beyond"),
                (BOUNDS, {"Rd": (0.3, 1e-300)}, "error = 1e-300 .expected a standard error > 0, from 1e-30"), (BOUNDS, {"Rd_r": ([np.inf] * 10, 1)}, "value = inf"),
                (BOUNDS, {"Rd": (1.7, 0.1)}, "value = 1.7 "), (BOUNDS, {"Rd": (0.3, 0.1), "R": (0.3, 0.1)}, "one of them"), (BOUNDS, {"Rd_r": (np.ones(99), 1)}, "as many as the scene has bins"),
                ({f"layer{i}.mua": (1, 2) for i in range(1, 5)}, {"Rd": (0.3, 0.01)}, "at most 3 mua"),
                ({"layer2.mua": (1, 2)}, {"Rd": (0.3, 0.01)}, "layer2.mua")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.fit(slab(), parameters, measured, photons=100)


class Shell(unittest.TestCase):
    def fit(self, table, *more, started=""):
        """Returns the exit code and the printed text of a fit of the slab to a table. more: words of the command. started: line of a shell that
        starts a new interpreter, with "$@" for the command."""
        with tempfile.TemporaryDirectory() as folder:
            scene, path = os.path.join(folder, "slab.mci"), os.path.join(folder, "seen.csv")
            slab().write(scene)
            with open(path, "wb") as file:
                file.write(table if isinstance(table, bytes) else table.encode())
            words = ["fit", "--photons", "2000", "--flights", "3", "--threads", "1", "--no-reentry", "--set", "layer1.g=0.85", "--set", "layer1.n=1.45",
                     scene, path, "layer1.mua=0.1:2", "layer1.mus=50:200", *more]
            if started:
                done = subprocess.run(["sh", "-c", started, "", sys.executable, "-m", "clustermcml", *words], capture_output=True, text=True,
                                      env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, check=False)
                return done.returncode, done.stdout + done.stderr.replace(folder, "")
            with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err, \
                    warnings.catch_warnings(), unittest.mock.patch.object(sys, "argv", ["", *words]):
                return main(), out.getvalue() + err.getvalue().replace(folder, "")

    def test_a_table_that_is_too_large_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "large.csv")
            with open(path, "wb") as file:
                file.truncate(20 * 2**30)
            ended = subprocess.run([sys.executable, "-m", "clustermcml", "fit", "samples/thick.mci", path, "layer1.mua=1:2"], capture_output=True, text=True,
                                   cwd=TOP, env={**os.environ, "PYTHONPATH": os.path.join(TOP, "src", "python")})
        self.assertEqual((ended.returncode, ended.stderr), (2, f"clustermcml: {path}: cannot be read: it has 21474836480 bytes (expected a table of at most 268435456 bytes)\n"))

    def test_a_table_gives_the_fit_of_its_numbers(self):
        code, said = self.fit("\ufeffname,place,value,error\nRd,,0.30,0.003 # sphere\n\nTt,,0.36,0.003\n", started='"$@"')
        same = mc.fit(slab(), BOUNDS, {"Rd": (0.30, 0.003), "Tt": (0.36, 0.003)}, photons=2000, flights=3, no_reentry=True,
                      set={"layer1.g": 0.85, "layer1.n": 1.45})
        self.assertEqual(code, 0, said)
        self.assertTrue(said.startswith(str(same)), said)
        for name, value, error in (("Rd", 0.30, 0.003), ("Tt", 0.36, 0.003)):
            model, noise, z = map(float, re.search(rf"model: {name} = (\S+) \+- (\S+), measured {value:g} \+- {error:g}, z (\S+)\n", said).groups())
            self.assertAlmostEqual(model, same.prediction[name], 5)
            self.assertAlmostEqual(z, (value - model) / (noise**2 + error**2) ** 0.5, 1)
        code, said = self.fit("Rd_r,0.01,0.5,0.1\nRd_r,0.05,1.2,0.1\nRd_r,0.1,nan,0.1\n")
        self.assertIn("clustermcml: note: /seen.csv: left out lines of Rd_r without a value: 1\n", said)
        self.assertNotIn("degree", said)
        self.assertEqual((code, len(re.findall(r"^model: Rd_r at 0.0(?:15|45) = \S+ \+- \S+, measured (?:0.5|1.2) \+- 0.1, z ", said, re.M))), (0, 2), said)

    def test_a_standard_output_that_takes_nothing(self):
        """A standard output that is full, closed, or without a reader gives the program's messages and exit codes."""
        said = "clustermcml: standard output cannot be written\n5\n"
        ends = (((), ">/dev/full", said), ((), "| true", "141\n"), (("--help",), ">/dev/full", said), ((), ">&-", said))
        for words, end, text in ends if "ALL_CASES" in os.environ else ends[:2]:
            self.assertEqual(self.fit("Rd,,0.30,0.003\nTt,,0.36,0.003\n", *words, started='{ "$@"; echo $? >&2; } ' + end), (0, text), end)

    def test_pictures(self):
        """Totals alone have no picture; the refusal comes before anything is simulated. A fit whose picture fails is printed first."""
        with unittest.mock.patch("clustermcml.__main__.fit", side_effect=AssertionError("flew")):
            self.assertEqual(self.fit("Rd,,0.3,0.01\n", "-o", "fit.svg"),
                             (2, "clustermcml: -o = 'fit.svg' (expected a profile in the table: Rd_r Tt_r Rd_a Tt_a)\n"))
            self.assertEqual(self.fit("Rd_r,0.01,0.5,0.1\n", "-o", "fit.jpg"),
                             (2, "clustermcml: -o = 'fit.jpg' (expected a name that ends in .svg, .png, .pdf or .eps)\n"))
        code, said = self.fit("Rd_r,0.01,0.5,0.1\nRd_r,0.05,1.2,0.1\n", "-o", "/proc/fit.svg")
        self.assertEqual((code, said.count("\nmodel: Rd_r at 0.015 "), said.count("\nclustermcml: /proc/fit.svg: ")), (5, 1, 1), said)

    def test_tables_that_do_not_fit(self):
        for table, text in (("Rd,,0.3\n", ":1 = 'Rd,,0.3' (expected name,place,value,error)"), ("Rd,,0.3,0.1\nRd,,0.3,0.1\n", ":2 = 'Rd' (expected each total once)"),
                            ("Rd,0.1,0.3,0.1\n", ":1: place = '0.1' (expected none of a total)"),
                            ("Rd_r,0.07,1,1\nRd_r,0.08,1,1\n", ":2: place = '0.08' (expected each bin once)"),
                            ("Rd_r,0.28,1,1\n", ":1: place = '0.28' (expected a number from 0 to below 0.27"),
                            ("# Größe\n".encode("latin-1"), r":1 = b'# Gr\xf6\xdfe' (expected text in UTF-8)"), ("", "seen.csv = '' (expected lines NAME,PLACE,VALUE,ERROR)"),
                            ("Rd,,0.3,1" + 140000 * "0", ":1: error = inf (expected a standard error > 0, from 1e-30 to 1e+30)"),
                            ("detector_x,,0.3,0.1\n", "seen.csv: measured = 'detector_x' (expected detectors of the scene, which has none)"),
                            *((f"Rd,,{word},0.1\n", f":1 = 'Rd,,{word},0.1' (expected name,place,value,error)") for word in ("0.3_1", "0_31", "\u0660.\u0663", "inf", "0x1")),
                            ("\nA,,0.3,0.1\n", ":2: name = 'A' (expected names among"), ("Rd,,nan,1\n", ":1: value = nan (expected a number from 0 to 1")):
            code, said = self.fit(table)
            self.assertEqual((code, said.count("\n")), (2, 1), said)
            self.assertIn(text, said)


    def test_words_that_are_none(self):
        """Refused words: parameters given twice or in other numerals, bad numbers of flights, and unknown options."""
        for word, text in (("layer1.mua=1:2", "each parameter once"), ("layer2.mua=0_1:3", "NAME=LOW:HIGH, as layer1.mua=0.01:10"), ("layer2.mua=\u0661:3", "NAME=LOW:HIGH, as layer1.mua=0.01:10")):
            self.assertEqual(self.fit("Rd,,0.3,0.1\n", word), (2, f"clustermcml: parameter = {word!r} (expected {text})\n"))
        self.assertEqual(self.fit("Rd,,0.3,0.1\n", "--flights", "2.5"), (2, "clustermcml: flights = 2.5 (expected a whole number from 2 to 1000)\n"))
        self.assertEqual(self.fit("Rd,,0.3,0.1\n", "--set", "layer1.n=1.4"), (2, "clustermcml: --set = 'layer1.n=1.4' (expected each name once)\n"))
        for words in (("--phot", "5"), ("--flight", "3"), ("--flights", "1_0")):
            with self.assertRaises(SystemExit) as ended:
                self.fit("Rd,,0.3,0.1\n", *words)
            self.assertEqual(ended.exception.code, 2)


# name: scene, measured quantities, photons of a flight
STUDY = {
    "flat": (slab(), ("Rd", "Tt"), 2e4),
    "flat, oblique": (mc.Scene([mc.Layer(n=1.4, mua=0.5, mus=100, g=0.9, d=0.2)], beam=mc.Beam("pencil", angle=45)), ("R", "Tt"), 2e4),
    "rough": (slab(top=HILL), ("Rd", "Tt"), 2e4),
    "rough, disk": (slab(top=HILL, beam=mc.Beam("disk", radius=0.2)), ("R", "Tt"), 2e4),
    "flat, profile": (slab(), ("Rd_r", "Tt"), 1e5),
    "rough, profile": (slab(top=HILL), ("Rd_r", "Tt"), 1e5),
}
NOISE = {"Rd_r": 0.04}  # relative noise of the data; 0.02 for all others


def bounds(dice):
    """Returns bounds as wide as BOUNDS, with the truth anywhere except near their ends. In the middle, the first flight would find it at once."""
    place = dict(zip(BOUNDS, dice.uniform(0.15, 0.85, len(BOUNDS))))
    return {name: tuple(TRUTH[name] * (high / low) ** (end - place[name]) for end in (0, 1)) for name, (low, high) in BOUNDS.items()}


def study(name, cases):
    """Simulates `cases` fits of a scene. Prints, for both parameters, how many intervals of 1 and 1.96 errors hold the truth, the mean of z, and
    the number of flights.

    The mean of z may be off from 0 by 4 of its own errors, plus the mean relative error s of the parameter. A value whose logarithm is normal has a
    mean z of -s / 2. The curvature of Rd and Tt over a logarithm, which is below 1, adds at most as much."""
    scene, kinds, photons = STUDY[name]
    result = mc.run(scene, photons=4e6, seed=1000, threads=1)
    true = {kind: np.asarray(result.Rd + result.Rsp if kind == "R" else result[kind]) for kind in kinds}
    dice, z, errors, flights = np.random.default_rng(1), [], [], []
    for case in range(cases):
        sigma = {kind: NOISE.get(kind, 0.02) * of for kind, of in true.items()}
        measured = {kind: (of + sigma[kind] * dice.standard_normal(of.shape), sigma[kind]) for kind, of in true.items()}
        fit = mc.fit(scene, bounds(dice), measured, photons=photons, seed=case, threads=1)
        z.append([(fit.values[key] - value) / fit.errors[key] for key, value in TRUTH.items()])
        errors.append([fit.errors[key] / value for key, value in TRUTH.items()])
        flights.append(fit.flights)
    z = np.array(z)
    inside = [100 * np.mean(np.abs(z) <= limit, axis=0) for limit in (1, 1.96)]
    skew, most = z.mean(axis=0), 4 / cases**0.5 + np.mean(errors, axis=0)
    print(f"{name}: {cases} fits, within 1 and 1.96 errors mua {inside[0][0]:.0f} and {inside[1][0]:.1f} %, mus {inside[0][1]:.0f} and "
          f"{inside[1][1]:.1f} %, mean z {skew.round(2)} of {most.round(2)} allowed, errors {(100 * np.mean(errors, axis=0)).round(1)} %, "
          f"flights {np.mean(flights):.1f}, at most {max(flights)}", flush=True)
    within = 3 + 3 * 100 * (0.95 * 0.05 / cases) ** 0.5  # 3 errors of the count, added to the allowed 3 %
    return np.all(np.abs(inside[1] - 95) <= within) and np.all(np.abs(skew) < most) and max(flights) <= 6 and np.mean(flights) <= 4


if __name__ == "__main__":
    if sys.argv[1:2] == ["long"]:
        sys.exit(not all([study(name, int(sys.argv[2])) for name in STUDY]))
    unittest.main()
