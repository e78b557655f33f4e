"""The scenes of the bench: their names, their .mci files, and independent values for them.

SPDX-License-Identifier: MIT
"""
import csv
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BENCH = os.path.dirname(HERE)
ROOT = os.path.dirname(BENCH)
REFERENCE = os.path.join(ROOT, "tests", "reference")

SCENES = {
    "S1": "samples/fig5.mci",
    "S2": "samples/fig6.mci",
    "S3": "samples/fig7text.mci",
    "S4": "samples/mcml_sample.mci",
    "S5": "samples/skin7.mci",
    "S6a": "samples/thick.mci",
    "S6b": "bench/lib/scenes/S6b.mci",
    "A": "bench/lib/scenes/A.mci",
}
AMPLITUDE = "0.018"  # largest height of rough tops and rings [cm]
AMPLITUDE_A = "0.03"
SEARCHED = "3e5"  # triangles of the rough top that is also searched with Embree
IRREGULAR = {"moved": ("1e4", "1e5", "1e6"), "kept": ("1e4", "1e5", "1e6"), "spiked": ("1e5",)}  # kinds of rough.py
OVERHANGING = ("cave", "mushrooms")  # kinds of rough.py
QUICK = "1e5"  # triangles of the irregular tops of --quick, and of those of scene A
RINGS = (1, 10, 50, 200, 1000)
TWO_THREADS = ("S6a", "S6a-rough-1e5", "S6a-moved-1e5", "S6a-kept-1e5", "S6a-rings-50-cone")
ABOVE = 7  # line of the index above, among lines that are neither comment nor blank; the first layer follows


class Case:
    """One row of the result: a scene file, options for the program, and the measured runs."""

    def __init__(self, name, medium, surface, path, options=(), threads=1, mesh=None, grid=None):
        self.name, self.medium, self.surface, self.path = name, medium, surface, path
        self.options, self.threads = list(options), threads
        self.mesh = mesh  # path of a rough top
        self.grid = grid  # name of the case with a regular grid, with which an irregular top is compared
        self.photons = self.mcml_photons = self.mcml_start = self.mcml_disturbed = 0
        self.runs, self.mcml_runs = [], []

    def two(self):
        """Returns this case on two threads."""
        return Case(self.name, self.medium, self.surface, self.path, self.options, 2, self.mesh, self.grid)


