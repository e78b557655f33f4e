"""Tests a tile against a mesh of 9 x 9 of its copies, in light that is wide compared with a period.

Both fly N packets (environment PHOTONS, 1e7) with different random numbers. Both boundaries of the upper layer are rough
surfaces. The medium below absorbs so much that no light from a beam of 0.3 cm comes to the patch's rim, 1.08 cm away.
Compared are totals and Rd(r), Tt(r) in groups of bins; level 1e-4 over all. cross.tile compares packet by packet; here
nothing is paired, so that a bias of a few packets in 1e5 shows, too. The test must also tell apart a tile whose waves are 5 %
higher. Shared: everything but the mesh and the queries over it."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import profiles  # noqa: E402

PHOTONS = int(float(os.environ.get("PHOTONS", "1e7")))
CELLS, SPACING, COPIES, DR = 24, 0.01, 9, 0.02


def height(i, j):
    x, y = 2 * math.pi * i / CELLS, 2 * math.pi * j / CELLS
    return math.sin(x) + 0.7 * math.cos(2 * y + 1) + 0.5 * math.sin(3 * x - 2 * y)


def write_map(path, copies, size):
    n = copies * CELLS
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ncols {n}\nnrows {n}\ncellsize {SPACING!r}\n")
        for j in range(n):
            file.write(" ".join(repr(size * height(i % CELLS, j % CELLS)) for i in range(n)) + "\n")


def fly(folder, name, copies, size, seed, photons):
    path = os.path.join(folder, name + ".asc")
    write_map(path, copies, size)
    line = f'm "{path}" units=cm' + ("" if copies > 1 else " tile")
    text = cml.mci(["1.4 2 60 0.8 0.05", "1.5 20 200 0.8 1"], photons=photons, surfaces={0: line, 1: line},
                   grid=f"0.01 {DR}", bins="10 50 1", extra=["beam disk 0.3 angle=50 azimuth=20"])
    record = cml.run(text, "--seed", seed, "--ignore-absorption", keep=folder)[0]
    return record, cml.read_sections(record["output"])


def main():
    verdict = cml.Verdict(f"tile against patch, {PHOTONS:.0e} photons each")
    with tempfile.TemporaryDirectory() as folder:
        tile, tile_sections = fly(folder, "tile", 1, 0.01, 1, PHOTONS)
        patch, patch_sections = fly(folder, "patch", COPIES, 0.01, 2, PHOTONS)
        higher, _ = fly(folder, "higher", 1, 0.0105, 3, min(PHOTONS, 10**7))
    for name, record in (("tile", tile), ("patch", patch)):
        cml.check_balance(verdict, name, record)
    for key in ("Rsp", "Rd", "A"):
        verdict.z(key, tile[key], tile[key + "_se"], patch[key], patch[key + "_se"])
    errors = {key: patch_sections["se_" + key] for key in ("Rd_r", "Tt_r")}
    profiles.compare(verdict, "tile", PHOTONS, tile_sections, patch_sections, errors, group=5, dr=DR)
    told = max(abs(tile[key] - higher[key]) / math.hypot(tile[key + "_se"], higher[key + "_se"])
               for key in ("Rsp", "Rd", "A"))
    verdict.check("waves 5 % higher are seen", told > 6, f"{told:.1f} errors")
    verdict.finish(profiles.student_limit(len(verdict.rows)))


if __name__ == "__main__":
    main()
