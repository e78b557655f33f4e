"""Tests that results are either whole or absent when writing fails, in run, --more, --sweep and merge.

Every write, fsync, close and rename on a result fails, once, or from some call on. A file under the name of a result must
afterwards be that of a run without faults, or the earlier file. Exit code 0 means that all results are those of a run without
faults. Otherwise the exit code is 5, and one line names the file and the reason. No temporary file is left. A link that
replaces a temporary .h5 file is not followed.

WHOLE=1 tries all of these calls, each in both ways; otherwise a third of the first and last calls on each file, in turns.
Shares with the program everything but the fault. Standard library only."""
import errno
import itertools
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(os.environ.get("CLUSTERMCML", "build/clustermcml"))
CALLS = {"write": "EIO lost ENOSPC short", "fsync": "EIO", "close": "EIO", "rename": "EIO ENOSPC"}
# Thin media: files are as long as those of thick media, and the flight takes a third of the time.
SCENE = """1.0
1
small.mco {format}
1000
0.1 0.1
4 20 10
map 8 6 0.1 0.1 angles volume
facets
1
1.0
b 2 0.05 0.1 0 0.1
1.4 0.5 2 0.8 0.5
i sphere 0 0 0.3 0.1  1.4 1 2 0.5
1.0
"""
RUN = ["small.mci", "--photons", "500", "--threads", "1", "--quiet", "-o", "OUT"]
BINARY = ["binary.mci", *RUN[1:]]
PART = "small.mci --photons 300 --threads 1 --quiet".split()
# name: (commands to run before, the command)
WORK = {
    "run": ([], [*RUN, "--keep"]),
    "run over an older result": ([[*RUN, "--seed", "2"]], RUN),
    "run, format B": ([], [*BINARY, "--keep"]),
    "more": ([[*RUN, "--keep"]], [*RUN[:1], "--more", "200", *RUN[3:]]),
    "sweep": ([], [*RUN, "--sweep", "table.csv", "--resume"]),
    "sweep over an older one": ([[*RUN, "--sweep", "table.csv", "--seed", "2"]], [*RUN, "--sweep", "table.csv"]),
    "merge": ([[*RUN, "--part", "1/2"], [*RUN, "--part", "2/2"]], "merge OUT/small.mco.part1of2 OUT/small.mco.part2of2 --quiet".split()),
}


def is_result(name):
    return not name.endswith((".tmp", ".lock")) and ".checkpoint" not in name and ".part" not in name


