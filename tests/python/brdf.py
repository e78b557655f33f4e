"""Tests of BRDFs and of the files that renderers read.

- Sums of bins are the program's totals, to 1e-12. Light from below equals light from above on the scene turned upside down.
- A lambertian ground under a clear matched layer has the BRDF R / pi. The fit of a slab, integrated over the light, is the reflectance by adding-doubling.
- Files are parsed here byte by byte, by the description of the format, and pass the checks of pbrt-v4.
With the argument `long`: reciprocity of raw bins at 1e7 packets, the ground to 1e-3, and errors of 20 random materials against other seeds."""
import csv
import os
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import warm_python  # noqa: E402
from python_package import TOP, mc, np  # noqa: E402
from clustermcml.brdf_fit import evaluate, fit_bins, reciprocity  # noqa: E402
from clustermcml.brdf_flight import Bins  # noqa: E402
from clustermcml.gloss import CELLS, cells_of, exits, nodes  # noqa: E402
from clustermcml.relit import relit_text  # noqa: E402

sys.modules["clustermcml.brdf"].GLOSS = 5000  # least packets of a lobe at each angle
SLAB = mc.Scene([mc.Layer(n=1.5, mua=0.5, mus=100, g=0.7, d=0.02), mc.Layer(n=1.3, mua=2, mus=50, g=0.5, d=0.01)], n_below=1.2)
WAVES = mc.Heightmap(0.004 * np.outer(np.ones(16), np.sin(np.arange(16) * np.pi / 8)), dx=0.01, tile=True)


