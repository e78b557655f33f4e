"""Commands of the program beside `run`: their answers as Python's numbers and lists.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import errors, library
from .options import CheckOptions, CrosscheckOptions, ExactOptions, FurnaceOptions, MeshOptions, Path, PlanOptions, TraceOptions, option_words, shown
from .program import find_program, say
from .scene import Scene
from .scene_files import as_file, scratch_folder
from .sweep import _table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from typing_extensions import Unpack

DIFFERENT = 1  # exit code of crosscheck and furnace if results disagree
EVENT = {"what": "what happened", "medium": "medium behind it: layer, 0 above", "x": "place", "y": "place", "z": "depth",
         "ux": "direction", "uy": "direction", "uz": "direction, down", "weight": "weight behind it", "rough_steps": "facets met at a rough boundary"}  # columns of trace


def _of_scene(command: str, scene: Union[Scene, Path], options: Mapping[str, object], kind: Any, fine: Sequence[int] = (0,),
              words: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Returns the answer of a command for a scene: one dict for each run. `check` and `exact` need no process, unless it shall refuse their options.
    For a Scene object the name of the file is left out, as the file is temporary."""
    given = option_words(options, kind)
    loaded = library.find(find_program(), [*words, *given]) if command in ("check", "exact") and set(options) <= set(kind.__annotations__) else None
    if loaded:
        with library.Runs(loaded, scene, [*given, *["--ignore-heightfields"] * (command == "exact")]) as held:
            told = held.told(command == "exact")
    else:
        with as_file(scene) as (path, scratch):
            told = say([command, path, "--json", *words, *given], scratch, fine=fine)
    hidden = "scene" if isinstance(scene, Scene) else ""
    return [{key: value for key, value in json.loads(line).items() if key != hidden} for line in told]


def version() -> str:
    """Version of the program, as results store it."""
    return say(["--version"], "")[0].removeprefix("clustermcml ")


@shown
def check(scene: Union[Scene, Path], *, sweep: Union[Path, Mapping[str, ArrayLike], pd.DataFrame, None] = None, reweight: bool = False,
          **options: Unpack[CheckOptions]) -> list[dict[str, Any]]:
    """Says what the program understands of a scene, without simulating it.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        sweep: Parameters as `sweep` takes them, or the path of a table; all its rows are checked.
        reweight: As of `sweep`.
        **options: Options of the program; `clustermcml help check` lists them.

    Returns:
        A list with a dict for each run: layers, boundaries and how they are represented, memory_bytes and more. With `sweep` the
            key `sweep` has the numbers of rows and flights.

    Raises:
        InputError: `run` would refuse the scene.
    """
    if sweep is None and not reweight:
        return _of_scene("check", scene, options, CheckOptions)
    with scratch_folder() as scratch:
        table = os.path.join(scratch, "sweep.csv")
        if isinstance(sweep, (str, os.PathLike)):
            table = errors.existing_file("sweep", sweep)
        else:
            with open(table, "w", encoding="utf-8") as file:
                file.write(_table(sweep, None, ()).text())
        return _of_scene("check", scene, options, CheckOptions, words=["--sweep", table, *["--reweight"] * reweight])


@shown
def exact(scene: Union[Scene, Path], **options: Unpack[ExactOptions]) -> list[dict[str, Any]]:
    """Computes the totals of a scene without photons, with planes in place of all shapes.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        **options: Options of the program; `clustermcml help exact` lists them.

    Returns:
        A list with a dict for each run: Rsp, Rd, A, Tt and A_l. NAME_error is the limit of the error of NAME. `planes` are the numbers of the
            boundaries whose shape is ignored; a warning names them.
    """
    answers = _of_scene("exact", scene, options, ExactOptions)
    flattened = sorted({boundary for answer in answers for boundary in answer["planes"]})
    if flattened:
        errors.warn("exact: a plane stands for boundary " + ", ".join(map(str, flattened)))
    return answers


