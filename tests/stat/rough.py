"""Tests rough boundaries: light that is isotropic on all sides stays so, and a mesh with the same slopes gives the same
totals.

Furnace: layers, a hill, a mesh with overhangs, a prism with upright gables, a tile and a sphere, alpha 0.05 to 2, both kinds
of roughness. Light that leaves obeys the cosine law, and every layer and body holds the light that its volume asks for. N =
2e4 packets a scene.
Relief: a mesh with Gaussian heights, a correlation length of a twentieth of the mean free path and facets of rms slope 0.5.
Its totals are those of `rough beckmann 0.5` within noise and 0.1 % (one standard deviation), and differ from those of the
smooth slab. N = 4e5. Statistic: z, level 1e-4 over all. The relief shares the facets' optics with the smooth walk only.
Lobes: light along the normal of a surface with small alpha is mirrored and refracted once. The lobes Rsp_dir and Tt_dir are
then the distribution of the facets' slopes, with Fresnel's reflectance of each. N = 1e6.
Clear slab between rough faces under diffuse light from both sides: the mean path, which is the sum of the fluence, is 4 V n^2
/ S, as no light is trapped. N = 16 runs of 5000."""
import bisect
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

HEAD = "1.0\n1\nrough.mco A\n1000\n0.01 0.01\n20 20 5\n"


def layers(top, bottom, inside="", n=1.4, beam=""):
    return f"{HEAD}{beam}1\n1\n{top}\n{n} 0.5 20 0.8 0.3\n{inside}{bottom}\n1.2\n"


def furnace_scenes():
    overhang, prism = os.path.abspath("meshes/overhang.obj"), os.path.abspath("meshes/prism.obj")
    for kind in ("ggx", "beckmann"):
        for alpha in (0.05, 0.5, 1, 2):
            line = f"rough {kind} {alpha}"
            yield f"{kind} {alpha} planes", layers(line, line)
        line = f"rough {kind} 0.4"
        yield f"{kind} hill", layers(f"b 2 0.1 0.2 0 1\n{line}", line)
        yield f"{kind} overhang", layers(f'm "{overhang}"\n{line}', line)
        yield f"{kind} prism", layers(f'm "{prism}"\n{line}', line)
        yield f"{kind} tile", layers(f"m gaussian 0.3 0.02 tile points=16\n{line}", line)
        yield f"{kind} sphere", layers("", line, f"i sphere 0 0 0.15 0.1 1.2 0 30 0.5 rough={kind},0.6\n")


def furnace(verdict, folder):
    path = os.path.join(folder, "rough.mci")
    for name, text in furnace_scenes():
        with open(path, "w") as file:
            file.write(text)
        done = subprocess.run([cml.PROGRAM, "furnace", path, "--photons", "2e4", "--json", "--alpha", "1e-9"], capture_output=True, text=True, check=False)
        verdict.check(name, done.returncode == 0, done.stderr)
        for run in map(json.loads, done.stdout.splitlines()):
            for place in run["places"]:
                if place["untested"] is None:
                    verdict.z(f"{name}: {place['name']}", place["ratio"], place["error"], 1)


def totals(folder, boundary):
    text = HEAD.replace("1000", "400000", 1) + f"beam rectangle 0.0128 0.0128\n1\n1\n{boundary}\n1.5 1 20 0.8 0.5\n{boundary}\n1\n"
    path = os.path.join(folder, "rough.mci")
    with open(path, "w") as file:
        file.write(text)
    told = json.loads(subprocess.run([cml.PROGRAM, path, "--json", "--output-dir", folder], capture_output=True, text=True, check=True).stdout)
    return {name: (told[name], told[name + "_se"]) for name in ("Rd", "A", "Tt")}


def relief(verdict, folder):
    drawn = totals(folder, "m gaussian 0.5 0.002 tile points=64")
    walked, smooth = totals(folder, "rough beckmann 0.5"), totals(folder, "")
    for name in ("Rd", "A", "Tt"):
        error = (drawn[name][1] ** 2 + walked[name][1] ** 2 + (0.001 * walked[name][0]) ** 2) ** 0.5
        verdict.z(f"relief {name}", drawn[name][0], error, walked[name][0])
    off = (smooth["Rd"][0] - walked["Rd"][0]) / (smooth["Rd"][1] ** 2 + walked["Rd"][1] ** 2) ** 0.5
    verdict.check("smooth Rd", abs(off) > 6, f"{off:.1f} errors from the rough one")