def read_tensor(path):
    """Returns the fields of a tensor file, read by the description of the format alone."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:12] == b"tensor_file\0" and data[12:14] == b"\1\0", data[:14]
    place, fields = 18, {}
    for _ in range(struct.unpack("<I", data[14:18])[0]):
        length, = struct.unpack("<H", data[place:place + 2])
        name = data[place + 2:place + 2 + length].decode()
        place += 2 + length
        axes, kind, offset = struct.unpack("<HBQ", data[place:place + 11])
        shape = struct.unpack(f"<{axes}Q", data[place + 11:place + 11 + 8 * axes])
        place += 11 + 8 * axes
        size = {1: 1, 10: 4}[kind] * int(np.prod(shape))
        assert offset + size <= len(data), name
        fields[name] = np.frombuffer(data[offset:offset + size], {1: "u1", 10: "<f4"}[kind]).reshape(shape)
    return fields


def looked_up(fields, name, channel, theta_i, theta_o, phi):
    """Returns f cos theta_o as a renderer reads it, linear between nodes and between angles of incidence. The light comes from azimuth 0."""
    light = np.array([np.sin(theta_i), 0, np.cos(theta_i)])
    half = light + [np.sin(theta_o) * np.cos(phi), np.sin(theta_o) * np.sin(phi), np.cos(theta_o)]
    half /= np.linalg.norm(half)
    table, angles = fields[name][0, :, channel].astype(float), fields["theta_i"].astype(float)
    last = table.shape[-1] - 1
    x, y = np.sqrt(2 * np.arccos(half[2]) / np.pi) * last, (np.arctan2(half[1], half[0]) + np.pi) / (2 * np.pi) * last
    i = min(max(int(np.searchsorted(angles, theta_i, side="right")) - 1, 0), len(angles) - 2)
    a, b = min(int(x), last - 1), min(int(y), last - 1)
    x, y, z = x - a, y - b, (theta_i - angles[i]) / (angles[i + 1] - angles[i])
    cells = (1 - z) * table[i, b:b + 2, a:a + 2] + z * table[i + 1, b:b + 2, a:a + 2]
    return float(np.array([1 - y, y]) @ cells @ np.array([1 - x, x]))


def quiet(function, *words, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function(*words, **options)


def sums(material):
    """Returns the largest difference between sums of bins and mirror parts and the totals."""
    data = material.data
    return max(float(abs((data[f"f_{side}"] * data.projected).sum(["theta", "phi"]) + data["mirror_" + name] - data["albedo_" + name]).max())
               for side, name in (("r", "R"), ("t", "T")))


class Tables(unittest.TestCase):
    def test_bins_add_up_to_the_totals(self):
        """Bins add up to the totals also if mirrored light lies on the edge of two bins (2.5 degrees), over tiles, and in light from below."""
        tile = mc.Scene([mc.Layer(n=1.5, mua=5, mus=50, g=0.5, d=0.02, top=WAVES)])
        for scene, back in ((SLAB, False), (SLAB, True), (tile, False), (tile, True)):
            material = mc.brdf(scene, angles=[0, 2.5, 40, 80], photons=2000, target_error=None, back=back)
            self.assertLess(sums(material), 1e-12)
            self.assertGreaterEqual(min(float(material.f_r.min()), float(material.f_t.min())), 0)
            self.assertEqual(material.f_r.dims, ("theta_i", "theta", "phi"))
            self.assertEqual(material.f_r.sel(theta=[30, 85], phi=[0, 180, 350]).shape, (4, 2, 3))
            exact = material.albedo_R + material.albedo_T + material.A
            self.assertLess(float(abs(exact - 1).max()), 1e-3)  # roulette leaves a small rest

    def test_mirror_parts(self):
        """A clear slab sends all light into its mirror images; a rough face sends none there."""
        clear = mc.Scene([mc.Layer(n=1.5, mua=0, mus=0, g=0, d=0.1)])
        material = mc.brdf(clear, angles=[10, 60], photons=2000, target_error=None)
        np.testing.assert_allclose(material.mirror_R, material.albedo_R, atol=1e-12)
        np.testing.assert_allclose(material.mirror_T, material.albedo_T, atol=1e-12)
        self.assertLess(float(abs(material.f_r).max()), 1e-12)
        self.assertIn("% of the light at 10 degrees is a mirror image and not in the .bsdf: put a smooth dielectric coat of n 1.5 over it", material.mirror_note())
        rough = mc.Scene([mc.Layer(n=1.5, mua=5, mus=50, g=0.5, d=0.02, top_rough=mc.Rough("ggx", 0.4))], n_below=1.5)
        material = mc.brdf(rough, angles=[30], photons=5000, target_error=None)
        self.assertLess(float(material.mirror_R.max()), 1e-3)
        self.assertEqual(material.mirror_note(), "")
        self.assertEqual(material.attrs["half"], "gloss")

    def test_light_from_below_is_light_from_above_upside_down(self):
        top, bottom = SLAB.layers
        upside = mc.Scene([bottom, top], n_above=SLAB.n_below, n_below=SLAB.n_above)
        a = mc.brdf(SLAB, angles=[0, 50], photons=20000, target_error=None, back=True)
        b = mc.brdf(upside, angles=[0, 50], photons=20000, target_error=None, seed=2)
        for name in ("albedo_R", "albedo_T", "mirror_R", "mirror_T"):
            z = (a[name] - b[name]) / np.hypot(a[name + "_se"], b[name + "_se"]).clip(1e-9)
            self.assertLess(float(abs(z).max()), 4.5, name)
        for name in ("f_r", "f_t"):
            x, y = (m[name].mean("phi") for m in (a, b))
            error = np.sqrt((a[name + "_se"] ** 2 + b[name + "_se"] ** 2).sum("phi")) / a.sizes["phi"]
            self.assertLess(float(abs((x - y) / error.clip(1e-12)).max()), 5, name)

    def test_the_error_target(self):
        material = mc.brdf(SLAB, angles=[0, 60], photons=1000, target_error=0.005)
        self.assertLess(float((material.albedo_R_se / material.albedo_R).max()), 0.005)
        self.assertGreater(float(material.photons.min()), 9999)
        black = mc.Scene([mc.Layer(n=1, mua=100, mus=0, g=0, d=1)])
        self.assertEqual(float(mc.brdf(black, angles=[0], photons=1000, target_error=0.001).albedo_R.max()), 0)

    def test_channels(self):
        wide = quiet(mc.brdf, SLAB, angles=[0, 60], photons=2000, target_error=None, channels={"nm": [450, 650], "layer1.mua": [50, 0.5]})
        self.assertEqual(wide.f_r.dims, ("channel", "theta_i", "theta", "phi"))
        self.assertEqual(wide.channels(), [450, 650])
        self.assertTrue(bool((wide.albedo_R.sel(channel=450) < wide.albedo_R.sel(channel=650)).all()))
        for label, kind in (({"nm": [450, 650]}, ".rgb.bsdf"), ({"channel": ["r", "g", "b"]}, ".bsdf")):
            many = len(next(iter(label.values())))
            material = quiet(mc.brdf, SLAB, angles=[0], photons=500, target_error=None, channels={**label, "layer1.mua": [1.0] * many})
            with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(mc.InputError, "path = .*expected a name that ends in"):
                material.to_bsdf(os.path.join(folder, "a" + kind))


class Fits(unittest.TestCase):
    def test_a_lambertian_ground(self):
        """Exact bins of a lambertian ground give the exact fit. Simulated bins give R / pi within the noise in the fit, the bins and the file."""
        bins, angles = Bins(18, 36), np.radians([0, 30, 60, 80])
        shares = np.broadcast_to(0.25 * bins.projected()[:, None], (4, 19, 36))
        found = fit_bins(shares, 1e-3 * np.sqrt(shares), angles, 1.0, bins)
        np.testing.assert_allclose(found.means, 0.25, rtol=1e-9)
        np.testing.assert_allclose(evaluate(found.coefficients, 1.0, 0.3, np.array([0.2, 1.2, 1.5]), 2.0), 0.25, rtol=1e-9)
        ground = mc.Scene([mc.Layer(n=1, mua=0, mus=0, g=0, d=0.01)], backing=mc.Backing("lambertian", R=0.8))
        material = mc.brdf(ground, angles=[0, 40, 80], photons=1e5, target_error=None)
        self.assertLess(abs(float(material.chi2) - 1), 0.15)
        for theta_i, theta_o in ((0, 0), (40, 20), (10, 60), (80, 40)):
            self.assertLess(abs(material.f(theta_i, theta_o, 90) * np.pi / 0.8 - 1), 0.05)
        with tempfile.TemporaryDirectory() as folder:
            quiet(material.to_bsdf, os.path.join(folder, "g.bsdf"))
            fields = read_tensor(os.path.join(folder, "g.bsdf"))
        for theta_o in (0.1, 0.5, 1.0):
            self.assertLess(abs(looked_up(fields, "spectra", 0, np.radians(40), theta_o, 2.0) / np.cos(theta_o) / (0.8 / np.pi) - 1), 0.05)

    def test_a_slab_against_adding_doubling(self):
        """Albedos of a slab are those of `exact`. The fit, integrated over directions of the light, is Rd of `exact` at the angle of exit."""
        slab = mc.Scene([mc.Layer(n=1.5, mua=0.5, mus=300, g=0.7, d=0.05)])
        material = mc.brdf(slab, angles=[0, 30, 50, 65, 80], photons=40000, target_error=None)
        beam = [mc.exact(mc.Scene(slab.layers, beam=mc.Beam(angle=angle)))[0] for angle in (0, 30, 50, 65, 80)]
        z = (material.albedo_R - np.array([one["Rd"] + one["Rsp"] for one in beam])) / material.albedo_R_se
        self.assertLess(float(abs(z).max()), 4.5)
        self.assertLess(abs(float(material.chi2) - 1), 0.15)
        theta, phi = np.meshgrid((np.arange(180) + 0.5) / 2, np.arange(0, 360, 15.0), indexing="ij")
        weight = np.sin(np.radians(theta)) * np.cos(np.radians(theta)) * np.radians(0.5) * np.radians(15)
        for angle, one in zip((0, 30, 50, 65, 80), beam):
            self.assertLess(abs(float((material.f(theta, angle, phi) * weight).sum()) / one["Rd"] - 1), 0.02, angle)

    def test_swapped_directions_give_the_same_bits(self):
        material = mc.brdf(SLAB, angles=[0, 30, 60], photons=3000, target_error=None)
        dice = np.random.default_rng(1)
        a, b, phi = dice.uniform(0, 90, 1000), dice.uniform(0, 90, 1000), dice.uniform(0, 360, 1000)
        np.testing.assert_array_equal(material.f(a, b, phi), material.f(b, a, phi))

    def test_raw_bins_are_reciprocal(self):
        material = mc.brdf(SLAB, angles=[0, 20, 40, 60, 80], photons=50000, target_error=None)
        self.assertEqual(len(material.reciprocity), 6)
        self.assertLess(float(abs(material.reciprocity[:, 3]).max()), 4.2)
        made = np.where(np.arange(19) >= 0, 1.0, 0) * np.array([[1.0], [1.1]])
        pairs = reciprocity(made, made * 0.01, [10, 50], Bins(18, 36), np.ones((2, 19)))
        np.testing.assert_allclose(pairs[0], (10, 50, 1 / 1.1 - 1, -0.1 / np.hypot(0.01, 0.011)))


class Lobes(unittest.TestCase):
    def test_cells_of_even_light(self):
        """Packets by the cosine law give f = 1 / pi in every cell, also in joined cells. The light comes from 50 degrees."""
        dice = np.random.default_rng(3)
        sine, phi = np.sqrt(dice.random(400000)), dice.uniform(0, 2 * np.pi, 400000)
        flights = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine**2)], axis=1)
        cells = cells_of(np.full(len(sine), 1 / len(sine)), flights, np.radians(50), CELLS)
        u, v = nodes(CELLS)
        cosine, _, along = exits(u, v, np.radians(50))
        inside = (cosine > 0.1) & (along > 0)
        self.assertLess(abs(cells[inside] * np.pi - 1).max(), 0.75)  # a cell holds 50 packets
        self.assertLess(abs(cells[inside].mean() * np.pi - 1), 0.02)

    def test_a_lobe_stands_where_light_is_mirrored(self):
        """Packets near the mirrored direction lie at small u for any angle. Packets that fly back to the light lie at the u of their angle."""
        for angle in np.radians([10, 60]):
            flights = np.array([[np.sin(angle), 0, np.cos(angle)]] * 60 + [[-np.sin(angle), 1e-4, np.cos(angle)]] * 60)
            cells = cells_of(np.full(120, 1e-3), flights, angle, CELLS)
            back = int(round(np.sqrt(2 * angle / np.pi) * (CELLS - 1)))
            self.assertGreater(cells[:, :2].max(), 100)
            self.assertGreater(cells[CELLS // 2, back], 10 * cells[CELLS // 4, CELLS - 1])

    def test_the_share_of_a_gloss(self):
        """The file of a rough face over black holds the light that the face reflects."""
        face = mc.Scene([mc.Layer(n=1.5, mua=1000, mus=0, g=0, d=1, top_rough=mc.Rough("beckmann", 0.2))], n_below=1.5)
        material = mc.brdf(face, angles=[0, 40], photons=2e5, target_error=None)
        with tempfile.TemporaryDirectory() as folder:
            quiet(material.to_bsdf, os.path.join(folder, "face.rgb.bsdf"))
            table = read_tensor(os.path.join(folder, "face.rgb.bsdf"))
        theta, phi = np.meshgrid((np.arange(90) + 0.5), np.arange(5, 360, 10), indexing="ij")
        for i, angle in enumerate((0, 40)):
            held = sum(looked_up(table, "rgb", 1, np.radians(angle), np.radians(t), np.radians(p)) * np.sin(np.radians(t)) for t, p in zip(theta.ravel(), phi.ravel()))
            self.assertLess(abs(held * np.radians(1) * np.radians(10) / float(material.albedo_R[i]) - 1), 0.02)


class Files(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = held.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def write_all(self, material, stem):
        names = [self.path(stem + end) for end in (".bsdf", ".rgb.bsdf", ".txt", ".h5", ".svg")]
        quiet(material.to_bsdf, names[0])
        quiet(material.to_bsdf, names[1])
        material.to_text(names[2])
        material.to_h5(names[3])
        material.plot(names[4])
        found = []
        for name in names:
            with open(name, "rb") as file:
                found.append(file.read())
        return found

    def test_one_seed_has_one_set_of_bytes(self):
        found = [self.write_all(mc.brdf(SLAB, angles=[0, 10], photons=2000, target_error=None, seed=seed, threads=threads), f"s{i}")
                 for i, (seed, threads) in enumerate(((1, 1), (1, 2)))]
        self.assertEqual(found[0], found[1])
        quiet(mc.brdf(SLAB, angles=[0, 10], photons=2000, target_error=None, seed=2).to_bsdf, self.path("other.bsdf"))
        with open(self.path("other.bsdf"), "rb") as file:
            self.assertNotEqual(found[0][0], file.read())

    def test_what_pbrt_asks_of_a_file(self):
        material = quiet(mc.brdf, SLAB, angles=[10, 20], photons=2000, target_error=None, channels={"nm": [450, 550, 650], "layer1.mua": [5, 1, 0.5]})
        quiet(material.to_bsdf, self.path("a.bsdf"))
        fields = read_tensor(self.path("a.bsdf"))
        shapes = {name: field.shape for name, field in fields.items()}
        m = shapes["luminance"][2]
        t = 1 + 5 + 1  # 0, then 10 to 20 in steps of 2.5, then 90
        self.assertEqual(shapes, {"theta_i": (t,), "phi_i": (1,), "ndf": (2, 2), "sigma": (2, 2), "vndf": (1, t, 2, 2), "luminance": (1, t, m, m),
                                  "spectra": (1, t, 3, m, m), "wavelengths": (3,), "description": shapes["description"], "jacobian": (1,)})
        self.assertEqual({name: field.dtype.kind for name, field in fields.items() if field.dtype.kind != "f"}, {"description": "u", "jacobian": "u"})
        self.assertEqual((fields["jacobian"][0], fields["phi_i"][0], fields["theta_i"][0]), (1, 0, 0))
        self.assertTrue((fields["ndf"] / (4 * fields["sigma"]) == 1).all() and (fields["vndf"] == 1).all())
        self.assertTrue((np.diff(fields["theta_i"]) > 0).all())
        np.testing.assert_array_equal(fields["wavelengths"], [450, 550, 650])
        self.assertGreater(fields["luminance"].min(), 0)
        self.assertGreaterEqual(fields["spectra"].min(), 0)
        self.assertTrue(fields["description"].tobytes().decode().startswith("Scene; "))

    def test_a_file_holds_the_fit(self):
        """A .bsdf gives f cos theta_o to 2 % at the flown angles, away from the horizon. A packet that flies straight on is on the mirror side."""
        material = mc.brdf(SLAB, angles=[0, 50], photons=5000, target_error=None)
        for name in ("b.bsdf", "b.rgb.bsdf"):
            quiet(material.to_bsdf, self.path(name))
        for name, kind, channels in (("b.bsdf", "spectra", 2), ("b.rgb.bsdf", "rgb", 3)):
            fields = read_tensor(self.path(name))
            self.assertEqual(fields[kind].shape[2], channels)
            for theta_o, phi in ((5, 0), (30, 60), (50, 180), (60, 170), (70, 250)):
                expected = material.f(50, theta_o, phi - 180) * np.cos(np.radians(theta_o))
                self.assertLess(abs(looked_up(fields, kind, channels - 1, np.radians(50), np.radians(theta_o), np.radians(phi)) / expected - 1), 0.02)
        fields = mc.read_bsdf(self.path("b.bsdf"))
        np.testing.assert_array_equal(fields["spectra"], read_tensor(self.path("b.bsdf"))["spectra"])

    def test_a_file_near_the_horizon(self):
        """Light of the fit in rings of exits, also halfway between the file's angles of incidence. Linear interpolation of the fit's values every
        5 degrees would be off by 0.6 %, 6 % near the horizon, and 31 to 103 % in the last 2.5 degrees."""
        material = mc.brdf(SLAB, angles=[0, 20, 50, 80], photons=20000, target_error=None)
        quiet(material.to_bsdf, self.path("h.bsdf"))
        fields = read_tensor(self.path("h.bsdf"))
        phi = np.arange(3, 360, 6.0)
        for theta_i, low, high, limit in ((65, 30, 35, 0.003), (71.25, 30, 35, 0.003), (71.25, 82.5, 87.5, 0.02), (30, 87.5, 90, 0.15), (21.25, 87.5, 90, 0.5)):
            theta_o = low + (np.arange(12) + 0.5) / 12 * (high - low)
            held = sum(looked_up(fields, "spectra", 0, *np.radians([theta_i, o, p - 180])) * np.sin(np.radians(o)) for o in theta_o for p in phi)
            o, p = np.meshgrid(theta_o, phi)
            expected = (material.f(theta_i, o, p) * np.cos(np.radians(o)) * np.sin(np.radians(o))).sum()
            self.assertLess(abs(held / expected - 1), limit, (theta_i, low, held / expected - 1))

    def test_a_file_is_read_back(self):
        material = quiet(mc.brdf, SLAB, angles=[0], photons=500, target_error=None, channels={"channel": ["r", "g", "b"], "layer1.mua": [1, 2, 3]})
        material.to_h5(self.path("d.h5"))
        again = mc.read_material(self.path("d.h5"))
        self.assertEqual(again.channels(), ["r", "g", "b"])
        for name, array in material.data.data_vars.items():
            np.testing.assert_array_equal(array, again[name], name)
        self.assertEqual(again.attrs["half"], "none")
        quiet(again.to_bsdf, self.path("d.rgb.bsdf"))
        with self.assertRaisesRegex(mc.InputError, "none.h5"):
            mc.read_material(self.path("none.h5"))
        with open(self.path("e.h5"), "wb") as file:
            file.write(b"no such file")
        with self.assertRaisesRegex(mc.InputError, "e.h5: not an .h5 file of a material"):
            mc.read_material(self.path("e.h5"))

    def test_the_text(self):
        material = mc.brdf(SLAB, angles=[0, 50], photons=2000, target_error=None)
        material.to_text(self.path("c.txt"))
        with open(self.path("c.txt"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertEqual([line for line in lines if line.startswith("#")][-1], "# theta_i theta_o phi f_r f_r_se f_t f_t_se")
        rows = np.loadtxt(self.path("c.txt"))
        self.assertEqual(rows.shape, (2 * 19 * 36, 7))
        np.testing.assert_allclose(rows[:, 3].reshape(2, 19, 36), material.f_r, rtol=1e-5)
        np.testing.assert_allclose(rows[19 * 36 + 36 + 1, :3], (50, 5, 10))


class Scenes(unittest.TestCase):
    def test_other_light_on_a_file(self):
        """Beams and tallies of a scene are replaced, also lines after #@. Names of files still lead to the same files."""
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "top.txt"), "w", encoding="utf-8") as file:
                file.write("2 0.01 0.1 0 1\n")
            path = os.path.join(folder, "a.mci")
            with open(path, "w", encoding="utf-8") as file:
                file.write('1.0 # version\n1\na.mco A\n10\n0.1 0.1 # "widths"\n1 1 1\nbeam disk 1 angle=20\n#@ directions 3 4\n\n1\n1\n#@ b "top.txt"\n1.4 1 1 0 1\n# a comment\n1\n')
            self.assertEqual(relit_text(path, ["beam pencil"]).splitlines(),
                             ["1.0", "1", "a.mco A", "beam pencil", "10", "0.1 0.1", "1 1 1", "1", "1", f'b "{folder}/top.txt"', "1.4 1 1 0 1", "1"])

    def test_a_hill_is_no_material(self):
        hill = mc.Scene([mc.Layer(n=1.4, mua=1, mus=10, g=0, d=0.1, top=mc.Heightfield(r=[0, 0.1], h=[0.02, 0]))], beam=mc.Beam("disk", radius=0.05, angle=10))
        with self.assertWarnsRegex(UserWarning, "the scene is not the same everywhere"):
            material = mc.brdf(hill, angles=[0, 30], photons=1000, target_error=None)
        self.assertLess(sums(material), 1e-12)
        with self.assertRaisesRegex(mc.InputError, "back = True .expected a scene of planes or tiles"):
            mc.brdf(hill, angles=[0], photons=100, back=True)

    def test_arguments(self):
        for expected, options in (("angles = .*rising angles from 0 to 89", {"angles": [10, 5]}), ("angles = ", {"angles": [0, 90]}), ("bins = ", {"bins": 3}), ("bins.1. = 7 .*even", {"bins": (4, 7)}),
                                  ("channels = .*column nm", {"channels": {"layer1.mua": [1, 2]}}), ("channels..nm.. = .*rising", {"channels": {"nm": [2, 1], "layer1.mua": [1, 2]}}),
                                  ("channels..channel.. = ", {"channels": {"channel": ["r", "b"], "layer1.mua": [1, 2]}}), ("channels = 'beam.angle'", {"channels": {"nm": [1, 2], "beam.angle": [1, 2]}}),
                                  ("back = 1 ", {"back": 1}), ("photons = 0 ", {"photons": 0}), ("target_error = 0 ", {"target_error": 0}), ("seed = -1", {"seed": -1}), ("layer9.mua", {"channels": {"nm": [1, 2], "layer9.mua": [1, 2]}, "angles": [0], "photons": 10})):
            with self.assertRaisesRegex(mc.InputError, expected):
                mc.brdf(SLAB, **options)


