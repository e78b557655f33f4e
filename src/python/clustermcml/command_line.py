"""Parts that the commands of the package share: options, messages, exit codes and files.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import os
import re
import stat
import sys
import tempfile
from typing import Any, Callable, NoReturn, Optional, Sequence

from . import errors

MOST_THREADS = 4096  # the limit of the program
PICTURES = (".svg", ".png", ".pdf", ".eps")


def print_text(text: str) -> int:
    """Prints a text. Returns an exit code, like the program's: 0, 5 if standard output cannot be written, or 141 if its reader
    is gone."""
    try:
        if sys.stdout is None:  # standard output is closed
            raise OSError
        print(text, end="", flush=True)
        return 0
    except BrokenPipeError:
        code = 141
    except OSError:
        code = 5
        print("clustermcml: standard output cannot be written", file=sys.stderr)
    setattr(sys, "stdout", None)  # keeps Python from flushing standard output again at exit, which would fail again
    return code


def shown_path(path: str) -> str:
    r"""A file's name, or a message with such names, for people and JSON: bytes that are no UTF-8, and controls of terminals, as \xNN.

    >>> shown_path("a" + chr(27) + "b.mco")
    'a\\x1bb.mco'
    """
    text = os.fsencode(path).decode("utf-8", "backslashreplace")
    return "".join(sign if sign.isprintable() else "".join(f"\\x{byte:02x}" for byte in sign.encode()) for sign in text)


class Parser(argparse.ArgumentParser):
    """The parser of a command's options. Every mistake is reported in one line, with exit code 2."""

    def __init__(self, command: str, operands: str, text: str, example: str) -> None:
        super().__init__(prog="clustermcml " + command, usage=f"clustermcml {command} {operands} [options]", description=text, epilog="example: " + example,
                         allow_abbrev=False)
        self.command = command

    def error(self, message: str) -> NoReturn:
        """Refuses the command line. argparse's "argument -o/--output: TEXT" becomes "--output TEXT"."""
        own = re.fullmatch(r"argument (?:-\w/)?(--[\w-]+): (.*)", message)
        text = f"{own[1]} {own[2]}" if own and "(expected" in own[2] else f"{self.command}: {message}"
        raise errors.InputError(text if "(expected" in text else f"{text} (try clustermcml {self.command} --help)")

    def print_help(self, file: Any = None) -> None:
        raise SystemExit(print_text(self.format_help()))

    def add_output(self, text: str, default: Optional[str] = None) -> None:
        self.add_argument("-o", "--output", metavar="FILE", default=default, type=picture_name, help=text)

    @staticmethod
    def number(expected: str, least: float = -math.inf, most: float = math.inf) -> Callable[[str], float]:
        """Returns a function that reads numbers from least to most."""
        def of(word: str) -> float:
            with contextlib.suppress(ValueError):
                if math.isfinite(float(word)) and least <= float(word) <= most:
                    return float(word)
            raise argparse.ArgumentTypeError(f"{word} (expected {expected})")
        return of

    @staticmethod
    def whole(least: int, most: int) -> Callable[[str], int]:
        """Returns a function that reads whole numbers from least to most. 1e6 is a whole number."""
        expected = f"a whole number from {least} to {most}"
        read = Parser.number(expected, least, most)

        def of(word: str) -> int:
            value = read(word)
            if value % 1:
                raise argparse.ArgumentTypeError(f"{word} (expected {expected})")
            return int(value)
        return of


def picture_name(path: str) -> str:
    """Returns the path if its ending is that of a picture, for the parser of a command."""
    if not path.lower().endswith(PICTURES):
        raise argparse.ArgumentTypeError(f"{path} (expected a name that ends in .svg, .png, .pdf or .eps)")
    return path


def picture_path(output: Any) -> str:
    """Checks the argument `output` of a function that draws: its ending must be that of a picture. Returns the path."""
    if not isinstance(output, (str, os.PathLike)) or not os.fspath(output).lower().endswith(PICTURES) or "\0" in os.fspath(output):
        raise errors.refuse("output", output, "a name that ends in .svg, .png, .pdf or .eps")
    return os.fspath(output)


def path_of(path: Any, ending: str) -> str:
    """Returns the path of a file to be written. Refuses a name with another ending."""
    if not isinstance(path, (str, os.PathLike)) or not os.fspath(path).endswith(ending) or "\0" in os.fspath(path):
        raise errors.refuse("path", path, f"a name that ends in {ending}")
    return os.fspath(path)


def check_overwrite(command: str, output: Optional[str], inputs: Sequence[str]) -> None:
    """Refuses an output that is one of the command's inputs, also under another name."""
    for path in inputs if output is not None else ():
        if os.path.exists(path) and os.path.exists(str(output)) and os.path.samefile(path, str(output)):
            raise errors.InputError(f"{command}: -o {output} would overwrite its input {path}")


def file_stem(command: str, output: Optional[str], endings: Sequence[str], scene: str, label: Optional[str]) -> str:
    """Returns the beginning of the names of a command's files; the default is the name of the scene. Refuses a beginning that
    would hide a file, or replace the scene or the table of --label."""
    stem = os.path.splitext(scene)[0] if output is None else output
    if os.path.basename(stem) in ("", ".", "..") or not os.path.isdir(os.path.dirname(os.path.abspath(stem))):
        raise errors.InputError(f"--output {shown_path(stem) or repr(stem)} (expected the beginning of a file's name, in a folder that is there)")
    for ending in endings:
        check_overwrite(command, stem + ending, [scene, (label or "").partition("=")[2]])
    return stem


def readable(path: str) -> str:
    """Returns the path if the file can be opened. Pipes are refused without opening them, because opening a pipe may block for
    ever."""
    try:
        mode = os.stat(path).st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise errors.InputError(f"{shown_path(path)}: is no regular file (expected an {os.path.splitext(path)[1].lower()} file)")
        with open(path, "rb"):
            return path
    except errors.InputError:
        raise
    except (OSError, ValueError) as error:
        raise errors.InputError(f"{shown_path(path)}: cannot be opened ({getattr(error, 'strerror', None) or error})") from None


def write(path: str, content: bytes) -> None:
    """Writes all of a file or none of it. Special files such as /dev/stdout are written directly."""
    try:
        if os.path.exists(path) and not os.path.isfile(path):
            with open(path, "wb") as file:
                file.write(content)
            return
        path = os.path.realpath(path)
        handle, name = tempfile.mkstemp(dir=os.path.dirname(path), prefix=".clustermcml_")
        try:
            with io.FileIO(handle, "w") as file:
                file.write(content)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(name, os.stat(path).st_mode & 0o777 if os.path.exists(path) else 0o666 & ~umask)
            os.replace(name, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)
            raise
    except OSError as error:
        raise errors.ClustermcmlError(f"{shown_path(path)}: cannot be written ({error.strerror})", 5) from error
