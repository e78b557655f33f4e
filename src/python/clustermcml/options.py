"""The options of the program's commands as keyword arguments: their names and types. `clustermcml help COMMAND` says what they do.

Type checkers and editors read the classes; `shown` puts their names into the signatures that notebooks and help() ask for.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import inspect
import os
from typing import TYPE_CHECKING, Any, Callable, Literal, Mapping, Optional, Sequence, TypedDict, TypeVar, Union

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


def shown(function: Function) -> Function:
    """Returns the function with a signature in which the options of **options: Unpack[KIND] stand one by one."""
    signature = inspect.signature(function)
    *fixed, options = signature.parameters.values()
    kind = globals()[options.annotation.removeprefix("Unpack[").removesuffix("]")]
    keywords = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kept.__forward_arg__)
                for name, kept in kind.__annotations__.items()]
    setattr(function, "__signature__", signature.replace(parameters=[*fixed, *keywords]))
    return function
