"""Tests derivatives of totals by mua and mus (--derivatives) against central differences.

For plane scenes the differences are those of adding-doubling. For rings, a backing, a body and a beam from the side they are
those of flights with the same random numbers. Derivatives of profiles are compared with those of their totals and with these
flights.
N = 4e4 packets a stack, 4e3 to 2e4 if they interact hundreds of times. Statistic: z of dRd, dA, dTt and of the absorption in
layers and bodies; level 1e-4 over all. Steps are 2 % for adding-doubling and 20 % for flights, whose bias, some 1 % of the
derivative, counts as an error.
With the argument `long`: ten times as many packets, and 400 runs of a thin and a thick stack, in which 68 % and 95 % of
derivatives lie within one and two standard errors of the truth."""
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402

LONG = "long" in sys.argv[1:]
TIMES = 10 if LONG else 1
GRID = {"bins": "10 20 5", "grid": "0.05 0.05"}
# name: layers, photons; thickness from 0.1 to 1000 mean free paths
STACKS = {
    "thin": (["1.4 0.5 1 0.3 0.1"], 40000),
    "few": (["1.3 2 20 0.7 0.1", "1.5 0.5 5 0 0.3"], 40000),
    "dark": (["1.4 30 10 0.9 0.2"], 40000),
    "glass": (["1.37 1 40 0.8 0.05", "1.5 0.2 0 0 0.1", "1.4 0.5 60 0.9 0.2"], 40000),
    "skin": (["1.4 5 100 0.8 0.02", "1.37 0.5 150 0.85 0.2"], 20000),
    "thick": (["1.4 0.1 100 0.5 1"], 10000),
    "deep": (["1.33 0.5 1000 0.9 1"], 4000),
}
SURFACE = "b 4 0.05 0.1 0.15 0.05 0.04 0.02 -0.03 0"
ROUGH = cml.mci(["1.4 0.5 10 0.8 0.2", "1.33 0.3 10 0.9 0.4\ni sphere 0.02 0 0.35 0.08 1.5 1 30 0.5"], photons=40000 * TIMES,
                surfaces={0: SURFACE}, n_below=1.5, **GRID,
                extra=["beam disk 0.2 angle=30", "detector ring 0 0.15 name=near", "detector disk 0.3 na=0.8 at=0.4,0 name=far"])
BACKED = cml.mci(["1.4 0.5 10 0.5 0.2", "1.33 0.1 5 0.5 0.2\nbacking 0.7 lambertian"], photons=40000 * TIMES, surfaces={1: SURFACE}, **GRID)
TOTALS = ("Rd", "A", "Tt")


def names_of(layers, bodies=0):
    return [f"layer{i + 1}" for i in range(layers)] + [f"body{i + 1}" for i in range(bodies)]


def value_of(text, medium, x):
    """Returns the number x (mua or mus) of a medium in the scene's text."""
    line = [line for line in text.splitlines() if line.startswith("i ")] if medium.startswith("body") else \
        [line for line in text.splitlines() if line.count(" ") == 4 and line[0].isdigit()]
    words = line[int(medium[-1]) - 1].split()
    return float(words[len(words) - 4 + ("mua", "mus").index(x) + (medium.startswith("body"))])


def exact_difference(text, name, value):
    """Returns central differences of totals and layers, each with its possible error."""
    h = 0.02 * value
    low, high = (cml.exact(text, "--set", f"{name}={value + s * h!r}") for s in (-1, 1))
    of = {key: ((high[key] - low[key]) / (2 * h), (high[key + "_error"] + low[key + "_error"]) / (2 * h)) for key in TOTALS}
    return of, [((b - a) / (2 * h), (low["A_error"] + high["A_error"]) / (2 * h)) for a, b in zip(low["A_l"], high["A_l"])]


def derived(text, keep, *options):
    record = cml.run(text, "--derivatives", *options, keep=keep)[0]
    return record, cml.read_sections(record["output"])


