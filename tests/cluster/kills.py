"""Tests random kills (KILLS of them, or 20), each resumed on another number of ranks and threads: the bytes at the end are
the same.

SIGTERM goes to the program, to one rank or to mpiexec, SIGUSR2 to mpiexec, SIGKILL to one rank or to mpiexec, sometimes in
the middle of starting. If the program itself decides on the exit code, it must be 75."""
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PROGRAM = os.environ.get("CLUSTERMCML", "build/clustermcml")
SCENE = ["", "--photons", "7e5", "--seed", "7"]
SHAPES = [(0, 1), (0, 2), (0, 1), (0, 2), (1, 1), (2, 1), (3, 1), (4, 1), (2, 2)]  # ranks (0: no mpiexec), threads
KILLS = int(os.environ.get("KILLS", "20"))
dice = random.Random(20)


def timed_scene(folder):
    """Writes thick.mci in FOLDER: samples/thick.mci with gates of time, directions, fluence and a rough top."""
    path = os.path.join(folder, "thick.mci")
    with open("samples/thick.mci", encoding="utf-8") as sample, open(path, "w", encoding="utf-8") as scene:
        scene.write(sample.read().replace("\n1                       # layers", "\ntime 3000 30\ndirections 9 12\nfluence\ndetector disk 0.3 na=0.5\n1                       # layers")
                    .replace("\n1.4 ", "\nrough beckmann 0.5\n1.4 "))
    return path


def bits(folder):
    """Returns the .mco without its time, and all arrays of the .h5 beside it, whose command lines differ."""
    with open(os.path.join(folder, "thick.mco"), "rb") as file:
        return b"".join(line for line in file if not line.startswith(b"# User time")), repr(cml.read_h5(os.path.join(folder, "thick.h5")))


def remove(folder):
    for name in ("thick.mco", "thick.h5"):
        os.remove(os.path.join(folder, name))


def start(folder, shape, resume):
    ranks, threads = shape
    launcher = ["mpiexec", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks else []
    command = [*launcher, PROGRAM, *SCENE, "--threads", str(threads), "-o", folder, "--checkpoint", "0.1"]
    return subprocess.Popen(command + ["--resume"] * resume, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def children(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return [int(word) for word in file.read().split()]


def victims(process, ranks):
    """Returns (process, signal, True if the program then decides on the exit code)."""
    if not ranks:
        return [(process.pid, signal.SIGTERM, True), (process.pid, signal.SIGKILL, False)]
    if dice.random() < 0.2:  # mpiexec takes two seconds to end
        return [(process.pid, signal.SIGTERM, False), (process.pid, signal.SIGUSR2, True)]
    one = dice.choice(children(process.pid) or [process.pid])
    return [(one, signal.SIGTERM, one != process.pid), (one, signal.SIGTERM, one != process.pid),
            (one, signal.SIGKILL, False), (process.pid, signal.SIGKILL, False)]


def wait_for_flight(process):
    for line in process.stdout:
        if line.startswith("  boundary 1"):
            return


def gone(pids):
    """Waits for ranks whose launcher was killed; they end by themselves."""
    for _ in range(600):
        if not any(os.path.exists(f"/proc/{pid}") and "clustermcml" in open(f"/proc/{pid}/cmdline").read()
                   for pid in pids):
            return True
        time.sleep(0.05)
    return False


def one_life(folder, shape, resume, complaints):
    """Starts, kills and waits. Returns (True if the run came to its end, True if it was killed)."""
    process = start(folder, shape, resume)
    flying = dice.random() < 0.85
    if flying:
        wait_for_flight(process)
    time.sleep(dice.uniform(0.02, 0.3))
    pids, killed = [], False
    if process.poll() is None:
        pids = children(process.pid) if shape[0] else []
        pid, number, decides = dice.choice(victims(process, shape[0]))
        try:
            os.kill(pid, number)
            killed = True
        except ProcessLookupError:
            pass
    _, errors = process.communicate()
    if killed and flying and decides and process.returncode not in (0, 75):
        complaints.append(f"{shape}, signal {number}: exit {process.returncode}: {errors}")
    if not killed and process.returncode != 0:
        complaints.append(f"{shape}: exit {process.returncode} without a kill: {errors}")
    if "refused" in errors or "of another run" in errors or "no older one" in errors:
        complaints.append(errors)
    if not gone(pids):
        complaints.append(f"{shape}: ranks outlive their launcher")
    return process.returncode == 0, killed and process.returncode != 0


def main():
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMP_WAIT_POLICY="passive")
    complaints, kills, ends, lives = [], 0, 0, 0
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as scenes:
        SCENE[0] = timed_scene(scenes)
        subprocess.run([PROGRAM, *SCENE, "--quiet", "-o", folder, "--checkpoint", "off"], check=True)
        expected, resume = bits(folder), False
        assert all(f"'{name}'" in expected[1] for name in ("Rd_t_se", "Rsp_dir_se", "phi_rz_se", "detector_1_t_se"))
        remove(folder)
        while (kills < KILLS or resume) and not complaints:
            shape = dice.choice(SHAPES)
            ended, killed = one_life(folder, shape, resume, complaints) if kills < KILLS else \
                (start(folder, shape, True).wait() == 0, False)
            kills, lives, resume = kills + killed, lives + 1, not ended
            if ended:
                ends += 1
                left = sorted(os.listdir(folder))
                if bits(folder) != expected:
                    complaints.append(f"{shape}: other bits at the end")
                if left != ["thick.h5", "thick.mco", "thick.mco.checkpoint"]:  # --resume leaves a checkpoint that says: finished
                    complaints.append(f"{shape}: left {left}")
                remove(folder)
    print(f"{kills} kills in {lives} lives, {ends} runs came to their end")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints or kills < KILLS or ends < 1 else 0)


main()
