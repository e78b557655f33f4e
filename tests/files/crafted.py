"""Tests `plot` and `compare` on crafted .h5 files. Each file is refused in one line, which is written out here, with exit code 2, within 2 GB and
20 seconds, and no file is written.

The files have attributes that are arrays, names too long, sizes that wrap or that the file cannot hold, links, values in other files, other
filters, chunks that are not what they claim, numbers that no run writes, and a FIFO."""
import os
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import warm_python  # noqa: E402
from fields import fly_twice, h5py, numpy  # noqa: E402

SCENE = """1.0
1
maps.mco A
2000
0.05 0.05
6 7 2
map 30 20 0.05 0.05 volume
1
1
1.4 0.5 50 0.8 0.3
1.5
"""
LONG = "A" * 63
COMMANDS = {
    "compare": ["compare", "good.h5", "bad.h5"],
    "plot": ["plot", "bad.h5", "--of", "Rd_xy", "-o", "out.svg"],
    "curve": ["plot", "bad.h5", "-o", "out.svg"],
}
CASES = []


def case(commands, message):
    """Adds a case. The decorated function changes the file bad.h5, and may return bytes to replace in it. message: the text after the file's name."""
    def add(change):
        CASES.append((change.__name__, change, commands.split(), message))
        return change
    return add


def attribute(where, name, value, dtype=None):
    if name in where.attrs:
        del where.attrs[name]
    where.attrs.create(name, value, dtype=dtype)


def replace(file, name, shape, dtype="<f8", **options):
    if name in file:
        del file[name]
    return file.create_dataset(name, shape, dtype, **options)


NUMBER = "is of another type or shape (expected one number of 64 bits)"
TEXT = "is of another type or shape (expected one text of fixed length)"


@case("compare curve", f"photons {NUMBER}")
def numbers_in_a_row(file):
    attribute(file, "photons", numpy.full(5000, 1e300))


@case("compare", f"seed {NUMBER}")
def integers(file):
    attribute(file, "seed", 5)


@case("compare curve", f"title {TEXT}")
def texts_in_a_row(file):
    attribute(file, "title", numpy.full(3000, b"A" * 100, "S100"))


@case("compare curve", f"title {TEXT}")
def a_text_of_variable_length(file):
    attribute(file, "title", "x" * 200, h5py.string_dtype())


@case("compare curve", f"sampling {TEXT}")
def texts_of_variable_length(file):
    attribute(file, "sampling", ["x" * 200] * 500, h5py.string_dtype())


@case("plot", f"units {TEXT}")
def units_in_a_row(file):
    attribute(file["Rd_xy"], "units", numpy.full(3000, b"A" * 100, "S100"))


@case("compare curve", "Rd has more numbers than its file can hold (expected those of a run)")
def a_product_that_wraps(file):
    replace(file, "Rd", (2**10, 2**51 + 1), chunks=(1, 2**28))


@case("compare curve", "Rd_ra has more numbers than its file can hold (expected those of a run)")
def a_promise(file):
    replace(file, "Rd_ra", (40000, 25000), chunks=(40000, 1))


@case("compare curve", "nz nr na = 6 120000 20000 (expected no more than the ")
def axes_of_a_grid_that_is_not_there(file):
    for name, n in (("r", 120000), ("alpha", 20000)):
        replace(file, name, (n,), data=numpy.full(n, 0.01), chunks=(n,), compression=9)
    for name in ("Rd_ra", "Tt_ra"):
        del file[name]


@case("compare curve", "Rd_r has 5 numbers (expected 7)")
def fewer_numbers(file):
    replace(file, "Rd_r", (5,), chunks=(5,), data=numpy.ones(5))


LINK = "is a link to another place (expected a data set of this file)"


@case("plot", f"Rd_xy {LINK}")
def an_external_link(file):
    del file["Rd_xy"]
    file["Rd_xy"] = h5py.ExternalLink("good.h5", "/Rd_xy")


@case("plot", f"Rd_xy {LINK}")
def a_soft_link_that_leaves(file):
    del file["Rd_xy"]
    file["call/other"] = h5py.ExternalLink("good.h5", "/")
    file["Rd_xy"] = h5py.SoftLink("/call/other/Rd_xy")


ELSEWHERE = "has its values in other files (expected values of its own)"


@case("plot", f"Rd_xy {ELSEWHERE}")
def external_storage(file):
    replace(file, "Rd_xy", (20, 30), "<f4", external=[("good.h5", 0, 2400)])


@case("plot", f"Rd_xy {ELSEWHERE}")
def a_virtual_data_set(file):
    del file["Rd_xy"]
    layout = h5py.VirtualLayout((20, 30), "<f4")
    layout[:] = h5py.VirtualSource("good.h5", "Rd_xy", (20, 30))
    file.create_virtual_dataset("Rd_xy", layout)


FILTERS = "is packed by other filters (expected shuffle and deflate)"


@case("plot", f"Rd_xy {FILTERS}")
def a_checksum(file):
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(20, 30), fletcher32=True, data=numpy.ones((20, 30)))


@case("plot", f"Rd_xy {FILTERS}")
def lzf(file):
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(20, 30), compression="lzf", data=numpy.ones((20, 30)))


