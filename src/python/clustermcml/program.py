"""Flies scenes: in this process, or by the program, whose files are then read.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import contextlib
import fcntl
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
from typing import IO, TYPE_CHECKING, Any, Callable, Iterable, Iterator, Mapping, NoReturn, Optional, Sequence, Union

import numpy as np

from . import errors, library
from .fields import MEASURED, Field, Fields
from .options import Path, RunOptions, shown
from .progress import Progress
from .results import read_as
from .scene import Scene, Text

if TYPE_CHECKING:
    import xarray as xr

    from typing_extensions import Unpack

PREFIX = "clustermcml: "
OWN = "# written by clustermcml.run or sweep\n"
FATES = {"Rsp": "specular", "Rd": "reflected", "A": "absorbed", "Tt": "transmitted"}  # keys of --json, and names of the book of each in the result
STOPS = (signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU)  # SIGINT is left to Python
NONE, ALL = "(?!)", ""  # patterns of notes
STOPPED = 75  # exit code of a run that was stopped by a signal


def find_program() -> str:
    """Returns the path of the program: $CLUSTERMCML, else the one in this package, else the one on the search path."""
    named = os.environ.get("CLUSTERMCML")
    if named:
        return errors.existing_file("CLUSTERMCML", named)
    packaged = importlib.resources.files(__package__) / "bin" / "clustermcml"
    found = str(packaged) if packaged.is_file() else shutil.which("clustermcml")
    if found is None:
        raise errors.InputError("clustermcml is not installed (expected it in the package, on the PATH, or named by CLUSTERMCML)")
    return found


def main() -> NoReturn:
    """Runs the command `clustermcml` of the package: replaces Python by the program. CLUSTERMCML may name this very command,
    and is ignored then."""
    if os.path.realpath(os.environ.get("CLUSTERMCML", "")) == os.path.realpath(sys.argv[0]):
        del os.environ["CLUSTERMCML"]
    os.environ.setdefault("CLUSTERMCML_PYTHON", sys.executable)  # the Python to which the program hands over the commands of this package
    program = find_program()
    os.execv(program, [program, *sys.argv[1:]])


NO_ARGUMENTS = {"json": "results are returned", "quiet": "results are returned", "verbose": "results are returned",
                "output": "results are returned", "classic": "results are returned", "sweep": "clustermcml.sweep flies sweeps", "help": "clustermcml help run prints it",
                "part": "a part of a run has no result; clustermcml run flies it, merge joins all", "version": "results have it as an attribute"}


def option_words(options: Mapping[str, object], kind: Any = RunOptions) -> list[str]:
    """Returns keyword arguments as words of a command line.

    True becomes an option without a value. False and None leave the option out. A list is joined by commas. A dict repeats the
    option with NAME=VALUE for each item. kind: class that lists the options. The program itself refuses unknown ones.

    >>> option_words({"photons": 1e5, "target_error": None, "no_reentry": True, "device": [0, 1]})
    ['--photons', '100000.0', '--no-reentry', '--device', '0,1']
    >>> option_words({"set": {"layer1.mua": 0.3, "above.n": 1.33}})
    ['--set', 'layer1.mua=0.3', '--set', 'above.n=1.33']
    """
    words = []
    for name, value in options.items():
        if name in NO_ARGUMENTS and name not in kind.__annotations__:
            raise errors.refuse(name, value, "no such argument: " + NO_ARGUMENTS[name])
        option, is_flag, known = "--" + name.replace("_", "-"), isinstance(value, (bool, np.bool_)), kind.__annotations__.get(name)
        if known and known.__forward_arg__ == "bool" and value is not None:
            errors.flag(name, value)
        elif known and (is_flag or isinstance(value, Mapping) and not known.__forward_arg__.startswith("Mapping")):
            raise errors.refuse(name, value, "a value")
        if is_flag:
            words += [option] if value else []
        elif isinstance(value, Mapping):
            words += [word for item in value.items() for word in (option, f"{item[0]}={item[1]}")]
        elif value is not None:
            words += [option, ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)]
        if any("\0" in word for word in words):
            raise errors.refuse(name, value, "text without NUL characters")
        try:
            "".join(words).encode(sys.getfilesystemencoding(), "surrogateescape")
        except UnicodeEncodeError:
            raise errors.refuse(name, value, "text that a command line can hold") from None
    return words


def renamed(text: str, folder: str) -> str:
    """Returns a message of the program in the caller's words: names of files in a temporary folder become names of the objects
    that the caller knows.

    >>> renamed("/tmp/x/scene.mci:9: boundary 0: /tmp/x/scene.surface0.obj: no faces", "/tmp/x")
    'Scene: boundary 0: its surface: no faces'
    >>> renamed("/tmp/x/scene.mco: cannot be written (No space left on device)", "/tmp/x")
    'scene.mco: cannot be written (No space left on device)'
    """
    names = {r"scene\.mci": "Scene", r"scene\.surface\d+\.\w+": "its surface", r"scene\.layer\d+body\d+\.\w+": "its surface",
             r"scene\.layer\d+(body\d+)?\.phase\.txt": "table of a Phase", r"sweep\.csv": "parameters"}
    for file, name in names.items():
        text = re.sub(re.escape(folder + os.sep) + file + r"(:\d+)?(?!\w)", name, text)
    return text.replace(folder + os.sep, "") if folder else text


def _own_words(text: str) -> str:
    """Returns a message about a scene in memory without the number of a line that the caller has never seen."""
    return re.sub(r"the run in line \d+", "the Scene", text)


@contextlib.contextmanager
def scratch_folder() -> Iterator[str]:
    """Yields a temporary folder. Messages of errors do not name its files."""
    with tempfile.TemporaryDirectory(prefix="clustermcml_") as folder:
        try:
            yield folder
        except errors.ClustermcmlError as error:
            error.args = (renamed(str(error), folder),)
            raise


def _silent_end(code: int) -> str:
    """Returns a message for a program that ended with this code and printed nothing.

    >>> _silent_end(-15), _silent_end(143), _silent_end(5)
    ('clustermcml was ended by SIGTERM', 'clustermcml was ended by SIGTERM', 'clustermcml ended with 5 and said nothing')
    """
    number = -code if code < 0 else code - 128
    return f"clustermcml was ended by {signal.Signals(number).name}" if number in list(signal.Signals) else f"clustermcml ended with {code} and said nothing"


def _how_to_go_on(text: str, kept: bool) -> str:
    """Returns the message of a run that was stopped, with Python's argument in place of --resume. kept: the checkpoint still
    exists.

    >>> _how_to_go_on("a.mco: stopped with 5 of 9 packets to fly; --resume continues from x/a.mco.checkpoint", True)
    'a.mco: stopped with 5 of 9 packets to fly; resume=True continues from x/a.mco.checkpoint'
    >>> _how_to_go_on("a.mco: stopped with 5 of 9 packets to fly; --resume continues from a.mco.checkpoint", False)
    'a.mco: stopped with 5 of 9 packets to fly; run and sweep keep a checkpoint in output_dir, from which resume=True continues'
    """
    if kept:
        return text.replace("--resume", "resume=True")
    return re.sub("; --resume continues.*", "; run and sweep keep a checkpoint in output_dir, from which resume=True continues", text)


def raise_failure(code: int, said: Sequence[str], kept: bool = True) -> NoReturn:
    """Raises the program's own message as an exception of its kind. kept: the folder of the program's files stays."""
    own = [line.removeprefix(PREFIX) for line in said if line.startswith(PREFIX)]
    text = own[-1] if own else "\n".join(said) or _silent_end(code)
    if code == STOPPED:
        text = _how_to_go_on(text, kept)
    raise errors.InputError(text) if code == 2 else errors.ClustermcmlError(text, code)


def _listen(pieces: Iterable[str], progress: Progress, said: list[str]) -> None:
    """Reads the program's standard error, cut at line feeds and carriage returns: its bar of progress goes to `progress`, all other lines to `said`."""
    with contextlib.suppress(OSError):  # the other end of the terminal is closed
        for piece in pieces:
            text = piece.replace("\033[K", "").rstrip("\n")
            share = re.match(r"(?:\[[#.]*\])? *(\d+) % +(.*)", text)
            if share:
                progress.show(int(share[1]), share[2])
            elif text:
                said.append(text)


