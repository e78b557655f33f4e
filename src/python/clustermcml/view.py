"""Draws a scene in the plane y = 0: boundaries, layers, bodies, beams with their outer rays, detectors and the map. Faces and
ports on boundary 0 get a plan beside it.

The shapes come from `check --json` and `mesh`.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
import os
from typing import Any, Iterable, Optional, Union

import numpy as np

from . import errors
from .command_line import Parser, check_overwrite, picture_path, print_text, shown_path
from .commands import check, mesh
from .pictures import COLOURS, drawing, save
from .scene import Scene
from .scene_files import scratch_folder
from .view_top import draw_plan, draw_section, half_width

LAYERS, BODIES = 20, 40  # numbers of layers and bodies that are named in the picture
MOST_CELLS = 2000  # most cells of a tile along the picture
HALF = {"pencil": 0.0, "disk": 1.0, "gaussian": 1.0, "ring": 1.0, "rectangle": 0.5, "image": 0.5}  # distance of the farthest part from the axis, in units of the beam's size


# ---- sections ----

def _read_obj(path: str) -> tuple[Any, Any]:
    """Reads the corners and the triangles of an .obj file of boundaries or bodies."""
    points, facets = [], []
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                points.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                facets.append([int(word.partition("/")[0]) - 1 for word in words[1:4]])
    return np.array(points), np.array(facets, dtype=int)


def section(points: Any, facets: Any, y: float) -> Any:
    """Cuts triangles with the plane at y. Returns the cuts as [n, 2 ends, x and height]; triangles that the plane misses are
    left out.

    >>> section(np.array([[0, -1, 0], [2, 1, 2], [0, 1, 0.0]]), np.array([[0, 1, 2]]), 0.0).tolist()
    [[[1.0, 1.0], [0.0, 0.0]]]
    """
    a, b = points[facets], points[np.roll(facets, -1, axis=1)]
    passes = (a[..., 1] > y) != (b[..., 1] > y)
    cut = passes.sum(axis=1) == 2
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((y - a[..., 1]) / (b[..., 1] - a[..., 1]))[..., None]
        ends = (a + share * (b - a))[..., [0, 2]]
    return ends[cut][passes[cut]].reshape(-1, 2, 2)


class Line:
    """The section of a boundary or body, as straight pieces [n, 2 ends, x and z], z down."""

    def __init__(self, pieces: Any) -> None:
        self.pieces = pieces

    def draw(self, axes: Any, **style: Any) -> None:
        gaps = np.full((len(self.pieces), 1, 2), np.nan)
        path = np.concatenate([self.pieces, gaps], axis=1).reshape(-1, 2)
        axes.plot(path[:, 0], path[:, 1], **style)


def _boundary_pieces(boundary: dict[str, Any], shape: Optional[str], left: float, right: float) -> Any:
    """Returns the pieces of a boundary: its shape, repeated if it has a period, and the plane beyond the shape."""
    outer = float(boundary["outer_z"])
    if shape is None:
        return np.array([[[left, outer], [right, outer]]])
    points, facets = _read_obj(shape)
    period = boundary.get("period")
    y = 0.0 if period is None else math.ceil(points[:, 1].min() / period[1]) * period[1]
    pieces = section(points, facets, y)
    pieces[..., 1] = float(boundary["z"]) - pieces[..., 1]
    if period is not None:
        first, last = math.floor((left - points[:, 0].max()) / period[0]), math.ceil((right - points[:, 0].min()) / period[0])
        step = max(1, (last - first) * len(pieces) // (MOST_CELLS * 10))
        return np.concatenate([pieces + np.array([k * period[0], 0.0]) for k in range(first, last + 1, step)])
    low, high = (pieces[..., 0].min(), pieces[..., 0].max()) if len(pieces) else (right, right)
    return np.concatenate([pieces, [[[left, outer], [min(low, right), outer]], [[high, outer], [max(high, right), outer]]]])


def _body_pieces(body: dict[str, Any], shape: Optional[str]) -> Any:
    low, high = np.array(body["lower"]), np.array(body["upper"])
    if low[1] > 0 or high[1] < 0:
        return np.zeros((0, 2, 2))
    if body["form"] == "sphere":
        middle, radius = (low + high) / 2, (high[0] - low[0]) / 2
        across = math.sqrt(max(radius ** 2 - middle[1] ** 2, 0))
        turn = np.linspace(0, 2 * np.pi, 65)
        circle = np.stack([middle[0] + across * np.cos(turn), middle[2] + across * np.sin(turn)], axis=1)
        return np.stack([circle[:-1], circle[1:]], axis=1)
    pieces = section(*_read_obj(str(shape)), 0.0)
    pieces[..., 1] *= -1
    return pieces


# ---- the frame ----

def _half(beam: dict[str, Any]) -> float:
    """Returns half the width [cm] of a beam's shape along its own x."""
    return HALF[beam["shape"]] * float(beam["size"][-1 if beam["shape"] == "ring" else 0]) if beam["size"] else 0.0


