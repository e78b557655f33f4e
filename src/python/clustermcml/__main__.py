"""The command `python3 -m clustermcml fit`, which does the work of mc.fit, and the entrance to `brdf`, `compare`, `plot`,
`profile` and `view`.

An example: `python3 -m clustermcml fit scene.mci measured.csv layer1.mua=0.01:10 layer1.mus=10:500`. Each line of the table
measured.csv is name, place, value, standard error. The place [cm or rad] says which bin of a profile is meant. Totals have no
place.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import warnings
from typing import Any, Iterator

import numpy as np

from . import errors
from .command_line import print_text, shown_path
from .commands import check
from .fit import Fit, fit
from .mco import NUMERAL
from .measured import PROFILES, check_name, check_number
from .options import FitOptions

MOST_BYTES = 256 * 2**20  # largest table that is read; the program has the same limit


def _add_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `run` that the flights of a fit may have. Values stay words, which the program reads."""
    group = parser.add_argument_group("options of the flights, as clustermcml help run explains them")
    for name, kind in FitOptions.__annotations__.items():
        typed = "--" + name.replace("_", "-")
        if kind.__forward_arg__ == "bool":
            group.add_argument(typed, action="store_true", default=None)
        elif kind.__forward_arg__.startswith("Mapping"):
            group.add_argument(typed, action="append", metavar="NAME=VALUE")
        else:
            group.add_argument(typed, metavar="VALUE")


def _options(words: argparse.Namespace) -> Any:
    found: dict[str, Any] = {name: getattr(words, name) for name in FitOptions.__annotations__ if getattr(words, name) is not None}
    for name, _, value in (word.partition("=") for word in found.pop("set", ())):
        if name in found.setdefault("set", {}):
            raise errors.refuse("--set", f"{name}={value}", "each name once")
        found["set"][name] = value
    return found


def _number(word: str) -> float:
    """The number that a word stands for, by the rules of the program. float() alone would also accept 0.3_1 and the digits of
    other scripts."""
    if not NUMERAL.fullmatch(word):
        raise ValueError
    return float(word)


def _bounds(words: list[str]) -> dict[str, tuple[float, float]]:
    bounds = {}
    for word in words:
        name, _, limits = word.partition("=")
        try:
            low, high = map(_number, limits.split(":"))
        except ValueError:
            raise errors.refuse("parameter", word, "NAME=LOW:HIGH, as layer1.mua=0.01:10") from None
        if name in bounds:
            raise errors.refuse("parameter", word, "each parameter once")
        bounds[name] = (low, high)
    return bounds


def _cells(path: str) -> Iterator[tuple[str, str, list[str]]]:
    """Yields each line of the table that has words: FILE:NUMBER, the text of the line, and its words between commas."""
    size = os.path.getsize(errors.existing_file("table", path))
    if size > MOST_BYTES:
        raise errors.InputError(f"{path}: cannot be read: it has {size} bytes (expected a table of at most {MOST_BYTES} bytes)")
    try:
        with open(path, "rb") as file:
            lines = file.read().splitlines()
    except OSError as error:
        raise errors.unreadable(path, "a table", error) from error
    for number, line in enumerate(lines, 1):
        try:
            text = line.decode("utf-8-sig")
        except UnicodeDecodeError:
            raise errors.refuse(f"{path}:{number}", line, "text in UTF-8") from None
        words = [cell.strip(' \t"') for cell in text.partition("#")[0].split(",")]
        if "".join(words) and words[0] != "name":
            yield f"{path}:{number}", text[:200], words


def _measured(path: str, scene: str) -> dict[str, Any]:
    """Reads the table of measured values. Profiles become arrays over the bins of the scene, NaN where nothing was measured."""
    grid = check(scene)[0]["grid"]
    measured: dict[str, Any] = {}
    left = dict.fromkeys(PROFILES, 0)
    for line, text, words in _cells(path):
        try:
            name, (place, value, error) = words[0], (np.nan if word.lower() in ("", "nan") else _number(word) for word in words[1:])
        except ValueError:
            raise errors.refuse(line, text, "name,place,value,error") from None
        check_name(f"{line}: name", name)
        if name not in PROFILES or not np.isnan(value):
            check_number(line, name, value, error)
        if name not in PROFILES:
            if name in measured:
                raise errors.refuse(line, name, "each total once")
            if not np.isnan(place):
                raise errors.refuse(f"{line}: place", words[1], "none of a total")
            measured[name] = (value, error)
            continue
        count, width = (grid["nr"], grid["dr"]) if name.endswith("_r") else (grid["na"], np.pi / 2 / grid["na"])
        most = (count - name.endswith("_r")) * width  # the last bin over r holds all light beyond the grid
        if not 0 <= place < most:
            raise errors.refuse(f"{line}: place", words[1], f"a number from 0 to below {most:g}, where {name} has bins")
        values, sigmas = measured.setdefault(name, (np.full(count, np.nan), np.full(count, np.nan)))
        if not np.isnan(values[int(place / width)]):
            raise errors.refuse(f"{line}: place", words[1], "each bin once")
        values[int(place / width)], sigmas[int(place / width)] = value, error
        left[name] += np.isnan(value)
    for name in filter(left.get, PROFILES):
        warnings.warn(f"{path}: left out lines of {name} without a value: {left[name]}")
    if not measured:
        raise errors.refuse(path, "", "lines NAME,PLACE,VALUE,ERROR")
    return measured


