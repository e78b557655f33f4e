"""Tests that `plot` draws the numbers of a file: drawn_arrays.py FILE.h5. One array of each set of axes is drawn, or every array if the environment
has ALL_CASES.

SPDX-License-Identifier: MIT
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "python"))
import numpy as np  # noqa: E402
from clustermcml import plot, read  # noqa: E402

figures = []
plot.save = lambda figure, path: figures.append(figure)


def shown(array):
    """Returns the part of an array that `plot` draws. Maps and voxels are cut, bins of light beyond the grid are left out, and r points to the
    right."""
    if "z_volume" in array.dims:
        array = array.sel(y=0, method="nearest")
    elif array.ndim == 3:
        array = array.sel(alpha=0.3, method="nearest")
    array = array.isel({dim: slice(0, -1) for dim in array.dims if dim in ("r", "z")})
    return array.T.values if array.dims[0] in ("r", "body", "layer") else array.values


ALL = "ALL_CASES" in os.environ
path, drawn = sys.argv[1], set()
for name, array in read(path).data_vars.items():
    if not array.dims or name.startswith(("layer_", "body_of")) or name.endswith("area"):
        continue
    if array.dims in drawn and name != "boundary0_irradiance_above" and not ALL:
        continue
    cut = ["--cut", "alpha=0.3"] if "alpha" in array.dims and array.ndim == 3 else []
    assert plot.main([path, "--of", name, "--linear", "--quiet", *cut]) == 0, name
    axes, numbers = figures.pop().axes[0], shown(array)
    if str(array.dims[0]).endswith("facet") or array.dims == ("theta", "phi"):
        assert axes.collections, name
        if name == "boundary0_irradiance_above":  # facets of a cone have equal numbers; only the light from one side tells them apart
            assert len(np.unique(axes.collections[0].get_facecolor(), axis=0)) > 2 * len(np.unique(array)), name
    else:
        found = np.asarray(axes.images[0].get_array()) if numbers.ndim == 2 else axes.lines[0].get_ydata()
        assert np.allclose(found, numbers, equal_nan=True), name
    drawn.add(array.dims)
assert len(drawn) > 12, drawn