def _width(scene: dict[str, Any], shapes: Iterable[Any]) -> tuple[float, float]:
    """Returns the left and right end of the picture [cm].

    The picture holds all shapes that are no planes, one period of a tile, the map, and ports with some room. If there is none of these, it holds the
    radial grid. Beams and detectors widen it."""
    ends = [end for points in shapes for end in (points[:, 0].min(), points[:, 0].max())]
    for body in scene.get("bodies", []):
        ends += [body["lower"][0], body["upper"][0]]
    if scene["map"]:
        ends += [sign * scene["map"]["nx"] * scene["map"]["dx"] / 2 for sign in (-1, 1)]
    for port in scene.get("top", []):
        ends += [port["x"] + sign * 2 * half_width(port["shape"], port["size"]) for sign in (-1, 1)] if port["kind"] == "port" else []
    if not ends or not max(ends) > min(ends):
        ends = [sign * scene["grid"]["nr"] * scene["grid"]["dr"] for sign in (-1, 1)]
    for beam in scene["beams"]:
        slant = 1 if beam["z"] is not None else math.sqrt(1 - (math.sin(math.radians(beam["angle"])) * math.cos(math.radians(beam["azimuth"]))) ** 2)
        ends += [beam["x"] - _half(beam) / slant, beam["x"] + _half(beam) / slant]
    for detector in _areas(scene):
        ends += [detector["x"] - _reach(detector), detector["x"] + _reach(detector)]
    margin = 0.06 * (max(ends) - min(ends))
    return min(ends) - margin, max(ends) + margin


