"""Checks the layers of the source tree. A source file includes files of its own room and of rooms below, never above. Modules
include and call each other in no circle. Each foreign library is used by one file. No room has more than 24 files.

ROOMS below is the only list of rooms and of what each may use. A file in no room is an error: decide first where it belongs.
A module is a source file with its header. A header that is code says so in its name and in its first words. src/README.md has
the rooms in the same order in its table, and a paragraph on each. Runs in the source directory."""
import fnmatch
import os
import re
import sys

MOST_FILES = 24
MORE_FILES = {"kernels": "what a rule says stands in a file of its own, and devices and hosts have theirs"}  # {room: reason why it may have more files}

# Rooms from the lowest to the highest. A room may use itself and the rooms that it names. A folder is one room, except
# for its files that are rooms of their own here.
ROOMS = {
    "kernels": "",
    "src/base": "",
    "src/vector": "",
    "src/geometry": "src/base",
    "src/tally": "src/base kernels/balance.h kernels/boundary.h",
    "src/output/files": "src/base",
    "src/result": "src/output/files src/tally src/base kernels/balance.h kernels/boundary.h",
    "src/scene/heightmap": "src/geometry src/base",
    "src/scene": "src/scene/heightmap src/geometry src/base kernels/boundary.h",
    "src/scene/body": "src/scene src/scene/heightmap src/geometry src/base",
    "src/input/mesh": "src/scene/heightmap src/geometry src/base",
    "src/input/keys": "src/input/mesh src/scene src/scene/heightmap src/geometry src/base kernels/boundary.h",
    "src/input": "src/result src/input/keys src/input/mesh src/scene/body src/scene src/scene/heightmap src/geometry src/base kernels/boundary.h",
    "src/input/sweep": "src/base",
    "src/surface/tree": "src/vector src/geometry src/base",
    "src/surface/bounds": "src/surface/tree src/scene/body src/scene src/scene/heightmap src/geometry src/base kernels",
    "src/surface/mesh": "src/surface/bounds src/surface/tree src/geometry src/base kernels",
    "src/surface/body": "src/surface/mesh src/surface/bounds src/surface/tree src/scene/body src/scene src/geometry src/base kernels",
    "src/surface": "src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/scene/body src/scene src/scene/heightmap src/geometry src/base kernels",
    "src/engine": "src/result src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/scene/body src/scene src/tally src/geometry src/base kernels",
    "src/engine/cpu": "src/engine src/vector src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/scene src/tally src/geometry src/base kernels",
    "src/engine/opencl": "src/engine src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/scene src/tally src/geometry src/base kernels",
    "src/engine/engines": "src/engine src/engine/cpu src/engine/opencl",  # the one file that names all engines
    "src/exact": "src/vector src/scene src/base kernels/rough.h",
    "src/aim": "src/exact src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/tally src/scene/body src/scene src/geometry src/base kernels",
    "src/run/cluster": "src/tally src/base",
    "src/run": "src/run/cluster src/result src/output/files src/engine src/engine/engines src/surface src/scene src/tally src/geometry src/base kernels",
    "src/run/crosscheck": "src/run src/run/cluster src/result src/engine src/engine/engines src/surface src/scene src/tally src/geometry src/base kernels",
    "src/output": "src/input/keys src/result src/output/files src/exact src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/tally src/scene/body src/scene src/geometry src/base kernels",
    "src/output/study": "src/input/keys src/result src/output/files src/tally src/base",
    "src/options": "src/input/keys src/engine src/engine/engines src/surface src/base",
    "src/simulation": "src/options src/aim src/output src/result src/output/files src/exact src/run src/run/cluster src/engine src/engine/engines src/surface src/input src/scene/body src/scene src/tally src/geometry src/base kernels",
    "src/flights": "src/simulation src/options src/aim src/input/sweep src/output src/result src/output/files src/output/study src/exact src/run src/run/cluster src/engine src/surface src/input src/scene/body src/scene src/tally src/geometry src/base kernels",
    "src/api": "src/flights src/simulation src/options src/exact src/output src/result src/output/files src/run src/run/cluster src/engine src/surface src/scene src/tally src/base",
    "src/cli/options": "src/options src/input/keys src/engine src/engine/engines src/surface src/base",
    "src/cli": "src/api src/flights src/cli/options src/simulation src/options src/aim src/output src/result src/output/files src/output/study src/exact src/run/crosscheck src/run src/run/cluster src/engine src/engine/engines "
               "src/engine/cpu src/engine/opencl src/surface src/surface/body src/surface/mesh src/surface/bounds src/surface/tree src/scene/body src/input src/input/mesh src/scene src/tally src/geometry src/base kernels",
}

