"""What the Python programs of bench ask of a command line, as lib.sh does: one line to standard error and exit code 2 for whatever
is wrong before anything is measured.

SPDX-License-Identifier: MIT
"""
import argparse
import os

import cases

PROGRAM = os.path.join(cases.ROOT, "build", "clustermcml")


class Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message):
        self.exit(2, "%s: %s (--help lists the options)\n" % (self.prog, message))


def number(text):
    """An option that counts or measures, like 7, 0.5 or 1e7."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError("%s: not a number above 0" % text)
    return value


def count(text):
    if number(text) < 1:
        raise argparse.ArgumentTypeError("%s: not a count" % text)
    return int(number(text))


def built(path):
    """A program, from wherever it is started later."""
    if not (os.path.isfile(path) and os.access(path, os.X_OK)):
        raise argparse.ArgumentTypeError("%s is no program: build it first" % path)
    return os.path.abspath(path)


def at_least(least):
    def checked(text):
        if count(text) < least:
            raise argparse.ArgumentTypeError("%s: fewer than %d tell no error" % (text, least))
        return count(text)
    return checked


def parser(text, **counts):
    """With --help, --program and --out, and an option for each count with its default, or (default, least that is allowed)."""
    made = Parser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--program", type=built, default=PROGRAM)
    made.add_argument("--out", default=os.path.join(cases.BENCH, "out"))
    for name, default in counts.items():
        default, least = default if isinstance(default, tuple) else (default, 1)
        made.add_argument("--" + name, type=at_least(least), default=default)
    return made


def only(names, known, made):
    """Those of the known names that stand between commas; all where there are none."""
    wanted = names.split(",") if names else list(known)
    for name in wanted:
        if name not in known:
            made.error("--only %s: no scene; there are %s" % (name, ", ".join(known)))
    return [name for name in known if name in wanted]
