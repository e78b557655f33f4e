"""Tests Monte Carlo against adding-doubling, two methods that share no code but the reader of .mci files.

The scenes are those that no table of other programs covers (slanted light, negative g, clear layers between others, dense
outer media), layer by layer. Rough planes share with the packets the walk on facets, but no random number, and neither
directions nor layers.
N = 5e5 packets a scene (with ALL_CASES: 2e6), and 1.5e5 (6e5) between rough planes, where a limit of `exact` is four standard
errors. Statistic: z of Rsp, Rd, A, Tt and of the absorption of each layer, whose error is the bound for weights of at most 1,
which is never too small; level 1e-4 over all. Further runs of `exact` check that a scattering coefficient that is 4 % off
would show, and so would planes that are not rough. Every second scene of rough planes is flown, and all with ALL_CASES."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

PHOTONS, ROUGH_PHOTONS = cml.repeats(2000000), cml.repeats(600000)
# name, layers, index above, index below, angle of the beam in degrees
SCENES = [
    ("slab 60", ["1.4 1 20 0.8 0.1"], 1.0, 1.0, 60),
    ("slab 85", ["1.4 0.5 30 0.9 0.1"], 1.0, 1.0, 85),
    ("matched 45", ["1.0 2 10 0.5 0.2"], 1.0, 1.0, 45),
    ("backward 30", ["1.37 1 15 -0.6 0.1"], 1.0, 1.5, 30),
    ("stack 50", ["1.5 0.1 3 0.8 0.2", "1.33 0.5 1 -0.4 0.3", "1.4 0 20 0.9 0.05"], 1.2, 1.45, 50),
    ("glass 70", ["1.5 0 0 0 0.1", "1.37 0.5 20 0.8 0.2", "1.5 0 0 0 0.1"], 1.0, 1.0, 70),
    ("absorber 40", ["1.4 1 20 0.8 0.05", "1.6 3 0 0 0.1", "1.33 1 10 0 0.1"], 1.0, 1.0, 40),
    ("from oil 55", ["1.33 1 20 0.8 0.1", "1.6 1 10 0.7 0.1"], 1.5, 1.0, 55),
    ("skin 0", ["1.53 0.2 1000 0.9 0.002", "1.34 0.15 400 0.85 0.008", "1.39 1 350 0.95 0.02", "1.4 0.7 200 0.76 0.1"],
     1.0, 1.0, 0),
]
# like SCENES, with the lines of rough boundaries at the end
ROUGH = [
    ("beckmann 0.5", ["1.5 1 20 0.8 0.5"], 1.0, 1.0, 0, {0: "rough beckmann 0.5", 1: "rough beckmann 0.5"}),
    ("ggx 0.05", ["1.5 1 20 0.8 0.5"], 1.0, 1.0, 60, {0: "rough ggx 0.05", 1: "rough ggx 0.05"}),
    ("ggx 2, isotropic", ["1.4 0.5 10 0 0.2"], 1.0, 1.2, 60, {0: "rough ggx 2", 1: "rough ggx 2"}),
    ("from oil", ["1.33 0.3 5 0.3 0.3"], 1.5, 1.0, 0, {0: "rough beckmann 2", 1: "rough beckmann 0.2"}),
    ("clear plates", ["1.5 0 0 0 0.1", "1.37 0.5 20 0.8 0.2", "1.5 0 0 0 0.1"], 1.0, 1.0, 30,
     {0: "rough ggx 0.3", 1: "rough beckmann 0.2", 2: "rough ggx 1", 3: "rough beckmann 0.1"}),
    ("rough inside", ["1.4 1 20 0.8 0.05", "1.6 3 0 0 0.1", "1.33 1 10 0 0.1"], 1.0, 1.33, 60,
     {1: "rough ggx 0.5", 2: "rough beckmann 1"}),
    ("below glass", ["1.5 0 0 0 0.1", "1.37 0.5 20 0.8 0.2"], 1.0, 1.0, 0, {1: "rough beckmann 0.3"}),
    ("mirror", ["1.4 0.5 10 0.5 0.1"], 1.0, 1.0, 45, {0: "rough ggx 0.2", 1: "rough beckmann 0.7\nbacking 0.9 mirror"}),
    ("absorbing plate", ["1.5 0.5 0 0 0.5"], 1.0, 1.0, 60, {0: "rough ggx 0.4", 1: "rough beckmann 0.4"}),
]


def bound(share, photons=PHOTONS):
    """Returns the largest possible error of a mean of scores of at most 1."""
    return (share * (1 - share) / photons) ** 0.5


def compare(verdict, name, text, expected, sigmas=1, photons=PHOTONS):
    with tempfile.TemporaryDirectory() as keep:
        record = cml.run(text, "--seed", 20261122, keep=keep)[0]
        layers = cml.read_sections(record["output"])["A_l"]
    cml.check_balance(verdict, name, record)
    for key in ("Rsp", "Rd", "A", "Tt", "A_backing") if "A_backing" in expected else ("Rsp", "Rd", "A", "Tt"):
        # a share that is split off every packet has no noise, but packets weigh 2^31 units
        error = cml.total_error(record, key, expected[key]) or 1e-9
        verdict.z(f"{name} {key}", record[key], error, expected[key], expected[key + "_error"] / sigmas)
        limit = record["exact_error"] + (expected[key + "_error"] if sigmas > 1 else 1e-7)
        verdict.check(name, abs(record[key + "_exact"] - expected[key]) <= limit,
                      f"{key}: the run says {record[key + '_exact']}, exact {expected[key]}")
    for i, (value, truth) in enumerate(zip(layers, expected["A_l"], strict=True)):
        verdict.z(f"{name} A_l {i + 1}", value, bound(truth, photons) or 1e-9, truth, expected["A_l_error"][i] / sigmas)


def main():
    verdict = cml.Verdict("exact")
    for name, layers, above, below, angle in SCENES:
        text = cml.mci(layers, photons=PHOTONS, n_above=above, n_below=below, extra=[f"beam pencil angle={angle}"])
        compare(verdict, name, text, cml.exact(text))
    for name, layers, above, below, angle, lines in ROUGH[::1 if "ALL_CASES" in os.environ else 2]:
        text = cml.mci(layers, photons=ROUGH_PHOTONS, n_above=above, n_below=below, surfaces=lines,
                       extra=[f"beam pencil angle={angle}"])
        compare(verdict, name, text, cml.exact(text), 4, ROUGH_PHOTONS)
    rough, smooth = (cml.exact(cml.mci(ROUGH[0][1], surfaces=lines)) for lines in (ROUGH[0][5], {}))
    # values of an independent program, each good to some 1e-4
    verdict.check("roughness", abs(rough["Rd"] - smooth["Rd"]) > 6 * bound(rough["Rd"], ROUGH_PHOTONS) and
                  all(abs(rough[key] - value) < 4e-4 for key, value in (("Rsp", 0.0394), ("Rd", 0.1264), ("A", 0.7188), ("Tt", 0.1154))),
                  f"{rough} and {smooth}")
    right, wrong = (cml.exact(cml.mci([f"1.4 1 {mus} 0.8 0.1"], extra=["beam pencil angle=60"])) for mus in (20, 20.8))
    verdict.check("4 % more scattering", abs(right["Rd"] - wrong["Rd"]) > 6 * bound(right["Rd"]),
                  f"Rd {right['Rd']} and {wrong['Rd']}")
    verdict.finish()


main()
