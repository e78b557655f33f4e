"""What the programs of bench ask of a command line: one line to standard error and exit code 2 for whatever is wrong before anything
is measured.

SPDX-License-Identifier: MIT
"""
import argparse
import os
import shutil
import subprocess
import sys

import cases
import picture


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


def build_folder(path):
    if not os.path.isfile(os.path.join(path, "CMakeCache.txt")):
        raise argparse.ArgumentTypeError("%s: no build folder of cmake" % path)
    return os.path.abspath(path)


BUILD = ("build", build_folder, os.path.join(cases.ROOT, "build"))
PROGRAM = ("program", built, os.path.join(BUILD[2], "clustermcml"))


def at_least(least):
    def checked(text):
        if count(text) < least:
            raise argparse.ArgumentTypeError("%s: fewer than %d are too few" % (text, least))
        return count(text)
    return checked


def parser(text, flags="", place=PROGRAM, **counts):
    """With --help and --out, an option for what is measured, `place`, by its name, check and default, the flags, and an option for
    each count with its default, or (default, least that is allowed); a default that is no integer makes a measure."""
    made = Parser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--" + place[0], type=place[1], default=place[2])
    made.add_argument("--out", default=os.path.join(cases.BENCH, "out"))
    for flag in flags.split():
        made.add_argument("--" + flag, action="store_true")
    for name, default in counts.items():
        default, least = default if isinstance(default, tuple) else (default, 1)
        made.add_argument("--" + name, type=number if isinstance(default, float) else at_least(least), default=default)
    return made


def instead(made, option, words, do, *modules):
    """Adds an option that stands alone, with these words, a result the first of them: `do` is called with them in place of a
    measurement. It needs the modules of Python."""
    class Instead(argparse.Action):
        def __call__(self, parser, namespace, values, option_string=None):
            if sys.argv[1:] != [option, *values]:
                made.error("%s needs %s and nothing else" % (option, " and ".join(words)))
            if not os.access(values[0], os.R_OK):
                made.error("%s: cannot be read" % values[0])
            picture.need(made, *modules)
            do(*values)
            made.exit()
    made.add_argument(option, nargs=len(words), metavar=words, action=Instead)


def need(made, *commands):
    for wanted in commands:
        if not shutil.which(wanted):
            made.error("%s is missing" % wanted)


def build(made, folder, target):
    """Builds a target of cmake, and says no more than what goes wrong."""
    need(made, "cmake")
    done = subprocess.run(["cmake", "--build", folder, "--target", target], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    if done.returncode:
        made.exit(2, done.stdout)


def only(names, known, made):
    """Those of the known names that stand between commas; all where there are none."""
    wanted = names.split(",") if names else list(known)
    for name in wanted:
        if name not in known:
            made.error("--only %s: no scene; there are %s" % (name, ", ".join(known)))
    return [name for name in known if name in wanted]
