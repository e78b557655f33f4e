"""Tests README and the tutorial: README's scene gives the summary below it, every command of the tutorial runs, and its numbers are those of the
files. No beam of a scene meets a rough top at one point.

Standard errors that the tutorial states, and the significance of its numbers, are judged with all packets only (long.tutorial)."""
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import manual  # noqa: E402
import warm_python  # noqa: E402
import svg_text  # noqa: E402
from fields import h5py, numpy as np  # noqa: E402

os.environ["PYTHONPATH"] = os.path.join(manual.TOP, "src", "python")  # the package counts as installed; long.pip really installs it
sys.path.insert(0, os.environ["PYTHONPATH"])
SCENE = "samples/two_runs.mci"  # the scene that README explains
TOP, WHOLE, read = manual.TOP, manual.WHOLE, manual.read
MOST_ERRORS = 2 if WHOLE else 5  # standard errors by which a number of the text may be off, beyond its rounding, so that another seed does not make it false


def run(command, folder, text=None):
    done = subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def science(scene):
    """Returns the lines of a scene with numbers. Comments are removed except lines after #@, and blank lines."""
    lines = (re.sub(r"#(?!@).*", "", line) for line in scene.splitlines())
    return [" ".join(line.split()) for line in lines if line.strip()]


def check_readme(verdict, folder):
    indented = [re.sub("^    ", "", part, flags=re.MULTILINE).strip("\n")
                for part in re.findall(r"(?:^    .*\n|^\n(?=    ))+", read("README.md"), re.MULTILINE)]
    scene = next(part for part in indented if "two_runs_flat.mco A" in part)
    summary = next(part for part in indented if part.startswith("two_runs_hill.mco:"))
    verdict.check("README's scene", science(scene) == science(read(SCENE)), "is that of the sample")
    code, output = run([cml.PROGRAM, os.path.join(TOP, SCENE)], folder)
    missing = [line for line in summary.splitlines() if line not in output.splitlines()]
    verdict.check("README's summary", code == 0 and not missing, "\n".join(missing) or f"exit code {code}")


def check_tutorial(verdict, folder):
    """Runs all pages of the tutorial in one folder, because a later page may build on an earlier one."""
    manual.make_tree(folder)
    here = manual.make_folder(folder, "tutorial")
    for name in (name for name in manual.pages() if name.startswith("tutorial/")):
        _, complaint = manual.run_page(name, folder, here)
        verdict.check(name, not complaint, complaint)
        if complaint:
            return
    check_numbers(verdict, here)
    check_beams(verdict, here)
    check_pictures(verdict, here)


def total(path, key):
    """Returns (value, standard error) of a total in an .mco."""
    sections, i = cml.read_sections(path), ("Rsp", "Rd", "A", "Tt").index(key)
    return sections["RAT"][i], sections["se_RAT"][i]


def change(a, b, key):
    (old, old_error), (new, new_error) = total(a, key), total(b, key)
    return new - old, math.hypot(old_error, new_error)


def row_of(table, **cells):
    """Returns Rsp and its error in the row of a sweep that has these cells."""
    with open(table, encoding="utf-8") as file:
        row = next(row for row in csv.DictReader(file) if all(float(row[k.replace("_", ".")]) == v for k, v in cells.items()))
    return float(row["Rsp"]), float(row["Rsp_se"])


def map_of(path, name):
    with h5py.File(path) as file:
        return file[name][:], file[name + "_se"][:], file["x"][:]


def pixel_error(path, pixels):
    """Returns the mean relative error of some pixels of Rd_xy."""
    values, errors, _ = map_of(path, "Rd_xy")
    return float((errors / values)[pixels].mean())


def furrows_ratio():
    """Returns the ratio of Rd_xy where the furrows face the light to Rd_xy where they turn away, with its error. Pixels are chosen as in chapter 5."""
    values, errors, x = map_of("furrows.h5", "Rd_xy")
    heights = 100 * np.fromfile(os.path.join(TOP, "meshes/furrows.gsf"), "<f4")[-64 * 64:].reshape(64, 64)[::-1]
    at = (np.arange(64) - 31.5) * 0.0025
    rises = np.array([np.diff(np.interp([x - 0.003, x + 0.003], at, row, period=0.16), axis=0)[0] for row in heights])
    slopes = np.array([np.interp(x, at, column, period=0.16) for column in rises.T]).T / 0.006
    lit = np.hypot(x, x[:, None]) < 0.17
    (up, up_error), (down, down_error) = ((values[chosen].mean(), np.linalg.norm(errors[chosen]) / chosen.sum())
                                          for chosen in (lit & (slopes > 0.2), lit & (slopes < -0.2)))
    return up / down, up / down * math.hypot(up_error / up, down_error / down)


