"""Commands of the program beside `run`: their answers as Python's numbers and lists.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import warnings
from typing import TYPE_CHECKING, Any, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import errors
from .options import CheckOptions, CrosscheckOptions, ExactOptions, FurnaceOptions, MeshOptions, Path, PlanOptions, TraceOptions, shown
from .program import PREFIX, environment, exits_on_signals, find_program, option_words, raise_failure, renamed, scene_file, scratch_folder
from .scene import Scene
from .sweep import write_table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from typing_extensions import Unpack

DIFFERENT = 1  # exit code of crosscheck and furnace if results disagree
EVENT = {"what": "what happened", "medium": "medium behind it: layer, 0 above", "x": "place", "y": "place", "z": "depth",
         "ux": "direction", "uy": "direction", "uz": "direction, down", "weight": "weight behind it"}  # columns of trace


def say(words: Sequence[str], scratch: str, fine: Sequence[int] = (0,)) -> str:
    """Runs the program and returns its standard output. Notes of the program become warnings. scratch: folder of temporary
    files, whose names messages leave out. fine: exit codes that are no failure."""
    command = [find_program(), *words]
    try:
        with exits_on_signals():
            ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace", env=environment())
    except OSError as error:
        raise errors.InputError(f"{command[0]}: cannot be run ({error.strerror})") from error
    said = [renamed(line, scratch) for line in ended.stderr.splitlines()]
    for note in (line for line in said if line.startswith(PREFIX + "note: ")):
        warnings.warn(note.removeprefix(PREFIX + "note: "), stacklevel=4)
    if ended.returncode not in fine:
        raise_failure(ended.returncode, said)
    return ended.stdout


def _of_scene(command: str, scene: Union[Scene, Path], options: Mapping[str, object], kind: Any, fine: Sequence[int] = (0,),
              words: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Returns the answer of a command for a scene: one dict for each run. For a Scene object the name of the file is left out,
    as the file is temporary."""
    with scratch_folder() as scratch, scene_file(scene, scratch) as path:
        told = say([command, path, "--json", *words, *option_words(options, kind)], scratch, fine)
    runs: list[dict[str, Any]] = [json.loads(line) for line in told.splitlines()]
    for run in runs:
        if isinstance(scene, Scene):
            run.pop("scene", None)
    return runs


def version() -> str:
    """Version of the program, as results store it."""
    return say(["--version"], "").splitlines()[0].removeprefix("clustermcml ")


@shown
def check(scene: Union[Scene, Path], *, sweep: Union[Path, Mapping[str, ArrayLike], pd.DataFrame, None] = None, reweight: bool = False,
          **options: Unpack[CheckOptions]) -> list[dict[str, Any]]:
    """What the program understands of a scene, for each of its runs: layers, boundaries and how they are represented, memory.
    sweep: parameters as mc.sweep takes them, without dim and
    coords, or the path of a table: all its rows are checked, and `sweep` in what is returned says how many these are, and how many
    flights they take, with reweight as in mc.sweep.

    Raises InputError where `run` would refuse it. `clustermcml help check` says what the options do.
    """
    if sweep is None and not reweight:
        return _of_scene("check", scene, options, CheckOptions)
    with scratch_folder() as scratch:
        table = os.path.join(scratch, "sweep.csv")
        if isinstance(sweep, (str, os.PathLike)):
            table = errors.existing_file("sweep", sweep)
        else:
            write_table(sweep, table)
        return _of_scene("check", scene, options, CheckOptions, words=["--sweep", table, *["--reweight"] * reweight])


@shown
def exact(scene: Union[Scene, Path], **options: Unpack[ExactOptions]) -> list[dict[str, Any]]:
    """Rsp, Rd, A, Tt and A_l of the scene with planes in place of all shapes, for each of its runs, without photons; NAME_error is the
    limit of the error."""
    return _of_scene("exact", scene, options, ExactOptions)


@shown
def plan(scene: Union[Scene, Path], **options: Unpack[PlanOptions]) -> list[dict[str, Any]]:
    """How many photons, and how much time, an error takes on this machine, for each run of the scene: target_error=1e-2."""
    return _of_scene("plan", scene, options, PlanOptions)


@shown
def crosscheck(scene: Union[Scene, Path], **options: Unpack[CrosscheckOptions]) -> list[dict[str, Any]]:
    """The same photons flown in several ways, for each run of the scene: the `ways`, and `agree` of all of them and of each with the
    first. dump: a file for the photons that differ."""
    return _of_scene("crosscheck", scene, options, CrosscheckOptions, (0, DIFFERENT))


@shown
def furnace(scene: Union[Scene, Path], **options: Unpack[FurnaceOptions]) -> list[dict[str, Any]]:
    """The scene in diffuse light from both sides, without absorption, for each of its runs: whether light is `even` in all `places`, as it
    must be whatever the shapes."""
    return _of_scene("furnace", scene, options, FurnaceOptions, (0, DIFFERENT))


@shown
def trace(scene: Union[Scene, Path], photon: int, **options: Unpack[TraceOptions]) -> xr.Dataset:
    """Every event of one photon (from 0), alone, with the random numbers that it has in a run with the same options; its attribute
    `end` says what became of it, `seen_by` names the detectors that saw it. `rough_steps`: the facets met at a rough boundary, 0 elsewhere."""
    import xarray as xr
    index = errors.whole("photon", photon, 0, 2**53)
    with scratch_folder() as scratch, scene_file(scene, scratch) as path:
        lines = say(["trace", path, str(index), *option_words(options, TraceOptions)], scratch).splitlines()
    rows: list[list[str]] = []
    rough_steps: list[int] = []  # number of facets, printed before the event
    steps = 0
    for line in lines:
        if line.startswith("# rough: "):
            steps = int(line.split()[2])
        elif not line.startswith("#"):
            rows.append(line.split()[1:])
            rough_steps.append(steps)
            steps = 0
    units = {"x": "cm", "y": "cm", "z": "cm"}
    events = {name: xr.DataArray(np.array([row[k] for row in rows], dtype={"what": str, "medium": int}.get(name, float)), dims="event",
                                 attrs={"units": units.get(name, "1"), "long_name": meaning})
              for k, (name, meaning) in enumerate(EVENT.items())}
    events["rough_steps"] = xr.DataArray(np.array(rough_steps, dtype=int), dims="event",
                                         attrs={"units": "1", "long_name": "facets met at a rough boundary"})
    return xr.Dataset(events, attrs={"photon": index, "end": lines[-1].removeprefix("# "),
                                     "seen_by": [line.split()[3].rstrip(",") for line in lines if line.startswith("# seen by ")]})


@shown
def mesh(scene: Union[Scene, Path], output_dir: Path = ".", **options: Unpack[MeshOptions]) -> list[str]:
    """Writes every boundary that is no plane, and every body, as an OBJ file into a folder, as a run would give it to Embree. Returns the
    paths of the files."""
    folder = errors.folder("output_dir", output_dir)
    with scratch_folder() as scratch, scene_file(scene, scratch) as path:
        said = say(["mesh", path, "-o", folder, *option_words(options, MeshOptions)], scratch)
    return re.findall(r" triangles -> (.*)$", said, re.MULTILINE)


