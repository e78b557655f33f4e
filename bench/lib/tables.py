"""Writes results and the texts that show them: CSV files with a head of comments, tables, and lines of a README.

The lines of a README stand between `<!-- written by bench/NAME -->` and `<!-- until here -->`. As a program, tables.py FILE README puts a result
there: a .csv as a table, a .md as its lines. NAME is then `lib/tables.py FILE`, with FILE as seen from bench.

SPDX-License-Identifier: MIT
"""
import csv
import json
import os
import platform
import shlex
import subprocess
import sys
import textwrap
import time

BENCH = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
END = "<!-- until here -->"


def wrapped(line):
    """The lines of a long one, which no table has."""
    if line.startswith("|") or len(line) <= 140:
        return [line]
    return textwrap.wrap(line, 140, subsequent_indent="  " * line.startswith("- "), break_long_words=False, break_on_hyphens=False)


def replace(readme, name, fresh):
    """Replaces the lines that were written before. Refuses a file without a place for them."""
    begin = "<!-- written by bench/%s -->" % name
    with open(readme, encoding="utf-8") as stream:
        lines = stream.read().split("\n")
    if begin not in lines or END not in lines[lines.index(begin):]:
        sys.exit("%s: no lines %s and, below it, %s" % (readme, begin, END))
    first = lines.index(begin)
    last = lines.index(END, first)
    with open(readme, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines[:first + 1] + [part for line in fresh for part in wrapped(line)] + lines[last:]))


def table(titles, rows):
    """Yields the lines of a Markdown table. Cells are words or numbers."""
    yield "| " + " | ".join(titles) + " |"
    yield "|---" * len(titles) + "|"
    for row in rows:
        yield "| " + " | ".join(map(str, row)) + " |"


def aligned(grid):
    """Returns the lines of a table for a terminal."""
    widths = [max(map(len, column)) for column in zip(*grid)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in grid]


def measured(header, *keys):
    """Returns the first line above a table: date, program, machine and other keys, as far as the result knows them."""
    about = dict(header)
    return "Measured: " + "; ".join(about[key] for key in ("date", "program", "machine") + keys if about.get(key))


def command_line(command):
    """Returns the first line that a command prints, or a question mark."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")[0]
    except (OSError, subprocess.CalledProcessError):
        return "?"


def compiler(program):
    """Returns (name and version, flags) of the compiler, from the folder in which the program was built."""
    try:
        with open(os.path.join(os.path.dirname(os.path.abspath(program)), "compile_commands.json")) as stream:
            words = [shlex.split(entry["command"]) for entry in json.load(stream)
                     if entry["file"].endswith("engine_cpu_level.c")][0]
    except (OSError, IndexError, KeyError, ValueError):
        return "?", "?"
    flags = [word for word in words if word[:2] in ("-O", "-f", "-m")]
    return command_line([words[0], "--version"]), " ".join(flags)


def processor():
    if not os.path.exists("/proc/cpuinfo"):
        return "?"
    with open("/proc/cpuinfo") as stream:
        names = [line.split(":")[1].strip() for line in stream if line.startswith("model name")]
    return names[0] if names else platform.machine()


def machine(program, rounds):
    """Returns the things on which measured numbers depend, as (key, text) pairs."""
    built_by, flags = compiler(program)
    return [("date", time.strftime("%Y-%m-%d")), ("program", command_line([program, "--version"])),
            ("machine", "%s, %d cores" % (processor(), os.cpu_count())), ("compiler", built_by), ("flags", flags), ("rounds", str(rounds))]


def write_csv(path, header, rows):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", newline="") as stream:
        for key, text_of in header:
            stream.write("# %s: %s\n" % (key, text_of))
        writer = csv.DictWriter(stream, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: "%.6g" % value if isinstance(value, float) else value
                             for key, value in row.items()})


def read_csv(path):
    with open(path, encoding="utf-8") as stream:
        lines = list(stream)
    header = [tuple(line[2:].strip().split(": ", 1)) for line in lines if line.startswith("# ")]
    return header, list(csv.DictReader(line for line in lines if not line.startswith("#")))


def lines_of(path):
    """Returns the lines that the README shows of a result."""
    if not path.endswith(".csv"):
        with open(path, encoding="utf-8") as stream:
            return stream.read().rstrip("\n").split("\n")
    header, rows = read_csv(path)
    return ["; ".join(": ".join(pair) for pair in header) + ".", "", *table(rows[0], [row.values() for row in rows])]


def keep(path, lines):
    """Writes lines as a result, and prints them."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines) + "\n")
    print("\n".join(lines))


def put(path, readme, name=None):
    """Puts a result into the README unchanged."""
    replace(readme, name or "lib/tables.py " + os.path.relpath(path, BENCH), lines_of(path))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: tables.py FILE.csv|FILE.md README.md")
    put(*sys.argv[1:])