def over(first, second):
    """Returns the ratio of two (value, error), with its error."""
    ratio = first[0] / second[0]
    return ratio, ratio * math.hypot(first[1] / first[0], second[1] / second[0])


def ring(path, first, last):
    """Returns the light that leaves in the bins first <= i < last of r, times a constant, with its error."""
    sections = cml.read_sections(path)
    weights = [2 * i + 1 for i in range(first, last)]
    return (sum(w * v for w, v in zip(weights, sections["Rd_r"][first:last])),
            math.hypot(*(w * e for w, e in zip(weights, sections["se_Rd_r"][first:last]))))


def mean_of(values, errors, chosen):
    return values[chosen].mean(), np.linalg.norm(errors[chosen]) / chosen.sum()


def bars_contrast():
    """Returns the brightness of two lit bars over that of two dark bars in the middle of bars.h5, and the mean relative error of their pixels."""
    values, errors, x = map_of("bars.h5", "Rd_xy")
    middle = np.abs(0.025 * (np.arange(12) - 5.5))[:, None] < 0.05
    lit, dark = (middle & (np.abs(x) < 0.1) & (np.floor(x / 0.05) % 2 == parity) for parity in (0, 1))
    return over(mean_of(values, errors, lit), mean_of(values, errors, dark)), float((errors / values)[lit | dark].mean())


def camera_shade():
    """Returns the brightness of the hill's shaded side over that of level ground in camera.h5, and the median relative error of a pixel."""
    with h5py.File("camera.h5") as file:
        values, errors, x, y = (file["detector_cam_" + name][:] for name in ("map", "map_se", "x", "y"))
    x, y = np.meshgrid(x, y)
    shade, level = (np.abs(x + 0.25) < 0.1) & (np.abs(y) < 0.15), y > 0.35
    return over(mean_of(values, errors, shade), mean_of(values, errors, level)), float(np.median(errors / values))


