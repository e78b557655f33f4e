"""The command line of the bench programs. Any mistake is reported in one line on standard error, with exit code 2, before anything is measured.

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
    """A parser that reports a mistake in one line."""

    def error(self, message):
        self.exit(2, "%s: %s (--help lists the options)\n" % (self.prog, message))


def number(text):
    """Returns the value of an option that counts or measures, such as 7, 0.5 or 1e7."""
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
    """Returns the absolute path of a program, which may later be started from any folder."""
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
    """Returns a parser with --help, --out, an option for the measured program, the flags, and an option for each count.

    place: name, check and default of the option for the program. counts: the default, or (default, least allowed value); a default that is no
    integer makes a measure."""
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
    """Adds an option that stands alone: `do` is called with its words in place of a measurement. The first word is a result. modules: Python
    modules that `do` needs."""
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
    """Builds a target of cmake. Prints only errors."""
    need(made, "cmake")
    done = subprocess.run(["cmake", "--build", folder, "--target", target], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    if done.returncode:
        made.exit(2, done.stdout)


def only(names, known, made):
    """Returns the known names that the comma-separated `names` selects, or all names if it is empty."""
    wanted = names.split(",") if names else list(known)
    for name in wanted:
        if name not in known:
            made.error("--only %s: no scene; there are %s" % (name, ", ".join(known)))
    return [name for name in known if name in wanted]
