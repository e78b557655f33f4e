"""What only .h5 files hold, merged: every array of maps, volumes and facets is the mean of two runs by photons (errors: the root of the
sum of squares), with its units, long name and axes. A file with an array that cannot be read is refused, and nothing written."""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import fly_twice, h5py, numpy  # noqa: E402

SCENE = """1.0
1
maps.mco A
3000
0.05 0.05
6 7 2
beam disk 0.2 at=0.1,0
map 30 20 0.05 0.05 angles volume top=-0.1
facets
1
1
b 3 0.06 0.1 0.02 0.2 0 1
1.4 0.5 50 0.8 0.3
i sphere 0 0 0.15 0.05 1.4 5 20 0.5
1.5
"""
EQUAL = ("layer_", "body_n", "body_mu", "body_g", "body_of_facet")


def expected(name, one, two):
    if name.startswith(EQUAL) or name.endswith("area"):
        return one
    if name in ("lost", "residue"):
        return one + two
    return numpy.hypot(one / 3, two * 2 / 3) if name.endswith("_se") else one / 3 + two * 2 / 3


def check(verdict, a, b, merged):
    verdict.check("arrays", sorted(a) == sorted(merged), str(set(a) ^ set(merged)))
    for name in (name for name in merged if name != "call"):
        one, two, both = (file[name][()] for file in (a, b, merged))
        scale = a[name].attrs.get("CLASS") == b"DIMENSION_SCALE"
        wanted = one if scale else expected(name, one, two)
        verdict.check(name, both.dtype == one.dtype and numpy.allclose(both, wanted, rtol=1e-6, atol=1e-30), "mean of both")
        for text in ("units", "long_name"):
            verdict.check(name, a[name].attrs[text] == merged[name].attrs[text], text)
        verdict.check(name, scale or [list(axis) for axis in a[name].dims] == [list(axis) for axis in merged[name].dims], "axes")
        errors = "ancillary_variables"
        verdict.check(name, a[name].attrs.get(errors) == merged[name].attrs.get(errors), errors)
    for name in ("A_xyz", "Rd_xya", "boundary0_irradiance_above", "body_irradiance_outside", "A_body"):
        verdict.check(name, merged[name][()].sum() > 0, "light")


def damage(path, copy):
    with h5py.File(path) as file:
        where = file["A_xyz"].id.get_chunk_info(0)
    with open(path, "rb") as file:
        data = bytearray(file.read())
    data[where.byte_offset : where.byte_offset + where.size] = bytes(where.size)
    with open(copy, "wb") as file:
        file.write(data)


def main():
    verdict = cml.Verdict("merge")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        fly_twice(SCENE, (3000, 6000))
        subprocess.run([cml.PROGRAM, "merge", "1/maps.h5", "2/maps.h5", "-o", "both.h5", "--quiet"], check=True)
        with h5py.File("1/maps.h5") as one, h5py.File("2/maps.h5") as two, h5py.File("both.h5") as both:
            check(verdict, one, two, both)
        damage("2/maps.h5", "damaged.h5")
        run = subprocess.run([cml.PROGRAM, "merge", "1/maps.h5", "damaged.h5", "-o", "none.h5"], capture_output=True, text=True)
        message = "clustermcml: damaged.h5: A_xyz cannot be read (expected chunks of the size that it names)\n"
        verdict.check("damaged", (run.returncode, run.stderr) == (2, message), run.stderr)
        verdict.check("damaged", not os.path.exists("none.h5") and not [name for name in os.listdir(".") if "tmp" in name], "nothing written")
    verdict.finish()


main()
