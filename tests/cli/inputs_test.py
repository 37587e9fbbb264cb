#!/usr/bin/env python3
"""`patinate init` and time-lapses as they are, as a user meets them. Usage: inputs_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from command_case import nightly

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
DATA = os.environ.get("PATINATE_DATA")


def run(*arguments, cwd):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)


def project_of(path):
    return json.loads(path.read_text())


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
        hints = (self.folder / "capture/capture.hints.txt").read_text()
        self.assertIn("check: `interval`", hints)
        self.assertIn("`texel_size_mm`", hints)
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

    def mixed_photos(self):
        """Three photographs of 48 x 40 and one of 64 x 64 among them."""
        self.crackle()
        photos = self.folder / "photos"
        photos.mkdir()
        for name in ("0000.png", "0001.png", "0002.png"):
            shutil.copy(self.folder / "capture/frames" / name, photos / f"day_{name}")
        self.succeeds("synth", "crackle", "--width", "64", "--height", "64", "--num-frames", "2", "-o", "large")
        shutil.copy(self.folder / "large/frames/0000.png", photos / "day_0001b.png")
        return photos

    def refused(self, *arguments):
        result = run(*arguments, cwd=self.folder)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        return result.stderr

    def test_photographs_of_several_sizes_are_a_series_by_hand(self):
        photos = self.mixed_photos()
        result = self.succeeds("init", "photos")
        self.assertIn("found: 4 photographs, day_*.png, of several sizes", result.stderr)
        self.assertIn("check: `align`: photographs differ in size, folder or format", result.stderr)
        project = project_of(photos / "capture.json")
        self.assertEqual((project["align"], project["frames"]["pattern"]), ("auto", "day_*.png"))

    def test_photographs_of_several_folders_and_formats_are_listed(self):
        photos = self.mixed_photos()
        (photos / "later").mkdir()
        (photos / "later/x.ppm").write_bytes(b"P6\n9 8\n255\n" + bytes(3 * 8 * 9))
        self.succeeds("init", "photos")
        project = project_of(photos / "capture.json")
        self.assertEqual(project["align"], "auto")
        self.assertEqual([frame["photo"] for frame in project["frames"]],
                         ["day_0000.png", "day_0001.png", "day_0001b.png", "day_0002.png", "later/x.ppm"])
        self.assertEqual([frame["time"] for frame in project["frames"]], [0, 1, 2, 3, 4])

    def test_smaller_copies_are_never_taken_for_further_photographs(self):
        photos = self.mixed_photos()
        (photos / "thumbs").mkdir()
        (photos / "thumbs/day_0000.ppm").write_bytes(b"P6\n9 8\n255\n" + bytes(3 * 8 * 9))
        error = self.refused("init", "photos")
        self.assertIn("3 photographs of 48 x 40 (day_0000.png ... day_0002.png), 1 photograph of 64 x 64 (day_0001b.png)", error)
        self.assertIn("--only", error)
        self.assertFalse((photos / "capture.json").exists())

    def test_only_says_which_names_make_the_frames(self):
        photos = self.mixed_photos()
        result = self.succeeds("init", "photos", "--only", "day_000?.png")
        self.assertIn("found: 3 photographs, day_*.png, 48 x 40", result.stderr)
        self.assertIn("1 other image, which --only leaves out", result.stderr)
        self.assertEqual(project_of(photos / "capture.json")["exclude"], [2])  # "day_*.png" will take later ones too
        self.succeeds("ingest", "photos", "-o", "history")
        self.assertEqual(len(json.loads((self.folder / "history/history.json").read_text())["frames"]), 3)
        self.assertIn("matches `x*`", self.refused("init", "photos", "--only", "x*", "-o", "other.json"))

    def test_photographs_and_a_movie_beside_them_are_two_sets(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        frames = b"".join(b"\x2c" + bytes(4) + b"\x01\0\x01\0\0" + b"\x02\x02\x44\x01\0" for _ in range(5))
        (photos / "a.gif").write_bytes(b"GIF89a\x01\0\x01\0\x80\0\0" + bytes(3) + b"\xff\xff\xff" + frames + b";")
        self.assertIn("a.gif with 5 images of 1 x 1", self.refused("init", "photos"))
        self.succeeds("init", "photos", "--only", "*.png")

    def test_extensions_in_capitals_are_the_same_format(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        (photos / "day_0001.png").rename(photos / "day_0001.PNG")
        self.assertIn("3 photographs", self.succeeds("init", "photos").stderr)
        self.succeeds("ingest", "photos", "-o", "history")
        self.assertEqual(len(json.loads((self.folder / "history/history.json").read_text())["frames"]), 3)

    def test_what_patinate_made_beside_the_photographs_is_none_of_them(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        self.succeeds("init", "photos")
        self.succeeds("ingest", "photos", "-o", "photos/history")
        self.succeeds("export", "photos/history", "-o", "photos/frames")
        self.assertIn("up to date", self.succeeds("init", "photos").stderr)

    def test_a_photograph_that_is_cut_off_is_named_and_left_out_of_the_draft(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        cut = photos / "day_0001.png"
        cut.write_bytes(cut.read_bytes()[:-20])
        said = self.succeeds("init", "photos").stderr
        self.assertIn("check: photos/day_0001.png: ends before its picture does; copy it again", said)
        self.assertEqual(project_of(photos / "capture.json")["exclude"], [1])
        self.succeeds("ingest", "photos", "-o", "history")

    def test_a_project_is_drafted_and_ingested_inside_its_folder(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        here = {"cwd": photos}
        for arguments in (["init", "."], ["ingest", "capture.json", "-o", "out"], ["ingest", ".", "-o", "out"]):
            result = run(*arguments, **here)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(project_of(photos / "capture.json")["frames"]["pattern"], "day_*.png")
        self.assertEqual(len(json.loads((photos / "out/history.json").read_text())["frames"]), 3)
        for capture in ("photos/", "photos/capture.json", photos / "capture.json"):  # from wherever it is named, it is the same project
            self.assertIn("up to date", self.succeeds("ingest", capture, "-o", photos / "out/").stderr)

    def test_blanks_and_letters_of_other_languages_in_paths(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        strange = self.folder / "Grünspan 2024 \u9752\u9285"
        photos.rename(strange)
        for day in sorted(strange.glob("*.png")):
            day.rename(strange / day.name.replace("day_", "Tag é "))
        self.succeeds("init", strange.name)
        self.succeeds("ingest", strange.name, "-o", "häßlich history")
        self.assertEqual(json.loads((self.folder / "häßlich history/history.json").read_text())["name"], strange.name)
        self.succeeds("export", "häßlich history", "-o", "ein film.mp4")

    def test_names_that_are_no_utf8(self):
        photos = self.mixed_photos()
        (photos / "day_0001b.png").unlink()
        folder = os.fsencode(self.folder)
        os.rename(os.fsencode(photos), folder + b"/gr\xfcn")
        result = subprocess.run([PATINATE, "init", b"gr\xfcn"], cwd=self.folder, capture_output=True)  # The name alone is not kept whole.
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(subprocess.run([PATINATE, "ingest", b"gr\xfcn", "-o", b"h\xfc"], cwd=self.folder, capture_output=True).returncode, 0)
        result = subprocess.run([PATINATE, "init", b"gr\xfcn", "-o", "elsewhere.json"], cwd=self.folder, capture_output=True)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn(b"no UTF-8", result.stderr)
        self.assertNotIn(b"json.exception", result.stderr)

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
    @nightly
    def test_a_movie_among_pictures_is_the_time_lapse(self):
        copper = pathlib.Path(DATA) / "timelapse/copper_patinating"
        self.assertIn("copper_patinating.webp with 100 images of", self.refused("init", copper, "-o", "copper.json"))
        self.succeeds("init", copper, "--only", "*.webp", "-o", "copper.json")
        project = project_of(self.folder / "copper.json")
        self.assertTrue(project["frames"]["pattern"].endswith("copper_patinating.webp"))
        self.succeeds("ingest", "copper.json", "-o", "history")
        self.assertEqual(len(json.loads((self.folder / "history/history.json").read_text())["frames"]), 100)


if __name__ == "__main__":
    unittest.main()
