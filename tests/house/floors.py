"""A source file includes its own floor and those below, never above; foreign libraries stay behind one file each.

The table below is the only list of floors. A file that stands in none of its rows is an error: decide first where
it belongs. Runs in the source directory."""
import fnmatch
import os
import re
import sys

FLOORS = [
    (6, "main options command command_*"),
    (5, "run report report_* plot plot_* crosscheck cluster cluster_alone dispatch checkpoint identity gnuplot compare compare_*"),
    (4, "engine engines engine_cpu engine_cpu_level engine_reference engine_scalar engine_opencl horizon opencl opencl_* packet_ends bundle bundle_*"),
    (3, "surface surface_* mesh_query mesh_line lattice grid_walk clearance fields vtk vti mci mci_* obj obj_* mco mco_* gsf esri curve"),
    (2, "scene mesh mesh_body mesh_border mesh_clean mesh_facet mesh_measure mesh_parts mesh_topology radial polygon footprint boxtree predicate triangle overlap overlap_* tessellate tally ranges heightmap heightmap_*"),
    (1, "status atomic_file clock constants version text vec3 field inputs stop launcher cores significance"),
]
KERNEL_FLOOR = 0  # everything in kernels/

# Headers of libraries and of rarer parts of POSIX, and the only files that may include them.
FOREIGN = {
    "embree*": "surface_mesh",
    "tiny_obj_loader.h": "obj_tiny",
    "immintrin.h": "bundle_masks",
    "jansson.h": "report compare_report",
    "omp.h": "cores engine_cpu_level",
    "CL/*": "opencl_parts",
    "getopt.h": "options",
    "hdf5*.h": "fields",
    "sys/resource.h": "command_load",
    "spawn.h": "gnuplot",
    "signal.h": "gnuplot stop",
    "mpi.h": "cluster",
    "pthread.h": "cluster dispatch",
    "sched.h": "cluster cores",
    "zlib.h": "checkpoint identity",
    "sys/wait.h": "gnuplot",
}
COMMON = set("""assert.h ctype.h errno.h float.h inttypes.h limits.h math.h stdarg.h stdatomic.h stdbool.h stddef.h
    stdint.h stdio.h stdlib.h string.h strings.h time.h fcntl.h sys/stat.h sys/types.h unistd.h""".split())
KERNEL_COMMON = set("math.h stdbool.h stddef.h stdint.h string.h float.h limits.h".split())
CXX_COMMON = set("cmath cstddef cstdint cstdio cstdlib cstring exception fstream iostream istream limits map new "
                 "sstream streambuf string utility vector".split())
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def floor_of(path):
    directory, name = os.path.split(path)
    if directory == "kernels":
        return KERNEL_FLOOR
    stem = os.path.splitext(name)[0]
    for floor, patterns in FLOORS:
        if any(fnmatch.fnmatchcase(stem, pattern) for pattern in patterns.split()):
            return floor
    return None


def may_include(path, header):
    stem, extension = os.path.splitext(os.path.basename(path))
    for pattern, owners in FOREIGN.items():
        if fnmatch.fnmatchcase(header, pattern):
            return stem in owners.split()
    if path.startswith("kernels/"):
        return header in KERNEL_COMMON
    return header in COMMON or (extension == ".cpp" and header in CXX_COMMON)


def check(files):
    """files: {path: text}. Returns the complaints."""
    complaints = []
    ours = {os.path.basename(path): path for path in files}
    for path, text in sorted(files.items()):
        floor = floor_of(path)
        if floor is None:
            complaints.append(f"{path}: on no floor (add it to the table in tests/house/floors.py)")
            continue
        for bracket, header in INCLUDE.findall(text):
            if header in ours:
                above = floor_of(ours[header])
                if above is not None and above > floor:
                    complaints.append(f"{path}: floor {floor} includes {header} of floor {above}")
            elif bracket == '"':
                complaints.append(f"{path}: includes \"{header}\", which is not here")
            elif not may_include(path, header):
                complaints.append(f"{path}: may not include <{header}>")
    return complaints


def check_the_check():
    """A check that cannot fail is none."""
    sound = {"src/run.c": '#include "run.h"\n#include <stdio.h>\n', "src/run.h": '#include "engine.h"\n',
             "src/engine.h": '#include "rng.h"\n', "kernels/rng.h": "#include <stdint.h>\n"}
    assert check(sound) == [], check(sound)
    for path, text in [("src/tally.h", '#include "run.h"\n'), ("kernels/rng.h", '#include "engine.h"\n'),
                       ("src/run.c", "#include <embree3/rtcore.h>\n"), ("src/run.c", "#include <jansson.h>\n"),
                       ("src/novelty.c", ""), ("src/run.c", '#include "missing.h"\n'),
                       ("kernels/rng.h", "#include <stdlib.h>\n"), ("src/run.c", "#include <vector>\n")]:
        assert len(check({**sound, path: text})) == 1, (path, text)


def main():
    check_the_check()
    files = {}
    for directory in ("src", "kernels"):
        for name in os.listdir(directory):
            if name.endswith((".c", ".h", ".cpp", ".cl")):
                path = directory + "/" + name
                with open(path, encoding="utf-8") as file:
                    files[path] = file.read()
    complaints = check(files)
    print("\n".join(complaints) or f"{len(files)} files keep to their floors")
    sys.exit(1 if complaints else 0)


main()
