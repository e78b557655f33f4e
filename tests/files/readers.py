"""Tests the .h5, .vti and .vtp files of a run as h5py, xarray and VTK read them: numbers as in the .mco, and right places, units, errors and
provenance.

One scene with a mesh, cones and a plane is small enough to compare every value."""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
from fields import arrays_of, h5py, numpy, read_vtk, vtk, xarray  # noqa: E402

MESH = os.path.join(os.path.dirname(cml.TESTS), "meshes", "wedge.obj")
NX, NY, NZ, NR, NA = 30, 20, 12, 25, 4
DX, DY, DZ, DR, TOP = 0.05, 0.1, 0.05, 0.02, -0.2
LONG_COMMENT = "# " + 100 * "a long line in the input is kept, however long. " + "\n"


def scene(name, letter):
    text = cml.mci(["1.34 0 0 0 0.2", "1.4 0.5 30 0.8 0.2"], name=name, photons=20000, grid=f"{DZ} {DR}",
                   bins=f"{NZ} {NR} {NA}", n_below=1.1,
                   surfaces={0: f'm "{MESH}"', 2: "b 4 0.05 0.1 -0.03 0.15 0.04 0.2 0 0"},
                   extra=[f"map {NX} {NY} {DX} {DY} angles volume top={TOP}", "#@ facets"]
                   + ["detector disk 0.5", "detector map 4 3 0.1 0.2 name=near", "detector map 3 5 0.05 0.02 at=0.1,-0.2 z=-0.15 na=0.9 name=cam"]
                   + 20 * [LONG_COMMENT.strip()] + ["beam disk 0.3 at=0.1,0"])
    return text.replace(f"{name} A", f"{name} {letter}")


def close(a, b, tolerance=1e-6):
    """True if both arrays agree to float32's precision, 6e-8, times a margin. A zero on one side must be a zero on the other."""
    a, b = numpy.asarray(a, dtype=float), numpy.asarray(b, dtype=float)
    return a.shape == b.shape and bool(numpy.all(numpy.abs(a - b) <= tolerance * numpy.abs(b)))


def check_tables(verdict, file, sections, record):
    """Checks profiles and errors against the .mco, which rounds to four or five digits, and totals against the JSON record."""
    for name in ("A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"):
        verdict.check(name, close(file[name], sections[name], 6e-5))
        verdict.check(name + "_se", close(file[name + "_se"], sections["se_" + name], 6e-5))
        verdict.check(name, file[name].attrs["ancillary_variables"].decode() == name + "_se", "names its errors")
    for name in ("Rsp", "Rd", "A", "Tt"):
        verdict.check(name, file[name][()] == record[name] and file[name + "_se"][()] == record[name + "_se"])
    verdict.check("A_rz", file["A_rz"].shape == (NR, NZ))
    area = 2 * numpy.pi * (numpy.arange(NR) + 0.5) * DR**2
    verdict.check("sum of A_rz", close((file["A_rz"][:] * area[:, None]).sum(axis=0), file["A_z"], 1e-12))
    verdict.check("books", file["residue"][()] == 0 and file["lost"][()] == 0 and file["book_launched"][()] == 1)


def check_superblock(verdict, path):
    """Checks the superblock by the HDF5 File Format Specification, II.A, version 2: no flag says that somebody is writing, and the size is that of
    the file."""
    with open(path, "rb") as file:
        head = file.read(36)
    verdict.check("superblock", head[8] == 2 and head[11] == 0, f"version {head[8]}, flags {head[11]}")
    verdict.check("superblock", int.from_bytes(head[28:36], "little") == os.path.getsize(path),
                  f"ends at {int.from_bytes(head[28:36], 'little')} of {os.path.getsize(path)}")


def check_map_sums(verdict, file):
    for name in ("Rd", "Tt"):
        inside = file[name + "_xy"][:].sum(dtype=float) * DX * DY
        verdict.check(name + "_xy", close(inside + file[name + "_outside"][()], file[name][()]), "and its outside")
        verdict.check(name + "_outside", file[name + "_outside"][()] > 0)
        da = numpy.pi / 2 / NA
        omega = 2 * numpy.pi * numpy.sin(da / 2) * numpy.sin(2 * (numpy.arange(NA) + 0.5) * da)
        verdict.check(name + "_xya", close((file[name + "_xya"][:] * omega).sum(axis=2), file[name + "_xy"]))
        errors = file[name + "_xya_se"][:] * omega
        ratio = (errors ** 2).sum() / (file[name + "_xy_se"][:] ** 2).sum()
        verdict.check(name + "_xya_se", 0.8 < ratio < 1.25, f"variances by angle sum to {ratio:.3f} of the pixels'")
    volume = file["A_xyz"][:].sum(dtype=float) * DX * DY * DZ
    verdict.check("A_xyz", close(volume + file["A_outside"][()], file["A"][()]), "and its outside")


