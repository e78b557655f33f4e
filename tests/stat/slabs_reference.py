"""Tests slabs and stacks against adding-doubling (see lib/slabs.py): reference engine, 20000 packets, every 12th row."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import slabs  # noqa: E402

slabs.run_all("reference", 20000, 12)
