"""Tests that examples in the docstrings of the package give the results that stand there, and that the cells of samples/notebook.ipynb run in
order.

Cells that draw run if matplotlib is installed, as does samples/rough_pictures.py. Differences that the notebook's pictures show must be larger than
5 standard errors."""
import contextlib
import doctest
import importlib
import importlib.util
import io
import json
import os
import pkgutil
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import svg_text  # noqa: E402
from python_package import TOP, mc as clustermcml, np  # noqa: E402


def cells_of(path):
    """Returns the Python cells of a notebook. Without matplotlib, lines that draw are left out."""
    with open(path, encoding="utf-8") as file:
        cells = ["".join(cell["source"]) for cell in json.load(file)["cells"] if cell["cell_type"] == "code"]
    drawn = importlib.util.find_spec("matplotlib") is not None
    return [cell if drawn else re.sub(r"(?m)^.*(\.plot\(|\bplt\b).*$", "", cell) for cell in cells]


def run_notebook():
    """Runs the cells of the notebook in an empty folder. Returns their variables."""
    cells = cells_of(os.path.join(TOP, "samples", "notebook.ipynb"))
    names, here = {}, os.getcwd()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        os.chdir(folder)
        try:
            for cell in cells:
                exec(cell, names)
        finally:
            os.chdir(here)
    return names


def effects(names):
    """Returns {claim of a picture in the notebook: its smallest difference, in standard errors}."""
    across, spectrum, far = names["across"], names["spectrum"].sortby("wavelength"), abs(names["far"])
    bright, dark = (across.isel(x=int(pick(across.Rd_xy.values))) for pick in (np.argmax, np.argmin))
    steps = abs(spectrum.Rd.diff("wavelength")) / np.hypot(spectrum.Rd_se[1:], spectrum.Rd_se[:-1].values)
    return {
        "furrows": float((bright.Rd_xy - dark.Rd_xy) / np.hypot(bright.Rd_xy_se, dark.Rd_xy_se)),
        "horizon": float(names["more"].min()),
        "spectrum": float(steps.min()),
        "heights": float(far.sel({"beam.angle": [30, 60]}).min()),
    }


def rough_pictures():
    """Returns the faults of the pictures that samples/rough_pictures.py draws."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, os.path.join(TOP, "samples", "rough_pictures.py"), folder, "1e3"], capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": os.path.join(TOP, "src", "python")})
        if done.returncode or len(os.listdir(folder)) != 3:
            return [f"rough_pictures.py: exit code {done.returncode}, {os.listdir(folder)}: {done.stderr}"]
        return [f"{name}: {fault}" for name in os.listdir(folder)
                for fault in svg_text.faults_of(svg_text.tree.parse(os.path.join(folder, name)).getroot())[0]]


failed = tried = 0
for module in pkgutil.iter_modules(clustermcml.__path__, "clustermcml."):
    result = doctest.testmod(importlib.import_module(module.name))
    failed, tried = failed + result.failed, tried + result.attempted
for shown, errors in effects(run_notebook()).items():
    tried, failed = tried + 1, failed + (not errors > 5)
    if not errors > 5:
        print(f"notebook.ipynb, {shown}: a difference of {errors:.1f} standard errors (expected more than 5)")
if importlib.util.find_spec("matplotlib"):
    tried, faults = tried + 1, rough_pictures()
    failed += bool(faults)
    print(*faults, sep="\n", end="\n" if faults else "")
print(f"{tried} examples, {failed} failed")
sys.exit(failed > 0 or tried == 0)