def check_facet_sums(verdict, file):
    for boundary, total in ((0, "Rd"), (2, "Tt")):
        start = f"boundary{boundary}_"
        area = file[start + "area"][:]

        def weight(name):
            return (file[start + name][:] * area).sum() + file[start + "outer_" + name][()]

        verdict.check(start + total, close(weight(total), file[total][()]), "sums to the total")
        came = weight("irradiance_above") + weight("irradiance_below")
        verdict.check(start + "exitance", close(weight("exitance_above") + weight("exitance_below"), came))
        verdict.check(start + "se", bool(numpy.all(file[start + total + "_se"][:] >= 0)))
    plane = file["boundary1_irradiance_above"]
    came = sum(file[f"boundary1_irradiance_{side}"][:] for side in ("above", "below"))
    went = sum(file[f"boundary1_exitance_{side}"][:] for side in ("above", "below"))
    verdict.check("boundary 1", plane.shape == (NY, NX) and close(came, went, 1e-5) and came.sum() > 0)
    whole = plane[:].sum(dtype=float) * DX * DY + file["boundary1_outer_irradiance_above"][()]
    verdict.check("boundary 1", 0.9 < whole < 1.5, f"receives {whole}")


def check_provenance(verdict, file, text):
    def word(name):
        return file.attrs[name].decode()

    verdict.check("input", word("input").startswith("all.mco A") and "beam disk 0.3" in word("input"))
    verdict.check("input", all(line in text for line in word("input").split("\n")), "as written")
    call = {name: item[()].decode() for name, item in file["call"].items()}
    verdict.check("call", " run " in call["command"] and "--json" in call["command"])
    verdict.check("call", call["input_file"].endswith(".mci") and call["input_file"] in call["command"] and len(call) == 2)
    verdict.check("seed", file.attrs["seed"] == 3 and file.attrs["photons"] == 20000 and word("engine") == "cpu")
    verdict.check("boundaries", "boundary 1: plane" in word("boundaries") and "cone" in word("boundaries"))
    for name, item in file.items():
        if name == "call":
            continue
        verdict.check(name, item.attrs["units"] and item.attrs["long_name"], "has units and a long name")
        if item.shape and "CLASS" not in item.attrs:  # an axis has the attribute CLASS
            verdict.check(name, all(len(axis) == 1 for axis in item.dims), "has its axes")


def check_xarray(verdict, path):
    with xarray.open_dataset(path) as data:
        verdict.check("xarray", data.Rd_xy.dims == ("y", "x") and data.Rd_xya.dims == ("y", "x", "alpha"))
        verdict.check("xarray", data.A_xyz.dims == ("z_volume", "y", "x") and data.A_rz.dims == ("r", "z"))
        verdict.check("x", close(data.x, (numpy.arange(NX) + 0.5 - NX / 2) * DX, 1e-12))
        verdict.check("y", close(data.y, (numpy.arange(NY) + 0.5 - NY / 2) * DY, 1e-12))
        verdict.check("z_volume", close(data.z_volume, TOP + (numpy.arange(NZ) + 0.5) * DZ, 1e-12))
        verdict.check("alpha", close(data.alpha, (numpy.arange(NA) + 0.5) * numpy.pi / 2 / NA, 1e-12))
        verdict.check("units", data.Rd_xy.units == "1/cm2" and data.x.units == "cm" and data.A_xyz.units == "1/cm3")
        bright = data.Rd_xy.where(data.Rd_xy == data.Rd_xy.max(), drop=True)
        verdict.check("brightest pixel", abs(float(bright.x[0])) < 0.5 and abs(float(bright.y[0])) < 0.5)


