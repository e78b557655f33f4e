#!/usr/bin/env python3
"""Draws one chart of accuracy against speed, with three scenes and at most six ways to fly each:

    summary.py [--quick] [--program PATH] [--out DIR]

By default the program is build/clustermcml and DIR is bench/out. Leaves summary.csv and, with matplotlib, summary.svg. Takes a minute.

    summary.py --draw CSV SVG

draws a result again. bench/accuracy/README.md explains the chart.

x: core seconds to a standard error of 0.1 % of Rd. y: the bias of Rd against the `reference` engine (double precision, exact cones, or the whole
mesh), from the same packets in 16 streams. The reference engine itself is checked by an independent program: tests/reference/profiles for the
shapes, MMC for the scan. Times of others, original MCML and MMC, come from stored results (bench/*/results), per photon. For the program of 2019
only printed curves are known, no times.

SPDX-License-Identifier: MIT
"""
import concurrent.futures
import itertools
import math
import os
import re
import shutil
import statistics
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cases
import chart
import command
import frontier
import picture
import rough
import tables
from frontier_scenes import Method, Scene

TRIANGLES = 10000
CONE, WHOLE = ["--engine", "reference", "--boundaries", "cone"], ["--engine", "reference", "--tolerance", "1e-9"]
PROFILE_PACKETS = 1e7  # packets of the independent program
FRONTIER, SPEED = "accuracy/results/frontier-amd-epyc-2core.csv", "speed/results/speed-amd-epyc-2core.csv"
MMC = "peers/results/mmc-amd-epyc-2core.md"
TITLES = {"lohill": "Radial hill, 0.1 cm high", "lonoise": "Random rings, +-0.05 cm", "scan": "Rough scan, pencil beam at one point"}
CHARTED = ("plane", "cone", "mesh 1e-2", "mesh 1e-3", "heightmap 1e-2", "mesh", "auto", "original MCML", "MMC")
SHOWN = {"plane": "shape ignored", "cone": "exact cones", "original MCML": "original MCML, flat"}
LEAST = 1e-9  # of a bias on the chart


def kept(name):
    return os.path.join(cases.BENCH, name)


# ---- scenes

def shape_scene(shape):
    methods = [Method("plane", ["--boundaries", "plane"]), Method("cone", ["--boundaries", "cone"]),
               Method("mesh 1e-2", ["--boundaries", "mesh", "--tolerance", "1e-2"]),
               Method("mesh 1e-3", ["--boundaries", "mesh", "--tolerance", "1e-3"]), Method("auto")]
    return Scene(shape, cases.shape_path(shape), None, methods, Method("truth", CONE))


def write_heightmap(path):
    """Writes the rough top of the other benches as an ESRI grid, whose rows run from the largest y down."""
    cells = round(math.sqrt(TRIANGLES / 2))
    _, grid = rough.heights(cells, float(cases.AMPLITUDE_A))
    with open(path, "w") as stream:
        stream.write("ncols %d\nnrows %d\nxllcorner 0\nyllcorner 0\ncellsize %.9g\nNODATA_value -9999\n"
                     % (cells + 1, cells + 1, rough.SIDE / cells))
        for row in reversed(grid):
            stream.write(" ".join("%.6f" % h for h in row) + "\n")


def scan_scene(work):
    path = os.path.join(work, "scan.mci")
    write_heightmap(os.path.join(work, "scan.asc"))
    cases.write_scene("A", path, surface='m "scan.asc" units=cm')
    methods = [Method("plane", ["--boundaries", "plane"]), Method("heightmap 1e-1", ["--boundaries", "mesh", "--tolerance", "1e-1"]),
               Method("heightmap 1e-2", ["--boundaries", "mesh", "--tolerance", "1e-2"]),
               Method("mesh", ["--boundaries", "mesh", "--tolerance", "1e-9", "--mesh-search", "embree"]), Method("auto")]
    return Scene("scan", path, None, methods, Method("truth", WHOLE))


# ---- results of other programs

def independent(shape):
    """Returns (Rd, standard error) of the program behind tests/reference/profiles. The error is at most that of as many packets of weight 1."""
    rows = cases.rows_of("profiles/%s.reentry.csv" % shape)
    width = 2 * float(rows[0]["r_mid_cm"])
    Rd = sum(2 * math.pi * (int(row["bin"]) + 0.5) * width ** 2 * float(row["Rd_r_per_cm2"]) for row in rows)
    return Rd, math.sqrt(Rd * (1 - Rd) / PROFILE_PACKETS)


def printed_in_2019(shape):
    """Returns the |bias| of the Rd that the report of 2019 printed, over the bins of its curve, against the same independent program."""
    curve, known = ({int(row["bin"]): float(row["r_mid_cm"]) * float(row["Rd_r_per_cm2"]) for row in cases.rows_of(path)}
                    for path in (kept("accuracy/figures/%s-2019.csv" % shape), "profiles/%s.reentry.csv" % shape))
    both = curve.keys() & known.keys()
    return abs(sum(curve[i] for i in both) / sum(known[i] for i in both) - 1)


