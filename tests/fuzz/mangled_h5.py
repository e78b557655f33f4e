"""Feeds mangled .h5 files to plot, compare and read. Each command draws, or refuses the file in one line with exit code 2. It
never crashes, hangs, shows a traceback, or takes more than 3 GB. Half of the files have some bytes changed; the other half
are sound HDF5 in which one object is changed.

    mangled_h5.py [NUMBER of files, default 500 [SEED]]

The parent imports all modules and forks a process for every few files. If a process dies by a signal, its current file is a
fault.
SPDX-License-Identifier: MIT"""
import contextlib
import io
import os
import random
import resource
import signal
import sys
import tempfile
import traceback

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "lib"))
from python_package import h5py, mc, np  # noqa: E402
from clustermcml import __main__, errors  # noqa: E402

EACH = 25  # files per process
LONGEST = 30.0  # seconds of processor time for a file; SIGPROF ends the process, even inside the HDF5 library
BLOCKED = 600  # seconds after which SIGALRM ends a process that waits for ever
ODD = (0.0, -1.0, 0.5, 1e308, -1e308, 1e-320, float("nan"), float("inf"), -float("inf"), 2.0**53, 1e19)
TYPES = ("<f8", "<f4", "<i4", "<i8", "S9", "f8,f8", "?", "<c16")


def sound(folder):
    """Makes a result with arrays of every kind, flown twice."""
    scene = mc.Scene([mc.Layer(1.4, 1, 60, 0.8, 0.1, bodies=[mc.Sphere(0, 0, 0.05, 0.02, 1.5, 3, 40, 0.5)], top=mc.Heightfield(r=[0, 0.05], h=[0.02, 0]))], photons=500,
                     nr=7, nz=5, na=3, map=mc.Map(4, 3, 0.1, 0.1, angles=True, volume=True), time=mc.Time(100, 4), directions=mc.Directions(3, 4), fluence=True, facets=True,
                     detectors=[mc.Detector("ring", r1=0.01, r2=1, name="far")])
    for seed in ("1", "2"):
        mc.run(scene, seed=int(seed), output_dir=os.path.join(folder, seed))
    with open(os.path.join(folder, "1", "scene.h5"), "rb") as file:
        return file.read()


def mangle_bytes(dice, content):
    changed = bytearray(content)
    for _ in range(dice.choice((1, 1, 2, 8))):
        at = dice.randrange(len(changed))
        size = dice.choice((1, 1, 8, 8, 64))
        start = dice.randrange(len(changed))
        changed[at:at + size] = dice.choice((b"", bytes(size), b"\xff" * size, dice.randbytes(size), changed[start:start + size], changed[at:at + size] * 2))
    return bytes(changed), "bytes"


def _other_values(dice, item):
    values = np.array(item[()], dtype=float)
    if values.ndim and values.size:
        values.flat[dice.randrange(values.size) if dice.random() < 0.5 else slice(None)] = dice.choice(ODD)
        return values
    return np.array(dice.choice(ODD))


def _other_shape(dice, item):
    shape = list(item.shape)
    if shape:
        shape[dice.randrange(len(shape))] = dice.choice((0, 1, 2, 50))
    return np.ones(dice.choice((shape, shape[1:], shape[::-1], [*shape, 2])))


def mangle_object(dice, path):
    """Replaces one object of the file by another. Returns a description of the change."""
    with h5py.File(path, "r+") as file:
        name = dice.choice(sorted(key for key in file if isinstance(file[key], h5py.Dataset)))
        item, kind = file[name], dice.choice(("values", "values", "shape", "type", "gone", "attribute", "attribute", "link", "promise", "axis"))
        kept = [(k, item.dims[k][0].name) for k in range(len(item.dims)) if len(item.dims[k])]
        made = None
        if kind == "values" and item.dtype.kind == "f":
            with contextlib.suppress(TypeError):
                made = _other_values(dice, item)
        elif kind == "shape":
            made = _other_shape(dice, item)
        elif kind == "type":
            made = np.zeros(item.shape, dice.choice(TYPES))
        if made is not None:
            chunks = item.chunks if item.chunks and made.shape == item.shape and dice.random() < 0.5 else None
            del file[name]
            item = file.create_dataset(name, data=made, chunks=chunks)
            for k, axis in kept:
                if k < item.ndim and axis in file:
                    item.dims[k].attach_scale(file[axis])
        elif kind == "gone":
            del file[name]
        elif kind == "attribute":
            where = dice.choice((item, file, file))
            key = dice.choice(sorted(where.attrs) or ["units"])
            del where.attrs[key]
            if dice.random() < 0.8:
                where.attrs.create(key, dice.choice([*ODD, np.bytes_("x\ny"), np.zeros(3), 7, np.bytes_("b 3 1 2 nan x"), np.bytes_("b 999999999 1")]))
        elif kind == "link":
            del file[name]
            file[name] = dice.choice((h5py.SoftLink("/" + name), h5py.ExternalLink("2/scene.h5", "/Rd"), h5py.ExternalLink("pipe.h5", "/Rd")))
        elif kind == "promise":
            del file[name]
            file.create_dataset(name, (2**20, 2**12), "<f8", chunks=(2**10, 2**12), compression=1)
        elif kind == "axis" and kept:
            others = sorted(key for key in file if isinstance(file[key], h5py.Dataset) and file[key].attrs.get("CLASS") == b"DIMENSION_SCALE")
            item.dims[kept[0][0]].detach_scale(file[kept[0][1]])
            item.dims[kept[0][0]].attach_scale(file[dice.choice(others)])
    return f"{kind} of {name}"