def _areas(scene: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the detectors that have an area: all but the groups."""
    return [detector for detector in scene.get("detectors", []) if detector["shape"] != "group"]


def _reach(detector: dict[str, Any]) -> float:
    """Returns half the width [cm] of a detector along x. Its sizes are two radii (the first is 0 for a disk), or widths; those
    of a map are widths of a pixel."""
    if detector["shape"] in ("disk", "ring"):
        return float(max(detector["size"]))
    return float(detector["nx"] * detector["size"][0] / 2)


def _depth(scene: dict[str, Any], depths: list[tuple[float, float]], width: float) -> tuple[float, float]:
    """Returns the upper and lower end of the picture [cm].

    The picture holds all bodies, and all boundaries that lie no deeper than twice its width, because layers are often given an
    enormous thickness."""
    top, bottom = depths[0]
    for body in scene.get("bodies", []):
        top, bottom = min(top, body["lower"][2]), max(bottom, body["upper"][2])
    reach, whole = top + 2 * max(width, bottom - top), True
    for low, high in depths[1:]:
        whole &= high <= reach
        top, bottom = (min(top, low), max(bottom, high)) if high <= reach else (top, bottom)
    for thing in [*scene["beams"], *_areas(scene)]:
        if thing["z"] is not None:
            top, bottom = min(top, thing["z"]), max(bottom, thing["z"])
    bottom += 0.0 if whole and bottom > top else width / 2
    return top - 0.35 * (bottom - top), bottom + 0.15 * (bottom - top)


# ---- drawing ----

def _beam_words(beam: dict[str, Any], number: str) -> str:
    """Returns the words that describe a beam in a picture."""
    size, words = beam["size"], {"gaussian": "Gaussian"}.get(beam["shape"], beam["shape"])
    words = f"port {beam['port']}, {words}" if beam.get("port") else words
    if beam["shape"] in ("disk", "gaussian"):
        words += f", R = {size[0]:g} cm"
    elif beam["shape"] == "ring":
        words += f", R = {size[0]:g} to {size[1]:g} cm"
    elif size:
        words += f", {size[0]:g} x {size[1]:g} cm"
    if beam["angle"] > 0:
        words += f", angle {beam['angle']:g}, azimuth {beam['azimuth']:g}"
    words += {"parallel": "", "na": f", na:{beam['na'] or 0:g}", "table": ", light of a table (rays: half its maximum)"}.get(beam["light"], ", " + beam["light"])
    return number + words + (f", at y = {beam['y']:g} cm" if beam["y"] else "")


def _arrow(axes: Any, tip: Any, foot: Any, **style: Any) -> None:
    """Draws an arrow, cut off at the frame."""
    drawn = axes.annotate("", tuple(tip), tuple(foot), annotation_clip=False, arrowprops={"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, **style})
    drawn.arrow_patch.set_clip_path(axes.patch)
    drawn.set_in_layout(False)


def _draw_beam(axes: Any, beam: dict[str, Any], frame: tuple[float, float, float, float]) -> None:
    """Draws the axis of a beam, its sides, and the rays at its sides. A beam that starts inside is drawn as arrows from its
    middle."""
    left, right, top, bottom = frame
    angle, across, half = math.radians(beam["angle"]), math.cos(math.radians(beam["azimuth"])), _half(beam)
    style: dict[str, Any] = {"color": COLOURS[1], "lw": 1.3}
    spread = math.radians(beam["spread"])
    if beam["z"] is None:
        length, axis = -top, np.array([math.sin(angle) * across, math.cos(angle)])
        slope = axis[0] / axis[1] if axis[1] > 1e-9 else 0.0
        wide = half / math.sqrt(max(1 - axis[0] ** 2, 1e-12))
        for offset in sorted({-wide, 0.0, wide}):
            _arrow(axes, (beam["x"] + offset, 0), (beam["x"] + offset - slope * length, top), **style)
        for sign in (-1, 1) if spread > 0 else ():
            ray = max(-1e3, min(1e3, math.tan(max(-1.55, min(1.55, angle * across + sign * spread)))))
            axes.plot([beam["x"] + sign * wide - ray * length, beam["x"] + sign * wide], [top, 0], ls=":", **style)
        return
    reach = min(0.12 * (right - left), 0.2 * (bottom - top))
    side = half * np.array([math.cos(angle) * across, -math.sin(angle)])
    middle, axis = np.array([beam["x"], beam["z"]]), np.array([math.sin(angle) * across, math.cos(angle)])
    axes.plot(*np.stack([middle - side, middle + side], axis=1), marker="o" if half == 0 else None, ms=4, **{**style, "lw": 2.5})
    turns = [0.0] if beam["light"] != "isotropic" else list(np.arange(0, 2 * np.pi, np.pi / 4))
    for turn in [*turns, *([-spread, spread] if 0 < spread < np.pi / 2 * 1.001 and len(turns) == 1 else [])]:
        towards = np.array([axis[0] * math.cos(turn) - axis[1] * math.sin(turn), axis[0] * math.sin(turn) + axis[1] * math.cos(turn)])
        edge = middle + side * np.sign(-turn) if len(turns) == 1 else middle
        _arrow(axes, edge + reach * towards, edge, ls="-" if turn == 0 else ":", **style)


def _draw_detector(axes: Any, detector: dict[str, Any]) -> None:
    """Draws a detector as seen along y. A short dashed line shows the direction in which it looks."""
    x, z, reach = detector["x"], detector["z"], _reach(detector)
    angle, across = math.radians(detector["angle"]), math.cos(math.radians(detector["azimuth"]))
    style: dict[str, Any] = {"color": COLOURS[2], "lw": 3.0, "solid_capstyle": "butt"}
    spans = [(-reach, reach)] if detector["shape"] != "ring" else [(-reach, -min(detector["size"])), (min(detector["size"]), reach)]
    for low, high in spans:
        axes.plot([x + low, x + high], [z, z], **style)
    away = np.array([math.sin(angle) * across, -math.cos(angle) if detector["side"] == "top" else math.cos(angle)])
    if angle > 0 or detector["na"] is not None:
        size = 0.25 * max(reach, 1e-9)
        axes.plot([x, x + 4 * size * away[0]], [z, z + 4 * size * away[1]], color=COLOURS[2], lw=1.0, ls="--")


def _label_detectors(axes: Any, detectors: list[dict[str, Any]], frame: tuple[float, float, float, float]) -> None:
    """Labels detectors beside their right ends, within the frame. A label that would meet another moves one line farther out."""
    left, right, top, bottom = frame
    letter, line = 0.012 * (right - left), 0.05 * (bottom - top)
    taken: list[tuple[float, float, float]] = []
    for detector in sorted(detectors, key=lambda detector: float(detector["x"])):
        text, sign = "detector " + detector["name"], -1 if detector["side"] == "top" else 1
        x = max(left + letter, min(detector["x"] + 0.9 * _reach(detector) + letter, right - letter * (len(text) + 1)))
        z = detector["z"] + sign * line
        while any(x < end + letter and start < x + letter * (len(text) + 1) and abs(z - other) < 0.99 * line for start, end, other in taken):
            z += sign * line
        taken.append((x, x + letter * len(text), z))
        axes.annotate(text, (x, z), va="center", color=COLOURS[2], fontsize="small", annotation_clip=False)


def _label_media(axes: Any, scene: dict[str, Any], depths: list[float], frame: tuple[float, float, float, float]) -> None:
    """Labels media at the right end of each layer if there is room. Of very many layers, only every second, third ... is
    labelled."""
    _, _, top, bottom = frame
    backing = scene["backing"]
    below = f"below, n = {scene['n_below']:g}"
    if backing:
        below = f"{backing['kind']}, " + (f"{backing['n']:.3g}+{backing['k']:.3g}i" if backing["kind"] == "metal" else f"R = {backing['R']:.3g}")
    words = [f"above, n = {scene['n_above']:g}", *(f"{layer.get('name') or f'layer {i}'}, n = {layer['n']:g}" for i, layer in enumerate(scene["layers"], 1)), below]
    ends = [-math.inf, *depths, math.inf]
    spans = [(max(ends[m], top), min(ends[m + 1], bottom), words[m]) for m in range(len(words)) if min(ends[m + 1], bottom) > max(ends[m], top)]
    spans = spans[::-(-len(spans) // LAYERS)]
    least, last = 0.045 * (bottom - top), -math.inf
    places = []
    for low, high, _ in spans:
        last = max((low + high) / 2, last + least)
        places.append(last)
    over = max(0.0, (places[-1] if places else 0) - bottom + least / 2)
    for i in range(len(places) - 1, -1, -1):
        places[i] = min(places[i], (places[i + 1] - least) if i + 1 < len(places) else places[i] - over)
    for (low, high, text), place in zip(spans, places):
        axes.annotate(text, (1.0, (low + high) / 2), (1.05, place), xycoords=("axes fraction", "data"), textcoords=("axes fraction", "data"), va="center", fontsize="small",
                      annotation_clip=False, arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "#808080"})


def _caption(scene: dict[str, Any], stretch: float) -> str:
    """Returns the caption. stretch: ratio of the drawn length of 1 cm along z to that along x."""
    named = [f"Boundary {b}: {boundary['shape']}." for b, boundary in enumerate(scene["boundaries"]) if boundary.get("shape")]
    plane = "Plane y = 0" + (f", z drawn {stretch:.2g} times as high as x is wide" if abs(math.log(stretch)) > 0.05 else "")
    return " ".join([plane + ".", *named[:6], *(["And others."] if len(named) > 6 else [])])


def draw(scene: dict[str, Any], folder: str, path: str, style: Optional[str] = None) -> None:
    """Draws a scene. scene: answer of `check`. folder: folder with the shapes that `mesh` has written."""
    stem = os.path.join(folder, os.path.basename(scene["output"]))
    shapes = [f"{stem}.boundary{b}.obj" for b in range(len(scene["boundaries"]))]
    there = [shape if os.path.exists(shape) else None for shape in shapes]
    points = [_read_obj(shape)[0] for shape in there if shape]
    left, right = _width(scene, points)
    lines = [Line(_boundary_pieces(boundary, shape, left, right)) for boundary, shape in zip(scene["boundaries"], there)]
    depths = [(float(line.pieces[..., 1].min()), float(line.pieces[..., 1].max())) for line in lines]
    top, bottom = _depth(scene, depths, right - left)
    bodies = [_body_pieces(body, f"{stem}.body{k}.obj") for k, body in enumerate(scene.get("bodies", []), 1)]
    with drawing(style, (12.0, 5.2) if scene.get("top", []) else (8.6, 5.2)):
        from matplotlib.figure import Figure
        figure = Figure(layout="constrained")
        plan, axes = figure.subplots(1, 2, width_ratios=[1, 1.5]) if scene.get("top", []) else (None, figure.subplots())
        axes.grid(False)
        if len(lines) > 2000:  # more lines would be one black area
            lines = [*lines[::-(-len(lines) // 2000)], lines[-1]]
        for line in lines:
            line.draw(axes, color="#202020")
        labels: list[tuple[float, float, str]] = []
        for k, pieces in enumerate(bodies):
            Line(pieces).draw(axes, color=COLOURS[0])
            if len(pieces) and len(labels) < BODIES:
                labels.append((float(pieces[..., 1].mean()), float(pieces[..., 0].max()), f"body {k + 1}, n = {scene['bodies'][k]['n']:g}"))
        last = -math.inf
        for depth, x, text in sorted(labels):  # labels stand one below the other
            last = max(depth, last + 0.045 * (bottom - top))
            axes.annotate(text, (x, last), (4, 0), textcoords="offset points", va="center", fontsize="small", color=COLOURS[0])
        frame = (left, right, top, bottom)
        if plan is not None:
            draw_plan(plan, scene)
            draw_section(axes, scene.get("top", []), frame)
        words = []
        for k, beam in enumerate(scene["beams"]):
            _draw_beam(axes, beam, frame)
            words.append(_beam_words(beam, f"{k + 1}: " if len(scene["beams"]) > 1 else ""))
        for detector in _areas(scene):
            _draw_detector(axes, detector)
        _label_detectors(axes, [detector for detector in _areas(scene) if not detector.get("port")], frame)  # the plan names ports
        if scene["map"]:
            reach = scene["map"]["nx"] * scene["map"]["dx"] / 2
            for x in (-reach, reach):
                axes.axvline(x, color="#808080", lw=1.0, ls="-.")
            words.append("map, {nx} x {ny} pixels of {dx:g} x {dy:g} cm".format(**scene["map"]))
        figure.get_layout_engine().set(rect=(0, 0, 0.97, 1))
        axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="x [cm]", ylabel="depth z [cm]")
        axes.set_title("\n".join(words), loc="left", fontsize="small", fontweight="normal", color=COLOURS[1])
        figure.suptitle(f"{shown_path(scene['output'])}, seen along y", fontweight="bold")
        caption = figure.supxlabel(_caption(scene, 1.0), fontsize="small", x=0.01, ha="left", color="#404040")
        _label_media(axes, scene, [boundary["outer_z"] for boundary in scene["boundaries"]], frame)
        figure.draw_without_rendering()
        box = axes.get_window_extent()
        caption.set_text(_caption(scene, box.height / (bottom - top) / (box.width / (right - left))))
        save(figure, path)


def view(scene: Union[Scene, str, os.PathLike[str]], output: Union[str, os.PathLike[str]], run: int = 1, style: Optional[str] = None, **options: Any) -> None:
    """Draws the section y = 0 through a scene: boundaries, layers, bodies, beams, detectors and the map.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        output: Path of the picture: .svg, .png, .pdf or .eps.
        run: Number of the run in the file, from 1.
        style: Path of a style of matplotlib (`.mplstyle`).
        **options: As of `mesh`.
    """
    path, run = picture_path(output), errors.whole("run", run, 1, 2**31)
    if style is not None:
        style = errors.existing_file("style", style)
    runs = check(scene, **options)
    if not 1 <= run <= len(runs):
        raise errors.InputError(f"--run {run} (expected 1 to {len(runs)}, the runs of {'the Scene' if isinstance(scene, Scene) else os.fspath(scene)})")
    told = runs[run - 1]
    with scratch_folder() as folder:
        curved = any(boundary["kind"] != "plane" for boundary in told["boundaries"]) or any(body["form"] != "sphere" for body in told.get("bodies", []))
        if curved:
            mesh(scene, folder, **options)
        draw(told, folder, path, style)


def main(words: list[str]) -> int:
    parser = Parser("view", "scene.mci", "Draws the section y = 0 through a scene: boundaries, layers, bodies with their numbers, beams with the rays at their sides, detectors, the ends of "
                    "the map. Flies no photons.", "clustermcml view samples/mixed.mci -o mixed.svg")
    parser.add_argument("scene", metavar="scene.mci")
    parser.add_output("the picture: .svg, .png, .pdf or .eps; default view.svg", "view.svg")
    parser.add_argument("--run", metavar="K", type=parser.whole(1, 2**31), default=1, help="the file's run, from 1 (default)")
    parser.add_argument("--set", metavar="NAME=VALUE", action="append", default=[], help="a number of the scene, as run takes it")
    parser.add_argument("--ignore-heightfields", action="store_true", help="heightfields count as planes")
    parser.add_argument("--style", metavar="FILE", help="a style of matplotlib (.mplstyle), over ours")
    parser.add_argument("--quiet", action="store_true", help="does not name the picture")
    given = parser.parse_args(words)
    check_overwrite("view", given.output, [given.scene])
    settings = {name: value for name, _, value in (word.partition("=") for word in given.set)}
    options: dict[str, Any] = {**({"set": settings} if settings else {}), **({"ignore_heightfields": True} if given.ignore_heightfields else {})}
    view(given.scene, given.output, given.run, given.style, **options)
    return 0 if given.quiet else print_text(shown_path(given.output) + "\n")
