"""Checks sizes: files have at most 600 lines, functions at most 60, half of the functions in src at most 12.

A file whose subject would be torn may be longer: its first lines then say "Over 600 lines: " and why.
C functions are found by the house's format: a brace alone in column 0 opens one, the next one closes it. Runs in the source
directory."""
import ast
import os
import statistics
import sys

MOST_IN_FILE, MOST_IN_FUNCTION, MEDIAN = 600, 60, 12


def c_functions(lines):
    """Yields (line number, length) of every function, with its signature, without the comment before it."""
    start = None
    for i, line in enumerate(lines):
        if line == "{":
            start = i
            while start > 0 and lines[start - 1].strip() and not lines[start - 1].startswith((" *", "/*", "#", "}")) \
                    and not lines[start - 1].endswith((";", "*/")):
                start -= 1
        elif line == "}" and start is not None:
            yield start + 1, i - start + 1
            start = None


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno - node.lineno + 1


def functions_of(path, text):
    if path.endswith((".c", ".h", ".cpp", ".cl")):
        return list(c_functions(text.split("\n")))
    return list(python_functions(text)) if path.endswith(".py") else []


def is_too_long(text):
    return text.count("\n") > MOST_IN_FILE and f"Over {MOST_IN_FILE} lines: " not in text[:1000]


def check_the_check():
    body = "int f(int a,\n      int b)\n{\n" + "    a++;\n" * 57 + "    return b;\n}\n"
    assert list(c_functions(("/* why */\n" + body).split("\n"))) == [(2, 62)]
    assert is_too_long("\n" * 601) and not is_too_long("\n" * 600)
    assert not is_too_long("/* Over 600 lines: one table. */" + "\n" * 601)
    assert list(python_functions("\ndef f():\n    return 1\n")) == [(2, 2)]


def main():
    check_the_check()
    complaints, lengths = [], []
    for directory in ("src", "kernels", "tests", "samples", "meshes", "bench"):
        for folder, _, names in os.walk(directory):
            for name in names:
                path = os.path.join(folder, name)
                if not name.endswith((".c", ".h", ".cpp", ".cl", ".py", ".sh")):
                    continue
                with open(path, encoding="utf-8") as file:
                    text = file.read()
                functions = functions_of(path, text)
                lengths += [length for _, length in functions] if directory == "src" else []
                if is_too_long(text):
                    complaints.append(f"{path}: {text.count(chr(10))} lines, at most {MOST_IN_FILE}")
                complaints += [f"{path}:{line}: a function of {length} lines, at most {MOST_IN_FUNCTION}"
                               for line, length in functions if length > MOST_IN_FUNCTION]
    median = statistics.median(lengths)
    if median > MEDIAN:
        complaints.append(f"src: the median function has {median} lines, at most {MEDIAN}")
    print("\n".join(complaints) or f"{len(lengths)} functions in src, median {median} lines, longest {max(lengths)}")
    sys.exit(1 if complaints else 0)


main()
