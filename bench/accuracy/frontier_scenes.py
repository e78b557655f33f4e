"""The scenes of frontier.py and the ways to fly them.

SPDX-License-Identifier: MIT
"""
import os

import cases

FLAT = ("S1", "S2", "S3", "S4", "S5", "S6a")
SHAPES = ("hihill", "hicrater", "lonoise")
ROUGH = (("S2", cases.AMPLITUDE), ("S5", "0.0015"))  # medium, height [cm]; the top of skin must not reach its second layer
NAMES = FLAT + SHAPES + tuple(medium + "-rough" for medium, _ in ROUGH)
TRIANGLES = 10000
CHARTED = ("S2", "S6a", "S5") + SHAPES + ("S2-rough", "S5-rough")
LABELS = {"S2": "S2 (fig6), flat", "S6a": "S6a (thick), flat", "S5": "S5 (skin7), flat", "S2-rough": "S2, rough scan on top",
          "S5-rough": "S5 (skin7), rough scan on top"}


class Method:
    """One way to fly a scene. name: kind of the boundaries, or auto."""

    def __init__(self, name, options=()):
        self.name, self.options = name, list(options)


class Scene:
    """path: file of the scene; flat: its data lines without shapes, for original MCML; truth: the method of the reference engine against which
    biases are measured, or None if adding-doubling knows the totals."""

    def __init__(self, name, path, flat, methods, truth=None, exact=None):
        self.name, self.path, self.flat, self.methods, self.truth, self.exact = name, path, flat, methods, truth, exact


def flat_scene(medium, work):
    path = os.path.join(work, medium + ".mci")
    cases.write_scene(medium, path)
    return Scene(medium, path, cases.data_lines(medium), [Method("plane")], None, cases.exact(medium))


def shape_scene(shape):
    path = cases.shape_path(shape)
    methods = [Method("plane", ["--boundaries", "plane"]), Method("cone", ["--boundaries", "cone"]),
               Method("mesh", ["--boundaries", "mesh"]), Method("auto")]
    return Scene(shape, path, [line for line in cases.lines_of(path) if line[:2] != "b "], methods,
                 Method("cone", ["--engine", "reference", "--boundaries", "cone"]))


def rough_scene(medium, amplitude, work):
    """Returns a scene with a scan on a regular grid, which is walked over. The method `mesh` searches the same triangles with Embree."""
    name = medium + "-rough"
    obj, path = os.path.join(work, name + ".obj"), os.path.join(work, name + ".mci")
    cases.make_surface("mesh", TRIANGLES, amplitude, obj)
    cases.write_scene(medium, path, surface='m "%s"' % os.path.basename(obj))
    methods = [Method("plane", ["--boundaries", "plane"]), Method("grid", ["--boundaries", "mesh"]),
               Method("mesh", ["--boundaries", "mesh", "--mesh-search", "embree"]), Method("auto")]
    return Scene(name, path, cases.data_lines(medium), methods, Method("mesh", ["--engine", "reference"]))


def all_scenes(work):
    return ([flat_scene(medium, work) for medium in FLAT] + [shape_scene(shape) for shape in SHAPES]
            + [rough_scene(medium, amplitude, work) for medium, amplitude in ROUGH])
