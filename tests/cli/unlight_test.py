#!/usr/bin/env python3
"""`patinate unlight` as a newcomer types it: a relief under lamps, from photographs to albedo. Usage: unlight_test.py PATINATE [unittest arguments]"""
import json
import math
import os
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
SIZE, FOCAL, DISTANCE = 48, 96.0, 100.0
LAMPS = [(150 * math.cos(a), 150 * math.sin(a), 160.0) for a in (0.2, 1.3, 2.4, 3.5, 4.6, 5.7)]
STRENGTH = 90000.0
ALBEDO = (0.5, 0.35, 0.2)


def relief(x, y):
    """Height and its slopes."""
    return 1.5 * math.cos(x / 3) * math.cos(y / 4), -0.5 * math.sin(x / 3) * math.cos(y / 4), -0.375 * math.cos(x / 3) * math.sin(y / 4)


def pixel_place(i, j):
    """Where a pixel's ray meets the relief; the camera stands at z = 100, y of the world is up."""
    dx, dy = (i - (SIZE - 1) / 2) / FOCAL, -(j - (SIZE - 1) / 2) / FOCAL
    z = 0.0
    for _ in range(60):
        z = relief(dx * (DISTANCE - z), dy * (DISTANCE - z))[0]
    return dx * (DISTANCE - z), dy * (DISTANCE - z), z


def lit(place, lamp):
    x, y, z = place
    _, sx, sy = relief(x, y)
    n = [-sx, -sy, 1.0]
    to = [lamp[0] - x, lamp[1] - y, lamp[2] - z]
    d = math.sqrt(sum(v * v for v in to))
    cosine = sum(a * b for a, b in zip(n, to)) / d / math.sqrt(sum(v * v for v in n))
    return max(0.0, cosine) / d ** 2 / math.pi


def srgb(v):
    v = min(1.0, max(0.0, v))
    return round(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055))


def write_png(path, pixel, width=SIZE, height=SIZE):
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))
    part = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     part(b"IDAT", zlib.compress(rows)) + part(b"IEND", b""))


def write_scan(path, n=80, side=60.0):
    lines = []
    for j in range(n + 1):
        for i in range(n + 1):
            x, y = side * i / n - side / 2, side * j / n - side / 2
            lines.append(f"v {x:.6f} {y:.6f} {relief(x, y)[0]:.6f}")
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i + 1
            lines += [f"f {a} {a + 1} {a + n + 2}", f"f {a} {a + n + 2} {a + n + 1}"]
    path.write_text("\n".join(lines) + "\n")


def run(*arguments, cwd=None):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)


