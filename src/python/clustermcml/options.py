"""The options of the program's commands as keyword arguments: their names and types. `clustermcml help COMMAND` says what they do.

Type checkers and editors read the classes; `shown` puts their names into the signatures that notebooks and help() ask for.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import inspect
import os
import sys
from typing import TYPE_CHECKING, Any, Callable, Literal, Mapping, Optional, Sequence, TypedDict, TypeVar, Union

import numpy as np

from . import errors

if TYPE_CHECKING:
    from .top import Face

Path = Union[str, os.PathLike[str]]
Function = TypeVar("Function", bound=Callable[..., Any])


class ExactOptions(TypedDict, total=False):
    set: Mapping[str, float]
    tolerance: float
    mesh_budget: float


class MeshOptions(ExactOptions, total=False):
    ignore_heightfields: bool
    boundaries: Literal["auto", "plane", "cone", "mesh"]
    normals: Literal["analytic", "vertex", "facet"]
    rings: Literal["area", "inscribed"]


class _Flight(MeshOptions, total=False):
    no_reentry: bool
    mesh_search: Literal["auto", "tree", "embree"]


class CheckOptions(_Flight, total=False):
    ignore_absorption: bool
    engine: Literal["cpu", "reference", "opencl"]
    threads: int


class _Packets(_Flight, total=False):
    seed: int
    roulette: Union[str, Sequence[float]]
    device: Union[int, str, Sequence[int]]
    group: int
    build_options: str


class TraceOptions(_Packets, total=False):
    run: int
    sampling: Literal["lattice", "random"]
    engine: Literal["cpu", "reference", "opencl"]


class _Photons(_Packets, total=False):
    photons: float
    ignore_absorption: bool
    threads: int
    chunk: float


class PlanOptions(_Photons, total=False):
    target_error: float
    error_of: str
    aim: Union[str, Sequence[str]]
    patience: float


class CrosscheckOptions(_Photons, total=False):
    sampling: Literal["lattice", "random"]
    dump: Path


class FurnaceOptions(MeshOptions, total=False):
    photons: float
    seed: int
    sampling: Literal["lattice", "random"]
    mesh_search: Literal["auto", "tree", "embree"]
    engine: Literal["cpu", "reference", "opencl"]
    threads: int
    patience: float
    alpha: float


class RunOptions(PlanOptions, total=False):
    sampling: Literal["lattice", "random"]
    engine: Literal["cpu", "reference", "opencl"]
    checkpoint: Union[float, Literal["off"]]
    resume: bool
    replace: bool
    no_clobber: bool
    keep: bool
    more: float
    derivatives: bool


class FitOptions(_Photons, total=False):
    sampling: Literal["lattice", "random"]
    engine: Literal["cpu", "reference"]
    patience: float


class SweepOptions(RunOptions, total=False):
    reweight: bool


class ProbeOptions(TypedDict, total=False):
    fill: Optional[float]
    face: Optional[Face]
    lit: Sequence[int]
    read: Optional[Sequence[int]]
    group: Optional[str]


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


def shown(function: Function) -> Function:
    """Returns the function with a signature in which the options of **options: Unpack[KIND] stand one by one."""
    signature = inspect.signature(function)
    *fixed, options = signature.parameters.values()
    kind = globals()[options.annotation.removeprefix("Unpack[").removesuffix("]")]
    keywords = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kept.__forward_arg__)
                for name, kept in kind.__annotations__.items()]
    setattr(function, "__signature__", signature.replace(parameters=[*fixed, *keywords]))
    return function