def mmc_row():
    """Returns (ratio of photons per second, relative difference of the absorbed share, its standard error) for MMC with 1e4 triangles."""
    with open(kept(MMC)) as stream:
        cells = [re.findall(r"[-+0-9.e]+", cell) for cell in next(line for line in stream if line.startswith("| A | regular | 10082 ")).split("|")]
    ours, theirs = [float(word) for word in cells[8]], [float(word) for word in cells[9]]
    return float(cells[7][0]), theirs[0] / ours[0] - 1, math.hypot(ours[1], theirs[1]) / ours[0]


def mcml_ratio(scene):
    """Returns the ratio of original MCML's time per photon to this program's, on the scene's media below planes, with MCML's roulette and random
    numbers."""
    if scene == "scan":
        row = next(row for row in tables.read_csv(kept(SPEED))[1] if row["case"] == "A" and row["mcml_to_ours"])
        return float(row["mcml_to_ours"])
    rows = {row["variant"]: row for row in tables.read_csv(kept(FRONTIER))[1] if row["scene"] == "lonoise" and row["method"] == "plane"}
    return float(rows["mcml"]["ns_per_photon"]) / float(rows["before"]["ns_per_photon"])


# ---- measuring

def row_of(series):
    after, before = series.runs["after"], series.runs["before"]
    boundary = after[0]["boundaries"][0]
    bias, error = series.bias["after"]["Rd"]
    return {"scene": series.scene.name, "method": series.method.name, "kind": boundary["kind"], "primitives": boundary["primitives"],
            "s_Rd": statistics.median(frontier.seconds_to(run, "Rd") for run in after),
            "s_Rd_random": statistics.median(frontier.seconds_to(run, "Rd") for run in before), "bias": bias, "bias_se": error,
            "from": "measured"}


def rows_of_others(scene, rows):
    """Returns rows of other programs. Original MCML has the bias of the plane, MMC the bias of a total that both programs know. Both sample at
    random."""
    plane = next(row for row in rows if row["method"] == "plane")
    others = [{**plane, "method": "original MCML", "s_Rd": mcml_ratio(scene) * plane["s_Rd_random"], "s_Rd_random": "",
               "from": SPEED if scene == "scan" else FRONTIER}]
    if scene == "scan":
        mesh = next(row for row in rows if row["method"] == "mesh")
        ratio, bias, error = mmc_row()
        others.append({**mesh, "method": "MMC", "s_Rd": ratio * mesh["s_Rd_random"], "s_Rd_random": "", "bias": bias, "bias_se": error,
                       "from": MMC})
    return others


def check_row(scene, truth):
    """Returns the difference of the reference engine from an independent program: in Rd, or in A for MMC."""
    if scene == "scan":
        _, bias, error = mmc_row()
        bias, source = -bias, MMC
    else:
        value, error = independent(scene)
        bias, error = truth["Rd"] / value - 1, math.hypot(truth["Rd_se"], error) / value
        source = "tests/reference/profiles/%s.reentry.csv" % scene
    return {"scene": scene, "method": "independent", "kind": "", "primitives": "", "s_Rd": "", "s_Rd_random": "", "bias": bias,
            "bias_se": error, "from": source}


def measure(program, scenes, quick):
    target, rounds, budget = (0.1, 2, 2) if quick else (0.15, 3, 12)
    begin, table = time.time(), []
    for scene in scenes:
        everything = [frontier.Series(scene, method) for method in scene.methods]
        for series in everything:
            frontier.calibrate(program, series, target)
        for index in range(rounds):
            for series in everything if index % 2 == 0 else everything[::-1]:
                frontier.measure_round(program, None, series, index)
        with concurrent.futures.ThreadPoolExecutor(frontier.CORES) as pool:
            frontier.paired(program, scene, everything, budget, pool)
        cone = frontier.fly(program, scene, scene.methods[1], "after", everything[1].photons["after"] * (2 if quick else 10), 1, False)
        rows = [row_of(series) for series in everything]
        table += rows + rows_of_others(scene.name, rows) + [check_row(scene.name, cone)]
        print("%4.0f s  %s" % (time.time() - begin, scene.name), file=sys.stderr, flush=True)
    return table, rounds


# ---- the chart

def shown_bias(row):
    """Returns (height of the mark, True if it is a limit). A bias hidden by noise stands at two standard errors, with an arrow."""
    bias, error = abs(float(row["bias"])), float(row["bias_se"])
    return (max(2 * error, LEAST), True) if bias < 2 * error else (max(bias, LEAST), bias < LEAST)


def merged(rows):
    """Returns places of marks. Methods that the chart cannot tell apart share a mark, because auto always nearly equals another method."""
    out = []
    for row in rows:
        x, (y, limit) = float(row["s_Rd"]), shown_bias(row)
        for place in out:
            if abs(math.log10(x / place["x"])) < 0.1 and abs(math.log10(y / place["y"])) < 0.25:
                place["names"].append(SHOWN.get(row["method"], row["method"]))
                break
        else:
            out.append({"x": x, "y": y, "limit": limit, "names": [SHOWN.get(row["method"], row["method"])]})
    return out


