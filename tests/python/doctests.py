"""The examples in the texts of the Python package give what stands there."""
import doctest
import importlib
import os
import pkgutil
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "python"))
try:
    import clustermcml
except ImportError as error:
    print(error)
    sys.exit(77)

failed = tried = 0
for module in pkgutil.iter_modules(clustermcml.__path__, "clustermcml."):
    result = doctest.testmod(importlib.import_module(module.name))
    failed, tried = failed + result.failed, tried + result.attempted
print(f"{tried} examples, {failed} failed")
sys.exit(failed > 0 or tried == 0)