class Unlight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = pathlib.Path(tempfile.mkdtemp(prefix="patinate_unlight_"))
        places = [[pixel_place(i, j) for i in range(SIZE)] for j in range(SIZE)]
        for k, lamp in enumerate(LAMPS):
            light = [[STRENGTH * lit(places[j][i], lamp) for i in range(SIZE)] for j in range(SIZE)]
            write_png(cls.work / f"light{k}.png", lambda x, y: [srgb(a * light[y][x] + 0.01) for a in ALBEDO])
            write_png(cls.work / f"undecoded{k}.png", lambda x, y: [round(255 * min(1, a * light[y][x])) for a in ALBEDO])
        write_png(cls.work / "dark.png", lambda x, y: [srgb(0.01)] * 3)
        write_scan(cls.work / "scan.obj")
        cls.step = {"format": "patinate.unlight", "version": 1, "name": "relief", "unit": "mm",
                    "camera": {"width": SIZE, "height": SIZE, "matrix": [[FOCAL, 0, (SIZE - 1) / 2], [0, FOCAL, (SIZE - 1) / 2], [0, 0, 1]],
                               "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "translation": [0, 0, DISTANCE]},
                    "lights": [{"position": p, "intensity": [STRENGTH] * 3} for p in LAMPS],
                    "photos": [f"light{k}.png" for k in range(len(LAMPS))], "ambient": "dark.png", "scan": "scan.obj"}

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.work)

    def write_step(self, **changes):
        step = {**self.step, **changes}
        path = self.work / "step.json"
        path.write_text(json.dumps({k: v for k, v in step.items() if v is not None}))
        return path

    def error(self, **changes):
        result = run("unlight", self.write_step(**changes), "-o", "broken", cwd=self.work)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        self.assertFalse((self.work / "broken").exists())
        return result.stderr

    def test_light_of_the_hollows_is_taken_off_on_request_and_reported(self):
        result = run("unlight", self.write_step(), "--interreflection", "--specular", "none", "-o", "hollows", cwd=self.work)
        self.assertEqual(result.returncode, 0, result.stderr)
        made = json.loads((self.work / "hollows/unlight.json").read_text())
        own = made["interreflection"]
        self.assertGreater(own["p95"], own["median"])
        self.assertLess(own["p95"], 0.2)
        self.assertIn("came from other places of the surface", made["notes"][0])
        self.assertEqual(run("validate", "hollows", cwd=self.work).returncode, 0)

    def test_every_kind_of_result_is_told_and_checked(self):
        for specular in ("none", "material"):
            result = run("unlight", self.write_step(), "--specular", specular, "-o", specular, cwd=self.work)
            self.assertEqual(result.returncode, 0, result.stderr)
            maps = json.loads((self.work / specular / "unlight.json").read_text())["maps"]
            self.assertEqual("metalness" in maps, specular == "material")
            told = run("info", specular, "--json", cwd=self.work)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertEqual(json.loads(told.stdout)["maps"], list(maps))
            self.assertEqual(run("validate", specular, cwd=self.work).returncode, 0)

    def test_albedo_comes_out_flat_and_right(self):
        result = run("unlight", self.write_step(), "-o", "unlit", "--json", cwd=self.work)
        self.assertEqual(result.returncode, 0, result.stderr)
        said = json.loads(result.stdout)
        made = json.loads((self.work / "unlit/unlight.json").read_text())
        self.assertEqual(said["determined_pixels"], made["determined_pixels"])
        self.assertGreater(made["determined_pixels"], 0.98 * made["surface_pixels"])
        self.assertLess(made["residual"], 0.01)
        for light in made["lights"]:
            self.assertLess(light["leave_one_out"]["rms"], 0.015)
        self.assertEqual(made["notes"], [])
        for name in ("albedo.exr", "stddev.exr", "normal.exr", "specular.exr", "mask.png", "report.html", "samples/06.png", "run.json"):
            self.assertTrue((self.work / "unlit" / name).exists(), name)
        page = (self.work / "unlit/report.html").read_text()
        self.assertIn("samples/01.png", page)
        told = run("info", "unlit", "--json", cwd=self.work)
        self.assertEqual(told.returncode, 0, told.stderr)
        facts = json.loads(told.stdout)
        self.assertEqual((facts["kind"], facts["lights"], facts["size"]), ("unlit", len(LAMPS), [SIZE, SIZE]))
        self.assertEqual(facts["maps"], ["albedo", "stddev", "normal", "mask", "specular"])
        self.assertEqual(run("validate", "unlit", cwd=self.work).returncode, 0)
        self.assertNotIn("interreflection", made)
        shutil.copytree(self.work / "unlit", self.work / "damaged")
        write_png(self.work / "damaged/mask.png", lambda x, y: [255] * 3, SIZE - 1, SIZE)
        wrong = run("validate", "damaged", cwd=self.work)
        self.assertEqual(wrong.returncode, 3)
        self.assertIn("mask.png", wrong.stderr)
        told = run("info", "unlit/albedo.exr", "--json", cwd=self.work)
        self.assertEqual(told.returncode, 0, told.stderr)
        again = run("unlight", self.write_step(), "-o", "unlit", cwd=self.work)
        self.assertIn("up to date", again.stderr)

    def test_the_same_bytes_for_any_number_of_threads(self):
        for threads in (1, 3):
            self.assertEqual(run("unlight", self.write_step(), "-o", f"t{threads}", "--threads", threads, cwd=self.work).returncode, 0)
        files = sorted(p.relative_to(self.work / "t1") for p in (self.work / "t1").rglob("*") if p.is_file() and p.name not in ("run.json", "job.json"))
        self.assertGreater(len(files), 10)
        for file in files:
            self.assertEqual((self.work / "t1" / file).read_bytes(), (self.work / "t3" / file).read_bytes(), file)

    def test_strengths_that_are_not_known(self):
        lights = [{"position": p} for p in LAMPS]
        result = run("unlight", self.write_step(lights=lights), "-o", "unknown", "--strengths", "--json", cwd=self.work)
        self.assertEqual(result.returncode, 0, result.stderr)
        made = json.loads((self.work / "unknown/unlight.json").read_text())
        self.assertFalse(made["is_absolute"])
        for light in made["lights"]:
            self.assertAlmostEqual(light["strength"][0], 1.0, delta=0.02)  # They are equal.
        self.assertIn("scale of its own", made["notes"][0])

    def test_undecoded_photographs_are_noticed(self):
        linear = {"photos": [f"undecoded{k}.png" for k in range(len(LAMPS))], "ambient": None}
        self.assertEqual(run("unlight", self.write_step(**linear, response="linear"), "-o", "right", cwd=self.work).returncode, 0)
        self.assertEqual(json.loads((self.work / "right/unlight.json").read_text())["notes"], [])
        self.assertEqual(run("unlight", self.write_step(**linear), "-o", "wrong", cwd=self.work).returncode, 0)
        self.assertIn("`response` is srgb, but decoded as linear", json.loads((self.work / "wrong/unlight.json").read_text())["notes"][-1])

    def test_directional_lights_without_a_scan(self):
        lights = [{"direction": [x / 219.3, y / 219.3, 160 / 219.3], "intensity": [4.0, 4.0, 4.0]} for x, y, _ in LAMPS]
        result = run("unlight", self.write_step(lights=lights, scan=None, camera=None, unit=None), "-o", "stereo", cwd=self.work)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.work / "stereo/normal.exr").exists())
        result = run("unlight", self.work / "step.json", "--interreflection", "-o", "hollows_of_nothing", cwd=self.work)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("--interreflection needs a scan", result.stderr)

    def test_what_is_wrong_is_said_in_one_line(self):
        write_png(self.work / "small.png", lambda x, y: [1, 2, 3], 10, 12)
        black = self.work / "black.png"
        write_png(black, lambda x, y: [0, 0, 0])
        white = self.work / "white.png"
        write_png(white, lambda x, y: [255, 255, 255])
        photos = self.step["photos"]
        self.assertIn("small.png: is 10 x 12 pixels; expected 48 x 48", self.error(photos=photos[:5] + ["small.png"]))
        self.assertIn("gone.png", self.error(photos=photos[:5] + ["gone.png"]))
        self.assertIn("one light for each of the 5 photographs; these are 6", self.error(photos=photos[:5]))
        self.assertIn("photograph 6 is black", self.error(photos=photos[:5] + ["black.png"], ambient=None))
        self.assertIn("saturated (white)", self.error(photos=["white.png"] * 6, ambient=None))
        self.assertIn("no light reaches", self.error(lights=[{"position": [p[0], p[1], -300], "intensity": [1, 1, 1]} for p in LAMPS]))
        for bad in (0, -5):
            self.assertIn("intensity", self.error(lights=self.step["lights"][:5] + [{"position": [1, 2, 300], "intensity": [1, bad, 1]}]))
        self.assertIn("`unit`", self.error(camera={**self.step["camera"], "translation": [0, 0, -300]}))
        self.assertIn("\"camera\"", self.error(camera=None))
        self.assertIn("\"scan\"", self.error(scan=None))
        self.assertIn("\"unit\"", self.error(unit=None))
        self.assertIn("fotos", self.error(fotos=[]))
        self.assertIn("scan.ply", self.error(scan="scan.ply"))

    def test_a_photograph_that_is_all_white_is_left_out_and_named(self):
        write_png(self.work / "white.png", lambda x, y: [255, 255, 255])
        result = run("unlight", self.write_step(photos=self.step["photos"][:5] + ["white.png"]), "-o", "white", cwd=self.work)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("photograph 6 is saturated", result.stderr)


if __name__ == "__main__":
    unittest.main()
