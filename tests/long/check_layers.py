"""Tests that `check` takes time linear in the number of layers: callgrind counts its instructions with 800, 1600 and 3200
layers.

Adding-doubling is left out for so many layers. The second step from one number to the next costs twice the first one if time
is linear, and four times if every layer looks at all others. Instructions are the same on any machine, however busy. Skipped
without valgrind.
SPDX-License-Identifier: MIT"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
MOST = 3  # limit of the second step, in units of the first


def instructions(layers: int, folder: str) -> int:
    """Returns the number of instructions that `check` of so many layers executes."""
    path = os.path.join(folder, f"{layers}.mci")
    with open(path, "w", encoding="ascii") as file:
        file.write(f"1.0\n1\nx.mco A\n1000\n0.01 0.01\n20 20 3\n{layers}\n1.0\n" + "1.4 0.1 10 0.8 0.001\n" * layers + "1.0\n")
    run = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", PROGRAM, "check", path],
                         capture_output=True, text=True, check=True)
    return int(re.search(r"Collected : (\d+)", run.stderr)[1])


def main() -> int:
    """Returns 1 if the second step costs too much."""
    if not shutil.which("valgrind"):
        return 77
    with tempfile.TemporaryDirectory() as folder:
        few, some, many = (instructions(layers, folder) for layers in (800, 1600, 3200))
    times = (many - some) / (some - few)
    print(f"800, 1600, 3200 layers: {few:.3g}, {some:.3g}, {many:.3g} instructions; second step {times:.2f} times the first")
    return int(times > MOST)


if __name__ == "__main__":
    sys.exit(main())
