"""Tests of files that are no results: `read` returns a Dataset or raises an InputError of one line, whatever the file holds.

`read` follows no link out of the file, reads no pipe, and takes no more memory than the file can hold. Crafted files with their messages come
first, then files that are damaged at random. Usage: strange_files.py [NUMBER of damaged files of each kind]"""
import os
import random
import re
import resource
import sys
import tempfile
import unittest
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
from python_package import h5py, mc, np, xr  # noqa: E402

MANGLED = 400
WORDS = "0 -1 1 2 1e999 nan 2000000000 99999999999999999999 1e-320 # A RAT InParm se_RAT A_z body \x00 \u2028 ;".split(" ")
SECRET = 12345.678


def replace(file, name, **what):
    """Replaces a data set by another without axes."""
    del file[name]
    return file.create_dataset(name, **what)


def promise(file, name, shape, layout):
    """Replaces a data set by one of that shape of which nothing is stored."""
    del file[name]
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if layout == "chunked":
        plan.set_chunk((1000, 1000))
        plan.set_deflate(1)
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple(shape), plan)


def virtual(file, other):
    layout = h5py.VirtualLayout(shape=(7,), dtype="f8")
    layout[:] = h5py.VirtualSource(other, "Rd_r", shape=(7,))
    del file["Rd_r"]
    file.create_virtual_dataset("Rd_r", layout)


def link(name, made):
    def change(file):
        del file[name]
        file[name] = made(file)
    return change


