"""Tests that SIGKILL at any moment never spoils a result.

SIGKILL is aimed at every kind of call (open, write, fsync, close, rename, link, unlink) on every file of a run: before the
first such call, after the last one, and in the middle of a write, with an older result in the folder or without. A file under
a final name must be whole, old or new. --resume on other threads or ranks, or a run from the beginning, must give the bytes
of an undisturbed run, and no other file.
Every third of these kills is tried, and all if the environment has ALL_CASES.

Shares with the program everything but the kill. Standard library only."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from file_faults import Folder, fault  # noqa: E402

SIGKILL = -9


def aims(folder):
    """Yields (call, which, action, file)."""
    for (call, name), count in folder.occurrences().items():
        yield call, 1, "before", name
        yield call, count, "after", name
        if call == "write":
            yield call, (count + 1) // 2, "half", name


def end(folder, number):
    """Continues what a killed run left: mostly by --resume, sometimes from the beginning, sometimes on ranks."""
    if number % 8 == 7:
        for name in os.listdir(folder.path):
            if ".checkpoint" in name and not name.endswith(".tmp"):
                os.remove(os.path.join(folder.path, name))
    ranks = 2 if number % 24 == 3 else 0
    return folder.run(threads=1 + number % 3, ranks=ranks)


def kill(folder, number, aim, ranks=0):
    """Kills one run and returns complaints about what follows."""
    complaints = []
    folder.clear(older=number % 2 == 0)
    call, n, action, name = aim
    done = folder.run(fault(call, n, action, name), ranks=ranks)
    if ranks == 0 and done.returncode != SIGKILL:
        complaints.append(f"exit {done.returncode} instead of the kill: {done.stderr}")
    if ranks and done.returncode == 0:
        complaints.append("exit 0 instead of the kill")
    complaints += [f"{wrong} is neither old nor new" for wrong in folder.wrong_files([folder.older, folder.expected])]
    done = end(folder, number)
    if done.returncode or "damaged" in done.stderr:
        complaints.append(f"goes on with exit {done.returncode}: {done.stderr}")
    left = folder.read()
    complaints += [f"{other} is left" for other in sorted(left.keys() - folder.expected.keys())]
    complaints += [f"{other} has other bytes" for other in folder.expected if left.get(other) != folder.expected[other]]
    return [f"{call} {name} {n} {action}: {complaint}" for complaint in complaints]


def main():
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    complaints, number = [], 0
    with Folder() as folder:
        for aim in list(aims(folder))[::1 if "ALL_CASES" in os.environ else 3]:
            complaints += kill(folder, number, aim)
            number += 1
        for aim in [("rename", 1, "before", "skinmap.h5"), ("write", 3, "half", "skinmap.volume.vti.tmp")]:
            complaints += kill(folder, number, aim, ranks=2)
            number += 1
    print(f"{number} kills")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints or number < 15 else 0)


main()
