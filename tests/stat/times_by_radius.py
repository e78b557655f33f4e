"""Tests light that leaves by radius and time (`time T1 N radii`) against results that share nothing with the program.

- A half space, mua 0, mus' 10/cm, g 0.8, n 1.4, and a slab of two transport lengths, against a small Monte Carlo in numpy
  below. Groups of bins, N = 1e5 packets of the program and 4e4 of the other; statistic: z by the program's errors and
  Poisson's, level 1e-4 over all.
- The half space where diffusion holds, 0.5 to 1.2 cm and 150 to 300 ps: A. Kienle, M. S. Patterson, J. Opt. Soc. Am. A 14,
  246-254 (1997), within 6 %.
- The half space again, against the published table of the Virtual Tissue Simulator (VTS, below), 1e8 packets, from 20 ps on.
  Earlier the table lies 1 to 2 % above the program, and above the small Monte Carlo here, too.
- Sums over r are Rd_t and Tt_t; sums over gates with later light are Rd_r and Tt_r, to 1e-12: both engines, rows of a sweep,
  threads."""
import math
import os
import sys
import tempfile

try:
    import numpy as np
except ImportError:  # like in lib/cml.py: this Python need not have it
    other = os.environ.get("CLUSTERMCML_PYTHON", "/usr/bin/python3")
    if sys.executable == other:
        sys.exit(77)
    os.execv(other, [other, *sys.argv])

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

C = 0.0299792458  # speed of light, cm/ps
N_IN, MUS, G = 1.4, 50.0, 0.8
SPECULAR = ((N_IN - 1) / (N_IN + 1)) ** 2
DR, NR = 0.1, 20
AREA = 2 * math.pi * (np.arange(NR) + 0.5) * DR * DR

# Packets of 1e8 that leave between these radii [DR] and times [ps], each of the weight 1 - SPECULAR. Sums of bins of the table ROfRhoAndTime in
# src/Vts/Modeling/Resources/ReferenceData/N1e8mua0musp1g0p8dr0p2dt0p005 of github.com/VirtualPhotonics/VTS (MIT License), the reference of
# its scaled Monte Carlo (A. Kienle, M. S. Patterson, Phys. Med. Biol. 41, 2221-2227 (1996)).
VTS_RADII, VTS_TIMES, VTS_PACKETS = (0, 1, 2, 4, 6, 10, 20), (20, 40, 70, 150, 300), 1e8
VTS = ((1459757, 693216, 488821, 188795), (3621804, 1851100, 1367890, 545829), (6187329, 4773954, 4274692, 1928833),
       (941183, 2866007, 4173942, 2459570), (14874, 768550, 3699573, 4061604), (0, 1981, 455822, 2148647))


def reflectance(cosine, n_out):
    """Returns Fresnel's reflectance of unpolarised light from inside."""
    sine = np.minimum(N_IN / n_out * np.sqrt(np.maximum(0, 1 - cosine ** 2)), 1)
    other = np.sqrt(1 - sine ** 2)
    s = ((N_IN * cosine - n_out * other) / (N_IN * cosine + n_out * other)) ** 2
    p = ((N_IN * other - n_out * cosine) / (N_IN * other + n_out * cosine)) ** 2
    return np.where(sine < 1, (s + p) / 2, 1)


def turned(u, rng):
    """Returns directions after scattering by Henyey and Greenstein, about the old directions, by an orthonormal frame of each."""
    n = u.shape[1]
    cosine = (1 + G * G - ((1 - G * G) / (1 - G + 2 * G * rng.random(n))) ** 2) / (2 * G)
    phi = 2 * math.pi * rng.random(n)
    helper = np.where(np.abs(u[2]) < 0.9, np.array([[0.0], [0], [1]]), np.array([[1.0], [0], [0]]))
    a = np.cross(helper, u, axis=0)
    a /= np.linalg.norm(a, axis=0)
    b = np.cross(u, a, axis=0)
    sine = np.sqrt(1 - cosine ** 2)
    new = cosine * u + sine * (np.cos(phi) * a + np.sin(phi) * b)
    return new / np.linalg.norm(new, axis=0)


