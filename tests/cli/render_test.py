#!/usr/bin/env python3
"""Pictures of surfaces with all of their maps, as a user asks for them. Usage: render_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
USAGE, INPUT = 2, 3
SMALL = ["--width", "64", "--height", "64", "--samples", "4", "--occlusion-samples", "8"]


def png(width, height, pixel):
    """An image of 8 bit; pixel(x, y) gives red, green and blue."""
    rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(width)) for y in range(height))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


class Render(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_render_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.make("synth", "ledge", "--cells", "8", "-o", "ledge")
        scene = json.loads((cls.folder / "ledge/scene.json").read_text())
        scene["atlas"] = {"resolution": 128}
        scene["run"] = {"iterations": 40, "history_every": 10}
        scene["objects"].append(dict(scene["objects"][0], name="second", preset="copper", translate=[900, 0, 0]))
        (cls.folder / "ledge/small.json").write_text(json.dumps(scene))
        cls.make("simulate", "ledge/small.json", "-o", "wet")
        (cls.folder / "square.obj").write_text("v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
        for name, pixel in (("gray", lambda x, y: (128, 128, 128)), ("flat", lambda x, y: (128, 128, 255)), ("white", lambda x, y: (255, 255, 255)),
                            ("checks", lambda x, y: (255 * ((x + y) % 2),) * 3), ("sky", lambda x, y: (16 * x, 32 * y, 128))):
            (cls.folder / f"{name}.png").write_bytes(png(16, 8, pixel))

    @classmethod
    def run_in(cls, *arguments):
        return subprocess.run([PATINATE, *arguments], cwd=cls.folder, capture_output=True, text=True, timeout=300)

    @classmethod
    def make(cls, *arguments):
        result = cls.run_in(*arguments)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}")
        return result

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def fails(self, about, *arguments):
        result = self.run_in("render", *arguments, "-o", "never.png")
        self.assertEqual((result.returncode, result.stdout, len(result.stderr.splitlines())), (USAGE, "", 1), result.stderr)
        self.assertIn(about, result.stderr)

    def test_a_simulation_is_shown_at_its_end_with_all_of_its_maps(self):
        self.make("render", "wet", *SMALL, "-o", "all.png")
        self.assertIn("up to date", self.make("render", "wet", *SMALL, "-o", "all.png").stderr)
        self.make("render", "wet", *SMALL, "--threads", "1", "-o", "one_thread.png")
        self.assertEqual(self.bytes_of("all.png"), self.bytes_of("one_thread.png"))
        for name, more in (("dry", ["--film", "1000000"]), ("smooth", ["--relief", "0"]), ("color", ["--maps", "color", "--num-times", "1"])):
            self.make("render", "wet", *SMALL, *more, "-o", f"{name}.png")
            self.assertNotEqual(self.bytes_of("all.png"), self.bytes_of(f"{name}.png"), name)

    def test_its_course_is_shown_with_all_maps(self):
        said = self.make("render", "wet", *SMALL, "--num-times", "2", "-o", "course.png").stderr
        self.assertNotIn("end only", said)
        self.make("render", "wet", *SMALL, "--num-times", "2", "--maps", "color", "-o", "course_color.png")
        self.assertNotEqual(self.bytes_of("course.png"), self.bytes_of("course_color.png"))

    def test_a_simulation_of_an_earlier_version_shows_its_course_in_color_and_says_so(self):
        shutil.copytree(self.folder / "wet", self.folder / "earlier")
        file = self.folder / "earlier/history/history.json"
        history = json.loads(file.read_text())
        for frame in history["frames"]:
            del frame["amounts"]
        file.write_text(json.dumps(history))
        said = self.make("render", "earlier", *SMALL, "--num-times", "2", "-o", "course_earlier.png").stderr
        self.assertIn("known only at the end", said)
        self.make("render", "earlier", *SMALL, "--num-times", "2", "--maps", "color", "-o", "course_earlier_color.png")
        self.assertEqual(self.bytes_of("course_earlier.png"), self.bytes_of("course_earlier_color.png"))

    def test_views_and_turntables(self):
        report = json.loads(self.make("render", "wet", *SMALL, "--views", "front,left,30:60", "--json", "-o", "view_%d.png").stdout)
        self.assertEqual([f["view"] for f in report["images"]], [0, 1, 2])
        self.make("render", "wet", *SMALL, "--views", "90", "-o", "left_view.png")
        strip = struct.unpack(">II", self.bytes_of("left_view.png")[16:24])
        self.assertEqual(strip, (64, 64))  # one view is no strip
        self.make("render", "wet", *SMALL, "--turntable", "4", "-o", "turn.mp4")
        self.make("render", "square.obj", "--texture", "gray.png", *SMALL, "--turntable", "4", "-o", "square.mp4")
        self.assertGreater(len(self.bytes_of("square.mp4")), 500)

    def test_flat_maps_of_a_mesh_change_little_and_others_much(self):
        mesh = ["square.obj", "--texture", "gray.png", *SMALL, "--azimuth", "0"]
        self.make("render", *mesh, "--normal-map", "flat.png", "-o", "flat.exr")
        for name, more in (("wet", ["--wetness-map", "white.png"]), ("metal", ["--metalness-map", "white.png"]), ("rough", ["--roughness-map", "white.png"]),
                           ("bumpy", ["--height-map", "checks.png"]), ("lit", ["--environment", "sky.png"])):
            self.make("render", *mesh, *more, "-o", f"{name}.exr")
            self.assertNotEqual(self.bytes_of("flat.exr"), self.bytes_of(f"{name}.exr"), name)

    def test_a_near_light_within_the_mesh_is_said(self):
        wet = ["render", "wet", "--time", "40", *SMALL, "--light-distance"]
        self.assertIn("the light stands within the mesh's bounding box", self.make(*wet, "1", "-o", "dark.png").stderr)
        self.assertNotIn("stands within", self.make(*wet, "1e5", "-o", "lit.png").stderr)
        self.assertNotEqual(self.bytes_of("dark.png"), self.bytes_of("lit.png"))

    def test_mistakes_are_named(self):
        self.fails("front, left, back", "wet", "--views", "above")
        self.fails("show one time", "wet", "--views", "front", "--times", "0,1")
        self.fails("--turntable", "wet", "--turntable", "2.5")
        self.fails("X,Y,Z", "wet", "--target", "1,2")
        self.fails("above 0", "wet", "--distance", "0")
        self.fails("one of um, mm, cm, m", "square.obj", "--texture", "gray.png", "--unit", "ell")


if __name__ == "__main__":
    unittest.main()
