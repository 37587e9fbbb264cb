#!/usr/bin/env python3
"""Lookups, time maps, movies, image sequences and color curves, as a user asks for them. Usage: pictures_test.py PATINATE"""
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from small_scene import make_small_scene

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_pictures_"))
CANNOT, USAGE, INPUT = 1, 2, 3


def run(*arguments, cwd=SHARED, **more):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120, **more)


def setUpModule():
    make_small_scene(PATINATE, SHARED)


def tearDownModule():
    shutil.rmtree(SHARED)


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_pictures_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def make(self, *arguments, **more):
        result = run(*arguments, cwd=self.folder, **more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def fails(self, code, about, *arguments):
        result = run(*arguments, cwd=self.folder)
        self.assertEqual((result.returncode, result.stdout, len(result.stderr.splitlines())), (code, "", 1), result.stderr)
        self.assertIn(about, result.stderr)

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


class Lookups(Case):
    def test_between_frames(self):  # Frames at 0, 7.5, 15, 22.5.
        aged = SHARED / "aged"
        for name, more in (("first", ["--time", 0]), ("second", ["--time", 7.5]), ("held", ["--time", 7, "--between", "hold"]),
                           ("nearest", ["--time", 7, "--between", "nearest"]), ("blend", ["--time", 7])):
            self.make("texture", aged, *more, "-o", f"{name}.exr")
        info = {name: self.pixels(f"{name}.exr") for name in ("first", "second", "held", "nearest", "blend")}
        self.assertEqual(info["held"], info["first"])
        self.assertEqual(info["nearest"], info["second"])
        self.assertNotIn(info["blend"], (info["first"], info["second"]))

    def pixels(self, name):
        """The file without its key."""
        content = self.bytes_of(name)
        key = json.loads(self.make("info", name, "--json").stdout)["key"]
        return content.replace(key.encode(), b"")

    def test_a_constant_time_map_is_a_plain_lookup(self):
        aged = SHARED / "aged"
        self.make("texture", aged, "--time-map", "0*height", "--times", "9,20", "-o", "map.exr")
        self.make("texture", aged, "--time", 9, "-o", "plain.exr")
        self.assertEqual(self.pixels("map.exr"), self.pixels("plain.exr"))
        self.fails(USAGE, "--times LOW,HIGH", "texture", aged, "--time-map", "height", "--time", 3, "-o", "x.exr")
        self.fails(USAGE, "did you mean `height`", "texture", aged, "--time-map", "heigth", "-o", "x.exr")

    def test_several_times_are_numbered_files(self):
        made = json.loads(self.make("texture", SHARED / "aged", "--num-times", 3, "-o", "t_%03d.png", "--json").stdout)
        self.assertEqual([image["file"] for image in made["images"]], ["t_000.png", "t_001.png", "t_002.png"])
        (self.folder / "t_001.png").unlink()
        kept = (self.folder / "t_000.png").stat().st_mtime_ns
        self.make("texture", SHARED / "aged", "--num-times", 3, "-o", "t_%03d.png")
        self.assertEqual((self.folder / "t_000.png").stat().st_mtime_ns, kept)
        self.assertTrue((self.folder / "t_001.png").exists())
        self.fails(USAGE, "%04d", "texture", SHARED / "aged", "--times", "0,5", "-o", "x.png")

    def test_what_is_no_transfer_says_what_to_do(self):
        self.fails(INPUT, "make a transfer of it first", "texture", SHARED / "history", "--time", 1, "-o", "x.png")
        self.fails(INPUT, "the order is patinate transfer HISTORY MESH", "transfer", SHARED / "urn/mesh.obj", SHARED / "history",
                   "--control", "facing", "-o", "swapped")
        self.fails(INPUT, "did you mean `aged`", "texture", SHARED / "agde", "--time", 1, "-o", "x.png")
        self.fails(USAGE, "--time: is missing", "texture", SHARED / "aged", "-o", "x.png")


class Movies(Case):
    def test_equal_input_gives_equal_bytes_and_is_up_to_date(self):
        for name in ("a.mp4", "a.webm", "a.gif"):
            with self.subTest(name=name):
                command = ["export", SHARED / "aged", "--frames", 6, "--fps", 12, "-o", name]
                self.make(*command)
                first = self.bytes_of(name)
                self.assertIn("up to date", self.make(*command).stderr)
                self.make(*command[:-1], "b" + name, "--threads", 1)
                self.assertEqual(self.bytes_of("b" + name), first)
                self.fails(CANNOT, "--force", *command[:3], 7, *command[4:])

    def test_a_turntable_of_odd_size(self):
        self.make("render", SHARED / "aged", "--frames", 4, "--turn", 360, "--width", 65, "--height", 49, "--samples", 1, "--occlusion-samples", 4, "-o", "t.mp4")
        self.assertGreater(len(self.bytes_of("t.mp4")), 500)

    def test_images_of_a_history(self):
        self.make("export", SHARED / "history", "--frames", 3, "-o", "h_%d.png")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["h_0.png", "h_1.png", "h_2.png"])

    def test_folders_whose_names_have_a_dot(self):
        for name in ("textures.v2", "textures.2024-05-01", "x.foo/"):
            self.make("export", SHARED / "history", "--times", "0", "-o", name)
            self.assertTrue((self.folder / name / "sequence.json").is_file())
        self.assertIn("up to date", self.make("export", SHARED / "history", "--times", "0", "-o", "x.foo").stderr)  # it is there

    def test_what_makes_a_folder_takes_no_name_of_a_file(self):
        self.fails(USAGE, "expected a name as `aged`", "transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--control", "facing", "--resolution", 32, "-o", "aged.glb")
        self.fails(USAGE, "expected a name as `compared`", "history", "compare", SHARED / "history", SHARED / "history", "-o", "compared.html")
        self.make("synth", "crackle", "--width", 48, "--height", 40, "--num-frames", 2, "-o", "crackle.glb/")

    def test_mistakes_are_named(self):
        self.fails(USAGE, "x.avi", "export", SHARED / "aged", "-o", "x.avi")
        self.fails(USAGE, "export", "render", SHARED / "history", "-o", "x.mp4")
        for name in ("x.usd", "x.foo", "x.MKV", "x.v2b"):  # no folders of these names
            self.fails(USAGE, "MODEL.glb, .usdz, .usda or .obj, MOVIE.mp4, .webm or .gif", "export", SHARED / "aged", "-o", name)
            self.fails(USAGE, ".png", "texture", SHARED / "aged", "--time", 5, "-o", name)
            self.fails(USAGE, ".exr, .mp4, .webm, .gif", "render", SHARED / "aged", "-o", name)
        self.fails(USAGE, ".png", "export", SHARED / "aged", "-o", "x_%02d.usda")
        self.assertEqual(list(self.folder.iterdir()), [])
        self.fails(USAGE, "given twice", "export", SHARED / "aged", "--times", "5,5", "-o", "x.glb")
        self.fails(USAGE, "--fps", "export", SHARED / "aged", "--fps", "0", "-o", "x.mp4")


