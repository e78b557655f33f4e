"""Tests parts of one run (--part), flown on 1 and 2 ranks, killed and resumed, then joined: every file has the bytes of one
run.

All outputs are on: profiles, times, directions, fluence, maps, voxels, facets, bodies, detectors, saved packets, and the
command line. The rows of a sweep and their tables are tested likewise. KILLS: least number of kills (8)."""
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM = os.path.abspath(os.environ["CLUSTERMCML"])
KILLS = int(os.environ.get("KILLS", "8"))
MPI = ["mpiexec", "--oversubscribe", "--bind-to", "none"] + ["--allow-run-as-root"] * (os.geteuid() == 0)
SCENE = """1.0
1
all.mco A
60001
0.02 0.02
5 5 3
time 100 20
directions 5 6
fluence
map 5 4 0.02 0.02 volume top=-0.01
facets
{saved}detector map 4 4 0.1 0.1 name=seen
detector disk 0.3 na=0.5
1
1
b 3  0.06 0.1  0.02 0.2  0 1
1.4 1 50 0.8 0.1
i sphere 0 0 0.05 0.01  1.4 1 50 0.8
1
"""
SWEEP = ["scene.mci", "--sweep", "table.csv", "--photons", "1001"]
dice = random.Random(56)


def start(folder, words, ranks=1):
    launcher = [*MPI, "-n", str(ranks)] if ranks > 1 else []
    return subprocess.Popen([*launcher, PROGRAM, *words, "--threads", "1", "--quiet", "--checkpoint", "0.02"], cwd=folder,
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)


def fly(folder, words, ranks=1):
    process = start(folder, words, ranks)
    error = process.communicate()[1]
    if process.returncode:
        raise SystemExit(f"FAILED {words}: exit {process.returncode}: {error}")


def make(folder, saved):
    os.mkdir(folder)
    with open(os.path.join(folder, "scene.mci"), "w", encoding="ascii") as file:
        file.write(SCENE.format(saved='photons "saved" limit=700\n' if saved else ""))
    with open(os.path.join(folder, "table.csv"), "w", encoding="ascii") as file:
        file.write("layer1.mua,seed\n1,3\n2,4\n3,5\n")


def files(folder):
    found = {}
    for name in os.listdir(folder):
        if re.search(r"\.part\d+of\d+$|\.mci$|table\.csv$", name):
            continue
        with open(os.path.join(folder, name), "rb") as file:
            found[name] = re.sub(rb"# User time.*\n", b"", file.read())
    return found


def differences(name, folder, expected):
    found = files(folder)
    bad = [file for file in sorted(set(found) | set(expected)) if found.get(file) != expected.get(file)]
    return [f"{name}: {bad} differ"] if bad else []


def fly_killed(folder, part):
    """Flies a part to its end through kills. Returns their number."""
    kills, lives = 0, 0
    while True:
        lives += 1
        process = start(folder, ["scene.mci", "--part", part, "--resume"], dice.choice((1, 2)))
        path = os.path.join(folder, "all.mco.part" + part.replace("/", "of"))
        if lives < 3:  # when there is a checkpoint, or a new one
            before = os.path.exists(path) and os.stat(path).st_mtime_ns
            while process.poll() is None and (os.path.exists(path) and os.stat(path).st_mtime_ns) == before:
                time.sleep(0.002)
            time.sleep(dice.uniform(0, 0.02))
            if process.poll() is None:
                kills += 1
                if dice.random() < 0.6:
                    os.killpg(process.pid, signal.SIGKILL)
                else:
                    os.kill(process.pid, signal.SIGUSR2)
        error, code = process.communicate()[1], process.returncode
        if code == 0:
            return kills
        if "locked by another process" in error:  # ranks outlive a killed mpiexec for a moment
            time.sleep(0.05)
        elif code not in (75, -signal.SIGKILL, -signal.SIGUSR2, 1):  # the exit code of a launcher that is about to end
            raise SystemExit(f"FAILED part {part}: exit {code}: {error}")


def main():
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMP_WAIT_POLICY="passive")
    hdf5 = "HDF5 yes" in subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
    complaints, kills, round_ = [], 0, 0
    with tempfile.TemporaryDirectory() as root:
        one, rows = os.path.join(root, "one"), os.path.join(root, "rows")
        make(one, hdf5)
        make(rows, hdf5)
        fly(one, ["scene.mci"])
        fly(rows, SWEEP)
        expected, expected_rows = files(one), files(rows)
        if len(expected) != (8 if hdf5 else 6) or len(expected_rows) != 3 * len(expected) + 1 + hdf5:
            complaints.append(f"left {sorted(expected)}, {sorted(expected_rows)}")
        while not complaints and (round_ == 0 or kills < KILLS):
            for count in (2, 3, 7):
                folder = os.path.join(root, f"parts{count}_{round_}")
                make(folder, hdf5)
                for k in dice.sample(range(1, count + 1), count):
                    kills += fly_killed(folder, f"{k}/{count}")
                if "all.mco" in files(folder):
                    complaints.append(f"{count} parts: a part wrote a result")
                subprocess.run([PROGRAM, "merge", "--quiet", *sorted(name for name in os.listdir(folder) if ".part" in name)], cwd=folder, check=True)
                complaints += differences(f"{count} parts", folder, expected)
            round_ += 1
        folder = os.path.join(root, "parts_of_rows")
        make(folder, hdf5)
        for k in (2, 1):
            fly(folder, [*SWEEP, "--part", f"{k}/2"], 2)
        subprocess.run([PROGRAM, "merge", "--quiet", *sorted(name for name in os.listdir(folder) if ".part" in name)], cwd=folder, check=True)
        complaints += differences("rows", folder, expected_rows)
    print(f"{kills} kills")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints else 0)


main()
