"""Flies scenes in this process, by libclustermcml: no program is started, and no file is written.

The library stands beside the program. Without it, and for all that it lacks (files, checkpoints), flights are the program's.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import ctypes
import functools
import glob
import json
import os
import re
import threading
from typing import Any, Callable, Iterator, Optional, Sequence, Union

import numpy as np

from . import errors
from .fields import MEASURED, WHOLE, Field, Fields
from .options import Path
from .progress import Progress
from .scene import Scene, Text
from .scene_files import NONE, Beside, own_words, renamed, scene_text

API = 1  # CLM_API of clustermcml.h
OPTIONS = frozenset(("--photons --set --derivatives --seed --target-error --error-of --sampling --roulette --aim --ignore-absorption --no-reentry --ignore-heightfields "
                     "--boundaries --tolerance --mesh-budget --normals --rings --mesh-search --engine --threads --chunk --device --group --build-options --reweight").split())
_Progress = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint64, ctypes.c_double)
_Row = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
_Note = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p)


def _text(text: Optional[bytes]) -> str:
    return (text or b"").decode("utf-8", "backslashreplace")


class _Array(ctypes.Structure):
    """struct clm_array."""

    _fields_ = [("name", ctypes.c_char_p), ("units", ctypes.c_char_p), ("meaning", ctypes.c_char_p), ("num_axes", ctypes.c_int), ("axis", ctypes.c_char_p * 4),
                ("size", ctypes.c_size_t * 4), ("count", ctypes.c_size_t), ("single", ctypes.c_int), ("value", ctypes.POINTER(ctypes.c_double)),
                ("error", ctypes.POINTER(ctypes.c_double))]


@functools.lru_cache(maxsize=None)
def _load(program: str) -> Optional[ctypes.CDLL]:
    """Loads the library that stands beside a program: in its folder (a build), or in lib beside that of the program. None: there is none, or one that is too old."""
    folder = os.path.dirname(os.path.realpath(program))
    names = [name for place in (".", "../lib*", "../lib*/*") for name in sorted(glob.glob(os.path.join(glob.escape(folder), place, f"libclustermcml.so.{API}")))]
    try:
        library = ctypes.CDLL(names[0])
        library.clm_scene_sweep  # pylint: disable=pointless-statement # the newest function
    except (IndexError, OSError, AttributeError):
        return None
    if library.clm_api() != API:
        return None
    library.clm_error.restype = library.clm_version.restype = library.clm_run_json.restype = ctypes.c_char_p
    library.clm_scene_free.argtypes = library.clm_run_free.argtypes = library.clm_run_json.argtypes = [ctypes.c_void_p]
    library.clm_run_fly.argtypes = [ctypes.c_void_p, ctypes.c_uint64]
    library.clm_on_note.restype = library.clm_run_on_progress.restype = library.clm_scene_free.restype = library.clm_run_free.restype = None
    return library


def find(program: str, words: Sequence[str]) -> Optional[ctypes.CDLL]:
    """Returns the library beside the program. None: the program must fly, for an option among the words of its command line."""
    wanted = {word for word in words if word.startswith("--")}
    return _load(program) if wanted <= OPTIONS else None


def _words(words: Sequence[str]) -> Any:
    """Returns words of a command line, as option_words makes them, as options of the library."""
    options: list[str] = []
    for word in words:
        if word.startswith("--"):
            options.append(word[2:])
        else:
            options[-1] += "=" + word
    return (ctypes.c_char_p * (len(options) + 1))(*map(os.fsencode, options), None)


def _apart(work: Callable[[], None], cancelled: threading.Event, ended: threading.Event) -> None:
    """Does the work, and sets `ended` at its end. The main thread lets another one do it, so that it hears of signals. An exception here cancels the work
    and awaits its end, but no longer than two seconds, or than the next exception: reading and preparing a scene cannot be cancelled."""
    def report() -> None:
        try:
            work()
        finally:
            ended.set()
    if threading.current_thread() is not threading.main_thread():
        return report()
    thread = threading.Thread(target=report, daemon=True)
    try:
        thread.start()
        while not ended.wait(1):
            pass
    except BaseException:
        cancelled.set()
        if thread.ident is None:  # it could not be started
            ended.set()
        ended.wait(2)
        raise


class Runs:
    """The runs of a scene, in the library.

    scene: object, or path of a file. words: options of the command line, for all flights. silent: pattern of notes that are no warnings."""

    def __init__(self, library: ctypes.CDLL, scene: Union[Scene, Text, Path], words: Sequence[str], silent: str = NONE) -> None:
        self.dll, self.silent, self.scene, self.beside, self.ended = library, silent, ctypes.c_void_p(), Beside(), threading.Event()
        self.ended.set()
        self.path = "Scene" if isinstance(scene, (Scene, Text)) else errors.existing_file("scene", scene)
        try:
            if isinstance(scene, (Scene, Text)):
                text = scene_text(scene, self.beside).encode("utf-8", "surrogateescape")
                self._call(library.clm_scene_parse, text, os.fsencode(self.beside.name or self.path), _words(words), ctypes.byref(self.scene))
            else:
                self._call(library.clm_scene_open, os.fsencode(self.path), _words(words), ctypes.byref(self.scene))
        except BaseException:
            self.__exit__()
            raise
        self.runs = library.clm_scene_runs(self.scene)

    def __enter__(self) -> Runs:
        return self

    def __exit__(self, *_: object) -> None:
        self._when_ended(self._free)

    def _free(self) -> None:
        self.dll.clm_scene_free(self.scene)
        self.beside.close()

    def _when_ended(self, free: Callable[[], object]) -> None:
        """Frees what the last call uses. After an interrupt the call may still run in its thread."""
        if self.ended.is_set():
            free()
        else:
            threading.Thread(target=lambda: self.ended.wait() and free(), daemon=True).start()

    def _renamed(self, said: str) -> str:
        """Returns a message of the library in the caller's words."""
        said = re.sub(r"^the table(:\d+)?: ", "parameters: ", renamed(said, self.beside.name or self.path))
        return own_words(said) if self.path == "Scene" else said

    def _call(self, function: Any, *arguments: Any, cancelled: Optional[threading.Event] = None) -> None:
        """Calls a function of the library. Its notes become warnings, its status an exception. cancelled: is set to end a flight."""
        notes: list[str] = []
        ended: list[tuple[int, str]] = []
        take = _Note(lambda _, text: notes.append(_text(text)))

        def work() -> None:  # notes and errors belong to the thread that calls
            self.dll.clm_on_note(take, None)
            ended.append((function(*arguments), _text(self.dll.clm_error())))
            self.dll.clm_on_note(None, None)
        self.ended = threading.Event()
        _apart(work, cancelled or threading.Event(), self.ended)
        for note in map(self._renamed, notes):
            if not re.search(self.silent, note):
                errors.warn(note)
        status, text = ended[0]
        if status:
            raise errors.InputError(self._renamed(text)) if status == 2 else errors.ClustermcmlError(self._renamed(text), status)

    def told(self, exact: bool) -> list[str]:
        """Returns the line that `check --json`, or `exact --json`, prints of each run."""
        text, lines = ctypes.c_char_p(), []
        for run in range(self.runs):
            self._call(self.dll.clm_scene_exact if exact else self.dll.clm_scene_check, self.scene, run, 1, ctypes.byref(text))
            lines.append(_text(text.value))
        return lines

    def fly(self, words: Sequence[str], progress: Progress, names: Optional[Sequence[str]] = None) -> Fields:
        """Flies the scene. words: further options of this flight. names: of the arrays that are wanted; None: all."""
        run, cancelled = ctypes.c_void_p(), threading.Event()

        def show(_: object, done: int, total: int, seconds: float) -> int:
            if 0 < done < total and seconds > 0 and progress.show(100 * done // total, f"{done / seconds:.3g} photons/s, {seconds * (total - done) / done:.0f} s left"):
                cancelled.set()
            return cancelled.is_set()
        self.shown = _Progress(show)  # as long as the flight may call it
        try:
            self._call(self.dll.clm_run_open, self.scene, 0, _words(words), ctypes.byref(run))
            self.dll.clm_run_on_progress(run, self.shown, None)
            self._call(self.dll.clm_run_fly, run, ctypes.c_uint64(0), cancelled=cancelled)
            return _fields(self.dll, run, names)
        finally:
            self._when_ended(lambda: self.dll.clm_run_free(run))

    def sweep(self, table: str, keep: Callable[[Fields], Fields], progress: Progress, names: Optional[Sequence[str]] = None) -> list[Fields]:
        """Flies the rows of a table, the text of a file of --sweep, and returns what `keep` makes of each. An exception there ends the sweep."""
        rows, cancelled = table.count("\n") - 1, threading.Event()
        found: dict[int, Fields] = {}
        failed: list[BaseException] = []

        def show(_: object, done: int, total: int, __: float) -> int:
            if 0 < done < total and progress.show(100 * (len(found) * total + done) // (rows * total), f"{len(found)} of {rows} rows"):
                cancelled.set()
            return cancelled.is_set()

        def take(_: object, row: int, run: int) -> int:
            try:
                found[row] = keep(_fields(self.dll, ctypes.c_void_p(run), names))
                if progress.show(100 * len(found) // rows, f"{len(found)} of {rows} rows"):
                    cancelled.set()
            except BaseException as error:  # pylint: disable=broad-except # no exception passes through the library
                failed.append(error)
            return bool(failed) or cancelled.is_set()
        try:
            self._call(self.dll.clm_scene_sweep, self.scene, None, table.encode(), _Progress(show), _Row(take), None, cancelled=cancelled)
        except errors.ClustermcmlError:
            if not failed:
                raise
        if failed:
            raise failed[0]
        return [found[row] for row in sorted(found)]


def _arrays(library: ctypes.CDLL, run: ctypes.c_void_p, names: Optional[Sequence[str]]) -> Iterator[_Array]:
    """Yields the arrays of these names that there are, and their axes. None: all."""
    array = _Array()
    i = 0
    while names is None and library.clm_run_item(run, i, ctypes.byref(array)) == 0:
        yield array
        i += 1
    left = [*dict.fromkeys(names or ())]
    for name in left:
        if library.clm_run_array(run, name.encode(), ctypes.byref(array)) == 0:
            left += [axis for axis in map(_text, array.axis[:array.num_axes]) if axis not in left]
            yield array


def _fields(library: ctypes.CDLL, run: ctypes.c_void_p, names: Optional[Sequence[str]]) -> Fields:
    """Returns arrays and the attributes of a run, as read_h5 returns them from its file, and how long it took."""
    def values(array: _Array, pointer: Any) -> Any:
        numbers = np.ctypeslib.as_array(pointer, shape=(array.count,)) if array.count else np.empty(0)
        return numbers.reshape(tuple(array.size[:array.num_axes])).astype(np.float32 if array.single else np.float64)
    held = {}
    for array in _arrays(library, run, names):
        name, dims = _text(array.name), tuple(map(_text, array.axis[:array.num_axes]))
        about = {"units": _text(array.units), "long_name": _text(array.meaning)}
        held[name] = Field(values(array, array.value), dims, about)
        if array.error:
            held[name + "_se"] = Field(values(array, array.error), dims, {**about, "long_name": "standard error"})
            about["ancillary_variables"] = name + "_se"
    attributes: dict[str, Union[str, float]] = {}
    key, text, number = ctypes.c_char_p(), ctypes.c_char_p(), ctypes.c_double()
    while library.clm_run_attribute(run, len(attributes), ctypes.byref(key), ctypes.byref(text), ctypes.byref(number)) == 0:
        attributes[_text(key.value)] = number.value if text.value is None else _text(text.value)
    attributes.update({name: int(attributes[name]) for name in WHOLE if name in attributes})
    told = json.loads(_text(library.clm_run_json(run)))
    attributes.update({name: told[name] for name in MEASURED if told.get(name) is not None})
    return Fields(held, attributes)
