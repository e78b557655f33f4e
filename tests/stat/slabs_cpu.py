"""Tests slabs and stacks against adding-doubling (see lib/slabs.py): cpu engine, 200000 packets, every 6th row of the table."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import slabs  # noqa: E402

slabs.run_all("cpu", 200000, 6)
