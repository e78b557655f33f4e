#!/usr/bin/env python3
"""Makes the files of twelve materials for renderers: materials.py [DIR] [ERROR] [profiles] [repository]

Leaves NAME.json, NAME.csv and NAME.rgb.bsdf of each material in DIR, by default the current directory, and a page materials.md with a picture
materials.svg. ERROR is the noise of profiles, by default 0.02. With the word profiles no .bsdf is made, which takes most of the time. With the word
repository, the page and the picture of the manual (samples/manual/recipes/materials.md) are written instead of those in DIR. The channels r, g, b
are 610, 540 and 460 nm if a source has spectra. Every row names its source. Needs the Python package (or PYTHONPATH=src/python and
CLUSTERMCML=build/clustermcml in a checkout), scipy and matplotlib.

SPDX-License-Identifier: MIT
"""
import os
import sys
from dataclasses import dataclass, field

import clustermcml as mc
import matplotlib
import numpy as np

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "clustermcml", "font.sans-serif": ["DejaVu Sans", "Arial"]})
from matplotlib.figure import Figure  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
NM = np.array([610.0, 540.0, 460.0])
THICK = 1e8  # thickness of a half space [cm]
EPIDERMIS = 0.006  # thickness [cm]
JENSEN = "Jensen, Marschner, Levoy, Hanrahan, A Practical Model for Subsurface Light Transport, SIGGRAPH 2001: reduced scattering, so g is 0 here"
NARASIMHAN = "Narasimhan, Gupta, Donner, Ramamoorthi, Nayar, Jensen, Acquiring Scattering Properties of Participating Media by Dilution, SIGGRAPH 2006: reduced, as pbrt lists it"
JACQUES = "Jacques, Skin Optics, Oregon Medical Laser Center News, January 1998 (formulas); hemoglobin: Prahl (`mc.media`)"
PAPER = "typical of copy paper, by Kubelka and Munk: S 50 m2/kg, K 0.5 m2/kg (red) to 1 m2/kg (blue), 80 g/m2, 0.01 cm (Pauler, Paper Optics, 1999, has such values); mus' = 4 S / 3, mua = K / 2"
PAINT = "an illustration and no measurement: a white coat of 0.005 cm on a grey ground"


@dataclass
class Material:
    """A material. layers: tuples n, mua, mus, g, d from above, in cm and 1/cm; mua and mus may be three numbers, for r, g, b."""

    name: str
    source: str
    layers: list
    more: dict = field(default_factory=dict)  # further arguments of the Scene

    def scene(self):
        layers = [mc.Layer(n=n, mua=float(np.ravel(mua)[0]), mus=float(np.ravel(mus)[0]), g=g, d=d) for n, mua, mus, g, d in self.layers]
        return mc.Scene(layers, photons=200_000, n_below=layers[-1].n, **self.more)

    def channels(self):
        """Returns the columns of the channels. Numbers that are equal in all channels stay in the scene."""
        columns = {"channel": ["r", "g", "b"]}
        for i, (_, mua, mus, _, _) in enumerate(self.layers, 1):
            columns.update({f"layer{i}.{name}": list(map(float, values)) for name, values in (("mua", mua), ("mus", mus)) if np.size(values) == 3})
        return columns


def half_space(name, source, n, reduced, mua, g=0.0):
    """Returns an infinitely deep material. reduced: reduced scattering; mua: absorption; both for r, g, b in 1/mm, as in papers on rendering."""
    return Material(name, source, [(n, 10 * np.array(mua), 10 * np.array(reduced) / (1 - g), g, THICK)])


def skin(name, melanosomes):
    """Returns skin: an epidermis with a share of melanosomes, over a dermis with 0.2 % of blood, three quarters of it oxygenated."""
    epidermis = mc.media.Medium({"melanosome": melanosomes, "bloodless skin": 1 - melanosomes}).columns(NM)["mua"]
    dermis = mc.media.Medium({**mc.media.blood(0.002, 0.75), "bloodless skin": 0.998}).columns(NM)["mua"]
    reduced = 2e5 * NM**-1.5 + 2e12 * NM**-4.0
    return Material(name, f"{JACQUES}; melanosomes {100 * melanosomes:g} %", [(1.4, epidermis, reduced / 0.2, 0.8, EPIDERMIS), (1.4, dermis, reduced / 0.2, 0.8, THICK)])


