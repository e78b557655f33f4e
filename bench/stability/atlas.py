#!/usr/bin/env python3
"""Makes the atlas of failures by situation and method:

    atlas.py [--quick] [--full] [--only WORD,...] [--build DIR] [--out DIR]
    atlas.py --natural [--crossings N] [--full] [--only WORD,...] [--build DIR] [--out DIR]

By default programs come from build/, and results go to bench/out, within 30 minutes on two cores; with --quick within 3. --full adds 1e6 and 1e7
triangles. --only selects situations with a WORD in their name. Leaves atlas.csv and atlas.md, with a row per situation and aim, and a column per
method. --natural: N (1e9) crossings in all, of packets aimed at any point of a face, within 20 minutes. It leaves natural.csv and natural.md, with
a row per method, and the events. tests/stability/README.md says what is simulated and counted.

    atlas.py --table CSV
    atlas.py --natural-table CSV

print such results again.

    atlas.py --readme README

writes the short table there from the files in bench/stability/results.

SPDX-License-Identifier: MIT
"""
import csv
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import command
import tables

PROGRAMS = ("clustermcml", os.path.join("tests", "stability_atlas"))
EVENTS = ("lost", "wrong", "missed", "spurious", "nan")
METHODS = ("reference-cone", "cpu-cone", "reference-mesh", "cpu-mesh")
SAME = {"reference": "reference-cone", "cpu": "cpu-cone"}  # planes stand in the columns of the cones


def rate(events, crossings):
    """Returns the events per 1e8 crossings. Without an event, returns the bound that 95 % of such flights would keep (rule of three)."""
    return f"{events * 1e8 / crossings:.3g}" if events else f"<{3e8 / crossings:.2g}"


def cell_text(cell):
    if cell is None:
        return "-"
    if cell["status"] != "flown":
        return cell["status"]
    crossings = int(cell["crossings"] or 0)
    if crossings == 0:
        return "no crossing"
    found = [f"{key} {rate(int(cell[key]), crossings)}" for key in EVENTS if int(cell[key] or 0)]
    return ", ".join(found) or rate(0, crossings)


def count(cells, key):
    return sum(int(cell[key] or 0) for cell in cells)


def natural_lines(cells):
    asked = [cell for cell in cells if cell["method"] != "program" and cell["status"] == "flown"]
    crossings, situations = count(asked, "crossings"), len({cell["situation"] for cell in asked})
    yield (f"lost {count(asked, 'lost')} and wrong side {count(asked, 'wrong') + count(asked, 'missed')} in {crossings:.3g} "
           f"oracle-checked crossings of packets aimed at nothing in particular, over all {situations} situations that "
           f"`check` accepts, at least {min(int(cell['crossings']) for cell in asked):.2g} in each by each method. No event "
           f"in so many bounds the rate by {3 / crossings:.1e} (95 %). The program's own flights are asked only for lost.")
    yield ""
    rows = []
    for method in dict.fromkeys(cell["method"] for cell in cells):
        row = [cell for cell in cells if cell["method"] == method and cell["status"] == "flown"]
        rows.append([method, len(row), f"{count(row, 'crossings'):.3g}",
                     *("-" if method == "program" and key != "lost" else count(row, key) for key in EVENTS)])
    yield from tables.table(("method", "situations", "crossings", *EVENTS), rows)
    for cell in cells:
        events = ", ".join(f"{key} {cell[key]}" for key in EVENTS if int(cell[key] or 0))
        if events or cell["status"] != "flown":
            yield f"\n{cell['situation']}, {cell['method']}: {cell['status']}, {cell['crossings']} crossings, {events}"


def program_text(program):
    """Returns the message of the program's own flight, or how it ended."""
    return f"lost {program['lost']}, trapped {program['trapped']}, {program['note']}" if program["status"] == "flown" else (
        f"{program['status']}: {program['note']}")


