"""Tests of subsurface profiles: totals, fits that recover made profiles, files, and messages.

With the argument `long N [M]`: N random materials, each with the default error and again with M packets of another seed. The printed L1 must hold
for the second profile."""
import contextlib
import functools
import io
import json
import os
import sys
import tempfile
import unittest
import unittest.mock
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np  # noqa: E402
from clustermcml import profile_flight  # noqa: E402
from clustermcml.__main__ import main  # noqa: E402
from clustermcml.profile_fits import Shares, fit_burley, fit_sum, lowest, scaled, shares_of, single_albedo  # noqa: E402

EDGES = np.linspace(0, 2, 401)


def slab(top=None, **values):
    return mc.Scene([mc.Layer(n=1.4, mua=2, mus=100, g=0.8, d=0.2, top=top)], photons=20000, **values)


@functools.lru_cache(maxsize=None)
def plain():
    """Returns the profile of the slab, flown once for all tests that only look at it."""
    return mc.profile(slab(), target_error=None)


def made(kind, weights, lengths, photons=0.0, seed=0):
    """Returns a profile whose parameters are known. With photons > 0, returns a random sample of so many packets."""
    light = np.asarray(weights) @ shares_of(kind, EDGES, np.asarray(lengths))
    if not photons:
        return Shares(EDGES, light, 1e-3 * np.sqrt(np.abs(light)))
    drawn = np.random.default_rng(seed).multinomial(int(photons), light) / photons
    return Shares(EDGES, drawn, np.sqrt(np.maximum(drawn, 1 / photons) / photons))


def of_csv(path):
    return np.genfromtxt(path, delimiter=",", names=True)


class Flights(unittest.TestCase):
    def test_all_of_the_light_is_there(self):
        """Light in the rings and beyond them adds up to Rd, which is Rd by adding-doubling."""
        for light in ("normal", "diffuse"):
            found = plain() if light == "normal" else mc.profile(slab(), light, target_error=None)
            r = found.r.values
            total = float((found.S * 2 * np.pi * r * 2 * r[0]).sum() + found.beyond)
            self.assertLess(abs(total / float(found.Rd) - 1), 1e-12)
            self.assertEqual(found.S.shape, (400,))
            self.assertTrue(0.997 < float(found.cdf[-1]) < 0.9999, float(found.cdf[-1]))
            self.assertAlmostEqual(float(found.cdf[-1]), 1 - float(found.beyond / found.Rd), 12)
            self.assertTrue((np.diff(found.cdf.values) >= 0).all())
        found = plain()
        self.assertAlmostEqual(float(found.Rd), float(mc.run(slab(), ignore_absorption=True).Rd), 12)
        self.assertLess(abs(float(found.Rd) - mc.exact(slab())[0]["Rd"]), 5 * float(found.Rd_se))

    def test_errors_are_those_of_other_seeds(self):
        a, b = plain(), mc.profile(slab(), target_error=None, seed=1)
        np.testing.assert_array_equal(a.S.values, b.S.values)
        width, other = 2 * a.r.values[0], mc.profile(slab(), target_error=None, seed=7)
        below = np.interp(np.append(0, a.r.values + width / 2), np.append(0, other.r.values + other.r.values[0]), np.append(0, other.cdf.values))
        shares = np.diff(below)[:200].reshape(20, 10).sum(axis=1)  # groups of ten bins; the bins themselves may have other widths in both profiles
        mine = (a.S * 2 * np.pi * a.r * width / a.Rd).values[:200].reshape(20, 10).sum(axis=1)
        error = np.sqrt(((a.S_se * 2 * np.pi * a.r * width / a.Rd).values[:200].reshape(20, 10) ** 2).sum(axis=1) * 2)
        self.assertLess((((mine - shares) / error) ** 2).sum(), 45)  # chi square with 20 degrees of freedom is above 45 in 1 of 1000 cases

    def test_rounds_until_the_noise_is_small(self):
        one = plain()
        with unittest.mock.patch.object(profile_flight, "_fly_planes", side_effect=profile_flight._fly_planes) as rounds:
            found = mc.profile(slab(), target_error=0.7 * float(one.noise))
        seeds = [call.args[-1] for call in rounds.call_args_list]
        self.assertTrue(len(seeds) > 1 and len(set(seeds)) == len(seeds), seeds)
        self.assertLessEqual(float(found.noise), 0.7 * float(one.noise))
        self.assertTrue(2 < float(found.photons) / float(one.photons) < 4, float(found.photons))

    def test_tiles_are_means_over_their_period(self):
        """Nearly flat tiles give the profile of a plane. Rd of rough tiles equals that of a beam over a period."""
        heights = np.zeros((8, 8))
        heights[::2] = 1e-7
        flat = mc.profile(slab(mc.Heightmap(heights, dx=0.05, tile=True)), target_error=None)
        plane = mc.profile(slab(), target_error=None, seed=5)
        for share in (0.3, 0.7, 0.95):
            r = np.interp(share, plane.cdf.values, plane.r.values + plane.r.values[0])
            there = np.interp(r, flat.r.values + flat.r.values[0], flat.cdf.values)
            self.assertLess(abs(there - share), 5 * np.sqrt(2 * share * (1 - share) / 20000 / float(plane.Rd)))
        top = mc.Relief(slope=0.5, length=0.01, points=32)
        rough = mc.profile(slab(top), "diffuse", target_error=None)
        beam = mc.run(slab(top, beam=mc.Beam("rectangle", tile=True, light="lambertian")), photons=40000)
        self.assertLess(abs(float(rough.Rd - beam.Rd)), 5 * float(np.hypot(rough.Rd_se, beam.Rd_se)))
        self.assertEqual(float(rough.photons), 20480)

    def test_channels_are_the_scenes_that_they_set(self):
        found = mc.profile(slab(), target_error=None, channels={"nm": [450, 650], "layer1.mua": [5, 2], "layer1.n": [1.5, 1.4]})
        alone = plain()
        np.testing.assert_array_equal(found.S.sel(channel=650).values, alone.S.values)
        self.assertEqual(found.n.values.tolist(), [1.5, 1.4])
        self.assertEqual(found.fit("exponentials").w.dims, ("channel", "term"))
        self.assertEqual(float(found.fit("burley").L1[1]), float(alone.fit("burley").L1))


