"""Tests saved packets (P18): rows of a file against the tallies of the same packets, `trace`, adding-doubling, and itself.

- The weights of all rows add up to Rd, Tt and Rsp, in units of weight. Binned again, rows give Rd_ra, Rd_t, Rd_dir, and light and mean paths of detectors.
- Rows drawn at random equal the answers of `trace`: place, direction, weight, path and interactions by medium, largest depth, touches.
- Rows weighted by exp(-x l), l the path in the layer, give Rd and Tt of a slab that absorbs x more, by adding-doubling: |z| < 4.
- Threads, ranks, a stop with --resume, and --more leave the same bytes, except for the group `call`. A limit leaves the first rows.
- The arrays equal those of Python's read_photons. A row of a sweep has a file of its own, equal to that of a run with --set.
Statistic: exact, except for the third test. Its errors come from the spread of the rows, which takes packets as independent. Shares with the
program: the packets; the third test shares nothing."""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from python_package import h5py, mc, np  # noqa: E402

N, C = 1 << 14, 0.0299792458
HILL = dict(layers=["1.4 1 40 0.7 0.2", "1.5 0.5 20 0.5 0.3\ni sphere 0 0 0.35 0.1 1.6 2 10 0.3"], n_below=1.3,
            surfaces={0: "b 3  0.25 0.1  0.1 0.4  0 1"}, grid="0.01 0.01", bins="20 50 10")
DETECTORS = ["detector disk 0.2 na=0.5 name=near", "detector ring 0.3 1 name=far", "detector rectangle 9 9 side=bottom name=under"]


def scene(photons=N, saved='photons "exits"', extra=(), **more):
    return cml.mci(**{**HILL, **more}, photons=photons, extra=[*extra, saved]).replace(" A\n", " B\n", 1)


def contents(path):
    """Returns all content of a file except its group `call`."""
    with h5py.File(path) as file:
        told = {name: (file[name].dtype, file[name][()].tobytes(), dict(file[name].attrs)["long_name"]) for name in file if name != "call"}
        return told, {name: np.asarray(value).tobytes() for name, value in file.attrs.items()}


class Rows:
    def __init__(self, path):
        with h5py.File(path) as file:
            self.attributes = dict(file.attrs)
            self.__dict__.update({name: file[name][()].astype(float) for name in file if name != "call"})

    def sums(self, N=N):
        return [self.weight[self.side == side].sum() / N for side in range(3)]


def binned(index, shape, weight):
    sums = np.zeros(shape)
    np.add.at(sums, tuple(np.minimum(i.astype(int), n - 1) for i, n in zip(index, shape)), weight)
    return sums