@shown
def plan(scene: Union[Scene, Path], **options: Unpack[PlanOptions]) -> list[dict[str, Any]]:
    """Says how many photons, and how much time, an error takes on this machine.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        **options: Options of the program, such as target_error=1e-2; `clustermcml help plan` lists them.

    Returns:
        A list with a dict for each run, whose `plans` has an entry for each engine and sampling.
    """
    return _of_scene("plan", scene, options, PlanOptions)


@shown
def crosscheck(scene: Union[Scene, Path], **options: Unpack[CrosscheckOptions]) -> list[dict[str, Any]]:
    """Simulates the same photons in several ways and compares the results.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        **options: Options of the program; dump is a file for the photons that differ.

    Returns:
        A list with a dict for each run: the `ways`, and `agree`, which is whether all ways agree with the first.
    """
    return _of_scene("crosscheck", scene, options, CrosscheckOptions, (0, DIFFERENT))


@shown
def furnace(scene: Union[Scene, Path], **options: Unpack[FurnaceOptions]) -> list[dict[str, Any]]:
    """Tests the shapes of a scene in diffuse light from both sides, without absorption, which must be equally bright everywhere.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        **options: Options of the program; `clustermcml help furnace` lists them.

    Returns:
        A list with a dict for each run: `places`, and `even`, which is whether the light is even in all of them.
    """
    return _of_scene("furnace", scene, options, FurnaceOptions, (0, DIFFERENT))


@shown
def trace(scene: Union[Scene, Path], photon: int, **options: Unpack[TraceOptions]) -> xr.Dataset:
    """Simulates one photon and returns all its events.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        photon: Number of the photon, from 0. It has the random numbers that it has in a run with the same options.
        **options: Options of the program; `clustermcml help trace` lists them.

    Returns:
        An xarray.Dataset over `event`: what, medium, x, y, z, ux, uy, uz, weight, and rough_steps, the facets met at a rough boundary. The
            attribute `end` says what became of the photon, and `seen_by` names the detectors that saw it.
    """
    import xarray as xr
    index = errors.whole("photon", photon, 0, 2**53)
    with as_file(scene) as (path, scratch):
        lines = say(["trace", path, str(index), *option_words(options, TraceOptions)], scratch)
    rows: list[list[Any]] = []
    steps = 0  # number of facets, printed before the event
    for line in lines:
        if line.startswith("# rough: "):
            steps = int(line.split()[2])
        elif not line.startswith("#"):
            rows.append([*line.split()[1:10], steps])
            steps = 0
    units = {"x": "cm", "y": "cm", "z": "cm"}
    events = {name: xr.DataArray(np.array([row[k] for row in rows], dtype={"what": str, "medium": int, "rough_steps": int}.get(name, float)), dims="event",
                                 attrs={"units": units.get(name, "1"), "long_name": meaning})
              for k, (name, meaning) in enumerate(EVENT.items())}
    return xr.Dataset(events, attrs={"photon": index, "end": lines[-1].removeprefix("# "),
                                     "seen_by": [line.split()[3].rstrip(",") for line in lines if line.startswith("# seen by ")]})


@shown
def mesh(scene: Union[Scene, Path], output_dir: Path = ".", **options: Unpack[MeshOptions]) -> list[str]:
    """Writes every boundary that is not a plane, and every body, as an OBJ file.

    Args:
        scene: A Scene, or the path of an `.mci` file.
        output_dir: Folder for the files.
        **options: Options of the program; `clustermcml help mesh` lists them.

    Returns:
        The paths of the files.
    """
    folder = errors.folder("output_dir", output_dir)
    with as_file(scene) as (path, scratch):
        said = say(["mesh", path, "-o", folder, *option_words(options, MeshOptions)], scratch)
    return [line.partition(" triangles -> ")[2] for line in said if " triangles -> " in line]


