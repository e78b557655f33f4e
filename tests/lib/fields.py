"""What the tests of .h5, .vti and .vtp files share: the readers, which are Debian packages, and reading itself.

Where they are missing the test is skipped, with a word; samples/packages.sh test installs them."""
import sys

try:
    import h5py
    import numpy
    import vtk
    import xarray
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as reason:
    print(f"skipped: {reason} (sh samples/packages.sh test installs it)")
    sys.exit(77)

__all__ = ["h5py", "numpy", "vtk", "xarray", "read_vtk", "arrays_of"]


def read_vtk(path):
    """The data set of a .vti or .vtp file; VTK's own complaints are errors."""
    reader = vtk.vtkXMLImageDataReader() if path.endswith(".vti") else vtk.vtkXMLPolyDataReader()
    complaints = []
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append("error"))
    reader.AddObserver("WarningEvent", lambda *_: complaints.append("warning"))
    if not reader.CanReadFile(path):
        raise RuntimeError(f"{path}: VTK cannot read it")
    reader.SetFileName(path)
    reader.Update()
    if complaints:
        raise RuntimeError(f"{path}: VTK complains")
    return reader.GetOutput()


def arrays_of(data):
    """{name: numpy array} of the cell data."""
    cells = data.GetCellData()
    return {cells.GetArrayName(i): vtk_to_numpy(cells.GetArray(i)) for i in range(cells.GetNumberOfArrays())}
