"""Checks that texts (*.md) name only things that exist: tests as ctest names them, and files and folders of the repository.

- Tests: unit.NAME and cross.NAME stand in test_NAME.c, others in NAME.py or NAME.sh below tests/LABEL, or
  tests/CMakeLists.txt names them in full. A name in capitals stands for any test. Conversely, tests/README.md names every
  test, but for its copy in double precision.
- Files: words in backquotes or in an indented block that begin with a folder of the repository or end like a source file (in
  samples and meshes: also like a scene or mesh). A path begins at the top, in the text's own folder, or in src, as includes
  do; a name without a slash may stand anywhere below the text's folder. A name with * is a pattern. Skipped are names with
  <>, {} or a word in capitals, and files that a build, a bench or a command of the text itself writes.
- No marks of an unfinished merge.

Runs in the source directory."""
import fnmatch
import os
import re
import sys

TESTS = {"unit": "c", "cross": "c", "stat": "py", "long": "py", "files": "py", "cli": "sh", "cluster": "sh py", "library": "c sh",
         "stability": "", "house": ""}  # the last two stand in tests/CMakeLists.txt
REGISTRY = "tests/CMakeLists.txt"
LIST = "tests/README.md"
SOURCES = (".c", ".h", ".cpp", ".cl", ".py", ".sh", ".cmake", ".cases", ".supp")
DATA = (".mci", ".obj", ".gsf", ".asc")  # endings that count in a folder with such files
TOP = ("README.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE", "CMakeLists.txt", "CMakePresets.json")
WRITTEN = ("build", "build-*", "bench/out")  # folders that a build or a bench writes
SKIPPED = tuple(f"bench/{room}/results" for room in ("accuracy", "choices", "parts", "peers", "speed", "stability"))  # texts that scripts wrote once, about the files of that time

REGISTERED = re.compile(r"NAME (\w+\.\w+)\s")
TEST = re.compile(r"(?<![\w/.-])(%s)\.(\w+)" % "|".join(TESTS))
QUOTED = re.compile(r"`([^`]+)`")
LINK = re.compile(r"""(?:\]\(|src=")([^)"#:\s]+)[)"]""")
REDIRECTED = re.compile(r">([\w.]+)")  # files that the commands of a text write
MERGE = re.compile(r"^(?:<<<<<<<|>>>>>>>) ", re.MULTILINE)
PLACEHOLDER = re.compile(r"^scene\.mci$|[<>{}]|(?:^|[/_.])(?!README|CONTRIBUTING|LICENSE|CITATION)[A-Z]{2,}(?:[._/]|$)")


def test_exists(label, name, files):
    registry = files[REGISTRY]
    if name.isupper() or re.search(r"NAME %s\.%s\s|\b%s/%s\.(?:py|sh)\b" % (label, name, label, name), registry):
        return True
    names = [f"test_{name}.c"] if TESTS[label] == "c" else [f"{name}.{end}" for end in TESTS[label].split()]
    return any(path.startswith(f"tests/{label}/") and os.path.basename(path) in names for path in files)


def tests_of(files):
    """Returns (tests in files of their own, tests that the registry names in full)."""
    found = set(REGISTERED.findall(files[REGISTRY]))
    for path in files:
        label, (name, end) = path.split("/")[1:2], os.path.splitext(os.path.basename(path))
        ends = TESTS.get(label[0], "").split() if path.startswith("tests/") else []
        if end[1:] in ends and (end != ".c" or name.startswith("test_")):
            found.add(label[0] + "." + name.removeprefix("test_"))
    return {name.removesuffix("_double") for name in found}


def unlisted(files):
    listed = {label + "." + name for label, name in TEST.findall(files[LIST])}
    return [f"{LIST}: does not name the test {name}" for name in sorted(tests_of(files) - listed)]


def words(text):
    """Returns possible paths: words in backquotes, targets of links, words of indented lines."""
    indented = [line for line in text.split("\n") if line.startswith("    ")]
    spans = QUOTED.findall("\n".join(line for line in text.split("\n") if not line.startswith("    "))) + indented
    found = [word for span in spans for word in span.split()] + LINK.findall(text)
    return [word.strip("`'\",;:()[]").removeprefix("./").rstrip("/") for word in found]


def folders_of(files):
    folders = set()
    for path in files:
        while os.path.dirname(path):
            path = os.path.dirname(path)
            folders.add(path)
    return folders


def is_path(word, home, places, endings):
    if word in ("beam.h", "detector.h"):  # heights of rectangles, by their names in --set
        return False
    if PLACEHOLDER.search(word) or not re.fullmatch(r"[\w./*+-]+", word) or word.startswith((".", "_")):
        return False
    if "/" not in word:
        return word in TOP or not word.startswith("*") and word.endswith(endings)
    first = word.split("/")[0]
    return word.endswith(SOURCES) or any(os.path.join(start, first) in places for start in ("", home, "src"))


