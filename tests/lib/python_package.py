"""Puts src/python on the path of the tests of the Python package, and imports the package with all packages that it needs.

If a package is missing, the test is skipped with a message."""
import os
import sys

TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(TOP, "src", "python"))
try:
    import h5py
    import numpy as np
    import xarray as xr
except ImportError as error:
    print(error)
    sys.exit(77)
import clustermcml as mc  # noqa: E402

__all__ = ["TOP", "h5py", "np", "xr", "mc"]