def own_flights(d, n_below, end, packets, seed):
    """Returns radius and time of photons that leave a layer before `end` [ps], above and below."""
    rng = np.random.default_rng(seed)
    p, u, path, out = np.zeros((3, packets)), np.zeros((3, packets)), np.zeros(packets), ([], [])
    u[2] = 1
    left = rng.exponential(1 / MUS, packets)
    while p.shape[1]:
        wall = np.where(u[2] > 0, d, 0.0)
        with np.errstate(divide="ignore"):
            way = np.where(u[2] != 0, (wall - p[2]) / u[2], math.inf)
        hits = way < left
        step = np.where(hits, way, left)
        p, path, left = p + step * u, path + step, left - step
        p[2, hits] = wall[hits]
        cosine = np.abs(u[2])
        passes = hits & (rng.random(hits.size) >= np.where(u[2] > 0, reflectance(cosine, n_below), reflectance(cosine, 1.0)))
        for side in (0, 1):
            here = passes & ((u[2] > 0) == bool(side))
            out[side].append(np.stack([np.hypot(p[0, here], p[1, here]), path[here] * N_IN / C]))
        u[2, hits & ~passes] *= -1
        scatters = ~hits
        u[:, scatters] = turned(u[:, scatters], rng)
        left = np.where(scatters, rng.exponential(1 / MUS, hits.size), left)
        stay = ~passes & (path * N_IN / C < end)
        p, u, path, left = p[:, stay], u[:, stay], path[stay], left[stay]
    return [np.concatenate(one, axis=1) for one in out]


def text_of(d, n_below, end, gates, photons, bins=f"10 {NR} 1"):
    return cml.mci([f"{N_IN} 0 {MUS:g} {G:g} {d}"], photons=photons, grid=f"0.5 {DR}", bins=bins, n_below=n_below, extra=[f"time {end} {gates} radii"])


def fields_of(text, *options):
    """Returns the arrays of the run's .h5."""
    with tempfile.TemporaryDirectory() as keep:
        record = cml.run(text, *options, keep=keep)[0]
        return {name: np.array(values) for name, values in cml.read_h5(os.path.splitext(record["output"])[0] + ".h5").items()}


def grid(found, name):
    return found[name].reshape(NR, -1)


def same_sums(verdict, name, found, width, sides=("Rd", "Tt")):
    for side in sides:
        shares = grid(found, side + "_rt") * AREA[:, None] * width
        later = found[side + "_rt_later"] * AREA
        for what, sums, known in (("over r", shares.sum(0), found[side + "_t"] * width), ("later", later.sum(), found[side + "_t_later"]),
                                  ("over gates", shares.sum(1) + later, found[side + "_r"] * AREA)):
            verdict.check(f"{name}: {side}_rt {what}", np.all(np.abs(sums - known) <= 1e-12 * np.max(known)) and np.max(known) > 0, f"{sums} {known}")


