"""The tables of README are what their commands print from the results in bench/results. Runs in the source directory."""
import os
import shutil
import subprocess
import sys
import tempfile

RESULTS = "bench/results/"
COMMANDS = (["bench/results.py", RESULTS + "amd-epyc-2core.csv"],
            ["bench/accuracy_table.py", RESULTS + "accuracy-amd-epyc-2core.csv"],
            ["bench/mmc.py", "--readme", RESULTS + "mmc-amd-epyc-2core.md"],
            ["bench/atlas_table.py", "--readme"])

failed = False
with open("README.md", encoding="utf-8") as file:
    ours = file.read()
with tempfile.TemporaryDirectory() as directory:
    for command in COMMANDS:
        copy = os.path.join(directory, "README.md")
        shutil.copy("README.md", copy)
        subprocess.run([sys.executable, "-B", *command, copy], check=True, stdout=subprocess.DEVNULL)
        with open(copy, encoding="utf-8") as file:
            if file.read() != ours:
                print("README.md is not what `python3 %s README.md` writes" % " ".join(command))
                failed = True
sys.exit(1 if failed else 0)