@case("plot", f"Rd_xy {FILTERS}")
def deflated_twice(file):
    del file["Rd_xy"]
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((20, 30))
    properties.set_deflate(9)
    properties.set_deflate(9)
    h5py.h5d.create(file.id, b"Rd_xy", h5py.h5t.IEEE_F32LE, h5py.h5s.create_simple((20, 30)), properties)
    file["Rd_xy"][()] = 1


@case("plot", "Rd_xy has an axis that is empty or can grow (expected axes of one size)")
def an_axis_that_can_grow(file):
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(20, 30), maxshape=(None, 30))


@case("plot", "Rd_xy is stored in another way (expected chunks, or one piece)")
def compact(file):
    del file["Rd_xy"]
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.COMPACT)
    h5py.h5d.create(file.id, b"Rd_xy", h5py.h5t.IEEE_F32LE, h5py.h5s.create_simple((20, 30)), properties)
    file["Rd_xy"][()] = 1


@case("compare curve", "Rd has values that are not there (expected all of them)")
def a_number_that_is_not_there(file):
    replace(file, "Rd", (), fillvalue=0.5)


@case("plot", "Rd_xy is of another type (expected floating-point numbers)")
def other_numbers(file):
    replace(file, "Rd_xy", (20, 30), "<i4", chunks=(20, 30), data=numpy.ones((20, 30)))


CHUNK = "cannot be read (expected chunks of the size that it names)"


def put_chunk(file, data, mask=0):
    file["Rd_xy"].id.write_direct_chunk((0, 0), data, filter_mask=mask)


@case("plot", f"Rd_xy {CHUNK}")
def a_chunk_that_is_too_short(file):
    put_chunk(file, zlib.compress(bytes(16)))


@case("plot", f"Rd_xy {CHUNK}")
def a_chunk_that_is_too_long(file):
    put_chunk(file, zlib.compress(bytes(100000000)))


@case("plot", f"Rd_xy {CHUNK}")
def a_chunk_longer_than_its_array(file):
    values = file["Rd_xy"][()]
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(20, 30), data=values)
    file["Rd_xy"].dims[0].attach_scale(file["y"])
    file["Rd_xy"].dims[1].attach_scale(file["x"])
    return [struct.pack("<IIQQQ", size, 0, 0, 0, 0) for size in (2400, 60000)]  # the chunk's key in its B-tree, and a key that says 60000 bytes in its place


@case("plot", f"Rd_xy {CHUNK}")
def a_chunk_without_its_filters(file):
    put_chunk(file, bytes(16), 3)


@case("plot", "Rd_xy has values that are not there (expected all of them)")
def chunks_that_are_missing(file):
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(20, 30), compression=1)


@case("plot", "Rd_xy has a chunk that is not there (expected all of them)")
def a_chunk_that_is_missing(file):
    del file["Rd_xy_se"]
    replace(file, "Rd_xy", (20, 30), "<f4", chunks=(10, 30))[:10] = 1
    file["Rd_xy"].dims[0].attach_scale(file["y"])
    file["Rd_xy"].dims[1].attach_scale(file["x"])
    for name in ("units", "long_name"):
        attribute(file["Rd_xy"], name, numpy.bytes_("1"))


@case("compare curve", "photons = 0.5 (expected a whole number of 1 or more)")
def half_a_packet(file):
    attribute(file, "photons", 0.5)


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def check(verdict, name, command, message):
    """Runs a command on bad.h5 and checks its message. `message` may be only the beginning of the text."""
    try:
        run = subprocess.run([cml.PROGRAM, *COMMANDS[command]], capture_output=True, text=True, timeout=20, preexec_fn=limit)
        said, code = run.stderr, run.returncode
    except subprocess.TimeoutExpired:
        said, code = "nothing for 20 seconds", None
    if command in ("compare", "plot", "curve"):  # the Python package may not need the damaged part, and has words of its own
        good = code in (0, 1) or code == 2 and said.startswith("clustermcml: bad.h5: ") and said.count("\n") == 1
        message = "one line"
    else:
        good = code == 2 and said.startswith(f"clustermcml: bad.h5: {message}") and said.count("\n") == 1
    verdict.check(f"{name} {command}", good, f"exit code {code}, {said[:200]!r}, expected 2, {message!r}")
    written = [path for path in os.listdir(".") if path.startswith("out")]
    verdict.check(f"{name} {command}", code == 0 or not written, f"wrote {written}")
    for path in written:
        os.remove(path)


def main():
    verdict = cml.Verdict("crafted")
    warm_python.start()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        fly_twice(SCENE, (2000, 2000))
        shutil.copy("1/maps.h5", "good.h5")
        for name, change, commands, message in CASES:
            shutil.copy("2/maps.h5", "bad.h5")
            with h5py.File("bad.h5", "r+") as file:
                patch = change(file)
            if patch:
                with open("bad.h5", "r+b") as file:
                    data = file.read()
                    assert patch[0] in data
                    file.seek(0)
                    file.write(data.replace(*patch))
            for command in commands:
                check(verdict, name, command, message)
        os.remove("bad.h5")
        os.mkfifo("bad.h5")
        for command in ("compare", "plot", "curve"):
            check(verdict, "a FIFO", command, "is no regular file (expected an .h5 file)")
    verdict.finish()


main()
