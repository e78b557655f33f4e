"""Exceptions of the package, and checks of arguments.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import inspect
import math
import os
import re
import unicodedata
import warnings
from typing import Any

import numpy as np


class ClustermcmlError(Exception):
    """The program has failed. The text is its own message, which names what was wrong and what was expected.

    Attributes:
        exit_code: Exit code of the program: 3 no device, 4 numerical, 5 a file could not be written, 75 stopped by a signal.
    """

    def __init__(self, message: str, exit_code: int = 2) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class InputError(ClustermcmlError, ValueError):
    """An argument, a scene or a file is refused (exit code 2 of the program). The text names it, its value and what was expected."""


def _shown(value: object) -> str:
    """Returns a value in one line for a message. A long list or array is cut after 200 letters.

    >>> _shown(np.zeros((2, 2)))
    'array([[0., 0.], [0., 0.]])'
    """
    text = re.sub(r"\s*\n\s*", " ", repr(value))
    return text if isinstance(value, str) or len(text) <= 200 else text[:200] + " ..."


def warn(text: str) -> None:
    """Warns at the line that has called this package."""
    frame, level = inspect.currentframe(), 1
    while frame and frame.f_globals.get("__package__") == __package__:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, stacklevel=level)


def refuse(name: str, value: object, expected: str) -> InputError:
    """Returns the exception for a bad argument: its name, its value, and the expected values in words."""
    return InputError(f"{name} = {_shown(value)} (expected {expected})")


def unreadable(path: str, expected: str, error: Exception) -> InputError:
    """Returns the exception, in one line, for a file whose reading has failed with `error`."""
    kind = "" if type(error) is ValueError else type(error).__name__ + ": "  # the text of a ValueError is written in this package
    return InputError(f"{path}: not {expected} ({kind}{' '.join(str(error).split())[:200]})")


def number(name: str, value: Any, least: float, most: float, expected: str) -> float:
    """Returns the value as a float. Refuses all but numbers from `least` to `most`.

    >>> number("Layer.g", 1.5, -1, 1, "a number from -1 to 1")
    Traceback (most recent call last):
    ...
    clustermcml.errors.InputError: Layer.g = 1.5 (expected a number from -1 to 1)
    """
    try:
        as_float = float(value)
    except (TypeError, ValueError, OverflowError):
        raise refuse(name, value, expected) from None
    if isinstance(value, (str, bytes, bool, np.bool_)) or not least <= as_float <= most:
        raise refuse(name, value, expected)
    return as_float


def at_least_zero(name: str, value: Any) -> float:
    """Returns the value as a float. Refuses all but numbers of 0 or more."""
    return number(name, value, 0.0, 1e300, "a number >= 0")


def above_zero(name: str, value: Any) -> float:
    """Returns the value as a float. Refuses all but numbers above 0."""
    return number(name, value, math.ulp(0.0), 1e300, "a number > 0")


def finite(name: str, value: Any) -> float:
    """Returns the value as a float. Refuses all but finite numbers."""
    return number(name, value, -1e300, 1e300, "a finite number")


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Returns the value as an int. Refuses all but whole numbers from `least` to `most`. 1e6 is a whole number."""
    expected = f"a whole number from {least} to {most}"
    as_float = number(name, value, least, most, expected)
    if as_float != int(as_float) or not least <= int(value) <= most:  # rounding to float may hide that an int is just above the limit
        raise refuse(name, value, expected)
    return int(value)


def flag(name: str, value: Any) -> None:
    """Refuses all but True and False."""
    if not isinstance(value, (bool, np.bool_)):
        raise refuse(name, value, "True or False")


def choice(name: str, value: Any, *known: str) -> None:
    """Refuses all but the known words."""
    if not isinstance(value, str) or value not in known:
        raise refuse(name, value, "one of " + " ".join(known))


def optional(name: str, value: object, kinds: Any, expected: str) -> None:
    """Refuses all but objects of these kinds, and None."""
    if not isinstance(value, (kinds, type(None))):
        raise refuse(name, value, expected)


