"""Tests the rate of false alarms of compare over many pairs, scenes and sizes. See tests/lib/pairs.py."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import pairs  # noqa: E402

verdict = cml.Verdict("compare.long")
for scene in pairs.SCENES:
    for photons in ((1000, 1000), (10000, 10000), (100000, 100000), (1000, 100000)):
        pairs.false_alarms(verdict, scene, photons, 400)
pairs.false_alarms_of_arrays(verdict, 20000, 100)
pairs.power(verdict, 10000000)
verdict.finish()
