#!/usr/bin/env python3
"""What still images say of their color, their orientation, their layers and pages. Usage: stills_test.py PATINATE [unittest arguments]

Pictures are made here, byte by byte; what a history must show of them comes from the standards' formulas."""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

from still_files import (ADOBE, D50, D65, HEIGHT, P3, REC2020, REC709, WIDTH, adaptation, apply, chromaticities, codes, colors, deep_exr, exif, exif_adobe,
                         exr, flat, gamma, inverse, light, png, profile, psd, radiance, read_frame, rec709, scene, scene_rows, srgb, tiff, tiff_in_strips,
                         times, upright, white, xyz_from_rgb)

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
# A history's frames are half floats; a profile's numbers have 16 bits behind the point.
HALF = 2e-3


class Stills(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_stills_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_patinate(self, *arguments):
        return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, errors="surrogateescape", timeout=120)

    def project(self, pictures, **more):
        """A folder with the pictures {name: bytes} and a project of all of them."""
        capture = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        for name, content in pictures.items():
            (capture / name).write_bytes(content)
        (capture / "capture.json").write_text(json.dumps({"format": "patinate.capture", "version": 1, "name": "n", "kind": "fixed",
                                                          "frames": {"pattern": "photo*", "interval": 1}, **more}))
        return capture

    def ingest(self, pictures, *options, **more):
        """Rows of each frame, and what was said."""
        capture = self.project(pictures, **more)
        result = self.run_patinate("ingest", capture, "-o", capture / "history", "--highlights", "keep", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return [read_frame(f) for f in sorted((capture / "history/frames").glob("*.exr"))], result.stderr

    def shows(self, picture, expected, *said, name="photo.png", limit=HALF, **more):
        (rows, *_), text = self.ingest({name: picture}, **more)
        self.assertEqual((len(rows[0]), len(rows)), (len(expected[0]), len(expected)), text)
        worst = max(abs(a - b) for got, want in zip(rows, expected) for p, q in zip(got, want) for a, b in zip(p, q))
        self.assertLessEqual(worst, limit, text)
        for words in said:
            self.assertIn(words, text)
        return text


class Color(Stills):
    def test_png_says_its_color_by_chunks_of_which_the_first_of_the_standard_counts(self):
        def power(value):
            return lambda v: v ** value
        adobe = lambda v: rec709(v, ADOBE)  # noqa: E731
        self.shows(png(codes(), gamma(1.0)), light(lambda v: v), "color: linear (PNG gAMA)")
        self.shows(png(codes(), gamma(1 / 1.8)), light(power(1.8)), "color: gamma 1.8")
        self.shows(png(codes(), gamma(0.45455)), light(), "color: sRGB (PNG gAMA)")
        self.shows(png(codes(), gamma(0.45455), chromaticities(ADOBE)), light(power(1 / 0.45455), adobe), "Adobe RGB (PNG gAMA and cHRM)")
        self.shows(png(codes(), chromaticities(ADOBE)), light(srgb, adobe), "color: Adobe RGB (PNG cHRM)")
        self.shows(png(codes(), (b"sRGB", b"\0"), gamma(1.0)), light(), "color: sRGB")
        self.shows(png(codes(), (b"cICP", b"\x0c\x0d\0\1"), (b"sRGB", b"\0")), light(srgb, lambda v: rec709(v, P3)), "color: Display P3")
        self.shows(png(codes(), (b"cICP", b"\x09\x08\0\1")), light(lambda v: v, lambda v: rec709(v, REC2020)), "color: BT.2020, linear")
        embedded = b"iCCP", b"x\0\0" + zlib.compress(profile(P3, 2.0, b"mine"))
        self.shows(png(codes(), embedded, gamma(1.0)), light(power(2.0), lambda v: rec709(v, P3)), "color: mine (ICC profile)")

    def test_tiff_has_profiles_primaries_lab_and_inks(self):
        size = (WIDTH, HEIGHT, 3, flat(codes()))
        mine = profile(ADOBE, 1.8, b"mine")
        self.shows(tiff([(*size, [(34675, 7, len(mine), mine)])]), light(lambda v: v ** 1.8, lambda v: rec709(v, ADOBE)), "mine (ICC profile)", name="photo.tif")
        rationals = b"".join(struct.pack("<II", round(v * 1e5), 100000) for xy in REC2020 for v in xy)
        self.shows(tiff([(*size, [(319, 5, 6, rationals)])]), light(srgb, lambda v: rec709(v, REC2020)), "BT.2020 (TIFF)", name="photo.tif")
        lab = [[(30 + 20 * x, (5 * y - 8) % 256, (7 * x - 30) % 256) for x in range(WIDTH)] for y in range(HEIGHT)]

        def linear(pixel):
            signed = [v - 256 if v > 127 else v for v in pixel]
            fy = (pixel[0] / 2.55 + 16) / 116
            cube = [t ** 3 if t > 6 / 29 else 3 * (6 / 29) ** 2 * (t - 4 / 29) for t in (fy + signed[1] / 500, fy, fy - signed[2] / 200)]
            xyz = [v * w for v, w in zip(cube, white(D50))]
            return apply(times(inverse(xyz_from_rgb(REC709)), adaptation(D50, D65)), xyz)
        self.shows(tiff([(WIDTH, HEIGHT, 3, flat(lab), [(262, 3, 1, 8)])]), [[linear(p) for p in row] for row in lab], "color: CIE L*a*b*", name="photo.tif")
        inks = [[(*pixel, 40) for pixel in row] for row in codes()]
        ink = [[[srgb((1 - v / 255) * (1 - 40 / 255)) for v in pixel] for pixel in row] for row in codes()]
        # Rounded to 8-bit codes on the way.
        self.shows(tiff([(WIDTH, HEIGHT, 4, flat(inks), [(262, 3, 1, 5)])]), ink, "CMYK without a profile", name="photo.tif", limit=0.01)

    def test_codes_of_12_bits_in_16_are_what_the_tiff_declares(self):
        wide = [[tuple(v * 16 for v in pixel) for pixel in row] for row in codes()]
        pixels = b"".join(struct.pack("<H", v) for row in wide for pixel in row for v in pixel)
        expected = [[[srgb(v / 4095) for v in pixel] for pixel in row] for row in wide]
        self.shows(tiff([(WIDTH, HEIGHT, 3, pixels, [(281, 3, 3, struct.pack("<3H", 4095, 4095, 4095))])]), expected, "codes up to 4095", name="photo.tif")

    def test_a_response_that_is_given_holds_and_says_so(self):
        self.shows(png(codes(), gamma(1.0)), light(), "`response` srgb is used instead of what the photographs say of their color: linear", response="srgb")
        self.assertNotIn("`response`", self.shows(png(codes(), (b"sRGB", b"\0")), light(), response="srgb"))

    def test_what_is_damaged_is_named_and_not_used(self):
        broken = b"iCCP", b"x\0\0" + zlib.compress(b"no profile")
        self.shows(png(codes(), broken), light(), "not used: its ICC profile is damaged")
        self.shows(png(codes(), (b"iCCP", b"x\0\0nothing")), light(), "not used: its ICC profile is damaged")
        self.shows(png(codes(), (b"cICP", b"\x63\x0d\0\1")), light(), "not used: its color code points")
        self.shows(png(codes(), (b"cHRM", b"\0" * 32)), light(), "not used: its chromaticities make no color space")
        mine = profile(P3, 2.2)
        for length in range(0, len(mine), 37):
            with self.subTest(length=length):
                self.ingest({"photo.tif": tiff([(WIDTH, HEIGHT, 3, flat(codes()), [(34675, 7, max(5, length), mine[:max(5, length)])])])})

    def test_what_lies_outside_of_rec_709_is_counted(self):
        vivid = [[(0, 255, 0)] * WIDTH for _ in range(HEIGHT)]
        text = self.shows(png(vivid, (b"cICP", b"\x0c\x0d\0\1")), [[rec709((0, 1, 0), P3)] * WIDTH for _ in range(HEIGHT)])
        self.assertIn("the colors of 60 pixels of photo.png (100 %) lie outside of Rec. 709", text)

    def test_radiance_says_exposure_and_primaries(self):
        # 128 of 256 with the exponent 128 is 0.5 [Ward Larson, Shakespeare 1998]; exposures multiply.
        pixel = (0.5, 0.25, 0.125)

        def rows(of):
            return [[list(of(pixel))] * WIDTH] * HEIGHT
        self.shows(radiance(), rows(tuple), name="photo.hdr")
        self.shows(radiance(b"EXPOSURE=2", b"EXPOSURE= 4"), rows(lambda v: [x / 8 for x in v]), "light divided by its EXPOSURE 8", name="photo.hdr")
        said = b"PRIMARIES= " + b" ".join(b"%g" % v for xy in (*REC2020, D65) for v in xy)
        self.shows(radiance(said), rows(lambda v: rec709(v, REC2020)), "color: BT.2020 (Radiance PRIMARIES)", name="photo.hdr")
        for line, problem in ((b"EXPOSURE=-1", "its EXPOSURE `-1` is no number > 0"), (b"COLORCORR=1 1 2", "its COLORCORR is not used"), (b"PRIMARIES=1 2", "its PRIMARIES are damaged")):
            self.shows(radiance(line), rows(tuple), problem, name="photo.hdr")
        (self.folder / "xyz.hdr").write_bytes(radiance().replace(b"rgbe", b"xyze"))
        self.assertIn("is a Radiance picture in CIE XYZ", self.run_patinate("info", "xyz.hdr").stderr)
        # Primaries of a float TIFF are those of light.
        rationals = b"".join(struct.pack("<II", round(v * 1e5), 100000) for xy in REC2020 for v in xy)
        values = b"".join(struct.pack("<3f", *pixel) for _ in range(WIDTH * HEIGHT))
        self.shows(tiff([(WIDTH, HEIGHT, 3, values, [(319, 5, 6, rationals), (339, 3, 3, struct.pack("<H", 3) * 3)])]), rows(lambda v: rec709(v, REC2020)), "BT.2020 (TIFF)", name="photo.tif")

    def test_exif_says_adobe_rgb(self):
        self.shows(png(codes(), (b"eXIf", exif_adobe())), light(lambda v: v ** (563 / 256), lambda v: rec709(v, ADOBE)), "color: Adobe RGB (EXIF)")


class Geometry(Stills):
    def test_every_orientation_is_turned_in_every_format_and_order_of_bytes(self):
        for orientation in range(1, 9):
            with self.subTest(orientation=orientation):
                expected = upright(light(), orientation)
                for order in "<>":
                    self.shows(png(codes(), (b"eXIf", exif(orientation, order))), expected)
                page = (WIDTH, HEIGHT, 3, flat(codes()), [(274, 3, 1, orientation)])
                text = self.shows(tiff([page]), expected, name="photo.tif")
                self.assertEqual(orientation > 1, f"EXIF orientation {orientation}" in text)

    def test_xmp_says_the_orientation_of_a_png_as_an_attribute_too(self):
        xmp = b'<rdf:RDF><rdf:Description tiff:Orientation="6"/></rdf:RDF>'
        self.shows(png(codes(), (b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + xmp)), upright(light(), 6))

    def test_what_is_not_read_is_refused_as_what_it_is(self):
        inks = bytes(4 * WIDTH * HEIGHT)
        for name, content, said in (
                ("jpeg.tif", tiff([(WIDTH, HEIGHT, 4, inks, [(262, 3, 1, 5)])]).replace(struct.pack("<HHII", 259, 3, 1, 1), struct.pack("<HHII", 259, 3, 1, 7)), "is a CMYK TIFF compressed as JPEG"),
                ("float.tif", tiff([(WIDTH, HEIGHT, 4, 4 * inks, [(262, 3, 1, 5), (339, 3, 4, struct.pack("<H", 3) * 4)])]), "floating point"),
                ("dark.tif", tiff([(WIDTH, HEIGHT, 1, bytes(range(60)), [(262, 3, 1, 3), (320, 3, 768, b"".join(struct.pack("<H", i % 256) for i in range(768)))])]), "has a palette of 8 bits"),
                ("inks.psd", psd(4, 4), "is a PSD in CMYK mode"), ("lab.psd", psd(9, 3), "is a PSD in Lab mode"),
                ("moving.png", png(codes(), (b"acTL", struct.pack(">II", 3, 0)), (b"fcTL", struct.pack(">IIIIIHHBB", 0, WIDTH, HEIGHT, 0, 0, 1, 10, 0, 0))), "is an animated PNG of 3 pictures"),
                ("sky.fits", b"SIMPLE  =                    T".ljust(80) + b"BITPIX  =                    8".ljust(80) + b"NAXIS   =                    2".ljust(80)
                 + b"NAXIS1  =                    4".ljust(80) + b"NAXIS2  =                    4".ljust(80) + b"END".ljust(2880 - 400) + bytes(2880), "is a FITS image")):
            (self.folder / name).write_bytes(content)
            result = self.run_patinate("info", name)
            self.assertEqual(result.returncode, 3, name + result.stdout)
            self.assertIn(said, result.stderr)
        self.shows(psd(3, 3), light(), name="photo.psd")
        self.shows(png(codes(), (b"acTL", struct.pack(">II", 1, 0))), light())  # Of one picture it is none.
        (self.folder / "solid").write_text("solid a\nendsolid a\n")
        self.assertIn("give it the extension of its format", self.run_patinate("info", "solid").stderr)

    def test_pixels_that_are_not_square_are_said(self):
        jfif = b"\xff\xe0\0\x10JFIF\0\1\1\0%s\0\0"
        jpeg = subprocess.run(["oiiotool", "--pattern", "constant:color=0.2,0.4,0.6", "10x6", "3", "-o", "plain.jpg"], cwd=self.folder, capture_output=True)
        square = png(codes(), (b"pHYs", struct.pack(">IIB", 2835, 2835, 1)))
        self.assertNotIn("taken as square", self.shows(square, light()))
        wide, high = "its pixels, 2 times as wide as high, are taken as square", "its pixels, 1.5 times as high as wide, are taken as square"
        self.shows(png(codes(), (b"pHYs", struct.pack(">IIB", 100, 200, 0))), light(), wide)
        rationals = [(282, 5, 1, struct.pack("<II", 600, 2)), (283, 5, 1, struct.pack("<II", 200, 1))]
        self.shows(tiff([(WIDTH, HEIGHT, 3, flat(codes()), rationals)]), light(), high, name="photo.tif")
        aspect = b"pixelAspectRatio\0float\0" + struct.pack("<I", 4)
        self.shows(exr([(None, colors(), [])]).replace(aspect + struct.pack("<f", 1), aspect + struct.pack("<f", 2)), scene_rows(), wide, name="photo.exr")
        self.assertIn(high, self.ingest({"photo.hdr": radiance(b"PIXASPECT=1.5")})[1])
        if jpeg.returncode == 0:
            plain = (self.folder / "plain.jpg").read_bytes()
            start = 20 if plain[2:4] == b"\xff\xe0" else 2
            for density, is_said in ((struct.pack(">HH", 72, 144), True), (struct.pack(">HH", 72, 72), False), (bytes(4), False)):
                self.assertEqual(wide in self.ingest({"photo.jpg": plain[:2] + jfif % density + plain[start:]})[1], is_said)

    def test_heif_is_turned_by_itself_alone_and_a_sequence_is_no_picture(self):
        for name in ("photo.heic", "photo.avif"):
            made = subprocess.run(["oiiotool", "--pattern", "constant:color=0.2,0.4,0.6", "64x48", "3", "--attrib", "Orientation", "6", "-o", name], cwd=self.folder, capture_output=True)
            if made.returncode or not (self.folder / name).exists():
                continue  # Its library has no encoder.
            result = self.run_patinate("info", name)
            self.assertRegex(result.stdout + result.stderr, r"EXIF orientation 6\) is not used")
            self.assertIn("64 x 48", result.stdout)
            (self.folder / name).write_bytes((self.folder / name).read_bytes() + struct.pack(">I4s", 8, b"moov"))
            result = self.run_patinate("info", name)
            self.assertEqual(result.returncode, 3, result.stdout)
            self.assertIn("is a sequence of pictures", result.stderr)

    def test_dates_in_xmp_are_those_of_exif(self):
        def packet(body):
            return b'<rdf:RDF><rdf:Description' + body + b'</rdf:RDF>'
        for body, said in ((b' exif:DateTimeOriginal="2020-05-28T18:20:05.250+02:00"/>', "2020-05-28 18:20:05.250 +02:00 (EXIF DateTimeOriginal)"),
                           (b'><exif:DateTimeDigitized>2020-05-28T18:20:05</exif:DateTimeDigitized></rdf:Description>', "2020-05-28 18:20:05 (EXIF DateTimeDigitized)"),
                           (b' xmp:CreateDate="2020-05-28T18:20:05" xmp:ModifyDate="2020-05-28T18:20:05"/>', None)):
            (self.folder / "photo.png").write_bytes(png(codes(), (b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + packet(body))))
            (self.folder / "photo.tif").write_bytes(tiff([(WIDTH, HEIGHT, 3, flat(codes()), [(700, 1, len(packet(body)), packet(body))])]))
            for name in ("photo.png", "photo.tif"):
                text = self.run_patinate("info", name).stdout
                self.assertEqual(said is not None, "time:" in text, (name, body))
                self.assertIn(said or "", text, name)

    def test_an_orientation_that_changes_within_a_series_is_told_with_its_photographs(self):
        stored = {3: upright(codes(), 3), 1: codes()}
        pictures = {f"photo{i}.png": png(stored[o], (b"eXIf", exif(o))) for i, o in enumerate((1, 1, 3))}
        frames, text = self.ingest(pictures)
        self.assertEqual(frames[0], frames[2])
        self.assertIn("orientation: nothing said; not so in photo2.png: turned by 180 degrees (EXIF orientation 3)", text)

    def test_pages_that_are_copies_or_masks_are_no_photographs(self):
        copy = (5, 3, 3, flat([r[:5] for r in codes()[:3]]), [(254, 4, 1, 1)])
        whole = (WIDTH, HEIGHT, 3, flat(codes()), [])
        self.shows(tiff([whole, copy]), light(), "page: 1; page 2 is a reduced copy", name="photo.tif")
        self.shows(tiff([copy, whole]), light(), "page: 2; page 1 is a reduced copy", name="photo.tif")

    def test_a_tiff_that_holds_fewer_rows_than_it_says_is_refused(self):
        for order in "<>":
            for pack in (None, zlib.compress):
                self.shows(tiff_in_strips(HEIGHT, 4, pack, order), light(), name="photo.tif")  # The last one is short.
                self.shows(tiff_in_strips(HEIGHT, HEIGHT, pack, order, 2**32 - 1), light(), name="photo.tif")
                for name, content in (("strips", tiff_in_strips(2 * HEIGHT, 2, pack, order)), ("one row more", tiff_in_strips(HEIGHT + 1, 3, pack, order)),
                                      ("one strip", tiff_in_strips(2 * HEIGHT, HEIGHT, pack, order))):
                    (self.folder / "photo.tif").write_bytes(content)
                    result = self.run_patinate("info", "photo.tif")
                    self.assertEqual(result.returncode, 3, (name, order, pack, result.stdout))
                    self.assertRegex(result.stderr, rf"photo\.tif: says that it has \d+ rows and holds {HEIGHT}; it is damaged", name)
            (self.folder / "photo.tif").write_bytes(tiff_in_strips(2 * HEIGHT, HEIGHT, zlib.compress, order, 2 * HEIGHT))
            result = self.run_patinate("info", "photo.tif")
            self.assertIn(f"says that it has {2 * HEIGHT} rows and holds {HEIGHT}; it is damaged", result.stderr, "a packed strip that ends early")
        whole, short = (WIDTH, HEIGHT, 3, flat(codes()), []), (WIDTH, HEIGHT, 3, flat(codes()), [])
        (self.folder / "photo.tif").write_bytes(tiff([whole, short]).replace(struct.pack("<HHII", 257, 4, 1, HEIGHT), struct.pack("<HHII", 257, 4, 1, 9 * HEIGHT)))
        self.assertEqual(self.run_patinate("info", "photo.tif").returncode, 3)

    def test_alpha_that_a_header_does_not_declare_is_not_used(self):
        def tga(attributes):
            pixels = bytes(v for row in codes() for r, g, b in row for v in (b, g, r, 0))
            return struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, WIDTH, HEIGHT, 32, 0x20 | attributes) + pixels
        self.shows(tga(0), light(), "alpha: not used", name="photo.tga")
        capture = self.project({"photo.tga": tga(8)})
        self.assertIn("no pixel is opaque", self.run_patinate("ingest", capture, "-o", "x").stderr)
        pixels = bytes(v for row in codes()[::-1] for r, g, b in row for v in (b, g, r, 0))
        bmp = b"BM" + struct.pack("<IHHI", 54 + len(pixels), 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, WIDTH, HEIGHT, 1, 32, 0, len(pixels), 0, 0, 0, 0) + pixels
        self.shows(bmp, light(), "alpha: not used", name="photo.bmp")
        extra = flat([[(*p, 0) for p in row] for row in codes()])
        self.shows(tiff([(WIDTH, HEIGHT, 4, extra, [(338, 3, 1, 0)])]), light(), name="photo.tif")