CODE = "/* Code, included "
MAP = "src/README.md"
ROW = re.compile(r"^\| `([a-z/]+)` \|", re.M)
PARAGRAPH = re.compile(r"^\*\*([a-z/, ]+)\.\*\*(?: |$)", re.M)

# Headers of libraries and of rarer parts of POSIX, and the only modules that may include them.
FOREIGN = {
    "embree*": "src/surface/mesh/mesh_surface",
    "tiny_obj_loader.h": "src/input/mesh/obj_tiny",
    "immintrin.h": "src/vector/group_masks",
    "jansson.h": "src/base/json_name src/output/report_json src/cli/command_plan src/cli/command_crosscheck src/cli/command_furnace",
    "omp.h": "src/run/cluster/launcher src/engine/cpu/engine_cpu_level src/engine/threads",
    "CL/*": "src/engine/opencl/opencl_parts",
    "hdf5*.h": "src/output/files/hdf5_file src/output/files/hdf5_head",
    "sys/resource.h": "src/cli/main",
    "sys/ioctl.h": "src/flights/progress",
    "signal.h": "src/run/stop",
    "mpi.h": "src/run/cluster/cluster_parts",
    "dlfcn.h": "src/run/cluster/cluster_load",
    "pthread.h": "src/engine/engine src/engine/threads src/output/files/hdf5_file src/run/cluster/cluster_parts src/run/run src/run/work_ranges src/surface/mesh/mesh_surface",
    "sched.h": "src/engine/threads src/run/cluster/cluster_service src/run/cluster/launcher",
    "zlib.h": "src/base/atomic_file src/output/files/hdf5_head src/run/checkpoint src/run/identity src/scene/checksum src/scene/phase",
    "sys/mman.h": "src/tally/tally",
    "sys/prctl.h": "src/run/stop",
    "dirent.h": "src/base/atomic_file",
    "locale.h": "src/api/api_parts",
}
COMMON = set("""assert.h complex.h ctype.h errno.h float.h inttypes.h limits.h math.h stdarg.h stdatomic.h stdbool.h stddef.h
    stdint.h stdio.h stdlib.h string.h strings.h time.h fcntl.h sys/stat.h sys/types.h unistd.h""".split())
KERNEL_COMMON = set("assert.h math.h stdbool.h stddef.h stdint.h string.h float.h limits.h".split())
CXX_COMMON = set("cmath cstddef cstdint cstdio cstdlib cstring exception fstream iostream istream limits map new "
                 "sstream streambuf string utility vector".split())
# Sources that define the same functions as others and are built in their place.
STAND_INS = "src/run/cluster/cluster_load src/engine/opencl/opencl_none".split()
DEFINITION = re.compile(r"^(?:CML_FN )?[a-z][^\n;{}()#]*?\b(cml_\w+)\([^;{}]*\)\n\{", re.M)
BODY = re.compile(r"\)\n\{\n.*?\n\}\n", re.S)
NAME = re.compile(r"\bcml_\w+\b")
TAG = re.compile(r"\b(?:struct|enum) cml_\w+")
COMMENT = re.compile(r"/\*.*?\*/", re.S)
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def module_of(path):
    return path.rsplit(".", 1)[0]


def room_of(path):
    """Returns the room of a file; None if it has none."""
    module = module_of(path)
    return module if module in ROOMS else (os.path.dirname(path) if os.path.dirname(path) in ROOMS else None)


def ours(header, files):
    """Returns the file that a quoted include names: by its path from src, or by its name for kernels."""
    for path in ("src/" + header, "kernels/" + header):
        if path in files:
            return path
    return None


def may_use(path, target):
    room, other = room_of(path), room_of(target)
    return room == other or other in ROOMS[room].split() or target in ROOMS[room].split()


def may_include(path, header):
    for pattern, owners in FOREIGN.items():
        if fnmatch.fnmatchcase(header, pattern):
            return module_of(path) in owners.split()
    if path.startswith("kernels/"):
        return header in KERNEL_COMMON
    return header in COMMON or (path.endswith(".cpp") and header in CXX_COMMON)


