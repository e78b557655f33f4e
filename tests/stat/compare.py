"""Tests the rate of false alarms and the power of compare, with few pairs; long.compare has many. See tests/lib/pairs.py."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import pairs  # noqa: E402

verdict = cml.Verdict("compare")
pairs.false_alarms(verdict, "thin", (5000, 5000), 12)
pairs.false_alarms(verdict, "dark", (2000, 20000), 8)
pairs.false_alarms_of_arrays(verdict, 10000, 4)
pairs.power(verdict, 1000000)
verdict.finish()