def label_places(places):
    """(side, decades above the mark) of every name, so that no two names meet: a panel has 116 points per decade of x, 15 of
    y, and letters of 6 x 12 points. Names that would leave the panel stand to the left of their mark."""
    at = [(116 * math.log10(place["x"] / 0.03), 15 * math.log10(place["y"])) for place in places]
    taken, out = [(x - 5, y - (26 if place["limit"] else 6), x + 5, y + 6) for place, (x, y) in zip(places, at)], []
    for place, (x, y) in zip(places, at):
        width = 6 * len(" = ".join(place["names"]))
        for side, up in itertools.product((-1,) if x + width > 348 else (1, -1), (0, 0.9, -0.9)):
            left = x + 8 if side > 0 else x - 8 - width
            box = (left, y + 15 * up - 6, left + width, y + 15 * up + 8)
            if not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken):
                break
        taken.append(box)
        out.append((side, up))
    return out


def panel(axes, rows, scene):
    """Draws one scene. Every place is a mark with its names. An arrow says that a bias is at most as large."""
    check = next(row for row in rows if row["method"] == "independent")
    axes.axhspan(1e-10, abs(float(check["bias"])) + 2 * float(check["bias_se"]), color="#f0f0f0", linewidth=0)
    if scene != "scan":
        old = printed_in_2019(scene)
        axes.axhline(old, color=chart.RED, linestyle="--", linewidth=1)
        axes.text(29, 1.4 * old, "program of 2019 (published curve)", ha="right")
    places = merged([row for row in rows if row["method"] in CHARTED])
    for place, (side, up) in zip(places, label_places(places)):
        theirs = place["names"][0] in (SHOWN["original MCML"], "MMC")
        chart.marks(axes, [place["x"]], [place["y"]], chart.RED if theirs else chart.BLUE, "s" if theirs else "o", 5)
        if place["limit"]:
            axes.annotate("", (place["x"], 0.06 * place["y"]), (place["x"], place["y"]), arrowprops={"arrowstyle": "-|>", "color": "#404040", "shrinkA": 0, "shrinkB": 0})
        axes.annotate(" = ".join(place["names"]), (place["x"], place["y"] * 10 ** up), (6 * side, 0), textcoords="offset points", va="center", ha="left" if side > 0 else "right")


def draw(csv, target):
    """Draws three panels, one below the other, to be read at half the width of a page: hence few marks and large letters."""
    rows, plt = tables.read_csv(csv)[1], picture.begin()
    figure = plt.figure(figsize=(5.83, 8.5))
    figure.text(0.02, 0.97, "Diffuse reflectance Rd: accuracy against speed", fontsize=13)
    figure.text(0.02, 0.925, "blue: this program; red: others; arrows are upper limits of the bias\n"
                "grey: below what other programs can resolve")
    panels = figure.subplots(len(TITLES), sharex=True, sharey=True, gridspec_kw={"left": 0.14, "right": 0.97, "top": 0.885, "bottom": 0.065, "hspace": 0.16})
    for axes, (scene, title) in zip(panels, TITLES.items()):
        axes.set(xscale="log", yscale="log", ylabel="relative bias of Rd")
        axes.set_title(title, loc="left")
        panel(axes, [row for row in rows if row["scene"] == scene], scene)
    chart.powers(panels[0].yaxis, -9, 0, 3)
    chart.powers(panels[0].xaxis, -1, 1, 1)
    panels[0].set(xlim=(0.03, 30), ylim=(1e-10, 2), xticks=(0.1, 1, 10), xticklabels=("0.1", "1", "10"))
    panels[-1].set_xlabel("core seconds to a standard error of 0.1 % in Rd")
    picture.save(figure, target)


def main():
    parser = command.parser(__doc__, "quick")
    command.instead(parser, "--draw", ("CSV", "SVG"), draw, "matplotlib")
    arguments = parser.parse_args()
    begin = time.time()
    with tempfile.TemporaryDirectory() as work:
        program = shutil.copy(arguments.program, work)  # a copy, which nobody rebuilds between two rounds
        scenes = [shape_scene("lohill"), shape_scene("lonoise"), scan_scene(work)]
        table, rounds = measure(program, scenes, arguments.quick)
    header = tables.machine(arguments.program, rounds)
    header += [("length", "quick" if arguments.quick else "full"), ("seconds", "%.0f" % (time.time() - begin)),
               ("load", "%.1f of %d cores" % (os.getloadavg()[1], os.cpu_count()))]
    kept = os.path.join(arguments.out, "summary")
    tables.write_csv(kept + ".csv", header, table)
    chart.draw_result(draw, kept + ".csv", kept + ".svg")


if __name__ == "__main__":
    main()