class Fits(unittest.TestCase):
    def test_exponentials_come_out(self):
        for weights, lengths in (([-0.25, 0.75, 0.5], [0.03, 0.1, 0.25]), ([0.1, 0.6, 0.3], [0.02, 0.1, 0.3]), ([0.25, 0.75], [0.1, 0.3])):
            found = fit_sum("exponentials", made("exponentials", weights, lengths), len(weights))
            np.testing.assert_allclose(found.weights, weights, atol=1e-4)
            np.testing.assert_allclose(found.lengths, lengths, rtol=1e-3)
            self.assertLess(found.L1, 1e-6)

    def test_a_fourth_exponential_where_three_are_off(self):
        """A fourth exponential is fitted to layers that differ much, as in one of the random materials."""
        weights, lengths = [0.1, 0.31, -0.55, 1.14], [0.006, 0.027, 0.128, 0.232]
        found = fit_sum("exponentials", made("exponentials", weights, lengths))
        np.testing.assert_allclose(found.weights, weights, atol=0.01)
        self.assertGreater(fit_sum("exponentials", made("exponentials", weights, lengths), 3).L1, 0.04)
        self.assertEqual(len(fit_sum("exponentials", made("exponentials", [-0.25, 0.75, 0.5], [0.03, 0.1, 0.25])).weights), 3)

    def test_burley_is_the_special_case(self):
        found = fit_burley(made("burley", [0.25, 0.75], [0.1, 0.3]))
        self.assertAlmostEqual(found.lengths[0], 0.1, 7)
        self.assertLess(found.L1, 1e-6)
        free = fit_sum("exponentials", made("burley", [0.25, 0.75], [0.1, 0.3]), 2)
        np.testing.assert_allclose([*free.weights, *free.lengths], [0.25, 0.75, 0.1, 0.3], rtol=1e-4)

    def test_gaussians_come_out(self):
        found = fit_sum("gaussians", made("gaussians", [0.3, 0.5, 0.2], [0.05, 0.15, 0.4]), 3)
        np.testing.assert_allclose([*found.weights, *found.lengths], [0.3, 0.5, 0.2, 0.05, 0.15, 0.4], rtol=1e-3)

    def test_errors_are_the_spread_of_samples(self):
        """Errors of fits equal the spread of 20 samples of 1e5 packets, known to 16 %. With ALL_CASES, 40 samples know it to 11 %."""
        samples, most = (40, 0.3) if "ALL_CASES" in os.environ else (20, 0.45)
        for kind, fit in (("burley", fit_burley), ("exponentials", lambda profile: fit_sum("exponentials", profile, 2))):
            found = [fit(made("exponentials", [0.25, 0.75], [0.1, 0.3], 1e5, seed)) for seed in range(samples)]
            spread = np.std([one.lengths for one in found], axis=0, ddof=1)
            np.testing.assert_allclose(np.mean([one.lengths_se for one in found], axis=0), spread, rtol=most, err_msg=kind)
        spread = np.std([one.weights for one in found], axis=0, ddof=1)
        np.testing.assert_allclose(np.mean([one.weights_se for one in found], axis=0), spread, rtol=most)

    def test_no_sum_is_negative(self):
        """Fitted sums are nowhere negative, even for light in a ring alone, and for noisy light that is 0 in the middle."""
        light = np.where((EDGES[:-1] > 0.4) & (EDGES[:-1] < 0.6), 1.0, 0.0)
        light = np.append(light / light.sum(), 0.0)
        found = fit_sum("exponentials", Shares(EDGES, light, np.full(401, 1e-3)))
        self.assertGreaterEqual(lowest(found.weights, found.lengths), -1e-9)
        self.assertLess(lowest(np.array([-2.0, 3.0]), np.array([0.1, 0.3])), -0.1)
        weights, lengths = [-0.32, 0.82, 0.5], [0.03, 0.1, 0.25]  # r S at r = 0 is -0.1 of its largest value
        self.assertLess(lowest(np.array(weights), np.array(lengths)), -0.01)
        found = fit_sum("exponentials", made("exponentials", weights, lengths))
        self.assertEqual((len(found.weights), bool(lowest(found.weights, found.lengths) >= -1e-9)), (3, True))
        self.assertLess(found.L1, 0.015)

    def test_the_walk_is_the_material_where_that_is_one(self):
        """A random walk is found again: its lengths in bins of another width, and the albedo and mean free path of a simulated one."""
        walk = made("exponentials", [0.25, 0.75], [0.1, 0.3])
        profile = Shares(0.05 * EDGES, (walk.light), walk.light_se)
        self.assertAlmostEqual(scaled(profile, walk)[0], 0.05, 9)
        for a in (0.2, 0.9, 0.999):
            s = np.sqrt(1 - a)
            self.assertAlmostEqual(single_albedo((1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)), a, 12)
        found = mc.profile(mc.Scene([mc.Layer(n=1, mua=0.5, mus=9.5, g=0, d=1e5)], photons=1e5), "diffuse", target_error=None).fit("openpbr")
        self.assertAlmostEqual(float(found.albedo), 0.95, delta=0.005)
        self.assertAlmostEqual(float(found.subsurface_radius_cm), 0.1, delta=0.003)
        self.assertAlmostEqual(float(found.Rd_walk), float(found.subsurface_color), delta=0.005)
        self.assertLess(float(found.L1), 0.07)


