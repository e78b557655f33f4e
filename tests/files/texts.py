"""What the texts for users promise: README's scene gives the summary that stands below it, every command of
samples/tutorial.md runs, one after the other, and the readers of samples/output.md read what a run leaves."""
import json
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py  # noqa: E402

TOP = os.path.dirname(cml.TESTS)
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SCENE = "samples/two_runs.mci"  # which README explains


def read(path):
    with open(os.path.join(TOP, path), encoding="utf-8") as file:
        return file.read()


def blocks(path):
    """[(language, code), ...] of a text."""
    return FENCED.findall(read(path))


def run(command, folder, text=None):
    done = subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def science(scene):
    """The numbers of a scene: no comments but those that are ours, no blank lines."""
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
    """In a tree like the repository's: build/clustermcml, meshes, samples."""
    os.makedirs(os.path.join(folder, "build"))
    os.symlink(cml.PROGRAM, os.path.join(folder, "build", "clustermcml"))
    for name in ("meshes", "samples"):
        os.symlink(os.path.join(TOP, name), os.path.join(folder, name))
    here = folder
    for number, (language, code) in enumerate(blocks("samples/tutorial.md")):
        where = f"tutorial.md, block {number + 1}"
        shell = f"set -eu\ncd '{here}'\nPATH='{folder}/build':$PATH\n{code}\npwd >'{folder}/where'\n"
        command = ["sh", "-c", shell] if language == "sh" else [sys.executable, "-c", code]
        status, output = run(command, here)
        verdict.check(where, status == 0, f"exit code {status}\n{code}\n{output}")
        if status != 0:
            return
        if language == "sh":
            with open(os.path.join(folder, "where"), encoding="utf-8") as file:
                here = file.read().strip()
    verdict.check("tutorial.md", os.path.basename(here) == "tutorial", here)


def check_readers(verdict, folder):
    status, output = run([cml.PROGRAM, os.path.join(TOP, "samples/skinmap.mci"), "--photons", "2e4", "--json"], folder)
    verdict.check("skinmap", status == 0, output)
    check_names(verdict, folder, json.loads(output))
    for language, code in blocks("samples/output.md"):
        if language == "python":
            status, output = run([sys.executable, "-c", code], folder)
            verdict.check("output.md, Python", status == 0 and "Rd = " in output, output)


def check_names(verdict, folder, record):
    """Every key of the JSON line, every path of the .h5 and every section of the .mco stands in output.md."""
    names = set(record) | {key for boundary in record["boundaries"] for key in boundary}
    with h5py.File(os.path.join(folder, "skinmap.h5")) as file:
        names |= {re.sub(r"^boundary\d+_(outer_)?", "boundary0_", name) for name in file} | set(file.attrs)
    names |= {name for name in cml.read_sections(os.path.join(folder, "skinmap.mco")) if name.isidentifier()}
    known = set(re.findall(r"\w+", read("samples/output.md").replace("_above`, `_below", "_above` `boundary0_irradiance_below`"
                                                                    " `boundary0_exitance_below")))
    missing = {name for name in names if name not in known and re.sub("(_control)?(_se)?$", "", name) not in known}
    verdict.check("output.md", not missing, f"does not name {sorted(missing)}")


def main():
    verdict = cml.Verdict("texts")
    for check in (check_readme, check_tutorial, check_readers):
        with tempfile.TemporaryDirectory() as folder:
            check(verdict, folder)
    verdict.finish()


main()