MATERIALS = [
    skin("skin_light", 0.038),
    skin("skin_medium", 0.135),
    skin("skin_dark", 0.305),
    half_space("skin1", JENSEN, 1.3, [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    half_space("marble", JENSEN, 1.5, [2.19, 2.62, 3.00], [0.0021, 0.0041, 0.0071]),
    half_space("whole_milk", JENSEN, 1.3, [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
    half_space("skim_milk", JENSEN, 1.3, [0.70, 1.22, 1.90], [0.0014, 0.0025, 0.0142]),
    half_space("espresso", NARASIMHAN, 1.33, [0.72378, 0.84557, 1.0247], [4.7984, 6.5751, 8.8493]),
    half_space("ketchup", JENSEN, 1.3, [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    half_space("apple", JENSEN, 1.3, [2.29, 2.39, 1.97], [0.0030, 0.0034, 0.046]),
    Material("copy_paper", PAPER, [(1.0, [2.0, 2.5, 4.0], 533.0, 0.0, 0.01)]),
    Material("white_paint", PAINT, [(1.5, [0.5, 0.6, 1.5], 5000.0, 0.6, 0.005)], {"backing": mc.Backing("lambertian", R=0.3)}),
]


SCENE = """```mci
# skin1.mci
1.0                     # file version
1                       # number of runs
skin1.mco A             # output file, format
100000                  # photons
0.02 0.02               # dz, dr [cm]
50 100 10               # nz, nr, na
1                       # layers
1.0                     # n above
1.3 0.32 7.4 0 1e8      # skin1 in red light: n, mua [1/cm], mus [1/cm], g, d [cm]
1.3                     # n below
```

```sh
clustermcml skin1.mci --photons 2e4
clustermcml profile skin1.mci -o skin1 --light diffuse --photons 2e4 --target-error 0.1
```""".splitlines()


def encoded(Rd):
    """Returns linear shares as sRGB values for a picture."""
    Rd = np.clip(Rd, 0, 1)
    return np.where(Rd <= 0.0031308, 12.92 * Rd, 1.055 * Rd ** (1 / 2.4) - 0.055)


def draw(made, path):
    """Draws a patch of each material's colour in diffuse light, and light per distance in its channels."""
    figure = Figure(figsize=(11, 8.6), layout="constrained")
    panels = figure.subplots(4, 3).flat
    for axes, (material, profile) in zip(panels, made):
        r = profile.r.values
        for c, colour in enumerate(("#D55E00", "#009E73", "#0072B2")):
            light = 2 * np.pi * r[c] * profile.S.values[c] / float(profile.Rd[c])
            light = light.reshape(-1, 4).mean(axis=1)
            middle = 10 * r[c].reshape(-1, 4).mean(axis=1)
            seen = middle < 30 * float(profile.mean_r.max())
            axes.plot(middle[seen], light[seen] / 10, color=colour, lw=1.2)
        axes.set_title(material.name, fontsize=10)
        axes.set_xlim(0, 30 * float(profile.mean_r.max()))
        axes.set_ylim(0, None)
        axes.tick_params(labelsize=8)
        axes.set_xlabel("distance [mm]", fontsize=8)
        patch = axes.inset_axes([0.62, 0.45, 0.33, 0.47], facecolor=encoded(profile.Rd.values))
        patch.set(xticks=[], yticks=[])
    panels[0].legend(panels[0].lines, ("red", "green", "blue"), loc="lower right", bbox_to_anchor=(1, 0.06), fontsize=7, frameon=False)
    figure.supylabel("light that leaves per distance [1/mm], of all that leaves", fontsize=9)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


def row(material, profile):
    def three(values, form):
        return " ".join(form % value for value in values)
    errors = [profile.fit(kind).L1.values.max() for kind in ("exponentials", "burley", "openpbr")]
    return f"| `{material.name}` | {three(profile.Rd.values, '%.3f')} | {three(10 * profile.mean_r.values, '%.3g')} | {profile.noise.values.max():.3f} | {' | '.join('%.3f' % one for one in errors)} |"


def properties(material):
    def shown(values):
        return " ".join("%.4g" % value for value in np.ravel(values))
    return [f"| `{material.name}` | {i} | {n:g} | {shown(mua)} | {shown(mus)} | {g:g} | {'half space' if d == THICK else '%g' % d} |"
            for i, (n, mua, mus, g, d) in enumerate(material.layers, 1)]


def page(made, picture):
    """Returns the text of materials.md."""
    lines = ["# Twelve materials", "", "`samples/materials.py` makes the files of twelve materials that renderers read, and this page.", "",
             f"![Light per distance, and colours in diffuse light]({picture})", "",
             "Patches are Rd of the three channels, as sRGB, in diffuse light.",
             "Curves are `2 pi r S / Rd`: how far light comes out from where it went in, in red, green and blue.", "",
             "A skin-like material as a scene:", "", *SCENE, "",
             "```text", "python3 samples/materials.py renderer                  all files, in the folder renderer",
             "python3 samples/materials.py renderer 0.02 profiles    no .bsdf, which takes most of the time", "```", "",
             "Each material has `.rgb.bsdf` ([a BRDF](brdf.md)), `.json` and `.csv` ([a profile](profile.md)).", "",
             "## What to change", "",
             "| want | change |", "|---|---|",
             "| a material of your own | a row of `MATERIALS`: a name, a source, and layers of n, mua, mus, g, d in cm and 1/cm |",
             "| colours | mua and mus as three numbers, of r, g and b |",
             "| values in 1/mm, as papers on rendering have them | `half_space`, which multiplies by 10 |", "",
             "## What comes out", "",
             "Rd is the diffuse reflectance, by r g b, and r the mean distance.",
             "Noise and L1 are those of the worst channel. L1 has the noise in it.", "",
             "| material | Rd | mean r [mm] | noise | L1 of exponentials | of Burley | of a random walk |", "|---|---|---|---|---|---|---|", *(row(*one) for one in made), "",
             "## What goes in", "", "Three numbers are of r, g and b.", "",
             "| material | layer | n | mua [1/cm] | mus [1/cm] | g | d [cm] |", "|---|---|---|---|---|---|---|", *(line for material, _ in made for line in properties(material)), "",
             "`white_paint` lies on a lambertian ground that sends back 0.3. All half spaces go on below with their own n.", "", "## Sources", "",
             "| material | source |", "|---|---|", *(f"| `{material.name}` | {material.source} |" for material, _ in made), "",
             "## Limits", "",
             "Measured reduced scattering mus' = mus (1 - g) does not tell g.",
             "The rows use g = 0 there, which changes light near the entry only.", ""]
    return "\n".join(lines)


def main(folder, error, profiles_only, repository):
    os.makedirs(folder, exist_ok=True)
    made = []
    for material in MATERIALS:
        stem = os.path.join(folder, material.name)
        profile = mc.profile(material.scene(), "diffuse", target_error=error, channels=material.channels())
        profile.to_json(stem + ".json")
        profile.to_csv(stem + ".csv")
        made.append((material, profile))
        if not profiles_only:
            mc.brdf(material.scene(), channels=material.channels()).to_bsdf(stem + ".rgb.bsdf")
        print(stem, flush=True)
    home, picture = (os.path.join(HERE, "manual", "recipes"), "../pictures/materials.svg") if repository else (folder, "materials.svg")
    draw(made, os.path.join(home, picture))
    with open(os.path.join(home, "materials.md"), "w", encoding="utf-8") as file:
        file.write(page(made, picture))


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word not in ("profiles", "repository")]
    main(words[0] if words else ".", float(words[1]) if len(words) > 1 else 0.02, "profiles" in sys.argv, "repository" in sys.argv)
