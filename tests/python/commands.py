"""Tests of the program's commands in Python: they have the program's options, give its answers, and never name deleted files."""
import inspect
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc, np, xr  # noqa: E402
from clustermcml import options  # noqa: E402
from clustermcml.options import NO_ARGUMENTS  # noqa: E402
from clustermcml.program import find_program  # noqa: E402
from clustermcml.surfaces import write_gsf  # noqa: E402

SLAB = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1)
RIDGES = os.path.join(TOP, "samples", "ridges.mci")
HILL = os.path.join(TOP, "samples", "shapes", "hihill.mci")


def command(*words):
    """Returns the standard output of the program. Exit code 1, which says that results differ, is allowed."""
    ended = subprocess.run([find_program(), *words], stdout=subprocess.PIPE, text=True)
    assert ended.returncode in (0, 1), words
    return ended.stdout


class Reliefs(unittest.TestCase):
    def test_are_drawn_by_the_program(self):
        relief = mc.Relief(0.2, 0.01, seed=9, points=32, spectrum="fractal:0.8", shift=(0, 0, 0.001))
        told = mc.check(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, relief)]))[0]["boundaries"][0]
        self.assertIn("repeated every 0.032 x 0.032 cm", told["reason"])
        self.assertAlmostEqual(told["mean_height"], 0.001, places=12)

    def test_of_wrong_numbers_are_refused(self):
        for call, text in ((lambda: mc.Relief(0, 1), r"Relief\.slope = 0 \(expected a number"), (lambda: mc.Relief(0.1, -1), r"Relief\.length = -1"),
                           (lambda: mc.Relief(0.1, 1, points=48), r"Relief\.points = 48 \(expected a power"),
                           (lambda: mc.Relief(0.1, 1, spectrum="white"), r"Relief\.spectrum = 'white'")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()


class Roughness(unittest.TestCase):
    def test_is_that_of_the_lines(self):
        rough = mc.Rough("ggx", 0.3)
        sphere = mc.Sphere(0, 0, 0.05, 0.01, n=1.5, mua=0, mus=10, g=0, rough=mc.Rough("beckmann", 0.5))
        scene = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, bodies=[sphere], top_rough=rough)], bottom_rough=rough, photons=200)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "rough.mci")
            scene.write(path)
            told = command("check", path)
        self.assertIn("boundary 0: plane at z = 0 cm, rough ggx 0.3 (", told)
        self.assertIn("boundary 1: plane at z = 0.1 cm, rough ggx 0.3 (", told)
        self.assertIn("r = 0.01 cm, rough beckmann 0.5, in layer 1", told)
        swept = mc.sweep(scene, {"boundary0.alpha": [0, 0.5], "body1.alpha": [0.5, 0]}, photons=100)
        self.assertEqual((swept.sizes["boundary0.alpha"], swept.sizes["body1.alpha"]), (2, 2))

    def test_of_wrong_numbers_is_refused(self):
        for call, text in ((lambda: mc.Rough("phong", 1), r"Rough\.kind = 'phong'"), (lambda: mc.Rough("ggx", 1e-5), r"Rough\.alpha = 1e-05"),
                           (lambda: mc.Layer(1.4, 1, 100, 0.9, 0.1, top_rough=0.2), r"Layer\.top_rough = 0\.2")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()


class Options(unittest.TestCase):
    def test_are_those_of_the_program(self):
        """The package has all options of the program and no others. They stand in the signature, where editors look for completion."""
        for name in ("run", "check", "plan", "exact", "trace", "mesh", "crosscheck", "furnace"):
            kind = set(vars(options)[name.capitalize() + "Options"].__annotations__)
            theirs = {word.replace("-", "_") for word in re.findall(r"^  (?:-\w, )?--([\w-]+)", command("help", name), re.MULTILINE)}
            self.assertEqual(kind, theirs - (set(NO_ARGUMENTS) - kind) - {"output_dir", "reweight"}, name)  # both belong to sweep
            self.assertLessEqual(kind, set(inspect.signature(getattr(mc, name)).parameters), name)
        self.assertEqual(inspect.signature(mc.sweep).parameters["target_error"].annotation, "float")

    def test_check_knows_how_many_flights_a_sweep_takes(self):
        grid = {"layer1.mua": [1, 2, 3], "layer1.mus": [50, 60]}
        self.assertEqual([mc.check(HILL, sweep=grid, reweight=flag)[0]["sweep"] for flag in (False, True)],
                         [{"rows": 6, "flights": 6}, {"rows": 6, "flights": 2}])
        for call, text in ((lambda: mc.check(HILL, sweep={"layer1.mua": [1, -2]}), r"parameters: column 1, layer1.mua = -2.0 .expected a coefficient"),
                           (lambda: mc.check(HILL, sweep="none.csv"), "sweep = 'none.csv'"), (lambda: mc.check(HILL, reweight=True), "parameters = None")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()

    def test_exact_says_which_shapes_it_ignores(self):
        with self.assertWarnsRegex(UserWarning, "^exact: a plane stands for boundary 0, 1$"):
            self.assertEqual(mc.exact(HILL)[0]["planes"], [0, 1])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(mc.exact(mc.Scene([SLAB]))[0]["planes"], [])

    def test_of_one_command_are_refused_by_others(self):
        for call, text in ((lambda: mc.exact(HILL, photons=5), "--photons"), (lambda: mc.run(HILL, output="a.svg"), "output = 'a.svg'"), (lambda: mc.trace(HILL, 0, json=True), "json = True")):
            with self.assertRaisesRegex(mc.InputError, text):
                call()

    def test_values_of_another_kind_are_refused(self):
        for call, text in ((lambda: mc.run(HILL, error_of=True), "error_of = True (expected a value)"), (lambda: mc.run(HILL, checkpoint=False), "checkpoint = False (expected a value)"), (lambda: mc.sweep(HILL, {"layer1.mua": [1]}, photons=np.False_), "photons = False (expected a value)"),
                           (lambda: mc.run(HILL, photons={}), "photons = {} (expected a value)"), (lambda: mc.plan(HILL, aim={"a": 1}), "aim = {'a': 1} (expected a value)"),
                           (lambda: mc.run(HILL, keep=1), "keep = 1 (expected True or False)"),
                           (lambda: mc.plan(HILL, aim="a\0"), r"aim = 'a\x00' (expected text without NUL characters)"),
                           (lambda: mc.run(HILL, set={"\0": 1}), r"set = {'\x00': 1} (expected text without NUL characters)"),
                           (lambda: mc.Scene([SLAB]).write("\0"), r"path = '\x00' (expected a name without NUL characters)")):
            with self.assertRaises(mc.InputError) as caught:
                call()
            self.assertEqual(str(caught.exception), text)


class Commands(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_expected(self):
        """Expected values of --aim stand in .mco and .h5 beside the counted ones. A layer above the level has its counted value."""
        layers = [mc.Layer(1.4, 1, 60, 0.8, 0.1, top=mc.Heightfield([0, 0.1], [0.02, 0])), mc.Layer(1.5, 2, 20, 0.5, 0.1)]
        mc.Scene(layers, photons=2000, format="A").write(path := os.path.join(self.folder, "deep.mci"))
        command(path, "--quiet", "--aim", "Tt", "--output", "deep.h5", "-o", self.folder)
        mco, h5 = mc.run(path, aim=["Tt", "A_l:2"]), mc.read(path.replace("mci", "h5"))
        for name in ("Tt_expected", "A_l_expected"):
            self.assertEqual((mco[name].dims, mco[name].attrs, h5[name].attrs["ancillary_variables"]), (h5[name].dims, h5[name].attrs, name + "_se"))
            np.testing.assert_allclose((mco[name], mco[name + "_se"]), (h5[name], h5[name + "_se"]), rtol=1e-4)
        np.testing.assert_array_equal((h5.A_l_expected == h5.A_l, h5.A_l_expected_se == h5.A_l_se), ([True, False], [True, False]))

    def test_trace(self):
        """mc.trace returns every number of the printed table, and the fate of the photon."""
        said = command("trace", RIDGES, "17", "--seed", "3").splitlines()
        events = mc.trace(RIDGES, 17, seed=3)
        rows = [line.split()[1:] for line in said if not line.startswith("#")]
        self.assertGreater(len(rows), 3)
        for k, name in enumerate(("what", "medium", "x", "y", "z", "ux", "uy", "uz", "weight")):
            np.testing.assert_array_equal(events[name].values, np.array([row[k] for row in rows]).astype(events[name].dtype), name)
        self.assertEqual((events.end, events.photon, events.z.units), (said[-1][2:], 17, "cm"))
        self.assertEqual(mc.trace(mc.Scene([SLAB]), 0).what[0], "launch")
        seen = mc.trace(mc.Scene([SLAB], detectors=[mc.Detector("disk", radius=1e3, name="all"), mc.Detector("disk", radius=1e-9, at=(5, 0))]), 0)
        self.assertEqual((events.seen_by, seen.seen_by), ([], ["all"]))
        frosted = mc.Scene([mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top_rough=mc.Rough("ggx", 1))])
        frosted.write(path := os.path.join(self.folder, "frosted.mci"))
        for photon in range(5):
            steps = [int(line.split()[2]) for line in command("trace", path, str(photon)).splitlines() if line.startswith("# rough: ")]
            np.testing.assert_array_equal([k for k in mc.trace(frosted, photon).rough_steps.values if k], steps)
            self.assertGreater(len(steps), 0)
        self.assertFalse(events.rough_steps.any())
        with self.assertRaisesRegex(mc.InputError, r"photon = -1 \(expected"):
            mc.trace(RIDGES, -1)

    def test_mesh(self):
        os.mkdir(os.path.join(self.folder, "mine"))
        mine = mc.mesh(HILL, os.path.join(self.folder, "mine"), tolerance=0.1)
        theirs = re.findall("-> (.*)", command("mesh", HILL, "--tolerance", "0.1", "-o", self.folder))
        self.assertEqual([os.path.basename(path) for path in mine], [os.path.basename(path) for path in theirs])
        for path, other in zip(mine, theirs):
            with open(path, encoding="utf-8") as one, open(other, encoding="utf-8") as two:
                self.assertEqual(one.read(), two.read())
        self.assertEqual(len(mine), 2)
        self.assertEqual(mc.mesh(mc.Scene([SLAB]), self.folder), [])

    def test_furnace(self):
        mine = mc.furnace(HILL, photons=2000)
        self.assertEqual(mine, [json.loads(command("furnace", HILL, "--photons", "2000", "--json"))])
        self.assertIs(mine[0]["even"], True)
        self.assertIs(mc.furnace(mc.Scene([SLAB]), photons=2000, alpha=0.9999)[0]["even"], False)

    def test_crosscheck(self):
        words = ("crosscheck", HILL, "--photons", "2000")
        mine = mc.crosscheck(HILL, photons=2000)
        self.assertEqual(mine, [json.loads(command(*words, "--json"))])
        self.assertIs(mine[0]["agree"], True)
        noise = os.path.join(TOP, "samples", "shapes", "hinoise.mci")
        self.assertIs(mc.crosscheck(noise, photons=20000, tolerance=0.1, rings="inscribed")[0]["agree"], False)

    def test_pictures(self):
        path = os.path.join(self.folder, "section.svg")
        mc.view(HILL, path)
        self.assertGreater(os.path.getsize(path), 1000)
        slab = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, bodies=[mc.Sphere(0, 0, 0.05, 0.02, n=1.4, mua=1, mus=2, g=0)])], photons=10)
        mc.view(slab, path)
        with open(path, encoding="utf-8") as file:
            self.assertIn(">body 1, n = 1.4<", file.read())

    def test_messages_name_no_files_that_are_gone(self):
        """Messages do not name deleted files: the program speaks of files beside the scene, the package of results."""
        dark = mc.Layer(1.4, 1, 100, 0, 0.1, phase=mc.Phase("table", angles=[0, 180], densities=[0, 0]))
        with self.assertRaisesRegex(mc.InputError, "^Scene: layer 1: phase: table of a Phase: p = 0"):
            mc.run(mc.Scene([dark]))
        wrapper = os.path.join(self.folder, "program")
        with open(wrapper, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\n"{find_program()}" "$@"; rm -f "$3"/scene.h5\n')
        os.chmod(wrapper, 0o755)
        with unittest.mock.patch.dict(os.environ, CLUSTERMCML=wrapper), self.assertRaisesRegex(mc.InputError, "^scene = 'scene.h5' .expected"):
            mc.run(mc.Scene([SLAB], photons=10))


class Meshes(unittest.TestCase):
    VERTICES = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 0.3]]
    FACES = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]

    def test_by_position(self):
        mine, named = mc.Mesh(self.VERTICES, self.FACES, units="mm"), mc.Mesh(vertices=self.VERTICES, faces=self.FACES, units="mm")
        self.assertEqual((mine, mine.path), (named, None))
        with self.assertRaisesRegex(mc.InputError, "Mesh.path"):
            mc.Mesh(self.VERTICES)
        with self.assertRaisesRegex(mc.InputError, "Mesh.vertices = 'a.obj'"):
            mc.Mesh("a.obj", self.FACES)

    def test_files_of_others(self):
        """The program reads an STL file as it is. Its gap of 1e-5 cm is refused, and joined by weld."""
        path = os.path.join(tempfile.mkdtemp(), "pyramid.stl")
        self.addCleanup(lambda: (os.remove(path), os.rmdir(os.path.dirname(path))))
        with open(path, "w", encoding="utf-8") as file:
            file.write("solid a\n")
            for i, face in enumerate(self.FACES):
                corners = "".join("vertex %.9g %.9g %.9g\n" % (*self.VERTICES[k][:2], self.VERTICES[k][2] + (1e-5 if (i, k) == (0, face[2]) else 0)) for k in face)
                file.write("facet normal 0 0 1\nouter loop\n" + corners + "endloop\nendfacet\n")
            file.write("endsolid a\n")
        with self.assertRaisesRegex(mc.ClustermcmlError, "weld=1.5e-05 joins them"):
            mc.check(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, top=mc.Mesh(path))]))
        mesh = mc.Mesh(path, weld=2e-5)
        told = mc.check(mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, top=mesh)]))[0]["boundaries"][0]
        self.assertEqual((told["kind"], told["primitives"]), ("mesh", 4))