def aimed_lines(cells):
    rows, programs, named = {}, {}, set()
    for cell in cells:
        if cell["method"] == "program":
            programs[cell["situation"]] = cell
        else:
            rows.setdefault((cell["situation"], cell["aim"]), {})[SAME.get(cell["method"], cell["method"])] = cell
    natural = [cell for cell in cells if cell["aim"] == "face" and cell["status"] == "flown"]
    yield (f"{count(cells, 'crossings'):.3g} crossings; lost or on the wrong side in the {count(natural, 'crossings'):.3g} "
           f"of packets aimed at nothing in particular (`face`): {count(natural, 'lost') + count(natural, 'wrong')}.")
    yield ""
    yield "Events per 1e8 crossings; `<`: none was seen, and the limit at 95 %. tests/stability/README.md has the words."
    yield ""
    table = []
    for (situation, aim), row in rows.items():
        known = situation in programs and situation not in named
        named.add(situation)
        table.append([situation, aim, *(cell_text(row.get(method)) for method in METHODS),
                      program_text(programs[situation]) if known else ""])
    table += [[situation, "check", *"----", f"{program['status']}: {program['note'].split('/')[-1]}"]
              for situation, program in programs.items() if situation not in named]
    yield from tables.table(("situation", "aim", "reference, cone", "cpu, cone", "reference, mesh", "cpu, mesh", "program"), table)


# --- the table in README ---

RESULTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "results")
AIMS = (("edges, ridges, vertices, tips; within 2 ulp", "edge vertex drop"),
        ("along an edge, in the surface", "along"),
        ("1e-2 to 1e-4 rad from a face", "1e-2 1e-3 1e-4"),
        ("1e-5 to 1e-7 rad from a face", "1e-5 1e-6 1e-7"))
KINDS = (("ridges, tips, rough meshes", "ridges-and-tip cone-tip pit-tip pole-of-a-dome vertices-and-edges "
                                       "irregular-mesh spiked-mesh"),
         ("grazing flights", "grazing-rings grazing-mesh smooth-rough"),
         ("walls, needles, grooves", "walls-1e3 mesh-walls-1e3 needles-1e4 grooves-1e3 groove-1deg"),
         ("1e-6 to 1e-4 cm fine; 1e2 cm off", "rings-1e-6cm rings-1e-6cm-far features-1e-4cm-at-1e2cm "
                                             "features-1e-4cm-beam-1e2cm-off"),
         ("layers of 1e-5 cm", "layer-1e-5cm mesh-layer-1e-5cm"),
         ("1e-6 and 1e3 cm in size", "scale-1e-6 wide-1e3cm mesh-wide-1e3cm"),
         ("1e5 rings, 1e6 and 1e7 triangles", "rings-1e5 triangles-1e6 triangles-1e7"),
         ("media: free path, g, n", "planes touching-planes mean-free-path-1e-4 mean-free-path-1e0 mean-free-path-1e4 "
                                    "g=-1 g=-0.999 g=0.999 g=1 n=1 n-all-but-matched n=2 n=4"),
         ("corners that send light back", "corner-cube corner-cube-clear"),
         ("overhangs, normals that disagree", "overhang overhang-below overhang-n=1 dome-n=1-smooth"),
         ("flat, degenerate, turned, unjoined", "flat-mesh degenerate-triangles turned-triangles triangles-alone"),
         ("tiles", "tile tile-below tile-many-periods tile-2x2 tile-odd tile-mirror tile-waves tile-walls-1e2 tile-smooth "
                   "tile-n=1 tile-clear tile-layer-1e-5cm tile-features-1e-4cm-at-1e2cm"),
         ("spheres, cylinders", "sphere cylinder-oblique cylinder-upright cylinder-level cylinder-wire cylinder-disk sphere-air "
                                "sphere-clear sphere-n=1 cylinder-n=1 sphere-scale-1e-6 sphere-1e-4cm-at-1e2cm "
                                "sphere-wide-1e3cm sphere-mean-free-path-1e-4 body-1e-6cm-below-plane beads-1e4"),
         ("closed meshes", "body-box body-stone body-stone-smooth body-stone-n=1 body-box-air body-needle body-bottle "
                           "body-below-mesh body-below-tile"),
         ("bodies in bodies", "nested-spheres-1e-6cm nested-cylinders-1e-6cm nested-ball-in-tube nested-stones-1e-6"))