def _beside(found: Fit) -> list[str]:
    """Returns one line for each measured number: model, measured value, both errors, and their difference in units of the
    combined error."""
    lines = []
    for name in found.measured:
        columns = [np.atleast_1d(of[name]) for of in (found.prediction, found.prediction_errors, found.measured, found.measured_errors)]
        places = [f" at {place:.4g}" for place in found.places[name]] if name in found.places else [""]
        lines += [f"model: {name}{place} = {model:.6g} +- {noise:.2g}, measured {value:.6g} +- {error:.2g}, z {(value - model) / np.hypot(noise, error):+.2f}"
                  for place, model, noise, value, error in zip(places, *columns)]
    return lines


class _Parser(argparse.ArgumentParser):
    def print_help(self, file: Any = None) -> None:
        raise SystemExit(print_text(self.format_help()))


def main() -> int:
    """Runs the command that `clustermcml brdf`, `compare`, `plot`, `profile` or `view` hands over, else `fit`. Returns the exit
    code."""
    commands = {"brdf": ".brdf", "compare": ".compare", "plot": ".plot", "profile": ".profile", "view": ".view"}
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    warnings.showwarning = lambda text, *_: print(f"clustermcml: note: {shown_path(str(text))}", file=sys.stderr)
    try:
        found: int = importlib.import_module(commands[command], __package__).main(sys.argv[2:]) if command in commands else fit_main()
        return found
    except errors.ClustermcmlError as error:
        print(f"clustermcml: {shown_path(str(error))}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 130
    except (ImportError, MemoryError):
        raise
    except Exception as error:  # pylint: disable=broad-except # an exception of a library on input that the package let pass
        if os.environ.get("CLUSTERMCML_TRACEBACK"):
            raise
        words = shown_path(" ".join(f"{type(error).__name__}: {error}".split()))
        print(f"clustermcml: {command}: {words} (set CLUSTERMCML_TRACEBACK=1 to see where)", file=sys.stderr)
        return 2


def fit_main() -> int:
    parser = _Parser(prog="python3 -m clustermcml", allow_abbrev=False, description="Fits mua and mus of layers and bodies to what was measured.")
    parser.add_argument("command", choices=["fit"])
    parser.add_argument("scene", help="an .mci file with one run")
    parser.add_argument("measured", help="a table, lines NAME,PLACE,VALUE,ERROR: Rd,,0.31,0.003 or Rd_r,0.05,1.2,0.1")
    parser.add_argument("parameters", nargs="+", help="NAME=LOW:HIGH: layer1.mua=0.01:10")
    parser.add_argument("--flights", type=_number, default=6, help="at most so many, default 6")
    parser.add_argument("-o", "--output", help="a picture of the first profile, model and measured: .svg, .png, .pdf or .eps")
    _add_options(parser)
    words = parser.parse_args()
    try:
        measured = _measured(words.measured, words.scene)
        if words.output is not None and not set(PROFILES) & set(measured):
            raise errors.refuse("-o", words.output, "a profile in the table: " + " ".join(PROFILES))
        if words.output is not None and not words.output.lower().endswith((".svg", ".png", ".pdf", ".eps")):
            raise errors.refuse("-o", words.output, "a name that ends in .svg, .png, .pdf or .eps")
        found = fit(words.scene, _bounds(words.parameters), measured, flights=words.flights, **_options(words))
        code = print_text("\n".join([str(found), *_beside(found), ""]))
        if words.output is not None:
            found.plot(words.output)
    except errors.ClustermcmlError as error:
        if str(error).startswith("measured"):
            error.args = (f"{words.measured}: {error}",)
        raise
    return code


if __name__ == "__main__":
    sys.exit(main())
