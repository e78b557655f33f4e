"""Tests of faces, ports and probes in Python: their lines, layouts, refusals, what `check` understands, results and pictures."""
import math
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc  # noqa: E402

SKIN = mc.Layer(n=1.4, mua=1, mus=20, g=0.5, d=0.5)
FIBRE = mc.Fibre(core=0.1, na=0.3, cladding=0.11)
STEEL = mc.Face(0.5, "disk", radius=0.6)


def cores(probe):
    return [port for port in probe.top if isinstance(port, mc.Port) and port.name]


class Probes(unittest.TestCase):
    def test_lines(self):
        """Every shape and law is written as its line, before layer 1 and in order."""
        top = [mc.Face(0.9, law="lambertian"), mc.Face(shape="ring", r1=0.2, r2=0.3, law="metal", n=2.5, k=3.4, at=(0.1, 0)),
               mc.Port("rectangle", width=0.2, height=0.1, n=1.5), mc.Port("ring", r1=0, r2=0.05, n=1.46, at=(0, -0.1), name="core")]
        scene = mc.Scene([SKIN], n_above=1.1, top=top, beam=mc.Beam("port", port="core", light="na:0.2", angle=5),
                         detectors=[mc.Detector("port", port="core", na=0.2, diffuse=True, name="back"), mc.Detector("port", port="1")])
        text = scene.text("a.mco")
        self.assertIn("\n1.1\nface 0.9 lambertian\nface ring 0.2 0.3 metal 2.5 3.4 at=0.1,0\nport rectangle 0.2 0.1 n=1.5\n"
                      "port ring 0 0.05 n=1.46 at=0,-0.1 name=core\n1.4 1 20 0.5 0.5\n", text)
        self.assertIn("\nbeam port core angle=5 light=na:0.2\ndetector port core na=0.2 diffuse name=back\ndetector port 1\n", text)

    def test_layouts(self):
        """Fibres stand where the layout says; claddings have the index of the aperture, epoxy holds all fibres."""
        probe = mc.Probe.six_around_one(FIBRE, fill=1.5, face=STEEL)
        self.assertEqual([port.name for port in cores(probe)], [f"f{i}" for i in range(7)])
        places = [port.at for port in cores(probe)]
        self.assertEqual(places[0], (0, 0))
        for a, b in zip(places[1:], places[2:] + places[1:2]):
            self.assertAlmostEqual(math.dist(a, b), 0.22, 6)
            self.assertAlmostEqual(math.hypot(*a), 0.22, 6)
        self.assertIs(probe.top[0], STEEL)
        self.assertAlmostEqual(probe.top[1].radius, 0.33, 6)
        self.assertAlmostEqual(probe.top[2].n ** 2, 1.46 ** 2 - 0.3 ** 2)
        self.assertEqual([beam.port for beam in probe.beam], ["f0"])
        self.assertEqual([detector.port for detector in probe.detectors], ["f1", "f2", "f3", "f4", "f5", "f6"])
        self.assertEqual(len(mc.Probe.ring(FIBRE, 0.5, 4, centre=False).beam), 1)
        row = mc.Probe.linear(mc.Fibre(0.1, na=0.3), [0, 0.3, 0.7], fill=1.5, lit=[0, 2], read=(0, 1))
        self.assertEqual([port.at for port in row.top[1:]], [(0, 0), (0.3, 0), (0.7, 0)])
        self.assertEqual((row.top[0].at, row.top[0].height), ((0.35, 0), 0.2))
        self.assertAlmostEqual(row.top[0].width, 0.9)
        self.assertEqual(([beam.port for beam in row.beam], [detector.port for detector in row.detectors]), (["f0", "f2"], ["f0", "f1"]))

    def test_refusals(self):
        cases = [(lambda: mc.Face(), r"Face\.R = None"), (lambda: mc.Face(1.1), r"Face\.R = 1\.1 \(expected a number from 0 to 1"),
                 (lambda: mc.Face(0.5, "disk"), r"Face\.radius = None"), (lambda: mc.Face(0.5, "disk", radius=1, r1=0), r"Face\.r1 = 0 \(expected None for a disk"),
                 (lambda: mc.Face(0.5, at=(1, 0)), r"Face\.at = \(1, 0\) \(expected \(0, 0\) for the whole"), (lambda: mc.Face(0.5, law="metal", n=1, k=1), r"Face\.R = 0\.5 \(expected None for metal"),
                 (lambda: mc.Port(radius=1, n=0), r"Port\.n = 0 \(expected"), (lambda: mc.Port(radius=1, name="a b"), r"Port\.name = 'a b' \(expected 1 to 24 letters"),
                 (lambda: mc.Port(None, n=1.4), r"Port\.shape = None"), (lambda: mc.Beam("port"), r"Beam\.port = None"), (lambda: mc.Beam("disk", 1, port="a"), r"Beam\.port = 'a' \(expected None"),
                 (lambda: mc.Beam("port", port="a", z=0.1), r"Beam\.z = 0\.1"), (lambda: mc.Beam("port", port="a", at=(1, 0)), r"Beam\.at = \(1, 0\)"),
                 (lambda: mc.Detector("port"), r"Detector\.port = None"), (lambda: mc.Detector("port", port="a", side="bottom"), r"Detector\.at, z, side ="),
                 (lambda: mc.Scene([SKIN], top=[SKIN]), r"Scene\.top = \[Layer"), (lambda: mc.Scene([SKIN], top=STEEL), r"Scene\.top = Face"),
                 (lambda: mc.Fibre(0.1, na=1.5), r"Fibre\.na = 1\.5 \(expected below n, 1\.46"), (lambda: mc.Fibre(0.1, na=0.2, cladding=0.09), r"Fibre\.cladding = 0\.09 \(expected a number >= core"),
                 (lambda: mc.Probe.linear(FIBRE, [0, 0.2]), r"fibre = Fibre.* \(expected an outer radius up to 0\.1, half"), (lambda: mc.Probe.linear(FIBRE, [0, 1], lit=[2]), r"lit = 2 \(expected"),
                 (lambda: mc.Probe.ring(0.1, 1), r"fibre = 0\.1 \(expected a Fibre"), (lambda: mc.Probe.six_around_one(FIBRE, face=0.5), r"face = 0\.5 \(expected a Face or None")]
        for make, text in cases:
            with self.assertRaisesRegex(mc.InputError, text) as caught:
                make()
            self.assertNotIn("\n", str(caught.exception))

    def test_a_probe_flies(self):
        """`check` understands every line as it was meant; the result has what the face keeps and what each fibre collects."""
        probe = mc.Probe.six_around_one(FIBRE, fill=1.5, face=STEEL)
        scene = mc.Scene([SKIN], photons=20000, top=probe.top, beam=probe.beam, detectors=probe.detectors, directions=mc.Directions(nt=3, np=4))
        told = mc.check(scene)[0]["top"]
        self.assertEqual(len(told), len(probe.top))
        for line, meant in zip(told, probe.top):
            self.assertEqual((line["kind"], line["shape"], line["x"], line["y"]), (type(meant).__name__.lower(), meant.shape, *meant.at))
            self.assertEqual(max(line["size"]), meant.radius)
            self.assertEqual((line["r"], line["law"]) if line["kind"] == "face" else line["n"], (0.5, "mirror") if line["kind"] == "face" else meant.n)
        self.assertEqual([line["name"] for line in told if line["kind"] == "port" and str(line["name"]).startswith("f")], [f"f{i}" for i in range(7)])
        result = mc.run(scene)
        self.assertAlmostEqual(float(result.Rsp + result.Rd + result.A + result.A_face + result.Tt), 1, 3)
        self.assertGreater(result.A_face, 0.01)
        self.assertGreater(result.A_face_se, 0)
        self.assertIn("face 1: disk of radius 0.6 cm at (0 0) cm, mirror, R = 0.5", result.attrs["top"])
        for i in range(1, 7):
            self.assertGreater(result[f"detector_f{i}"], 0)
        again = mc.run(scene, photons=2000, set={"face.r": 0.0})
        self.assertGreater(again.A_face, result.A_face)

    def test_picture(self):
        """The plan names the fibres, the faces and the indices."""
        probe = mc.Probe.linear(FIBRE, [0, 0.3], face=mc.Face(0.6, "rectangle", width=1, height=0.5, law="lambertian"))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "probe.svg")
            mc.view(mc.Scene([SKIN], top=probe.top, beam=probe.beam, detectors=probe.detectors), path)
            with open(path, encoding="utf-8") as file:
                picture = file.read()
        for text in (">f0<", ">f1<", "from above, n = 1 beyond", "face: R = 0.6 lambertian; ports: n = 1.429, 1.46", "R = 0.1 cm, na:0.3"):
            self.assertIn(text, picture)


if __name__ == "__main__":
    unittest.main()
