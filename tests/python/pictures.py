"""Tests of pictures, asked of matplotlib: styles, ticks, gaps, the meaning of grey, and refusals.

SPDX-License-Identifier: MIT
"""
import cProfile
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import mc  # noqa: E402
import h5py  # noqa: E402
import numpy as np  # noqa: E402
from clustermcml import plot  # noqa: E402

SCENE = "1.0\n1\np.h5 B\n2000\ntime 300 30\ndetector disk 0.05 at=0.2,0 name=far\n0.02 0.05\n20 60 1\n2\n1\n1.4 0.5 50 0.8 0.1\n1.4 1 50 0.8 0.23\n1\n"


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.kept.cleanup)
        scene = cls.write(cls, "p.mci", SCENE)
        mc.run(scene, output_dir=cls.kept.name)
        cls.result = os.path.join(cls.kept.name, "p.h5")

    def write(self, name, text):
        path = os.path.join(self.kept.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def drawn(self, *words):
        """Returns the figure that the words draw, with its ticks."""
        figures, save = [], plot.save
        plot.save = lambda figure, path: (figure.draw_without_rendering(), figures.append(figure))
        try:
            self.assertEqual(plot.main([*words, "--quiet"]), 0)
        finally:
            plot.save = save
        return figures[0]

    def refused(self, message, *words):
        with self.assertRaises(mc.InputError) as caught:
            plot.main([*words, "-o", os.path.join(self.kept.name, "none.svg")])
        self.assertIn(message, str(caught.exception))
        self.assertNotIn("Error", str(caught.exception))

    @staticmethod
    def pixels(draw):
        """Returns the pixels of a picture in space, and the number of Python calls that drawing takes."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        canvas = FigureCanvasAgg(Figure())
        profile = cProfile.Profile()
        profile.enable()
        draw(canvas.figure.add_subplot(projection="3d"))
        canvas.draw()
        profile.disable()
        return np.asarray(canvas.buffer_rgba()).copy(), sum(entry.callcount for entry in profile.getstats())

    def test_facets_are_those_of_matplotlib(self):
        """Triangles and quads, alone and mixed, look as in matplotlib's own collection, which sorts them one by one. A Python call for each facet
        would take most of the time."""
        import matplotlib
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection
        from clustermcml.facets import Mesh, draw_mesh
        rng, n = np.random.default_rng(1), 20
        x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        points = np.stack([x.ravel(), y.ravel(), rng.normal(0, 0.7, n * n)], axis=1)
        quads = [np.array([i, i + n, i + n + 1, i + 1]) for i in range(n * n - n) if i % n < n - 1]
        triangles = [quad[[0, *half]] for quad in quads for half in ((1, 2), (2, 3))]
        norm = matplotlib.colors.Normalize(0, 1)
        self.pixels(lambda axes: None)  # imports matplotlib's modules before calls are counted
        for facets in (triangles, quads, [*quads[:200], *triangles[400:]]):
            mesh = Mesh(points, np.concatenate(facets), np.cumsum([len(facet) for facet in facets]), rng.random(len(facets)))
            def theirs(axes):
                draw_mesh(matplotlib, axes, mesh, norm)
                shaded = self.shaded(mesh, facets, norm)
                axes.collections[0].remove()
                axes.add_collection3d(Poly3DCollection([points[facet] * (1, 1, -1) for facet in facets], facecolors=shaded, edgecolors="none", linewidths=0, antialiased=False))

            (mine, calls), (own, most) = (self.pixels(of) for of in (lambda axes: draw_mesh(matplotlib, axes, mesh, norm), theirs))
            np.testing.assert_array_equal(mine, own)
            self.assertLess(calls + 50 * len(facets), most)

    @staticmethod
    def shaded(mesh, facets, norm):
        """Returns colours of facets in light from the left, computed one by one."""
        import matplotlib
        colours = matplotlib.colormaps[matplotlib.rcParams["image.cmap"]](norm(mesh.values))
        for colour, facet in zip(colours, facets):
            at = mesh.points[facet] * (1, 1, -1)
            normal = sum(np.cross(at[i] - at[0], at[i + 1] - at[0]) for i in range(1, len(at) - 1))
            colour[:3] *= 0.45 + 0.55 * abs(normal @ (-0.5, -0.3, 0.81)) / np.linalg.norm(normal)
        return colours

    def test_style_sets_widths_and_size(self):
        style = self.write("j.mplstyle", "lines.linewidth: 4\nlines.markersize: 9\nfigure.figsize: 3.5, 2.5\n")
        figure = self.drawn(self.result, "--of", "Rd_r", "--style", style)
        line = figure.axes[0].lines[0]
        self.assertEqual([line.get_linewidth(), line.get_markersize(), *figure.get_size_inches()], [4, 9, 3.5, 2.5])
        self.assertEqual(list(self.drawn(self.result, "--of", "Rd_r").get_size_inches()), [8, 4])

    def ticks(self, axis):
        low, high = sorted(axis.get_view_interval())
        places = [*axis.get_majorticklocs(), *axis.get_minorticklocs()]
        texts = [tick.get_text() for minor in (False, True) for tick in axis.get_ticklabels(minor=minor)]
        return {text: place for text, place in zip(texts, places) if text and low <= place <= high}

    def test_short_log_axes_have_ticks_that_differ(self):
        for span in ("0.31:0.34", "0.2:0.9", "0.11:3", "2e-5:9e-4"):
            for figure in (self.drawn(self.result, "--of", "Rd_r", "--yrange", span), self.drawn(self.result, "--of", "A_rz", "--log", "--crange", span)):
                ticks = self.ticks(figure.axes[-1].yaxis)
                self.assertGreaterEqual(len(ticks), 3, (span, ticks))
                for text, place in ticks.items():
                    self.assertAlmostEqual(float(text) / place, 1, 5)

    def test_zeros_are_gaps_and_bands_do_not_stretch_log_axes(self):
        with h5py.File(self.result) as file:
            numbers = file["detector_far_t"][()]
        lit = numbers > 0
        self.assertTrue(lit.any() and not lit.all())
        axes = self.drawn(self.result, "--of", "detector_far_t").axes[0]
        line = axes.lines[0]
        self.assertTrue((np.isnan(line.get_ydata()) == ~lit).all())
        lone = lit & ~np.append(lit[1:], False) & ~np.append(False, lit[:-1])
        self.assertTrue(set(np.flatnonzero(lone)) <= set(line.get_markevery()))
        self.assertGreater(axes.get_ylim()[0], numbers[lit].min() / 2)

    def test_grey_says_what_it_is(self):
        """Grey bins are explained: bins that two layers share have no fluence."""
        for scale, words in (("--linear", "not known"), ("--log", "no light or not known")):
            label = self.drawn(self.result, "--of", "fluence_rz", scale).axes[-1].get_ylabel()
            self.assertTrue(label.endswith("; grey: " + words), label)
            self.assertNotIn("not known", self.drawn(self.result, "--of", "A_rz", scale).axes[-1].get_ylabel())

    def test_tables_with_other_columns(self):
        table = self.write("skin.csv", "r_mid_cm,S_per_cm2,S_se,cdf\n0.5,3,0.1,0.3\n1.5,2,0.1,0.6\n2.5,1,0.1,0.9\n")
        axes = self.drawn(table, "--of", "S").axes[0]
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("radius r  [cm]", "S  [1/cm²]"))
        self.refused("skin.csv: Rd_r is missing (expected --of S or cdf, and a column of places", table)

    def test_what_has_no_axis_or_is_no_result(self):
        self.refused("p.h5: detector_far is one number, ", self.result, "--of", "detector_far")
        self.refused(" (expected an array over an axis: Rd_", self.result, "--of", "Rd")
        other = os.path.join(self.kept.name, "x.brdf.h5")
        with h5py.File(other, "w") as file:
            file["brdf"] = [1.0]
        self.refused("x.brdf.h5: not an .h5 file of a result (another kind of file (expected the array Rd in it))", other)


if __name__ == "__main__":
    unittest.main()
