"""The examples in the texts of the Python package give what stands there, and the blocks of samples/python.md and the cells of
samples/notebook.ipynb run, one after the other; those that draw, where matplotlib is installed, and samples/rough_pictures.py there, too. Differences that the notebook's
pictures show are larger than 5 standard errors."""
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


def blocks_of(path):
    """The Python in a text or a notebook."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if not path.endswith(".ipynb"):
        return re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    cells = ["".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    drawn = importlib.util.find_spec("matplotlib") is not None
    return [cell if drawn else re.sub(r"(?m)^.*(\.plot\(|\bplt\b).*$", "", cell) for cell in cells]


def run_text(path):
    """Runs the blocks of a text in an empty folder. Returns what the blocks print, and their variables."""
    blocks = blocks_of(path)
    printed, names, here = io.StringIO(), {}, os.getcwd()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
        os.chdir(folder)
        try:
            for block in blocks:
                exec(block, names)
        finally:
            os.chdir(here)
    return printed.getvalue(), names


def effects(names):
    """{what a picture of the notebook shows: its smallest difference, in standard errors}."""
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
    """What is wrong with the pictures that samples/rough_pictures.py draws."""
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
(printed, _), (told, names) = (run_text(os.path.join(TOP, "samples", name)) for name in ("python.md", "notebook.ipynb"))
said = printed + told
for shown, errors in effects(names).items():
    tried, failed = tried + 1, failed + (not errors > 5)
    if not errors > 5:
        print(f"notebook.ipynb, {shown}: a difference of {errors:.1f} standard errors (expected more than 5)")
for expected in ("Rd = 0.", "mesh because", "the same skin, flat: Rd = 0.", "Rd at 500 nm: 0.", "middle of the light at x = 0.", "absorbed by the vessel: 0.", "Rd of the flat scene: 0.", "Layer.g = 1.9 (expected a number from -1 to 1)"):
    tried, failed = tried + 1, failed + (expected not in said)
    if expected not in said:
        print(f"samples do not print {expected}:\n{said}")
if importlib.util.find_spec("matplotlib"):
    tried, faults = tried + 1, rough_pictures()
    failed += bool(faults)
    print(*faults, sep="\n", end="\n" if faults else "")
print(f"{tried} examples, {failed} failed")
sys.exit(failed > 0 or tried == 0)
