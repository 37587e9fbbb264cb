#!/usr/bin/env python3
"""What a history says in numbers and pictures: figures of every frame as table, CSV and charts; years; sizes. Usage: stats_test.py PATINATE [unittest arguments]"""
import csv
import json
import random
import struct
import sys
import unittest

import calibration_scene as scene
from command_case import CANNOT, INPUT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PATINATE)


class Statistics(CommandCase):
    def rows(self, file):
        with open(self.folder / file, newline="") as table:
            return list(csv.DictReader(table))

    def test_color_cracks_and_classes_over_time_are_a_table_and_charts(self):
        command = ["info", self.shared / "history", "--stats", "--class", "dark=#202020", "--class", "light=#e0e0e0"]
        told = json.loads(self.succeeds(*command, "--json"))["frames"]
        self.succeeds(*command, "--csv", "a.csv")
        rows = self.rows("a.csv")
        self.assertEqual([float(row["time (s)"]) for row in rows], [frame["time"] for frame in told])
        for row, frame in zip(rows, told):
            self.assertEqual([float(row[c]) for c in "Lab"], frame["mean_lab"])
            self.assertEqual(float(row["crack_share"]), frame["crack_share"])
            self.assertEqual(float(row["crack_density (1/mm)"]), frame["crack_density"])
            self.assertEqual(float(row["dark"]), frame["classes"]["dark"])
            self.assertAlmostEqual(float(row["dark"]) + float(row["light"]), 1.0, 9)
        # Cracks open from frame to frame.
        self.assertGreater(told[-1]["crack_share"], told[0]["crack_share"])
        page = (self.folder / "a.html").read_text()
        self.assertEqual(page.count("<svg"), 4)
        self.assertIn("crack_density", page)
        self.assertIn("up to date", self.run_patinate(*command, "--csv", "a.csv").stderr)

    def test_files_of_others_stay(self):
        (self.folder / "a.html").write_text("mine")
        self.fails(CANNOT, "a.html", "info", self.shared / "history", "--stats", "--csv", "a.csv")
        self.fails(USAGE, "--stats", "info", self.shared / "history", "--csv", "b.csv")

    def test_what_happened_between_two_photographs_is_said_to_lie_between_them(self):
        told = json.loads(self.succeeds("info", self.shared / "history", "--stats", "--json"))
        times = [frame["time"] for frame in told["frames"]]
        low, high = told["onset"]["median_seen_between"]
        self.assertTrue(low in times and high in times, (low, high))
        self.assertTrue(low <= told["onset"]["median"] <= high or abs(low - told["onset"]["median"]) < 1e-3)
        text = self.succeeds("info", self.shared / "history", "--stats")
        self.assertIn("median between" if low < high else "median", text.split("onset:")[1].splitlines()[0])

    def test_years_are_called_yr_where_people_read_them(self):
        history = self.take("history")
        self.edit_json(history / "history.json", lambda h: h.update(time_unit="a"))
        self.assertIn(" yr", self.succeeds("info", "history"))
        self.assertIn("time yr", self.succeeds("info", "history", "--stats"))
        self.assertEqual(json.loads(self.succeeds("info", "history", "--stats", "--json"))["time_unit"], "a")  # As in files.
        self.succeeds("history", "trim", "history", "--until", "20", "-o", "trimmed")
        self.assertEqual(json.loads((self.folder / "trimmed/history.json").read_text())["time_unit"], "a")


class Sizes(CommandCase):
    def size(self, file):
        return struct.unpack(">II", (self.folder / file).read_bytes()[16:24])

    def test_a_picture_of_a_history_has_the_width_that_was_asked_for(self):
        render = ["render", self.shared / "history", "--time", "3", "-o"]
        self.succeeds(*render, "own.png")
        self.succeeds(*render, "narrow.png", "--width", "24")
        self.succeeds(*render, "low.png", "--height", "20")
        self.assertEqual([self.size(f"{name}.png") for name in ("own", "narrow", "low")], [(48, 40), (24, 20), (24, 20)])
        self.succeeds(*render, "wide.png", "--width", "480")
        self.assertEqual(self.size("wide.png"), (480, 400))


class Factors(CommandCase):
    def test_what_no_curve_describes_is_refused_in_one_line(self):
        (self.folder / "photos").mkdir()
        numbers = random.Random(1)
        for i in range(8):  # Every photograph has a bright stripe elsewhere.
            scene.write_png(self.folder / f"photos/{i}.png", 48, 40, lambda x, y: (0.8 if x // 6 == i else 0.3) + 0.02 * numbers.random())
        self.succeeds("init", "photos", "--quiet")
        self.succeeds("ingest", "photos", "-o", "stripes", "--quiet")
        self.fails(INPUT, "no place changes", "history", "factorize", "stripes", "-o", "factors")

    def test_a_reconstruction_that_follows_its_history_brings_no_warning(self):
        result = self.run_patinate("history", "factorize", self.shared / "history", "-o", "factors")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("reconstruction has only", result.stderr)


if __name__ == "__main__":
    unittest.main()
