#!/usr/bin/env python3
"""Makes a profile of skin with its three fits: skin_profile.py [DIR] [ERROR]

Simulates light skin of samples/materials.py at 610 nm, and leaves skin_profile.json, skin_profile.csv and a picture skin_profile.svg in DIR, by
default the current directory. ERROR is the noise of the profile, by default 0.01. The script needs the same packages as materials.py.

SPDX-License-Identifier: MIT
"""
import os
import sys

import clustermcml as mc
from materials import MATERIALS


def main(folder, error):
    skin = next(material for material in MATERIALS if material.name == "skin_light").scene()
    profile = mc.profile(skin, target_error=error)
    stem = os.path.join(folder, "skin_profile")
    profile.to_json(stem + ".json")
    profile.to_csv(stem + ".csv")
    profile.plot(stem + ".svg")
    print(f"Rd {float(profile.Rd):.4f} +- {float(profile.Rd_se):.4f}, mean r {10 * float(profile.mean_r):.3f} mm, noise {float(profile.noise):.4f}")
    for kind in ("exponentials", "gaussians", "burley", "openpbr"):
        print(f"{kind}: L1 {float(profile.fit(kind).L1):.4f}")
    print(stem + ".svg")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ".", float(sys.argv[2]) if len(sys.argv) > 2 else 0.01)