def _read_lines(process: subprocess.Popen[str], progress: Progress, rows: int) -> list[str]:
    """Returns the lines of the program's standard output, read as they come.

    On an interrupt or any other exception, the program is told to stop and writes its checkpoint, while this waits. SIGINT
    cannot be used: a script that was started with & ignores it, and so do all its children."""
    assert process.stdout is not None
    told: list[str] = []
    try:
        for line in process.stdout:
            told.append(line)
            if rows:
                progress.show(100 * len(told) // rows, f"{len(told)} of {rows} rows")
        process.wait()
    except BaseException:
        process.terminate()
        process.wait()
        raise
    return told


@contextlib.contextmanager
def exits_on_signals() -> Iterator[None]:
    """Turns signals that would end this process at once into an exit (143 for SIGTERM, as shells report it), so that the
    program is stopped first.

    Only the main thread may set handlers. A handler of the caller stays."""
    ours = [number for number in STOPS if signal.getsignal(number) is signal.SIG_DFL] if threading.current_thread() is threading.main_thread() else []
    for number in ours:
        signal.signal(number, lambda number, frame: sys.exit(128 + number))
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _locked(path: str, folder: str) -> IO[bytes]:
    """Opens and locks the file of the scene. The kernel releases the lock when the process ends, so that no stale lock remains."""
    file = open(path, "a+b")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise errors.ClustermcmlError(f"{path}: locked by another call (expected an output_dir of its own for each)", 5) from None
    except OSError:  # this file system has no locks
        pass
    file.seek(0)
    if file.read(len(OWN)) not in (b"", OWN.encode()):
        file.close()
        raise errors.refuse("output_dir", folder, "a folder without another scene.mci, which would be overwritten")
    return file


def _unlock(file: IO[bytes]) -> None:
    """Unlocks the file. Closing alone is not enough, because a process forked meanwhile also has the file open."""
    with contextlib.suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_UN)