class Work:
    """One command and the commands before it, run in a folder. `expected` holds the files that they leave without faults."""

    def __init__(self, root, before, command):
        self.root, self.command, self.out = root, command, os.path.join(root, "out")
        self.restore({})
        for earlier in before:
            self.call(earlier).check_returncode()
        self.before = self.read()
        log = os.path.join(root, "log")
        self.call(command, CML_FAULT_LOG=log).check_returncode()
        self.expected = self.read()
        with open(log, encoding="utf-8") as file:
            self.calls = [tuple(line.split()) for line in file]  # (call, file); temporary files are NAME.tmp
        os.remove(log)

    def start(self, arguments, **faults):
        preloaded = {"LD_PRELOAD": os.environ["FILE_FAULT"], "CML_FAULT_FOLDER": self.out + "/", **faults} if faults else {}
        words = [word.replace("OUT", self.out) for word in arguments]
        return subprocess.Popen(["env", *(f"{name}={value}" for name, value in preloaded.items()), PROGRAM, *words],
                                cwd=self.root, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def call(self, arguments, **faults):
        process = self.start(arguments, **faults)
        out, err = process.communicate()
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def restore(self, files):
        shutil.rmtree(self.out, ignore_errors=True)
        os.mkdir(self.out)
        for name, data in files.items():
            with open(os.path.join(self.out, name), "wb") as file:
                file.write(data)

    def read(self):
        files = {}
        for name in os.listdir(self.out):
            with open(os.path.join(self.out, name), "rb") as file:
                files[name] = re.sub(rb"# User time.*\n", b"", file.read())
        return files

    def faults(self, whole):
        """Yields faults (call, n, "+" or "", reason): the n-th call of this kind fails for this reason; with "+" all later ones fail, too."""
        for call, reasons in CALLS.items():
            names = [name for made, name in self.calls if made == call and not name.endswith(".lock")]
            ends = {names.index(name) for name in names} | {len(names) - 1 - names[::-1].index(name) for name in names}
            for i in range(len(names)) if whole else sorted(ends):
                for many in ("", "+") if whole else ("+",) if i % 2 else ("",):
                    reason = reasons.split()[i % len(reasons.split())]
                    yield call, i + 1, "" if reason == "short" else many, reason

    def judge(self, call, n, many, reason):
        """Returns (existing results, those that are wrong, other complaints)."""
        self.restore(self.before)
        aim = f"{call} {n}{many} {getattr(errno, reason, reason)}"
        done = self.call(self.command, CML_FAULT=aim)
        left = {name: data for name, data in self.read().items() if is_result(name)}
        old = {} if done.returncode == 0 else self.before
        wrong = [name for name, data in left.items() if data not in (self.expected.get(name), old.get(name))]
        lines = [line for line in done.stderr.splitlines() if not line.startswith("clustermcml: note: ")]
        complaints = [f"{name} is left" for name in os.listdir(self.out) if name.endswith((".tmp", ".lock"))]
        if done.returncode == 0:
            complaints += [f"{name} is missing" for name in self.expected if is_result(name) and name not in left]
        elif done.returncode != 5 or len(lines) != 1 or not re.fullmatch(r"clustermcml: \S+: cannot be written \(.+\)", lines[0]):
            complaints.append(f"exit {done.returncode}: {done.stderr}")
        return left, wrong, [f"{aim}: {text}" for text in [f"{name} has other bytes, exit {done.returncode}" for name in wrong] + complaints]


def follows_link(work):
    """Stops the program before it opens a temporary .h5 file again and puts a link there. Returns True if the program writes
    to the link's target."""
    work.restore({})
    victim = os.path.join(work.root, "victim")
    with open(victim, "w", encoding="utf-8") as file:
        file.write("precious")
    process = work.start(work.command, CML_FAULT="open 2 stop small.h5.tmp")
    if os.WIFSTOPPED(os.waitpid(process.pid, os.WUNTRACED)[1]):
        for name in os.listdir(work.out):
            if ".h5." in name:
                os.remove(os.path.join(work.out, name))
                os.symlink(victim, os.path.join(work.out, name))
        os.kill(process.pid, signal.SIGCONT)
    process.communicate()
    with open(victim, "rb") as file:
        return file.read() != b"precious"


def prepare(root):
    for name, text in (("small.mci", SCENE.format(format="A")), ("binary.mci", SCENE.format(format="B")),
                       ("table.csv", "layer1.mua\n1\n2\n")):
        with open(os.path.join(root, name), "w", encoding="utf-8") as file:
            file.write(text)
    for seed, folder in enumerate(("one", "two")):
        os.mkdir(os.path.join(root, folder))
        subprocess.run([PROGRAM, *PART, "--seed", str(seed), "-o", folder], cwd=root, check=True)
    if not os.path.exists(os.path.join(root, "one", "small.h5")):
        print("the program was built without HDF5")
        sys.exit(77)


def main():
    failed, complaints = dict.fromkeys(CALLS, 0), []
    published = different = 0
    with tempfile.TemporaryDirectory() as root:
        root = os.path.realpath(root)
        prepare(root)
        whole = "WHOLE" in os.environ
        for first, (name, (before, command)) in enumerate(WORK.items()):
            work = Work(root, before, command)
            for fault in itertools.islice(work.faults(whole), 0 if whole else first % 3, None, 1 if whole else 3):
                left, wrong, texts = work.judge(*fault)
                failed[fault[0]] += 1
                published += len(left)
                different += len(wrong)
                complaints += [f"{name}: {text}" for text in texts]
            if name == "run" and follows_link(work):
                complaints.append("a link that took the place of small.h5.tmp was followed")
    print(", ".join(f"{count} {call}" for call, count in failed.items()) + f" failed: {published} results published, {different} different")
    print("\n".join("FAILED " + complaint for complaint in complaints))
    sys.exit(1 if complaints or min(failed.values()) < 5 else 0)


main()
