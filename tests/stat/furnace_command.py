"""Tests the command `furnace` on all samples: in diffuse light without absorption each layer and body holds as much light as
its volume asks for.

Tested are turbid layers, turbid bodies and the light that leaves below. A wrong crossing, refraction, free path or volume
shows.
N = 1e4 packets a run; statistic: z of 63 degrees of freedom made normal, level 1e-4 over all.
usage: furnace_command.py [N]"""
import glob
import json
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402


def main():
    verdict = cml.Verdict("furnace_command")
    photons = sys.argv[1] if len(sys.argv) > 1 else "1e4"
    tested = 0
    for scene in sorted(glob.glob("samples/*.mci") + glob.glob("samples/shapes/*.mci")):
        done = subprocess.run([cml.PROGRAM, "furnace", scene, "--photons", photons, "--json", "--alpha", "1e-9"], capture_output=True,
                              text=True, check=False)
        refused = "a backing (expected none in a furnace" in done.stderr
        verdict.check(scene, done.returncode == (2 if refused else 0), done.stderr)
        for run in map(json.loads, done.stdout.splitlines()):
            for place in run["places"]:
                if place["untested"] is None:
                    verdict.z(f"{scene}: {place['name']}", place["ratio"], place["error"], 1)
                    tested += 1
    verdict.check("places", tested > 60, f"{tested} of all samples")
    verdict.finish(limit=4.9)  # 87 values at 1e-4 in all


main()