class Light(unittest.TestCase):
    def setUp(self):
        """Makes a folder with a table and an image whose names need quotes, and enters it."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        pathlib.Path("a led.txt").write_text("0 1\n20 0\n", encoding="utf-8")
        write_gsf("a row.gsf", np.array([[1, 2], [0, 4]]), 0.1, 0.1)

    def test_files_by_relative_names(self):
        """Relative names belong to the folder in which Python runs, wherever the scene lies."""
        scene = mc.Scene([SLAB], photons=50, beam=[mc.Beam("disk", 0.1, light="a led.txt"),
                                                   mc.Beam("image", file=pathlib.Path("a row.gsf"), light=pathlib.Path("a led.txt"), angle=60, azimuth=-30)])
        os.mkdir("sub")
        scene.write("sub/w.mci")
        for told in mc.check(scene), mc.check("sub/w.mci"):
            self.assertEqual([tuple(beam[key] for key in ("shape", "light", "angle", "azimuth")) for beam in told[0]["beams"]],
                             [("disk", "table", 0, 0), ("image", "table", 60, -30)])
        xr.testing.assert_equal(mc.run(scene), mc.run("sub/w.mci"))
        self.assertEqual(mc.sweep(scene, {"layer1.mua": [1, 2]}).Rd.shape, (2,))
        self.assertEqual((mc.trace(scene, 0).what[0], mc.exact(scene)), ("launch", mc.exact(mc.Scene([SLAB], beam=scene.beam))))

    def test_refusals(self):
        words = "parallel, lambertian, isotropic, na:N or the path of a file that is there"
        for call, text in ((lambda: mc.Beam(light="lambert"), f"Beam.light = 'lambert' (expected {words})"),
                           (lambda: mc.Beam(light=pathlib.Path("lambertian")), f"Beam.light = 'lambertian' (expected {words})"),
                           (lambda: mc.Beam("image", file="b.gsf"), "Beam.file = 'b.gsf' (expected the path of a file that is there)"),
                           (lambda: mc.Phase("table", angles=[0, 180], densities=[1, 2, 3]), "Phase.densities = [1, 2, 3] (expected 2 finite numbers, one for each angle)"),
                           (lambda: mc.Phase("table", angles=[[0], [180]], densities=[[1], [2]]), "Phase.angles = [[0], [180]] (expected a list of finite angles)"),
                           (lambda: mc.check(mc.Scene([mc.Layer(1.4, 1, 9, 0.5, 1, phase=mc.Phase("hg2", g1=0.5, g2=0, w=1.5))])), "Scene: layer 1: phase: w = 1.5 (expected a share of 0..1)")):
            with self.assertRaisesRegex(mc.InputError, re.escape(text)):
                call()
        pathlib.Path('a"b').touch()
        with self.assertRaisesRegex(mc.InputError, "Beam.light = .*expected a path without quotation marks"):
            mc.Beam(light='a"b')


class Files(unittest.TestCase):
    def test_netcdf(self):
        """Results are written as netCDF and read again by the packages that clustermcml installs. `.h5` files are netCDF."""
        with tempfile.TemporaryDirectory() as folder:
            scene = mc.Scene([SLAB], photons=500, map=mc.Map(4, 3, 0.1, 0.1), directions=mc.Directions(2, 4))
            result = mc.run(scene, output_dir=folder)
            path = os.path.join(folder, "a.nc")
            result.to_netcdf(path, engine="h5netcdf")
            with xr.open_dataset(path, engine="h5netcdf") as again:
                xr.testing.assert_identical(again.load(), result)
            swept = mc.sweep(scene, {"layer1.mua": [1, 2], "text": ["a", "b"]}, coords=["text"], photons=100)
            swept.to_netcdf(path, engine="h5netcdf")
            with xr.open_dataset(path, engine="h5netcdf") as again:
                xr.testing.assert_identical(again.load(), swept)
            with xr.open_dataset(os.path.join(folder, "scene.h5"), engine="h5netcdf") as direct:
                np.testing.assert_array_equal(direct.Rd_xy, result.Rd_xy)
                self.assertEqual((direct.Rd_xy.dims, direct.Rd_xy.units), (("y", "x"), "1/cm2"))


if __name__ == "__main__":
    unittest.main()
