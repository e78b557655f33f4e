"""Checks that comments begin with their subject: the first sentence is a full sentence or a noun phrase. It does not begin
with a preposition, a relative or a word that leans on the comment above. Docstrings count, and so do comments at the end
of a line of code. Runs in the source directory."""
import ast
import io
import os
import re
import sys
import tokenize

FOLDERS = ("src", "kernels", "tests", "samples", "meshes", "bench")
LEANING = ("Of", "That", "So", "As", "What", "Whether", "Where", "How", "Which", "Who", "Whose", "The same")  # rule 2 of plain words
BEGINS = re.compile(r"(?:%s)\b" % "|".join(LEANING))
C_TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)


def c_comments(text):
    for token in C_TOKEN.finditer(text):
        if token[0].startswith("/"):
            yield text.count("\n", 0, token.start()) + 1, re.sub(r"^(?:/\*+|//+)[<!]?\s*", "", token[0])


def hash_comments(lines):
    """Yields (line number, first line) of each block of lines that begin with #, in a shell script or a CMake file."""
    above = False
    for number, line in enumerate(lines, 1):
        found = re.match(r"\s*#(?!!)\s*(.*)", line)
        if found and not above:
            yield number, found[1]
        above = bool(found)


def python_comments(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node):
            yield node.body[0].lineno, ast.get_docstring(node)
    above = -1
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            number, alone = token.start[0], token.line.lstrip().startswith("#")
            if not (alone and above == number - 1):
                yield number, token.string.lstrip("# ")
            above = number if alone else -1


def comments_of(path, text):
    if path.endswith((".c", ".h", ".cpp", ".cl")):
        return c_comments(text)
    return python_comments(text) if path.endswith(".py") else hash_comments(text.split("\n"))


def complaints_of(path, text):
    return [f"{path}:{number}: a comment begins with {BEGINS.match(comment)[0]} (expected its subject): {comment.splitlines()[0][:60]}"
            for number, comment in comments_of(path, text) if BEGINS.match(comment)]


def check_the_check():
    """Checks on made-up files that this check can fail."""
    sound = {"a.c": '/* Packets fly.\n * Of these some stay. */\nputs("/* Of */"); /* Office */ // so\n', "a.sh": "# Runs.\n# That is all.\necho # Of\n",
             "a.py": '"""Reads."""\n# One.\n# So two.\nx = "# Of"  # as it is\n'}
    for path, text in sound.items():
        assert complaints_of(path, text) == [], complaints_of(path, text)
    for path, text in (("a.c", "int a; /* Of those. */"), ("a.h", "// The same.\n"), ("a.py", '"""So it is."""\n'), ("a.py", "x = 1  # What x is\n"),
                       ("a.py", 'def f():\n    """Whether."""\n'), ("a.sh", "ls\n# How.\n")):
        assert len(complaints_of(path, text)) == 1, (path, text)


def main():
    check_the_check()
    complaints, count = [], 0
    for top in FOLDERS:
        for folder, _, names in os.walk(top):
            for path in sorted(os.path.join(folder, name) for name in names if name.endswith((".c", ".h", ".cpp", ".cl", ".py", ".sh", ".cmake"))):
                with open(path, encoding="utf-8") as file:
                    complaints += complaints_of(path, file.read())
                count += 1
    print("\n".join(complaints) or f"{count} files")
    sys.exit(1 if complaints else 0)


main()
