"""Spectra: a scene whose media depend on the wavelength.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import errors
from .media import Medium, wavelengths as rising
from .options import Path, SweepOptions, shown
from .progress import Wanted
from .scene import Scene
from .sweep import _table, fly_sweep

if TYPE_CHECKING:
    import xarray as xr

    from typing_extensions import Unpack

Media = Mapping[str, Union[Medium, npt.ArrayLike]]
EXPECTED = '{"layer1": Medium(...), "layer1.d": 0.1}: a Medium for a layer or a body, or a number, or one for each wavelength, for a name as `set` takes it'
ALONE = ("aim", "target_error", "derivatives", "keep", "more")  # options that need a flight of its own for each row


def columns_of(media: Any, nm: Any) -> dict[str, Any]:
    """Returns {name as `set` takes it: values over the wavelengths} of all numbers that the media set."""
    if not isinstance(media, Mapping) or not media or not all(isinstance(name, str) for name in media):
        raise errors.refuse("media", media, EXPECTED)
    columns: dict[str, Any] = {}
    for name, medium in media.items():
        if isinstance(medium, Medium):
            found = {f"{name}.{kind}": values for kind, values in medium.columns(nm).items()}
        else:
            values = errors.array(f"media[{name!r}]", medium, "iuf", EXPECTED).astype(float)
            if values.shape not in ((), nm.shape) or "." not in name:
                raise errors.refuse(f"media[{name!r}]", medium, EXPECTED)
            found = {name: np.broadcast_to(values, nm.shape)}
        for column, values in found.items():
            if column in columns:
                raise errors.refuse("media", column, "each number once")
            columns[column] = values
    if not columns:
        raise errors.refuse("media", media, "at least one number that depends on the media")
    return columns


def _shared(columns: Mapping[str, Any]) -> bool:
    """Returns whether two wavelengths differ in mua alone, so that one flight serves both."""
    others = np.array([values for name, values in columns.items() if not name.endswith(".mua")]).T
    return bool(others.size == 0 or len(np.unique(others, axis=0)) < len(others)) and len(next(iter(columns.values()))) > 1


@shown
def spectrum(scene: Union[Scene, Path], media: Media, wavelengths: npt.ArrayLike, *, variables: Optional[Sequence[str]] = None,
             output_dir: Optional[Path] = None, progress: Wanted = None, **options: Unpack[SweepOptions]) -> xr.Dataset:
    """Simulates a scene at each wavelength.

    Wavelengths that differ in mua alone share a flight (reweight=True), unless an option needs a flight for each.

    Args:
        scene: A Scene, or the path of an `.mci` file with one run.
        media: {name: Medium} for layers and bodies (layer1, body1, or a layer's own name), and {name: number, or one for each wavelength}
            for single numbers as `set` takes them: layer1.d, above.n, layer2.mus.
        wavelengths: Rising wavelengths [nm].
        variables: Names of the arrays to keep; None keeps all.
        output_dir: As of `sweep`.
        progress: As of `sweep`.
        **options: As of `sweep`.

    Returns:
        An xarray.Dataset with the results at all wavelengths. Their dimension is `nm`; the numbers that were set stand beside it as coordinates.

    Raises:
        InputError: A medium, a wavelength, the scene or an option is refused.

    Examples:
        >>> spectrum("scene.mci", {"layer1": 1.4}, [500, 600])
        Traceback (most recent call last):
        ...
        clustermcml.errors.InputError: media['layer1'] = 1.4 (expected {"layer1": Medium(...), "layer1.d": 0.1}: a Medium for a layer or a body, or a number, or one for each wavelength, for a name as `set` takes it)
    """
    nm = rising("wavelengths", wavelengths)
    columns = columns_of(media, nm)
    if not any(options.get(name) for name in ALONE) and options.get("engine") != "opencl":
        options.setdefault("reweight", _shared(columns))
    table = _table(columns, "nm", {"nm": nm})
    result = fly_sweep(scene, table, variables, output_dir, progress, options, " counts from above")  # the user chose media by name, and has counted layers already
    result["nm"].attrs.update(units="nm", long_name="wavelength")
    return result
