"""Pictures of meshes with a number for each facet: reads the .vtp files that runs write, and draws them from the side, shaded.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

from . import errors
from .command_line import readable, shown_path

TYPES = {"Float64": "<f8", "Float32": "<f4", "UInt32": "<u4", "Int64": "<i8"}
RASTER = 2000  # number of facets from which a picture holds pixels in place of polygons


class Mesh(NamedTuple):
    points: Any  # [n, 3] cm, z down
    corners: Any  # indices of points, facet after facet
    ends: Any  # [m] index in corners behind the last corner of each facet
    values: Any  # [m] number of each facet


def read_mesh(path: str, name: str) -> Mesh:
    """Reads the shape and one array of a .vtp file of this program. Its arrays follow one header, each after its number of
    bytes."""
    with open(readable(path), "rb") as file:
        content = file.read()
    try:
        head, _, _ = content.partition(b"<AppendedData")
        begin = content.index(b"_", len(head)) + 1
        arrays = {}
        for kind, label, offset in re.findall(rb'<DataArray type="(\w+)" Name="(\w+)"[^>]*offset="(\d+)"', head):
            size = int(np.frombuffer(content, "<u8", 1, begin + int(offset))[0])
            kept = np.dtype(TYPES[kind.decode()])
            arrays[label.decode()] = np.frombuffer(content, kept, size // kept.itemsize, begin + int(offset) + 8)
        if name not in arrays:
            raise errors.InputError(f"{shown_path(path)}: no array {name} (expected one of {' '.join(sorted(set(arrays) - {'Points', 'connectivity', 'offsets'}))})")
        corners, points = arrays["connectivity"].astype(int), arrays["Points"].reshape(-1, 3)
        ends = arrays["offsets"].astype(int)
        if not ends.size or np.diff(ends, prepend=0).min() < 3 or ends[-1] != corners.size:
            raise ValueError("facets without three corners")
        if corners.max() >= len(points) or arrays[name].size != ends.size or not np.isfinite(points).all():
            raise ValueError("facets without points or numbers")
        return Mesh(points, corners, ends, arrays[name].astype(float))
    except errors.InputError:
        raise
    except Exception as error:  # any: numpy raises many kinds of exceptions for damaged bytes
        raise errors.unreadable(path, "a .vtp file of this program", error) from error


def _normals(places: Any, starts: Any, sizes: Any) -> Any:
    """Returns twice the area of each polygon as a vector, even if corners coincide. places: [n, 3] of all corners. starts:
    first corner of each polygon."""
    following = np.arange(1, len(places) + 1)
    following[starts + sizes - 1] = starts
    arms = places - np.repeat(places[starts], sizes, axis=0)
    return np.add.reduceat(np.cross(arms, arms[following]), starts)


def _polygons(axes: Any, places: Any, starts: Any, sizes: Any, colours: Any) -> Any:
    """Returns all facets as polygons in the picture, the farthest first. The axes must be finished. matplotlib's
    Poly3DCollection projects and sorts facets one by one at each drawing, which is slow."""
    from matplotlib.collections import PolyCollection
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    class Polygons(PolyCollection):  # type: ignore[misc]
        """Polygons in the plane of the picture that are drawn among objects in space."""

        def do_3d_projection(self) -> float:
            """Returns the depth of the collection. The constant is enough, because the picture has no other collection to sort."""
            return 0.0

    x, y, depth = proj_transform(*places.T, axes.get_proj())
    order = np.argsort(-np.add.reduceat(depth, starts) / sizes, kind="stable")
    seen = np.stack([x, y], axis=1)
    if (sizes == sizes[0]).all():
        seen = seen.reshape(-1, sizes[0], 2)[order]  # an array is drawn far quicker than a list
    else:
        seen = [seen[starts[i]:starts[i] + sizes[i]] for i in order]
    return Polygons(seen, facecolors=colours[order], edgecolors="none", linewidths=0, antialiased=False, rasterized=len(sizes) > RASTER)


def draw_mesh(matplotlib: Any, axes: Any, mesh: Mesh, norm: Any) -> None:
    """Draws the facets of a mesh in three dimensions, coloured by their values."""
    from matplotlib.ticker import MaxNLocator
    places = mesh.points[mesh.corners] * (1, 1, -1)  # z points down in the file and up in the picture
    sizes = np.diff(mesh.ends, prepend=0)
    starts = mesh.ends - sizes
    normals = _normals(places, starts, sizes)
    length = np.linalg.norm(normals, axis=1)
    lit = abs(normals @ np.array([-0.5, -0.3, 0.81])) / np.where(length > 0, length, 1)
    colours = matplotlib.colormaps[matplotlib.rcParams["image.cmap"]](norm(np.maximum(mesh.values, norm.vmin)))
    colours[:, :3] *= (0.45 + 0.55 * lit)[:, None]
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    axes.set(xlim=(low[0], low[0] + size[0]), ylim=(low[1], low[1] + size[1]), zlim=(-high[2], -high[2] + size[2]))
    axes.set_xlabel("x  [cm]", labelpad=16)
    axes.set_ylabel("y  [cm]", labelpad=22)
    flat = size[2] / size.max()
    axes.set_box_aspect(np.maximum(size / size.max(), 0.08), zoom=1.0 - 0.2 * flat)
    for i, set_ticks in enumerate((axes.set_xticks, axes.set_yticks)):  # no ticks at the ends, because their labels would meet in a corner
        ticks = MaxNLocator(5).tick_values(low[i], high[i])
        set_ticks(ticks[abs(ticks - (low[i] + high[i]) / 2) < 0.45 * size[i]])
    axes.set_zticks([])
    axes.text2D(0.5, 0.98, f"heights {0.0 - high[2]:.2g} to {0.0 - low[2]:.2g} cm" + (f", drawn {0.08 / flat:.1f} times as high" if flat < 0.08 else ""), transform=axes.transAxes, ha="center", va="top", fontsize="small")
    axes.view_init(elev=32, azim=-60)
    axes.add_collection(_polygons(axes, places, starts, sizes, colours), autolim=False)