def reflectance(n, theta):
    """Returns Fresnel's reflectance, from index n into 1."""
    sine = n * math.sin(theta)
    if sine >= 1:
        return 1.0
    a, b = n * math.cos(theta), math.sqrt(1 - sine * sine)
    c, d = math.cos(theta), n * b
    return ((a - b) ** 2 / (a + b) ** 2 + (c - d) ** 2 / (c + d) ** 2) / 2


def lobe(kind, alpha, bins, bend, share):
    """Returns the light in each bin of 5 degrees of exit, for light along the normal: a facet of angle m sends share(m) to
    the angle bend(m)."""
    steeper = (lambda t: alpha * alpha / (alpha * alpha + t * t)) if kind == "ggx" else (lambda t: math.exp(-(t / alpha) ** 2))
    expected, edges, steps = [0.0] * bins, [math.radians(5 * i) for i in range(1, bins + 1)], 40000
    for i in range(steps):
        low, high = (math.radians(41 * (i + k) / steps) for k in (0, 1))
        where = bisect.bisect(edges, bend((low + high) / 2))
        if where < bins:
            expected[where] += (steeper(math.tan(low)) - steeper(math.tan(high))) * share((low + high) / 2)
    return expected


def lobes(verdict, folder):
    """Tests lobes of light mirrored from outside, and of light refracted out of the medium. The latter has the index of the
    medium above, so that light reaches the facets undisturbed."""
    n, photons, bins, extra = 1.5, 1000000, 6, ["directions 18 1"]
    for kind, alpha in (("ggx", 0.05), ("beckmann", 0.1)):
        line = f"rough {kind} {alpha}"
        outside = cml.mci([f"{n} 1e4 0 0 1"], photons=photons, extra=extra, n_below=n, surfaces={0: line})
        inside = cml.mci([f"{n} 0 0 0 0.1"], photons=photons, extra=extra, n_above=n, surfaces={1: line})
        for text, key, bend, share in ((outside, "Rsp_dir", lambda m: 2 * m, lambda m: reflectance(1 / n, m)),
                                       (inside, "Tt_dir", lambda m: math.asin(min(1.0, n * math.sin(m))) - m, lambda m: 1 - reflectance(n, m))):
            found = cml.read_sections(cml.run(text, "--sampling", "random", keep=folder)[0]["output"])[key]
            for i, truth in enumerate(lobe(kind, alpha, bins, bend, share)):
                solid = 2 * math.pi * (math.cos(math.radians(5 * i)) - math.cos(math.radians(5 * i + 5)))
                if truth * photons > 10:
                    verdict.z(f"{key} {kind} {5 * i} degrees", found[i] * solid, math.hypot(math.sqrt(truth / photons), 1e-3 * truth), truth)


def clear(verdict, folder):
    thick, n = 1.0, 1.4
    for kind, alpha in (("ggx", 0.2), ("ggx", 1), ("beckmann", 0.5), ("beckmann", 2)):
        line = f"rough {kind} {alpha}"
        text = cml.repeated(16, [f"{n} 0 0 0 {thick}"], photons=5000, grid="0.1 1", bins="10 1 1", surfaces={0: line, 1: line},
                            extra=["fluence", "beam disk 0.1 light=lambertian", "beam disk 0.1 light=lambertian z=2 angle=180"])
        paths = [sum(cml.read_sections(record["output"])["phi_z"]) * 0.1 for record in cml.run(text, keep=folder)]
        verdict.z(f"path {line}", statistics.fmean(paths), statistics.stdev(paths) / 4, 2 * thick * n * n)


def main():
    verdict = cml.Verdict("rough")
    with tempfile.TemporaryDirectory() as folder:
        furnace(verdict, folder)
        relief(verdict, folder)
        lobes(verdict, folder)
        clear(verdict, folder)
    verdict.finish(limit=4.9)  # some 75 values at 1e-4 in all


main()
