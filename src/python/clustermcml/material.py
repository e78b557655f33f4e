"""The result of `brdf`, a material: reflection and transmission by direction, and the files that renderers read.

SPDX-License-Identifier: MIT
"""

from __future__ import annotations

import io
import os
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import errors
from .brdf_fit import evaluate
from .bsdf_file import write_bsdf
from .channels import OfChannels
from .command_line import path_of, picture_path, write
from .gloss import CELLS, beside, exits, finer, nodes, with_means
from .options import Path
from .pictures import COLOURS, drawing, save

if TYPE_CHECKING:
    import xarray as xr

SIZE = 2 * CELLS - 1  # nodes of a .bsdf along each axis. Exits near the horizon (90 degrees) need finer nodes than lobes do
GREY_NM = (360.0, 830.0)  # a grey material, for renderers of spectra
HORIZON = np.pi / 2 - 1e-4  # largest angle [rad] at which f is computed: at 90 degrees rounding would leave no light
STEP = 2.5  # degrees between angles of incidence of a .bsdf, at most: renderers interpolate at the same half vector, and the horizon moves from one to the next
MUCH = 1e-3  # share of the light in a mirror image that is worth a message
PLOTTED = 5  # number of angles of incidence in a picture


@dataclass(repr=False)
class Material(OfChannels):
    """The result of `brdf`. Its arrays are attributes: `material.f_r` is `material.data.f_r`.

    Attributes:
        data: xarray.Dataset of all arrays.
    """

    data: xr.Dataset

    def f(self, theta_i: Any, theta_o: Any, phi: Any, channel: int = 0) -> Any:
        """Evaluates the fit of light that was inside the material.

        Swapping theta_i and theta_o changes no bit.

        Args:
            theta_i: Angle of incidence [degrees].
            theta_o: Exit angle [degrees].
            phi: Azimuth between both [degrees].
            channel: Index of the channel.

        Returns:
            Values [1/sr], of the arguments' common shape.
        """
        angles = np.broadcast_arrays(*(np.radians(angle) for angle in (theta_i, theta_o, phi)))
        return evaluate(self._each("fit")[channel], float(self._each("index")[channel]), *angles)

    # ---- files ----

    def _half(self, channel: int, angle: float) -> Any:
        """Returns f of a lobe at the nodes of a .bsdf. Between the flown angles, cells of equal half vector are interpolated
        linearly."""
        flown, cells = self.data["theta_i"].values, self._each("f_half")[channel]
        i = int(np.clip(np.searchsorted(flown, angle, side="right") - 1, 0, max(len(flown) - 2, 0)))
        j = min(i + 1, len(flown) - 1)
        share = (angle - flown[i]) / (flown[j] - flown[i]) if j > i else 0.0
        return finer((1 - share) * cells[i] + share * cells[j])

    def _table(self, angles: Any) -> Any:
        """Returns f cos theta_o [angle of incidence, channel, v, u] at the nodes of a .bsdf. angles: of incidence [degrees]."""
        u, v = nodes(SIZE)
        each = [exits(u, v, np.radians(angle)) for angle in angles]
        above = np.array([(cosine > 0) & (along > 0) for cosine, _, along in each])
        used = np.array([beside(one) for one in above])
        rows = []
        for channel in range(max(len(self.channels()), 1)):
            row = np.zeros_like(above, float)
            if self.data.attrs["half"] != "all":
                f = np.array([self._continued(channel, angle, *one[:2]) for angle, one in zip(angles, each)])
                row = np.where(used, np.maximum(with_means(f, angles), 0), 0.0)
            if "f_half" in self.data:
                row += np.where(above, [self._half(channel, float(angle)) * one[0] for angle, one in zip(angles, each)], 0.0)
            rows.append(row)
        return np.stack(rows, axis=1)

    def _continued(self, channel: int, angle: float, cosine: Any, phi: Any) -> Any:
        """f cos theta_o of the fit; below the horizon f goes on as a straight line in the cosine."""
        fit, index, light = self._each("fit")[channel], float(self._each("index")[channel]), np.full_like(phi, np.radians(angle))
        f = evaluate(fit, index, light, np.arccos(np.minimum(np.abs(cosine), 1)), phi)
        level = evaluate(fit, index, light, np.full_like(phi, HORIZON), phi)
        return np.where(cosine > 0, f, 2 * level - f) * cosine

    def to_bsdf(self, path: Path) -> None:
        """Writes a table for the plugin `measured` of Mitsuba 3 and pbrt-v4.

        A grey material can be either kind of file; channels r, g, b need the first, wavelengths the second. A warning says how much light the table lacks
        because it leaves as a mirror image.

        Args:
            path: NAME.rgb.bsdf for variants of Mitsuba with RGB, any other NAME.bsdf for those with spectra, and for pbrt.
        """
        name, labels = path_of(path, ".bsdf"), self.channels()
        rgb = name.endswith(".rgb.bsdf")
        if labels and rgb != (labels == ["r", "g", "b"]):
            raise errors.refuse("path", name, "a name that ends in .rgb.bsdf, for channels r g b" if not rgb else "a name that ends in .bsdf without .rgb, for channels by nm")
        angles = _steps(self.data["theta_i"].values)
        table, theta = self._table(angles), np.radians(angles)
        copies = len(labels) or (3 if rgb else len(GREY_NM))
        table = table if labels else np.repeat(table, copies, axis=1)
        if theta[0] > 0:
            theta, table = np.concatenate([[0.0], theta]), np.concatenate([table[:1], table])
        theta, table = np.concatenate([theta, [np.pi / 2]]), np.concatenate([table, table[-1:]])
        attrs = self.data.attrs
        text = f"{attrs['scene']}; {attrs['version']}; seed {attrs['seed']}"
        write_bsdf(name, table, theta, text, None if rgb else np.array(labels or GREY_NM, float))
        if self.mirror_note():
            warnings.warn(self.mirror_note(), stacklevel=2)

    def mirror_note(self) -> str:
        """Returns a sentence on the light that no table holds, at the first angle where that is much; "" where there is little."""
        mirror = self._each("mirror_R").max(axis=0)
        if mirror.max() < MUCH:
            return ""
        i = int(np.argmax(mirror >= MUCH))
        return (f"{100 * mirror[i]:.1f} % of the light at {self.data['theta_i'].values[i]:g} degrees is a mirror image and not in the .bsdf: "
                f"put a smooth dielectric coat of n {self.data.attrs['n_layer']:g} over it, or give the face a rough line")

    def _lines(self) -> Any:
        """Yields the rows of the text table."""
        data, labels = self.data, self.channels() or [None]
        names = ("f_r", "f_r_se", "f_t", "f_t_se")
        columns = [self._each(name) for name in names]
        for c, label in enumerate(labels):
            for i, angle in enumerate(data["theta_i"].values):
                for o, theta in enumerate(data["theta"].values):
                    for p, phi in enumerate(data["phi"].values):
                        words = [] if label is None else [f"{label:g}" if isinstance(label, (int, float)) else str(label)]
                        yield " ".join([*words, f"{angle:g}", f"{theta:g}", f"{phi:g}", *(f"{column[c, i, o, p]:.6g}" for column in columns)])

    def to_text(self, path: Path) -> None:
        """Writes the bins as lines theta_i theta_o phi f_r f_r_se f_t f_t_se, in degrees and 1/sr, behind a head of # lines. Channels come first.

        Args:
            path: Path of the text file.
        """
        if not isinstance(path, (str, os.PathLike)) or "\0" in os.fspath(path):
            raise errors.refuse("path", path, "the name of a file")
        data, attrs = self.data, self.data.attrs
        shown = [f"# {name}: {attrs[name]}" for name in ("scene", "version", "identity", "seed", "side")]
        shown.append("# photons: " + " ".join(f"{count:.0f}" for count in np.ravel(data["photons"].values)))
        shown.append("# units: degrees, 1/sr; bin middles; phi 0 is the mirror side; f_t is of flux: radiance has n_below^2 / n_above^2 more")
        for name in ("mirror_R", "mirror_T"):
            shown.append(f"# {name}, in no bin: " + " ".join(f"{value:.6g}" for value in np.ravel(data[name].values)))
        shown.append("# " + ("channel " if self.channels() else "") + "theta_i theta_o phi f_r f_r_se f_t f_t_se")
        write(os.fspath(path), "\n".join([*shown, *self._lines(), ""]).encode())

    def to_h5(self, path: Path) -> None:
        """Writes all arrays as an HDF5 file in the manner of netCDF, the same bytes every time. `read_material` reads the file.

        Args:
            path: A name that ends in .h5.
        """
        import h5py
        name, content = path_of(path, ".h5"), io.BytesIO()
        with h5py.File(content, "w") as file:
            file.attrs.update(self.data.attrs)
            for dim, size in self.data.sizes.items():
                if dim not in self.data.coords:
                    file[str(dim)] = np.arange(size)
            for key, array in self.data.variables.items():
                values = array.values
                file[str(key)] = values.astype(object) if values.dtype.kind == "U" else values
                file[str(key)].attrs.update(array.attrs)
            for dim in self.data.sizes:
                file[str(dim)].make_scale(str(dim))
            for key, array in self.data.variables.items():
                for i, dim in enumerate(array.dims if key not in self.data.sizes else ()):
                    file[str(key)].dims[i].attach_scale(file[str(dim)])
        write(name, content.getvalue())

    def to_netcdf(self, path: Path, **options: Any) -> None:
        """Writes all arrays as xarray does.

        Args:
            path: Path of the file.
            **options: As of xarray's `Dataset.to_netcdf`.
        """
        self.data.to_netcdf(path, **options)

    # ---- pictures ----

    def _plane(self, name: str, channel: int, i: int) -> tuple[Any, Any]:
        """Returns the signed angles [degrees] and the values in the plane of incidence. Negative angles lie on the side that
        the light comes from."""
        values, theta = self._each(name)[channel, i], self.data["theta"].values
        back = self.data.sizes["phi"] // 2
        return np.concatenate([-theta[::-1], theta]), np.concatenate([values[::-1, back], values[:, 0]])

    def plot(self, path: Path, channel: int = 0) -> None:
        """Draws f_r in the plane of incidence for up to five angles, with bands of one standard error and the fit dashed.

        Args:
            path: Path of the picture: .svg, .png, .pdf or .eps.
            channel: Index of the channel.
        """
        name = picture_path(path)
        errors.whole("channel", channel, 0, max(len(self.channels()), 1) - 1)
        angles = self.data["theta_i"].values
        shown = np.unique(np.linspace(0, len(angles) - 1, min(PLOTTED, len(angles))).round().astype(int))
        with drawing():
            from matplotlib.figure import Figure
            figure = Figure(figsize=(7.2, 4.4), layout="constrained")
            axes = figure.subplots()
            for colour, i in zip(COLOURS, shown):
                x, f = self._plane("f_r", channel, i)
                error = self._plane("f_r_se", channel, i)[1]
                axes.fill_between(x, f - error, f + error, color=colour, alpha=0.25, lw=0)
                axes.plot(x, f, color=colour, label=f"light from {angles[i]:g}")
                if self.data.attrs["half"] == "none":
                    axes.plot(x, self._plane("f_fit", channel, i)[1], color=colour, ls="--", lw=0.9)
            _scale(axes, self._each("f_r")[channel])
            axes.set(xlim=(-90, 90), xticks=range(-90, 91, 30), xlabel="exit angle, light comes from the left [degrees]", ylabel="f_r [1/sr]")
            axes.legend(fontsize="small")
            save(figure, name)


