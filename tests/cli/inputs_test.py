#!/usr/bin/env python3
"""`patinate init` and time-lapses as they are, as a user meets them. Usage: inputs_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
DATA = os.environ.get("PATINATE_DATA")


def run(*arguments, cwd):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)


def project_of(path):
    return json.loads(re.sub(r"//.*", "", path.read_text()))


class Init(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_inputs_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def succeeds(self, *arguments):
        result = run(*arguments, cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def crackle(self):
        self.succeeds("synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "-o", "capture")
        (self.folder / "capture/capture.json").unlink()

    def test_a_lab_folder_becomes_a_project_that_ingest_takes_at_once(self):
        self.crackle()
        result = self.succeeds("init", "capture")
        self.assertIn("4 photographs, frames/*.png", result.stderr)
        self.assertIn("check: `interval`", result.stderr)
        project = project_of(self.folder / "capture/capture.json")
        self.assertEqual(project["transmission"], {"photo": "backlight.png", "blank": "backlight_blank.png", "align": "none"})
        self.succeeds("ingest", "capture", "-o", "history")
        history = json.loads((self.folder / "history/history.json").read_text())
        self.assertEqual([len(history["frames"]), history["controls"][0]["name"]], [4, "thickness"])

    def test_a_project_is_never_overwritten_without_force(self):
        self.crackle()
        self.succeeds("init", "capture")
        self.assertIn("up to date", self.succeeds("init", "capture").stderr)
        mine = self.folder / "capture/capture.json"
        mine.write_text(mine.read_text().replace('"interval":1', '"interval":7.5'))
        edited = mine.read_text()
        self.assertIn("7.5", edited)
        result = run("init", "capture", cwd=self.folder)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(mine.read_text(), edited)
        self.succeeds("init", "capture", "--force")
        self.assertNotEqual(mine.read_text(), edited)

    def test_the_project_may_lie_elsewhere(self):
        self.crackle()
        (self.folder / "projects").mkdir()
        self.succeeds("init", "capture", "-o", "projects/mine.json")
        self.succeeds("ingest", "projects/mine.json", "-o", "history")

    def test_photographs_of_other_sizes_and_masks_beside_the_frames_are_left_out(self):
        self.crackle()
        for name in ("0000.png", "0001.png", "0002.png"):
            shutil.copy(self.folder / "capture/frames" / name, self.folder / f"day_{name}")
        self.succeeds("synth", "crackle", "--width", "64", "--height", "64", "--num-frames", "2", "-o", "large")
        photos = self.folder / "photos"
        photos.mkdir()
        for day in self.folder.glob("day_*.png"):
            day.rename(photos / day.name)
        shutil.copy(self.folder / "large/frames/0000.png", photos / "day_0001b.png")
        result = self.succeeds("init", "photos")
        self.assertIn("day_0001b.png", result.stderr)
        self.assertEqual(project_of(photos / "capture.json")["exclude"], [2])
        self.succeeds("ingest", "photos", "-o", "history")

    def test_an_empty_folder_says_what_is_missing(self):
        (self.folder / "empty").mkdir()
        result = run("init", "empty", cwd=self.folder)
        self.assertEqual(result.returncode, 3)
        self.assertIn("holds no photographs and no movie", result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1)

    @unittest.skipUnless(DATA, "PATINATE_DATA is not set")
    def test_bananas_have_their_dates_in_their_names(self):
        self.succeeds("init", pathlib.Path(DATA) / "timelapse/banana_14_B", "-o", "banana.json")
        project = project_of(self.folder / "banana.json")
        self.assertEqual(project["time_unit"], "d")
        self.assertNotIn("interval", project["frames"])

    @unittest.skipUnless(DATA, "PATINATE_DATA is not set")
    def test_a_movie_among_pictures_is_the_time_lapse(self):
        self.succeeds("init", pathlib.Path(DATA) / "timelapse/copper_patinating", "-o", "copper.json")
        project = project_of(self.folder / "copper.json")
        self.assertTrue(project["frames"]["pattern"].endswith("copper_patinating.webp"))
        self.succeeds("ingest", "copper.json", "-o", "history")
        self.assertEqual(len(json.loads((self.folder / "history/history.json").read_text())["frames"]), 100)


if __name__ == "__main__":
    unittest.main()
