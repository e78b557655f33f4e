"""Tests the pages of the manual. Each block that can be run runs, except blocks of the tutorial, which tutorial.py runs.

Pages of input must have the program's own table of keys. Pages of output must name every key of JSON, every array and attribute of a result, and
the arrays that have standard errors."""
import json
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import manual  # noqa: E402
import warm_python  # noqa: E402
from fields import h5py  # noqa: E402

os.environ["PYTHONPATH"] = os.path.join(manual.TOP, "src", "python")  # the package counts as installed; long.pip really installs it
sys.path.insert(0, os.environ["PYTHONPATH"])


def run(*words, folder="."):
    done = subprocess.run([cml.PROGRAM, *words], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def check_blocks(verdict):
    with tempfile.TemporaryDirectory() as tree:
        manual.make_tree(tree)
        for name in manual.pages():
            if name.startswith("tutorial/"):
                continue
            _, complaint = manual.run_page(name, tree, manual.make_folder(tree, name))
            verdict.check(name, not complaint, complaint)


def rows_of(text):
    return [line for line in text.splitlines() if line.startswith("| `")]


def check_keys(verdict):
    """Each row of `help keys` stands in samples/manual/input as it is, and as often."""
    written = [row for name in manual.pages() if name.startswith("input/") for row in rows_of(manual.page(name))]
    rows = rows_of(run("help", "keys")[1])
    verdict.check("keys", len(rows) > 100, f"{len(rows)} rows")
    for row in set(rows):
        verdict.check("keys", written.count(row) == rows.count(row), f"stand {written.count(row)} times in samples/manual/input: {row}")


def output_text():
    return "\n".join(manual.page(name) for name in manual.pages() if name.startswith("output/"))


def check_names(verdict, folder):
    """Checks that the pages of output name every key of the JSON line, every path of the .h5 and every section of the .mco."""
    status, output = run(os.path.join(manual.TOP, "samples/skinmap.mci"), "--photons", "2e4", "--json", folder=folder)
    verdict.check("skinmap", status == 0, output)
    record = json.loads(output)
    names = set(record) | {key for boundary in record["boundaries"] for key in boundary}
    with h5py.File(os.path.join(folder, "skinmap.h5")) as file:
        names |= {re.sub(r"^boundary\d+_(outer_)?", "boundary0_", name) for name in file} | set(file.attrs)
    sections = cml.read_sections(os.path.join(folder, "skinmap.mco"))
    names |= {re.sub(r"^(se_)?boundary\d+_(outer_)?", r"\1boundary0_", name) for name in sections if name.isidentifier()}
    known = set(re.findall(r"\w+", output_text()))
    missing = {name for name in names if name not in known and re.sub("^se_|_se$", "", name) not in known}
    verdict.check("output", not missing, f"no page names {sorted(missing)}")


def check_errors(verdict, folder):
    """The page on standard errors names each array of a scene with maps, voxels, bodies and facets that has one, and no array that
    has none."""
    scene = re.sub("^map .*", "map 8 8 0.1 0.1 angles volume", manual.read("samples/vein.mci"), flags=re.MULTILINE)
    path = os.path.join(folder, "errors.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write(scene.replace("../meshes", os.path.join(manual.TOP, "meshes")).replace("vein.mco", "errors.mco"))
    status, output = run(path, "--photons", "1e3", "--quiet", folder=folder)
    verdict.check("errors.mci", status == 0, output)
    with h5py.File(os.path.join(folder, "errors.h5")) as file:
        scored = {re.sub("(?:boundary[0-9]|body)_(irradiance|exitance)_.*", r"\1", name): name + "_se" in file
                  for name in file if not name.endswith(("_se", "_outside"))}
    named = {name for row in manual.page("output/standard-errors.md").splitlines() if row.count("|") == 3
             for name in re.findall(r"`(\w+)`", row.split("|")[2])}
    verdict.check("errors", len(named) > 40, f"{len(named)} arrays are named")
    for name, has in scored.items():
        verdict.check("errors", has == (name in named), f"{name} has {'an' if has else 'no'} error, and the page says otherwise")


def main():
    verdict = cml.Verdict("manual")
    warm_python.start()
    check_keys(verdict)
    with tempfile.TemporaryDirectory() as folder:
        check_names(verdict, folder)
        check_errors(verdict, folder)
    check_blocks(verdict)
    verdict.finish()


main()
