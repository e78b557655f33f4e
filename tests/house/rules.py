"""Checks the pages of the physics rules P1, P2, ... in the manual: samples/manual/physics/p01.md has the title `# P1 Name`,
and so on. A rule that a comment cites has its page; a rule with a page is cited in kernels or src. (texts.py looks for the
tests and files that a page names.) Runs in the source directory."""
import ast
import os
import re
import sys

PAGES = "samples/manual/physics/"
CODE = ("src/", "kernels/")

TITLE = re.compile(r"# P(\d+) ")
RULE = re.compile(r"\bP(\d+)\b")
RANGE = re.compile(r"\bP\d+ ?(?:\.\.|to|-) ?P\d+\b")  # a span of the list, which cites no rule
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
    """Returns the complaints. files: {path: text}."""
    titles = {path: TITLE.match(text) for path, text in sorted(files.items()) if re.match(PAGES + r"p\d+\.md$", path)}
    defined = [int(title[1]) if title else 0 for title in titles.values()]
    complaints = []
    if defined != list(range(1, len(defined) + 1)):
        complaints.append(f"{PAGES}: titles of rules {defined}, expected 1, 2, 3, ...")
    cited = set()
    for path, text in sorted(files.items()):
        rules = rules_in(path, text)
        complaints += [f"{path}: cites P{rule}, which {PAGES} does not define"
                       for rule in sorted(rules - set(defined))]
        if path.startswith(CODE) and not path.endswith(".md"):
            cited |= rules
    complaints += [f"{PAGES}: nothing in kernels or src cites P{rule}" for rule in defined if rule not in cited]
    return complaints


def check_the_check():
    """Checks on made-up files that this check can fail."""
    first, second = PAGES + "p01.md", PAGES + "p02.md"
    sound = {first: "# P1 Launch\n", second: "# P2 Step\nP1 first\n", PAGES + "index.md": "P1 to P9", "kernels/walk.h": "/* P1: go. */\n",
             "src/x/run.c": "// P2, P1 to P9\nputs(\"P7\"); /* as in P2 */ char c = '\"'; /* P1 */\n",
             "tests/unit/room/test_a.c": "", "tests/stat/b.py": '"""P1."""\nx = "P8"  # P2\n',
             "bench/c.sh": "echo P9 # P1\n"}
    assert check(sound) == [], check(sound)
    assert rules_in("a.c", sound["src/x/run.c"]) == {1, 2}
    for path, text in [("kernels/walk.h", "/* P1: go. P3 */"), ("src/x/run.c", "// P1 to P2\n"),
                       ("bench/c.sh", "# P3\n"), ("tests/stat/b.py", "x = 1  # P3\n"), ("bench/d.py", '"""P3."""\n'),
                       (first, "# P1 Launch\nas in P3\n"), (PAGES + "p03.md", "# P3 None\n")]:
        assert len(check({**sound, path: text})) == 1, (path, text, check({**sound, path: text}))


def main():
    check_the_check()
    files = {}
    for directory in ("src", "kernels", "tests", "bench", "samples/manual"):
        for folder, _, names in os.walk(directory):
            for name in names:
                path = os.path.join(folder, name)
                if name.endswith((".c", ".h", ".cpp", ".cl", ".py", ".sh", ".md")):
                    if path != "tests/house/rules.py":  # its own cases cite rules that do not exist
                        with open(path, encoding="utf-8") as file:
                            files[path] = file.read()
    complaints = check(files)
    print("\n".join(complaints) or "rules and citations agree")
    sys.exit(1 if complaints else 0)


main()