def command(*words):
    """Runs a command. Returns a complaint about its answer, or None."""
    said, sys.argv = io.StringIO(), ["clustermcml", *words]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        code = __main__.main()
    lines = [line for line in said.getvalue().splitlines() if not line.startswith("clustermcml: note: ")]
    good = code in (0, 1) and len(lines) <= code or code == 2 and len(lines) == 1 and lines[0].startswith("clustermcml: ")
    return None if good else f"exit code {code}, {said.getvalue()[:300]!r}"


def reads():
    try:
        mc.read("bad.h5")
    except errors.InputError as error:
        return f"two lines: {str(error)!r}" if "\n" in str(error) else None
    return None


def fault_of(dice, names):
    """Returns the complaint about the file bad.h5, or None."""
    jobs = {"read": reads, "compare": lambda: command("compare", "bad.h5", "2/scene.h5", *(["-o", "out.svg"] if dice.random() < 0.2 else [])),
            "plot": lambda: command("plot", "bad.h5", "-o", "out.svg"), "plot --of": lambda: command("plot", "bad.h5", "--of", dice.choice(names), "-o", "out.svg")}
    for name, job in jobs.items():
        try:
            fault = job()
        except Exception:
            fault = traceback.format_exc()
        if fault:
            return f"{name}: {fault}"
    return None


def work(first, last, seed, content, names):
    """Tests the files of one process; prints the current file, because the process may die."""
    resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for index in range(first, last):
        dice = random.Random(f"{seed} {index}")
        changed, how = mangle_bytes(dice, content) if index % 2 else (content, "")
        with open("bad.h5", "wb") as file:
            file.write(changed)
        how = how or mangle_object(dice, "bad.h5")
        with open("at", "w", encoding="utf-8") as file:
            file.write(f"{index} {how}")
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        signal.alarm(BLOCKED)
        fault = fault_of(dice, names)
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
        if fault:
            with open("faults", "a", encoding="utf-8") as file:
                file.write(f"file {index} ({how}): {fault}\n")
    os._exit(0)


def main():
    number, seed = int(sys.argv[1]) if len(sys.argv) > 1 else 500, sys.argv[2] if len(sys.argv) > 2 else "1"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        content = sound(folder)
        os.mkfifo("pipe.h5")
        open("faults", "w", encoding="utf-8").close()
        with h5py.File("1/scene.h5") as file:
            names = sorted(name for name in file if isinstance(file[name], h5py.Dataset) and file[name].ndim)
        for vtp in os.listdir("1"):  # shapes beside the file
            os.link(os.path.join("1", vtp), vtp.replace("scene", "bad"))
        os.remove("bad.h5")
        for words in (("compare", "1/scene.h5", "2/scene.h5", "-o", "out.svg"), ("plot", "1/scene.h5", "--of", "boundary0_irradiance_above", "-o", "out.svg")):
            fault = command(*words)  # imports what all processes need
            assert fault is None, fault
        first = 0
        while first < number:
            child = os.fork() or work(first, min(number, first + EACH), seed, content, names)
            status = os.waitpid(child, 0)[1]
            first += EACH
            if status:
                with open("at", encoding="utf-8") as at, open("faults", "a", encoding="utf-8") as faults:
                    where = at.read()
                    faults.write(f"file {where}: the process ended with {status}\n")
                    first = int(where.split()[0]) + 1
        with open("faults", encoding="utf-8") as file:
            found = file.read()
    print(found + f"{number} files, {found.count('file ')} faults")
    sys.exit(1 if found else 0)


main()
