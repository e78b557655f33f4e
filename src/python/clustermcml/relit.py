"""Scenes in another light: the scene's beams and tallies are replaced by lines of the caller.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import os
import re
import warnings
from typing import Any, Sequence, Union

from . import errors
from .commands import check
from .mco import NUMERAL
from .options import Path
from .scene import Scene, Text

REPLACED = ("beam", "map", "facets", "time", "directions", "fluence", "detector", "photons")  # keywords of the lines before the layers that are replaced
WITH_FILES = ("m", "b", "i", "phase", "beam")
WORD = re.compile(r'"[^"]*"|\S+')


def told_of(scene: Union[Scene, Path]) -> dict[str, Any]:
    """Returns the answer of `check` for a scene with one run. Its notes are left out, because they concern a light that is
    replaced."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        runs = check(scene)
    if len(runs) != 1:
        raise errors.refuse("scene", os.fspath(scene) if isinstance(scene, os.PathLike) else scene, f"a file with one run, this one has {len(runs)}")
    return runs[0]


def _words(line: str) -> list[str]:
    """Returns the words of a line without its comment. A line after `#@` is a line of this program, not a comment."""
    text = line.strip()
    text = text[2:] if text.startswith("#@") else text
    return WORD.findall(re.sub(r'("[^"]*")|#.*', lambda found: found[1] or "", text))


def _absolute(words: Sequence[str], folder: str) -> list[str]:
    """Returns the words. Names of existing files become absolute paths."""
    def of(word: str) -> str:
        path = os.path.join(folder, word.strip('"'))
        if NUMERAL.fullmatch(word):
            return word
        return f'"{os.path.abspath(path)}"' if os.path.isfile(path) else word
    return [of(word) for word in words]


def light_lines(path: str, *kinds: str) -> list[list[str]]:
    """Returns the words of the scene's lines of these kinds: beam, detector. Names of files become absolute."""
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        return [_absolute(words, os.path.dirname(path)) for words in map(_words, file) if words[:1] and words[0] in kinds]


def beam_shape(path: str) -> str:
    """Returns the shape of the scene's one beam and the place of its axis, as words of a `beam` line. Empty for the default
    pencil."""
    return " ".join(word for words in light_lines(path, "beam")[:1] for word in words[1:] if "=" not in word or word.startswith("at="))


def relit_text(path: str, lines: Sequence[str]) -> Text:
    """The text of the scene in `path` with `lines` in place of its beams and tallies. Names of files become absolute."""
    folder, kept, with_words = os.path.dirname(path), [], 0
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        for line in file.read().splitlines():
            words = _words(line)
            if not words or with_words >= 3 and words[0] in REPLACED:
                continue
            with_words += 1
            kept.append(" ".join(_absolute(words, folder) if words[0] in WITH_FILES else words))
            kept += lines if with_words == 3 else []
    return Text("\n".join([*kept, ""]))
