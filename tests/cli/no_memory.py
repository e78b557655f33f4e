"""Tests a machine that runs out of memory: requests for memory that the program makes for a scene fail, one per run.

The program must do without (for example, a thread is not bound) and save as many packets as ever. Or it must say so in one
line, exit with 2, or with 5 if a file was to be written, and leave no half-written file. Shares nothing with the program but
its words. Requests of libraries do not fail.

no_memory.py PROGRAM: clustermcml linked with tests/lib/failing_memory.c. WHOLE=1: every request, else every eleventh (every
third for two beams)."""
import concurrent.futures
import os
import re
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])

SCENE = """1.0
2
first.mco A
1000
map 4 3 0.1 0.1 angles volume
facets
0.01 0.02
20 20 10
2
1.0
b 4 0 0.1 0.05 0.1 0.02 0.1 0 0.1
1.4 0.5 50 0.8 0.1
m "pyramid.obj" units=mm
1.5 1 20 0 0.2
1.0
second.mco B
1000
0.01 0.02
20 20 10
1
1.0
m "scan.asc" units=mm
1.4 0.5 50 0.8 0.1
1.0
"""
SCAN = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + "0 0 0 0\n0 1 0.5 0\n0 0.3 2 0\n0 0 0 0\n"

RUN = ["scene.mci", "--photons", "200", "--threads", "1", "--quiet"]
COMMANDS = {
    "run": RUN + ["-o", "OUT"],
    "mesh": ["mesh", "scene.mci", "-o", "OUT"],
    "run on meshes": RUN + ["--boundaries", "mesh", "--normals", "vertex", "--json", "-o", "OUT"],
    "reference": RUN + ["--engine", "reference", "-o", "OUT"],
    "rounds": ["flat.mci", "--photons", "64", "--threads", "1", "--target-error", "0.3", "--checkpoint", "1e-9", "--quiet", "-o", "OUT"],
    "threads": ["flat.mci", "--photons", "200", "--threads", "2", "--quiet", "-o", "OUT"],
    "two beams": ["beams.mci", "--threads", "1", "--json", "-o", "OUT"],
    "trace": ["trace", "scene.mci", "3"],
}


def call(folder, arguments, failing):
    """Runs the program. Returns its exit code, lines of standard error without notes, names in the folder of results, and the
    line about saved packets."""
    with tempfile.TemporaryDirectory() as out:
        arguments = [argument.replace("OUT", out) for argument in arguments]
        run = subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, errors="replace",
                             stdin=subprocess.DEVNULL, env={**os.environ, "FAIL_ALLOCATION": str(failing)})
        lines = [line for line in run.stderr.replace(out, "OUT").splitlines() if not line.startswith("clustermcml: note: ")]
        return run.returncode, lines, sorted(os.listdir(out)), re.findall(r'"saved":{[^}]*}', run.stdout)


def fault(code, lines, names, saved, whole):
    """Returns the complaint about how a run ended; an empty text if all is right. whole: the line about saved packets of a
    run without failure."""
    left = [name for name in names if not re.fullmatch(r"[\w.]+\.(mco|h5|vti|vtp|obj|svg|mco\.checkpoint|mco\.checkpoint\.old)", name)]
    if left:
        return f"left {' '.join(left)}"
    if code in (0, 1):  # 1: two results differ
        return "" if saved == whole else f"saved {saved} instead of {whole}"
    if code not in (2, 5) or len(lines) != 1 or not lines[0].startswith("clustermcml: "):
        return "not one line with exit code 2 or 5"
    return "" if re.search("out of memory: |Cannot allocate memory", lines[0]) else "another reason"


def prepare(folder):
    """Writes the input files."""
    def write(name, text):
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)
    with open("meshes/pyramid.obj", encoding="ascii") as file:
        write("pyramid.obj", file.read())
    write("scene.mci", SCENE)
    write("scan.asc", SCAN)
    flat = "1.0\n1\n%s A\n1000\n0.01 0.02\n20 20 10\n1\n1.0\n1.4 0.5 50 0.8 0.1\n1.0\n"
    write("beams.mci", (flat % "beams.mco").replace("0.01 0.02", 'photons "exits" limit=50\nbeam pencil\nbeam disk 0.1\n0.01 0.02', 1))
    write("flat.mci", flat % "flat.mco")
    subprocess.run([PROGRAM, *RUN], cwd=folder, check=True, capture_output=True)


def main():
    failures = 0
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(2) as pool:
        prepare(folder)
        for i, (name, arguments) in enumerate(COMMANDS.items()):
            code, lines, _, whole = call(folder, arguments, 0)
            requests, step = int(lines[-1].removeprefix("requests: ")), 3 if name == "two beams" else 11
            failing = range(1, requests + 1) if "WHOLE" in os.environ else range(1 + i % step, requests + 1, step)
            ends = list(pool.map(lambda n: call(folder, arguments, n), failing))
            refused = sum(code in (2, 5) for code, *_ in ends)
            print(f"{name}: {len(failing)} of {requests} requests fail, {refused} of them end it", flush=True)
            for number, end in zip(failing, ends):
                if fault(*end, whole):
                    failures += 1
                    print(f"FAILED: {name}, request {number}: {fault(*end, whole)}: exit {end[0]}, {end[1]}")
            if code not in (0, 1) or refused < len(failing) / 2:
                failures += 1
                print(f"FAILED: {name}: exit {code} without a failure, {refused} of {len(failing)} requests matter: {lines}")
    sys.exit(failures > 0)


main()
