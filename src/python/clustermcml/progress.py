"""Progress of a run: a bar in a notebook, a line in a terminal, or calls of a function, which may stop the run.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import sys
from typing import Any, Callable, Optional, Union

Wanted = Union[bool, Callable[[int, str], Any], None]  # an argument `progress`


def _notebook_bar() -> Any:
    """Shows and returns a bar of 100 parts, or returns None outside of notebooks."""
    shell = sys.modules.get("IPython")
    kernel = shell.get_ipython() if shell else None
    if kernel is None or not hasattr(kernel, "kernel"):
        return None
    from IPython.display import ProgressBar

    bar = ProgressBar(100)
    bar.display()
    return bar


class Progress:
    """Shows percents. Used as a context, it ends a half-written line, and raises what the function has raised.

    show: with None, progress is shown if standard error is a terminal, or Python runs in a notebook. A function gets what `show` gets.
    """

    def __init__(self, show: Wanted) -> None:
        self.function = show if callable(show) else None
        self.failed: Optional[BaseException] = None
        self.bar = None if show is False or self.function else _notebook_bar()
        self.lines = self.bar is None and not self.function and (sys.stderr.isatty() if show is None else bool(show))
        self.begun, self.count, self.part = False, 0, ""

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.progress = 100
        if self.begun:
            print(file=sys.stderr)
        if self.failed:
            raise self.failed

    def begin(self, name: str) -> None:
        """Begins the next part of the work, which `show` numbers."""
        self.count += 1
        self.part = f"{name} {self.count}, "

    def show(self, percent: int, text: str) -> bool:
        """Shows progress of a part, and returns whether the run shall stop. percent: 0 to 100. text: words after it."""
        if self.function:
            try:
                return bool(self.function(percent, self.part + text))
            except BaseException as error:  # pylint: disable=broad-except # no exception passes through the library
                self.failed = error
                return True
        if self.bar is not None:
            self.bar.progress = percent
        elif self.lines:
            self.begun = True
            print(f"\r{self.part}{percent} %, {text}\033[K", end="", file=sys.stderr, flush=True)
        return False