class Curves(Case):
    def test_regions_over_time(self):
        self.make("info", SHARED / "history", "--curves", "c.csv", "--by", "thickness", "--bins", 3, "--at", "5,6")
        rows = list(csv.DictReader((self.folder / "c.csv").read_text().splitlines()))
        self.assertEqual({row["time (s)"] for row in rows}, {"0", "7.5", "15", "22.5"})
        first = [row for row in rows if row["time (s)"] == "0"]
        self.assertEqual(int(first[0]["pixels"]), 48 * 40)
        self.assertEqual(sum(int(row["pixels"]) for row in first if row["region"].startswith("thickness")), 48 * 40)
        self.assertEqual(first[-1]["region"], "at 5 6")
        for row in rows:
            self.assertEqual(float(row["delta_e"]) == 0.0, row["time (s)"] == "0")
            self.assertLessEqual(float(row["R_p05"]), float(row["R_p95"]))

    def test_mistakes_are_named(self):
        self.fails(INPUT, "did you mean `thickness`", "info", SHARED / "history", "--curves", "c.csv", "--by", "thicknes")
        self.fails(USAGE, "--at", "info", SHARED / "history", "--curves", "c.csv", "--at", "48,0")
        self.fails(INPUT, "no curves", "info", SHARED / "urn/mesh.obj", "--curves", "c.csv")


class Sources(Case):
    def test_run_record_says_where_options_come_from(self):
        (self.folder / "run.toml").write_text("threads = 1\n[transfer]\nresolution = 48\ncoherence = 0.7\ncontrol = ['facing']\n")
        self.make("transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--config", "run.toml", "--coherence", "0.9", "-o", "out",
                  env={**os.environ, "PATINATE_FINE_PASSES": "1"})
        options = json.loads((self.folder / "out/run.json").read_text())["options"]
        self.assertEqual(options["coherence"], {"value": 0.9, "from": "command line"})
        self.assertEqual(options["fine_passes"], {"value": 1, "from": "PATINATE_FINE_PASSES"})
        self.assertEqual(options["resolution"], {"value": 48, "from": "run.toml: line 3"})
        self.assertEqual(options["seed"]["from"], "default")


if __name__ == "__main__":
    unittest.main()
