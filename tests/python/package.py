"""Tests of the Python package against files and the program: arrays equal those of files, scenes are written as meant, runs give the results of the
command line, an interrupt leaves a checkpoint, and every error names the argument, its value and the expectation."""
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, h5py, mc, np, xr  # noqa: E402
from clustermcml.program import NONE, _fly_program, _listen, find_program, result_of  # noqa: E402
from clustermcml.progress import Progress  # noqa: E402

SLAB = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
SKIN = os.path.join(TOP, "samples", "skin7.mci")


def command(*words):
    """Returns the standard output of the program."""
    return subprocess.run([find_program(), *words], stdout=subprocess.PIPE, check=True, text=True).stdout


def numbers_of(path, key, count):
    """Returns the first `count` numbers of a section of an .mco, read from its text."""
    with open(path, encoding="utf-8") as file:
        body = re.split(r"(?m)^%s( #.*)?$" % key, file.read())[-1]
    return [float(word) for word in re.sub("#.*", "", body).split()[:count]]


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        octahedron = mc.Mesh(vertices=[[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], scale=0.01, shift=(0.1, 0, -0.05),
                             faces=[[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
        upwards = mc.Phase("table", angles=[0, 60, 180], densities=[2, 1.5, 0])  # 1 + c, up to a factor
        bodies = [mc.Sphere(0, 0, 0.05, 0.01, 1.5, 3, 40, 0.3333, phase=upwards), mc.Body(octahedron, 1.6, 4, 50, 0.25, union=True)]
        scene = mc.Scene([mc.Layer(1.34, 0.2, 0, 0, 0.02), mc.Layer(1.4, 1, 100, 0.9, 0.1, bodies=bodies, phase=mc.Phase("gk", g=0.9, a=0.5))], photons=2000, nr=7, nz=5, na=3, dr=0.05, dz=0.03,
                         map=mc.Map(4, 3, 0.1, 0.2, angles=True, volume=True), facets=True, format="A",
                         bottom=mc.Heightfield([0, 0.1], [0.02, 0]))
        backed = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1)], photons=2000, backing=mc.Backing("lambertian", R=0.5), format="A",
                          time=mc.Time(end=50, n=10), directions=mc.Directions(nt=3, np=4), map=mc.Map(4, 3, 0.1, 0.2),
                          detectors=[mc.Detector("map", nx=4, ny=3, dx=0.1, dy=0.2, na=1, diffuse=True, name="cam"), mc.Detector("disk", radius=0.2, na=0.5),
                                     mc.Detector("ring", r1=0, r2=1e6)],
                          fluence=True, nr=6, nz=5, dr=0.02, dz=0.02)
        backed.write(os.path.join(cls.folder.name, "backed.mci"))
        for end in (".mco", ".h5"):
            command(os.path.join(cls.folder.name, "backed.mci"), "--quiet", "--output", "backed" + end, "-o", cls.folder.name)
        scene.write(os.path.join(cls.folder.name, "a.mci"))
        command(os.path.join(cls.folder.name, "a.mci"), "--quiet", "-o", cls.folder.name)
        cls.mco, cls.h5 = (os.path.join(cls.folder.name, "a" + end) for end in (".mco", ".h5"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_mco(self):
        data = mc.read(self.mco)
        for name, shape in (("A_l", 2), ("A_z", 5), ("Rd_r", 7), ("Tt_a", 3), ("A_rz", (7, 5)), ("Rd_ra", (7, 3))):
            np.testing.assert_array_equal(data[name].values, np.reshape(numbers_of(self.mco, name, np.prod(shape)), shape), name)
        for name, count in (("Rd_r", 7), ("A_l", 2)):
            np.testing.assert_array_equal(data[name + "_se"].values, numbers_of(self.mco, "se_" + name, count))
        self.assertEqual(data.photons, 2000)
        self.assertEqual(data.attrs["seed"], 1)
        np.testing.assert_array_equal(data.layer_n, [1.34, 1.4])

    def test_h5(self):
        data = mc.read(self.h5)
        with h5py.File(self.h5) as file:
            arrays = [name for name in file if isinstance(file[name], h5py.Dataset)]
            self.assertEqual(sorted(data.variables), sorted(arrays))
            for name in arrays:
                np.testing.assert_array_equal(data[name].values, file[name][()], name)
                self.assertEqual(data[name].attrs["units"], file[name].attrs["units"].decode())
        self.assertEqual(data.Rd_xya.dims, ("y", "x", "alpha"))

    def test_both_say_the_same(self):
        mco, h5 = mc.read(self.mco), mc.read(self.h5)
        self.assertLessEqual(set(mco.variables), set(h5.variables))
        for name in set(h5.variables) - set(mco.variables):  # maps and facets
            self.assertRegex(name, r"^([xy]|z_volume|\w+_xy\w*|\w+_outside|boundary\w+|body_(facet|of_facet|area|(irradiance|exitance)_\w+))$")
        for name in mco.variables:
            np.testing.assert_allclose(mco[name], h5[name], rtol=6e-4, atol=1e-12, err_msg=name)
            self.assertEqual(mco[name].dims, h5[name].dims, name)
            for said in ("units", "long_name", "ancillary_variables"):
                self.assertEqual(mco[name].attrs.get(said), h5[name].attrs.get(said), name)
        for name in ("photons", "seed", "run", "engine", "sampling", "version", "title"):
            self.assertEqual(mco.attrs[name], h5.attrs[name], name)

    def test_phases(self):
        """Phase functions of a layer and of the first body, a table beside the scene, stand in both files. The .h5 names the table without folders."""
        with open(os.path.join(self.folder.name, "a.layer2body0.phase.txt"), encoding="utf-8") as file:
            self.assertEqual([list(map(float, line.split())) for line in file], [[0, 2], [60, 1.5], [180, 0]])
        layer, body = mc.read(self.h5).phases.splitlines()
        self.assertEqual(layer, "phase of layer 2: gk 0.9 0.5")
        self.assertRegex(body, r"^phase of body 1: table of 3 rows, crc32 [0-9a-f]{8} from a\.layer2body0\.phase\.txt$")
        self.assertEqual([line.split(" from ")[0] for line in mc.read(self.mco).phases.splitlines()], [layer, body.split(" from ")[0]])
        for wrong in (dict(kind="hg"), dict(kind="gk", g=0.9), dict(kind="rayleigh", a=1), dict(kind="table", angles=[0, 180])):
            with self.assertRaises(mc.InputError):
                mc.Phase(**wrong)

    def test_backing(self):
        """Both files name the backing and the light that it kept. Bad backings are refused."""
        mco, h5 = (mc.read(os.path.join(self.folder.name, "backed" + end)) for end in (".mco", ".h5"))
        for data in (mco, h5):
            self.assertEqual(data.phases.strip(), "backing: lambertian, R = 0.5")
            self.assertGreater(data.A_backing, 0)
            self.assertGreater(data.A_backing_se, 0)
        np.testing.assert_allclose(mco.A_backing, h5.A_backing, rtol=1e-8)
        self.assertAlmostEqual(float(h5.Rsp + h5.Rd + h5.A + h5.Tt + h5.A_backing), 1, 3)
        for wrong in (dict(), dict(R=1.1), dict(kind="metal", n=1), dict(kind="mirror", R=1, n=1), dict(kind="paint", R=1)):
            with self.assertRaises(mc.InputError):
                mc.Backing(**wrong)

    def test_time_and_directions(self):
        """Time gates and directions have their axes, and add up to the totals, which an .mco has to six digits."""
        edges = np.linspace(0, np.pi / 2, 4)
        solid = (np.cos(edges[:-1]) - np.cos(edges[1:])) * 2 * np.pi / 4
        for data in (mc.read(os.path.join(self.folder.name, "backed" + end)) for end in (".mco", ".h5")):
            np.testing.assert_allclose(data.gate, np.arange(2.5, 50, 5))
            self.assertEqual((data.Rd_t.dims, data.Rd_dir.dims, data.Rsp_dir.shape), (("gate",), ("theta", "phi"), (3, 4)))
            for name in ("Rd", "A"):
                self.assertAlmostEqual(float((data[name + "_t"] * 5).sum() + data[name + "_t_later"]), float(data[name]), delta=1e-6)
            for name in ("Rsp", "Rd"):
                self.assertAlmostEqual(float((data[name + "_dir"].values * solid[:, None]).sum()), float(data[name]), delta=1e-6)
            self.assertGreater(float(data.Rd_dir_se.min()) * float(data.Rd_t_se.max()), 0)

    def test_detectors(self):
        """A detector with NA = n equals the map bit for bit; one that takes all light equals Rd + Rsp. Both files agree, and merging is a mean."""
        mco, h5 = (mc.read(os.path.join(self.folder.name, "backed" + end)) for end in (".mco", ".h5"))
        for end in ("", "_se"):
            np.testing.assert_array_equal(h5["detector_cam_map" + end].values, h5["Rd_xy" + end].values)
        np.testing.assert_allclose(h5.detector_cam_x, h5.x)
        self.assertAlmostEqual(float(h5.detector_cam_map.astype(float).sum() * 0.02), float(h5.detector_cam), delta=1e-6)
        self.assertAlmostEqual(float(h5.detector_3), float(h5.Rd + h5.Rsp), delta=1e-12)
        self.assertAlmostEqual(float((h5.detector_2_t * 5).sum() + h5.detector_2_t_later), float(h5.detector_2), delta=1e-12)
        for name in ("cam", "2", "3"):
            for end in ("", "_t", "_t_later", "_path", "_interactions", "_deepest"):
                np.testing.assert_allclose(mco[f"detector_{name}{end}"], h5[f"detector_{name}{end}"], rtol=1e-8)
                np.testing.assert_allclose(mco[f"detector_{name}{end}_se"], h5[f"detector_{name}{end}_se"], rtol=1e-4)
        self.assertTrue(mco.detectors.startswith("detector cam: map of 4 x 3 pixels of 0.1 x 0.2 cm at (0 0 0) cm, top, na 1"))
        self.assertEqual((mco.detectors, mco.detector_names), (h5.detectors, "cam 2 3"))
        other = os.path.join(self.folder.name, "other.h5")
        command(os.path.join(self.folder.name, "backed.mci"), "--quiet", "--seed", "2", "--output", "other.h5", "-o", self.folder.name)
        other, both = mc.read(other), mc.merge([os.path.join(self.folder.name, "backed.h5"), other])
        for name in ("detector_2", "detector_2_t", "detector_cam_map"):
            np.testing.assert_allclose(both[name], (h5[name] + other[name]) / 2, rtol=1e-6, atol=1e-9)
        for name in ("detector_2_path", "detector_2_interactions", "detector_2_deepest"):
            mean = np.average([h5[name], other[name]], axis=0, weights=[float(h5.detector_2), float(other.detector_2)])
            np.testing.assert_allclose(both[name], mean, rtol=1e-6, atol=1e-9)

    def test_fluence(self):
        """Fluence has its axes, and phi mua equals the absorption within the noise of few packets."""
        for data in (mc.read(os.path.join(self.folder.name, "backed" + end)) for end in (".mco", ".h5")):
            self.assertEqual((data.phi_rz.dims, data.phi_z.dims), (("r", "z"), ("z",)))
            np.testing.assert_allclose(data.phi_z[:5] * 1, data.A_z[:5], rtol=0.05)
            self.assertGreater(float(data.phi_z_se.min()) * float(data.phi_rz_se.max()), 0)

    def test_fluence_by_time(self):
        scene = mc.Scene(layers=[mc.Layer(n=1.4, mua=1, mus=50, g=0.8, d=0.1)], photons=1000, fluence="time", time=mc.Time(end=20, n=4), nr=6, nz=5, dr=0.02, dz=0.02)
        result = mc.run(scene)
        self.assertEqual((result.phi_rzt.dims, result.phi_rzt_later.dims), (("r", "z", "gate"), ("r", "z")))
        np.testing.assert_allclose(5 * result.phi_rzt.sum("gate") + result.phi_rzt_later, result.phi_rz, rtol=1e-12)
        for wrong in ("gate", 1, np.ones(2)):
            with self.assertRaisesRegex(mc.InputError, "Scene.fluence"):
                mc.Scene(layers=scene.layers, fluence=wrong)
        self.assertEqual(mc.merge([result, mc.run(scene, seed=2)]).attrs["photons"], 2000)

    def test_original_mcml(self):
        """Files of original MCML end after Tt_ra, and have no errors."""
        path = os.path.join(self.folder.name, "old.mco")
        with open(self.mco, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as old:
            old.write(file.read().replace("   Last line: # end", "").split("\n# clustermcml")[0])
        data = mc.read(path)
        xr.testing.assert_equal(data.Tt_ra, mc.read(self.mco).Tt_ra)
        self.assertNotIn("Rd_se", data)

    def test_names(self):
        """The name of the output may be one word, have blanks, or hold a sign that begins a comment."""
        path = os.path.join(self.folder.name, "renamed.mco")
        with open(self.mco, encoding="utf-8") as file:
            text = file.read()
        for name in ("skin", "two words.mco", "a b", "x#y.mco", "RAT.mco"):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text.replace("\na.mco \tA", "\n%s \tA" % name))
            data = mc.read(path)
            self.assertEqual((data.title, data.photons), (name, 2000))
            xr.testing.assert_equal(data, mc.read(self.mco)[list(data.data_vars)])
            self.assertEqual(data.lacks, path[:-4] + ".h5")  # is read only if it is of the same run

    def test_damaged(self):
        path = os.path.join(self.folder.name, "cut.mco")
        with open(self.mco, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as cut:
            cut.write(file.read()[:900])
        with open(self.mco, encoding="utf-8") as file:
            whole = file.read()
        for name, content in (("end.mco", whole.removesuffix("# end\n")), ("line.mco", whole.removesuffix("\n")), ("two.mco", 2 * whole), ("not.mco", "hello"), ("not.h5", "hello"), ("not.txt", "hello")):
            with open(os.path.join(self.folder.name, name), "w", encoding="utf-8") as file:
                file.write(content)
        for name, text in (("cut.mco", "the file is cut off"), ("end.mco", "expected # end"), ("line.mco", "expected # end"), ("two.mco", "text behind # end"), ("not.mco", "not an .mco"), ("not.h5", "not an .h5"),
                           ("not.txt", "expected a name that ends in .mco or .h5"), ("none.h5", "a file that is there")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.read(os.path.join(self.folder.name, name))


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "scene.mci")

    def checked(self, scene):
        scene.write(self.path)
        return json.loads(command("check", "--json", self.path))

    def test_everything_arrives(self):
        scene = mc.Scene([mc.Layer(1.37, 0.1, 50.5, -0.3, 1e-3), SLAB], n_above=1.1, n_below=1.2, photons=12345, dr=0.1, dz=0.2, nr=3,
                         nz=4, na=5, beam=mc.Beam("gaussian", 0.1, at=(0.01, -0.02), angle=30, azimuth=45),
                         map=mc.Map(6, 7, 0.1, 0.3, volume=True, top=-0.1))
        told = self.checked(scene)
        self.assertEqual(told["layers"], [{"n": 1.37, "mua": 0.1, "mus": 50.5, "g": -0.3, "d": 1e-3, "mean_d": 1e-3},
                                          {"n": 1.4, "mua": 1.0, "mus": 100.0, "g": 0.9, "d": 0.1, "mean_d": 0.1}])
        self.assertEqual((told["n_above"], told["n_below"], told["photons"]), (1.1, 1.2, 12345))
        self.assertEqual(told["grid"], {"dz": 0.2, "dr": 0.1, "nz": 4, "nr": 3, "na": 5})
        self.assertEqual([told["map"][key] for key in ("nx", "ny", "dx", "dy", "volume")], [6, 7, 0.1, 0.3, True])
        with open(self.path, encoding="utf-8") as file:
            self.assertIn("beam gaussian 0.1 at=0.01,-0.02 angle=30 azimuth=45\n", file.read())

    def vertices(self):
        command("mesh", self.path, "-o", self.folder.name)
        name = next(name for name in os.listdir(self.folder.name) if name.endswith("boundary0.obj"))
        with open(os.path.join(self.folder.name, name), encoding="utf-8") as file:
            return np.array([line.split()[1:4] for line in file if line.startswith("v ")], dtype=float)

    def test_heightmap_lies_as_the_array_says(self):
        heights = np.zeros((5, 7))
        heights[3, 1] = 0.02  # above the middle of the map, left of it
        self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1, 0.2))]))
        peak = max(self.vertices(), key=lambda vertex: vertex[2])
        np.testing.assert_allclose(peak, [-0.2, 0.2, 0.02], atol=1e-7)

    def test_heightmap_is_repeated(self):
        heights = np.array([[0, 0.02, 0.01], [0, 0.01, 0.02]])
        for tile, period in ((True, "0.3 x 0.2"), ("mirror", "0.4 x 0.2")):
            scene = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(heights, 0.1, tile=tile))])
            self.assertIn(f"repeated every {period} cm", self.checked(scene)["boundaries"][0]["reason"])

    def test_heights_of_any_kind_of_number(self):
        """Arrays of every kind and byte order of number write the same file as double precision."""
        heights = np.array([[0, 1, 2], [3, 0, 1]]) / 1024  # exact in all kinds of numbers; a hundredth of it is not exact in half precision
        files = []
        for array in (heights, heights.astype("f2"), heights.astype(">f4"), np.asfortranarray(heights), heights.tolist()):
            mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap(array, 0.1))]).write(self.path)
            with open(os.path.join(self.folder.name, "scene.surface0.gsf"), "rb") as file:
                files.append(file.read())
        self.assertEqual(files, [files[0]] * 5)

    def test_faces_of_small_integers(self):
        """Indices of faces, counted from 1 in the file, do not overflow small integers."""
        vertices = np.array([[np.cos(k), np.sin(k), 0] for k in np.arange(255) / 255 * 2 * np.pi] + [[0, 0, 0.1]])
        faces = np.array([[k, (k + 1) % 255, 255] for k in range(255)], dtype="u1")
        told = self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Mesh(vertices=vertices, faces=faces))]))
        self.assertEqual(told["boundaries"][0]["kind"], "mesh")

    def test_paths_with_blanks(self):
        self.path = os.path.join(self.folder.name, "H\u00fcgel zwei.mci")
        self.assertEqual(self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightmap([[0, 0.01], [0, 0]], 0.1))]))["output"],
                         "H\u00fcgel zwei.mco")

    def test_values_from_arrays(self):
        """Booleans and arrays of numpy are taken like Python's."""
        scene = mc.Scene([SLAB], facets=np.True_, beam=mc.Beam(at=np.array([0.1, 0])), map=mc.Map(2, 2, 1, 1, angles=np.True_))
        self.assertIn("beam pencil at=0.1,0\nmap 2 2 1 1 angles\nfacets\n", scene.text("a.mco"))
        several = mc.Scene([SLAB], beam=[mc.Beam(), mc.Beam("rectangle", width=1, height=2, light="na:0.2", z=0.1, angle=120, share=3)])
        self.assertIn("beam pencil\nbeam rectangle 1 2 z=0.1 angle=120 light=na:0.2 share=3\n", several.text("a.mco"))

    def test_mesh_from_arrays(self):
        vertices = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0.1, 0.2, 0.05]]
        faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
        mesh = mc.Mesh(vertices=vertices, faces=faces, units="mm", shift=(0, 0, 0.001))
        self.assertEqual(self.checked(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, mesh)]))["boundaries"][0]["kind"], "mesh")
        peak = max(self.vertices(), key=lambda vertex: vertex[2])
        np.testing.assert_allclose(peak, [0.01, 0.02, 0.006], atol=1e-9)

    def test_errors_name_argument_value_and_what_was_expected(self):
        cases = [(lambda: mc.Layer(1.4, -1, 1, 0, 1), r"Layer\.mua = -1 \(expected a number >= 0\)"),
                 (lambda: mc.Layer(1.4, 1, 1, 2, 1), r"Layer\.g = 2 \(expected"),
                 (lambda: mc.Layer(1.4, 1, 1, 0, "1"), r"Layer\.d = '1' \(expected"),
                 (lambda: mc.Layer(1.4, 1, float("nan"), 0, 1), r"Layer\.mus = nan \(expected"),
                 (lambda: mc.Layer(1.4, 1, 1, 0, 1, top="a.obj"), r"Layer\.top = 'a\.obj' \(expected"),
                 (lambda: mc.Beam("disc", 1), r"Beam\.kind = 'disc' \(expected"), (lambda: mc.Beam("disk"), r"Beam\.radius = None"),
                 (lambda: mc.Beam(angle=90), r"Beam\.angle = 90"), (lambda: mc.Beam(z=1, angle=181), r"Beam\.angle = 181"),
                 (lambda: mc.Beam("ring", r1=1), r"Beam\.r2 = None"), (lambda: mc.Beam("disk", 1, width=2), r"Beam\.width = 2"),
                 (lambda: mc.Beam("image"), r"Beam\.file = None"), (lambda: mc.Beam(light=1), r"Beam\.light = 1"),
                 (lambda: mc.Beam(at=1), r"Beam\.at = 1 \(expected 2 numbers"),
                 (lambda: mc.Map(0, 1, 1, 1), r"Map\.nx = 0"), (lambda: mc.Map(1, 1, 1, 1, top=1), r"Map\.top = 1"),
                 (lambda: mc.Heightfield([0, 1], [0]), r"Heightfield\.h = \[0\] \(expected 2 finite"),
                 (lambda: mc.Heightfield([1, 2], [0, 0]), r"Heightfield\.r = \[1, 2\]"),
                 (lambda: mc.Heightmap([1.0, 2.0], 1), r"Heightmap\.heights = \[1\.0, 2\.0\]"),
                 (lambda: mc.Mesh("none.obj"), r"Mesh\.path = 'none\.obj' \(expected"), (lambda: mc.Mesh(), r"Mesh\.path = None"),
                 (lambda: mc.Layer(1.4, 10**400, 1, 0, 1), r"Layer\.mua = 1000"), (lambda: mc.Layer(1.4, np.True_, 1, 0, 1), r"Layer\.mua = "),
                 (lambda: mc.Heightfield(["a"], [0]), r"Heightfield\.r = \['a'\] \(expected"),
                 (lambda: mc.Heightfield([0, 1], [0, None]), r"Heightfield\.h = \[0, None\] \(expected"),
                 (lambda: mc.Heightmap([[0, 1], [2]], 1), r"Heightmap\.heights = \[\[0, 1\], \[2\]\] \(expected"),
                 (lambda: mc.Heightmap(np.ma.masked_less([[0, 1], [2, 3]], 1), 1), r"Heightmap\.heights\[0, 0\] = masked \(expected"),
                 (lambda: mc.Heightmap(np.where(np.arange(900).reshape(30, 30) % 400 == 307, np.nan, 0), 1),
                  r"^Heightmap\.heights\[10, 7\] = nan \(expected .*; 2 of 900 numbers are missing, the first here\)$"),
                 (lambda: mc.Heightfield([0, 1], [0, np.inf]), r"Heightfield\.h\[1\] = inf \(expected"), (lambda: mc.Heightmap(np.nan, 1), r"Heightmap\.heights = nan \(exp"),
                 (lambda: mc.Heightmap([[0, 0], [0, 1e39]], 1), r"Heightmap\.heights = .* \(expected"),
                 (lambda: mc.Heightmap([[0, 0], [0, 0]], 1, tile=1), r"Heightmap\.tile = 1 \(expected"),
                 (lambda: mc.Mesh(vertices=[[0, 0, 0]], faces=np.zeros((0, 3), int)), r"Mesh\.faces = array\("),
                 (lambda: mc.Mesh(vertices=[[0, 0], [1]], faces=[[0, 1, 2]]), r"Mesh\.vertices = "),
                 (lambda: mc.Mesh(SKIN, faces=[[0, 1, 2]]), r"Mesh\.path = .* \(expected either"),
                 (lambda: mc.Map(1, 1, 1, 1, angles="no"), r"Map\.angles = 'no' \(expected True or False"),
                 (lambda: mc.Scene([SLAB], facets=2), r"Scene\.facets = 2 \(expected True or False"),
                 (lambda: mc.Scene(5), r"Scene\.layers = 5 \(expected"), (lambda: mc.Scene([SLAB], format=["A"]), r"Scene\.format = \['A'\]"),
                 (lambda: mc.Heightmap([[0, 0], [0, 0]], 1, tile="twice"), r"Heightmap\.tile = 'twice' \(expected"),
                 (lambda: mc.Mesh(vertices=[[0, 0, 0]], faces=[[0, 1, 2]]), r"Mesh\.faces = .* \(expected indices from 0 to 0"),
                 (lambda: mc.Body(mc.Mesh(SKIN), 1.4, 1, 1, 0, union="yes"), r"Body\.union = 'yes' \(expected True or False"),
                 (lambda: mc.Scene([]), r"Scene\.layers = \[\] \(expected"), (lambda: mc.Scene([SLAB], photons=0.5), r"Scene\.photons = 0\.5"),
                 (lambda: mc.Scene([SLAB], nr=2.5), r"Scene\.nr = 2\.5"), (lambda: mc.Scene([SLAB], beam=None), r"Scene\.beam = None")]
        for make, text in cases:
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                make()
            self.assertNotIn("\n", str(caught.exception))
        self.assertIn("\n1.4 1 100 0.9 0\n", mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0)]).text("a.mco"))  # original MCML allows it, too


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_as_the_command_line(self):
        mine = mc.run(SKIN, photons=3000, seed=5, output_dir=self.folder)
        kept = mc.read(os.path.join(self.folder, "skin7.mco"))
        xr.testing.assert_equal(mine, kept)
        other = os.path.join(self.folder, "other")
        os.mkdir(other)
        command(SKIN, "--photons", "3000", "--seed", "5", "--quiet", "-o", other)
        xr.testing.assert_equal(mine, mc.read(os.path.join(other, "skin7.mco")))
        self.assertGreater(mine.attrs["steps"], 3000)

    def test_nothing_stays_without_a_folder(self):
        with unittest.mock.patch.object(tempfile, "tempdir", self.folder):  # a folder of its own: other processes make folders in the common one
            mc.run(mc.Scene([SLAB], photons=100))
        self.assertEqual(os.listdir(self.folder), [])

    def test_errors_are_the_programs(self):
        scene = mc.Scene([SLAB], photons=100)
        for options, text in (({"seed": "x"}, r"--seed x \(expected a whole number"), ({"sead": 1}, "unknown option --sead"),
                              ({"json": True}, r"json = True"),
                              ({"help": True}, r"help = True"), ({"sweep": "a.csv"}, r"sweep = 'a.csv'"), ({"output_dir": "/dev/null/none"}, r"output_dir = '/dev/null/none' \(expected a folder")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.run(scene, **options)
        with self.assertRaisesRegex(mc.InputError, "scene = 'none.mci'"):
            mc.run("none.mci")

    def test_set(self):
        result = mc.run(mc.Scene([SLAB], photons=100), set={"layer1.mua": 2, "layer1.mus": 30.5}, no_reentry=np.True_)
        self.assertEqual((float(result.layer_mua[0]), float(result.layer_mus[0]), result.reentry), (2, 30.5, 0))

    def test_name_without_an_ending(self):
        """An output without an ending is an .mco."""
        path = os.path.join(self.folder, "a.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(mc.Scene([SLAB], photons=100, format="A").text("a").replace("a A", '"two words" A'))
        self.assertEqual(mc.run(path).photons, 100)

    def test_scenes_of_others_stay(self):
        """A file in the folder with the name of the scene is overwritten only if an earlier call wrote it."""
        path = os.path.join(self.folder, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write("mine")
        with self.assertRaisesRegex(mc.InputError, "output_dir = .*scene.mci"):
            mc.run(mc.Scene([SLAB], photons=100), output_dir=self.folder)
        with open(path, encoding="utf-8") as file:
            self.assertEqual(file.read(), "mine")
        os.remove(path)
        for photons in (100, 200):
            self.assertEqual(mc.run(mc.Scene([SLAB], photons=photons), output_dir=self.folder).photons, photons)

    def test_two_calls_of_one_folder_at_a_time(self):
        """Two threads with one folder: a call returns the result of its own scene or is refused."""
        got, refused = [], []

        def call(mua):
            try:
                result = mc.run(mc.Scene([mc.Layer(1.4, mua, 100, 0.9, 0.1)], photons=200), output_dir=self.folder)
                got.append(float(result.layer_mua[0]) == mua)
            except mc.ClustermcmlError as error:
                refused.append(str(error))
        for _ in range(10):
            threads = [threading.Thread(target=call, args=(mua,)) for mua in (1, 2, 3)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertTrue(len(got) >= 10 and all(got), got)
        self.assertEqual([text for text in refused if "scene.mci: locked by another call" not in text], [])

    def test_another_process_in_the_folder(self):
        """Another process in the folder makes a call fail at once. After that process was killed, the call succeeds."""
        script = ("import sys; sys.path.insert(0, sys.argv[1]); import clustermcml as mc\n"
                  "mc.run(mc.Scene([mc.Layer(1.4, 0, 1000, 0.9, 1)], photons=1e8), output_dir=sys.argv[2])")
        scene = mc.Scene([SLAB], photons=200)
        with subprocess.Popen([sys.executable, "-c", script, sys.path[0], self.folder]) as process:
            while not os.path.exists(os.path.join(self.folder, "scene.lock")) and process.poll() is None:
                time.sleep(0.02)
            with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="utf-8") as children:
                program = int(children.read())
            with self.assertRaises(mc.ClustermcmlError) as caught:
                mc.run(scene, output_dir=self.folder)
            process.kill()
        os.kill(program, signal.SIGKILL)
        self.assertRegex(str(caught.exception), "scene.mci: locked by another call")
        while True:  # until the kernel has released the lock of the killed program
            try:
                self.assertEqual(float(mc.run(scene, output_dir=self.folder).layer_mua[0]), 1)
                break
            except mc.ClustermcmlError as error:
                self.assertRegex(str(error), "scene.lock: locked by another process")

    def test_killed_before_its_scene_was_written(self):
        with open(os.path.join(self.folder, "scene.mci"), "w", encoding="utf-8"):
            pass
        self.assertEqual(mc.run(mc.Scene([SLAB], photons=200), output_dir=self.folder).photons, 200)

    def test_a_result_that_was_replaced(self):
        """A result is refused if another run replaced it between the end of the program and the reading."""
        for kind in "AB":
            paths = [os.path.join(self.folder, name + ".mci") for name in "ab"]
            for path, layer in zip(paths, (SLAB, mc.Layer(1.4, 2, 100, 0.9, 0.1))):
                with open(path, "w", encoding="utf-8") as file:
                    file.write(mc.Scene([layer], photons=200, format=kind).text("same.mco"))
            told = [_fly_program(path, self.folder, [], "", Progress(False), "none", NONE)[0] for path in paths]
            self.assertEqual(result_of(told[1])["layer_mua"].values[0], 2)
            with self.assertRaisesRegex(mc.ClustermcmlError, "same.*: replaced by another call"):
                result_of(told[0])

    def test_files_that_are_gone_are_not_named(self):
        closed = mc.Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        with self.assertRaisesRegex(mc.InputError, "^Scene: boundary 0: its surface: the mesh is a closed body"):
            mc.run(mc.Scene([mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=2, top=closed)]))
        with self.assertRaisesRegex(mc.InputError, "^--set: layer2.mua = 1 .expected a name that the Scene knows: photons, "):
            mc.run(mc.Scene([SLAB]), set={"layer2.mua": 1})
        with self.assertRaisesRegex(mc.InputError, "^parameters: column 1, layer1.mua = -1.0 .expected"):
            mc.sweep(mc.Scene([SLAB]), {"layer1.mua": [1, -1]})

    def test_what_cannot_be_written_or_run(self):
        os.mkdir(os.path.join(self.folder, "scene.mci"))
        with self.assertRaisesRegex(mc.ClustermcmlError, "scene.mci: cannot be written"):
            mc.run(mc.Scene([SLAB], photons=100), output_dir=self.folder)
        program = os.environ["CLUSTERMCML"]
        try:
            os.environ["CLUSTERMCML"] = SKIN
            with self.assertRaisesRegex(mc.InputError, "skin7.mci: cannot be run"):
                mc.run(mc.Scene([SLAB], photons=100))
        finally:
            os.environ["CLUSTERMCML"] = program

    def test_notes_are_warnings(self):
        with open(os.path.join(self.folder, "a.mci"), "w", encoding="utf-8") as file:
            file.write(mc.Scene([SLAB], photons=100).text("a.h5") + "b.mco A\n")  # a second run, more than the file announces
        with self.assertWarnsRegex(UserWarning, "a.mci"):
            mc.run(os.path.join(self.folder, "a.mci"), output_dir=self.folder)

    def test_commands_say_what_the_program_says(self):
        two = os.path.join(self.folder, "two.mci")
        mc.Scene([SLAB, mc.Layer(1.5, 0.2, 10, 0, 0.1)]).write(two)
        said = {name: json.loads(command(name, path, "--json")) for name, path in (("check", SKIN), ("exact", two))}
        mine = mc.check(SKIN)
        for check in (mine[0], said["check"]):
            check.pop("memory_bytes")  # memory and time differ between processes
            for boundary in check["boundaries"]:
                boundary.pop("build_s")
        self.assertEqual(mine, [said["check"]])
        self.assertEqual(mc.exact(two), [said["exact"]])
        thick = mc.exact(mc.Scene([SLAB]), set={"layer1.mua": 0})[0]
        self.assertLess(abs(thick["A"]), 1e-7)
        self.assertNotIn("scene", thick)
        plan = mc.plan(mc.Scene([SLAB], photons=100), target_error=0.5, photons=100)[0]
        self.assertEqual((plan["error"], plan["plans"][0]["engine"]), (0.5, "cpu"))
        self.assertEqual("clustermcml " + mc.__version__, command("--version").splitlines()[0])

    def test_commands_of_results(self):
        paths = []
        for seed in (1, 2):
            folder = os.path.join(self.folder, str(seed))
            os.mkdir(folder)
            mc.run(mc.Scene([SLAB], photons=1000), seed=seed, output_dir=folder)
            paths.append(os.path.join(folder, "scene.h5"))
        self.assertEqual(mc.compare(*paths), json.loads(command("compare", *paths, "--json")))
        mc.run(mc.Scene([mc.Layer(1.4, 9, 100, 0.9, 0.1)], photons=1000), output_dir=os.path.join(self.folder, "1"))
        self.assertFalse(mc.compare(*paths)["agree"])  # a difference is no failure
        with self.assertRaisesRegex(mc.InputError, "scene.h5"):
            mc.merge(paths)  # the results are of two scenes
        mine = mc.run(mc.Scene([SLAB], photons=1000), output_dir=os.path.join(self.folder, "1"))
        joined = mc.merge([mine, paths[1]])
        self.assertAlmostEqual(float(joined.Rd), np.mean([mc.read(path).Rd for path in paths]), 12)
        for results, text in (("a.mco", "results = 'a.mco'"), (5, "results = 5"), (["none.mco", "none.mco"], r"results\[0\] = 'none.mco'")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.merge(results)

    def test_commands_refuse_and_warn_as_run(self):
        with self.assertRaisesRegex(mc.InputError, "^Scene: boundary 0: its surface"):
            mc.check(mc.Scene([mc.Layer(1.4, 1, 10, 0, 0.1, top=mc.Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 0, 1]]))]))
        with open(os.path.join(self.folder, "a.mci"), "w", encoding="utf-8") as file:
            file.write(mc.Scene([SLAB], photons=100).text("a.h5") + "b.mco A\n")  # a second run, more than the file announces
        with self.assertWarnsRegex(UserWarning, "a.mci"):
            mc.check(os.path.join(self.folder, "a.mci"))

    def test_rows_of_files(self):
        """Rows of an .asc run downwards: the first row of the file is the last row of a Heightmap's array."""
        path = os.path.join(self.folder, "scan.asc")
        with open(path, "w", encoding="utf-8") as file:
            file.write("ncols 4\nnrows 3\ncellsize 0.1\n" + "2.5 2.5 0 0\n" * 2 + "0 0 0 5\n")
        surfaces = mc.Mesh(path, units="mm"), mc.Heightmap(0.1 * np.loadtxt(path, skiprows=3)[::-1], dx=0.01)
        scenes = [mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.6, top=surface)], photons=300, beam=mc.Beam("disk", radius=0.01)) for surface in surfaces]
        one, other = (mc.run(scene).Rd_ra for scene in scenes)
        xr.testing.assert_allclose(one, other)
        self.assertGreater(float(one.sum()), 0)

    def test_sweep(self):
        """Every combination of a sweep equals the run with these values."""
        scene = mc.Scene([SLAB, mc.Layer(1.5, 0.2, 10, 0, 0.1)], photons=500, nr=4, nz=3, na=2)
        swept = mc.sweep(scene, {"layer2.mua": [0.5, 0.1], "layer1.d": [0.1, 0.2, 0.3]})
        self.assertEqual(swept.Rd_ra.dims, ("layer2.mua", "layer1.d", "r", "alpha"))
        for mua in (0.5, 0.1):
            for d in (0.1, 0.2, 0.3):
                alone = mc.run(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, d), mc.Layer(1.5, mua, 10, 0, 0.1)], photons=500, nr=4, nz=3, na=2))
                one = swept.sel({"layer2.mua": mua, "layer1.d": d}).drop_vars(["layer2.mua", "layer1.d"])
                xr.testing.assert_equal(one, alone)
        self.assertNotIn("seconds", swept.attrs)
        self.assertEqual(swept.attrs["photons"], 500)

    def test_sweep_leaves_out_what_not_all_rows_have(self):
        hill = mc.Layer(1.4, 1, 100, 0.9, 0.1, mc.Heightfield([0, 0.1], [0.02, 0]))
        scene = mc.Scene([hill], photons=100, facets=True, map=mc.Map(2, 2, 0.1, 0.1))
        for heights in ([1, 0], [0, 1]):  # a hill of height 0 is a plane
            with self.assertWarnsRegex(UserWarning, "boundary0_Rd .*: left out"):
                swept = mc.sweep(scene, {"boundary0.height": heights})
            self.assertEqual((swept.boundary1_exitance_below.dims[0], "boundary0_Rd" in swept), ("boundary0.height", False))

    def test_sweep_keeps_what_is_asked_for(self):
        scene = mc.Scene([SLAB], photons=100)
        swept = mc.sweep(scene, {"seed": [1, 2, 3]}, variables=["Rd", "Rd_se"], output_dir=self.folder)
        self.assertEqual(sorted(swept.data_vars), ["Rd", "Rd_se"])
        self.assertEqual(swept.Rd.shape, (3,))
        self.assertTrue(os.path.exists(os.path.join(self.folder, "scene-0003.h5")))
        for parameters, text in (({"layer1.mua": [1, 1]}, r"parameters\['layer1.mua'\] = \[1, 1\] \(expected values that differ"),
                                 ({"layer1.mua": 1}, "a list of at least one number"), ({}, "a dict of names"),
                                 ({"layer1.mua": [1, [2, 3]]}, "a list of at least one number"), ({"layer9.mua": [1]}, "layer9.mua"), ({"layer1.g": [2.0]}, "layer1.g")):
            with self.assertRaisesRegex(mc.InputError, text):
                mc.sweep(scene, parameters)
        with self.assertRaisesRegex(mc.InputError, "variables = 'Rd' .expected a list"):
            mc.sweep(scene, {"seed": [1]}, variables="Rd")
        with self.assertRaisesRegex(mc.InputError, "sweep = 'a.csv' .expected no such"):
            mc.sweep(scene, {"seed": [1]}, sweep="a.csv")
        with self.assertRaisesRegex(mc.InputError, "variables = 'Rx' .expected one of"):
            mc.sweep(scene, {"seed": [1]}, variables=["Rx"])

    def shown_of(self, call):
        """Returns the text on standard error when `call` runs with progress=True."""
        shown, real = io.StringIO(), sys.stderr
        sys.stderr = shown
        try:
            call()
        finally:
            sys.stderr = real
        return shown.getvalue()

    def test_progress(self):
        """Progress shows the program's own bar, and the rows of a sweep."""
        thick = os.path.join(TOP, "samples", "thick.mci")
        self.assertRegex(self.shown_of(lambda: mc.run(thick, photons=2e5, threads=1, progress=True)), r"\r\d+ %, .* left")
        rows = self.shown_of(lambda: mc.sweep(mc.Scene([SLAB], photons=100), {"seed": [1, 2]}, progress=True))
        self.assertIn("50 %, 1 of 2 rows", rows)
        self.assertIn("100 %, 2 of 2 rows", rows)
        self.assertEqual(self.shown_of(lambda: mc.run(thick, photons=1e5, progress=False)), "")

    def test_what_the_program_says_is_taken_apart(self):
        said = []
        with Progress(False) as progress:
            _listen(["[##..]  50 %  1e+06 photons/s  1 s, 1 s left\033[K", "\033[K", "clustermcml: note: hello"], progress, said, self.fail)
        self.assertEqual(said, ["clustermcml: note: hello"])


if __name__ == "__main__":
    unittest.main()
