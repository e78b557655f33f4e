"""Results in watts or joules: every number of light times the power or the energy of the beam.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import errors
from .fields import OF_DETECTED, OF_THE_SCENE, Field

if TYPE_CHECKING:
    import xarray as xr

NO_LIGHT = re.compile(rf"lost|residue|{OF_THE_SCENE.pattern}|boundary\d+_height|(boundary|body)_[zr]_(min|max)|{OF_DETECTED.pattern}")


def is_light(name: str) -> bool:
    """True for arrays that are proportional to the light of the beam. False for the scene, counts of packets, and means over detected packets.

    >>> [is_light(name) for name in ("Rd_r_se", "detector_far", "detector_far_path_se", "layer_mua", "dRd_dmua")]
    [True, True, False, False, True]
    """
    return not NO_LIGHT.fullmatch(name.removesuffix("_se"))


def unit_of_light(unit: str, of: str) -> str:
    """Returns the unit of an array of light times a power or an energy. of: "W" or "J".

    >>> [unit_of_light(unit, "W") for unit in ("1", "1/cm2", "sr-1", "1/(cm2 sr)", "cm", "cm/sr")]
    ['W', 'W/cm2', 'W/sr', 'W/(cm2 sr)', 'W cm', 'W cm/sr']
    """
    if unit.startswith("1"):
        return of + unit[1:]
    return f"{of}/sr" if unit == "sr-1" else f"{of} {unit}"


def check_timed(name: str, unit: str, of: str) -> None:
    """Refuses watts for arrays over gates, because the light of a gate is that of a pulse."""
    if of == "W" and re.search(r"\bps\b", unit):
        raise errors.refuse("power", f"of {name} in {unit}", "energy, because arrays over time are those of a pulse")


def lit(array: Field, amount: float, of: str) -> Field:
    """Returns an array of light times a power [W] or an energy [J]; any other array stays as it is. of: "W" or "J"."""
    unit = str(array.attrs.get("units", "1"))
    if not is_light(array.name):
        return array
    check_timed(array.name, unit, of)
    return replace(array.times(amount), attrs={**array.attrs, "units": unit_of_light(unit, of)})


def _amount(name: str, value: Any, result: xr.Dataset) -> Any:
    """Returns a power or an energy: a number, or a DataArray over a dimension of the result."""
    import xarray as xr
    if not isinstance(value, xr.DataArray):
        return errors.above_zero(name, value)
    expected = "numbers > 0 over a dimension of the result: " + " ".join(map(str, result.dims))
    numbers = errors.array(name, value.values, "iuf", expected)
    if not set(value.dims) <= set(result.dims) or not (numbers > 0).all() or any(
            dim in value.coords and dim in result.coords and not np.array_equal(value[dim], result[dim]) for dim in value.dims):
        raise errors.refuse(name, value, expected)
    return value


def scale(result: xr.Dataset, *, power: Union[float, xr.DataArray, None] = None, energy: Union[float, xr.DataArray, None] = None) -> xr.Dataset:
    """Returns a result in watts or joules: all light, and its standard errors, times the power or the energy of the beam.

    A unit 1/cm2 becomes W/cm2 or J/cm2, and so on. Of a result with power, `A_rz` is absorbed power per volume [W/cm3], `phi_rz` is fluence
    rate, `Rd_r` is exitance and facets have irradiance [W/cm2]. Of a result with energy, arrays over time gates are in J/ps.
    Numbers of the scene, `lost`, `residue`, and means of what a detector has seen stay.

    Args:
        result: A Dataset of `run`, `read`, `sweep` or `merge`.
        power: Power of the beam, of several beams their sum [W]. A DataArray over a dimension of a sweep gives each row its own.
        energy: Energy of the beam in place of power [J].

    Returns:
        An xarray.Dataset. Its attribute `scaled` is the unit, W or J.

    Raises:
        InputError: Not one of power and energy is given, the result has been scaled, or has arrays over time and a power is given.

    Examples:
        >>> import xarray as xr
        >>> scale(xr.Dataset({"Rd_r": ("r", [2.0], {"units": "1/cm2"})}), power=0.1).Rd_r.attrs["units"]
        'W/cm2'
    """
    import xarray as xr
    if not isinstance(result, xr.Dataset) or "scaled" in result.attrs:
        raise errors.refuse("result", "scaled to " + result.attrs["scaled"] if isinstance(result, xr.Dataset) else result, "a Dataset of a run, which is not scaled")
    if (power is None) == (energy is None):
        raise errors.refuse("power", power, "a power or an energy, not both")
    of, amount = ("W", _amount("power", power, result)) if energy is None else ("J", _amount("energy", energy, result))
    scaled = result.copy()
    for name in map(str, result.data_vars):
        array = result[name]
        if is_light(name):
            unit = str(array.attrs.get("units", "1"))
            check_timed(name, unit, of)
            found = array * amount
            scaled[name] = found.transpose(*array.dims, ...).assign_attrs({**array.attrs, "units": unit_of_light(unit, of)})
    return scaled.assign_attrs(scaled=of)