def array(name: str, value: Any, kinds: str, expected: str) -> Any:
    """Returns the value as an array of finite numbers. kinds: the allowed kinds of its dtype, as letters of numpy.

    Masked numbers are refused. The message names the first number that is missing, because the shown beginning of a large array
    may have none.

    >>> array("Mesh.faces", [[0, 1, 2], [3]], "iu", "an array [m, 3] of whole numbers")
    Traceback (most recent call last):
    ...
    clustermcml.errors.InputError: Mesh.faces = [[0, 1, 2], [3]] (expected an array [m, 3] of whole numbers)
    """
    try:
        numbers = np.asarray(value)
    except (TypeError, ValueError):
        raise refuse(name, value, expected) from None
    if numbers.dtype.kind not in kinds:
        raise refuse(name, value, expected)
    finite = np.isfinite(numbers)
    holes = np.argwhere(~finite | (value.mask if isinstance(value, np.ma.MaskedArray) else False))
    if len(holes):
        first = tuple(holes[0])
        raise refuse(f"{name}{holes[0].tolist() or ''}", np.ma.masked if finite[first] else numbers[first].item(),
                     f"{expected}; {len(holes)} of {numbers.size} numbers are missing, the first here")
    return numbers


def existing_file(name: str, value: Any, expected: str = "the path of a file that is there") -> str:
    """Returns the absolute path of a file. Refuses a path where no file is."""
    if not isinstance(value, (str, os.PathLike)):
        raise refuse(name, value, expected)
    try:
        there = os.path.isfile(value)
    except ValueError:  # the path has a NUL character, or half of a surrogate pair
        there = False
    if not there:
        raise refuse(name, os.fspath(value), expected)
    return os.path.abspath(os.fspath(value))


def quoted_file(name: str, value: Any, expected: str = "the path of a file that is there") -> str:
    """Returns the absolute path of an existing file in quotes, which an `.mci` file in any folder can hold."""
    path = existing_file(name, value, expected)
    if re.search('["\r\n]', path):
        raise refuse(name, path, "a path without quotation marks and ends of lines")
    return f'"{path}"'


def folder(name: str, value: Any) -> str:
    """Returns the absolute path of a folder, which is made if it does not exist."""
    if not isinstance(value, (str, os.PathLike)) or not os.fspath(value):
        raise refuse(name, value, "a folder")
    try:
        os.makedirs(value, exist_ok=True)
    except (OSError, ValueError) as error:
        raise refuse(name, value, f"a folder that is there or can be made; {getattr(error, 'strerror', None) or error}") from None
    return os.path.abspath(os.fspath(value))


def is_line(text: str) -> bool:
    """True if a file in UTF-8 can hold the text in one line."""
    return not any(unicodedata.category(sign) in ("Cc", "Cs", "Zl", "Zp") for sign in text)


def text(name: str, value: Any) -> str:
    """Returns the value if it is a text of one line that a file in UTF-8 can hold; refuses it otherwise.

    >>> text("Saved.name", "a\\nb")
    Traceback (most recent call last):
    ...
    clustermcml.errors.InputError: Saved.name = 'a\\nb' (expected a text of one line)
    """
    if not isinstance(value, str) or not is_line(value):
        raise refuse(name, value, "a text of one line")
    return value


def rounded(value: float, error: float, sign: str = "+-") -> str:
    """Returns a value and its standard error as text, rounded to two digits of the error.

    >>> rounded(5.21656, 1.6), rounded(123456, 4321), rounded(1.23e-7, 4.5e-9), rounded(2, float("inf"))
    ('5.2 +- 1.6', '123500 +- 4300', '1.230e-07 +- 4.5e-09', '2 +- inf')
    """
    if not (math.isfinite(value) and math.isfinite(error) and error > 0):
        return f"{value:.6g} {sign} {error:.2g}"
    last = int(f"{error:.1e}".partition("e")[2]) - 1  # power of ten of the second digit of the error
    if last < -6:
        size = int(f"{max(abs(value), error):.6e}".partition("e")[2])
        return f"{value:.{max(size - last, 0)}e} {sign} {error:.1e}"
    return f"{round(value, -last):.{max(-last, 0)}f} {sign} {round(error, -last):.{max(-last, 0)}f}"