class Exr(Stills):
    def test_chromaticities_are_converted(self):
        xy = struct.pack("<8f", *(v for p in (*REC2020, D65) for v in p))
        part = None, colors(), [(b"chromaticities", b"chromaticities", xy)]
        self.shows(exr([part]), scene_rows(lambda v: rec709(v, REC2020)), "color: BT.2020 (EXR chromaticities)", name="photo.exr")
        xyz, equal = ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), (1 / 3, 1 / 3)
        part = None, colors(), [(b"chromaticities", b"chromaticities", struct.pack("<8f", *(v for p in (*xyz, equal) for v in p)))]
        # Values that are none of Rec. 709 are many here: negative ones become 0, and half floats are relative.
        self.shows(exr([part]), scene_rows(lambda v: rec709(v, xyz, equal)), "color: CIE XYZ, white 0.3333, 0.3333 (EXR chromaticities)", name="photo.exr", limit=4 * HALF)

    def test_the_one_part_or_layer_in_color_is_the_photograph(self):
        depth = {"Z": lambda x, y: 7.0}
        self.shows(exr([("depth", depth, []), ("image", colors(), [])]), scene_rows(), "layer: part 2 (image) of 2", name="photo.exr")
        self.shows(exr([(None, {**colors("cam1.diffuse.", 1.0), "cam1.depth.Z": depth["Z"]}, [])]), scene_rows(), "layer: cam1.diffuse of 2", name="photo.exr")
        lower = {f"main.{n}": (lambda x, y, c=c: scene(x, y, c)) for c, n in enumerate(("red", "green", "blue"))}
        self.shows(exr([(None, lower, [])]), scene_rows(), "layer: main", name="photo.exr")
        shadow = {k: (lambda x, y: 0.5) for k in colors("shadow.")}
        self.shows(exr([(None, {**colors("x.Combined."), **shadow}, [])]), scene_rows(), "layer: x.Combined of 2", name="photo.exr")
        self.shows(exr([(None, {**colors(), **shadow}, [])]), scene_rows(), name="photo.exr")
        # Alpha of the layer takes what is transparent off the mask, and is divided out.
        self.shows(exr([(None, {k: (lambda x, y, f=f: 0.5 * f(x, y)) for k, f in colors("x.", 1.0).items()}, [])]), scene_rows(), name="photo.exr")

    def test_several_pictures_in_color_are_refused_by_their_names(self):
        capture = self.project({"photo.exr": exr([(None, {**colors("first."), **colors("second.")}, [])])})
        result = self.run_patinate("ingest", capture, "-o", "x")
        self.assertEqual(result.returncode, 3)
        self.assertIn("holds several pictures in color (first, second)", result.stderr)

    def test_deep_pictures_are_refused_by_name_in_every_command(self):
        capture = self.project({"photo.exr": deep_exr()})
        said = "photo.exr: is a deep EXR, with several samples a pixel; flatten it"
        for arguments in (("info", capture / "photo.exr"), ("ingest", capture, "-o", "x")):
            result = self.run_patinate(*arguments)
            self.assertNotEqual(result.returncode, 0, arguments)
            self.assertIn(said, result.stderr, arguments)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        (capture / "capture.json").unlink()
        drafted = self.run_patinate("init", capture)
        self.assertIn(said, drafted.stderr)

    def test_the_default_view_is_shown(self):
        views = b"".join(struct.pack("<I", len(v)) + v for v in (b"left", b"right"))
        right = {k: (lambda x, y: 0.5) for k in colors("right.")}
        self.shows(exr([(None, {**colors(), **right}, [(b"multiView", b"stringvector", views)])]), scene_rows(), "layer: view left", name="photo.exr")

    def test_the_display_window_is_the_picture(self):
        window = 0, 0, WIDTH - 1, HEIGHT - 1
        self.shows(exr([(None, colors(), [])], (-3, -2, WIDTH + 4, HEIGHT + 1), window), scene_rows(), "window: display window, 10 x 6", name="photo.exr")
        # What no data cover is transparent, and so outside of the mask.
        part = [[scene(x, y, c) if 2 <= x < 8 and 1 <= y else 0.0 for c in range(3)] for y in range(HEIGHT) for x in range(WIDTH)]
        rows = [part[y * WIDTH:(y + 1) * WIDTH] for y in range(HEIGHT)]
        self.shows(exr([(None, colors(), [])], (2, 1, 7, HEIGHT + 3), window), rows, "is transparent", name="photo.exr")

    def test_data_beside_the_display_window_show_nothing(self):
        capture = self.project({"photo.exr": exr([(None, colors(), [])], (20, 20, 29, 25), (0, 0, WIDTH - 1, HEIGHT - 1))})
        result = self.run_patinate("ingest", capture, "-o", "x")
        self.assertEqual(result.returncode, 3)
        self.assertIn("photo.exr: shows nothing: its data lie outside of its display window", result.stderr)

    def test_light_beyond_half_floats_is_named_and_counts_as_saturated(self):
        bright = {k: (lambda x, y, f=f: 1e6 if (x, y) == (3, 2) else f(x, y)) for k, f in colors().items()}
        pictures = {"photo0.exr": exr([(None, bright, [])]), "photo1.exr": exr([(None, colors(), [])])}
        frames, text = self.ingest(pictures)
        self.assertEqual(frames[0][2][3], (65504.0,) * 3)
        self.assertIn("the light of 1 pixel of photo0.exr exceeds 65504, the largest half float", text)