def tutorial_numbers():
    """Yields (text of the tutorial, numbers of its groups with their allowed errors). The files are in the current folder."""
    lower, higher = change("rough.mco", "level.mco", "A"), change("level.mco", "rough.mco", "Rd")
    yield (r"A is lower by (\S+) \+- (\S+), (\S+) % of it, Rd higher by (\S+) \+- (\S+);",
           (lower, (lower[1], 0), (100 * lower[0] / total("level.mco", "A")[0], 100 * lower[1]), higher, (higher[1], 0)))
    last = [cml.read_sections(name)["Rd_a"][-1] for name in ("level.mco", "rough.mco")]
    error = [cml.read_sections(name)["se_Rd_a"][-1] for name in ("level.mco", "rough.mco")]
    ratio = last[1] / last[0]
    yield r"the horizon (\S+) times as", ((ratio, ratio * math.hypot(error[0] / last[0], error[1] / last[1])),)
    points = measured_points()
    yield (r"errors, (\d+) to (\d+) %, are", tuple((100 * bound(e / v for v, e, _ in points), 0) for bound in (min, max)))
    yield r"of these (\d+) points (\d+) do", ((len(points), 0), (sum(abs(v - truth) <= e for v, e, truth in points), 0))
    values, _, x = map_of("scan.h5", "Rd_xy")
    yield r"on average (\S+) cm to the right", ((float((values * x).sum() / values.sum()), 1e-4 * WHOLE),)
    yield r"give an error of (\d+) % in its middle", ((100 * pixel_error("scan.h5", (slice(18, 22), slice(20, 40))), 0.5 * WHOLE),)
    yield r"light are known to (\S+) %, which", ((100 * pixel_error("furrows.h5", slice(14, 66)), 0.5 * WHOLE),)
    ratio, error = furrows_ratio()
    yield r"in the mean (\d+) \+- (\d+) % higher", ((100 * (ratio - 1), 100 * error), (100 * error, 0))
    yield (r"plane would mirror (\S+) \(`check` prints it\), the texture mirrors (\S+),",
           ((flat_rsp(os.path.join(TOP, "samples/furrows.mci")), 0), total("furrows.mco", "Rsp")))
    vessel = cml.read_sections("vessel.mco")
    yield r"vessel absorbs, (\S+)\. A of the summary, (\S+), is", ((vessel["A_body"][0], 0), (vessel["RAT"][2], 0))
    yield r"A of the summary, (\S+), is that of the tissue and the vessel together", ((vessel["A_body"][0] + sum(vessel["A_l"]), 0),)
    yield r"one of 0.28 cm would lose (\d+) % of the light below", ((100 * thin_loss(), 0),)
    at = {(a, h): row_of("heights.sweep.csv", beam_angle=a, boundary0_height=h) for a in (0, 60) for h in (0, 0.5, 1, 2)}
    yield (r"that of a plane, (\S+), to within 2 % .* twice that: (\S+) \+- (\S+)\. At 60 degrees a plane mirrors (\S+)\. Low furrows "
           r"mirror more, (\S+) \+- (\S+) at .* less, (\S+) \+- (\S+) as they are and (\S+) \+- (\S+) at twice",
           (at[0, 0], at[0, 2], (at[0, 2][1], 0), at[60, 0], *(pair for h in (0.5, 1, 2) for pair in (at[60, h], (at[60, h][1], 0)))))
    thin, (said,) = cml.read_sections("thin.mco"), objects("check", "thin.mci")
    own, error, mean = thin["A_l"][0], thin["se_A_l"][0], said["layers"][0]["mean_d"]
    nominal, flat = (objects("exact", "thin.mci", "--set", f"layer1.d={d}")[0]["A_l"][0] for d in (said["layers"][0]["d"], mean))
    yield (r"Layer 1 absorbs (\S+) \+- (\S+)\. Nominally flat it absorbs (\S+), (\S+) % more; .* it is (\S+) cm thick in the mean, (\S+) % less than its d, .* "
           r"flat one absorbs (\S+): the roughness itself does (\S+) %\. `shift=0,0,(\S+)`",
           ((own, error), (error, 0), (nominal, 0), (100 * (nominal / own - 1), 100 * error / own), (mean, 0), (100 * (1 - mean / said["layers"][0]["d"]), 0),
            (flat, 0), (100 * (1 - own / flat), 100 * error / flat), (-said["boundaries"][0]["mean_height"], 0)))
    patch = objects("check", "rough.mci")[0]
    yield (r"mean height of the patch is (\S+) cm, so that the epidermis is as thick as the level one to (\S+) %",
           ((patch["boundaries"][0]["mean_height"], 0), (100 * (patch["layers"][0]["mean_d"] / patch["layers"][0]["d"] - 1), 0)))
    near, away = (over(ring("fibre.mco", *bins), ring("wide.mco", *bins)) for bins in ((0, 4), (60, 79)))
    yield (r"narrow cone brings (\S+) \+- (\S+) times as much light back\. Between 0\.3 and 0\.4 cm it brings (\S+) \+- (\S+) times",
           (near, (near[1], 0), away, (away[1], 0)))
    contrast, pixel = bars_contrast()
    yield r"are only (\S+) \+- (\S+) times as bright in .* A pixel there is known to (\S+) %\.", (contrast, (contrast[1], 0), (100 * pixel, 0))
    shade, pixel = camera_shade()
    yield (r"typical one is known to (\S+) % .* are (\S+) \+- (\S+) times as bright as the level ground",
           ((100 * pixel, 0), shade, (shade[1], 0)))
    fibres = cml.read_sections("fibres.mco")
    far = fibres["detector_far_path"][2], fibres["se_detector_far_path"][2]
    yield r"all of its way, (\S+) \+- (\S+) cm, lies in the dermis", (far, (far[1], 0))
    deep = cml.read_sections("deep.mco")
    yield r"gives Tt as (\S+) \+- (\S+) millionths", ((1e6 * deep["Tt_expected"][0], 0), (1e6 * deep["se_Tt_expected"][0], 0))
    with open("scene.mci", encoding="utf-8") as file:
        scene = file.read()
    scan, number, flat = total("ground.mco", "Rd"), total("scene.mco", "Rd"), objects("exact", "scene.mci", "--set", "boundary0.alpha=0")[0]["Rd"]
    yield (r"Sdq of this scan is (\S+)\. Light on the scan gives Rd = (\S+) \+- (\S+), and light on the number (\S+) \+- (\S+)\. A smooth slab has (\S+)\.",
           ((float(re.search(r"^rough beckmann (\S+)", scene, re.MULTILINE)[1]), 0), scan, (scan[1], 0), number, (number[1], 0), (flat, 0)))
    remote = cml.read_sections("remote.mco")
    yield r"It sees (\S+) \+- (\S+) hundred-millionths", ((1e8 * remote["detector_remote"][0], 0), (1e8 * remote["se_detector_remote"][0], 0))


def measured_points():
    """Returns [(value, error, value of the long run)] of the points that stand for measurements in chapter 4."""
    curve = cml.read_sections("flat.mco")["Rd_r"]
    with open("measured.csv", encoding="utf-8") as file:
        return [(float(row["Rd_r"]), float(row["Rd_r_se"]), curve[int(float(row["r_mid_cm"]) / 0.01)]) for row in csv.DictReader(file)]