def tallies(verdict, engine):
    asks = ["time 100 20", "directions 6 8", *DETECTORS]
    with tempfile.TemporaryDirectory() as folder:
        told = cml.run(scene(extra=asks), "--engine", engine, keep=folder)[0]
        rows = Rows(os.path.join(folder, "exits.photons.h5"))
        with h5py.File(os.path.join(folder, "out.h5")) as file:
            result = {name: file[name][()] for name in file if name != "call"}
        trace_rows(verdict, engine, os.path.join(folder, "scene.mci"), rows)
    verdict.check(engine, told["saved"] == {"rows": len(rows.index), "found": len(rows.index), "covers": N}, f"said {told['saved']}")
    for name, total in zip(("Rd", "Tt", "Rsp"), rows.sums()):
        verdict.check(engine, total == told[name] and total > 0.005, f"{name} of rows {total!r}, of the run {told[name]!r}")
    up, w = rows.side == 0, rows.weight / N
    t = np.arccos(np.minimum(np.abs(rows.uz), 1))
    ra = binned((np.hypot(rows.x, rows.y)[up] / 0.01, t[up] / (np.pi / 20)), (50, 10), w[up])
    da, r, a = np.pi / 20, (np.arange(50) + 0.5) * 0.01, (np.arange(10) + 0.5) * np.pi / 20
    area = np.outer(2 * np.pi * r * 0.01, 4 * np.pi * np.sin(a) * np.sin(da / 2) * np.cos(a))
    gates = binned((rows.time[up] / 5,), (21,), w[up])[:20] / 5
    turn = np.arctan2(rows.uy, rows.ux) % (2 * np.pi)
    edges = np.cos(np.linspace(0, np.pi / 2, 7))
    sr = (edges[:-1] - edges[1:])[:, None] * np.full(8, 2 * np.pi / 8)
    for name, mine in (("Rd_ra", ra / area), ("Rd_t", gates), ("Rd_dir", binned((t[up] / (np.pi / 12), turn[up] / (np.pi / 4)), (6, 8), w[up]) / sr)):
        verdict.check(engine, np.allclose(mine, result[name], rtol=1e-12, atol=0), f"{name}: {np.abs(mine - result[name]).max()} off")
    for k, name in enumerate(("near", "far", "under")):
        seen = rows.detector == k + 1
        verdict.check(engine, np.isclose(w[seen].sum(), result[f"detector_{name}"], rtol=1e-14, atol=0), f"{name}: {w[seen].sum()}")
        means = (w[seen] @ rows.path[seen] / w[seen].sum(), w[seen] @ rows.interactions[seen] / w[seen].sum(), w[seen] @ rows.deepest[seen] / w[seen].sum())
        for ending, mean in zip(("path", "interactions", "deepest"), means):
            theirs = result[f"detector_{name}_{ending}"]
            verdict.check(engine, np.allclose(mean, theirs, rtol=1e-5, atol=1e-6), f"{name} {ending}: {mean}, of the tally {theirs}")
    times = rows.path @ [1.0, 1.4, 1.5, 1.3, 1.6] / C
    verdict.check(engine, np.allclose(times, rows.time, rtol=1e-5), f"times are {np.abs(times - rows.time).max()} ps off")


