"""Files of earlier versions, in tests/files/compat/VERSION, are read today: scenes fly, results give the numbers that stand in them, and
agree with today's flights of their scenes. Checkpoints and parts of a run are refused in one line, and stay as they are."""
import lzma
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import warm_python  # noqa: E402
from python_package import h5py, mc, np  # noqa: E402

FOLDER = os.path.join(cml.TESTS, "files", "compat")
NO_DATA = {"call", "input"}  # groups and texts of an .h5 that are no arrays of a result


def unpack(version, folder):
    for name in os.listdir(os.path.join(FOLDER, version)):
        path = os.path.join(FOLDER, version, name)
        if name.endswith(".xz"):
            with lzma.open(path) as packed, open(os.path.join(folder, name[:-3]), "wb") as file:
                file.write(packed.read())
        else:
            shutil.copy(path, folder)


def command(*words):
    """(exit code, lines of standard error) of the program."""
    done = subprocess.run([cml.PROGRAM, *words], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.splitlines()


def content(path):
    with open(path, "rb") as file:
        return file.read()


def check_flights(verdict, version):
    """Today's program flies the scenes. Their results agree with those of the version."""
    for scene in ("layers", "shapes"):
        code, said = command("run", f"{scene}.mci", "--quiet", "-o", "today")
        verdict.check(version, code == 0, f"{scene}.mci: exit code {code}: {said}")
        for name in (f"{scene}.mco", f"{scene}.h5"):
            if code == 0 and os.path.exists(name):
                code, said = command("compare", name, os.path.join("today", name))
                verdict.check(version, code == 0, f"compare {name} and today's: exit code {code}: {said}")


def rounded(value, word):
    """Returns a value rounded to the digits that a word in a text has."""
    digits = re.sub(r"[eE].*", "", word).replace(".", "").lstrip("-+0")
    return float(f"{value:.{max(len(digits), 1) - 1}e}")


def check_text(verdict, version, path):
    """All sections of an .mco that an .mco holds today, to the digits of the text; a warning names the others. What the .h5 beside it has comes with
    more digits."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = mc.read(path)
    with open(path, encoding="utf-8") as file:
        text = file.read()
    said = " ".join(str(warning.message) for warning in caught)
    for key, block in re.findall(r"^(?!InParm)([A-Za-z]\w*)(?: .*)?\n((?:[ \t]*[-+\d.]+.*\n)+)", text, re.MULTILINE):
        words = re.sub(r"#.*", "", block).split()
        numbers = np.array(words, dtype=float)
        name = key[3:] + "_se" if key.startswith("se_") else key
        if key == "RAT":
            verdict.check(version, [float(result[total]) for total in ("Rsp", "Rd", "A", "Tt")] == list(numbers), f"{path}: {key}")
        elif name in result:
            verdict.check(version, [rounded(value, word) for value, word in zip(np.ravel(result[name]), words)] == list(numbers), f"{path}: {key}")
        elif key not in ("se_RAT", "books", "lattice", "time") and not key.startswith(("heightfield", "se_")):
            verdict.check(version, re.search(rf"\b{key}\b.* were not read", said), f"{path}: {key} is neither read nor named in {said!r}")


def check_arrays(verdict, version, path):
    """All arrays of an .h5, number by number."""
    result = mc.read(path)
    with h5py.File(path) as file:
        arrays = {name: array[()] for name, array in file.items() if isinstance(array, h5py.Dataset) and name not in NO_DATA}
    verdict.check(version, len(arrays) > 50, f"{path}: {len(arrays)} arrays")
    for name, values in arrays.items():
        same = name in result.variables and np.array_equal(result[name].values, values, equal_nan=values.dtype.kind == "f")
        verdict.check(version, same, f"{path}: {name}")


def check_checkpoint(verdict, version):
    """The program of the very commit that wrote the checkpoint continues from it. All others refuse it, and leave it as it is."""
    os.mkdir("resumed")
    kept = shutil.move("layers.mco.checkpoint", "resumed")
    before = content(kept)
    code, said = command("run", "layers.mci", "--photons", "3e6", "--resume", "--quiet", "-o", "resumed")
    said = [line for line in said if "note: replaces" not in line]
    if code == 0 and version != "0.1.0":
        verdict.check(version, mc.read("resumed/layers.mco").photons == 3e6, "checkpoint: not all photons were flown")
        return
    verdict.check(version, code == 2 and len(said) == 1 and "layers.mco.checkpoint" in said[0], f"checkpoint: exit code {code}: {said}")
    verdict.check(version, content(kept) == before, "the checkpoint was changed")


def check_parts(verdict, version):
    """The program of the very commit that wrote the parts joins them. All others refuse them in one line."""
    code, said = command("merge", "layers.mci", "layers.mco.part1of2", "layers.mco.part2of2", "--quiet", "-o", "joined")
    if code == 0:
        verdict.check(version, mc.read("joined/layers.mco").identical(mc.read("layers.mco")), "merge: not the sum of the parts")
    else:
        verdict.check(version, code == 2 and len(said) == 1 and "layers.mco.part" in said[0], f"merge: exit code {code}: {said}")


def main():
    verdict = cml.Verdict("compat")
    warm_python.start()
    for version in sorted(name for name in os.listdir(FOLDER) if os.path.isdir(os.path.join(FOLDER, name))):
        with tempfile.TemporaryDirectory() as folder:
            unpack(version, folder)
            os.chdir(folder)
            for name in sorted(os.listdir(".")):
                if name.endswith(".mco"):
                    check_text(verdict, version, name)
                elif name == "shapes.h5":
                    check_arrays(verdict, version, name)
                elif name.endswith(".photons.h5"):
                    verdict.check(version, len(mc.read_photons(name)) == 50, f"{name}: not its 50 packets")
            if os.path.exists("layers.mco.part1of2"):
                check_parts(verdict, version)
            check_checkpoint(verdict, version)
            check_flights(verdict, version)
            os.chdir(cml.TESTS)
    verdict.finish()


main()