def _steps(angles: Any) -> Any:
    """Returns the angles with others between them, at most STEP apart.

    >>> _steps([0, 5, 7]).tolist()
    [0.0, 2.5, 5.0, 7.0]
    """
    parts = [np.linspace(low, high, int(np.ceil((high - low) / STEP)), endpoint=False) for low, high in zip(angles[:-1], angles[1:])]
    return np.concatenate([*parts, [float(angles[-1])]])


def read_material(path: Path) -> Material:
    """Reads the material in a file NAME.brdf.h5, which `Material.to_h5` or the command `brdf` has written.

    Args:
        path: Path of the file.

    Returns:
        A Material.
    """
    import xarray as xr
    name = errors.existing_file("path", path)
    try:
        with xr.open_dataset(name, engine="h5netcdf") as file:
            data = file.load()
    except (OSError, ValueError, KeyError) as error:
        raise errors.unreadable(name, "an .h5 file of a material", error) from error
    if "fit" not in data or "half" not in data.attrs:
        raise errors.refuse("path", name, "a file that `brdf` has written")
    return Material(data)


def _scale(axes: Any, values: Any) -> None:
    """Makes the axis logarithmic if a lobe stands far above the other values."""
    middle = float(np.median(values[values > 0])) if (values > 0).any() else 0.0
    if middle > 0 and values.max() > 30 * middle:
        axes.set(yscale="log", ylim=(middle / 30, 1.5 * values.max()))
    else:
        axes.set_ylim(0, None)
