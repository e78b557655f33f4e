"""Tests sweeps that are killed or stopped in the middle and resumed, on 1 to 3 ranks. No row is lost or doubled: at the end
the files of all rows and the table have the bytes of an undisturbed sweep. On several ranks each flies rows of its own; a
signal to one of them stops all. Bytes and lines of --json are the same for any number of ranks. KILLS: number of kills
(4)."""
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM = os.environ["CLUSTERMCML"]
KILLS = int(os.environ.get("KILLS", "4"))
ROWS = 24
MPI = ["mpiexec", "--oversubscribe", "--bind-to", "none"] + ["--allow-run-as-root"] * (os.geteuid() == 0)


def launcher_of(ranks):
    return [*MPI, "-n", str(ranks)] if ranks > 1 else []


def start(folder, table, ranks, resume):
    command = [*launcher_of(ranks), PROGRAM, "samples/thick.mci", "--sweep", table, "--photons", "20000", "--threads", "1", "--quiet", "-o",
               folder, "--checkpoint", "0.1"] + ["--resume"] * resume
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)


def read(folder):
    """Returns {name: bytes without the time} of results; checkpoints are left out."""
    files = {}
    for name in os.listdir(folder):
        if "checkpoint" in name or name.endswith(".h5"):
            continue
        with open(os.path.join(folder, name), "rb") as file:
            files[name] = re.sub(rb"# User time.*\n", b"", file.read())
    return files


def rows_there(folder):
    return len([name for name in os.listdir(folder) if re.fullmatch(r"thick-\d{4}\.mco", name)])


def disturb(process, folder, dice):
    """Sends a signal when some more rows exist. Returns True if it was sent before the end."""
    goal = rows_there(folder) + dice.randrange(1, 6)
    while process.poll() is None and rows_there(folder) < min(goal, ROWS):
        time.sleep(0.002)
    if process.poll() is not None:
        return False
    if dice.random() < 0.7:
        os.killpg(process.pid, signal.SIGKILL)
    else:
        os.kill(process.pid, signal.SIGUSR2)
    return True


def check_few(root):
    """Tests two rows on three ranks, which fly each row together."""
    table = os.path.join(root, "two.csv")
    with open(table, "w", encoding="ascii") as file:
        file.write("layer1.g\n0.5\n0.9\n")
    found = []
    for ranks in (1, 3):
        folder = os.path.join(root, f"two{ranks}")
        os.mkdir(folder)
        start(folder, table, ranks, False).wait()
        found.append(read(folder))
    return [] if len(found[0]) == 3 and found[0] == found[1] else [f"two rows: {sorted(found[0])}, {sorted(found[1])}"]


def objects(root, table, ranks):
    """Returns (row, totals) of every line of --json, in the order of the lines."""
    folder = os.path.join(root, f"json{ranks}")
    os.mkdir(folder)
    command = [*launcher_of(ranks), PROGRAM, "samples/thick.mci", "--sweep", table, "--photons", "1000", "--threads", "1", "--json", "-o",
               folder]
    lines = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
    return [[json.loads(line)[key] for key in ("row", "Rd", "A", "Tt")] for line in lines]


def check_json(root, table):
    one, three = objects(root, table, 1), objects(root, table, 3)
    rows = [row for row, *_ in one]
    return [] if len(set(rows)) == ROWS and one == three else [f"--json: rows {rows}, on 3 ranks {[row for row, *_ in three]}"]


def main():
    dice, complaints, kills, lives = random.Random(1), [], 0, 0
    with tempfile.TemporaryDirectory() as root:
        table = os.path.join(root, "table.csv")
        with open(table, "w", encoding="ascii") as file:
            file.write("layer1.mua,seed\n" + "".join(f"{0.1 + 0.05 * i:.2f},{i % 3}\n" for i in range(ROWS)))
        plain = os.path.join(root, "plain")
        os.mkdir(plain)
        if start(plain, table, 1, False).wait():
            complaints.append("the sweep that nobody disturbs fails")
        expected = read(plain)
        if len(expected) != ROWS + 1 or any("checkpoint" in name for name in os.listdir(plain)):
            complaints.append(f"left {sorted(os.listdir(plain))}")
        shared = os.path.join(root, "shared")
        os.mkdir(shared)
        process = start(shared, table, 3, False)
        if process.wait() or read(shared) != expected:
            complaints.append(f"3 ranks: other bytes, {process.stderr.read()}")
        complaints += check_few(root) + check_json(root, table)
        while kills < KILLS and not complaints:
            folder = os.path.join(root, f"killed{kills}")
            os.mkdir(folder)
            resume = False
            while True:
                process = start(folder, table, dice.choice((1, 1, 3)), resume)
                disturbed = kills < KILLS and disturb(process, folder, dice)
                error, code, lives, resume = process.stderr.read(), process.wait(), lives + 1, True
                kills += disturbed
                if code == 0:
                    break
                if "locked by another process" in error:  # ranks outlive a killed mpiexec for a moment
                    time.sleep(0.05)
                    continue
                if not disturbed or (code not in (75, -signal.SIGKILL, 1) and "stopped with" not in error):
                    complaints.append(f"exit {code}: {error}")
                    break
            if not complaints and read(folder) != expected:
                complaints.append(f"other bytes after kills: {sorted(read(folder))}")
    print(f"{kills} kills in {lives} lives")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints else 0)


main()
