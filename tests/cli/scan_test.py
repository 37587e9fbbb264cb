#!/usr/bin/env python3
"""A scan under a fixed camera, from photographs to a transfer. Usage: scan_test.py PATINATE [unittest arguments]"""
import json
import math
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
WIDTH, HEIGHT, FOCAL, DISTANCE = 60, 45, 100.0, 100.0

CALIBRATION = """%YAML:1.0
---
image_width: 60
image_height: 45
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 100., 0., 29.5, 0., 100., 22., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
"""
POSE = """rotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., -1., 0., 0., 0., -1. ]
translation: [ 0., 0., 100. ]
"""


def height(x):
    return 2.0 * math.cos(math.pi * x / 10.0)


def write_png(path, pixel):
    rows = b"".join(b"\0" + bytes(c for x in range(WIDTH) for c in pixel(x, y)) for y in range(HEIGHT))
    part = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)) +
                     part(b"IDAT", zlib.compress(rows)) + part(b"IEND", b""))


def write_relief(path, n=48, side=50.0):
    """Furrows along y, narrower than the picture, with UVs."""
    lines = []
    for j in range(n + 1):
        for i in range(n + 1):
            x = side * i / n - side / 2
            lines += [f"v {x:.6f} {side * j / n - side / 2:.6f} {height(x):.6f}", f"vt {i / n:.6f} {j / n:.6f}"]
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i + 1
            b, c, d = a + 1, a + n + 2, a + n + 1
            lines += [f"f {a}/{a} {b}/{b} {c}/{c}", f"f {a}/{a} {c}/{c} {d}/{d}"]
    path.write_text("\n".join(lines) + "\n")


class Scan(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_scan_"))
        self.addCleanup(shutil.rmtree, self.folder)
        write_relief(self.folder / "relief.obj")
        (self.folder / "camera.yml").write_text(CALIBRATION + POSE)
        (self.folder / "frames").mkdir()
        for t in range(4):
            # Furrows dry last: a pixel darkens with the height of what it shows (without perspective in z).
            def pixel(x, y):
                wet = (1.0 - height((x - 29.5) * DISTANCE / FOCAL) / 2.0) / 2.0
                return (int(200 - 40 * t * (1 - wet)), int(150 - 30 * t * (1 - wet) + x % 3), 90 + y % 4)
            write_png(self.folder / f"frames/{t}.png", pixel)
        self.write_project()

    def write_project(self, **more):
        project = {"format": "patinate.capture", "version": 1, "name": "relief", "kind": "fixed", "unit": "mm",
                   "frames": {"pattern": "frames/*.png", "interval": 1}, "scan": {"mesh": "relief.obj", "camera": "camera.yml"}}
        project.update(more)
        (self.folder / "capture.json").write_text(json.dumps({k: v for k, v in project.items() if v is not None}))

    def run_(self, *arguments):
        return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True)

    def succeeds(self, *arguments):
        result = self.run_(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def fails(self, message):
        result = self.run_("ingest", "capture.json", "-o", "bad")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn(message, result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        return result.stderr

    def test_photographs_with_a_scan_become_a_history_that_transfers_by_accessibility(self):
        self.succeeds("validate", "capture.json")
        self.succeeds("ingest", "capture.json", "--scan-scale", "2", "-o", "history")
        history = json.loads((self.folder / "history/history.json").read_text())
        self.assertEqual([c["name"] for c in history["controls"]], ["accessibility"])
        self.assertEqual(history["controls"][0]["unit"], "1/mm")
        self.assertEqual(history["maps"], {"position": "maps/position.exr", "normal": "maps/normal.exr", "texel_size": "maps/texel_size.exr"})
        for file in [history["mask"], *history["maps"].values()]:
            self.assertTrue((self.folder / "history" / file).exists(), file)
        self.assertAlmostEqual(history["texel_size_mm"], DISTANCE / FOCAL, delta=0.25)
        self.succeeds("validate", "history")
        self.assertIn("up to date", self.succeeds("ingest", "capture.json", "--scan-scale", "2", "-o", "history").stderr)
        self.succeeds("transfer", "history", "relief.obj", "--unit", "mm", "--control", "accessibility", "--scale", "2",
                      "--resolution", "64", "-o", "aged")
        self.succeeds("texture", "aged", "--time", "3", "-o", "aged.png")

    def test_a_photograph_that_comes_later_leaves_the_scan_as_it_is(self):
        self.succeeds("ingest", "capture.json", "-o", "history")
        before = (self.folder / "history/maps/position.exr").stat()
        shutil.copy(self.folder / "frames/3.png", self.folder / "frames/4.png")
        self.succeeds("ingest", "capture.json", "-o", "history")
        after = (self.folder / "history/maps/position.exr").stat()
        self.assertEqual((before.st_ino, before.st_mtime_ns), (after.st_ino, after.st_mtime_ns))

    def test_mistakes_are_one_line_that_says_what_would_be_right(self):
        self.write_project(unit=None)
        self.fails("um, mm, cm or m")
        self.write_project(unit="m")
        (self.folder / "camera.yml").write_text(CALIBRATION)
        self.fails("has no `rotation`")
        (self.folder / "camera.yml").write_text(CALIBRATION + POSE.replace("100.", "-100."))
        self.fails("behind the camera; check `unit` and the camera's pose")
        (self.folder / "camera.yml").write_text("nonsense")
        self.fails("is no OpenCV calibration")
        self.write_project(scan={"mesh": "relief.obj", "camera": "missing.yml"})
        self.fails("missing.yml")
        self.write_project(scan={"mesh": "points.ply", "camera": "camera.yml"})
        (self.folder / "camera.yml").write_text(CALIBRATION + POSE)
        (self.folder / "points.ply").write_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                                                "end_header\n0 0 0\n")
        self.assertIn("point cloud", self.fails("points.ply"))


if __name__ == "__main__":
    unittest.main()
