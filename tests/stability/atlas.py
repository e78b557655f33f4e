"""The atlas: simulates every situation by every method, and counts what goes wrong.

  atlas.py PROGRAM WALKER [--out FILE.csv] [--crossings N] [--seconds S] [--natural] [--full] [--only WORD,...] [--test]

PROGRAM is clustermcml, WALKER the harness stability_atlas. Each cell (situation, method, aim) ends after N crossings or S seconds. --natural flies
only packets that are aimed at any point of a face, N crossings in all. Every cell gets at least FLOOR of an equal share; the rest goes to cells
that need few flights for a crossing. --full adds meshes of 1e6 and 1e7 triangles. --only selects situations that have one of the words in their
name. --test writes nothing, and fails if an event happens that must not. Each situation is tested by one of its methods, the next situation by the
next method, and every fourth one by the program; all methods are tested if the environment has ALL_CASES. Only the standard library is needed."""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

import situations

ROUND = ("reference", "cpu", "reference-mesh", "cpu-mesh")
RADIAL = ("reference-cone", "cpu-cone", "reference-mesh", "cpu-mesh")
MESHES = ("reference-mesh", "cpu-mesh")
COLUMNS = "situation method aim status crossings lost wrong missed spurious nan trapped flights note".split()
COUNTS = COLUMNS[4:12]
STRICT = ("face", "beam", "1e-2")  # aims at which no event may happen; at all others a few may
FLOOR = 0.7  # share of an equal share: 5e6 of 1e9 crossings
PILOT = 20000  # crossings of the pilot that counts the flights for one crossing in a cell
FLIGHTS, NATURAL_FLIGHTS = 20, 1000  # most flights for each crossing that is asked for; the sparsest cells need some 120
MOST_OF_AIMED = 0.01  # for 500 crossings; meshes have no event at all, cones along a ridge have 0.1 %


def methods_of(situation):
    methods = kinds_of(situation)
    return [method for method in methods if not (situation.name in situations.NO_MESH and method in MESHES)]


def kinds_of(situation):
    if 'm "' in situation.mci or '\ni "' in situation.mci:
        return MESHES
    if "\ni sphere" in situation.mci or "\ni cylinder" in situation.mci:
        return ROUND
    return RADIAL if "\nb " in situation.mci else ("reference", "cpu")


def short(message):
    return message.strip().split("\n")[-1].split("clustermcml: ")[-1]


def patience(situation):
    """Returns the seconds after which a scene that is only read and checked counts as too slow."""
    return 600 if situation.big else 60


def run(command, limit=None):
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return None


def fly_cell(arguments, situation, path, method, aims, crossings):
    """Returns a cell for each aim. One process flies all aims, so that surfaces are made once."""
    empty = [{"situation": situation.name, "method": method, "aim": aim, "status": "flown", "note": ""} for aim in aims]
    limit = patience(situation) + 2 * len(aims) * arguments.seconds if arguments.seconds else None
    flights = NATURAL_FLIGHTS if arguments.natural else FLIGHTS
    done = run([arguments.walker, path, method, ",".join(aims), repr(crossings), repr(arguments.seconds), str(flights)], limit)
    if done is None:
        return [cell | {"status": "too slow", "note": f"not ready after {limit:g} s"} for cell in empty]
    if done.returncode != 0:
        return [cell | {"status": "refused" if done.returncode == 2 else "failed",
                        "note": short(done.stderr) or f"ended with {done.returncode}"} for cell in empty]
    lines = [line.split(",") for line in done.stdout.splitlines()]
    return [cell | dict(zip(COUNTS, map(int, values))) | {"note": values[len(COUNTS)]}
            for cell, values in zip(empty, lines, strict=True)]