def path_exists(word, home, places):
    if any(fnmatch.fnmatchcase(word + "/", pattern + "/*") for pattern in WRITTEN):
        return True
    starts = {os.path.normpath(os.path.join(start, word)) for start in ("", home, "src")}
    if "/" not in word:
        starts.add(os.path.join(home, "*", word))
    patterns = [start for start in starts if "*" in start]
    return bool(starts & places) or any(fnmatch.filter(places, pattern) for pattern in patterns)


def check_text(path, text, files, places):
    """Returns complaints about one text. places: files and folders that exist."""
    written = set(REDIRECTED.findall(text))
    home = os.path.dirname(path)
    beside = [file for file in files if os.path.dirname(file) == home]
    endings = SOURCES + tuple(end for end in DATA if any(file.endswith(end) for file in beside))
    missing = [f"{path}: names the test {label}.{name}, which is not there"
               for label, name in sorted(set(TEST.findall(text)))
               if "." + name not in SOURCES + (".md",) and not test_exists(label, name, files)]
    if MERGE.search(text):
        missing.append(f"{path}: holds marks of a merge")
    return missing + [f"{path}: names {word}, which is not there" for word in sorted(set(words(text)) - written)
                      if is_path(word, home, places, endings) and not path_exists(word, home, places)]


def check(files):
    """Returns the complaints. files: {path: text}; only texts and the registry of tests need their text."""
    places = set(files) | folders_of(files)
    return [complaint for path, text in sorted(files.items()) if path.endswith(".md") and not path.startswith(SKIPPED)
            for complaint in check_text(path, text, files, places)] + unlisted(files)


def check_the_check():
    """Checks on made-up texts that this check can fail. Each of these must give exactly one complaint."""
    sound = {"README.md": "`unit.a` cross.b `stat.coverage`, long.d stability.e `house.f` cli.NAME\n`src/room/a.c`\n"
                          "`src/room`\n    sh bench/g.sh --out bench/out >build/x/y.txt\n[h](bench/h.svg) `skin.obj` `1/cm`\n",
             "src/README.md": "`room/a.c` `a.c` `cluster.c` `room/<name>.c` `room/i_NAME.c` `src/room/*.c` `../none.c` `room/*.c`",
             REGISTRY: "add_test(NAME long.d\nadd_test(NAME stability.e\ncml_script_test(house x/house/f.py)",
             "bench/speed/results/old.md": "`src/gone.c`", "meshes/README.md": "`i.obj` `README.md` `scene.mci`\n```sh\nrun >j.obj\n```\n`j.obj`"}
    sound |= {path: "" for path in "tests/unit/room/test_a.c tests/cross/test_b.c tests/stat/coverage.py tests/long/same.sh "
              "tests/house/g.py src/room/a.c src/room/cluster.c bench/g.sh bench/h.svg meshes/i.obj".split()}
    sound[LIST] = "`unit.a` cross.b stat.coverage stability.e long.d"
    assert check(sound) == [], check(sound)
    for path in ("tests/unit/room/test_c.c", "tests/cli/c.sh", "tests/stat/c.py"):
        assert len(check({**sound, path: ""})) == 1, (path, check({**sound, path: ""}))
    assert check({**sound, "tests/unit/room/test_a_double.c": "", "tests/unit/room/a_cases.h": "", "tests/cli/c.cases": ""}) == []
    for text in ("`unit.b`", "cross.a", "stat.none", "`long.same`", "house.g", "stability.atlas", "cli.a", "unit.room",
                 "`src/room/b.c`", "`src/rooms/a.c`", "`src/none`", "`none/a.c`", "`b.c`", "    sh bench/none.sh",
                 "[x](bench/no.svg)", '<img src="bench/no.svg">', "`bench/*.py`", "`tests/unit/a.c --quick`", "a\n<<<<<<< HEAD\nb"):
        for path in ("README.md", "CONTRIBUTING.md", "bench/README.md"):
            assert len(check({**sound, path: text})) == 1, (path, text, check({**sound, path: text}))
    assert len(check({**sound, "meshes/README.md": "`i.obj` `none.obj` `CITATION.cff`"})) == 2


def read_all():
    files = {}
    for folder, folders, names in os.walk("."):
        folders[:] = [name for name in folders if name != ".git" and not name.startswith("build")]
        for name in names:
            path = os.path.relpath(os.path.join(folder, name))
            files[path] = ""
            if name.endswith(".md") or path == REGISTRY:
                with open(path, encoding="utf-8") as file:
                    files[path] = file.read()
    return files


def main():
    check_the_check()
    files = read_all()
    complaints = check(files)
    texts = [path for path in files if path.endswith(".md") and not path.startswith(SKIPPED)]
    named = {test for path in texts for test in TEST.findall(files[path])}
    print("\n".join(complaints) or f"{len(texts)} texts, {len(named)} tests named")
    sys.exit(1 if complaints else 0)


main()
