"""Phase functions: the scattering of a medium that does not follow Henyey and Greenstein.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import errors
from .options import Path
from .surfaces import shortest

NUMBERS = {"hg2": ("g1", "g2", "w"), "mhg": ("g", "w"), "gk": ("g", "a"), "rayleigh": (), "table": ()}


@dataclass
class Phase:
    """A phase function, in place of that of Henyey and Greenstein. The medium's g must be its mean cosine to 1e-3.

    Attributes:
        kind: "hg2" (with g1, g2, w), "mhg" (g, w), "gk" (g, a), "rayleigh", or "table" (path, or angles and densities).
        g1: Mean cosine of the first part.
        g2: Mean cosine of the second part.
        w: Share of the first part, 0 to 1.
        g: Mean cosine.
        a: Exponent of the Gegenbauer kernel, above -0.5 and at most 100; 0.5 is the function of Henyey and Greenstein.
        path: File with a column of angles [degrees, 0 to 180, rising] and a column of densities.
        angles: Angles of a table [degrees].
        densities: Density at each angle, in any unit.

    Examples:
        >>> Phase("hg2", g1=0.9, g2=-0.4, w=0.95).line("", "")
        'phase hg2 0.9 -0.4 0.95'
    """

    kind: str
    g1: Optional[float] = None
    g2: Optional[float] = None
    w: Optional[float] = None
    g: Optional[float] = None
    a: Optional[float] = None
    path: Optional[Union[str, os.PathLike[str]]] = None
    angles: Optional[npt.ArrayLike] = None
    densities: Optional[npt.ArrayLike] = None

    def __post_init__(self) -> None:
        errors.choice("Phase.kind", self.kind, *NUMBERS)
        for name in ("g1", "g2", "w", "g", "a"):
            value = getattr(self, name)
            if name in NUMBERS[self.kind]:
                errors.finite("Phase." + name, value)
            elif value is not None:
                raise errors.refuse("Phase." + name, value, f"None for {self.kind}")
        tables = (self.path is not None) + (self.angles is not None and self.densities is not None)
        if tables != (self.kind == "table"):
            raise errors.refuse("Phase.path", self.path, "a file, or angles and densities, for a table, and for nothing else")
        if self.angles is not None and self.densities is not None:
            expected = "a list of finite angles"
            angles = errors.array("Phase.angles", self.angles, "iuf", expected)
            if angles.ndim != 1:
                raise errors.refuse("Phase.angles", self.angles, expected)
            expected = f"{angles.size} finite numbers, one for each angle"
            if errors.array("Phase.densities", self.densities, "iuf", expected).shape != angles.shape:
                raise errors.refuse("Phase.densities", self.densities, expected)

    def line(self, directory: Path, stem: str) -> str:
        """Returns the line for a `.mci` in that directory. Writes DIRECTORY/STEM.phase.txt if the table is given as arrays."""
        if self.kind != "table":
            return " ".join(["phase", self.kind, *(shortest(getattr(self, name)) for name in NUMBERS[self.kind])])
        if self.path is not None:
            return "phase table " + errors.quoted_file("Phase.path", self.path)
        path = stem + ".phase.txt"
        rows: npt.NDArray[Any] = np.column_stack([np.asarray(self.angles), np.asarray(self.densities)])
        np.savetxt(os.path.join(directory, path), rows, "%.17g")
        return f'phase table "{path}"'
