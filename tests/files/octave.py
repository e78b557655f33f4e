"""Tests samples/readers/clustermcml_read.m under GNU Octave: arrays of an .mco and an .h5 equal those of the files, in the order that its text
promises. Bad files are refused in one line."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import h5py, numpy  # noqa: E402

READERS = os.path.join(os.path.dirname(cml.TESTS), "samples", "readers")
# Prints every numeric field: name, shape, and numbers with the last axis varying fastest, as Python lists them.
PRINT_ALL = """
addpath('%s');
data = clustermcml_read('%s');
names = fieldnames(data);
for i = 1:numel(names)
  values = data.(names{i});
  if ~isnumeric(values), continue, end
  printf('%%s %%s:', names{i}, mat2str(size(values)));
  printf(' %%.17g', permute(values, ndims(values):-1:1));
  printf("\\n");
end
fflush(stdout);
"""
REFUSE = "addpath('%s'); try, clustermcml_read('%s'); catch e, disp(e.message), end, fflush(stdout);"


def octave(program):
    """Returns the text that Octave prints. Octave of Debian 12 may fail after its last command, as it ends, which is ignored."""
    return subprocess.run(["octave-cli", "--eval", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                          check=False).stdout


def arrays(path):
    """Returns {name: (shape, numbers)} as Octave has read them."""
    found = {}
    for line in octave(PRINT_ALL % (READERS, path)).splitlines():
        head, numbers = line.split(":")
        name, shape = head.split(" ", 1)
        found[name] = [int(n) for n in shape.strip("[]").split()], numpy.array(numbers.split(), dtype=float)
    return found


def check_h5(verdict, path):
    read = arrays(path)
    with h5py.File(path) as file:
        names = [name for name in file if isinstance(file[name], h5py.Dataset)]
        verdict.check("all arrays", set(read) == set(names), f"{sorted(set(names) ^ set(read))}")
        for name in names:
            shape, values = read[name]
            expected = file[name][()]
            as_columns = list(expected.shape) if expected.ndim > 1 else [expected.size, 1]
            verdict.check(name, shape == as_columns, f"{shape}, not {as_columns}")
            verdict.check(name, numpy.array_equal(values, numpy.ravel(expected).astype(float)), "other numbers")


def sections_of(path):
    """Returns {key: all numbers of the section} of an .mco."""
    with open(path, encoding="utf-8") as file:
        parts = re.split(r"(?m)^([A-Za-z]\w*)(?: #.*)?$", file.read())
    return {key: [float(word) for word in re.sub("#.*", "", body).split()] for key, body in zip(parts[1::2], parts[2::2])}


def check_mco(verdict, path):
    read, sections = arrays(path), sections_of(path)
    for name in ("A_l", "A_z", "Rd_r", "Tt_a", "A_rz", "Rd_ra", "Tt_ra", "books"):
        verdict.check(name, numpy.array_equal(read[name][1], sections[name]), "of the .mco")
    verdict.check("se_Rd_r", numpy.array_equal(read["Rd_r_se"][1], sections["se_Rd_r"]), "of the .mco")
    verdict.check("totals", [read[name][1][0] for name in ("Rsp", "Rd", "A", "Tt")] == list(sections["RAT"]), "of the .mco")
    verdict.check("axes", [len(read[name][1]) for name in ("r", "z", "alpha", "layer")] == [100, 30, 1, 1], "of the .mco")
    verdict.check("A_rz", read["A_rz"][0] == [100, 30], "of the .mco")


def check_single_bins(verdict, folder):
    """Checks that axes with one bin stay axes."""
    path = os.path.join(folder, "single.mci")
    with open(path, "w", encoding="utf-8") as file:
        file.write("1.0\n1\nsingle.mco A\n100\n0.01 0.1\n4 1 2\nmap 3 1 0.1 0.1 angles volume\n1\n1\n1.4 1 100 0.9 0.1\n1\n")
    subprocess.run([cml.PROGRAM, path, "--quiet", "-o", folder], check=True)
    mco, h5 = (arrays(os.path.join(folder, "single" + ending)) for ending in (".mco", ".h5"))
    for name, shape in (("A_rz", [1, 4]), ("Rd_ra", [1, 2]), ("Rd_xy", [1, 3]), ("Rd_xy_se", [1, 3]), ("Rd_xya", [1, 3, 2]),
                        ("A_xyz", [4, 1, 3])):
        verdict.check("single bins", h5[name][0] == shape and mco.get(name, h5[name])[0] == shape, f"{name}: {h5[name][0]}, not {shape}")


def main():
    if not shutil.which("octave-cli"):
        print("octave-cli is missing")
        sys.exit(77)
    verdict = cml.Verdict("octave")
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(os.path.dirname(cml.TESTS), "samples", "skinmap.mci")
        subprocess.run([cml.PROGRAM, scene, "--photons", "2e4", "--quiet", "-o", folder], check=True)
        check_h5(verdict, os.path.join(folder, "skinmap.h5"))
        check_mco(verdict, os.path.join(folder, "skinmap.mco"))
        named = os.path.join(folder, "named.mco")
        with open(os.path.join(folder, "skinmap.mco"), encoding="utf-8") as file, open(named, "w", encoding="utf-8") as other:
            other.write(file.read().replace("\nskinmap.mco \tA", "\nx#y z.mco \tA"))
        check_mco(verdict, named)
        check_single_bins(verdict, folder)
        for path, text in ((os.path.join(folder, "none.mco"), "expected a file that is there"),
                           (scene, "expected a name that ends in .mco or .h5")):
            verdict.check("refusal", text in octave(REFUSE % (READERS, path)), path)
    verdict.finish()


main()