def run_program(arguments, situation, path, directory):
    """Runs the program itself on a situation. The note of the cell says how much Rd would change without the surface."""
    cell = {"situation": situation.name, "method": "program", "aim": "beam", "status": "flown"}
    photons = "2e3" if arguments.test else "2e5" if arguments.natural else "2e4"
    command = [arguments.program, path, "--json", "--quiet", "-o", directory, "--photons", photons]
    limit = 2 * patience(situation)
    done = run(command, limit)
    if done is None:
        return cell | {"status": "too slow", "note": f"not ready after {limit} s"}
    flat = None if arguments.natural or arguments.test else run(command + ["--boundaries", "plane"], limit)
    if done.returncode not in (0, 4):
        return cell | {"status": "refused" if done.returncode == 2 else "failed", "note": short(done.stderr)}
    result = json.loads(done.stdout)
    cell |= {"lost": result["lost"], "trapped": result["trapped"], "note": f"residue {result['residue']}"}
    if arguments.natural:
        return cell | {"crossings": int(result["crossings"])}
    if flat and flat.returncode == 0:
        change = json.loads(flat.stdout)["Rd"] - result["Rd"]
        cell["note"] += f", plane Rd {change:+.1e}"
    return cell


def check_refused(arguments, situation, path):
    done = run([arguments.program, "check", path])
    status = "refused" if done.returncode == 2 else ("accepted" if done.returncode == 0 else "failed")
    return {"situation": situation.name, "method": "program", "aim": "check", "status": status,
            "note": short(done.stderr)}


def share_out(arguments, pool, cells):
    """Returns the crossings of every cell for --natural. They are the same on any machine, because flights are counted, not timed."""
    equal = arguments.crossings / len(cells)
    pilots = list(pool.map(lambda cell: fly_cell(arguments, *cell, min(PILOT, equal))[0], cells))
    ease = [pilot.get("crossings", 0) / max(1, pilot.get("flights", 0)) for pilot in pilots]
    return [math.ceil(FLOOR * equal + (1 - FLOOR) * arguments.crossings * x / sum(ease)) for x in ease]


def fly_cells(arguments, pool, cells):
    """Returns the jobs of all cells in their order. Cells with the fewest crossings begin first, because they need the most flights for each."""
    crossings = share_out(arguments, pool, cells) if arguments.natural else [arguments.crossings] * len(cells)
    order = sorted(range(len(cells)), key=lambda i: crossings[i])
    jobs = {i: pool.submit(fly_cell, arguments, *cells[i], crossings[i]) for i in order}
    return [jobs[i] for i in range(len(cells))]


def all_cells(arguments, directory):
    cells, others, few = [], [], arguments.test and "ALL_CASES" not in os.environ
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for number, situation in enumerate(situations.build(directory, arguments.full)):
            path = situation.path(directory)
            if not any(word in situation.name for word in arguments.only.split(",")):
                continue
            if situation.refused:
                if not arguments.natural:
                    others.append((check_refused, arguments, situation, path))
                continue
            methods = methods_of(situation)
            if few:
                methods = [methods[number % len(methods)]]
            cells += [(situation, path, method, ("face",) if arguments.natural else situation.aims) for method in methods]
            if few and number % 4:
                continue
            others.append((run_program, arguments, situation, path, directory))
        flown, jobs = fly_cells(arguments, pool, cells), [pool.submit(*job) for job in others]
        return [cell for job in flown for cell in job.result()] + [job.result() for job in jobs]


def must_not(cell, refused):
    """True if the cell breaks a promise: an accepted scene loses no packet and knows the medium of each packet, and a scene to be refused is
    refused."""
    if cell["situation"] in refused:
        return cell["status"] != "refused" or refused[cell["situation"]] not in cell["note"]
    if cell["status"] != "flown" or cell["method"] == "program" and "residue 0" not in cell["note"]:
        return True
    events = sum(cell.get(key, 0) for key in ("lost", "wrong", "missed", "spurious", "nan"))
    return events > (0 if cell["aim"] in STRICT else MOST_OF_AIMED * cell.get("crossings", 0))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("walker")
    parser.add_argument("--out")
    parser.add_argument("--crossings", type=float, default=1e8)
    parser.add_argument("--seconds", type=float, default=0)
    parser.add_argument("--natural", action="store_true")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--test", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        cells = all_cells(arguments, directory)
        refused = {s.name: s.refused for s in situations.build(directory) if s.refused}
    if arguments.out:
        with open(arguments.out, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(cells)
    broken = [cell for cell in cells if must_not(cell, refused)]
    for cell in broken:
        print(" ".join(f"{key}={value}" for key, value in cell.items() if value != ""))
    print(f"{len(cells)} cells, {sum(cell.get('crossings', 0) for cell in cells)} crossings, {len(broken)} broken")
    sys.exit(1 if broken and arguments.test else 0)


main()