def lines_of(path):
    """Returns the lines of a scene of ROOT without comments, which every program reads in the same way."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as stream:
        lines = [line.split("#")[0].strip() for line in stream]
    return [line for line in lines if line]


def shape_path(shape):
    return os.path.join(ROOT, "samples", "shapes", shape + ".mci")


def data_lines(medium):
    return lines_of(SCENES[medium])


def write_scene(medium, path, photons=None, surface=None):
    """Writes a copy of a flat scene, with a surface line for its top and another number of photons."""
    lines = data_lines(medium)
    if photons:
        lines[3] = str(photons)
    if surface:
        lines.insert(ABOVE + 1, surface)
    with open(path, "w") as stream:
        stream.write("\n".join(lines) + "\n")


def make_surface(kind, number, amplitude, path):
    subprocess.run([sys.executable, os.path.join(HERE, "rough.py"), kind, str(number), amplitude, path], check=True)


def top_case(medium, kind, number, amplitude, work):
    """Returns the case of a medium below a rough mesh of rough.py. The regular grid is called rough."""
    top = "rough" if kind == "mesh" else kind
    mesh = os.path.join(work, "%s-%s-%s.obj" % (top, number, amplitude))
    if not os.path.exists(mesh):
        make_surface(kind, number, amplitude, mesh)
    name = "%s-%s-%s" % (medium, top, number)
    path = os.path.join(work, name + ".mci")
    write_scene(medium, path, surface='m "%s"' % os.path.basename(mesh))
    return Case(name, medium, top, path, mesh=mesh, grid=None if kind == "mesh" else "%s-rough-%s" % (medium, number))


def rough_cases(medium, numbers, amplitude, work):
    cases = []
    for number in numbers:
        case = top_case(medium, "mesh", number, amplitude, work)
        cases.append(case)
        if number == SEARCHED:
            cases.append(searched(case))
    return cases


def searched(case):
    """Returns this case with Embree in place of the walk over cells."""
    return Case(case.name + "-embree", case.medium, "searched", case.path, ["--mesh-search", "embree"], grid=case.grid)


def irregular_cases(medium, amplitude, work, quick):
    made = [top_case(medium, kind, number, amplitude, work) for kind, numbers in IRREGULAR.items()
            for number in numbers if number == QUICK or not quick]
    return made + [searched(case) for case in made if case.name.endswith("-moved-" + QUICK)]


def overhang_case(medium, work):
    """Returns the case of a medium below a mesh of meshes/ that is mostly flat."""
    name, mesh = medium + "-overhang", os.path.join(ROOT, "meshes", "overhang.obj")
    path = os.path.join(work, name + ".mci")
    write_scene(medium, path, surface='m "%s"' % mesh)
    return Case(name, medium, "overhang", path, mesh=mesh)


def overhanging_cases(medium, work):
    """Returns the cases that only Embree can search."""
    return [top_case(medium, kind, QUICK, AMPLITUDE, work) for kind in OVERHANGING] + [overhang_case(medium, work)]


def level_case(medium, work):
    """Returns the case of a flat mesh that is treated as a mesh. It shows the cost of a mesh without a shape."""
    name, obj = medium + "-level-mesh", "level.obj"
    make_surface("mesh", 8, "0", os.path.join(work, obj))
    path = os.path.join(work, name + ".mci")
    write_scene(medium, path, surface='m "%s"' % obj)
    return Case(name, medium, "level", path, ["--boundaries", "mesh"])


def ring_cases(medium, work):
    cases = []
    for rings in RINGS:
        text = "rings-%d.txt" % rings
        make_surface("rings", rings, AMPLITUDE, os.path.join(work, text))
        name = "%s-rings-%d" % (medium, rings)
        path = os.path.join(work, name + ".mci")
        write_scene(medium, path, surface='b "%s"' % text)
        for kind in ("cone", "mesh") if rings > 1 else ("cone",):
            cases.append(Case("%s-%s" % (name, kind), medium, "rings", path, ["--boundaries", kind]))
    return cases


def all_cases(work, quick):
    """Returns all cases, grouped by medium. The flat scene comes first, so that it runs close to the cases that are divided by it."""
    numbers = ["1e3", "1e4", "1e5", "3e5"] + ([] if quick else ["1e6"])
    cases = []
    for medium in SCENES:
        flat = os.path.join(work, medium + ".mci")
        write_scene(medium, flat)
        cases.append(Case(medium, medium, "flat", flat))
        if medium in ("S2", "S6a"):
            cases.append(level_case(medium, work))
            cases += rough_cases(medium, numbers, AMPLITUDE, work)
            cases += irregular_cases(medium, AMPLITUDE, work, quick) + overhanging_cases(medium, work)
            cases += ring_cases(medium, work)
        if medium == "A":
            cases += rough_cases(medium, [QUICK], AMPLITUDE_A, work) + irregular_cases(medium, AMPLITUDE_A, work, True)
    with_two = []
    for case in cases:
        with_two += [case, case.two()] if case.name in TWO_THREADS else [case]
    return with_two


def beside_grids(all_of_them):
    """Returns the tops that are compared with a regular grid, those grids, and the flat scenes of their media."""
    tops = [case for case in all_of_them if case.grid or case.surface == "overhang"]
    wanted = {case.grid for case in tops} | {case.medium for case in tops} | {case.name for case in tops}
    return [case for case in all_of_them if case.name in wanted]


def rows_of(name):
    """Returns the rows of a CSV file of tests/reference as {column: text}, without the comments above its header."""
    path = os.path.join(REFERENCE, name)
    if not os.path.exists(path):
        return []
    with open(path) as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def totals_of(row, specular):
    """Returns Rd, A and Tt from total reflectance and transmittance, which include specular and unscattered light."""
    reflected, transmitted = float(row["UR1"]), float(row["UT1"])
    return {"Rd": reflected - specular, "A": 1 - reflected - transmitted, "Tt": transmitted}


def exact_of(lines):
    """Returns Rd, A, Tt of a flat scene, given by its data lines, from adding-doubling (error below 1e-6, without this program), or None."""
    try:
        layers = [[float(word) for word in line.split()] for line in lines[ABOVE + 1:-1]]
    except ValueError:
        return None
    specular = ((layers[0][0] - 1) / (layers[0][0] + 1)) ** 2
    for row in rows_of("layers.csv"):
        if [[float(word) for word in layer.split("/")] for layer in row["layers"].split("|")] == layers:
            return totals_of(row, specular)
    for row in rows_of("slabs.csv"):
        key = [float(row[name]) for name in ("n_slab", "mua", "mus", "g", "d")]
        if [key] == layers and float(row["n_outside"]) == 1 and row["specular_included"] == "yes":
            return totals_of(row, specular)
    return None


def exact(medium):
    return exact_of(data_lines(medium))


def reference(medium):
    """Returns the independent Rd of a medium, or None."""
    known = exact(medium)
    return known and known["Rd"]
