"""The examples in the texts of the Python package give what stands there, and the blocks of samples/python.md run, one after the
other."""
import contextlib
import doctest
import importlib
import io
import os
import pkgutil
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import TOP, mc as clustermcml  # noqa: E402



def run_text(path):
    """What the blocks of Python in a text print, run in an empty folder."""
    with open(path, encoding="utf-8") as file:
        blocks = re.findall(r"```python\n(.*?)```", file.read(), re.DOTALL)
    printed, names, here = io.StringIO(), {}, os.getcwd()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
        os.chdir(folder)
        try:
            for block in blocks:
                exec(block, names)
        finally:
            os.chdir(here)
    return printed.getvalue()


failed = tried = 0
for module in pkgutil.iter_modules(clustermcml.__path__, "clustermcml."):
    result = doctest.testmod(importlib.import_module(module.name))
    failed, tried = failed + result.failed, tried + result.attempted
said = run_text(os.path.join(TOP, "samples", "python.md"))
for expected in ("Rd = 0.", "middle of the light at x = 0.", "absorbed by the vessel: 0.", "Rd of the flat scene: 0.", "Layer.g = 1.9 (expected a number from -1 to 1)"):
    tried, failed = tried + 1, failed + (expected not in said)
    if expected not in said:
        print(f"python.md does not print {expected}:\n{said}")
print(f"{tried} examples, {failed} failed")
sys.exit(failed > 0 or tried == 0)