class Crafted(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        resource.setrlimit(resource.RLIMIT_AS, (4 * 2**30, 4 * 2**30))
        cls.folder = tempfile.TemporaryDirectory()
        sphere = mc.Sphere(0, 0, 0.05, 0.01, 1.5, 3, 40, 0.5)
        scene = mc.Scene([mc.Layer(1.4, 1, 100, 0.9, 0.1, bodies=[sphere])], photons=300, nr=7, nz=5, na=2, map=mc.Map(3, 2, 0.1, 0.2), format="A")
        mc.run(scene, output_dir=cls.folder.name)
        cls.sound = {}
        for end in ("mco", "h5"):
            with open(os.path.join(cls.folder.name, "scene." + end), "rb") as file:
                cls.sound[end] = file.read()
        cls.whole = cls.sound["mco"]
        cls.sound["mco"] = re.sub(rb"# more of this run stands .*\n", b"", cls.whole)  # a copy that does not refer to an .h5 file beside it
        cls.other = os.path.join(cls.folder.name, "other.h5")
        with h5py.File(cls.other, "w") as file:
            file["Rd_r"] = np.full(7, SECRET)
        cls.pipe = os.path.join(cls.folder.name, "pipe.h5")
        os.mkfifo(cls.pipe)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def write(self, end, content):
        path = os.path.join(self.folder.name, "strange." + end)
        with open(path, "wb") as file:
            file.write(content)
        return path

    def refused(self, path, text):
        with self.assertRaisesRegex(mc.InputError, text) as caught:
            mc.read(path)
        self.assertNotIn("\n", str(caught.exception))

    def test_a_bit_of_a_single_number(self):
        """A flipped bit of a single number is found. No chunk has a checksum of such a number; the header of its data set has."""
        path = self.write("h5", self.sound["h5"])
        with h5py.File(path) as file:
            numbers = {name: item[()] for name, item in file.items() if isinstance(item, h5py.Dataset) and item.shape == ()}
        self.assertGreater(len(numbers), 20)
        for name, number in numbers.items():
            found = self.sound["h5"].find(np.float64(number).tobytes())
            if number == 0 or found < 0:
                continue
            content = bytearray(self.sound["h5"])
            content[found + 3] ^= 4
            with self.subTest(name):
                self.refused(self.write("h5", bytes(content)), "checksum")

    def test_h5(self):
        raw = os.path.join(self.folder.name, "raw")
        with open(raw, "wb") as file:
            file.write(np.full(7, SECRET).tobytes())
        variable = h5py.string_dtype()
        changes = (
                (link("Rd", lambda file: h5py.ExternalLink(self.other, "Rd_r")), "Rd is a link"),
                (link("Rd_r", lambda file: h5py.ExternalLink(self.other, "Rd_r")), "Rd_r is a link"),
                (link("Rd_r", lambda file: h5py.ExternalLink(self.pipe, "Rd_r")), "Rd_r is a link"),
                (link("Rd_r", lambda file: h5py.SoftLink("/Tt_r")), "Rd_r is a link"),
                (link("call/command", lambda file: h5py.ExternalLink(self.other, "Rd_r")), "command is a link"),
                (lambda file: virtual(file, self.other), "Rd_r lies in other files"),
                (lambda file: replace(file, "Rd_r", shape=(7,), dtype="f8", external=[(raw, 0, 56)]), "Rd_r lies in other files"),
                (lambda file: replace(file, "Rd_r", data=np.zeros(7), compression="lzf"), "Rd_r has the filters"),
                (lambda file: replace(file, "Rd_r", data=np.zeros(7), fletcher32=True), "Rd_r has the filters"),
                (lambda file: replace(file, "Rd_r", data=["a"] * 7, dtype=variable), "Rd_r is of a strange type"),
                (lambda file: replace(file, "Rd_r", data=np.zeros(7, "f8,f8")), "Rd_r is of a strange type"),
                (lambda file: replace(file, "Rd_r", data=h5py.Empty("f8")), "Rd_r is of a strange type"),
                (lambda file: replace(file, "Rd_r", shape=(8,), chunks=(1,), fillvalue=7.0, dtype="f8", compression=1)
                 .write_direct(np.ones(1), np.s_[:], np.s_[:1]), "Rd_r lacks chunks"),
                (lambda file: file.create_dataset("more", data=np.zeros(7)), "more has an axis without a name"),
                (lambda file: replace(file, "Rd_r", shape=(7,), maxshape=(None,), chunks=(10**8,), dtype="f8"), "Rd_r has chunks of"),
                (lambda file: promise(file, "Rd_r", (32000, 32000), "chunked"), "Rd_r promises 8192000000 bytes"),
                (lambda file: promise(file, "Rd_r", (2**30, 2**30), "contiguous"), "Rd_r promises 9223372036854775808 bytes"),
                (lambda file: file.attrs.create("photons", np.arange(10**4)), "attribute photons is an array"),
                (lambda file: file.attrs.create("title", np.array([b"a", b"b"])), "attribute title is an array"),
                (lambda file: file.attrs.create("title", "text", dtype=variable), "attribute title is an array or of a strange type"),
                (lambda file: file.attrs.create("photons", np.inf), "infinity"), (lambda file: file.attrs.create("run", np.bytes_("one")), "int"),
                (lambda file: file["Rd"].attrs.create("units", np.zeros(3)), "attribute units is an array"),
                (lambda file: file["r"].attrs.create("CLASS", np.zeros(3)), "attribute CLASS is an array"),
                (lambda file: file["r"].attrs.create("REFERENCE_LIST", "text"), "attribute REFERENCE_LIST is of a strange type"),
                (lambda file: file["r"].attrs.create("REFERENCE_LIST", 3), "attribute REFERENCE_LIST is of a strange type"),
                (lambda file: file.pop("Rd"), "expected the array Rd"), (lambda file: file.pop("r"), "A_rz has an axis without a name"))
        for change, text in changes:
            path = self.write("h5", self.sound["h5"])
            with h5py.File(path, "r+") as file:
                change(file)
            with self.subTest(text):
                self.refused(path, r"strange\.h5: not an \.h5 file of a result .*" + text)

    def test_a_value_many_times(self):
        """A value that is linked many times is refused: the sum of all promised bytes is bounded."""
        path = self.write("h5", self.sound["h5"])
        with h5py.File(path, "r+") as file:
            big = file.create_dataset("big", data=np.zeros(100000), chunks=(100000,), compression=9)
            big.dims[0].label = "big"
            for i in range(1000):
                file[f"big{i}"] = big
            file["big"].make_scale("big")
        self.refused(path, "bytes .expected at most")

    def test_mco(self):
        text = self.sound["mco"].decode()
        more = "expected a whole number from 1 to"
        rsp, rd = re.search(r"^RAT .*\n(\S+).*\n(\S+)", text, re.M).groups()
        for old, new, said in (("5\t7\t2\t", "2000000000\t7\t2\t", f":16: nz = '2000000000' .{more} "), ("5\t7\t2\t", "5\t7\t0\t", f":16: na = '0' .{more}"),
                               ("5\t7\t2\t", "5\t-7\t2\t", f":16: nr = '-7' .{more}"), ("5\t7\t2\t", "5\t7_0\t2\t", f":16: nr = '7_0' .{more}"),
                               ("5\t7\t2\t", "5\t7.0\t2\t", f":16: nr = '7.0' .{more}"), ("\n1\t\t\t\t\t#", "\n900000000\t\t\t\t\t#", f":18: number of layers = '900000000' .{more}"),
                               *(("\n300 ", f"\n{word} ", f":14: photons = '{word}' .expected a whole number above 0") for word in ("0", "-300", "1e999", "1e30", "300.5", "3_00")),
                               ("\n300 ", "\n\u0663 ", ":14: photons = '.' .expected a whole"), ("\n300 ", "\n300 7 ", ":14: number too many = '7' .expected the end of the line"),
                               *(("\n0.01\t0.01\t", f"\n{word}\t0.01\t", f":15: dz = '{word}' .expected a number above 0") for word in ("0", "-0.01", "nan", "1e400")),
                               *(("\n1.4\t1\t100\t0.9\t0.1", "\n" + line, f":21: {what} .expected a number") for line, what in
                                 (("0 1 9 0 1", "n = '0'"), ("1 nan 9 0 1", "mua = 'nan'"), ("1 -1 9 0 1", "mua = '-1'"), ("1 1 9 2 1", "g = '2'"), ("1 1 9 0 -1", "d = '-1'"), ("1 1 9 0", "d = 'nothing'"))),
                               *((f"\n{rd} ", f"\n{word} ", rf":26: RAT.1. = '{seen}' .expected a number, one of 4") for word, seen in
                                 (("inf", "inf"), ("zero", "zero"), ("nan", "nan"), ("1e400", "1e400"), ("0.8_2", "0.8_2"), ("\u0663.5", "..5"), ("1.#INF", "1.#INF"), ("0.8\xa0", "0.8."))),
                               (f"\n{rd} ", f"\n0.8 {rd} ", r":28: RAT.4. = '\S+' .expected the end of 4 numbers"), (f"\n{rsp} ", "\n# ", r":30: RAT.3. = 'A_l'"),
                               ("\nse_RAT ", "\nse_RAT #\nzero ", r":\d+: se_RAT.0. = 'zero' "), ("\nbooks ", "\nbooks #\n1\nmore ", r":\d+: books.1. = 'more' .expected a number, one of 12"),
                               ("\nA_rz", "\nB_rz", ": A_rz.0. = 'nothing'"), ("A1", "A1\0", "NUL byte"), ("\n", "\r", "last line is missing"),
                               (text, "A1\nInParm\nname" + " " * 10**6 + ".", ": photons = 'nothing'")):
            self.assertIn(old, text)
            with self.subTest(said):
                self.refused(self.write("mco", text.replace(old, new, -1 if old == "\n" else 1).encode()), r"strange\.mco.*" + said)

    def test_mco_beside_another_h5(self):
        """Only an .h5 of the same run is read beside an .mco. A damaged one is refused."""
        beside = self.write("h5", self.sound["h5"])
        self.assertIn("A_body", mc.read(self.write("mco", self.whole)))
        with self.assertWarnsRegex(UserWarning, "of another run"):
            self.assertEqual(mc.read(self.write("mco", re.sub(rb"Identity: \w+", b"Identity: 0123456789abcdef", self.whole))).lacks, beside)
        self.write("h5", self.sound["h5"][:3000])
        self.refused(self.write("mco", self.whole), "strange.h5: not an .h5 file of a result")
        os.unlink(beside)
        with self.assertWarnsRegex(UserWarning, "strange.h5 is missing"):
            self.assertEqual(mc.read(self.write("mco", self.whole)).lacks, beside)

    def test_mco_as_the_program_takes_them(self):
        """An .mco is read as the program reads it: with other ends of lines, with a byte order mark, with comments after numbers. Of two equal
        sections the first counts."""
        text, sound = self.sound["mco"], mc.read(self.write("mco", self.sound["mco"]))
        for other in (text.replace(b"\n", b"\r\n"), b"\xef\xbb\xbf" + text, text.replace(b"\nse_RAT ", b"\nRAT #\n1\n2\n3\n4\n\nse_RAT "),
                      text.replace(b"\n300 ", b"\n3e2 photons ")):
            self.assertNotEqual(other, text)
            xr.testing.assert_identical(mc.read(self.write("mco", other)), sound)

    def test_no_files(self):
        os.mkdir(os.path.join(self.folder.name, "folder.h5"))
        for name in ("pipe.h5", "folder.h5", "none.mco"):
            self.refused(os.path.join(self.folder.name, name), "expected the path of a file that is there")

    def test_names_with_strange_ends_of_lines(self):
        path = self.write("mco", self.sound["mco"].replace(b"\nscene.mco \tA", "\na\u2028b\x0c.mco \tA".encode()))
        self.assertEqual(mc.read(path).title, "a\u2028b\x0c.mco")

    def mangle(self, dice, content):
        """Returns the content with a few bytes or words changed, or a piece cut out, doubled, or moved."""
        changed = bytearray(content)
        for _ in range(dice.choice((1, 1, 2, 8))):
            at, to = sorted(dice.randrange(len(changed) + 1) for _ in range(2))
            to = min(to, at + dice.choice((1, 8, 8, 64, len(changed))))
            kind = dice.randrange(7)
            if kind == 0:
                changed[at:to] = b""
            elif kind == 1:
                changed[at:to] *= 2
            elif kind == 2:
                changed[at:to] = bytes(to - at)
            elif kind == 3:
                changed[at:to] = b"\xff" * (to - at)
            elif kind == 4:
                start = dice.randrange(len(changed) + 1)
                changed[at:to] = changed[start:start + to - at]
            else:
                for _ in range(3):
                    changed[dice.randrange(len(changed))] = dice.randrange(256)
        return bytes(changed)

    def mangle_words(self, dice, content):
        words = re.split(r"(\s+)", content.decode())
        for _ in range(dice.choice((1, 1, 3, 10))):
            words[2 * dice.randrange(dice.choice((40, len(words))) // 2)] = dice.choice(WORDS)
        return "".join(words).encode()

    def survives(self, end, content):
        try:
            self.assertIsInstance(mc.read(self.write(end, content)), xr.Dataset)
            return 1
        except mc.InputError as error:
            self.assertNotIn("\n", str(error))
            return 0

    def test_mangled(self):
        dice, kinds = random.Random(1), {"bytes of .mco": ("mco", self.mangle), "words of .mco": ("mco", self.mangle_words), "bytes of .h5": ("h5", self.mangle)}
        for name, (end, change) in kinds.items():
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read = sum(self.survives(end, change(dice, self.sound[end])) for _ in range(MANGLED))
            print(f"{name}: {MANGLED} files, {read} of them read")
            self.assertTrue(0 < read < MANGLED)



if __name__ == "__main__":
    if len(sys.argv) > 1:
        MANGLED = int(sys.argv.pop())
    unittest.main()
