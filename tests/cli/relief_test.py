#!/usr/bin/env python3
"""Height change between registered scans. Usage: relief_test.py PATINATE [unittest arguments]"""
import csv
import json
import math
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WIDTH, HEIGHT, STEP = 120, 80, 0.1  # Points and mm: 12 mm x 8 mm.
# A pit of 40 micrometers, a Gaussian of 1.2 mm: the volume of its formula, pi * depth * width^2.
DEPTH, SPREAD = 0.04, 1.2
LOST_MM3 = math.pi * DEPTH * SPREAD * SPREAD


def surface(x, y):
    return 0.15 * math.sin(1.3 * x + 0.4 * y) + 0.1 * math.cos(0.9 * y) + 0.5 * math.exp(-((x + 3) ** 2 + y * y) / 3)


def pit(x, y):
    return -DEPTH * math.exp(-((x - 3) ** 2 + y * y) / SPREAD ** 2)


def write_scan(path, seed, change=lambda x, y: 0.0, turn=0.0, lift=0.0):
    """Loose points of their own, with 10 micrometers of noise, turned about y and lifted."""
    rng = random.Random(seed)
    points = []
    for j in range(HEIGHT):
        for i in range(WIDTH):
            x, y = (i + rng.random() - WIDTH / 2) * STEP, (j + rng.random() - HEIGHT / 2) * STEP
            z = surface(x, y) + change(x, y) + rng.gauss(0, 0.01)
            points.append((math.cos(turn) * x + math.sin(turn) * z, y, math.cos(turn) * z - math.sin(turn) * x + lift))
    header = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *[f"property double {a}" for a in "xyz"], "end_header"]
    path.write_text("\n".join(header + ["%.9g %.9g %.9g" % p for p in points]) + "\n")


class Relief(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_relief_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        write_scan(cls.folder / "day00.ply", 1)
        write_scan(cls.folder / "day07.ply", 2, turn=0.003, lift=0.2)
        write_scan(cls.folder / "day14.ply", 3, change=pit, turn=-0.002, lift=-0.1)
        subprocess.run([PATINATE, "register", "day00.ply", "day07.ply", "day14.ply", "--unit", "mm", "-o", "registered"], cwd=cls.folder, check=True, capture_output=True)

    def run_it(self, *arguments, code=0):
        result = subprocess.run([PATINATE, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=300)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def refuses(self, code, words, *arguments):
        result = self.run_it(*arguments, code=code)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        self.assertIn(words, result.stderr)

    def test_the_pit_is_found_with_its_volume_and_the_unchanged_step_shows_none(self):
        report = json.loads(self.run_it("height-change", "registered", "--times", "0,7,14", "--toward", "0,0,1", "-o", "out", "--json").stdout)
        first, same, pitted = report["steps"]
        self.assertTrue(first["reference"])
        self.assertLess(same["changed_share"], 0.01)
        self.assertLess(abs(same["mean_change_um"]), 4 * same["mean_change_stddev_um"])
        self.assertLess(abs(pitted["net"]["mm3"] + LOST_MM3), 4 * pitted["net"]["stddev_mm3"])
        self.assertLess(pitted["net"]["stddev_mm3"], 0.2 * LOST_MM3)  # An interval that says something.
        self.assertEqual(report["warnings"], [])
        rows = list(csv.DictReader((self.folder / "out/relief.csv").read_text().splitlines()))
        self.assertEqual([row["scan"] for row in rows], ["day07.ply", "day14.ply"])
        self.assertIn("Height change", (self.folder / "out/report.html").read_text())
        # What it makes is a history.
        self.run_it("validate", "out")
        self.assertIn("height", self.run_it("info", "out").stdout)
        self.assertIn("up to date", self.run_it("height-change", "registered", "--times", "0,7,14", "--toward", "0,0,1", "-o", "out").stderr)

    def test_a_stable_part_may_be_painted(self):
        self.run_it("height-change", "registered", "-o", "first")
        width, height = struct.unpack(">II", (self.folder / "first/change/0002.png").read_bytes()[16:24])
        # Black where the pit is: 2.4 mm, two of its widths, around (3, 0) mm; of 12 mm x 8 mm.
        rows = b"".join(b"\0" + bytes(0 if math.hypot(x / width * 12 - 9, y / height * 8 - 4) < 2.4 else 255 for x in range(width)) for y in range(height))
        (self.folder / "stays.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))))
        report = json.loads(self.run_it("height-change", "registered", "--stable", "stays.png", "-o", "again", "--json").stdout)
        self.assertLess(abs(report["steps"][2]["net"]["mm3"] + LOST_MM3), 4 * report["steps"][2]["net"]["stddev_mm3"])
        self.assertIn("outside", report["warnings"][0]["text"])  # Loose points have no outside.

    def test_where_the_larger_part_receded_the_surface_is_said_to_be_measured_against_it(self):
        write_scan(self.folder / "receded.ply", 4, change=lambda x, y: -0.1 if x > -1 else 0.0)
        self.run_it("register", "day00.ply", "receded.ply", "--unit", "mm", "--accept-failed", "-o", "most")
        report = json.loads(self.run_it("height-change", "most", "--toward", "0,0,1", "-o", "risen", "--json").stdout)
        self.assertIn("everything is measured against", report["warnings"][0]["text"])
        self.assertIn("--stable", report["warnings"][0]["cure"])

    def test_threads_change_nothing(self):
        for threads in ("1", "3"):
            self.run_it("height-change", "registered", "--threads", threads, "-o", f"threads{threads}")
        for file in ("change/0001.exr", "change/0002.exr", "height/0002.exr", "relief.csv"):
            self.assertEqual((self.folder / "threads1" / file).read_bytes(), (self.folder / "threads3" / file).read_bytes(), file)

    def test_bad_input_gets_one_line(self):
        self.refuses(2, "3 scans", "height-change", "registered", "--times", "0,7", "-o", "bad")
        self.refuses(2, "increases", "height-change", "registered", "--times", "0,7,7", "-o", "bad")
        (self.folder / "small.pgm").write_text("P2 2 1 255\n255 0\n")
        self.refuses(3, "expected those of the maps", "height-change", "registered", "--stable", "small.pgm", "-o", "bad")
        registration = json.loads((self.folder / "registered/registration.json").read_text())
        (self.folder / "unsaid").mkdir(exist_ok=True)
        (self.folder / "unsaid/registration.json").write_text(json.dumps({**registration, "unit": None}))
        self.refuses(3, "give --unit", "height-change", "unsaid", "-o", "bad")
        registration["scans"][1]["path"] = "../gone.ply"
        (self.folder / "unsaid/registration.json").write_text(json.dumps(registration))
        self.refuses(3, "day07.ply", "height-change", "unsaid", "-o", "bad")
        self.assertFalse((self.folder / "bad").exists())


if __name__ == "__main__":
    unittest.main()
