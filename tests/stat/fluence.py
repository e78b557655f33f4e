"""Tests fluence (P14) against known values.

- Turbid layers: phi mua is the absorption of the same packets, bin by bin and voxel by voxel. The z-scores are of the
  differences of the runs, so common noise drops out. Bins are finer than a free path, or coarser.
- A furnace: light by the cosine law from both sides, irradiance 1 each. The fluence is 4 in air, and 4 n^2 in a turbid layer
  and a clear one beside it. A clear layer alone, between planes, has only the directions that can enter it: 4 n^2 (1 - sqrt(1
  - 1 / n^2)). Bins are bounded, because means over an infinite clear layer have no variance.
- A pit through the bins, with the index of air, that absorbs and does not scatter: each bin has the integral over the light
  that has come to it, air included, in closed form.
- The same pit through voxels, over a square each.
- A glass plate above and its inner reflections, which are split off at the launch (P1): 1 + R of their sum, in closed form.
- A bin lies within one of its errors of the mean over other runs in 68 % of cases, with random and with evenly spread draws.
- By gate: gates sum to phi_rz, and mua times a layer's fluence in a gate is the absorption in that gate.
Statistic: z, level 1e-4 over all."""
import math
import os
import re
import statistics
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

RUNS, SINGLE = 30, 2.0**-23


def sections_of(text, *options):
    with tempfile.TemporaryDirectory() as keep:
        records = cml.run(text, *options, keep=keep)
        return [(record, cml.read_sections(record["output"]) | {"A_rz": grid_of(record["output"])} | voxels_of(record["output"])) for record in records]


def grid_of(path):
    """Returns A_rz of an .mco, whose numbers stand in lines of five."""
    with open(path, encoding="utf-8") as file:
        behind = file.read().split("\nA_rz\n")[1]
    return list(map(float, behind.split("#")[0].split("\n\n")[0].split()))


def voxels_of(path):
    """Returns {name: values, x fastest} of the image of voxels beside a result, if there is one; errors are se_ as in
    sections."""
    path = path[:-4] + ".volume.vti"
    if not os.path.exists(path):
        return {}
    with open(path, "rb") as file:
        data = file.read()
    begin = data.index(b"_", data.index(b"<AppendedData")) + 1
    found = {}
    for name, offset in re.findall(rb'Name="(\w+)"[^>]*offset="(\d+)"', data[:begin]):
        at = begin + int(offset)
        key = re.sub(r"(.*)_se$", r"se_\1", name.decode())
        found[key] = struct.unpack_from(f"<{struct.unpack_from('<Q', data, at)[0] // 4}f", data, at + 8)
    return found


def spread(verdict, name, values, truth, rounding=0):
    """Compares the mean of values of runs with the truth by their spread. rounding: error of the mean by single precision;
    interactions of a dense layer score both sides alike, so little else remains."""
    error = math.hypot(statistics.stdev(values) / math.sqrt(len(values)), rounding)
    verdict.z(name, statistics.fmean(values), error, truth)


