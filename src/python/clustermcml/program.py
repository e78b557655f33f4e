"""Flies scenes: in this process, or by the program, whose files are then read.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import contextlib
import importlib.resources
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Any, Callable, Iterable, Iterator, Mapping, NoReturn, Optional, Sequence, Union

from . import errors, library
from .fields import MEASURED, Fields
from .options import Path, RunOptions, option_words, shown
from .progress import Progress, Wanted
from .results import read_as
from .scene import Scene, Text
from .scene_files import NONE, renamed, scene_file, scratch_folder

if TYPE_CHECKING:
    import xarray as xr

    from typing_extensions import Unpack

PREFIX = "clustermcml: "
FATES = {"Rsp": "specular", "Rd": "reflected", "A": "absorbed", "Tt": "transmitted"}  # keys of --json, and names of the book of each in the result
STOPS = (signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU)  # SIGINT is left to Python
ALL = ""  # pattern of notes
RANKS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS")  # how many processes a launcher of MPI says it has started
LAUNCHER = re.compile(r"(OMPI|PMIX|PMI|I_MPI)_.*|SLURM_STEP_NUM_TASKS")  # variables by which such a launcher talks to its processes
STOPPED = 75  # exit code of a run that was stopped by a signal
NO_RESULT = re.compile(r".*\.(mci|lock|checkpoint|old|gsf|obj|txt)")  # names of other files in a folder


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


def _failure(code: int, said: Sequence[str], kept: bool) -> errors.ClustermcmlError:
    """Returns the program's own message as an exception of its kind. kept: the folder of the program's files stays."""
    own = [line.removeprefix(PREFIX) for line in said if line.startswith(PREFIX)]
    number = -code if code < 0 else code - 128
    ended = f"was ended by {signal.Signals(number).name}" if number in list(signal.Signals) else f"ended with {code} and said nothing"
    text = own[-1] if own else "\n".join(said) or "clustermcml " + ended
    if code == STOPPED:
        text = text.replace("--resume", "resume=True") if kept else re.sub(
            "; --resume continues.*", "; run and sweep keep a checkpoint in output_dir, from which resume=True continues", text)
    return errors.InputError(text) if code == 2 else errors.ClustermcmlError(text, code)


def _listen(pieces: Iterable[str], progress: Progress, said: list[str], stop: Callable[[], None]) -> None:
    """Reads the program's standard error, cut at line feeds and carriage returns: its bar of progress goes to `progress`, which may
    `stop` it, all other lines to `said`."""
    for piece in pieces:
        text = piece.replace("\033[K", "").rstrip("\n")
        share = re.match(r"(?:\[[#.]*\])? *(\d+) % +(.*)", text)
        if share and progress.show(int(share[1]), share[2]):
            stop()
        elif text and not share:
            said.append(text)


@contextlib.contextmanager
def _exits_on_signals() -> Iterator[None]:
    """Turns signals that would end this process at once into an exit (143 for SIGTERM, as shells report it), so that the program is stopped first.
    Only the main thread may set handlers. A handler of the caller stays."""
    ours = [number for number in STOPS if signal.getsignal(number) is signal.SIG_DFL] if threading.current_thread() is threading.main_thread() else []
    for number in ours:
        signal.signal(number, lambda number, frame: sys.exit(128 + number))
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _refuse_ranks() -> None:
    """Refuses to fly where a launcher has started several processes, as each would fly the same photons. A script that has loaded mpi4py.MPI knows its rank."""
    for name in () if "mpi4py.MPI" in sys.modules else RANKS:
        count = os.environ.get(name, "")
        if count.isdigit() and int(count) > 1:
            raise errors.InputError(f"clustermcml in Python flies in one process, and a launcher started {count} ({name}={count}): "
                                    "start the program with mpiexec, or one Python without it; or import mpi4py.MPI, and let each process fly a run of its own")


def _start(words: Sequence[str]) -> subprocess.Popen[str]:
    """Starts the program in a session of its own, so that an interrupt reaches it from here alone. With CLUSTERMCML_PARENT, it draws its bar into the
    pipe, and stops by itself when this process or the calling thread ends in any way. The program is no rank of a launcher that has started Python."""
    environment = {name: value for name, value in os.environ.items() if not LAUNCHER.fullmatch(name)}
    try:
        return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8",
                                errors="replace", start_new_session=True, env={**environment, "CLUSTERMCML_PARENT": str(os.getpid())})
    except OSError as error:
        raise errors.InputError(f"{words[0]}: cannot be run ({error.strerror})") from error


def say(words: Sequence[str], scratch: str, progress: Progress = Progress(False), rows: int = 0, silent: str = NONE, fine: Sequence[int] = (0,)) -> list[str]:
    """Runs the program and returns the lines of its standard output. Its notes become warnings.

    scratch: folder of temporary files, whose names messages leave out. rows: of a sweep, whose lines are counted; 0: the bar is shown. silent: pattern of
    notes that are no warnings. fine: exit codes that are no failure. On an interrupt or any other exception, the program is told to stop and writes its
    checkpoint, while this waits. SIGINT cannot be used: a script that was started with & ignores it, and so do all its children."""
    said: list[str] = []
    told: list[str] = []
    with _exits_on_signals(), _start([find_program(), *words]) as process:
        listener = threading.Thread(target=_listen, args=(process.stderr, Progress(False) if rows else progress, said, process.terminate))
        listener.start()
        try:
            for line in process.stdout or ():
                told.append(line.rstrip("\n"))
                if rows and progress.show(100 * len(told) // rows, f"{len(told)} of {rows} rows"):
                    process.terminate()
            process.wait()
        except BaseException:
            process.terminate()
            process.wait()
            raise
        finally:
            listener.join()
    said = [renamed(line, scratch) for line in said]
    for note in (line.removeprefix(PREFIX + "note: ") for line in said if line.startswith(PREFIX + "note: ")):
        if not re.search(silent, note):
            errors.warn(note)
    if process.returncode not in fine:
        raise _failure(process.returncode, said, scratch not in words)
    return told


def _named(path: str) -> str:
    """Returns the real name of a file that the program shows with \\xNN for bytes that are no UTF-8 or control a terminal."""
    if os.path.exists(path):
        return path
    return os.fsdecode(re.sub(rb"\\x([0-9a-f]{2})", lambda byte: bytes.fromhex(byte[1].decode()), os.fsencode(path)))


def result_of(told: Mapping[str, Any]) -> Fields:
    """Returns the result of a run, from its .h5 or else its .mco. Refuses a file that another call has replaced: totals must
    equal those that the program has told, to all digits."""
    path = next((path for path in told["files"] if path.endswith(".h5") and not path.endswith(".photons.h5")), told["files"][0])
    if not os.path.isfile(path):
        raise errors.refuse("scene", path, "a scene whose result is a file")
    data = read_as(path)
    if any(float(data["book_" + fate]) != told.get(total, float(data["book_" + fate])) for total, fate in FATES.items()):
        raise errors.ClustermcmlError(f"{path}: replaced by another call (expected an output_dir of its own for each)", 5)
    data.attrs.update({key: told[key] for key in MEASURED if told.get(key) is not None})
    return data


def _finished(call: Sequence[str], folder: str, progress: Progress) -> Optional[dict[str, Any]]:
    """Returns the files of a run that was finished before and has no checkpoint. Returns None for any other run.

    --json would fly such a run anew to know all digits. Any other run has a checkpoint after this call, which holds all digits."""
    said = "\n".join(say(call, "", progress))
    names = re.findall(r"^(\S.*): \S+ photons, .*, seed \d+$", said, re.MULTILINE)
    stands = len(names) == 1 and "\n  finished before" in said and not os.path.exists(os.path.join(folder, names[0] + ".checkpoint"))
    return {"files": [_named(path) for path in re.findall("^  -> (.*)$", said, re.MULTILINE)]} if stands else None


def _fly_program(scene: str, folder: str, words: list[str], table: str, progress: Progress, scratch: str, silent: str) -> list[dict[str, Any]]:
    """Flies a scene by the program, or each row of a table, and returns its answers. scratch: temporary folder whose files are not named."""
    call, path, rows = [scene, "-o", folder, *words], os.path.join(scratch, "sweep.csv"), max(table.count("\n") - 1, 0)
    if table:
        with open(path, "w", encoding="utf-8") as file:
            file.write(table)
        call += ["--sweep", path, *(["--output", "row.h5"] if folder == scratch else [])]  # an .h5 has all digits, as the library has them
    if "--resume" in words and folder != scratch and not table and not all(map(NO_RESULT.fullmatch, os.listdir(folder))):
        stands, silent = _finished(call, folder, progress), ALL
        if stands:
            return [stands]
    told = list(map(json.loads, say([*call, "--json"], scratch, progress, rows, silent)))
    if not table and len(told) != 1:
        raise errors.refuse("scene", scene, f"a file with one run, this one has {len(told)}")
    return sorted(({**run, "files": [_named(path) for path in run["files"]]} for run in told), key=lambda run: int(run.get("row") or 0))


def fly(scene: Union[Scene, Text, Path], words: list[str], progress: Progress, *, table: str = "", output_dir: Optional[Path] = None, silent: str = NONE,
        names: Optional[Sequence[str]] = None, keep: Callable[[Fields], Fields] = lambda result: result) -> list[Fields]:
    """Flies a scene, or each row of a table, and returns the results in their order.

    words: options of a command line. table: text of a file of --sweep; "" is none. output_dir: folder for the program's files; None flies in this
    process, or by the program where the library lacks something. silent: pattern of notes that are no warnings. names: of the arrays that are needed;
    the program reads all. keep: returns the part of a result that is kept."""
    _refuse_ranks()
    loaded = library.find(find_program(), words) if output_dir is None else None
    if loaded:
        with library.Runs(loaded, scene, words, silent) as held:
            if held.runs != 1:
                raise errors.refuse("scene", held.path, f"a file with one run, this one has {held.runs}")
            return held.sweep(table, keep, progress, names) if table else [keep(held.fly([], progress, names))]
    with scratch_folder() as scratch:
        folder = errors.folder("output_dir", scratch if output_dir is None else output_dir)
        with scene_file(scene, folder) as path:
            return [keep(result_of(told)) for told in _fly_program(path, folder, words, table, progress, scratch, silent)]


@shown
def run(scene: Union[Scene, Path], *, output_dir: Optional[Path] = None, progress: Wanted = None,
        **options: Unpack[RunOptions]) -> xr.Dataset:
    """Simulates a scene and returns its result.

    Args:
        scene: A Scene, or the path of an `.mci` file with one run.
        output_dir: Folder in which results and checkpoints stay; it is made where it is missing. Calls at the same time need folders of their own.
            None: the run flies in this process without files, or by the program in a temporary folder where the library lacks something.
        progress: Whether to show a progress bar; None shows one in notebooks and terminals. Or a function of percents and a text, called some twice a
            second: it stops the run if it returns True, or raises something.
        **options: Options of the program, with underscores: photons=1e6, seed=2, threads=4, target_error=1e-3, engine="reference",
            no_reentry=True, set={"layer1.mua": 0.5}. `clustermcml help run` lists them.

    Returns:
        An xarray.Dataset as `read` returns it, with how long the run took among the attributes.

    Raises:
        InputError: The scene or an option is refused; the text is the program's.
        ClustermcmlError: The run has failed, or `progress` has stopped it (exit_code 75).
        KeyboardInterrupt: The run was stopped. With output_dir its checkpoint stays, and the same call with resume=True continues.
    """
    if isinstance(scene, Scene) and scene.saved and output_dir is None:
        raise errors.refuse("output_dir", output_dir, "a folder: the file of saved photons stays there")
    with Progress(progress) as shown_progress:
        return fly(scene, option_words(options), shown_progress, output_dir=output_dir)[0].dataset()