class Files(unittest.TestCase):
    def setUp(self):
        short = unittest.mock.patch.object(sys.modules["clustermcml.profile"], "WALK", 20000)
        short.start()
        self.addCleanup(short.stop)

    def test_what_is_printed_is_what_the_table_says(self):
        """The printed L1 of all curves equals L1 computed from the .csv with the parameters of the .json."""
        with tempfile.TemporaryDirectory() as folder:
            found = mc.Profile(plain().data)
            paths = [os.path.join(folder, name) for name in ("a.csv", "a.json", "a.svg", "b.csv", "b.json", "b.svg")]
            for one, names in ((found, paths[:3]), (mc.profile(slab(), target_error=None, threads=1), paths[3:])):
                one.to_csv(names[0])
                one.to_json(names[1])
                one.plot(names[2])
            for path, again in zip(paths[:3], paths[3:]):
                with open(path, "rb") as file, open(again, "rb") as other:
                    self.assertEqual(file.read(), other.read(), path)
            table = of_csv(paths[0])
            with open(paths[1], encoding="utf-8") as file:
                told = json.load(file)
        r, width = table["r_mid_cm"], 2 * table["r_mid_cm"][0]
        light = table["S_per_cm2"] * 2 * np.pi * r * width / told["Rd"]
        np.testing.assert_allclose(np.cumsum(light), table["cdf"], atol=1e-12)
        edges = np.append(r - width / 2, r[-1] + width / 2)
        fits = told["fits"]
        for name, w, d in (("exponentials", fits["exponentials"]["w"], fits["exponentials"]["d_cm"]), ("gaussians", fits["gaussians"]["w"], fits["gaussians"]["sigma_cm"]),
                           ("burley", [0.25, 0.75], np.array([1, 3]) * fits["burley"]["d_cm"])):
            x = edges / np.reshape(d, (-1, 1))
            below = 1 - w @ np.exp(-(x**2) / 2 if name == "gaussians" else -x)
            error = np.abs(np.diff(below) - light).sum() + abs(below[-1] - table["cdf"][-1])
            self.assertAlmostEqual(error, fits[name]["L1"], 9, name)
        self.assertEqual((told["n"], told["light"], told["seed"], told["photons"], len(fits["gaussians"]["w"])), (1.4, "normal", 1, 20000, 6))
        self.assertGreater(fits["burley"]["L1"], told["noise"])
        self.assertEqual(told["Rd"], float(found.Rd))

    def test_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            scene, table, stem = (os.path.join(folder, name) for name in ("a.mci", "rgb.csv", "paint"))
            slab(mc.Relief(slope=0.3, length=0.01, points=32)).write(scene)
            with open(table, "w", encoding="utf-8") as file:
                file.write("channel,layer1.mua  # 1/cm\nr,1\ng,2\nb,5\n")
            code, said, _ = called("profile", scene, "-o", stem, "--target-error", "1", "--light", "diffuse", "--label", "channel=" + table)
            self.assertEqual(code, 0)
            self.assertRegex(said, r"(?s)r Rd = 0\.\d+ \+- .*\n  exponentials: L1 0\.\d+, w .*\n  openpbr: L1 .*b Rd = .*paint.csv\n.*paint.json\n.*paint.svg\n$")
            with open(stem + ".json", encoding="utf-8") as file:
                told = json.load(file)
            with open(stem + ".csv", encoding="utf-8") as file:
                lines = file.read().splitlines()
        self.assertEqual(told["channel"], ["r", "g", "b"])
        self.assertEqual([len(told[name]) for name in ("Rd", "noise", "photons", "mean_r_cm")], [3] * 4)
        self.assertEqual(np.shape(told["fits"]["exponentials"]["w"]), (3, 3))
        self.assertEqual((lines[0], len(lines), lines[1][:2], lines[-1][:2]), ("channel,r_mid_cm,S_per_cm2,S_se,cdf", 1201, "r,", "b,"))
        self.assertTrue(told["Rd"][0] > told["Rd"][1] > told["Rd"][2])

    def test_the_sample_has_twelve_sound_materials(self):
        """samples/materials.py has twelve materials, each with a source and channels that its scene knows. Every r, g and b scatters."""
        with unittest.mock.patch.object(sys, "path", [os.path.join(TOP, "samples"), *sys.path]):
            import materials
        self.assertEqual((len(materials.MATERIALS), len({one.name for one in materials.MATERIALS})), (12, 12))
        for one in materials.MATERIALS:
            columns = one.channels()
            self.assertGreater(len(one.source), 20, one.name)
            self.assertEqual(columns.pop("channel"), ["r", "g", "b"])
            for c in range(3):
                layers = mc.check(one.scene(), set={name: values[c] for name, values in columns.items()})[0]["layers"]
                self.assertTrue(all(layer["mus"] > 0 and layer["mua"] > 0 for layer in layers), one.name)
        marble = next(one for one in materials.MATERIALS if one.name == "marble")
        np.testing.assert_allclose(marble.channels()["layer1.mua"], [0.021, 0.041, 0.071])  # 0.0021 0.0041 0.0071 /mm

    def test_refusals(self):
        hill = slab(mc.Heightfield(r=[0, 0.1], h=[0.02, 0]))
        ball = mc.Scene([mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, bodies=[mc.Sphere(0, 0, 0.05, r=0.02, n=1.4, mua=1, mus=1, g=0)])])
        tiles = slab(mc.Relief(slope=0.1, length=0.01, points=32), bottom=mc.Relief(slope=0.1, length=0.02, points=32, shift=(0, 0, -0.05)))
        clear = mc.Scene([mc.Layer(n=1.4, mua=1, mus=0, g=0, d=0.1)])
        for scene, values, text in ((hill, {}, "planes and tiles alone.*boundary 0 is neither"), (ball, {}, "has bodies"), (tiles, {}, "tiles of one period"),
                                    (clear, {}, "light comes back beside"), (slab(), {"light": "red"}, "one of normal diffuse"), (slab(), {"photons": 10}, "photons = 10 "),
                                    (slab(), {"target_error": 0}, "target_error = 0 "), (slab(), {"seed": -1}, "seed = -1"),
                                    (slab(), {"channels": {"nm": [500], "layer1.mua": [1]}}, "two rising wavelengths"),
                                    (slab(), {"channels": {"nm": [500, 600], "beam.x": [1, 2]}}, "numbers of the material"),
                                    (slab(), {"channels": {"nm": [500, 600], "layer7.mua": [1, 2]}}, "layer7"), ("none.mci", {}, "none.mci")):
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                mc.profile(scene, **values)
            self.assertNotIn("\n", str(caught.exception))
        found = mc.profile(slab(), target_error=None, photons=1000)
        for call, text in ((lambda: found.fit("spline"), "one of exponentials gaussians burley openpbr"), (lambda: found.fit("burley", 2), "None for burley"),
                           (lambda: found.fit(terms=0), "terms = 0"), (lambda: found.to_json("a.txt"), "ends in .json"), (lambda: found.plot("a.txt"), "ends in .svg")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()
        with tempfile.TemporaryDirectory() as folder:
            scene, table = os.path.join(folder, "a.mci"), os.path.join(folder, "t.csv")
            slab().write(scene)
            with open(table, "w", encoding="utf-8") as file:
                file.write("nm,layer1.mua\n500,x\n")
            for words, text in ((["--light", "red"], "light = 'red'"), (["--photons", "3"], "--photons 3"), (["--label", "nm=" + table], "row 1 = 500,x"),
                                (["--label", "channel=" + table], "no table with a column channel"), (["-o", "nowhere/paint"], "--output nowhere/paint")):
                code, said, error = called("profile", scene, *words)
                self.assertEqual((code, said, error.count("\n")), (2, "", 1), error)
                self.assertIn(text, error)
            self.assertEqual(sorted(os.listdir(folder)), ["a.mci", "t.csv"])


def called(*words):
    """Returns the exit code, standard output and standard error of a command of the package."""
    with unittest.mock.patch.object(sys, "argv", ["clustermcml", *words]), contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()) as error:
        try:
            code = main()
        except SystemExit as ended:
            code = ended.code
        except mc.ClustermcmlError as refused:  # words that no command accepts
            code = refused.exit_code
    return code, said.getvalue(), error.getvalue()


