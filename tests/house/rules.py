"""kernels/README.md defines the physics rules P1, P2, ...: one heading `## P1 Name` each, in order. A rule that a
comment cites has its heading; a rule with a heading is cited in kernels or src. (That the tests and files exist which it
names, texts.py sees.) Runs in the source directory."""
import ast
import os
import re
import sys

README = "kernels/README.md"
CODE = ("src/", "kernels/")

HEADING = re.compile(r"^## P(\d+)\b", re.M)
RULE = re.compile(r"\bP(\d+)\b")
RANGE = re.compile(r"\bP\d+ ?(?:\.\.|to|-) ?P\d+\b")  # names a span of the list, cites no rule
C_TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
SHELL_COMMENT = re.compile(r"(?:^|\s)#(.*)")


def python_comments(text):
    found = [comment for line in text.split("\n") for comment in SHELL_COMMENT.findall(line)]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)):
            found.append(ast.get_docstring(node) or "")
    return "\n".join(found)


def comments(path, text):
    if path.endswith((".c", ".h", ".cpp", ".cl")):
        return "\n".join(token for token in C_TOKEN.findall(text) if token[0] == "/")
    if path.endswith(".py"):
        return python_comments(text)
    if path.endswith(".sh"):
        return "\n".join(SHELL_COMMENT.findall(text))
    return text if path.endswith(".md") else ""


def rules_in(path, text):
    return {int(number) for number in RULE.findall(RANGE.sub("", comments(path, text)))}


def check(files):
    """files: {path: text}. Returns the complaints."""
    readme = files[README]
    defined = [int(number) for number in HEADING.findall(readme)]
    complaints = []
    if defined != list(range(1, len(defined) + 1)):
        complaints.append(f"{README}: headings of rules {defined}, expected 1, 2, 3, ...")
    cited = set()
    for path, text in sorted(files.items()):
        rules = rules_in(path, text)
        complaints += [f"{path}: cites P{rule}, which {README} does not define"
                       for rule in sorted(rules - set(defined))]
        if path.startswith(CODE) and not path.endswith(".md"):
            cited |= rules
    complaints += [f"{README}: nothing in kernels or src cites P{rule}" for rule in defined if rule not in cited]
    return complaints


def check_the_check():
    """A check that cannot fail is none."""
    sound = {README: "## P1 Launch\n## P2 Step\nP1 first\n", "kernels/walk.h": "/* P1: go. */\n",
             "src/x/run.c": "// P2, P1 to P9\nputs(\"P7\"); /* as in P2 */ char c = '\"'; /* P1 */\n",
             "tests/unit/room/test_a.c": "", "tests/stat/b.py": '"""P1."""\nx = "P8"  # P2\n',
             "bench/c.sh": "echo P9 # P1\n"}
    assert check(sound) == [], check(sound)
    assert rules_in("a.c", sound["src/x/run.c"]) == {1, 2}
    for path, text in [("kernels/walk.h", "/* P1: go. P3 */"), ("src/x/run.c", "// P1 to P2\n"),
                       ("bench/c.sh", "# P3\n"), ("tests/stat/b.py", "x = 1  # P3\n"), ("bench/d.py", '"""P3."""\n'),
                       (README, "## P1 Launch\n## P2 Step\nas in P3\n"), (README, "## P2 Step\n## P1 Launch\n"),
                       (README, "## P1 Launch\n## P2 Step\n## P3 None\n")]:
        assert len(check({**sound, path: text})) == 1, (path, text, check({**sound, path: text}))


def main():
    check_the_check()
    files = {}
    for directory in ("src", "kernels", "tests", "bench"):
        for folder, _, names in os.walk(directory):
            for name in names:
                path = os.path.join(folder, name)
                if name.endswith((".c", ".h", ".cpp", ".cl", ".py", ".sh", ".md")):
                    if path != "tests/house/rules.py":  # its own cases cite rules that do not exist
                        with open(path, encoding="utf-8") as file:
                            files[path] = file.read()
    complaints = check(files)
    print("\n".join(complaints) or f"{len(HEADING.findall(files[README]))} rules")
    sys.exit(1 if complaints else 0)


main()
