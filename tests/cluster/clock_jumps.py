"""Tests that jumps of the date do not disturb a run. The date jumps by an hour or a day, forwards and back again and again,
during runs on one process and on two ranks. Bytes and checkpoints stay the same, and progress and the time of flight are
those without jumps.

Shares with the program everything but the date. Standard library only."""
import os
import pty
import re
import subprocess
import sys
import tempfile

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
HOUR, DAY = 3600, 86400
PHOTONS = 200000


def bits(path):
    with open(path, "rb") as file:
        return b"".join(line for line in file if not line.startswith(b"# User time"))


def read_terminal(terminal):
    """Reads everything until the other side of the terminal is closed."""
    text = b""
    while True:
        try:
            block = os.read(terminal, 65536)
        except OSError:
            block = b""
        if not block:
            return text.decode()
        text += block


def run(folder, seconds, ranks):
    """Runs the program with a terminal as standard error. Returns the exit code and the terminal's text."""
    words = ["env", f"LD_PRELOAD={os.environ['FILE_FAULT']}:{os.environ['SYSTEM_FAULT']}", f"CML_CLOCK=jump {seconds}",
             f"CML_CLOCK_LOG={folder}/jumps", f"CML_FAULT_FOLDER={folder}/", f"CML_FAULT_LOG={folder}/calls", PROGRAM,
             "samples/thick.mci", "--photons", str(PHOTONS), "--threads", "1", "--checkpoint", "1e-9", "-o", folder]
    if ranks:
        words = ["mpiexec", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *words]
    mine, its = pty.openpty()
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=its) as process:
        os.close(its)
        shown = read_terminal(mine)
    os.close(mine)
    return process.returncode, shown


def check(folder, seconds, ranks, expected):
    code, shown = run(folder, seconds, ranks)
    if code:
        return [f"exit {code}: {shown}"]
    complaints = []
    result = os.path.join(folder, "thick.mco")
    with open(os.path.join(folder, "calls"), encoding="utf-8") as file:
        checkpoints = file.read().count("rename thick.mco.checkpoint\n")
    jumps = os.path.exists(os.path.join(folder, "jumps"))
    with open(result, encoding="utf-8") as file:
        took = float(re.search(r"# User time: *([-+.e0-9]+)", file.read()).group(1))
    bars = [tuple(map(float, bar)) for bar in re.findall(r"(\S+) % +(\S+) photons/s +\S+ \w+, (\S+) s left", shown)]
    shares = [share for share, _, _ in bars]
    if bits(result) != expected:
        complaints.append("other bytes")
    if checkpoints == 0 or (ranks and not jumps):  # a single process never asks for the date
        complaints.append(f"jumped: {jumps}, {checkpoints} checkpoints")
    if not 0 <= took < HOUR / 2:
        complaints.append(f"took {took} s")
    if ranks == 0 and (not bars or shares != sorted(shares) or shares[-1] != 100):
        complaints.append(f"progress: {shown}")
    if any(not speed > PHOTONS / (HOUR / 2) or not 0 <= left < HOUR / 2 for _, speed, left in bars):
        complaints.append(f"speed: {shown}")
    return complaints


def main():
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    complaints = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([PROGRAM, "samples/thick.mci", "--photons", str(PHOTONS), "--quiet", "-o", folder], check=True)
        expected = bits(os.path.join(folder, "thick.mco"))
    for seconds in (HOUR, -HOUR, DAY, -DAY):
        for ranks in (0, 2) if abs(seconds) == DAY else (0,):
            with tempfile.TemporaryDirectory() as folder:
                folder = os.path.realpath(folder)
                complaints += [f"{seconds} s, {ranks} ranks: {text}"
                               for text in check(folder, seconds, ranks, expected)]
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints else 0)


main()
