"""Files of surfaces: writes arrays as files that the program reads.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import Any

import numpy as np

CM = 0.01  # m


def write_gsf(path: str, heights: Any, dx: float, dy: float) -> None:
    """Writes a Gwyddion Simple Field (gwyddion.net/documentation/user-guide-en/gsf.html). heights: [ny, nx] in cm, y rising
    with the first index. The file has single-precision floats in m, the row of the largest y first. XReal and YReal are widths
    of all pixels."""
    ny, nx = heights.shape
    header = (f"Gwyddion Simple Field 1.0\nXRes = {nx}\nYRes = {ny}\nXReal = {float(nx * dx * CM)!r}\nYReal = {float(ny * dy * CM)!r}\n"
              "XYUnits = m\nZUnits = m\n").encode("ascii")
    with open(path, "wb") as file:
        file.write(header + b"\0" * (4 - len(header) % 4))
        file.write(np.ascontiguousarray(heights[::-1].astype(float) * CM, dtype="<f4").tobytes())


def write_obj(path: str, vertices: Any, faces: Any) -> None:
    """Writes a Wavefront OBJ file. vertices: [n, 3]. faces: [m, 3], counted from 0 here, from 1 in the file."""
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {float(x)!r} {float(y)!r} {float(z)!r}\n" for x, y, z in vertices)
        file.writelines(f"f {a} {b} {c}\n" for a, b, c in (faces.astype(np.int64) + 1).tolist())