def _text(scene: Union[Scene, Text], folder: Path) -> str:
    """Returns the text of a scene's file in a folder, in which its surfaces and tables are written."""
    try:
        return scene if isinstance(scene, Text) else OWN + scene.text("scene.mco", folder)
    except OSError as error:
        raise errors.ClustermcmlError(f"{error.filename}: cannot be written ({error.strerror})", 5) from error


@contextlib.contextmanager
def scene_file(scene: Union[Scene, Text, Path], folder: str) -> Iterator[str]:
    """Yields the path of the scene's file. A scene in memory is written into `folder`, and no other call writes there until its
    result is read."""
    if not isinstance(scene, (Scene, Text)):
        yield errors.existing_file("scene", scene)
        return
    path = os.path.join(folder, "scene.mci")
    with contextlib.ExitStack() as held:
        try:
            file = held.enter_context(_locked(path, folder))
            held.callback(_unlock, file)
            with open(path, "w", encoding="utf-8", errors="surrogateescape") as written:
                written.write(_text(scene, folder))
        except OSError as error:
            raise errors.ClustermcmlError(f"{error.filename}: cannot be written ({error.strerror})", 5) from error
        try:
            yield path
        except errors.ClustermcmlError as error:
            error.args = (_own_words(str(error)),)
            raise


def environment() -> dict[str, str]:
    """Returns the environment of the program. With CLUSTERMCML_PARENT, the program stops by itself when this process or the
    calling thread ends in any way."""
    return {**os.environ, "CLUSTERMCML_PARENT": str(os.getpid())}


def _start(words: list[str], here: int, there: int) -> subprocess.Popen[str]:
    """Starts the program. Its standard error is `there`, the other end of the terminal `here`."""
    try:
        return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=there, text=True, encoding="utf-8",
                                errors="replace", start_new_session=True, env=environment())
    except OSError as error:
        os.close(here)
        raise errors.InputError(f"{words[0]}: cannot be run ({error.strerror})") from error
    finally:
        os.close(there)


def _named(path: str) -> str:
    """Returns the real name of a file that the program shows with \\xNN for bytes that are no UTF-8 or control a terminal."""
    if os.path.exists(path):
        return path
    return os.fsdecode(re.sub(rb"\\x([0-9a-f]{2})", lambda byte: bytes.fromhex(byte[1].decode()), os.fsencode(path)))


