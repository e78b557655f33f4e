"""Reads the pages of the manual and runs their blocks: scenes (```mci), commands (```sh) and Python (```python).

The blocks of a page run in order, in one folder. Other blocks (```text, ```c) are only read. Every run of 1e5 packets or more gets an eighth of
them, unless ALL_CASES is in the environment.

SPDX-License-Identifier: MIT"""
import contextlib
import glob
import io
import os
import re
import subprocess
import sys
import traceback

import cml

TOP = os.path.dirname(cml.TESTS)
MANUAL = os.path.join(TOP, "samples", "manual")
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
WHOLE = "ALL_CASES" in os.environ


def read(path):
    with open(os.path.join(TOP, path), encoding="utf-8") as file:
        return file.read()


def pages():
    """Returns the paths of all pages below samples/manual, sorted."""
    return sorted(os.path.relpath(path, MANUAL) for path in glob.glob(os.path.join(MANUAL, "**", "*.md"), recursive=True))


def page(name):
    return read(os.path.join("samples", "manual", name))


def blocks(text):
    """Returns the fenced blocks of a page: [(language, code), ...]."""
    return FENCED.findall(text)


def fewer(text):
    """Returns commands, Python or a scene with fewer photons: an eighth of 1e5 or more."""
    def eighth(match):
        return match[1] + (match[2] if WHOLE or float(match[2]) < 1e5 else str(cml.repeats(round(float(match[2]))) // 2))
    return re.sub(r"(--photons |--more |photons=|\.(?:mco|h5)\s+[AB]\b[^\n]*\n\s*)([\d.]+(?:e\d+)?)", eighth, text)


def make_tree(folder):
    """Makes a tree like the repository's: build/clustermcml, meshes, samples."""
    os.makedirs(os.path.join(folder, "build"))
    os.makedirs(os.path.join(folder, "samples"))
    os.symlink(cml.PROGRAM, os.path.join(folder, "build", "clustermcml"))
    with open(os.path.join(folder, "build", "python3"), "w", encoding="utf-8") as file:
        file.write(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    os.chmod(file.name, 0o755)
    os.symlink(os.path.join(TOP, "meshes"), os.path.join(folder, "meshes"))
    for name in os.listdir(os.path.join(TOP, "samples")):
        path = os.path.join(folder, "samples", name)
        if name.endswith(".mci"):
            with open(path, "w", encoding="utf-8") as file:
                file.write(fewer(read(os.path.join("samples", name))))
        else:
            os.symlink(os.path.join(TOP, "samples", name), path)


def make_folder(tree, name):
    """A folder for the blocks of pages, with the samples and meshes in it."""
    here = os.path.join(tree, "run", name)
    os.makedirs(here)
    for other in ("meshes", "samples"):
        os.symlink(os.path.join(tree, other), os.path.join(here, other))
    return here


def run_scene(code, tree, here):
    """Saves a scene under the name in its first comment, `# NAME.mci`, and runs it. Its results go to a folder where they do no harm."""
    name = (re.match(r"# *([\w-]+\.mci)\b", code) or ["", "scene.mci"])[1]
    with open(os.path.join(here, name), "w", encoding="utf-8") as file:
        file.write(code)
    words = [cml.PROGRAM, name, "--photons", "200", "--quiet", "-o", os.path.join(tree, "tried")]
    done = subprocess.run(words, cwd=here, capture_output=True, text=True, check=False)
    return here, done.returncode == 0, done.stdout + done.stderr


def run_shell(code, tree, here):
    where = os.path.join(tree, "where")
    shell = f"set -eu\ncd '{here}'\nPATH='{tree}/build':$PATH\n{code}\npwd >'{where}'\n"
    done = subprocess.run(["sh", "-c", shell], cwd=here, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        with open(where, encoding="utf-8") as file:
            here = file.read().strip()
    return here, done.returncode == 0, done.stdout + done.stderr


def run_python(code, names, here):
    said, home = io.StringIO(), os.getcwd()
    try:
        os.chdir(here)
        with contextlib.redirect_stdout(said):
            exec(code, names)
    except Exception:
        return here, False, said.getvalue() + traceback.format_exc(limit=-1)
    finally:
        os.chdir(home)
    return here, True, said.getvalue()


def run_page(name, tree, here):
    """Runs all blocks of a page that can run. Returns the folder in which the commands have ended, and a complaint, "" if all ran."""
    import clustermcml
    names = {"mc": clustermcml}
    for number, (language, code) in enumerate(blocks(page(name)), 1):
        few = fewer(code)
        if language == "mci":
            here, right, said = run_scene(few, tree, here)
        elif language == "sh":
            here, right, said = run_shell(few, tree, here)
        elif language == "python":
            here, right, said = run_python(few, names, here)
        else:
            continue
        if not right:
            return here, f"block {number} of {name} fails:\n{code}\n{said}"
    return here, ""
