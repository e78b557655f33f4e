"""What can go wrong, and how arguments are checked.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import math
import os
from typing import Any


class ClustermcmlError(Exception):
    """The program has failed. The text is its own message, which names what was wrong and what was expected.

    exit_code: of the program (3 no device, 4 numerical, 5 a file could not be written, 75 stopped by a signal).
    """

    def __init__(self, message: str, exit_code: int = 2) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class InputError(ClustermcmlError, ValueError):
    """An argument, a scene or a file is not what it must be (exit code 2 of the program)."""


def refuse(name: str, value: object, expected: str) -> InputError:
    """The error of an argument: its name, its value, and what was expected."""
    return InputError(f"{name} = {value!r} (expected {expected})")


def number(name: str, value: Any, least: float, most: float, expected: str) -> float:
    """The value as a float, if it is a number from `least` to `most`.

    >>> number("Layer.g", 1.5, -1, 1, "a number from -1 to 1")
    Traceback (most recent call last):
    ...
    clustermcml.errors.InputError: Layer.g = 1.5 (expected a number from -1 to 1)
    """
    try:
        as_float = float(value)
    except (TypeError, ValueError):
        raise refuse(name, value, expected) from None
    if isinstance(value, (str, bytes, bool)) or not least <= as_float <= most:
        raise refuse(name, value, expected)
    return as_float


def at_least_zero(name: str, value: Any) -> float:
    return number(name, value, 0.0, 1e300, "a number >= 0")


def above_zero(name: str, value: Any) -> float:
    return number(name, value, math.ulp(0.0), 1e300, "a number > 0")


def finite(name: str, value: Any) -> float:
    return number(name, value, -1e300, 1e300, "a finite number")


def whole(name: str, value: Any, least: int, most: int) -> int:
    """The value as an int, if it is a whole number from `least` to `most`; 1e6 is one."""
    expected = f"a whole number from {least} to {most}"
    as_float = number(name, value, least, most, expected)
    if as_float != int(as_float):
        raise refuse(name, value, expected)
    return int(value)


def existing_file(name: str, value: Any) -> str:
    """The path of a file that is there, absolute."""
    if not isinstance(value, (str, os.PathLike)):
        raise refuse(name, value, "the path of a file")
    if not os.path.isfile(value):
        raise refuse(name, os.fspath(value), "the path of a file that is there")
    return os.path.abspath(os.fspath(value))
