"""Monte Carlo light transport in layered turbid media whose boundaries need not be flat.

Five lines from a scene to a picture (with matplotlib):

    import clustermcml as mc
    skin = mc.Layer(n=1.4, mua=1, mus=100, g=0.9, d=0.1, top=mc.Heightfield(r=[0, 0.1], h=[0.02, 0]))
    result = mc.run(mc.Scene([skin], photons=1e5))
    print(float(result.Rd), "+-", float(result.Rd_se))
    result.Rd_r.plot()

Results are xarray.Dataset, with units, axes and standard errors (NAME_se of NAME). Lengths are in cm, coefficients in 1/cm.
`clustermcml help output` says what every quantity is.

SPDX-License-Identifier: MIT
"""

from . import media
from .bodies import Body, Cylinder, Sphere
from .brdf import brdf
from .bsdf_file import read_bsdf
from .commands import check, crosscheck, exact, furnace, mesh, plan, trace, version
from .compare import compare
from .detectors import Detector
from .errors import ClustermcmlError, InputError
from .fit import Fit, fit
from .integrating_sphere import sphere
from .material import Material, read_material
from .merge import merge
from .mie import Mie, mie
from .phases import Phase
from .photons import Saved, read_photons
from .probes import Fibre, Probe
from .profile import Profile, profile
from .program import run
from .results import read
from .scene import Backing, Beam, Directions, Layer, Map, Scene, Time
from .spectrum import spectrum
from .surfaces import Heightfield, Heightmap, Mesh, Relief, Rough
from .sweep import sweep
from .top import Face, Port
from .view import view
from .watts import scale

__all__ = ["Backing", "Beam", "Body", "ClustermcmlError", "Cylinder", "Detector", "Directions", "Face", "Fibre", "Fit", "Heightfield", "Heightmap", "InputError", "Layer", "Map", "Material", "Mesh", "Mie", "Phase", "Port", "Probe", "Profile", "Relief", "Rough", "Saved", "Scene",
           "Sphere", "Time", "brdf", "check", "compare", "crosscheck", "exact", "fit", "furnace", "media", "merge", "mesh", "mie", "plan", "profile", "read", "read_bsdf", "read_material", "read_photons", "run", "scale", "spectrum", "sphere", "sweep", "trace", "view"]


def __getattr__(name: str) -> str:
    """`__version__` is the version of the program, asked at first use: without a program, the package still imports and reads
    results."""
    if name == "__version__":
        return version()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