def includes(path, text, files):
    """Yields (file of ours or None, header as written, bracket) of every include. An include for the device and one for the
    host may name different files; both count."""
    for bracket, header in INCLUDE.findall(text):
        yield (ours(header, files) if bracket == '"' else None), header, bracket


def check_file(path, text, files):
    if room_of(path) is None:
        return [f"{path}: in no room (decide where it belongs: tests/house/floors.py lists them)"]
    complaints = []
    if path.endswith("_inl.h") != text.startswith(CODE):
        complaints.append(f"{path}: a header of code ends in _inl.h and begins with {CODE}, and no other does")
    for target, header, bracket in includes(path, text, files):
        if target is None and bracket == '"':
            complaints.append(f"{path}: includes \"{header}\", which is not here")
        elif target is None and not may_include(path, header):
            complaints.append(f"{path}: may not include <{header}>")
        elif target is not None and room_of(target) is not None and not may_use(path, target):
            complaints.append(f"{path}: {room_of(path)} may not use {target}")
    return complaints


def find_circle(graph):
    """Returns a list of names that include each other in a circle; empty if there is none. graph: {name: names it includes}."""
    done, path = set(), []

    def visit(module):
        if module in path:
            return path[path.index(module):] + [module]
        if module in done:
            return []
        path.append(module)
        for other in sorted(graph.get(module, ())):
            circle = visit(other)
            if circle:
                return circle
        done.add(path.pop())
        return []

    for module in sorted(graph):
        circle = visit(module)
        if circle:
            return circle
    return []


def graph_of(files):
    """Returns {module: modules it includes}. A header without a source file stands for the files that it includes."""
    direct = {}
    for path, text in files.items():
        targets = {module_of(target) for target, _, _ in includes(path, text, files) if target}
        direct.setdefault(module_of(path), set()).update(targets)
    bare = {module for module in direct if not any(module + end in files for end in (".c", ".cpp", ".cl"))}

    def expand(module, seen):
        for other in direct[module] - seen:
            seen.add(other)
            if other in bare:
                expand(other, seen)
        return seen

    return {module: expand(module, set()) - bare - {module} for module in direct if module not in bare}


def calls_of(files):
    """Returns {module: modules whose functions it names}, because a shared header of declarations hides such a circle from
    includes. In a header only the bodies of functions count; its declarations belong to another module."""
    texts, calls = {}, {}
    for path, text in files.items():
        module, text = module_of(path), TAG.sub("", COMMENT.sub("", text))
        if module not in STAND_INS:
            texts[module] = texts.get(module, "") + text
            calls[module] = calls.get(module, "") + ("".join(BODY.findall(text)) if path.endswith(".h") else text)
    home = {name: module for module, text in texts.items() for name in DEFINITION.findall(text)}
    return {module: {home[name] for name in NAME.findall(text) if name in home} - {module}
            for module, text in calls.items()}


def check_circles(files):
    headers = {path: text for path, text in files.items() if path.endswith(".h")}
    circle = find_circle({path: {target for target, _, _ in includes(path, text, files) if target}
                          for path, text in headers.items()}) or find_circle(graph_of(files)) or find_circle(calls_of(files))
    return ["a circle: " + " -> ".join(circle)] if circle else []


def check_sizes(files):
    counts = {}
    for path in files:
        counts[os.path.dirname(path)] = counts.get(os.path.dirname(path), 0) + 1
    return [f"{room}: {count} files, at most {MOST_FILES}" for room, count in sorted(counts.items())
            if count > MOST_FILES and room not in MORE_FILES]


def check(files):
    """Returns the complaints. files: {path: text}."""
    complaints = [complaint for path, text in sorted(files.items()) for complaint in check_file(path, text, files)]
    complaints += check_sizes(files)
    return complaints or check_circles(files)  # an include from above often closes a circle: one complaint is enough


def check_map(text, rooms):
    """Returns complaints about the map: the rooms are folders, those of src without src/."""
    rows = ROW.findall(text)
    told = {room for rooms_told in PARAGRAPH.findall(text) for room in rooms_told.split(", ")} | {"kernels"}
    complaints = [] if rows == rooms else [f"{MAP}: the rooms of its table are not those of tests/house/floors.py, in their order"]
    return complaints + [f"{MAP}: no paragraph on {room}" for room in rooms if room not in told]


