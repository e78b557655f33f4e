"""Tests of bodies in an .h5 file: shares and media stand along `body`, facets of all bodies along `body_facet`.

Sums over facets are `flux_body`, areas are known, and all light that arrives at a body leaves it or is absorbed. JSON and tables of sweeps have
equal numbers."""
import csv
import itertools
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import arrays_of, h5py, numpy, read_vtk  # noqa: E402

SCENE = """1.0
1
bodies.mco A
20000
0.01 0.01
20 20 2
facets
1
1
1.4 0.5 50 0.8 0.3
i sphere 0 0 0.1 0.05 1.4 5 20 0.5
i cylinder -0.2 0.1 0.15 0.2 0.1 0.15 0.03 1.33 0 0 0
i "cube.obj" 1.5 2 10 0.9 shift=0.1,-0.15,-0.1
1
"""
CORNERS = [(x, y, z) for x in (-0.02, 0.02) for y in (-0.03, 0.03) for z in (-0.01, 0.01)]
FACES = [(1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2), (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4)]


def check_drawing(verdict, path, file):
    """Checks a drawing: every face has the values of its facet. The cube's facets are its triangles; other drawings have about the area of their
    body."""
    drawing = read_vtk(path)
    arrays, points = arrays_of(drawing), drawing.GetBounds()
    body = arrays["body"]
    verdict.check("box", numpy.allclose(points[4:], (0.05, 0.18), atol=2e-3) and math.isclose(points[0], -0.2, abs_tol=1e-9), str(points))
    sizes = numpy.array([drawing.GetCell(i).ComputeArea() for i in range(drawing.GetNumberOfCells())])
    whose, areas = file["body_of_facet"][:], file["body_area"][:]
    for k in (1, 2, 3):
        verdict.check("area drawn", math.isclose(sizes[body == k].sum(), areas[whose == k].sum(), rel_tol=0.01), f"body {k}")
    for name in ("irradiance_outside", "irradiance_inside", "exitance_outside", "exitance_inside"):
        drawn, known = arrays[name], file["body_" + name][:]
        for k in (1, 2, 3):
            light = (drawn * sizes)[body == k].sum(), (known * areas)[whose == k].sum()
            verdict.check(name, math.isclose(*light, rel_tol=0.01), f"body {k}: drawn {light[0]}, in the .h5 {light[1]}")
        verdict.check(name, numpy.allclose(drawn[body == 3], known[whose == 3], rtol=1e-6), "of the cube's triangles")
        ends = [numpy.unique(drawn[(body == 2) & (numpy.isclose(centre_x(drawing), x, atol=1e-6))]) for x in (-0.2, 0.2)]
        verdict.check(name, all(len(end) == 1 for end in ends) and numpy.allclose(numpy.concatenate(ends), known[2:4], rtol=1e-6),
                      f"of the cylinder's ends: {ends}, {known[2:4]}")


def centre_x(drawing):
    cells = [drawing.GetCell(i).GetBounds() for i in range(drawing.GetNumberOfCells())]
    return numpy.array([0.5 * (low + high) for low, high, *_ in cells])


def check(verdict, file):
    verdict.check("A", math.isclose(file["A_l"][:].sum() + file["A_body"][:].sum(), file["A"][()], rel_tol=1e-12), "by media")
    verdict.check("body_n", file["body_n"][:].tolist() == [1.4, 1.33, 1.5])
    verdict.check("body_mua", file["body_mua"][:].tolist() == [5, 0, 2])
    whose, areas = file["body_of_facet"][:], file["body_area"][:]
    verdict.check("body_of_facet", whose.tolist() == [1] + 3 * [2] + 12 * [3])
    sphere, disk, cube = 4 * math.pi * 0.05**2, math.pi * 0.03**2, 2 * (0.04 * 0.06 + 0.04 * 0.02 + 0.06 * 0.02)
    verdict.check("areas", numpy.allclose(areas[:4], [sphere, 2 * math.pi * 0.03 * 0.4, disk, disk], rtol=1e-12))
    verdict.check("areas", math.isclose(areas[4:].sum(), cube, rel_tol=1e-9), "of the cube")
    flux = file["flux_body"][:]
    names = ("irradiance_outside", "irradiance_inside", "exitance_outside", "exitance_inside")
    sums = numpy.array([[(file["body_" + name][:] * areas)[whose == k].sum() for name in names] for k in (1, 2, 3)])
    verdict.check("flux_body", numpy.allclose(sums, flux, rtol=1e-6) and flux.min() > 0, f"{sums}, in flux_body {flux}")
    verdict.check("what arrives leaves", numpy.allclose(sums[:, :2].sum(axis=1), sums[:, 2:].sum(axis=1), rtol=1e-6), str(sums))


