"""Tests that a failing file system never loses or spoils a result.

Every kind of call (open, write, fsync, close, rename, link, unlink) on every file of a run fails once, the first or the last
one, with an older result in the folder or without. If a result cannot be written, the exit code is 5 and one line names the
file; existing files stay, no half-written file appears, and --resume gives the bytes of the run without faults. A checkpoint
that cannot be written is noted, and the run goes on. Short writes are no failure.
Every third of these failures is tried, and all if the environment has ALL_CASES.

Shares with the program everything but the fault. Standard library only."""
import errno
import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from file_faults import NAMES, Folder, fault  # noqa: E402

REASONS = {"open": ["ENOSPC", "EROFS", "ENOENT", "EINTR"], "write": ["EIO", "ENOSPC", "short", "EINTR"],
           "fsync": ["EIO", "EINTR"], "close": ["EIO"], "rename": ["EIO", "EROFS", "ENOENT", "ENOSPC"],
           "link": ["EPERM", "EEXIST"], "unlink": ["EROFS"]}


def aims(folder):
    """Returns a list of (call, which, reason, file). Reasons take turns."""
    turn = 0
    for (call, name), count in folder.occurrences().items():
        for n in sorted({1, count}):
            yield call, n, REASONS[call][turn % len(REASONS[call])], name
            turn += 1


def subject(folder, call, n, name):
    """Returns the name of the file that a call is for. A sync of the folder after a rename is for the renamed file."""
    if name != ".":
        return name
    place = [i for i, made in enumerate(folder.calls) if made == (call, name)][n - 1]
    return [renamed for made, renamed in folder.calls[:place] if made == "rename"][-1]


def wanted_code(folder, call, n, reason, name):
    """Returns the expected exit code. Failing checkpoints do not end a run. Neither do files that cannot be removed, nor
    closing files without content: the lock, the two files that test if the folder is writable, and the folder."""
    tries = call == "close" and (name in (".", "skinmap.lock") or (n == 1 and ("unlink", name) in folder.calls))
    helps = ".checkpoint" in subject(folder, call, n, name) or call == "unlink"
    return 0 if helps or tries or reason == "short" else 5


def check_words(folder, code, reason, name, err):
    """Returns complaints about the messages: expected is one line with the file and the reason, or notes about checkpoints
    after those about replaced results."""
    usual = ("clustermcml: note: replaces ", "clustermcml: note: --resume finds no ")
    lines = [line for line in err.splitlines() if not line.startswith(usual)]
    path = os.path.join(folder.path, name.removesuffix(".tmp"))
    words = "" if reason == "short" else os.strerror(getattr(errno, reason))
    if code == 5:
        return [] if len(lines) == 1 and lines[0].startswith(f"clustermcml: {path}: ") and words in lines[0] else [err]
    return [line for line in lines if not line.startswith("clustermcml: note: ") or ".checkpoint" not in line]


def fail(folder, number, aim):
    """Makes one call fail and returns complaints about what follows."""
    call, n, reason, name = aim
    folder.clear(older=number % 2 == 0)
    action = "short" if reason == "short" else getattr(errno, reason)
    done = folder.run(fault(call, n, action, name))
    code = wanted_code(folder, *aim)
    complaints = [f"exit {done.returncode}, not {code}"] if code != done.returncode else []
    complaints += check_words(folder, code, reason, subject(folder, call, n, name), done.stderr)
    complaints += [f"{wrong} is neither old nor new" for wrong in folder.wrong_files([folder.older, folder.expected])]
    left = folder.read()
    complaints += [f"{other} is left" for other in left if other.endswith((".tmp", ".lock")) and call != "unlink"]
    final = name.removesuffix(".tmp")
    if code == 5 and final in NAMES and left.get(final) not in (folder.older[final], None):
        complaints.append("the older result is gone")
    if code == 5 or call == "unlink":
        complaints += [f"after it: {folder.run().stderr}"] if folder.run().returncode else []
        left = folder.read()
    if left != folder.expected:
        complaints.append(f"other bytes, or files: {sorted(left)}")
    return [f"{call} {name} {n} {reason}: {complaint}" for complaint in complaints]


def stopped(folder):
    """Tests that a run which is asked to stop, but cannot write a checkpoint, says so and exits with 5 instead of 75."""
    folder.clear()
    process = folder.start({"CML_FAULT": f"rename 1+ {errno.EIO} skinmap.mco.checkpoint"}, photons="1e9")
    note = process.stderr.readline()
    if "--resume finds no" in note:
        note = process.stderr.readline()
    process.send_signal(signal.SIGTERM)
    last = process.communicate()[1].splitlines()[-1]
    path = os.path.join(folder.path, "skinmap.mco.checkpoint")
    line = f"{path}: cannot be written ({os.strerror(errno.EIO)})"
    good = process.returncode == 5 and note == f"clustermcml: note: {line}\n" and last == f"clustermcml: {line}"
    return [] if good and not os.listdir(folder.path) else [f"stopped: exit {process.returncode}: {note}{last}"]


def read_only(folder):
    """Tests a file system that becomes read-only in the middle of a run: the older result stays."""
    folder.clear(older=True)
    done = folder.run({"CML_FAULT": f"open 6+ {errno.EROFS}"})
    good = done.returncode == 5 and done.stderr.splitlines()[-1].startswith(f"clustermcml: {folder.path}/skinmap.mco: ")
    changed = [name for name in NAMES if folder.read()[name] != folder.older[name]]
    return [] if good and not changed else [f"read-only: exit {done.returncode}, {changed}: {done.stderr}"]


def main():
    complaints, number = [], 0
    with Folder() as folder:
        tried = list(aims(folder))[::1 if "ALL_CASES" in os.environ else 3]
        for aim in tried:
            complaints += fail(folder, number, aim)
            number += 1
        if {aim[0] for aim in tried} != set(REASONS):
            complaints.append("a kind of call is missing")
        complaints += stopped(folder) + read_only(folder)
    print(f"{number} failing calls")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints or number < 15 else 0)


main()