class Names(Stills):
    def test_every_byte_of_a_name_works(self):
        page = tiff([(WIDTH, HEIGHT, 3, flat(codes()), [])])
        names = ["photo?.tif", "photo #1.tif", "photo 100%.tif", "photo?a=b&c.tif", "photo\n.tif", "photo\\.tif", "photo\udcff.tif", "photo:;'\"*[x].tif"]
        frames, _ = self.ingest({name: page for name in names})
        self.assertEqual(len(frames), len(names))
        self.assertTrue(all(frame == frames[0] for frame in frames))


class Said(Stills):
    def test_info_and_init_say_what_was_understood(self):
        page = tiff([(WIDTH, HEIGHT, 3, flat(codes()), [(274, 3, 1, 6)]), (5, 3, 3, bytes(45), [(254, 4, 1, 1)])])
        capture = self.project({"photo.tif": page})
        facts = json.loads(self.run_patinate("info", capture / "photo.tif", "--json").stdout)
        self.assertEqual(facts["orientation"], "turned by 90 degrees clockwise (EXIF orientation 6)")
        self.assertEqual(facts["page"], "1; page 2 is a reduced copy")
        self.assertEqual(facts["size"], [HEIGHT, WIDTH])
        (capture / "capture.json").unlink()
        (capture / "photo.tif").unlink()
        (capture / "photo.png").write_bytes(png(codes(), gamma(1.0)))
        said = self.run_patinate("init", capture).stderr
        self.assertIn("found: color: linear (PNG gAMA)", said)
        self.assertNotIn("response", json.loads((capture / "capture.json").read_text()))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
