#!/usr/bin/env python3
"""When photographs were taken: sources, their order, and what is said where they disagree. Usage: times_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from series_files import exif, png

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())
# What must not take part: dates of writing and changing.
CHANGED = "2024:01:01 00:00:00"


def photograph(i, **more):
    """Frames that get darker, so that a history can be made of them."""
    return png(16, 12, lambda x, y: [(8 * x + 5 * y + 20 + (3 * i * (x > 8))) % 256] * 3, **more)


class Times(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def series(self, photographs, **project):
        """Writes photographs, {name: EXIF texts or None}, in the order of their making, and a project for them."""
        for i, (name, texts) in enumerate(photographs.items()):
            (self.folder / name).write_bytes(photograph(i, exif=exif(**texts) if texts else None))
        frames = {"pattern": "*.png", **({"interval": project.pop("interval")} if "interval" in project else {})}
        content = {"format": "patinate.capture", "version": 1, "name": "series", "kind": "fixed", "frames": frames, "time_unit": "s", **project}
        (self.folder / "capture.json").write_text(json.dumps(content))

    def run_patinate(self, *arguments):
        return subprocess.run([PATINATE, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120)

    def ingest(self):
        run = self.run_patinate("ingest", "capture.json", "-o", "out")
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stderr

    def times(self):
        return [frame["time"] for frame in json.loads((self.folder / "out/history.json").read_text())["frames"]]

    def expect_times(self, times, said="", unsaid="disagree"):
        stderr = self.ingest()
        self.assertEqual(self.times(), times)
        self.assertIn(said, stderr)
        self.assertNotIn(unsaid, stderr)

    def expect_refusal(self, about):
        run = self.run_patinate("ingest", "capture.json", "-o", "out")
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn(about, run.stderr)

    def test_fractions_of_a_second_count(self):
        for digits, times in ((["24", "74", "24", "74"], [0, 0.5, 1, 1.5]), (["9", "1", "9", "1"], [0, 0.2, 2, 2.2]), (["900001", "100001", "900001", "100001"], [0, 0.2, 2, 2.2])):
            dates = ["2018:01:01 02:04:04", "2018:01:01 02:04:04" if digits[0] == "24" else "2018:01:01 02:04:05",
                     "2018:01:01 02:04:05" if digits[0] == "24" else "2018:01:01 02:04:06", "2018:01:01 02:04:05" if digits[0] == "24" else "2018:01:01 02:04:07"]
            self.series({f"a{i}.png": {"DateTimeOriginal": dates[i], "SubSecTimeOriginal": digits[i], "DateTime": CHANGED} for i in range(4)})
            self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
            self.expect_times(times, "EXIF DateTimeOriginal, 2018-01-01 02:04:04")

    def test_a_clock_that_is_set_is_no_time_that_passed(self):
        spring = [("01:30:00", "+01:00"), ("03:00:00", "+02:00"), ("03:30:00", "+02:00"), ("04:00:00", "+02:00")]
        self.series({f"a{i}.png": {"order": "<>"[i % 2], "DateTimeOriginal": "2023:03:26 " + t, "OffsetTimeOriginal": o} for i, (t, o) in enumerate(spring)}, time_unit="min")
        self.expect_times([0, 30, 60, 90], "2023-03-26 01:30:00 +01:00 to 2023-03-26 04:00:00 +02:00")

    def test_a_journey_changes_the_offset_of_both_dates(self):
        flight = [("2023:06:01 23:00:00", "+09:00"), ("2023:06:01 16:00:00", "+01:00"), ("2023:06:01 12:00:00", "-04:00")]
        for kind in ("Original", "Digitized"):
            self.series({f"{kind}{i}.png": {"DateTime" + kind: t, "OffsetTime" + kind: o} for i, (t, o) in enumerate(flight)}, time_unit="h", frames={"pattern": kind + "*.png"})
            self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
            self.expect_times([0, 1, 2], "EXIF DateTime" + kind)

    def test_an_offset_that_some_photographs_do_not_say_is_not_guessed(self):
        self.series({f"a{i}.png": {"DateTimeOriginal": f"2023:03:26 0{i}:30:00", **({"OffsetTimeOriginal": o} if o else {})} for i, o in enumerate(("+01:00", "+02:00", ""))})
        self.expect_refusal("a2.png has no OffsetTime, which changes in the series")

    def test_names_with_a_day_and_exif_with_its_time_agree(self):
        self.series({f"2020-05-{26 + i}.png": {"DateTimeOriginal": f"2020:05:{26 + i} {t}"} for i, t in enumerate(("08:00:00", "20:00:00", "09:00:00", "21:00:00"))}, time_unit="h")
        self.expect_times([0, 36, 49, 85], "EXIF DateTimeOriginal")

    def test_the_finest_of_sources_that_agree_is_taken(self):
        self.series({f"PXL_20200528_0820{s}.png": {"DateTimeOriginal": f"2020:05:28 10:20:{s[:2]}", "OffsetTimeOriginal": "+02:00"} for s in ("00123", "00873", "02123")})
        self.expect_times([0, 0.75, 2], "dates in file names")

    def test_counters_are_no_dates(self):
        for name in ("DSC_201011{:02d}.png", "IMG_20200528_{:04d}.png", "IMG_20200528_102005_{:03d}.png"):
            self.series({name.format(8 + i): {"DateTimeOriginal": f"2021:05:01 1{i}:00:00"} for i in range(4)}, time_unit="h", frames={"pattern": name.split("{")[0] + "*.png"})
            self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
            self.assertEqual(self.times(), [0, 1, 2, 3], name)
        self.series({f"X_201011{8 + i:02d}.png": None for i in range(4)}, frames={"pattern": "X_*.png"})
        self.expect_refusal("has no date in the name")

    def test_sources_that_disagree_are_named_with_both_values(self):
        self.series({f"2020-05-28_1{i}-00-00.png": {"DateTimeOriginal": f"2020:05:28 1{2 * i}:00:00"} for i in range(4)}, time_unit="h")
        run = self.run_patinate("ingest", "capture.json", "-o", "out")
        self.assertEqual(self.times(), [0, 2, 4, 6])
        self.assertRegex(run.stderr, r"times disagree.*_13-00-00\.png is from 2020-05-28 16:00:00 by EXIF DateTimeOriginal .*2020-05-28 13:00:00 by dates in file names")
        self.assertEqual([w["about"] for w in json.loads((self.folder / "out/history.json").read_text())["warnings"] if "times disagree" in w["text"]], ["series"])

    def test_a_stated_interval_that_contradicts_dates_is_said(self):
        names = {f"Picture 2020-05-28 {t}.png": None for t in ("10.20.05 AM", "11.20.05 AM", "12.20.05 PM", "01.20.05 PM")}
        self.series(names, interval=1, time_unit="h")
        self.assertRegex(self.ingest(), r"stated times disagree with dates in file names")
        self.series({f"p{i}.png": {"DateTimeOriginal": f"2020:05:28 10:00:{7.5 * i:02.0f}"} for i in range(4)}, frames={"pattern": "p*.png", "interval": 7.5})
        self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
        self.expect_times([0, 7.5, 15, 22.5])

    def test_clocks_of_twelve_hours(self):
        self.series({f"Picture 2020-05-28 {t}.png": None for t in ("10.20.05 AM", "11.20.05 AM", "12.20.05 PM", "01.20.05 PM")}, time_unit="h")
        self.expect_times([0, 1, 2, 3], "dates in file names, 2020-05-28 10:20:05 to 2020-05-28 13:20:05")

    def test_other_forms_of_dates_in_names(self):
        forms = (["28.05.2020 18-20-05.250", "28.05.2020 18-20-06.750"], ["2020-05-28_18-20-05_250", "2020-05-28_18-20-06_750"], ["28 May 2020 6.20.05,25 PM", "28 May 2020 6.20.06,75 PM"])
        for k, names in enumerate(forms):
            self.series({f"{k} {name}.png": None for name in names}, frames={"pattern": f"{k} *.png"})
            self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
            self.assertEqual(self.times(), [0, 1.5], names)
        self.series({f"z05-06-2020_10-20-0{i}.png": None for i in range(3)}, frames={"pattern": "z*.png"})
        self.expect_refusal("has no date in the name")  # The 5th of June, or the 6th of May.

    def test_a_second_date_in_a_name_is_no_time_of_day(self):
        self.series({f"20240101_exp_202401{day}_1200.png": None for day in (29, 30, 31)})
        self.expect_times([0, 86400, 172800])

    def test_a_day_ends_at_24_hours(self):
        self.series({f"2024-{name}.png": None for name in ("01-31 23-00", "01-31 24-00", "02-01 01-00")})
        self.expect_times([0, 3600, 7200])
        for path in self.folder.glob("*.png"):
            path.unlink()
        self.series({name: {"DateTimeOriginal": date} for name, date in (("a.png", "2024:01:31 23:00:00"), ("b.png", "2024:01:31 24:00:00"))})
        (self.folder / "out").rename(self.folder / "first")
        self.expect_times([0, 3600])

    def test_what_looks_like_a_time_and_is_none_is_named(self):
        self.series({"2024-01-31 23-00.png": None, "2024-01-31 25-00.png": None})
        self.expect_refusal("2024-01-31 23-00.png has a time of day in its date in the name, 2024-01-31 25-00.png none")
        for path in self.folder.glob("*.png"):
            path.unlink()
        self.series({"a.png": {"DateTimeOriginal": "0000:00:00 00:00:00"}, "b.png": None})
        self.expect_refusal("a.png has no EXIF DateTimeOriginal that is a date: `0000:00:00 00:00:00`")

    def test_dates_of_writing_are_none_of_taking(self):
        for i in range(3):
            (self.folder / f"p{i}.png").write_bytes(photograph(i, written=(2024, 1, 3 - i, 0, 0, 0)))
        self.series({})
        self.expect_refusal("p0.png has no EXIF DateTimeOriginal")
        self.series({f"p{i}.png": {"DateTime": f"2024:01:0{3 - i} 00:00:00"} for i in range(3)})
        self.expect_refusal("p0.png has no EXIF DateTimeOriginal")
        self.assertNotIn("2024", self.run_patinate("info", "p0.png").stdout)

    def test_names_sort_as_people_read_them(self):
        for names in (["t=0.25h", "t=0.5h", "t=0.75h", "t=1.0h", "t=1.25h", "t=10h"], ["t0,5", "t0,75", "t1"], ["img_2", "img_10"], ["v1.9", "v1.10", "v1.11"], ["a.1.2.9", "a.1.2.10"],
                      ["t=-10min", "t=-5min", "t=0min", "t=5min"], ["-10min", "-5min", "0min"], ["T-10", "T-2", "T+0", "T+3", "T+20"], ["img-2", "img-10"], ["5-2", "5-10"]):
            for file in self.folder.glob("*.png"):
                file.unlink()
            self.series({name + ".png": None for name in reversed(names)}, interval=1)
            self.run_patinate("ingest", "capture.json", "-o", "out", "--force")
            inputs = [entry["name"] for entry in json.loads((self.folder / "out/job.json").read_text())["depends_on"]]
            self.assertEqual([name for name in inputs if name.endswith(".png") and not name.startswith("time of")], [name + ".png" for name in names])

    def test_an_excluded_photograph_does_not_shift_the_others(self):
        self.series({f"a{i}.png": {"DateTimeOriginal": f"2020:05:28 1{i}:00:00"} for i in range(4)}, exclude=[0, 2], time_unit="h")
        self.expect_times([1, 3])

    def test_info_and_init_say_where_times_come_from(self):
        self.series({f"a{i}.png": {"DateTimeOriginal": f"2020:05:28 1{i}:00:00", "SubSecTimeOriginal": "25", "OffsetTimeOriginal": "+02:00"} for i in range(3)})
        self.assertIn("2020-05-28 10:00:00.25 +02:00 (EXIF DateTimeOriginal)", self.run_patinate("info", "a0.png").stdout)
        self.assertIn("times from EXIF DateTimeOriginal, 2020-05-28 10:00:00.25 +02:00 to 2020-05-28 12:00:00.25 +02:00",
                      self.run_patinate("init", ".", "-o", "drafted.json").stderr)
        (self.folder / "Shot 2020-05-28 at 1.20.05 PM.png").write_bytes(photograph(0))
        self.assertIn("2020-05-28 13:20:05 (file name)", self.run_patinate("info", "Shot 2020-05-28 at 1.20.05 PM.png").stdout)


if __name__ == "__main__":
    unittest.main()