def trace_rows(verdict, engine, path, rows):
    for k in range(0, len(rows.index), len(rows.index) // 8):
        done = subprocess.run([cml.PROGRAM, "trace", path, str(int(rows.index[k])), "--engine", engine], capture_output=True, text=True, check=True).stdout
        events = [(row[1], int(row[2]), np.array(row[3:], float)) for row in (line.split() for line in done.splitlines() if re.match(r" *\d+  ", line))]
        where, last = f"{engine}, packet {rows.index[k]:.0f}", events[-1][2]
        mine = [rows.ux[k], rows.uy[k], rows.uz[k], rows.weight[k]]
        verdict.check(where, np.allclose(mine, last[3:7], rtol=1e-4, atol=1e-5), f"ends {mine}, not {last[3:7]}")
        length, interactions, deepest, counts, touches = np.zeros(5), np.zeros(5), -np.inf, False, 0
        for (what, medium, place), before in zip(events[1:], events):
            if counts:
                length[before[1]] += np.linalg.norm(place[:3] - before[2][:3])
                interactions[medium] += what == "interact"
            counts = counts or what in ("reflect", "transmit")
            deepest = max(deepest, place[2]) if counts else deepest
            if what in ("reflect", "transmit"):
                touches, touched = touches + 1, place[:3]
        verdict.check(where, np.allclose(length, rows.path[k], rtol=1e-3, atol=1e-4) and (interactions == rows.interactions[k]).all(),
                      f"{rows.path[k]} {rows.interactions[k]}, traced {length} {interactions}")
        verdict.check(where, abs(deepest - rows.deepest[k]) < 1e-5 and touches == rows.touches[k], f"{rows.deepest[k]} {rows.touches[k]}, traced {deepest} {touches}")
        verdict.check(where, np.allclose((rows.x[k], rows.y[k], rows.z[k]), touched, atol=1e-4), f"left at {rows.x[k]} {rows.y[k]} {rows.z[k]}, not {touched}")


def another_absorption(verdict):
    slab = dict(layers=["1.4 0.5 60 0.8 0.2"], surfaces={}, n_below=1.0)
    with tempfile.TemporaryDirectory() as folder:
        cml.run(scene(photons=1 << 16, **slab), keep=folder)
        rows = Rows(os.path.join(folder, "exits.photons.h5"))
    for more in (0.5, 2, 8):
        exact = cml.exact(cml.mci([f"1.4 {0.5 + more} 60 0.8 0.2"]))
        for side, name in enumerate(("Rd", "Tt")):
            terms = np.where(rows.side == side, rows.weight * np.exp(-more * rows.path[:, 1]), 0)
            terms = np.append(terms, np.zeros((1 << 16) - len(terms)))
            verdict.z(f"{name} with {more} 1/cm more", terms.mean(), terms.std() / 2**8, exact[name])


def same(verdict, what, one, other):
    for part, mine, theirs in zip(("arrays", "attributes"), contents(one), contents(other)):
        verdict.check(what, mine == theirs, f"{part} differ: {[name for name in mine if mine[name] != theirs.get(name)]}")


def stopped(verdict, path, folder):
    """Starts a run, stops it twice after its next checkpoint, and then lets it finish."""
    def checkpoint():
        try:
            return os.stat(os.path.join(folder, "out.mco.checkpoint")).st_ino
        except FileNotFoundError:
            return None

    stops = 0
    for asked in (True, True, False):
        before = checkpoint()
        process = subprocess.Popen([cml.PROGRAM, path, "--resume", "--checkpoint", "0.02", "--quiet", "--threads", "1", "-o", folder], stderr=subprocess.PIPE)
        while asked and checkpoint() == before and process.poll() is None:
            time.sleep(0.005)
        if asked:
            process.send_signal(signal.SIGINT)
        process.communicate()
        stops += process.returncode == 75
    verdict.check("--resume", process.returncode == 0 and stops > 0, f"ended with {process.returncode} after {stops} stops")


def order(verdict, limit, photons, ways, beams=()):
    saved = f'photons "exits" limit={limit}'
    with tempfile.TemporaryDirectory() as top:
        path = os.path.join(top, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene(photons, saved, extra=[*DETECTORS, *beams]))
        files = {}
        for way in ("one", *ways):
            os.mkdir(folder := os.path.join(top, way))
            files[way] = os.path.join(folder, "exits.photons.h5")
            words = [cml.PROGRAM, "run", path, "--quiet", "-o", folder]
            if way == "stop":
                stopped(verdict, path, folder)
            elif way == "more":
                subprocess.run([*words, "--photons", "5000", "--keep"], check=True)
                subprocess.run([*words, "--more", str(photons - 5000)], check=True)
            elif way == "ranks":
                if not shutil.which("mpiexec"):
                    continue
                subprocess.run(["mpiexec", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", "3", *words, "--threads", "1"], check=True)
            else:
                subprocess.run([*words, "--threads", "1" if way == "one" else "3", "--chunk", "77"], check=True, stderr=subprocess.DEVNULL)
            if way != "one":
                same(verdict, f"limit {limit}: {way}", files["one"], files[way])
        return Rows(files["one"])


def limits(verdict):
    whole, part = order(verdict, 1_000_000, 1 << 17, ("stop", "ranks")), order(verdict, 3000, 1 << 15, ("three", "more", "ranks"))
    verdict.check("limit", len(part.index) == 3000 and (part.index == whole.index[:3000]).all() and (np.diff(whole.index) > 0).all(), "not the first rows")
    verdict.check("limit", (part.path == whole.path[:3000]).all() and part.attributes["found"] == (whole.index < 1 << 15).sum(), "other rows")
    verdict.check("limit", part.attributes["covers"] == part.index[-1] + 1 and whole.attributes["covers"] == 1 << 17, f"covers {part.attributes['covers']}")


def hashes(index):
    """Hashes indices with splitmix64's finaliser (Steele, Lea, Flood 2014)."""
    z = index.astype(np.uint64)
    z = (z ^ z >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ z >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
    return z ^ z >> np.uint64(31)


def several_beams(verdict, photons=10000, limit=2000):
    """Checks that a limit keeps a fair sample of the rows of several beams, also of beams with fewer photons than batches."""
    pencils = [f"beam pencil at={0.001 * k},0 share={w}" for k, w in [(0, 3), (1, 0.01)]]
    beams = [*pencils, "beam pencil z=0.09 light=isotropic share=1", *(f"beam pencil z=0.09 at={k},0 light=isotropic share=0.01" for k in range(25))]
    order(verdict, limit, photons, ("more",), ["beam disk 0.1 share=3", beams[2]])
    part = order(verdict, limit, photons, ("three", "ranks"), beams)
    with tempfile.TemporaryDirectory() as folder:
        cml.run(scene(photons, extra=[*DETECTORS, *beams]), keep=folder)
        whole = Rows(os.path.join(folder, "exits.photons.h5"))
    covers, first = part.attributes["covers"], np.argsort(hashes(whole.index))[:limit]
    verdict.check("several beams", (part.index == np.sort(whole.index[first])).all(), "other rows")
    faint, all_faint = ((rows.index >= 3 << 48).sum() for rows in (part, whole))
    share = limit / len(whole.index)
    verdict.z("faint beams", faint, np.sqrt(all_faint * share * (1 - share)), all_faint * share)
    verdict.z("covers", covers, np.sqrt(photons * share * (1 - share)), photons * share)
    for side, (few, all_) in enumerate(zip(part.sums(covers), whole.sums(photons))):
        squares = (part.weight[part.side == side]**2).sum() / covers - few**2
        verdict.z(f"several beams, side {side}", few, np.sqrt(squares / covers), all_)


def detected(verdict):
    with tempfile.TemporaryDirectory() as folder:
        cml.run(scene(extra=DETECTORS[:2]), keep=folder)
        whole = Rows(path := os.path.join(folder, "exits.photons.h5"))
        table = mc.read_photons(path)
        verdict.check("Python", (table.index == whole.index).all() and (table.path_2 == whole.path[:, 2]).all() and (table.side == whole.side).all()
                      and table.attrs["covers"] == N and table.weight.sum() == whole.weight.sum(), "another table")
        cml.run(scene(saved='photons "exits" detected', extra=DETECTORS[:2]), keep=folder)
        some = Rows(path)
        verdict.check("detected", (some.index == whole.index[whole.detector > 0]).all() and 0 < len(some.index) < len(whole.index), "other rows")
        cml.run(scene(saved='photons "exits" detected', extra=["detector disk 1e-9 at=50,50 name=none"]), keep=folder)
        verdict.check("detected", len(mc.read_photons(path)) == 0, "rows of nothing")


def swept(verdict):
    """Checks that row 2 of a sweep has the packets of a run with --set."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.mci")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene(2000))
        with open(os.path.join(folder, "rows.csv"), "w", encoding="utf-8") as file:
            file.write("layer1.mua\n2\n3\n")
        cml.run(path, "--sweep", os.path.join(folder, "rows.csv"), keep=folder)
        cml.run(path, "--set", "layer1.mua=3", keep=folder)
        row, run, other = (contents(os.path.join(folder, f"exits{name}.photons.h5"))[0] for name in ("-0002", "", "-0001"))
        verdict.check("sweep", row == run and row["weight"] != other["weight"], "other rows")


verdict = cml.Verdict("saved packets")
for engine in ("cpu", "reference"):
    tallies(verdict, engine)
another_absorption(verdict)
limits(verdict)
several_beams(verdict)
detected(verdict)
swept(verdict)
verdict.finish(limit=4)
