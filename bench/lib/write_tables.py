"""Writes the tables of all READMEs of the benches anew from stored results: write_tables.py [--check]. With --check, nothing is written, and the
exit code is 1 if a table is not what its command writes. Runs in any folder.

SPDX-License-Identifier: MIT
"""
import os
import shutil
import subprocess
import sys
import tempfile

import tables

BENCH = tables.BENCH
SPEED, PARTS = "speed/results/speed-amd-epyc-2core.csv", "parts/results/parts-intel-xeon-2core.txt"
# by folder: scripts with their arguments, to which the README is appended; a result alone is put into the README unchanged
COMMANDS = {
    "speed": (["speed/results.py", SPEED], ["speed/results.py", "--irregular", SPEED]),
    "accuracy": (["accuracy/accuracy_table.py", "accuracy/results/accuracy-amd-epyc-2core.csv"],
                 ["accuracy/frontier_table.py", "accuracy/results/frontier-amd-epyc-2core.csv"],
                 ["accuracy/results/roughness.md"], ["accuracy/results/unbiased.md"]),
    "stability": (["stability/atlas.py", "--readme"],),
    "peers": (["peers/mmc.py", "--readme", "peers/results/mmc-amd-epyc-2core.md"], ["peers/results/vessel-intel-xeon-2core.md"],
              ["peers/results/peers-shared-amd-epyc-2core.md"], ["peers/results/rough_faces.md"],
              ["peers/results/appearance.md"]),
    "choices": tuple(["choices/results/" + name] for name in ("roulette.md", "aim.md", "lattice.csv", "lights.md", "lattice-tried.csv")),
    "parts": (["parts/limits.py", "parts/results/speed-intel-xeon-2core.csv", PARTS], ["parts/gpu_static.py", "--readme", "parts/results/gpu-static.csv"],
              ["parts/results/lanes.csv"]),
    "": (["lib/answers.py"],),
}


def full(words):
    """Returns the words of a command with absolute paths. A result alone is put into the README by lib/tables.py."""
    script = [] if words[0].endswith(".py") else ["lib/tables.py"]
    return [os.path.join(BENCH, word) if "/" in word else word for word in script + words]


def write(folder, readme):
    for words in COMMANDS[folder]:
        done = subprocess.run([sys.executable, "-B", *full(words), readme], stdout=subprocess.DEVNULL, check=False)
        if done.returncode:
            sys.exit("%s failed for %s" % (" ".join(words), readme))


def is_written(folder, readme):
    """True if writing changes nothing."""
    with tempfile.TemporaryDirectory() as work:
        copy = shutil.copy(readme, work)
        write(folder, copy)
        with open(readme, encoding="utf-8") as ours, open(copy, encoding="utf-8") as fresh:
            return ours.read() == fresh.read()


def main():
    wrong = []
    for folder in COMMANDS:
        readme = os.path.join(BENCH, folder, "README.md")
        if sys.argv[1:] != ["--check"]:
            write(folder, readme)
        elif not is_written(folder, readme):
            wrong.append(readme)
            print("%s: tables are not what `python3 bench/lib/write_tables.py` writes" % os.path.relpath(readme))
    sys.exit(1 if wrong else 0)


main()
