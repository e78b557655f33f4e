"""Files of scenes that Python holds in memory, and the folders of such files.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import tempfile
from typing import Iterator, Union

from . import errors
from .options import Path
from .scene import Scene, Text

NONE = "(?!)"  # pattern of no note
OWN = "# written by clustermcml.run or sweep\n"


def renamed(text: str, folder: str) -> str:
    """Returns a message of the program in the caller's words: names of files in a temporary folder become names of the objects
    that the caller knows.

    >>> renamed("/tmp/x/scene.mci:9: boundary 0: /tmp/x/scene.surface0.obj: no faces", "/tmp/x")
    'Scene: boundary 0: its surface: no faces'
    >>> renamed("/tmp/x/scene.mco: cannot be written (No space left on device)", "/tmp/x")
    'scene.mco: cannot be written (No space left on device)'
    >>> renamed("Scene/scene.mci:3: MyScene/lamp.gsf: no NUL byte", "Scene")
    'Scene: MyScene/lamp.gsf: no NUL byte'
    """
    before = r"(?<![\w./-])" + re.escape(folder + os.sep)  # not the end of a longer path
    names = {r"scene\.mci": "Scene", r"scene\.surface\d+\.\w+": "its surface", r"scene\.layer\d+body\d+\.\w+": "its surface",
             r"scene\.layer\d+(body\d+)?\.phase\.txt": "table of a Phase", r"sweep\.csv": "parameters"}
    for file, name in names.items():
        text = re.sub(before + file + r"(:\d+)?(?!\w)", name, text)
    return re.sub(before, "", text) if folder else text


def own_words(text: str) -> str:
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


def scene_text(scene: Union[Scene, Text], folder: Path) -> str:
    """Returns the text of a scene's file in a folder, in which its surfaces and tables are written."""
    try:
        return scene if isinstance(scene, Text) else OWN + scene.text("scene.mco", folder)
    except OSError as error:
        raise errors.ClustermcmlError(f"{error.filename}: cannot be written ({error.strerror})", 5) from error


@contextlib.contextmanager
def scene_file(scene: Union[Scene, Text, Path], folder: str) -> Iterator[str]:
    """Yields the path of the scene's file. A scene in memory is written into `folder`, and no other call writes there until its
    result is read: the file is locked. The kernel unlocks it when the process ends, so that no stale lock remains."""
    if not isinstance(scene, (Scene, Text)):
        yield errors.existing_file("scene", scene)
        return
    path = os.path.join(folder, "scene.mci")
    with contextlib.ExitStack() as held:
        try:
            file = held.enter_context(open(path, "a+b"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                held.callback(fcntl.flock, file, fcntl.LOCK_UN)  # closing is not enough, because a process forked meanwhile also has the file open
            except BlockingIOError:
                raise errors.ClustermcmlError(f"{path}: locked by another call (expected an output_dir of its own for each)", 5) from None
            except OSError:  # this file system has no locks
                pass
            file.seek(0)
            if file.read(len(OWN)) not in (b"", OWN.encode()):
                raise errors.refuse("output_dir", folder, "a folder without another scene.mci, which would be overwritten")
            file.truncate(0)
            file.write(scene_text(scene, folder).encode("utf-8", "surrogateescape"))
            file.flush()
        except OSError as error:
            raise errors.ClustermcmlError(f"{path}: cannot be written ({error.strerror})", 5) from error
        try:
            yield path
        except errors.ClustermcmlError as error:
            error.args = (own_words(str(error)),)
            raise


@contextlib.contextmanager
def as_file(scene: Union[Scene, Path]) -> Iterator[tuple[str, str]]:
    """Yields the path of the scene's file, and a temporary folder, in which a Scene object is written."""
    with scratch_folder() as scratch, scene_file(scene, scratch) as path:
        yield path, scratch


class Beside(contextlib.ExitStack):
    """The folder beside a scene in memory. It is made if a surface or a table is written there: the library reads these from files alone."""

    name = ""

    def __fspath__(self) -> str:
        self.name = self.name or self.enter_context(tempfile.TemporaryDirectory(prefix="clustermcml_"))
        return self.name
