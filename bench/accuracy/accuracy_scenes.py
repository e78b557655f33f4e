"""The scenes that the accuracy chart compares, and the methods that fly them.

SPDX-License-Identifier: MIT
"""
import functools
import math
import os
import sys

import cases

sys.path.insert(0, os.path.join(cases.ROOT, "tests", "lib"))
import paired_planes  # noqa: E402

RUNS = 16  # runs in every file, each with its own random streams
SHAPES = ("flat50", "lohill", "hihill", "locrater", "hicrater", "lonoise", "hinoise")
TOLERANCES = ("1e-1", "3e-2", "1e-2", "5e-3", "2e-3", "1e-3", "3e-4", "1e-4")
FEWER_TOLERANCES = ("1e-1", "1e-2", "1e-3")
KINDS = [(normals, rings) for normals in ("analytic", "vertex", "facet") for rings in ("area", "inscribed")]
TRIANGLES = (50, 100, 200, 500, 1000, 2000, 5000, 10000)  # triangles of the coarser samplings of the rough top
TRUE_TRIANGLES = 40000
FINE_RINGS = 12000  # rings of the stack's top
COST_RINGS = (200, 1000, 10000)
FEW_RUNS = 4  # number of runs if building a mesh takes seconds
LOWER = 1000  # ratio of the low hill's height to the ripple's
ASKED = ("1e-1", "5e-2", "2e-2", "1e-2", "1e-3", "1e-4")  # tolerances of the scenes in which a plane is worse than it looks


class Method:
    """One way to fly a scene. group: the series of the chart. scene: a file in place of the scene's own."""

    def __init__(self, name, group, options, tolerance="", scene=None):
        self.name, self.group, self.options, self.tolerance, self.scene = name, group, options, tolerance, scene


class Scene:
    """A file of several runs. mut and profile (last radius, steepest slope): of its curved boundaries, if they matter."""

    def __init__(self, name, path, methods, mut=0.0, profile=None):
        self.name, self.path, self.methods, self.mut, self.profile = name, path, methods, mut, profile

    def path_of(self, method):
        return method.scene or self.path

    def bound(self, group, deviation):
        """Returns bounds on paper of the errors of a tessellation's points and normals, and of points in single precision."""
        if not self.profile or not deviation:
            return dict.fromkeys(("position_bound_cm", "normal_bound_rad", "optical_bound", "float_cm"), "")
        radius, slope = self.profile
        tilt = slope / math.hypot(1, slope)
        half_arc = math.sqrt((2 if "inscribed" in group else 3) * deviation)  # pi / N, N from the deviation's formula
        return {"position_bound_cm": deviation * radius,
                "normal_bound_rad": tilt * (half_arc if "facet" in group or "vertex" in group else deviation),
                "optical_bound": self.mut * slope * deviation * radius, "float_cm": radius * 2.0 ** -24}


def mesh_methods(quick):
    methods = []
    for normals, rings in KINDS:
        standard = (normals, rings) == KINDS[0]
        for tolerance in TOLERANCES if standard or not quick else FEWER_TOLERANCES:
            options = ["--boundaries", "mesh", "--tolerance", tolerance, "--normals", normals, "--rings", rings]
            group = "mesh-%s-%s" % (normals, rings)
            methods.append(Method("%s-%s" % (group, tolerance), group, options, tolerance))
    return methods


def forced_methods():
    return [Method("reference-cone", "reference", ["--engine", "reference", "--boundaries", "cone"]),
            Method("cpu-cone", "cone", ["--boundaries", "cone"]), Method("auto", "auto", []),
            Method("mesh", "mesh-auto", ["--boundaries", "mesh"])]


def radial_methods(quick):
    return forced_methods() + [Method("opencl-cone", "opencl", ["--engine", "opencl", "--boundaries", "cone"]),
                               Method("plane", "plane", ["--boundaries", "plane"])] + mesh_methods(quick)


def write_runs(lines, name, path, surfaces, runs=RUNS):
    """Writes a file with `runs` runs of one scene. lines: its data lines; surfaces: {index of a medium's line: line above it}."""
    body = lines[3:]
    for index in sorted(surfaces, reverse=True):
        body.insert(index, surfaces[index])
    text = ["1.0", str(runs)]
    for run in range(runs):
        text += ["%s%d.mco A" % (name, run)] + body
    with open(path, "w") as stream:
        stream.write("\n".join(text) + "\n")


def profile_of(words):
    """Returns (last radius, steepest slope) of the numbers of a heightfield."""
    numbers = [float(word) for word in words[1:]]
    heights, spacings = numbers[0::2], numbers[1::2]
    slopes = [abs(b - a) / s for a, b, s in zip(heights, heights[1:], spacings)]
    return sum(spacings[:-1]), max(slopes)


def shape_scene(shape, work, quick):
    lines = cases.lines_of(cases.shape_path(shape))
    path = os.path.join(work, shape + ".mci")
    write_runs(lines, shape, path, {})
    words = [line for line in lines if line.startswith("b ")][0].split()[1:]
    return Scene(shape, path, radial_methods(quick), 2.0, profile_of(words))


def rings_scene(medium, work, quick):
    name = medium + "-rings"
    heights = os.path.join(work, "rings.txt")
    cases.make_surface("rings", 50, cases.AMPLITUDE, heights)
    path = os.path.join(work, name + ".mci")
    lines = cases.data_lines(medium)
    write_runs(lines, name, path, {cases.ABOVE - 2: 'b "rings.txt"'})
    n, mua, mus = (float(word) for word in lines[cases.ABOVE + 1].split()[:3])
    with open(heights) as stream:
        return Scene(name, path, radial_methods(quick), mua + mus, profile_of(stream.read().split()))


