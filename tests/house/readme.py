"""The tables of bench/README.md are what their commands print from the results in bench/results. Runs in the source directory."""
import os
import shutil
import subprocess
import sys
import tempfile

README = "bench/README.md"
RESULTS = "bench/results/"
COMMANDS = (["bench/results.py", RESULTS + "intel-xeon-2core.csv"],
            ["bench/results.py", "--irregular", RESULTS + "intel-xeon-2core.csv"],
            ["bench/accuracy_table.py", RESULTS + "accuracy-amd-epyc-2core.csv"],
            ["bench/mmc.py", "--readme", RESULTS + "mmc-intel-xeon-2core.md"],
            ["bench/frontier_table.py", RESULTS + "frontier-intel-xeon-2core.csv"],
            ["bench/limits.py", RESULTS + "intel-xeon-2core.csv", RESULTS + "parts-intel-xeon-2core.txt"],
            ["bench/gpu_static.py", "--readme", RESULTS + "gpu-static.csv"],
            ["bench/atlas_table.py", "--readme"])

failed = False
with open(README, encoding="utf-8") as file:
    ours = file.read()
with tempfile.TemporaryDirectory() as directory:
    for command in COMMANDS:
        copy = os.path.join(directory, "README.md")
        shutil.copy(README, copy)
        subprocess.run([sys.executable, "-B", *command, copy], check=True, stdout=subprocess.DEVNULL)
        with open(copy, encoding="utf-8") as file:
            if file.read() != ours:
                print("%s is not what `python3 %s %s` writes" % (README, " ".join(command), README))
                failed = True
sys.exit(1 if failed else 0)
