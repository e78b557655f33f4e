"""Runs of the compared programs, undisturbed on the cores that they need, and of a wanted length.

SPDX-License-Identifier: MIT
"""
import json
import os
import subprocess
import sys
import tempfile
import time

CALIBRATE_S = 0.1  # shortest run [s] that tells the photons per second well enough
FOREIGN = 0.05  # share of a core that other programs may take from a run before it is repeated
REPEATS = 3
spent = 0.0  # user seconds of the last run
MOST_PHOTONS = 50000000


def busy_seconds():
    """Returns the core seconds that the whole machine has worked so far, or None without /proc/stat."""
    try:
        with open("/proc/stat") as stream:
            ticks = [int(word) for word in stream.readline().split()[1:9]]
    except (OSError, ValueError):
        return None
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")  # time in idle and iowait does not count


def run(command, directory, threads=1, environment=None):
    """Runs a child. Returns (standard output, resource usage, True if others took cores that it needs). Exit codes 0 and 4 (numerical trouble) are
    accepted."""
    global spent  # for callers that ask nothing else of the usage
    with tempfile.TemporaryFile("w+") as out:
        begin, before = time.monotonic(), busy_seconds()
        child = subprocess.Popen(command, cwd=directory, env=environment, stdout=out)
        _, status, usage = os.wait4(child.pid, 0)
        wall, after = time.monotonic() - begin, busy_seconds()
        child.returncode, spent = os.waitstatus_to_exitcode(status), usage.ru_utime
        if child.returncode not in (0, 4):
            sys.exit("%s: exit code %d" % (" ".join(command), child.returncode))
        out.seek(0)
        foreign = 0.0 if before is None or after is None else after - before - usage.ru_utime - usage.ru_stime
        return out.read(), usage, foreign > (os.cpu_count() - threads + FOREIGN) * wall + 0.02  # ticks are 0.01 s


def run_alone(command, directory, threads=1, environment=None):
    """Runs a command as `run` does, and repeats it a few times if other programs took cores that it needs."""
    for _ in range(REPEATS):
        result = run(command, directory, threads, environment)
        if not result[2]:
            break
        time.sleep(1)
    return result


def fly_alone(program, case, photons, seed):
    """Runs the program once. Returns its JSON record with the memory of the process, and whether others disturbed it."""
    environment = dict(os.environ)
    if case.threads > 1:
        environment["OMP_PROC_BIND"] = "true"
    command = [program, case.path, "--json", "--threads", str(case.threads), "--seed", str(seed),
               "--photons", str(photons)] + case.options
    text, usage, disturbed = run_alone(command, os.path.dirname(case.path), case.threads, environment)
    return {**json.loads(text), "rss": usage.ru_maxrss / 1024, "disturbed": disturbed}


def records(command, cwd=None, allowed=(0, 4)):
    """Returns the records that --json prints, one for each run. Exit code 4, numerical trouble, is accepted, because results are to show it."""
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode not in allowed:
        sys.exit("%s: exit code %d: %s" % (" ".join(command), done.returncode, done.stderr.strip()))
    return [json.loads(line) for line in done.stdout.splitlines()]


def two_digits(photons):
    digits = "%.1e" % min(max(photons, 100), MOST_PHOTONS)
    return int(float(digits))


def calibrate(program, case, target):
    """Sets the number of photons that take about `target` seconds."""
    photons = 2000
    while True:
        seconds = fly_alone(program, case, photons, 1)["seconds"]
        if seconds > CALIBRATE_S or photons >= MOST_PHOTONS:
            break
        photons = min(MOST_PHOTONS, int(photons * min(20.0, 1.5 * CALIBRATE_S / max(seconds, 1e-4))) + 1)
    case.photons = two_digits(photons * target / seconds)


def fly_mcml(mcml, lines, photons):
    """Runs original MCML on the data lines of a flat scene. Returns (user seconds, Rd, whether others disturbed it)."""
    with tempfile.TemporaryDirectory() as work:
        with open(os.path.join(work, "x.mci"), "w") as stream:
            stream.write("\n".join(lines[:3] + [str(int(photons))] + lines[4:]) + "\n")
        _, usage, disturbed = run_alone([mcml, "x.mci"], work)
        with open(os.path.join(work, lines[2].split()[0]), errors="replace") as stream:
            rd = [line.split()[0] for line in stream if "#Diffuse reflectance" in line]
    return usage.ru_utime, float(rd[0]), disturbed


def calibrate_mcml(mcml, lines, target):
    """Returns (seconds for start and output, photons that take about `target` seconds) of original MCML."""
    start = min(fly_mcml(mcml, lines, 1)[0] for _ in range(3))
    photons, seconds = 500, 0.0
    while seconds < CALIBRATE_S:
        photons *= 4
        seconds = fly_mcml(mcml, lines, photons)[0] - start
    return start, two_digits(photons * target / seconds)
