"""Measures the change of results when a plane replaces a curved boundary, on equal photon streams.

The plane is made of level rings, so that it uses as many random numbers as the curved boundary. RUNS runs of a scene in one file, each with its own
streams, are made with both surfaces. They give paired differences of the totals and of every bin of the profiles. The excess of a difference over a
tolerance is measured in standard errors."""
import math
import statistics
import tempfile

import cml

RUNS = 16
TOTALS = ("Rsp", "Rd", "A", "Tt")
PROFILES = ("Rd_r", "Tt_r", "Rd_a", "Tt_a", "A_z", "A_l")
LEAST_SHARE = 0.01  # share of the light: smaller totals and profiles are held to the tolerance of this share
# A plane: level up to a radius that no light reaches. The bump there raises the envelope, beyond which a packet counts as leaked. With an envelope
# no higher than rounding, a packet would leak now and then.
LEVEL = "b 4 0 500 0 0.1 1e-4 0.1 0 1"


class Scene:
    """Layers with one curved boundary. surface: its line; level: the line of the plane; layers: lines of an .mci; at: index of the boundary."""

    def __init__(self, name, surface, layers, level=LEVEL, at=0, beam="pencil", n_above=1.0, n_below=1.0,
                 grid="0.01 0.01", bins="50 50 10"):
        self.name, self.surface, self.level, self.layers, self.at, self.beam = name, surface, level, layers, at, beam
        self.n_above, self.n_below, self.grid, self.bins = n_above, n_below, grid, bins

    def text(self, surface, runs=1):
        """Returns the text of a file that has the scene `runs` times, with `surface` as the line of the boundary."""
        lines = ["1.0", str(runs)]
        for run in range(runs):
            lines += [f"out{run}.mco A", "1000", f"beam {self.beam}", self.grid, self.bins, str(len(self.layers)),
                      str(self.n_above)]
            for i, layer in enumerate(self.layers + [str(self.n_below)]):
                lines += [surface, layer] if i == self.at else [layer]
        return "\n".join(lines) + "\n"


def lens(n, radius, slope):
    """Returns the line of a parabola of n samples, with this slope at its rim."""
    heights = [slope * radius / 2 * (1 - (i / (n - 1)) ** 2) for i in range(n)]
    return f"b {n} " + " ".join(f"{height:.9g} {radius / (n - 1):.9g}" for height in heights)


# Scenes of small height and slope with their tolerances, which a plane would break all the same: grazing light on a slope, light near the critical
# angle, a lens above a long clear layer.
DECEPTIVE = [
    (Scene("grazing", "b 2 0.002 0.05 0 0.05", ["1.4 0.5 0.5 0 1"],
           beam="pencil at=-0.02,0 angle=88.9"), 0.05),
    (Scene("critical", "b 2 0.0015 0.1 0 0.1", ["1.0 0.1 1 0 1"], beam="disk 0.05 angle=42.2",
           n_above=1.5), 0.02),
    (Scene("lens", lens(41, 1, 0.0045), ["1.59 0 0 0 100"], beam="disk 0.9", n_below=1.59,
           grid="1 0.1"), 0.01),
]


def bins_of(scene, record, key):
    """Returns the light in each bin of a profile, as shares of all light."""
    values = cml.read_sections(record["output"])[key]
    dz, dr = map(float, scene.grid.split())
    if key == "A_l":
        return values
    if key == "A_z":
        return [value * dz for value in values]
    if key in ("Rd_r", "Tt_r"):
        return [value * 2 * math.pi * (i + 0.5) * dr * dr for i, value in enumerate(values)]
    step = math.pi / 2 / len(values)
    return [value * 4 * math.pi * math.sin((i + 0.5) * step) * math.sin(step / 2) for i, value in enumerate(values)]


def fly(scene, surface, photons, options=()):
    """Returns the records and, for each run, {name: [values]}. A total has one value."""
    with tempfile.TemporaryDirectory() as keep:
        records = cml.run(scene.text(surface, RUNS), "--photons", photons, *options, keep=keep)
        runs = [{key: [record[key]] for key in TOTALS} | {key: bins_of(scene, record, key) for key in PROFILES}
                for record in records]
    return records, runs


def mean(columns):
    return [statistics.fmean(column) for column in columns]


def errors(columns):
    return [statistics.stdev(column) / math.sqrt(len(column)) for column in columns]


def distance(differences):
    """Returns the sum over bins of the absolute mean difference, not raised by noise. Signs come from one half of the runs, differences from the
    other. The mean is at most the true sum."""
    halves = mean(zip(*differences[::2])), mean(zip(*differences[1::2]))
    return sum(math.copysign(b, a * b) if a * b else 0.0 for a, b in zip(*halves))


class Bias:
    """The bias of a scene whose boundary is replaced by a plane. series and bins have pairs (relative difference, its standard error)."""

    def __init__(self, scene, photons, options=()):
        truth_records, truth = fly(scene, scene.surface, photons, options)
        level_records, level = fly(scene, scene.level, photons, [*options, "--boundaries", "cone"])
        self.series, self.bins = {}, {}
        self.clean = all(record["lost"] == 0 and record["residue"] == 0 for record in truth_records + level_records)
        self.seconds = statistics.fmean(record["cpu_s"] for record in truth_records)  # processor time of a run with the curved boundary [s]
        for key in TOTALS + PROFILES:
            differences = [[b - a for a, b in zip(one[key], other[key])] for one, other in zip(truth, level)]
            whole = max(sum(mean(zip(*(run[key] for run in truth)))), LEAST_SHARE)
            means, spread = mean(zip(*differences)), errors(list(zip(*differences)))
            shift = abs(means[0]) if key in TOTALS else distance(differences)
            self.series[key] = shift / whole, math.hypot(*spread) / whole
            average = whole / len(means)
            holds = [max(value, average) for value in mean(zip(*(run[key] for run in truth)))]
            self.bins[key] = [(abs(m) / h, e / h) for m, e, h in zip(means, spread, holds)]

    def excess(self, tolerance):
        """Returns the largest excess over the tolerance, in standard errors, of a series and of a bin, with their names."""
        def over(pair):
            return (pair[0] - tolerance) / max(pair[1], 1e-12)
        series = max((over(pair), key) for key, pair in self.series.items())
        bins = max((over(pair), f"{key}[{i}]") for key, pairs in self.bins.items() for i, pair in enumerate(pairs))
        return series, bins
