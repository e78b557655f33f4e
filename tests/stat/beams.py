"""Tests beam disk, gaussian, at, angle, azimuth, on planes and on a mesh.

- Convolution: on a flat scene a packet that starts at s leaves at s + d, where d does not depend on s. Rd(r) and Tt(r) of any
  beam at normal incidence therefore follow from those of the pencil. P(|s + d| <= rho) for given |s| and |d| is the share of
  a circle, acos((s^2 + d^2 - rho^2) / (2 s d)) / pi. |s| runs through the beam's quantiles: R sqrt(u) for a disk, R
  sqrt(-ln(1 - u) / 2) for the irradiance exp(-2 r^2 / R^2). The results are compared with the beams' own runs.
- Slanted light on an absorbing plate: Rsp, Rd, Tt by Fresnel and Snell, and the ring in which the light leaves.
- The angle at which light leaves: a plate returns the beam's own. A cone below, lit along its axis, turns light by asin(n sin
  a) - a from the vertical, in the direction of the cone's normal.
- Turning the beam about z on a flat scene, and mirroring mesh and beam together, change nothing (`compare`, p > 1e-4).
N = 2.5e5 (ALL_CASES: 1e6) for profiles; statistic: z of groups of bins, level 1e-4 over all."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import pairs  # noqa: E402
import profiles  # noqa: E402

PHOTONS, DR, NR, GROUP = cml.repeats(1000000), 0.0025, 240, 12
LAYERS = ["1.4 1 60 0.8 0.1"]
QUANTILES = [(i + 0.5) / 400 for i in range(400)]


def scene(beam="", surfaces=None, layers=LAYERS, name="out.mco", photons=PHOTONS):
    return cml.mci(layers, name=name, photons=photons, grid=f"0.01 {DR}", bins=f"10 {NR} 1", surfaces=surfaces,
                   extra=[beam] if beam else ())


def fly(beam, seed):
    with tempfile.TemporaryDirectory() as keep:
        record = cml.run(scene(beam), "--seed", seed, "--ignore-absorption", keep=keep)[0]
        return record, cml.read_sections(record["output"])


def disk(radius, x=0.0, y=0.0):
    """Returns |s| of points spread over a disk around (x, y): radii by quantiles, angles by the golden section."""
    points = [(radius * math.sqrt(u), 2.399963229728653 * i) for i, u in enumerate(QUANTILES)]
    return [math.hypot(x + r * math.cos(a), y + r * math.sin(a)) for r, a in points]


def gaussian(radius):
    return [radius * math.sqrt(-0.5 * math.log1p(-u)) for u in QUANTILES]


def within(s, d, rho):
    """Returns P(|s + d| <= rho) for a uniform angle between s and d."""
    if s + d <= rho:
        return 1.0
    if abs(s - d) >= rho:
        return 0.0
    return math.acos((s * s + d * d - rho * rho) / (2 * s * d)) / math.pi


def kernel(starts):
    """Returns K[j][i]: the share of the pencil's light in ring i that a beam with these starts has in group j of rings."""
    edges = [GROUP * DR * j for j in range(NR // GROUP + 1)]
    cumulative = [[sum(within(s, (i + 0.5) * DR, rho) for s in starts) / len(starts) for i in range(NR - 1)]
                  for rho in edges]
    return [[b - a for a, b in zip(low, high)] for low, high in zip(cumulative, cumulative[1:])]


def convolution(verdict, name, beam, starts, pencil, seed):
    record, sections = fly(beam, seed)
    cml.check_balance(verdict, name, record)
    shares = kernel(starts)
    for key in ("Rd_r", "Tt_r"):
        ours = profiles.ring_sums(sections[key], DR, GROUP)
        errors = profiles.ring_errors(sections["se_" + key], DR, GROUP)
        rings = profiles.ring_sums(pencil[key], DR, 1)
        ring_errors = profiles.ring_errors(pencil["se_" + key], DR, 1)
        for j in range(NR // GROUP - 4):  # groups that lack light from beyond the pencil's last rings are cut off
            expected = sum(k * ring for k, ring in zip(shares[j], rings))
            spread = math.sqrt(sum((k * error) ** 2 for k, error in zip(shares[j], ring_errors)))
            if ours[j] * PHOTONS > 300:
                verdict.z(f"{name} {key} r = {j * GROUP * DR:.3f}..", ours[j], errors[j], expected, spread)


def plate(verdict, angle, azimuth, at):
    """Tests a plate with n 1.5, mua 3, mus 0, d 0.2, whose totals and exit places are known in closed form."""
    n, mua, d, photons = 1.5, 3.0, 0.2, 400000
    ci = math.cos(math.radians(angle))
    st = math.sin(math.radians(angle)) / n
    ct = math.sqrt(1 - st * st)
    R = 0.5 * (((ci - n * ct) / (ci + n * ct)) ** 2 + ((ct - n * ci) / (ct + n * ci)) ** 2)
    e = math.exp(-mua * d / ct)
    name = f"plate {angle} {azimuth} {at}"
    beam = f"beam pencil at={at[0]},{at[1]} angle={angle} azimuth={azimuth}"
    with tempfile.TemporaryDirectory() as keep:
        record = cml.run(scene(beam, layers=[f"{n} {mua} 0 0 {d}"], photons=photons), "--seed", 5, keep=keep)[0]
        sections = cml.read_sections(record["output"])
    cml.check_balance(verdict, name, record)
    back = R * (1 - R) ** 2 * e * e / (1 - R * R * e * e)
    through = (1 - R) ** 2 * e / (1 - R * R * e * e)
    for key, truth in (("Rsp", R), ("Rd", back), ("Tt", through)):
        verdict.z(f"{name} {key}", record[key], math.sqrt(truth * (1 - truth) / photons), truth)
    for key, passes in (("Tt_r", 1), ("Rd_r", 2)):  # first exits: one and two crossings of the plate
        along = passes * d * st / ct
        x = at[0] + along * math.cos(math.radians(azimuth))
        y = at[1] + along * math.sin(math.radians(azimuth))
        weights = profiles.ring_sums(sections[key], DR, 1)
        ring = weights.index(max(weights))
        verdict.check(f"{name} {key}", ring == int(math.hypot(x, y) / DR), f"ring {ring}, {math.hypot(x, y) / DR:.2f}")


def angles(verdict):
    """Tests angles of exit from clear media, 3 degrees a bin. All light that leaves a plate does so in the beam's bin. Light
    leaves the cone in the bin of its deviation if it has not been reflected before: more than nine tenths at n = 1.33."""
    na = 30
    step = 90 / na
    cone, n = 10, 1.33  # slope angle of the cone (degrees), index
    turned = math.degrees(math.asin(n * math.sin(math.radians(cone)))) - cone
    below = {1: f"b 2 {-0.5 * math.tan(math.radians(cone)):.17g} 0.5 0 0"}
    cases = [(f"plate {angle}", f"beam pencil angle={angle}", {}, angle, 1 - 1e-9) for angle in (10, 44, 46, 88)]
    cases.append(("axicon", "beam pencil at=0.12,-0.09", below, turned, 0.9))
    for name, beam, surfaces, angle, share in cases:
        text = cml.mci([f"{n} 0 0 0 0.5"], photons=20000, bins=f"1 1 {na}", surfaces=surfaces, extra=[beam])
        with tempfile.TemporaryDirectory() as keep:
            record = cml.run(text, "--seed", 6, keep=keep)[0]
            sections = cml.read_sections(record["output"])
        cml.check_balance(verdict, name, record)
        for key in ("Tt_a", "Rd_a") if not surfaces else ("Tt_a",):
            # weights: an .mco divides a bin by 2 pi sin(a) da
            weights = [x * math.sin(math.radians((i + 0.5) * step)) for i, x in enumerate(sections[key])]
            held = weights[int(angle / step)] / sum(weights)
            verdict.check(f"{name} {key}", held >= share, f"{held:.4f} of the light at {angle:.1f} degrees")


def mirrored(path, out):
    """Writes the mesh with the sign of y reversed."""
    with open(path, encoding="utf-8") as file, open(out, "w", encoding="utf-8") as mirror:
        for line in file:
            word = line.split()
            mirror.write(f"v {word[1]} {-float(word[2])} {word[3]}\n" if word[:1] == ["v"] else line)


def agree(verdict, name, first, second, keep):
    """Compares two scenes that must give the same results, with different random numbers."""
    paths = [cml.run(text, "--seed", seed, keep=keep)[0]["output"] for seed, text in ((31, first), (32, second))]
    record = pairs.compare_all([paths])[0]
    print(f"{name}: p = {record['p']:.3g} over {record['tests']} tests")
    verdict.check(name, record["p"] > 1e-4 and record["tests"] > 100, f"p = {record['p']}, {record['tests']} tests")
    return record


def symmetries(verdict):
    mesh = os.path.join(os.path.dirname(cml.TESTS), "meshes", "wedge.obj")
    with tempfile.TemporaryDirectory() as keep:
        mirrored(mesh, os.path.join(keep, "mirror.obj"))
        turned = [scene(f"beam gaussian 0.05 angle=50 azimuth={azimuth}", name=f"{azimuth}.mco") for azimuth in (0, 77)]
        agree(verdict, "turned about z", *turned, keep)
        beams = [f"beam disk 0.04 at=0.05,{sign}0.12 angle=35 azimuth={sign}60" for sign in ("", "-")]
        surfaces = [{0: f'm "{mesh}"'}, {0: 'm "mirror.obj"'}]
        scenes = [scene(b, s, name=f"m{i}.mco") for i, (b, s) in enumerate(zip(beams, surfaces))]
        agree(verdict, "mirrored", *scenes, keep)
        # the test must notice a mirrored mesh whose beam is not mirrored
        wrong = scene(beams[0], surfaces[1], name="m2.mco")
        path = cml.run(wrong, "--seed", 33, keep=keep)[0]["output"]
        p = pairs.compare_all([(os.path.join(keep, "m0.mco"), path)])[0]["p"]
        verdict.check("mesh mirrored, beam not", p < 1e-6, f"p = {p}")


def main():
    verdict = cml.Verdict("beams")
    record, pencil = fly("", 41)
    cml.check_balance(verdict, "pencil", record)
    convolution(verdict, "disk", "beam disk 0.1", disk(0.1), pencil, 42)
    convolution(verdict, "gaussian", "beam gaussian 0.1", gaussian(0.1), pencil, 43)
    convolution(verdict, "at", "beam pencil at=0.12,-0.16", [0.2], pencil, 44)
    convolution(verdict, "disk at", "beam disk 0.08 at=-0.1,0.05", disk(0.08, -0.1, 0.05), pencil, 45)
    plate(verdict, 20, 30, (0.05, -0.02))
    plate(verdict, 55, -110, (0.03, 0.08))
    plate(verdict, 80, 200, (0.01, 0.0))
    angles(verdict)
    symmetries(verdict)
    verdict.finish(profiles.student_limit(len(verdict.rows)))


main()