def random_material(draw):
    """Returns a scene of 1 to 3 layers of one index, the last one infinitely deep, with albedos from dark to white."""
    n, layers = draw.uniform(1, 1.6), []
    count = draw.integers(1, 4)
    for k in range(count):
        mus, g = 10 ** draw.uniform(1, 2.3), draw.uniform(0, 0.9)
        mua = mus * (1 - g) * 10 ** draw.uniform(-3, 0)
        layers.append(mc.Layer(n=n, mua=mua, mus=mus, g=g, d=1e8 if k == count - 1 else 10 ** draw.uniform(-0.5, 0.7) / (mus * (1 - g))))
    return mc.Scene(layers, photons=2e5)


def again(scene, width, photons):
    """Returns the profile of another seed in bins of the same width, because L1 of a curve without a peak at r = 0 grows as bins get finer."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.mci")
        scene.write(path)
        flown = profile_flight.fly_profile(profile_flight.Target(path, None, "normal", path, {}, None), width, int(photons), None, 100)
    return Shares(width * np.arange(profile_flight.BINS + 1), flown.light / flown.Rd, flown.light_se / flown.Rd)


def long(count, photons):
    """Returns the random materials whose printed L1 does not hold for the profile of another seed, by curve.

    The printed L1 contains the noise of its own flight, which is replaced by the noise of the other. L1 must hold within a fifth. If it is below
    its own noise, it must hold within a fifth of that noise."""
    draw, wrong, worst = np.random.default_rng(20), [], 0.0
    for number in range(count):
        scene = random_material(draw)
        found = mc.profile(scene)
        shares = again(scene, 2 * float(found.r[0]), photons)
        own, noise = float(found.noise), shares.noise()
        line = f"{number}: {len(scene.layers)} layers, n {scene.layers[0].n:.3f}, Rd {float(found.Rd):.4f}, noise {own:.4f} and {noise:.4f}; L1"
        for kind in ("exponentials", "gaussians", "burley"):
            curve = found._fitted(kind)[0]
            there = shares.error_of(curve.weights @ shares_of(kind, shares.edges, curve.lengths))
            expected = np.sqrt(max(curve.L1**2 - own**2, 0) + noise**2)
            line += f", {len(curve.weights)} {kind} {curve.L1:.4f} -> {expected:.4f}, is {there:.4f}"
            if abs(there - expected) > 0.2 * max(there, own):
                wrong.append(f"{number} {kind}: {expected:.4f}, is {there:.4f}")
            if kind == "exponentials":
                worst = max(worst, there - noise)
                if there > 0.02 + noise or curve.L1 > 0.02 + own:
                    wrong.append(f"{number}: exponentials {there:.4f}, more than 0.02 beyond the noise")
        print(line, flush=True)
    print(f"{count} materials, exponentials at most {worst:.4f} beyond the noise; wrong: {wrong}")
    return 1 if wrong else 0


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    if sys.argv[1:2] == ["long"]:
        sys.exit(long(int(sys.argv[2]), float(sys.argv[3]) if len(sys.argv) > 3 else 2e6))
    unittest.main()
