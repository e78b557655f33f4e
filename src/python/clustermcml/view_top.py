"""Draws what touches boundary 0, the faces and ports of a scene: their cut in a section, and a plan from above.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
from typing import Any

from .pictures import COLOURS

NAMED = 40  # ports that are named in the plan


def half_width(shape: str, size: list[float]) -> float:
    """Returns half the width [cm] along x of a disk, a ring or a rectangle."""
    return size[0] / 2 if shape == "rectangle" else max(size)


def _cuts(line: dict[str, Any], left: float, right: float) -> list[tuple[float, float]]:
    """Returns where the line y = 0 runs through a face or a port, as pairs of x.

    >>> _cuts({"shape": "ring", "size": [3.0, 5.0], "x": 1.0, "y": 0.0}, -9, 9)
    [(-4.0, -2.0), (4.0, 6.0)]
    """
    if line["shape"] is None:
        return [(left, right)]
    x, y, size = line["x"], abs(line["y"]), line["size"]
    if line["shape"] == "rectangle":
        return [(x - size[0] / 2, x + size[0] / 2)] if y <= size[1] / 2 else []
    out, inner = (math.sqrt(max(r * r - y * y, 0)) for r in (max(size), size[0] if line["shape"] == "ring" else 0.0))
    return [] if out == 0 else [(x - out, x + out)] if inner == 0 else [(x - out, x - inner), (x + inner, x + out)]


def colour(line: dict[str, Any]) -> str:
    """Returns the colour of a face, a grey that is lighter the more it reflects, or of a port, a blue that is deeper with its index."""
    if line["kind"] == "face":
        grey = 0.35 + 0.45 * (0.6 if line["r"] is None else line["r"])
        return f"{grey:.3f}"
    depth = max(0.0, min(1.0, line["n"] - 1))
    return "#{:02X}{:02X}FF".format(*(round(235 - depth * span) for span in (150, 70)))


def _words(top: list[dict[str, Any]]) -> str:
    """Returns the laws of faces and the indices of ports in words, each once.

    >>> _words([{"kind": "face", "law": "mirror", "r": 0.5}, {"kind": "port", "n": 1.46}, {"kind": "port", "n": 1.44}])
    'face: R = 0.5; ports: n = 1.44, 1.46'
    """
    faces = [f"n = {line['n']:.3g}+{line['k']:.3g}i" if line["law"] == "metal" else f"R = {line['r']:.3g}" + " lambertian" * (line["law"] == "lambertian")
             for line in top if line["kind"] == "face"]
    indices = sorted({line["n"] for line in top if line["kind"] == "port"})
    parts = ["face: " + ", ".join(dict.fromkeys(faces))] * bool(faces) + ["ports: n = " + ", ".join(f"{n:.4g}" for n in indices)] * bool(indices)
    return "; ".join(parts)


def draw_section(axes: Any, top: list[dict[str, Any]], frame: tuple[float, float, float, float]) -> None:
    """Draws the cuts of faces and ports as bars on z = 0; later ones lie on top."""
    left, right, upper, lower = frame
    for k, line in enumerate(top):
        for low, high in _cuts(line, left, right):
            axes.fill_between([low, high], -0.035 * (lower - upper), 0, color=colour(line), lw=0.6, edgecolor="#404040", zorder=1.5 + 1e-3 * k)


def _patch(line: dict[str, Any], reach: float, style: dict[str, Any]) -> Any:
    from matplotlib.patches import Annulus, Circle, Rectangle
    if line["shape"] is None:
        return Rectangle((-10 * reach, -10 * reach), 20 * reach, 20 * reach, **style)
    middle, size = (line["x"], line["y"]), line["size"]
    if line["shape"] == "rectangle":
        return Rectangle((middle[0] - size[0] / 2, middle[1] - size[1] / 2), *size, **style)
    return Annulus(middle, size[1], size[1] - size[0], **style) if line["shape"] == "ring" and size[0] > 0 else Circle(middle, max(size), **style)


def draw_plan(axes: Any, scene: dict[str, Any]) -> None:
    """Draws boundary 0 from above: faces and ports in their order, with the names of ports that are lit or read.

    The plan holds all ports, and faces up to twice as far out."""
    top = scene["top"]
    used = {thing.get("port") for thing in [*scene["beams"], *scene.get("detectors", [])]}
    shaped = [line for line in top if line["shape"] is not None]
    far = {id(line): math.hypot(line["x"], line["y"]) + (math.hypot(*line["size"]) / 2 if line["shape"] == "rectangle" else max(line["size"])) for line in shaped}
    ports = [far[id(line)] for line in shaped if line["kind"] == "port"]
    reach = max([*ports, *(min(far[id(line)], 2 * max(ports, default=math.inf)) for line in shaped)], default=1.0)
    axes.grid(False)
    for k, line in enumerate(top):
        axes.add_patch(_patch(line, reach, {"facecolor": colour(line), "edgecolor": "#404040", "lw": 0.6, "zorder": 1 + 1e-3 * k}))
    named = [line for line in top if line["kind"] == "port" and (line["name"] in used or not used - {None})]
    lit = {beam.get("port") for beam in scene["beams"]}
    for line in named[:NAMED]:
        ring = line["shape"] == "ring"
        place = (line["x"], line["y"] + (sum(line["size"]) / 2 if ring else 0.0))
        axes.annotate(line["name"], place, ha="center", va="center", fontsize="small", color=COLOURS[1 if line["name"] in lit else 4], zorder=3, clip_on=True)
    axes.set(xlim=(-1.05 * reach, 1.05 * reach), ylim=(-1.05 * reach, 1.05 * reach), aspect="equal", xlabel="x [cm]", ylabel="y [cm]")
    axes.set_title(f"from above, n = {scene['n_above']:g} beyond\n{_words(top)}", loc="left", fontsize="small", fontweight="normal")