def _lines(scene: str, folder: str, options: list[str], progress: Progress, scratch: str, rows: int, silent: str) -> list[str]:
    """Runs the program and returns the lines of its standard output. rows: of a sweep, 0 for none. Other arguments as of `_fly_program`.

    The program has a session of its own, so that an interrupt reaches it from here alone. Its standard error is a terminal, so
    that it draws a bar.
    """
    said: list[str] = []
    words = [find_program(), scene, "-o", folder, *options]
    here, there = os.openpty()
    with exits_on_signals(), _start(words, here, there) as process, open(here, encoding="utf-8", errors="replace") as terminal:
        listener = threading.Thread(target=_listen, args=(terminal, Progress(False) if rows else progress, said))
        listener.start()
        try:
            told = _read_lines(process, progress, rows)
        finally:
            listener.join()
    said = [renamed(line, scratch) for line in said]
    for note in (line.removeprefix(PREFIX + "note: ") for line in said if line.startswith(PREFIX + "note: ")):
        if not re.search(silent, note):
            errors.warn(note)
    if process.returncode != 0:
        raise_failure(process.returncode, said, folder != scratch)
    return told


def _few(told: Mapping[str, Any], path: str, names: Sequence[str]) -> Fields:
    """Returns these arrays of an .h5 and their axes. It has just been written: the checks of `read_h5` would take longer than its flight."""
    import h5py
    held = {name: Field(told[name]) for name in names if isinstance(told.get(name), (float, int))}
    left = [name for name in names if name not in held]
    with h5py.File(path, "r", locking=False) as file:
        for name in (name for name in left if name in file):
            item = file[name]
            dims = (name,) if h5py.h5ds.is_scale(item.id) else tuple(scales[0].name[1:] for scales in item.dims)
            left += [dim for dim in dims if dim not in left]
            held[name] = Field(item[()], dims)
    return Fields(held, {**told})


def result_of(told: Mapping[str, Any], names: Optional[Sequence[str]] = None) -> Fields:
    """Returns the result of a run, from its .h5 or else its .mco. Refuses a file that another call has replaced: totals must
    equal those that the program has told, to all digits. names: of the arrays that are needed; None: all."""
    h5 = next((path for path in told["files"] if path.endswith(".h5") and not path.endswith(".photons.h5")), None)
    path = h5 or told["files"][0]
    if not os.path.isfile(path):
        raise errors.refuse("scene", path, "a scene whose result is a file")
    if h5 and names:
        return _few(told, h5, names)
    data = read_as(path)
    if any(float(data["book_" + fate]) != told.get(total, float(data["book_" + fate])) for total, fate in FATES.items()):
        raise errors.ClustermcmlError(f"{path}: replaced by another call (expected an output_dir of its own for each)", 5)
    data.attrs.update({key: told[key] for key in MEASURED if told.get(key) is not None})
    return data


def _may_be_finished(scene: str, folder: str) -> bool:
    """True if the folder holds a file by the name of the run's result, which stands in the third line with words. Without such a file, the run is
    simulated at once, so that a large scene is loaded only once."""
    with open(scene, encoding="utf-8", errors="replace") as file:
        words = [line.split()[0] for line in (line.partition("#")[0] for line in file) if line.strip()]
    stem = os.path.splitext((words[2:3] or [""])[0].strip('"'))[0]
    return "/" in stem or any(re.match(re.escape(stem) + r"(?!.*\.(mci|lock|checkpoint|old)$)", name) for name in os.listdir(folder))


def _finished(scene: str, folder: str, options: list[str], progress: Progress) -> Optional[dict[str, Any]]:
    """Returns the files of a run that was finished before and has no checkpoint. Returns None for any other run.

    --json would fly such a run anew to know all digits. Any other run has a checkpoint after this call, which holds all digits."""
    said = "".join(_lines(scene, folder, options, progress, "", 0, NONE))
    names = re.findall(r"^(\S.*): \S+ photons, .*, seed \d+$", said, re.MULTILINE)
    stands = len(names) == 1 and "\n  finished before" in said and not os.path.exists(os.path.join(folder, names[0] + ".checkpoint"))
    return {"files": [_named(path) for path in re.findall("^  -> (.*)$", said, re.MULTILINE)]} if stands else None


