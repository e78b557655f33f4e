"""What the tests of the Python package share: the package, from src/python, and the packages that it needs.

Where these are missing the test is skipped, with a word."""
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
