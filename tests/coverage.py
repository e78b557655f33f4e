"""Prints which code the tests execute: a table of lines and branches by room (kernels and the folders of src).

coverage.py LCOV GAPS: LCOV is the output of `llvm-cov export -format=lcov`; GAPS becomes a text with every line that no test
executed. Runs in the source directory. Exit code 1 if a room is below 95 % of its lines.

A line of a header counts as executed if it was in any file that includes it. A branch is one of the two ways that a condition
can go. For a function in a header, llvm-cov counts the copy with the most executed branches."""
import collections
import os
import sys

LEAST = 95.0


class Source:
    def __init__(self):
        self.lines = collections.Counter()  # line number: how often it was executed
        self.branches = 0
        self.gone = 0

    def missed(self):
        return sorted(number for number, times in self.lines.items() if times == 0)


def read(path):
    """Returns {path from the top: Source} of src and kernels."""
    sources, source = {}, None
    with open(path, encoding="utf-8") as file:
        for record in file:
            key, _, value = record.rstrip("\n").partition(":")
            if key == "SF":
                source = sources.setdefault(os.path.relpath(value), Source())
            elif key == "DA":
                number, times = value.split(",")[:2]
                source.lines[int(number)] += int(times)
            elif key == "BRF":
                source.branches += int(value)
            elif key == "BRH":
                source.gone += int(value)
    return {name: source for name, source in sources.items() if name.startswith(("src/", "kernels/")) and source.lines}


def share(part, whole):
    return 100 * part / whole if whole else 100.0


def row(name, sources):
    lines = sum(len(source.lines) for source in sources)
    missed = sum(len(source.missed()) for source in sources)
    branches, gone = sum(source.branches for source in sources), sum(source.gone for source in sources)
    print(f"| {name} | {lines} | {share(lines - missed, lines):.1f} % | {branches} | {share(gone, branches):.1f} % |")
    return share(lines - missed, lines)


def write_gaps(path, sources):
    with open(path, "w", encoding="utf-8") as out:
        for name, source in sorted(sources.items()):
            with open(name, encoding="utf-8") as file:
                text = file.read().split("\n")
            for number in source.missed():
                out.write(f"{name}:{number}: {text[number - 1].strip()}\n")


def main():
    sources = read(sys.argv[1])
    write_gaps(sys.argv[2], sources)
    rooms = collections.defaultdict(list)
    for name, source in sources.items():
        rooms[os.path.dirname(name)].append(source)
    print("| room | lines | executed | branches | gone |\n|---|---|---|---|---|")
    shares = [row(f"`{room}`", rooms[room]) for room in sorted(rooms)]
    row("all", sources.values())
    sys.exit(0 if shares and min(shares) >= LEAST else 1)


main()