def against_exact(verdict):
    for name, (layers, photons) in STACKS.items():
        text = cml.mci(layers, photons=photons * TIMES, **GRID)
        with tempfile.TemporaryDirectory() as keep:
            record, sections = derived(text, keep, "--seed", 3)
        cml.check_balance(verdict, name, record)
        media = names_of(len(layers))
        for k, medium in enumerate(media):
            for x in ("mua", "mus"):
                value = value_of(text, medium, x)
                if value == 0:
                    verdict.check(f"{name} {medium}", record[f"dRd_d{x}"][k] is None, "a number without mus")
                    continue
                totals, absorbed = exact_difference(text, f"{medium}.{x}", value)
                for key in TOTALS:
                    of = f"d{key}_d{x}"
                    verdict.z(f"{name} {of} {medium}", record[of][k], record[of + "_se"][k], *totals[key])
                for i, truth in enumerate(absorbed):
                    at = i * len(media) + k
                    verdict.z(f"{name} dA_{i + 1}_d{x} {medium}", sections[f"dA_l_d{x}"][at], sections[f"se_dA_l_d{x}"][at], *truth)


def profile_sums(sections, key, layers, column, columns):
    """Returns the sum of a profile over r, in bins 0.05 cm wide."""
    return sum(2 * math.pi * (i + 0.5) * 0.05 ** 2 * value for i, value in enumerate(sections[key][column::columns]))


def against_flights(verdict, name, text, media, seed):
    """Compares derivatives with differences of flights. The errors of both count, and a fiftieth of the difference, because
    flights that are 40 % apart only approximate a derivative."""
    with tempfile.TemporaryDirectory() as keep, tempfile.TemporaryDirectory() as other:
        record, sections = derived(text, keep, "--seed", seed)
        cml.check_balance(verdict, name, record)
        for k, medium in enumerate(media):
            for x in ("mua", "mus"):
                value = value_of(text, medium, x)
                h = 0.2 * value
                low, high = (cml.run(text, "--seed", seed + 1, "--set", f"{medium}.{x}={value + s * h!r}", keep=other)[0] for s in (-1, 1))
                for key in TOTALS + (("A_backing",) if "A_backing" in record else ()):
                    of, truth = f"d{key}_d{x}", (high[key] - low[key]) / (2 * h)
                    spread = math.hypot(low[key + "_se"], high[key + "_se"]) / (2 * h)
                    verdict.z(f"{name} {of} {medium}", record[of][k], record[of + "_se"][k], truth, math.hypot(spread, truth / 50))
                for key in ("detector_near", "detector_far") if "detector_near" in low else ():
                    truth, spread = (high[key] - low[key]) / (2 * h), math.hypot(low[key + "_se"], high[key + "_se"]) / (2 * h)
                    own, error = sections[f"{key}_d{x}"][k], sections[f"se_{key}_d{x}"][k]
                    verdict.z(f"{name} {key}_d{x} {medium}", own, error, truth, math.hypot(spread, truth / 50))
                for key in ("Rd", "Tt"):
                    whole, bins = record[f"d{key}_d{x}"][k], profile_sums(sections, f"d{key}_r_d{x}", 0, k, len(media))
                    verdict.check(f"{name} d{key}_r_d{x} {medium}", abs(bins - whole) <= 2e-5 * abs(whole) + 1e-9, f"sums to {bins}, not {whole}")


def coverage(verdict):
    """Tests 400 runs of 5000 packets: the shares of derivatives within one and two errors of the truth."""
    runs = 400
    for name in ("few", "thick"):
        layers = STACKS[name][0]
        inside, count = [0, 0], 0
        records = cml.run(cml.repeated(runs, layers, photons=5000 if name == "few" else 1000, **GRID), "--derivatives")
        for k, medium in enumerate(names_of(len(layers))):
            for x in ("mua", "mus"):
                totals, _ = exact_difference(cml.mci(layers, **GRID), f"{medium}.{x}", value_of(cml.mci(layers, **GRID), medium, x))
                for key in ("Rd", "Tt"):
                    off = [abs(r[f"d{key}_d{x}"][k] - totals[key][0]) / r[f"d{key}_d{x}_se"][k] for r in records]
                    inside = [inside[i] + sum(z <= i + 1 for z in off) for i in range(2)]
                    count += len(off)
        shares = [100 * n / count for n in inside]
        print(f"{name}: {shares[0]:.1f} % within one standard error, {shares[1]:.1f} % within two, of {count}")
        verdict.check(f"coverage {name}", abs(shares[0] - 68.3) < 5 and abs(shares[1] - 95.4) < 3, f"{shares}")


def main():
    verdict = cml.Verdict("derivatives")
    against_exact(verdict)
    against_flights(verdict, "rough", ROUGH, names_of(2, 1), 11)
    against_flights(verdict, "backed", BACKED, names_of(2), 13)
    if LONG:
        coverage(verdict)
    verdict.finish()


main()
