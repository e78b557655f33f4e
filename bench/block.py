"""The lines of a README that a script writes: those between `<!-- written by bench/NAME -->` and `<!-- until here -->`.

SPDX-License-Identifier: MIT
"""
import sys

END = "<!-- until here -->"


def replace(readme, script, fresh):
    """Puts the lines in place of those that the script wrote before; refuses a file that has no place for them."""
    begin = "<!-- written by bench/%s -->" % script
    with open(readme, encoding="utf-8") as stream:
        lines = stream.read().split("\n")
    if begin not in lines or END not in lines[lines.index(begin):]:
        sys.exit("%s: no lines %s and, below it, %s" % (readme, begin, END))
    first = lines.index(begin)
    last = lines.index(END, first)
    with open(readme, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines[:first + 1] + list(fresh) + lines[last:]))


def table(titles, rows):
    """The lines of a table."""
    yield "| " + " | ".join(titles) + " |"
    yield "|---" * len(titles) + "|"
    for row in rows:
        yield "| " + " | ".join(row) + " |"