def _fly_program(scene: str, folder: str, words: list[str], table: str, progress: Progress, scratch: str, silent: str) -> list[dict[str, Any]]:
    """Flies a scene by the program, or each row of a table, and returns its answers. scratch: temporary folder whose files are not named."""
    path = os.path.join(scratch, "sweep.csv")
    if table:
        with open(path, "w", encoding="utf-8") as file:
            file.write(table)
        words = ["--sweep", path, *(["--output", "row.h5"] if folder == scratch else []), *words]  # an .h5 has all digits, as the library has them
    resumes = "--resume" in words and folder != scratch and not table and _may_be_finished(scene, folder)
    stands = _finished(scene, folder, words, progress) if resumes else None
    if stands:
        return [stands]
    told = list(map(json.loads, _lines(scene, folder, ["--json", *words], progress, scratch, max(table.count("\n") - 1, 0), ALL if resumes else silent)))
    if not table and len(told) != 1:
        raise errors.refuse("scene", scene, f"a file with one run, this one has {len(told)}")
    return sorted(({**run, "files": [_named(path) for path in run["files"]]} for run in told), key=lambda run: int(run.get("row") or 0))


class _Beside:
    """The folder beside a scene in memory. It is made if a surface or a table is written there: the library reads these from files alone."""

    made: Optional[tempfile.TemporaryDirectory[str]] = None

    def __fspath__(self) -> str:
        self.made = self.made or tempfile.TemporaryDirectory(prefix="clustermcml_")
        return self.made.name

    def close(self) -> None:
        if self.made:
            self.made.cleanup()


def fly(scene: Union[Scene, Text, Path], words: list[str], progress: Progress, *, table: str = "", output_dir: Optional[Path] = None, silent: str = NONE,
        names: Optional[Sequence[str]] = None, keep: Callable[[Fields], Fields] = lambda result: result) -> list[Fields]:
    """Flies a scene, or each row of a table, and returns the results in their order.

    words: options of a command line. table: text of a file of --sweep; "" is none. output_dir: folder for the program's files; None flies in this
    process, or by the program where the library lacks something. silent: pattern of notes that are no warnings. names: of the arrays that are needed.
    keep: returns the part of a result that is kept."""
    loaded = library.find(find_program(), words) if output_dir is None else None
    if not loaded:
        with scratch_folder() as scratch:
            folder = errors.folder("output_dir", scratch if output_dir is None else output_dir)
            with scene_file(scene, folder) as path:
                return [keep(result_of(told, names)) for told in _fly_program(path, folder, words, table, progress, scratch, silent)]
    with contextlib.closing(_Beside()) as beside:
        text = _text(scene, beside) if isinstance(scene, (Scene, Text)) else None
        folder = beside.made.name if beside.made else "Scene"

        def own(said: str) -> str:
            said = re.sub(r"^the table(:\d+)?: ", "parameters: ", renamed(said, folder))
            return "" if re.search(silent, said) else _own_words(said) if text else said
        path = os.path.join(folder, "scene.mci") if text else errors.existing_file("scene", scene)
        with library.Scene(loaded, path, text, words, own) as flown:
            return flown.sweep(table, keep, progress, names) if table else [keep(flown.fly([], progress, names))]


@shown
def run(scene: Union[Scene, Path], *, output_dir: Optional[Path] = None, progress: Optional[bool] = None,
        **options: Unpack[RunOptions]) -> xr.Dataset:
    """Simulates a scene and returns its result.

    Args:
        scene: A Scene, or the path of an `.mci` file with one run.
        output_dir: Folder in which results and checkpoints stay; it is made where it is missing. Calls at the same time need folders of their own.
            None: the run flies in this process without files, or by the program in a temporary folder where the library lacks something.
        progress: Whether to show a progress bar; None shows one in notebooks and terminals.
        **options: Options of the program, with underscores: photons=1e6, seed=2, threads=4, target_error=1e-3, engine="reference",
            no_reentry=True, set={"layer1.mua": 0.5}. `clustermcml help run` lists them.

    Returns:
        An xarray.Dataset as `read` returns it, with how long the run took among the attributes.

    Raises:
        InputError: The scene or an option is refused; the text is the program's.
        ClustermcmlError: The run has failed.
        KeyboardInterrupt: The run was stopped. With output_dir its checkpoint stays, and the same call with resume=True continues.
    """
    if isinstance(scene, Scene) and scene.saved and output_dir is None:
        raise errors.refuse("output_dir", output_dir, "a folder: the file of saved photons stays there")
    with Progress(progress) as shown_progress:
        return fly(scene, option_words(options), shown_progress, output_dir=output_dir)[0].dataset()
