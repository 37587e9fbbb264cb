#!/usr/bin/env python3
"""`patinate history combine`: several histories as one, and transfers of it; `transfer --source-mask`. Usage: combine_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_combine_"))
USAGE, INPUT = 2, 3


def run(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=SHARED, capture_output=True, text=True, timeout=120)


def gray_png(path, width, height, code):
    rows = b"".join(b"\0" + bytes(code(x, y) for x in range(width)) for y in range(height))
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def setUpModule():
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "thin"],
                      ["synth", "crackle", "--width", "40", "--height", "56", "--num-frames", "4", "--seed", "7", "-o", "thick"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["ingest", "thin", "-o", "one"], ["ingest", "thick", "-o", "two"],
                      ["history", "combine", "one", "two", "-o", "library"]):
        result = run(*arguments)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")


def tearDownModule():
    shutil.rmtree(SHARED)


class Combine(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=SHARED))

    def refused(self, code, about, *arguments):
        result = run(*arguments, "-o", self.folder / "out")
        lines = [line for line in result.stderr.splitlines() if line.startswith("patinate: error: ")]
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertIn(about, lines[0])
        self.assertFalse((self.folder / "out").exists())

    def test_a_library_is_a_history(self):
        info = json.loads(run("info", "library", "--json").stdout)
        self.assertEqual([(part["width"], part["height"]) for part in info["library"]], [(48, 40), (40, 56)])
        self.assertEqual([c["name"] for c in info["controls"]], ["thickness", "history"])
        self.assertEqual(run("validate", "library").returncode, 0)
        self.assertIn("up to date", run("history", "combine", "one", "two", "-o", "library").stderr)
        result = run("export", "library", "--num-times", "2", "-o", self.folder / "out_%02d.png")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_the_key_is_that_of_its_parts(self):
        manifest = json.loads((SHARED / "library/history.json").read_text())
        self.assertEqual([part["key"] for part in manifest["library"]], [json.loads((SHARED / name / "history.json").read_text())["key"] for name in ("one", "two")])
        again = json.loads(run("history", "combine", SHARED / "one", SHARED / "two", "--json", "-o", self.folder / "again").stdout)
        self.assertEqual([part["x"] for part in again["histories"]], [part["x"] for part in manifest["library"]])
        self.assertEqual((self.folder / "again/history.json").read_bytes(), (SHARED / "library/history.json").read_bytes())

    def test_a_mask_says_where_each_applies(self):
        gray_png(SHARED / "which.png", 64, 64, lambda x, y: 255 if x >= 32 else 0)
        result = run("transfer", "library", "urn/mesh.obj", "--resolution", "64", "--control", "facing", "--control", "history=which.png", "-o", self.folder / "aged")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("history: 0 crackle, 1 crackle", result.stderr)
        controls = json.loads((self.folder / "aged/transfer.json").read_text())["controls"]
        self.assertEqual([(c["source"], c["mapping"]) for c in controls], [("thickness", "rank"), ("history", "physical")])
        self.assertEqual(run("validate", self.folder / "aged").returncode, 0)
        for command in (["texture", self.folder / "aged", "--time", "5", "-o", self.folder / "tex.png"], ["evaluate", self.folder / "aged", "--samples", "200", "-o", self.folder / "report"]):
            result = run(*command)
            self.assertEqual(result.returncode, 0, result.stderr)

    def test_a_transfer_without_the_control_is_told_of_it(self):
        result = run("transfer", "library", "urn/mesh.obj", "--resolution", "64", "--control", "facing", "-o", self.folder / "aged")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no control says which history applies where; give --control history=MAP", result.stderr)

    def test_what_cannot_be_combined(self):
        self.refused(INPUT, "at least two histories", "combine", "one")
        self.refused(INPUT, "urn/mesh.obj: is no history", "combine", "one", "urn/mesh.obj")
        self.refused(INPUT, "library: is a library already", "combine", "library", "one")
        self.refused(INPUT, "two: has no control `depth`", "combine", "one", "two", "--control", "age=thickness,depth")
        self.refused(USAGE, "names 1 controls for 2 histories", "combine", "one", "two", "--control", "age=thickness")
        self.refused(USAGE, "the library's name for it is missing", "combine", "one", "two", "--control", "thickness")
        self.refused(USAGE, "did you mean `span`", "combine", "one", "two", "--clock", "spam")
        self.refused(USAGE, "found 3 histories; expected two", "combine", "one", "two", "one", "--where", "thickness")
        self.refused(USAGE, "leave out --control", "combine", "one", "two", "--where", "thickness", "--texel-size", "1")
        self.refused(USAGE, "leave out --control", "combine", "one", "two", "--where", "thickness", "--control", "a=thickness,thickness")
        self.refused(USAGE, "where `thicknes`: position 1: unknown name `thicknes`; there are `thickness`", "combine", "one", "two", "--where", "thicknes")

    def test_one_history_inside_another_is_a_history(self):
        result = run("history", "combine", "one", "two", "--where", "smoothstep(0.4, 0.6, thickness)", "-o", self.folder / "layers")
        self.assertEqual(result.returncode, 0, result.stderr)
        manifest = json.loads((self.folder / "layers/history.json").read_text())
        self.assertEqual([c["name"] for c in manifest["controls"]], ["thickness"])
        self.assertNotIn("parts", manifest)
        self.assertEqual(run("validate", self.folder / "layers").returncode, 0)
        self.assertIn("up to date", run("history", "combine", "one", "two", "--where", "smoothstep(0.4, 0.6, thickness)", "-o", self.folder / "layers").stderr)
        result = run("history", "combine", "one", "two", "--where", "0.1*thickness", "-o", self.folder / "nothing")
        self.assertEqual(result.returncode, INPUT)
        self.assertIn("is above a half nowhere", result.stderr)
        self.assertFalse((self.folder / "nothing").exists())

    def test_source_masks(self):
        gray_png(SHARED / "small.png", 20, 40, lambda x, y: 255)
        gray_png(SHARED / "none.png", 48, 40, lambda x, y: 0)
        gray_png(SHARED / "three.png", 48, 40, lambda x, y: 255 if y == 9 and 20 <= x < 23 else 0)
        gray_png(SHARED / "right.png", 48, 40, lambda x, y: 255 if x >= 20 else 0)
        transfer = ["transfer", "one", "urn/mesh.obj", "--resolution", "64", "--control", "facing", "--source-mask"]
        self.refused(INPUT, "small.png: source mask: is 20 x 40 pixels; the history one is 48 x 40", *transfer, "small.png")
        self.refused(INPUT, "none.png: source mask: leaves no pixel", *transfer, "none.png")
        self.refused(INPUT, "give a larger mask, or a smaller --neighborhood", *transfer, "three.png")
        self.refused(INPUT, "missing.png", *transfer, "missing.png")
        result = run(*transfer, "right.png", "-o", self.folder / "aged")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads((self.folder / "aged/transfer.json").read_text())["source_mask"], "source_mask.png")
        self.assertIn("up to date", run(*transfer, "right.png", "-o", self.folder / "aged").stderr)


if __name__ == "__main__":
    unittest.main()
