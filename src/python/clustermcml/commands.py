"""Commands of the program beside `run`: what they say with --json, as Python's own numbers and lists.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import warnings
from typing import Any, Sequence, Union

import xarray as xr

from . import errors
from .program import PREFIX, find_program, option_words, raise_failure, renamed, scene_file
from .results import read
from .scene import Scene

Path = Union[str, os.PathLike[str]]
DIFFERENT = 1  # exit code of compare where two results disagree


def _say(words: Sequence[str], scratch: str, fine: Sequence[int] = (0,)) -> str:
    """What the program prints. Its notes are warnings. scratch: a folder whose files are not named. fine: exit codes of no failure."""
    command = [find_program(), *words]
    try:
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace")
    except OSError as error:
        raise errors.InputError(f"{command[0]}: cannot be run ({error.strerror})") from error
    said = [renamed(line, scratch) for line in ended.stderr.splitlines()]
    for note in (line for line in said if line.startswith(PREFIX + "note: ")):
        warnings.warn(note.removeprefix(PREFIX + "note: "), stacklevel=4)
    if ended.returncode not in fine:
        raise_failure(ended.returncode, said)
    return ended.stdout


def _of_scene(command: str, scene: Union[Scene, Path], options: dict[str, Any]) -> list[dict[str, Any]]:
    """What a command says of a scene, one dict a run. The file of an object is gone afterwards, so its name is left out."""
    with tempfile.TemporaryDirectory(prefix="clustermcml_") as scratch, scene_file(scene, scratch) as path:
        told = _say([command, path, "--json", *option_words(options)], scratch)
    runs: list[dict[str, Any]] = [json.loads(line) for line in told.splitlines()]
    for run in runs:
        if isinstance(scene, Scene):
            run.pop("scene", None)
    return runs


def version() -> str:
    """Of the program, as results have it."""
    return _say(["--version"], "").splitlines()[0].removeprefix("clustermcml ")


def check(scene: Union[Scene, Path], **options: Any) -> list[dict[str, Any]]:
    """What the program understands of a scene, for each of its runs: layers, boundaries and how they are represented, memory.

    Raises InputError where `run` would refuse it. Options as of `run`: `clustermcml help check` lists them.
    """
    return _of_scene("check", scene, options)


def exact(scene: Union[Scene, Path], **options: Any) -> list[dict[str, Any]]:
    """Rsp, Rd, A, Tt and A_l of the scene with planes in place of all shapes, for each of its runs, without photons; NAME_error is the
    limit of the error."""
    return _of_scene("exact", scene, options)


def plan(scene: Union[Scene, Path], **options: Any) -> list[dict[str, Any]]:
    """How many photons, and how much time, an error takes on this machine, for each run of the scene: target_error=1e-2."""
    return _of_scene("plan", scene, options)


def compare(a: Path, b: Path, **options: Any) -> dict[str, Any]:
    """Whether two results (.mco, .h5) agree within their noise: what `clustermcml compare --json` says, and `agree`."""
    words = ["compare", errors.existing_file("a", a), errors.existing_file("b", b), "--json", *option_words(options)]
    told: dict[str, Any] = json.loads(_say(words, "", (0, DIFFERENT)))
    return told


def merge(results: Sequence[Path], output: Path) -> xr.Dataset:
    """Joins results of one scene that were flown with different seeds into the file `output` (.mco or .h5), and reads it."""
    if isinstance(results, str) or not isinstance(results, Sequence):
        raise errors.refuse("results", results, "a list of paths")
    files = [errors.existing_file(f"results[{i}]", path) for i, path in enumerate(results)]
    if not isinstance(output, (str, os.PathLike)) or os.path.splitext(output)[1].lower() not in (".mco", ".h5"):
        raise errors.refuse("output", output, "a name that ends in .mco or .h5")
    _say(["merge", *files, "--quiet", "--output", os.path.abspath(os.fspath(output))], "")
    return read(output)