def against_own_flights(verdict, name, found, d, n_below, end, packets):
    gates = grid(found, "Rd_rt").shape[1]
    own = own_flights(d, n_below, end, packets, 58)
    rs, ts = [0, 1, 2, 4, 6, 10, NR - 1], [0, gates // 15, gates // 7, gates // 4, gates // 2, gates]
    for side, left in zip(("Rd", "Tt"), own):
        measure = AREA[:, None] * end / gates
        shares, errors = grid(found, side + "_rt") * measure, grid(found, side + "_rt_se") * measure
        counts = np.histogram2d(left[0], left[1], bins=(np.arange(NR) * DR, np.linspace(0, end, gates + 1)))[0]
        for r0, r1 in zip(rs, rs[1:]):
            for t0, t1 in zip(ts, ts[1:]):
                here = np.s_[r0:r1, t0:t1]
                n = counts[here].sum()
                if n >= 30:
                    verdict.z(f"{name} {side} r {r0 * DR:.1f} to {r1 * DR:.1f} t {t0 * end / gates:g} to {t1 * end / gates:g}", shares[here].sum(),
                              math.sqrt((errors[here] ** 2).sum()), n / packets * (1 - SPECULAR), math.sqrt(n) / packets)


def against_table(verdict, found, end):
    gates = grid(found, "Rd_rt").shape[1]
    measure = AREA[:, None] * end / gates
    shares, errors = grid(found, "Rd_rt") * measure, grid(found, "Rd_rt_se") * measure
    for r0, r1, row in zip(VTS_RADII, VTS_RADII[1:], VTS):
        for t0, t1, n in zip(VTS_TIMES, VTS_TIMES[1:], row):
            here = np.s_[r0:r1, t0 * gates // end:t1 * gates // end]
            if n > 1e4:
                verdict.z(f"table r {r0 * DR:.1f} to {r1 * DR:.1f} t {t0} to {t1}", shares[here].sum(), math.sqrt((errors[here] ** 2).sum()),
                          n / VTS_PACKETS * (1 - SPECULAR), math.sqrt(n) / VTS_PACKETS)


def diffusion(rho, t):
    """Returns the result of Kienle and Patterson for n 1.4: 0.118 fluence + 0.306 flux, extrapolated boundary."""
    d, z0, v = 1 / (3 * MUS * (1 - G)), 1 / (MUS * (1 - G)), C / N_IN
    zb = 2 * d * (1 + 0.493) / (1 - 0.493)
    near, far = (np.exp(-(rho ** 2 + z ** 2) / (4 * d * v * t)) for z in (z0, z0 + 2 * zb))
    fluence = v * (4 * math.pi * d * v * t) ** -1.5 * (near - far)
    flux = 0.5 * (4 * math.pi * d * v) ** -1.5 * t ** -2.5 * (z0 * near + (z0 + 2 * zb) * far)
    return (1 - SPECULAR) * (0.118 * fluence + 0.306 * flux)


def against_diffusion(verdict, found, end):
    gates = grid(found, "Rd_rt").shape[1]
    r, t = (np.arange(NR) + 0.5) * DR, (np.arange(gates) + 0.5) * end / gates
    for r0, r1 in ((5, 8), (8, 12)):
        for t0, t1 in ((150, 200), (200, 300)):
            here = np.ix_(range(r0, r1), [i for i in range(gates) if t0 < t[i] < t1])
            weight = (AREA[:, None] * np.ones(gates))[here]
            value, error = (grid(found, "Rd_rt")[here] * weight).sum(), math.sqrt(((grid(found, "Rd_rt_se")[here] * weight) ** 2).sum())
            truth = (diffusion(r[:, None], t[None, :])[here] * weight).sum()
            print(f"  diffusion, r {r0 * DR:.1f} to {r1 * DR:.1f}, {t0} to {t1} ps: {value / truth - 1:+.3f} +- {error / truth:.3f}")
            verdict.check("diffusion", abs(value / truth - 1) < 0.06 + 4 * error / truth, f"{value} +- {error}, expected {truth}")


def main():
    verdict = cml.Verdict("light by radius and time")
    end, gates = 300, 30
    deep = fields_of(text_of(3.3, N_IN, end, gates, 100000))  # light that comes back from 3.3 cm has flown for 308 ps
    slab = fields_of(text_of(0.2, 1.0, 100, gates, 100000))
    against_own_flights(verdict, "half space", deep, 3.3, N_IN, end, 40000)
    against_own_flights(verdict, "slab", slab, 0.2, 1.0, 100, 40000)
    against_diffusion(verdict, deep, end)
    against_table(verdict, deep, end)
    same_sums(verdict, "half space", deep, end / gates, ["Rd"])
    same_sums(verdict, "slab", slab, 100 / gates)
    few = text_of(0.2, 1.0, 20, gates, 3000)
    one = fields_of(few, "--threads", "1")
    for name, found in (("reference", fields_of(few, "--engine", "reference")), ("threads", fields_of(few, "--threads", "3", "--chunk", "77"))):
        same_sums(verdict, name, found, 20 / gates)
        if name == "threads":
            verdict.check("threads", all(np.array_equal(one[key], found[key]) for key in one if "_rt" in key))
    large = fields_of(text_of(0.2, 1.0, 20, 4000, 1000))
    same_sums(verdict, "many gates", large, 20 / 4000)
    verdict.check("many gates", "Rd_rt_se" not in large and "Rd_rt_later_se" not in large and "A_rz_se" in large, "errors")
    with tempfile.TemporaryDirectory() as keep:
        table = os.path.join(keep, "t.csv")
        with open(table, "w", encoding="utf-8") as file:
            file.write("layer1.mua\n0\n3\n")
        cml.run(few, "--sweep", table, "--reweight", keep=keep)
        for row in (1, 2):
            found = {key: np.array(values) for key, values in cml.read_h5(os.path.join(keep, f"out-000{row}.h5")).items()}
            same_sums(verdict, f"row {row}", found, 20 / gates)
    verdict.finish()


if __name__ == "__main__":
    main()