def rough_scene(work):
    """Returns a scene with an asymmetric top. Its truth is a fine sampling, run in double precision."""
    name, lines = "S2-rough", cases.data_lines("S2")

    def file_of(triangles):
        obj = "rough-%d.obj" % triangles
        cases.make_surface("mesh", triangles, cases.AMPLITUDE, os.path.join(work, obj))
        paths = {}
        for normals in ("face", "vertex"):
            paths[normals] = os.path.join(work, "%s-%d-%s.mci" % (name, triangles, normals))
            write_runs(lines, name, paths[normals], {cases.ABOVE - 2: 'm "%s" normals=%s' % (obj, normals)})
        return paths

    truth = file_of(TRUE_TRIANGLES)["face"]
    methods = [Method("reference-mesh", "reference", ["--engine", "reference"]),
               Method("cpu-mesh", "cone", []), Method("plane", "plane", ["--boundaries", "plane"]),
               Method("auto", "auto", [])]
    for triangles in TRIANGLES:
        for normals, path in file_of(triangles).items():
            group = "mesh-%s-area" % ("facet" if normals == "face" else normals)
            methods.append(Method("sampled-%s-%d" % (normals, triangles), group, [], "", path))
    return Scene(name, truth, methods)


def stack_scene(work):
    """Returns a scene whose boundaries suit different methods: fine rings over clear air, a flat field, a hill."""
    cases.make_surface("rings", FINE_RINGS, cases.AMPLITUDE, os.path.join(work, "fine.txt"))
    hill = [line for line in cases.lines_of(cases.shape_path("lohill")) if line[:2] == "b "][0]
    lines = cases.data_lines("S2")
    medium = lines[cases.ABOVE + 1]
    lines[cases.ABOVE - 1] = "2"
    lines.insert(cases.ABOVE + 1, medium)
    flat = "b 50 " + "0 0.01 " * 50
    path = os.path.join(work, "stack.mci")
    first = cases.ABOVE - 2
    write_runs(lines, "stack", path, {first: 'b "fine.txt"', first + 1: flat, first + 2: hill}, FEW_RUNS)
    return Scene("stack", path, forced_methods())


def cost_scene(rings, work):
    """Returns a scene that measures the cost of rings and triangles, for the constants of src/surface/surface_choice.c."""
    name = "S2-rings-%d" % rings
    path = os.path.join(work, name + ".mci")
    cases.make_surface("rings", rings, cases.AMPLITUDE, path + ".txt")
    write_runs(cases.data_lines("S2"), name, path, {cases.ABOVE - 2: 'b "%s.txt"' % os.path.basename(path)}, FEW_RUNS)
    return Scene(name, path, forced_methods() + [Method("plane", "plane", ["--boundaries", "plane"])])


def ripple_scene(work):
    """Returns a scene with a hill so low that a plane is enough if the tolerance allows it."""
    lines = cases.lines_of(cases.shape_path("lohill"))
    for index, words in [(i, line.split()) for i, line in enumerate(lines) if line.startswith("b ")]:
        low = ["%.6g" % (float(height) / LOWER) for height in words[2::2]]
        lines[index] = " ".join(words[:2] + [word for pair in zip(low, words[3::2]) for word in pair])
    path = os.path.join(work, "ripple.mci")
    write_runs(lines, "ripple", path, {})
    methods = forced_methods() + [Method("plane", "plane", ["--boundaries", "plane"])]
    methods += [Method("auto-%s" % tolerance, "auto", ["--tolerance", tolerance], tolerance)
                for tolerance in ("1e-3", "1e-4")]
    return Scene("ripple", path, methods)


def deceptive_scene(paired, work):
    """Returns a scene of small height and slope for which a plane is nevertheless wrong: `auto` must notice this at every tolerance."""
    path = os.path.join(work, paired.name + ".mci")
    with open(path, "w") as stream:
        stream.write(paired.text(paired.surface, RUNS))
    mua, mus = (float(word) for word in paired.layers[0].split()[1:3])
    methods = forced_methods() + [Method("plane", "plane", ["--boundaries", "plane"])]
    for tolerance in ASKED:
        methods += [Method("auto-%s" % tolerance, "auto", ["--tolerance", tolerance], tolerance),
                    Method("mesh-analytic-area-%s" % tolerance, "mesh-analytic-area",
                           ["--boundaries", "mesh", "--tolerance", tolerance], tolerance)]
    return Scene(paired.name, path, methods, mua + mus, profile_of(paired.surface.split()[1:]))


def makers(quick):
    """Returns, by the scene's name, the function that makes its files in a folder."""
    of = functools.partial
    shapes = {shape: of(shape_scene, shape, quick=quick) for shape in SHAPES}
    rings = {medium + "-rings": of(rings_scene, medium, quick=quick) for medium in ("S2", "S6a")}
    costs = {"S2-rings-%d" % count: of(cost_scene, count) for count in COST_RINGS}
    deceptive = {paired.name: of(deceptive_scene, paired) for paired, _ in paired_planes.DECEPTIVE}
    return {**shapes, **rings, "S2-rough": rough_scene, "ripple": ripple_scene, **costs, "stack": stack_scene, **deceptive}
