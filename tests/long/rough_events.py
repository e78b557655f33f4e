"""Tests that no packet and no weight is lost at rough boundaries, in 1e6 boundary events or more, 1e8 with ALL_CASES. usage:
rough_events.py [N]

Alpha goes from 1e-4 to 2, with both kinds of roughness. Surfaces are planes, cones, meshes with overhangs, prisms with slopes
of 45 and of 89 degrees, grooves with interpolated normals, tiles, bodies, mirrors. Media are clear or nearly so: nearly every
step of a packet ends at a rough boundary, and packets meet facets at all angles. Losses are printed with their cause."""
import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

MESHES = os.path.abspath("meshes")
ALPHAS = (1e-4, 1e-3, 0.02, 0.2, 1, 2)
THIN = 0.3  # scattering coefficient of nearly clear media, 1/cm


def prism(path, half, height):
    """Writes the mesh of a roof along y with upright gables."""
    with open(path, "w", encoding="ascii") as file:
        file.write("".join(f"v {x} {y} {z}\n" for y in (-0.4, 0.4) for x, z in ((-half, 0), (half, 0), (0, height))))
        file.write("f 1 2 3\nf 4 6 5\nf 1 3 6 4\nf 2 5 6 3\n")


def scenes(folder):
    """Yields scenes: name, lines above the first layer, lines below it. {} stands for `KIND ALPHA`, {b} for the roughness of
    bodies."""
    prism(os.path.join(folder, "steep.obj"), 0.004, 0.25)
    plane = "rough {}\n"
    yield "planes", "1.5", plane, "", plane
    yield "cones", "1.5", "b 9 0.1 0.05 -0.1 0.05 0.2 0.05 0 0.02 0.2 0.1 -0.05 0.02 0.3 0.1 0 0.1 0 1\n" + plane, "", plane
    yield "overhang", "1.4", f'm "{MESHES}/overhang.obj"\n' + plane, "", plane
    yield "overhang in glass", "1", f'm "{MESHES}/overhang.obj"\n' + plane, "", plane
    yield "prism", "1.5", f'm "{MESHES}/prism.obj"\n' + plane, "", plane
    yield "steep prism", "1.5", f'm "{folder}/steep.obj"\n' + plane, "", plane
    yield "spikes", "1.5", f'm "{MESHES}/spikes.obj" normals=vertex\n' + plane, "", plane
    yield "grooves", "1.5", f'm "{MESHES}/grooves.asc" units=mm normals=vertex\n' + plane, "", plane
    yield "tile", "1.5", "m gaussian 1 0.02 tile points=32 normals=vertex\n" + plane, "", plane
    yield "mirror", "1.5", plane, "", "m gaussian 0.5 0.02 tile points=32 normals=vertex\n" + plane + "backing 0.9 mirror\n"
    bodies = ("i sphere 0 0 0.5 0.2 1 0 {t} 0 rough={b}\ni sphere 0.5 0 0.5 0.2 1.8 0 {t} 0 rough={b}\n"
              "i cylinder -0.6 0 0.3 -0.4 0.2 0.6 0.05 1.6 0 {t} 0 rough={b}\n"
              f'i "{folder}/needle.obj" 1 0 {{t}} 0 rough={{b}}\n')
    with open(os.path.join(folder, "needle.obj"), "w", encoding="ascii") as file:
        file.write("v -0.001 0.3 -0.4\nv 0.001 0.3 -0.4\nv 0 0.302 -0.4\nv 0 0.3007 -0.7\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n")
    yield "bodies", "1.4", plane, bodies, plane


def text(n, top, inside, bottom, kind, alpha):
    rough = f"{kind} {alpha}"
    above = "1.5" if n == "1" else "1"
    return (f"1.0\n1\nrough.mco A\n1000\nbeam disk 0.6 light=lambertian\n0.1 0.1\n20 20 5\n1\n{above}\n" + top.format(rough) +
            f"{n} 0 {THIN} 0 1\n" + inside.format(b=rough.replace(" ", ","), t=THIN) + bottom.format(rough) + f"{above}\n")


def main():
    wanted = float(sys.argv[1]) if len(sys.argv) > 1 else 1e8 if "ALL_CASES" in os.environ else 1e6
    verdict, flown = cml.Verdict("rough events"), 0
    with tempfile.TemporaryDirectory() as folder:
        cases = [(*scene, kind, alpha) for scene in scenes(folder) for kind in ("ggx", "beckmann") for alpha in ALPHAS]
        for name, *case in cases:
            photons, where = 200, f"{name}, {case[4]} {case[5]}"
            for _ in range(2):  # a first look says how many events a packet has
                record = cml.run(text(*case), "--photons", photons, "--seed", 3, keep=folder)[0]
                events = record["steps"] / (1 + THIN)
                photons = max(200, int(photons * wanted / len(cases) / events * 1.1))
            flown += events
            cml.check_balance(verdict, where, record)
            if record["lost"]:
                with open(record["output"], encoding="utf-8") as file:
                    print(where, re.findall(r"^# .*lost.*$", file.read(), re.M)[:5])
    print(f"{flown:.3g} events in {len(cases)} scenes")
    verdict.check("events", flown >= wanted, f"{flown:.3g} of {wanted:.3g}")
    verdict.finish()


main()