class Command(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.python = warm_python.start()

    def run_command(self, folder, *words):
        return subprocess.run([os.environ["CLUSTERMCML"], "brdf", *words], cwd=folder, capture_output=True, text=True, check=False,
                              env={**os.environ, "CLUSTERMCML_PYTHON": self.python})

    def test_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            SLAB.write(os.path.join(folder, "slab.mci"))
            done = self.run_command(folder, "slab.mci", "-o", "paint", "--angles", "0,10", "--photons", "1e4")
            self.assertEqual((done.returncode, sorted(os.listdir(folder))), (0, ["paint.brdf.h5", "paint.brdf.txt", "paint.bsdf", "paint.rgb.bsdf", "slab.mci"]), done.stderr)
            self.assertRegex(done.stdout, r"(?m)^ *10 degrees: R 0\.\d{5} \+- 0\.\d{5}, T 0\.\d{5}, A 0\.\d{5}; gloss 0\.00000, mirror image 0\.\d{5}, straight through 0\.\d{5}\nfit of")
            self.assertRegex(done.stderr, r"^clustermcml: note: \d\.\d % of the light at 0 degrees is a mirror image and not in the \.bsdf: put .*\n$")
            with open(os.path.join(folder, "t.csv"), "w", encoding="utf-8") as file:
                csv.writer(file).writerows([["lambda", "layer1.mua"], [450, 3], [650, 0.5]])
            done = self.run_command(folder, "slab.mci", "-o", "two", "--angles", "0", "--photons", "1e3", "--label", "lambda=t.csv", "--quiet")
            self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)
            np.testing.assert_array_equal(read_tensor(os.path.join(folder, "two.bsdf"))["wavelengths"], [450, 650])

    def test_printed_shares(self):
        """R, T, A and A_backing add up to all light. The gloss of a rough face is the Rsp of a flight."""
        rough = mc.Scene([mc.Layer(n=1.5, mua=2, mus=100, g=0.6, d=0.02, top_rough=mc.Rough("beckmann", 0.3))], backing=mc.Backing("lambertian", R=0.5))
        with tempfile.TemporaryDirectory() as folder:
            rough.write(os.path.join(folder, "rough.mci"))
            said = self.run_command(folder, "rough.mci", "--angles", "60", "--photons", "2e4", "--target-error", "1").stdout
            found = re.match(r"60 degrees: R (\S+) \+- \S+, T (\S+), A (\S+), A_backing (\S+); gloss (\S+), mirror image 0\.00000, straight through 0\.00000\n", said)
            self.assertTrue(found, said)
            *shares, gloss = map(float, found.groups())
            self.assertAlmostEqual(sum(shares), 1, delta=1e-3)
            self.assertGreater(shares[3], 0.1)
            flown = mc.run(mc.Scene(rough.layers, backing=rough.backing, beam=mc.Beam(angle=60)), photons=20000, seed=9)
            self.assertAlmostEqual(gloss, float(flown.Rsp), delta=6 * float(flown.Rsp_se))
            done = self.run_command(folder, "rough.mci", "--back", "--angles", "60")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", "clustermcml: --back: no light comes in from below a backing\n"))

    def test_bad_words(self):
        with tempfile.TemporaryDirectory() as folder:
            SLAB.write(os.path.join(folder, "slab.mci"))
            with open(os.path.join(folder, "bad.csv"), "w", encoding="utf-8") as file:
                file.write("nm,layer1.mua\n450,x\n")
            for name in ("open.csv", "own.bsdf"):
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write('nm,layer1.mua\n450,"1\n650,2\n')
            for words, expected in ((["none.mci"], "scene = 'none.mci' (expected the path of a file that is there)"),
                                    (["slab.mci", "--angles", "0,x"], "--angles 0,x (expected angles in degrees, as 0,30,60)"),
                                    (["slab.mci", "--photons", "0"], "--photons 0 (expected a whole number from 1 to 281474976710656)"),
                                    (["slab.mci", "--label", "nm=bad.csv"], "bad.csv: row 1 = 450,x (expected 2 numbers)"),
                                    (["slab.mci", "--label", "um=bad.csv"], "bad.csv: no table with a column um (expected a first line of names, then numbers)"),
                                    (["slab.mci", "-o", "no/such"], "--output no/such (expected the beginning of a file's name, in a folder that is there)"),
                                    (["slab.mci", "-o", ""], "--output '' (expected the beginning of a file's name, in a folder that is there)"),
                                    (["slab.mci", "-o", "./"], "--output ./ (expected the beginning of a file's name, in a folder that is there)"),
                                    (["slab.mci", "--seed", "1.5"], "--seed 1.5 (expected a whole number from 0 to 1099511627776)"),
                                    (["slab.mci", "--threads", "1e9"], "--threads 1e9 (expected a whole number from 1 to 4096)"),
                                    (["slab.mci", "--angles", "\x1b[31m"], "--angles \\x1b[31m (expected angles in degrees, as 0,30,60)"),
                                    (["slab.mci", "--label", "nm=open.csv"], "open.csv: not a table (Error: unexpected end of data)"),
                                    (["slab.mci", "--label", "nm=own.bsdf", "-o", "own"], "brdf: -o own.bsdf would overwrite its input own.bsdf"),
                                    ([], "brdf: the following arguments are required: scene.mci (try clustermcml brdf --help)")):
                done = self.run_command(folder, *words)
                self.assertEqual((done.returncode, done.stderr, done.stdout), (2, f"clustermcml: {expected}\n", ""), words)
            self.assertEqual(sorted(os.listdir(folder)), ["bad.csv", "open.csv", "own.bsdf", "slab.mci"])


