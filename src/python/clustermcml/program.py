"""Runs the program on a scene and reads what it leaves.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import importlib.resources
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from typing import Any, Iterator, NoReturn, Optional, Sequence, Union

import xarray as xr

from . import errors
from .progress import Progress
from .results import read
from .scene import Scene

PREFIX = "clustermcml: "
MEASURED = ("seconds", "cpu_s", "steps", "photons_per_s", "threads", "ranks")  # keys of --json that become attributes


def find_program() -> str:
    """The path of the program: $CLUSTERMCML, else the one in this package, else the one on the search path."""
    named = os.environ.get("CLUSTERMCML")
    if named:
        return errors.existing_file("CLUSTERMCML", named)
    packaged = importlib.resources.files(__package__) / "bin" / "clustermcml"
    found = str(packaged) if packaged.is_file() else shutil.which("clustermcml")
    if found is None:
        raise errors.InputError("clustermcml is not installed (expected it in the package, on the PATH, or named by CLUSTERMCML)")
    return found


def main() -> NoReturn:
    """The command `clustermcml` of the package: becomes the program."""
    program = find_program()
    os.execv(program, [program, *sys.argv[1:]])


def option_words(options: dict[str, Any]) -> list[str]:
    """Keywords as the program's options: True is an option without a value, None and False leave it out, a list is joined by commas.

    >>> option_words({"photons": 1e5, "target_error": None, "no_reentry": True, "device": [0, 1]})
    ['--photons', '100000.0', '--no-reentry', '--device', '0,1']
    """
    words = []
    for name, value in options.items():
        if name in ("json", "quiet", "verbose", "output"):
            raise errors.refuse(name, value, "no such argument: results are returned")
        if value is None or value is False:
            continue
        words.append("--" + name.replace("_", "-"))
        if value is not True:
            words.append(",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value))
    return words


def _raise_failure(code: int, said: Sequence[str]) -> NoReturn:
    """The program's own message, as an error of its kind."""
    own = [line.removeprefix(PREFIX) for line in said if line.startswith(PREFIX)]
    text = own[-1] if own else "\n".join(said) or f"clustermcml ended with {code} and said nothing"
    raise errors.InputError(text) if code == 2 else errors.ClustermcmlError(text, code)


def _listen(lines: Iterator[str], progress: Progress, said: list[str]) -> None:
    """Takes the program's standard error apart: progress is shown, the rest is kept."""
    for line in lines:
        share = re.match(r"(\d+) %, (.*)", line)
        if share:
            progress.show(int(share[1]), share[2])
        else:
            said.append(line.rstrip("\n"))


def _finish(process: subprocess.Popen[str]) -> str:
    """All of standard output. An interrupt is passed on: the program writes its checkpoint, and this waits for that."""
    assert process.stdout is not None
    try:
        text = process.stdout.read()
        process.wait()
        return text
    except KeyboardInterrupt:
        process.send_signal(signal.SIGINT)
        process.wait()
        raise


def _fly(words: Sequence[str], show: Optional[bool]) -> list[dict[str, Any]]:
    """What the program says of every run, as --json does. In a session of its own, so that an interrupt reaches it from here alone."""
    said: list[str] = []
    with Progress(show) as progress, subprocess.Popen(
            [find_program(), *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            encoding="utf-8", errors="replace", start_new_session=True) as process:
        assert process.stderr is not None
        listener = threading.Thread(target=_listen, args=(iter(process.stderr), progress, said))
        listener.start()
        try:
            text = _finish(process)
        finally:
            listener.join()
    for note in (line for line in said if line.startswith(PREFIX + "note: ")):
        warnings.warn(note.removeprefix(PREFIX + "note: "), stacklevel=4)
    if process.returncode != 0:
        _raise_failure(process.returncode, said)
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def _result(told: dict[str, Any]) -> xr.Dataset:
    """The Dataset of a run: of its .h5, which has more, else of its .mco."""
    files = [path for path in told["files"] if path.endswith((".h5", ".mco"))]
    data = read(next((path for path in files if path.endswith(".h5")), files[0]))
    data.attrs.update({key: told[key] for key in MEASURED if told.get(key) is not None})
    return data


def run(scene: Union[Scene, str, os.PathLike[str]], *, output_dir: Union[None, str, os.PathLike[str]] = None,
        progress: Optional[bool] = None, **options: Any) -> xr.Dataset:
    """Flies a scene and returns its result, as `read` does, with how long it took among the attributes.

    scene: a Scene, or the path of an `.mci` file with one run. output_dir: a folder that is there, in which results and checkpoints
    stay; None: they are read and removed. progress: whether to show how far the run is; None: in notebooks and terminals.
    Everything else is an option of the program, with underscores: photons=1e6, seed=2, threads=4, target_error=1e-3,
    engine="reference", no_reentry=True; `clustermcml help run` lists them.

    Raises InputError for what is refused, ClustermcmlError for what fails later; the text is the program's. Notes of the program are
    warnings. A KeyboardInterrupt stops the program cleanly: with output_dir its checkpoint stays, and resume=True continues.
    """
    with tempfile.TemporaryDirectory(prefix="clustermcml_") as scratch:
        folder = scratch if output_dir is None else os.path.abspath(os.fspath(output_dir))
        if not os.path.isdir(folder):
            raise errors.refuse("output_dir", output_dir, "a folder that is there, or None")
        path = os.path.join(folder, "scene.mci")
        if isinstance(scene, Scene):
            scene.write(path)
        else:
            path = errors.existing_file("scene", scene)
        told = _fly([path, "--json", "-o", folder, *option_words(options)], progress)
        if len(told) != 1:
            raise errors.refuse("scene", path, f"a file with one run, this one has {len(told)}")
        return _result(told[0])