def turbid(verdict):
    layers, mua = ["1.4 1 50 0.8 0.1", "1.5 3 20 0 0.1"], (1, 3)
    for nr, nz in ((3, 4), (4, 20)):
        text = cml.repeated(RUNS, layers, photons=2000, grid=f"{0.2 / nz} 0.05", bins=f"{nz} {nr} 1", extra=["fluence", "beam disk 0.05", "map 3 2 0.04 0.06 volume"])
        runs = sections_of(text)
        for record, _ in runs:
            cml.check_balance(verdict, "turbid", record)
        for i in range(nz):
            of = mua[i * 2 // nz]
            spread(verdict, f"phi_z[{i}] of {nz}", [found["phi_z"][i] * of - found["A_z"][i] for _, found in runs], 0)
        for i in range((nr - 1) * nz):  # the last radius of A_rz holds all that lies beyond
            of = mua[i % nz * 2 // nz]
            spread(verdict, f"phi_rz[{i}] of {nz}", [found["phi_rz"][i] * of - found["A_rz"][i] for _, found in runs], 0)
        for i in range(6 * nz):
            of = mua[i // 6 * 2 // nz]
            spread(verdict, f"phi_xyz[{i}] of {nz}", [found["phi_xyz"][i] * of - found["A_xyz"][i] for _, found in runs], 0,
                   rounding=SINGLE * statistics.fmean(found["A_xyz"][i] for _, found in runs))


def furnace(verdict, name, layers, truth, n=1.5):
    """Tests a furnace: layers 0.004 thick, and as much air below them. The sources are so wide that light from beyond them
    would come within 0.002 of the horizontal and does not matter."""
    wide, dz, nr = 4.0, 0.002, 3
    nz = 2 * len(layers) + 2
    beam = f"beam disk {wide} light=lambertian"
    text = cml.repeated(RUNS, [f"{n} 0 {mus} 0 0.004" for mus in layers], photons=20000, grid=f"{dz} 0.2", bins=f"{nz} {nr} 1",
                        extra=["fluence", beam, f"{beam} z={nz * dz + 0.001} angle=180"])
    runs = [found for _, found in sections_of(text)]
    per_irradiance = 2 * math.pi * wide**2
    for i in range(nz):
        mean = [statistics.fmean([found["phi_rz"][ir * nz + i] * (2 * ir + 1) / nr for ir in range(nr)]) * per_irradiance for found in runs]
        spread(verdict, f"{name}, half layer {i}", mean, 4 if i // 2 == len(layers) else truth)


def pit(verdict, mua):
    """Tests a cone 0.1 deep and 0.2 wide, heights -0.1 + r / 2 inside, in light straight down of irradiance 1 / (pi 0.3^2)."""
    wide, dr, dz, nr, nz = 0.3, 0.05, 0.03, 6, 5
    nx, ny, dx, dy, raised = 4, 3, 0.08, 0.07, -0.045
    text = cml.repeated(RUNS, [f"1 {mua} 0 0 1"], photons=2000, grid=f"{dz} {dr}", bins=f"{nz} {nr} 1",
                        extra=["fluence", f"beam disk {wide}", f"map {nx} {ny} {dx} {dy} volume top={raised}"], surfaces={0: "b 2  -0.1 0.2  0 1"})
    runs = [found for _, found in sections_of(text)]

    def light_of(r, top):  # mean over the depths of a bin at r
        surface = max(0, 0.1 - r / 2)
        air = min(max(surface - top, 0), dz)
        return (air + (math.exp(-mua * max(top - surface, 0)) - math.exp(-mua * max(top + dz - surface, 0))) / mua) / dz

    steps = 400
    for i in range(nr * nz):
        ir, iz = divmod(i, nz)  # the mean over the ring, by r dr
        truth = statistics.fmean(light_of(math.sqrt((ir * dr) ** 2 + (k + 0.5) / steps * (2 * ir + 1) * dr * dr), iz * dz) for k in range(steps))
        spread(verdict, f"pit of {mua}, bin {i}", [found["phi_rz"][i] * math.pi * wide**2 for found in runs], truth)
    steps = 24
    for i in range(nx * ny * nz):
        x, y = (i % nx - nx / 2) * dx, (i // nx % ny - ny / 2) * dy
        truth = statistics.fmean(light_of(math.hypot(x + (k % steps + 0.5) / steps * dx, y + (k // steps + 0.5) / steps * dy), raised + i // (nx * ny) * dz)
                                 for k in range(steps * steps))
        spread(verdict, f"pit of {mua}, voxel {i}", [found["phi_xyz"][i] * math.pi * wide**2 for found in runs], truth)


def glass(verdict):
    """Tests a plate between equal media, so that nothing comes back from below. d and u are the light that flies down and up
    in the plate."""
    n = 1.5
    r = ((n - 1) / (n + 1)) ** 2
    down = (1 - r) / (1 - r * r)
    found = sections_of(cml.mci([f"{n} 0 0 0 0.1", "1 10 0 0 1"], photons=4000, grid="0.05 0.1", bins="2 1 1",
                                extra=["fluence", "map 1 1 0.2 0.2 volume top=-0.1"]))[0][1]
    for i in range(2):
        verdict.z(f"glass, bin {i}", found["phi_z"][i], max(found["se_phi_z"][i], 1e-6), down * (1 + r))
    for i in range(2):  # air above: light that comes, and light that goes up again
        verdict.z(f"air above glass, voxel {i}", found["phi_xyz"][i] * 0.04, max(found["se_phi_xyz"][i] * 0.04, 1e-6), 1 + 2 * r / (1 + r))


def coverage(verdict, sampling, count):
    text = cml.repeated(count, ["1.4 1 50 0.8 0.1"], photons=3000, grid="0.02 0.02", bins="5 5 1", extra=["fluence", "map 4 4 0.02 0.02 volume"])
    runs = [found for _, found in sections_of(text, "--sampling", sampling)]
    for keys in (("phi_rz", "phi_z"), ("phi_xyz",)):
        coverage_of(verdict, f"{sampling}, {keys[-1]}", runs, keys)


def coverage_of(verdict, name, runs, keys):
    count = len(runs)
    within = tried = 0
    for key in keys:
        for i in range(len(runs[0][key])):
            values = [found[key][i] for found in runs]
            for k, found in enumerate(runs):
                others = (sum(values) - values[k]) / (count - 1)
                within += abs(values[k] - others) < found["se_" + key][i] * math.sqrt(1 + 1 / (count - 1))
                tried += 1
    verdict.check(f"errors, {name}", abs(within / tried - 0.683) < 0.05, f"{within} of {tried} within one error")
    print(f"errors of fluence, {name}: {within / tried:.3f} of {tried} within one")


def compare(verdict):
    turbid(verdict)
    furnace(verdict, "clear layer", [0], 4 * 1.5**2 * (1 - math.sqrt(1 - 1 / 1.5**2)))
    furnace(verdict, "clear layer under a turbid one", [1000, 0], 4 * 1.5**2)
    pit(verdict, 10)
    pit(verdict, 40)
    glass(verdict)


def gates(verdict):
    """Tests that the absorption of a layer in a gate is mua times its fluence in that gate, for a dense layer and for marks
    in a thin one. Bins over r end where next to no light comes."""
    layers, mua, dr, width = ["1.4 2 100 0.9 0.1", "1.4 2 5 0.8 0.2"], 2, 0.2, 4
    extra = ["beam disk 0.1", f"time {10 * width} 10", "fluence time"]
    runs = sections_of(cml.repeated(RUNS, layers, photons=1000, grid=f"0.01 {dr}", bins="30 30 1", extra=extra))
    ring = [math.pi * dr * dr * (2 * i + 1) for i in range(30)]
    for record, found in runs:
        cml.check_balance(verdict, "gates", record)
        for i, whole in enumerate(found["phi_rz"]):
            total = sum(found["phi_rzt"][10 * i:10 * i + 10]) * width + found["phi_rzt_later"][i]
            verdict.check("gates", abs(total - whole) <= 1e-9 * whole, f"bin {i} sums to {total}, not {whole}")
    for layer, depths in enumerate((range(10), range(10, 30))):
        for gate in range(10):
            absorbed = [sum(ring[r] * 0.01 * mua * found["phi_rzt"][(30 * r + z) * 10 + gate] for r in range(30) for z in depths) for _, found in runs]
            spread(verdict, f"layer {layer + 1}, gate {gate}", [a - found["A_lt"][10 * layer + gate] for a, (_, found) in zip(absorbed, runs)], 0,
                   rounding=1e-6 * statistics.fmean(absorbed))


def main():
    """Runs all tests, or only the last one with a given number of runs."""
    verdict = cml.Verdict("fluence")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS
    for sampling in ("random", "lattice"):
        coverage(verdict, sampling, count)
    if len(sys.argv) == 1:
        compare(verdict)
        gates(verdict)
    verdict.finish(limit=6)  # Student's distribution with 29 degrees, 200 values at 1e-4 in all


main()