def objects(*words):
    """Returns the objects that a command prints with --json, one for every run."""
    return [json.loads(line) for line in run([cml.PROGRAM, *words, "--json"], ".")[1].splitlines()]


def flat_rsp(scene):
    return objects("check", scene)[0]["flat"]["Rsp"]


def thin_loss():
    """Returns the transmittance of the last row of chapter 9 with the dermis of chapter 1, by adding-doubling."""
    with open("skin.csv", encoding="utf-8") as file:
        names, *_, last = csv.reader(file, skipinitialspace=True)
    cells = [word for name, value in zip(names, last) if "." in name for word in ("--set", f"{name}={value}")]
    return objects("exact", "flat.mci", *cells)[0]["Tt"]


def agrees(said, value, error):
    half = 0.5 * 10.0 ** -len(said.partition(".")[2])
    return abs(float(said) - value) <= half * (1 + 1e-9) + MOST_ERRORS * error


def check_numbers(verdict, folder):
    """Checks the numbers of the tutorial against the results that its commands have left, and that they are more than noise."""
    os.chdir(folder)
    text = " ".join(" ".join(manual.page(name) for name in manual.pages() if name.startswith("tutorial/")).split())
    for pattern, numbers in tutorial_numbers():
        said = re.search(pattern, text)
        verdict.check("tutorial", said, f"has no words like {pattern}")
        for word, (value, error) in zip(said.groups() if said else (), numbers):
            if not error and not WHOLE:  # the number is an error, or exact
                continue
            verdict.check("tutorial", agrees(word, value, error), f"says {word}, files {value:.6g} +- {error:.2g}: {said[0]}")
    if WHOLE:
        check_significance(verdict)


def check_significance(verdict):
    for key, sign in (("A", -1), ("Rd", 1)):
        value, error = change("level.mco", "rough.mco", key)
        verdict.check("tutorial, ridges", sign * value > 3 * error, f"{key} changes by {value:.2g} +- {error:.2g}")
    value, error = change("level.mco", "rough.mco", "Tt")
    verdict.check("tutorial, ridges", abs(value) < 2 * error, f"Tt changes by {value:.2g} +- {error:.2g}")
    for what, (value, error) in (("fibre", over(ring("fibre.mco", 0, 4), ring("wide.mco", 0, 4))), ("bars", bars_contrast()[0]), ("camera", camera_shade()[0])):
        verdict.check(f"tutorial, {what}", abs(value - 1) > 5 * error, f"a ratio of {value:.3g} +- {error:.2g} is noise")
    off = sorted(abs(value - truth) / error for value, error, truth in measured_points())
    verdict.check("tutorial, measured.csv", off[-1] < 4 and off[len(off) // 2] < 1.5, f"lies off by {off} errors")
    with open("spectrum.sweep.csv", encoding="utf-8") as file:
        loss = max(float(row["Tt"]) for row in csv.DictReader(file))
    verdict.check("tutorial, spectrum", loss < 1e-5, f"{loss} of the light is lost below")


def check_beams(verdict, folder):
    """Checks that no scene of the samples or the tutorial has a pencil on a mesh at its top, because a pencil meets one point of the mesh."""
    scenes = [os.path.join(where, name) for where in (folder, os.path.join(TOP, "samples")) for name in os.listdir(where)]
    for scene in sorted(name for name in scenes if name.endswith(".mci")):
        status, output = run([cml.PROGRAM, "check", scene, "--json"], folder)
        kinds = [json.loads(line)["boundaries"][0]["kind"] for line in output.splitlines()] if status == 0 else []
        with open(scene, encoding="utf-8") as file:
            wide = re.search("^(#@ )?beam (disk|gaussian|rectangle)", file.read(), re.MULTILINE)
        verdict.check(scene, wide or "mesh" not in kinds, "lights one point of a mesh")


def check_pictures(verdict, folder):
    """Checks that pictures can be read, also on a dark page."""
    for name in sorted(name for name in os.listdir(folder) if name.endswith(".svg")):
        faults, texts = svg_text.faults_of(svg_text.tree.parse(os.path.join(folder, name)).getroot())
        verdict.check(name, texts > 0 and not faults, "; ".join(faults))


def main():
    verdict = cml.Verdict("tutorial")
    warm_python.start()
    for check in (check_readme, check_tutorial):
        with tempfile.TemporaryDirectory() as folder:
            check(verdict, folder)
    verdict.finish()


main()