def check_images(verdict, stem, file):
    flat, volume = read_vtk(stem + ".map.vti"), read_vtk(stem + ".volume.vti")
    verdict.check("map.vti", flat.GetDimensions() == (NX + 1, NY + 1, 1), f"{flat.GetDimensions()}")
    verdict.check("map.vti bounds", close(flat.GetBounds(), (-0.75, 0.75, -1, 1, 0, 0), 1e-12))
    verdict.check("volume.vti", volume.GetDimensions() == (NX + 1, NY + 1, NZ + 1))
    verdict.check("volume.vti bounds", close(volume.GetBounds(), (-0.75, 0.75, -1, 1, TOP, TOP + NZ * DZ), 1e-12))
    arrays = arrays_of(flat)
    for name in ("Rd_xy", "Rd_xy_se", "Tt_xy", "Tt_xy_se", "Rd_xya", "Tt_xya_se", "boundary1_exitance_below"):
        verdict.check("map.vti " + name, numpy.array_equal(arrays[name].reshape(file[name].shape), file[name][:]))
    camera = read_vtk(stem + ".detector_cam.vti")
    verdict.check("detector_cam.vti", camera.GetDimensions() == (4, 6, 1), f"{camera.GetDimensions()}")
    verdict.check("detector_cam.vti", close(camera.GetBounds(), (0.025, 0.175, -0.25, -0.15, -0.15, -0.15), 1e-12), f"{camera.GetBounds()}")
    for detector in ("near", "cam"):
        arrays = arrays_of(read_vtk(f"{stem}.detector_{detector}.vti"))
        verdict.check("detector " + detector, sorted(arrays) == [f"detector_{detector}_map", f"detector_{detector}_map_se"])
        for name, values in arrays.items():
            verdict.check(name, numpy.array_equal(values.reshape(file[name].shape), file[name][:]) and values.max() > 0)
    verdict.check("volume.vti", numpy.array_equal(arrays_of(volume)["A_xyz"].reshape(NZ, NY, NX), file["A_xyz"][:]))


def check_faces(verdict, stem, file):
    for boundary, per_facet, corners in ((0, 1, 3), (2, 64, 4)):
        faces, start = read_vtk(f"{stem}.boundary{boundary}.vtp"), f"boundary{boundary}_"
        facets = file[start + "area"].shape[0]
        verdict.check(start + "vtp", faces.GetNumberOfCells() == facets * per_facet)
        verdict.check(start + "vtp", faces.GetCell(0).GetNumberOfPoints() == corners)
        for name, values in arrays_of(faces).items():
            verdict.check(start + name, numpy.array_equal(values, numpy.repeat(file[start + name][:], per_facet)))
        size = vtk.vtkCellSizeFilter()
        size.SetInputData(faces)
        size.Update()
        area = arrays_of(size.GetOutput())["Area"].reshape(facets, per_facet).sum(axis=1)
        verdict.check(start + "area", close(area, file[start + "area"], 1e-9 if corners == 3 else 2e-3))
    verdict.check("boundary 0", close(read_vtk(stem + ".boundary0.vtp").GetBounds(), (-0.5, 0.5, -0.5, 0.5, -0.1, 0), 1e-9))
    bounds = read_vtk(stem + ".boundary2.vtp").GetBounds()
    verdict.check("boundary 2", close(bounds, (-0.45, 0.45, -0.45, 0.45, 0.35, 0.43), 1e-9), f"{bounds}")
    verdict.check("boundary 1", not os.path.exists(stem + ".boundary1.vtp"), "is a plane and has no file")


def main():
    verdict = cml.Verdict("readers")
    with tempfile.TemporaryDirectory() as keep:
        text = scene("all.mco", "A")
        record = cml.run(text, "--seed", 3, "--threads", 2, keep=keep)[0]
        names = sorted(os.path.basename(path) for path in record["files"])
        verdict.check("files", names == ["all.boundary0.vtp", "all.boundary2.vtp", "all.detector_cam.vti", "all.detector_near.vti", "all.h5",
                                         "all.map.vti", "all.mco", "all.volume.vti"], f"{names}")
        verdict.check("files", sorted(os.listdir(keep)) == sorted(names + ["scene.mci"]), "and no others")
        stem = os.path.join(keep, "all")
        check_superblock(verdict, stem + ".h5")
        with h5py.File(stem + ".h5") as file:
            check_tables(verdict, file, cml.read_sections(stem + ".mco"), record)
            check_map_sums(verdict, file)
            check_facet_sums(verdict, file)
            check_provenance(verdict, file, text)
            check_images(verdict, stem, file)
            check_faces(verdict, stem, file)
        check_xarray(verdict, stem + ".h5")
        record = cml.run(scene("binary.mco", "B"), "--seed", 3, "--ignore-absorption", keep=keep)[0]
        verdict.check("format B", os.path.basename(record["output"]) == "binary.h5")
        verdict.check("format B", not os.path.exists(os.path.join(keep, "binary.mco")))
        with h5py.File(record["output"]) as binary, h5py.File(stem + ".h5") as file:
            verdict.check("format B", numpy.array_equal(binary["Rd_ra"][:], file["Rd_ra"][:]))
            verdict.check("--ignore-absorption", "A_xyz" not in binary and "A_rz" not in binary)
    verdict.finish()


main()
