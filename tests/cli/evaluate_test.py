#!/usr/bin/env python3
"""How good a texture is, as a user would ask. Usage: evaluate_test.py PATINATE [unittest arguments]"""
import base64
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

from command_case import nightly

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_evaluate_"))
WIDTH, HEIGHT = 96, 80


def patinate(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True)


def write_png16(path, width, height, pixel):
    """RGB of 16 bit; pixel(x, y) -> (r, g, b)."""
    rows = b"".join(b"\0" + b"".join(struct.pack(">HHH", *pixel(x, y)) for x in range(width)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_nnf(path, width, height, source):
    path.write_bytes(b"".join(struct.pack("<ii", *source(x, y)) for y in range(height) for x in range(width)))


def setUpModule():
    patinate("synth", "crackle", "--width", WIDTH, "--height", HEIGHT, "--num-frames", 4, "-o", "photos")
    result = patinate("ingest", "photos", "-o", "crackle")
    assert result.returncode == 0, result.stderr
    patinate("synth", "sculpture", "--resolution", 24, "-o", "urn")
    result = patinate("transfer", "crackle", "urn/mesh.obj", "--control", "facing", "--resolution", 64, "-o", "aged")
    assert result.returncode == 0, result.stderr
    write_nnf(WORK / "same.nnf", WIDTH, HEIGHT, lambda x, y: (x, y))
    write_png16(WORK / "same16.png", WIDTH, HEIGHT, lambda x, y: (x, y, 0))
    write_nnf(WORK / "tiles.nnf", WIDTH, HEIGHT, lambda x, y: (x % 16, y % 16))


def tearDownModule():
    shutil.rmtree(WORK)


def figures(report, name):
    return {f["name"]: f for m in report["maps"] if m["name"] == name for f in m["figures"]}


class Evaluate(unittest.TestCase):
    def test_a_transfer_beside_the_maps_of_other_tools(self):
        arguments = ("evaluate", "aged", "same.nnf", "tiles.nnf", "--history", "crackle", "--control", "thickness=crackle/controls/thickness.exr", "--samples", 1000, "-o", "report")
        result = patinate(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("tiles:", result.stderr)
        report = json.loads((WORK / "report/evaluation.json").read_text())
        self.assertEqual([m["name"] for m in report["maps"]], ["aged", "same", "tiles"])
        same, tiles, aged = figures(report, "same"), figures(report, "tiles"), figures(report, "aged")
        self.assertEqual(same["control_error_mean"]["value"], 0)
        self.assertEqual(same["coherent_share"]["value"], 1)
        self.assertEqual(same["texels_per_piece"]["value"], WIDTH * HEIGHT)
        self.assertEqual(tiles["rep64"]["value"], 1)
        self.assertAlmostEqual(tiles["used_share"]["value"], 256 / (WIDTH * HEIGHT), 9)
        self.assertGreater(tiles["patch_swd"]["value"], same["patch_swd"]["value"])
        energy = json.loads((WORK / "aged/transfer.json").read_text())["energy"]
        self.assertAlmostEqual(aged["energy"]["value"], energy["energy"], 9)
        self.assertAlmostEqual(aged["control_error_mean"]["value"], energy["control_error_mean"], 3)
        self.assertAlmostEqual(aged["coherent_share"]["value"], energy["coherent_share"], 9)
        self.assertIsNotNone(aged["seam_gradient_ratio"]["value"])
        # The source as it is wanted costs nothing; a share of it lies too near the border, 3 of 96 and of 80 pixels on each side.
        self.assertEqual((same["audit_ratio"]["value"], same["audit_energy"]["value"], same["audit_optimal_share"]["value"]), (1, 0, 1))
        self.assertAlmostEqual(same["audit_excluded"]["value"], 1 - 90 * 74 / (WIDTH * HEIGHT), delta=0.03)
        self.assertGreater(tiles["audit_energy"]["value"], 0.1)
        self.assertGreater(aged["audit_ratio"]["value"], 1)
        self.assertAlmostEqual(aged["audit_energy"]["value"], energy["energy"], delta=0.1 * energy["energy"])
        page = (WORK / "report/evaluation.html").read_text()
        self.assertFalse("http:" in page)
        self.assertIn("up to date", patinate(*arguments).stderr)

    def test_lines_are_measured_at_each_threshold(self):
        report = json.loads(patinate("evaluate", "same.nnf", "--history", "crackle", "--control", "thickness=crackle/controls/thickness.exr", "--audits", 0, "--samples", 500, "-o", "lines", "--json").stdout)
        same, lines = figures(report, "same"), report["maps"][0]["lines"]
        self.assertEqual([line["kind"] for line in lines[:3]], ["dark"] * 3)
        self.assertEqual(same["border_contrast"]["value"], 1)
        self.assertEqual(same["rep_all"]["value"], 0)
        for name in ("line_share", "dead_ends", "closed_share", "line_length", "line_length_q4"):
            self.assertEqual(same[name]["value"], same[name]["split"], name)
            apart = [f["value"] for line in lines[:3] for f in line["figures"] if f["name"] == name]
            self.assertAlmostEqual(same[name]["value"], sum(apart) / 3, 6)

    def test_pictures_are_no_larger_than_a_page_needs(self):
        write_nnf(WORK / "long.nnf", 1800, 16, lambda x, y: (x % WIDTH, y))
        write_png16(WORK / "long.png", 1800, 16, lambda x, y: (x * 36, 0, 0))
        result = patinate("evaluate", "long.nnf", "--history", "crackle", "--control", "thickness=long.png", "--audits", 0, "--samples", 500, "-o", "long")
        self.assertEqual(result.returncode, 0, result.stderr)
        page = (WORK / "long/evaluation.html").read_text()
        self.assertIn("(1800 x 16, shown at 1600 x 14)", page)
        sizes = [struct.unpack(">II", base64.b64decode(data[:64])[16:24]) for data in re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", page)]
        self.assertEqual(max(width for width, _ in sizes), 1600)
        self.assertIn((WIDTH, HEIGHT), sizes)

    def test_a_png_of_codes_says_the_same_as_raw_numbers(self):
        found = [json.loads(patinate("evaluate", file, "--history", "crackle", "--samples", 500, *more, "-o", file + ".report", "--json").stdout)["maps"][0]
                 for file, more in (("same.nnf", ("--control", "crackle/controls/thickness.exr")), ("same16.png", ()))]
        self.assertEqual(found[0]["hash"], found[1]["hash"])
        self.assertEqual([f.get("undefined") for m in found for f in m["figures"] if f["name"] == "audit_ratio"], [None, "no control was given"])

    @nightly
    def test_audits_can_be_left_out_and_follow_the_seed(self):
        def audit(*options):
            result = patinate("evaluate", "aged", "--samples", 500, *options, "-o", "audit", "--force", "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            return {f["name"]: f["value"] for f in json.loads(result.stdout)["maps"][0]["figures"] if f["name"].startswith("audit")}
        self.assertEqual(audit("--audits", 0), {})
        one = audit("--audits", 50)
        self.assertEqual(one, audit("--audits", 50, "--threads", 1))
        self.assertNotEqual(one["audit_energy"], audit("--audits", 50, "--seed", 2)["audit_energy"])

    def test_the_tools_own_picture_is_checked_against_its_coordinates(self):
        patinate("texture", "aged", "--time", 0, "-o", "unused.png")
        result = patinate("evaluate", "same.nnf", "--history", "crackle", "--picture", "crackle/frames/0003.exr", "--samples", 500, "-o", "own", "--json")
        self.assertEqual(figures(json.loads(result.stdout), "same")["explained_pixels"]["value"], 1, result.stderr)

    def test_what_is_missing_is_said_in_a_line(self):
        write_nnf(WORK / "beyond.nnf", WIDTH, HEIGHT, lambda x, y: (x + 1, y))
        for arguments, code, text in ((("same.nnf",), 2, "--history: is needed for same.nnf"), (("same.nnf", "--history", "crackle"), 3, "does not say its size; give --control or --picture"),
                                      (("tiles.nnf", "--history", "crackle", "--picture", "same16.png", "--control", "crackle/controls/nothing.exr"), 3, "nothing.exr: "),
                                      (("beyond.nnf", "--history", "crackle", "--picture", "same16.png"), 3, "texel 95, 0 comes from 96, 0, which is not in the source of 96 x 80"),
                                      (("same.nnf", "--history", "crackle", "--control", "crackle/controls/thickness.exr:2"), 2, "weight and mapping are the tool's own"),
                                      (("crackle", "--history", "crackle"), 3, "transfer"),
                                      (("aged", "aged"), 3, "two maps are called `aged`"),
                                      (("urn/mesh.obj", "--history", "crackle"), 3, "mesh.obj")):
            result = patinate("evaluate", *arguments, "-o", "bad")
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(text, result.stderr)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            self.assertFalse((WORK / "bad").exists())


if __name__ == "__main__":
    unittest.main()