def read_cells(path):
    """Returns the cells of a CSV file, or none if no such file was stored."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def pooled(situations, aim, cells):
    texts = []
    for method in METHODS:
        row = [cell for cell in cells if SAME.get(cell["method"], cell["method"]) == method and cell["status"] == "flown"]
        crossings = count(row, "crossings")
        texts.append(rate(sum(count(row, key) for key in EVENTS), crossings) if crossings else "-")
    flown = [cell for cell in cells if cell["status"] == "flown" and cell["method"] != "program"]
    return f"| {situations} | {aim} | {count(flown, 'crossings'):.2g} | " + " | ".join(texts) + " |"


def readme_lines(quick, natural):
    refused = [cell for cell in quick if cell["aim"] == "check"]
    unknown = {cell["situation"] for cell in quick if cell not in refused} - set(" ".join(k for _, k in KINDS).split())
    if unknown:
        sys.exit("atlas.py: in none of KINDS: " + " ".join(sorted(unknown)))
    yield "| situations | aimed at | crossings | cones, double | cones, single | meshes, double | meshes, single |"
    yield "|---|---|---|---|---|---|---|"
    yield pooled("all", "nothing in particular", natural)
    for name, aims in AIMS:
        yield pooled("all", name, [cell for cell in quick if cell["aim"] in aims.split()])
    for name, situations in KINDS:
        cells = [cell for cell in quick if cell["situation"] in situations.split()]
        if cells:
            yield pooled(name, "every way", cells)
    right = sum(cell["status"] == "refused" for cell in refused)
    yield f"| surfaces that cross or touch, holes | - | - | {right} of {len(refused)} refused | | | |"


def rewrite(readme):
    quick, large, natural = (read_cells(os.path.join(RESULTS, "atlas-%s.csv" % name)) for name in ("quick", "large", "natural"))
    tables.replace(readme, "stability/atlas.py", readme_lines(quick + large, natural))


# --- the program ---

def built(path):
    """Returns a build folder with the program and the walker."""
    for name in PROGRAMS:
        command.built(os.path.join(path, name))
    return os.path.abspath(path)


def show(path, lines_of=aimed_lines):
    print("\n".join(lines_of(read_cells(path))))


def main():
    parser = command.parser(__doc__, "quick full natural", ("build", built, command.BUILD[2]), crossings=1e9)
    parser.add_argument("--only", default="", metavar="WORD,...")
    command.instead(parser, "--table", ("CSV",), show)
    command.instead(parser, "--natural-table", ("CSV",), lambda path: show(path, natural_lines))
    command.instead(parser, "--readme", ("README",), rewrite)
    arguments = parser.parse_args()
    kept = os.path.join(arguments.out, "natural" if arguments.natural else "atlas")
    how = (["--natural", "--crossings", str(arguments.crossings), "--seconds", "0"] if arguments.natural
           else ["--crossings", "1e8", "--seconds", "0.2" if arguments.quick else "5"])  # each cell ends by its seconds
    os.makedirs(arguments.out, exist_ok=True)
    done = subprocess.run([sys.executable, "-B", os.path.join(cases.ROOT, "tests", "stability", "atlas.py"),
                           *(os.path.join(arguments.build, name) for name in PROGRAMS), "--out", kept + ".csv", "--only", arguments.only,
                           *how, *["--full"] * arguments.full], check=False)
    if done.returncode:
        sys.exit(done.returncode)
    tables.keep(kept + ".md", list((natural_lines if arguments.natural else aimed_lines)(read_cells(kept + ".csv"))))


main()