class Long(unittest.TestCase):
    packets = 10_000_000

    def test_reciprocity(self):
        """f is reciprocal for a slab, a rough face (in bins of 1 degree, for its lobe), and a tile with equal sides, in its plane of symmetry."""
        paint = mc.Layer(n=1.5, mua=5, mus=200, g=0.7, d=0.02)
        rough = mc.Layer(n=1.5, mua=5, mus=200, g=0.7, d=0.02, top_rough=mc.Rough("beckmann", 0.3))
        tile = mc.Layer(n=1.5, mua=5, mus=200, g=0.7, d=0.05, top=WAVES)
        for name, layer, bins in (("slab", paint, (18, 36)), ("rough", rough, (90, 36)), ("tile", tile, (90, 36))):
            material = mc.brdf(mc.Scene([layer], n_below=1.5), angles=[20, 40, 60, 80], photons=self.packets, target_error=None, bins=bins)
            pairs = material.reciprocity.values
            print(f"{name}: {len(pairs)} pairs, median difference {100 * np.median(abs(pairs[:, 2])):.2f} %, worst z {abs(pairs[:, 3]).max():.1f}, chi^2 {float(material.chi2):.2f}")
            self.assertEqual(len(pairs), 6)
            self.assertLess(abs(pairs[:, 3]).max(), 4, name)

    def test_a_lambertian_ground(self):
        """A lambertian ground has f = R / pi to 1e-3 (rms over directions), by the fit and by the file. With 1e8 packets, 45 terms are known to
        0.7e-3."""
        ground = mc.Scene([mc.Layer(n=1, mua=0, mus=0, g=0, d=0.01)], backing=mc.Backing("lambertian", R=0.8))
        material = mc.brdf(ground, photons=self.packets, target_error=None)
        dice = np.random.default_rng(4)
        theta_i, theta_o, phi = np.degrees(np.arcsin(np.sqrt(dice.random(500)))), np.degrees(np.arcsin(np.sqrt(dice.random(500)))), dice.uniform(0, 360, 500)
        off = {"fit": material.f(theta_i, theta_o, phi) * np.pi / 0.8 - 1}
        with tempfile.TemporaryDirectory() as folder:
            quiet(material.to_bsdf, os.path.join(folder, "g.bsdf"))
            fields = read_tensor(os.path.join(folder, "g.bsdf"))
        near = (theta_i < 80) & (theta_o < 70)
        off["file"] = np.array([looked_up(fields, "spectra", 0, *np.radians(angles)) / np.cos(np.radians(angles[1])) for angles in zip(theta_i[near], theta_o[near], phi[near])]) * np.pi / 0.8 - 1
        for name, values in off.items():
            rms = float(np.sqrt(np.mean(values**2)))
            print(f"lambertian ground, {name}: rms {rms:.5f}, mean {np.mean(values):+.5f}")
            self.assertLess(rms, 1e-3 * np.sqrt(1e7 / self.packets), name)

    def test_errors_are_true(self):
        """Errors of 20 random materials are true, by two seeds: z in bins of 60 packets and more has the spread of Student's t, and |z| of albedos
        stays below 4.5."""
        dice, spread, albedos = np.random.default_rng(5), [], []
        for _ in range(20):
            face = mc.Rough("ggx", dice.uniform(0.1, 0.6)) if dice.random() < 0.5 else None
            layers = [mc.Layer(n=dice.uniform(1, 1.6), mua=10 ** dice.uniform(-1, 1.5), mus=10 ** dice.uniform(1, 2.5), g=dice.uniform(0, 0.9), d=10 ** dice.uniform(-2, -0.5), top_rough=face)
                      for face in ([face, None, None])[:dice.integers(1, 4)]]
            scene = mc.Scene(layers, n_below=dice.uniform(1, 1.6))
            a, b = (mc.brdf(scene, angles=[0, 35, 70], photons=20000, target_error=None, seed=seed, bins=(6, 6)) for seed in (1, 2))
            enough = ((a.f_r + b.f_r) / 2 * a.projected * 20000 > 60).values
            z = ((a.f_r - b.f_r) / np.hypot(a.f_r_se, b.f_r_se)).values[enough]
            spread += list(z)
            albedos += list(((a.albedo_R - b.albedo_R) / np.hypot(a.albedo_R_se, b.albedo_R_se)).values)
        rms = float(np.sqrt(np.mean(np.square(spread))))
        print(f"{len(spread)} bins of 20 materials: rms z {rms:.3f}; albedos: {np.sqrt(np.mean(np.square(albedos))):.2f}, worst {np.max(np.abs(albedos)):.1f}")
        self.assertLess(abs(rms - np.sqrt(30 / 28)), 0.05)
        self.assertLess(np.max(np.abs(albedos)), 4.5)


def load_tests(loader, tests, pattern):
    return unittest.TestSuite(loader.loadTestsFromTestCase(case) for case in (Tables, Fits, Lobes, Files, Scenes, Command))


if __name__ == "__main__":
    if sys.argv[1:2] == ["long"]:
        Long.packets = int(float((sys.argv[2:] + ["1e7"])[0]))
        sys.exit(not unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Long)).wasSuccessful())
    unittest.main()
