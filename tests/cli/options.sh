#!/bin/sh
# Tests that every option appears in a text for users (README.md, the manual), and that every option named there exists. Where
# a text shows a whole command, the option must belong to that command. The program's help is the reference.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
cat >"$work/check.py" <<'END_OF_CHECK'
import glob, re, subprocess, sys

PROGRAM = sys.argv[1]
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
# Options of other programs that texts name alone: cmake, Open MPI, Slurm, scripts of bench.
FOREIGN = {"--prefix", "--bind-to", "--map-by", "--mca", "--mpi", "--quick"}


PACKAGE = ("brdf", "plot", "compare", "profile", "view")  # whose options are those of the Python package


def options_of(topic):
    words = [PROGRAM, topic, "--help"] if topic in PACKAGE else [PROGRAM, "help", topic]
    text = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    return {name for line in text.split("\n") if re.match(r"  (-\w( [A-Z]+)?, )?--", line) for name in OPTION.findall(line[:26])}


def spans(text):
    """What is typed: words in backquotes, indented and fenced lines."""
    fenced = False
    for line in text.split("\n"):
        if line.startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            yield line.strip()
        else:
            yield from re.findall(r"`([^`]+)`", line)


def check_span(span, commands, every):
    """Complaints about options that are not there, and the options named."""
    words = span.split()
    at = [i for i, word in enumerate(words) if re.fullmatch(r"(.*/)?clustermcml", word)]
    if not at and not span.startswith("--"):
        return [], set()
    named = set(OPTION.findall(" ".join(words[at[0]:] if at else words).split(" | ")[0])) - (FOREIGN if not at else set())
    command = words[at[0] + 1].strip("[]") if at and at[0] + 1 < len(words) else ""
    known = every if not at or command == "help" else commands.get(command, commands["run"] | {"--help", "--version"})
    return [f"`{span}`: no option {name}" for name in sorted(named - known)], named & every


def check(texts, commands, every):
    complaints, named = [], set()
    for path, text in texts.items():
        for span in spans(text):
            wrong, right = check_span(span, commands, every)
            complaints += [f"{path}: {line}" for line in wrong]
            named |= right
    return complaints + [f"no text names {name} (samples/manual/options.md lists options)" for name in sorted(every - named)]


def check_the_check():
    commands = {"run": {"--a", "--b"}, "plan": {"--b"}}
    sound = {"x.md": "`--a` and `--b 3`, `--prefix`, `cmake --build`\n\n    mpiexec --c clustermcml plan x --b | y --d\n    z --e\n"}
    assert check(sound, commands, {"--a", "--b"}) == [], check(sound, commands, {"--a", "--b"})
    for text in ("`--c`", "    clustermcml plan x --a", "    clustermcml x.mci --c", "```\nclustermcml plan --a\n```", "`clustermcml plan --a`"):
        assert len(check({**sound, "y.md": text}, commands, {"--a", "--b"})) == 1, text
    assert len(check({"x.md": "`--a`"}, commands, {"--a", "--b"})) == 1


check_the_check()
listed = subprocess.run([PROGRAM, "help"], capture_output=True, text=True, check=True).stdout
names = re.findall(r"^  \[?([a-z]+)\]? ", listed.split("\ncommands\n")[1].split("\n\n")[0], re.MULTILINE)
texts = {}
for path in ["README.md", *sorted(glob.glob("samples/manual/**/*.md", recursive=True))]:
    with open(path, encoding="utf-8") as file:
        texts[path] = file.read()
every = options_of("options").union(*map(options_of, PACKAGE))
complaints = check(texts, {name: options_of(name) for name in {*names, *PACKAGE}}, every)
print("\n".join(complaints) or f"{len(every)} options in {len(texts)} texts")
sys.exit(1 if complaints or len(every) < 35 or len(names) < 10 else 0)
END_OF_CHECK
python3 "$work/check.py" "$program" || complain "options and texts"
finish