def check_tables(verdict, folder):
    """Checks the table and the JSON of a sweep with one row that changes nothing."""
    with open(os.path.join(folder, "one.csv"), "w", encoding="utf-8") as file:
        file.write("body1.mua\n5\n")
    said = subprocess.run([cml.PROGRAM, os.path.join(folder, "bodies.mci"), "--json", "-o", folder, "--sweep", os.path.join(folder, "one.csv")],
                          check=True, stdout=subprocess.PIPE)
    record = json.loads(said.stdout)
    with open(os.path.join(folder, "bodies.sweep.csv"), encoding="utf-8") as file:
        row = next(csv.DictReader(file))
    sides = ("arrives_outside", "arrives_inside", "leaves_outside", "leaves_inside")
    with h5py.File(os.path.join(folder, "bodies.h5")) as file, h5py.File(os.path.join(folder, "bodies.sweep.h5")) as swept:
        for end in ("", "_se"):
            found = file["flux_body" + end][:]
            verdict.check("sweep's .h5", numpy.array_equal(swept["flux_body" + end][0], found) and numpy.array_equal(swept["side"], file["side"]))
            verdict.check("sweep's .csv", [[float(row[f"body{k}.{side}{end}"]) for side in sides] for k in (1, 2, 3)] == found.tolist(), f"{row}")
            verdict.check("JSON", record["flux_body" + end] == found.ravel().tolist(), f"{record}")


def check_many_axes(verdict, folder):
    """Two values in each of six columns are six axes; seven would leave no axes for body and side of flux_body, and are rows."""
    names = "above.n below.n layer1.n layer1.mua layer1.mus layer1.g body1.mua".split()
    for count in (6, 7):
        rows = itertools.product(*(("1", "1.2") if name.endswith(".n") else ("0.5", "0.8") for name in names[:count]))
        with open(os.path.join(folder, "many.csv"), "w", encoding="utf-8") as file:
            file.write(",".join(names[:count]) + "\n" + "".join(",".join(row) + "\n" for row in rows))
        done = subprocess.run([cml.PROGRAM, os.path.join(folder, "bodies.mci"), "--quiet", "--photons", "64", "-o", folder, "--sweep", os.path.join(folder, "many.csv")],
                              check=False, capture_output=True, text=True)
        verdict.check(f"{count} columns", done.returncode == 0, done.stderr)
        with h5py.File(os.path.join(folder, "bodies.sweep.h5")) as file:
            shape = (2,) * 6 if count == 6 else (128,)
            verdict.check(f"{count} columns", file["flux_body"].shape == shape + (3, 4), str(file["flux_body"].shape))


def main():
    verdict = cml.Verdict("bodies")
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "bodies.mci"), "w", encoding="utf-8") as file:
            file.write(SCENE)
        with open(os.path.join(folder, "cube.obj"), "w", encoding="utf-8") as file:
            file.writelines("v %g %g %g\n" % corner for corner in CORNERS)
            file.writelines("f %d %d %d\n" % face for face in FACES)
        subprocess.run([cml.PROGRAM, os.path.join(folder, "bodies.mci"), "--quiet", "-o", folder], check=True)
        with h5py.File(os.path.join(folder, "bodies.h5")) as file:
            check(verdict, file)
            check_drawing(verdict, os.path.join(folder, "bodies.bodies.vtp"), file)
        check_tables(verdict, folder)
        check_many_axes(verdict, folder)
    verdict.finish()


main()