def check_the_check():
    """Checks on made-up trees that this check can fail. Each of these must give exactly one complaint."""
    sound = {"src/run/run.c": '#include "run/run.h"\n#include <stdio.h>\n',
             "src/run/run.h": '#include "engine/engine.h"\n', "src/engine/engine.h": '#include "rng.h"\n',
             "src/surface/bounds.h": '#include "bounds.h"\n', "kernels/rng.h": "#include <stdint.h>\n",
             "kernels/bounds.h": "", "src/tally/tally.h": ""}
    assert check(sound) == [], check(sound)
    for path, text in [("src/tally/tally.h", '#include "run/run.h"\n'), ("kernels/rng.h", '#include "engine/engine.h"\n'),
                       # two headers of one name: the one of the higher room
                       ("src/tally/tally.h", '#include "surface/bounds.h"\n'),
                       ("src/run/run.c", "#include <embree3/rtcore.h>\n"), ("src/run/run.c", "#include <jansson.h>\n"),
                       ("src/novelty.c", ""), ("src/run/run.c", '#include "run/missing.h"\n'),
                       ("kernels/rng.h", "#include <stdlib.h>\n"), ("src/run/run.c", "#include <vector>\n"),
                       ("src/run/stop.h", '#include "run/stop.h"\n'), ("src/run/stop.h", CODE), ("src/run/stop_inl.h", ""),
                       ("src/run/stop.c", '#include "run/stop.h"\n#include "run/cores.h"\n')]:
        files = {**sound, path: text}
        if path == "src/run/stop.c":  # a circle by sources alone
            files["src/run/stop.h"], files["src/run/cores.h"] = "", ""
            files["src/run/cores.c"] = '#include "run/stop.h"\n'
        assert len(check(files)) == 1, (path, text, check(files))
    caller = "{}cml_status cml_run_{}(int a)\n{{\n    return cml_run_{}(a); /* cml_run_none */\n}}\n"
    calls = {"src/run/run.c": caller.format("", "one", "two"), "src/run/stop.c": caller.format("", "two", "three"),
             "src/run/none.c": caller.format("static ", "none", "one")}
    assert check({**sound, **calls}) == [], check({**sound, **calls})
    calls["src/run/cores.c"] = caller.format("", "three", "one")
    assert len(check({**sound, **calls})) == 1, check({**sound, **calls})
    inline = {"src/run/stop.h": "static inline int cml_run_stop(int a)\n{\n    return cml_run_one(a);\n}\n",
              "src/run/run.c": "int cml_run_one(int a)\n{\n    return a ? cml_run_stop(a) : 0;\n}\n"}
    assert len(check({**sound, **inline})) == 1, check({**sound, **inline})
    inline["src/run/stop.h"] = "int cml_run_one(int a);\nstruct cml_run_one\n{\n    int a;\n}\n"
    assert check({**sound, **inline}) == [], check({**sound, **inline})
    rooms, rows = ["kernels", "base", "plot", "cli"], "| `kernels` | a | - |\n| `base` | b | - |\n| `plot` | c | - |\n| `cli` | d | - |\n"
    assert check_map(rows + "**base.** It.\n**plot, cli.** They.\n", rooms) == []
    assert len(check_map(rows + "**base.** It.\n**plot.** It.\n", rooms)) == 1
    assert len(check_map(rows + "**base.** It.\n**plot, cli.** They.\n", rooms[1:])) == 1
    crowded = {f"src/base/file{i}.h": "" for i in range(MOST_FILES + 1)}
    assert len(check(crowded)) == 1, check(crowded)


def read_all():
    files = {}
    for top in ("src", "kernels"):
        for folder, _, names in os.walk(top):
            for name in names:
                if name.endswith((".c", ".h", ".cpp", ".cl")):
                    path = folder + "/" + name
                    with open(path, encoding="utf-8") as file:
                        files[path] = file.read()
    return files


def main():
    check_the_check()
    files = read_all()
    folders = [room.removeprefix("src/") for room in ROOMS if os.path.isdir(room)]
    with open(MAP, encoding="utf-8") as file:
        complaints = check(files) + check_map(file.read(), folders)
    print("\n".join(complaints) or f"{len(files)} files keep to their rooms")
    sys.exit(1 if complaints else 0)


main()
