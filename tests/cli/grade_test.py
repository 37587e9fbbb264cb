#!/usr/bin/env python3
"""`patinate grade`: grades of a panel whose rust is known. Usage: grade_test.py PATINATE [unittest arguments]"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from command_case import INPUT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PATINATE)


class Grade(CommandCase):
    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="patinate_grade_"))
        cls.addClassCleanup(shutil.rmtree, cls.made)
        for arguments in (["synth", "panel", "--width", "300", "--height", "200", "--num-frames", "4", "--edge", "2", "--rust", "3", "--stains", "4",
                           "--scribe", "--creep", "1", "-o", "photos"], ["ingest", "photos/capture.json", "-o", "panel"]):
            subprocess.run([cls.patinate, *arguments, "--quiet"], cwd=cls.made, check=True)
        cls.truth = json.loads((cls.made / "photos/truth/truth.json").read_text())
        cls.panel = cls.made / "panel"

    def make(self, name, *options):
        size = [] if "--width" in options else ["--width", "140", "--height", "120"]
        for arguments in (["synth", "panel", *size, "--num-frames", "3", "--edge", "2", *options, "-o", f"{name}_photos"],
                          ["ingest", f"{name}_photos/capture.json", "-o", name]):
            subprocess.run([self.patinate, *arguments, "--quiet"], cwd=self.made, check=True)

    def figures(self, report, time, region="sample"):
        times = {t["time"]: t for r in report["regions"] if r["name"] == region for t in r["times"]}
        return {f["name"]: f for f in times[time]["figures"]}, times[time]

    def test_a_panel_gets_the_grades_of_its_truth(self):
        scribe = self.truth["scribe"]
        ends = ",".join(f"{v:.3f}" for v in [*scribe["from_mm"], *scribe["to_mm"], scribe["width_mm"]])
        self.succeeds("grade", self.panel, "--edge-mm", "2", "--scribe", ends, "-o", "report")
        self.succeeds("validate", "report")
        report = json.loads((self.folder / "report/report.json").read_text())
        last = self.truth["frames"][-1]
        figures, time = self.figures(report, last["time"])
        rusted = figures["rusted_percent"]
        self.assertLessEqual(rusted["low"], last["rust_test_percent"])
        self.assertGreaterEqual(rusted["high"], last["rust_test_percent"])
        # The asked 3 % are in the middle of Ri 4 (1 to 8) and of D610's 4 (3 to 10) or 5 (1 to 3).
        grades = {g["scale"]: g["grade"] for g in time["grades"]}
        self.assertEqual(grades["ri"], "4")
        self.assertIn(grades["d610"], ("4", "5"))
        # Half a pixel on each side, and ends of the scribe that are left out.
        creep = (last["creep_left_mm"] + last["creep_right_mm"]) / 2
        self.assertAlmostEqual(figures["creep_mm"]["value"], creep, delta=0.1 + 0.1 * creep)
        # The paint's change is stated; stains and noise leave the median where it is to 1.
        first = self.truth["frames"][0]["paint_lab"]
        for name, channel in (("delta_l", 0), ("delta_a", 1), ("delta_b", 2)):
            self.assertAlmostEqual(figures[name]["value"], last["paint_lab"][channel] - first[channel], delta=1.0)
        self.assertGreater(figures["gloss_60"]["value"], 0)
        rows = list(csv.DictReader((self.folder / "report/grades.csv").read_text().splitlines()))
        self.assertEqual({row["region"] for row in rows}, {"sample"})
        self.assertIn("Ri", self.succeeds("info", "report"))

    def test_the_report_says_what_the_project_says_of_the_sample(self):
        shutil.copytree(self.made / "photos", self.folder / "photos")
        sample = {"coating": "epoxy, 120 um", "exposure": "ISO 9227 NSS", "panel": 17}
        self.edit_json(self.folder / "photos/capture.json", lambda capture: capture.update(sample=sample))
        self.succeeds("ingest", "photos/capture.json", "-o", "panel")
        self.succeeds("validate", "panel")
        self.succeeds("grade", "panel", "--edge-mm", "2", "-o", "report")
        report = json.loads((self.folder / "report/report.json").read_text())
        self.assertEqual({f["name"]: f["text"] for f in report["sample"]}, {"coating": "epoxy, 120 um", "exposure": "ISO 9227 NSS", "panel": "17"})
        self.assertIn("epoxy, 120 um", (self.folder / "report/report.html").read_text())
        # It goes along when a history is made from another one, and a new statement is noticed.
        self.succeeds("history", "trim", "panel", "--until", "300", "-o", "part")
        self.assertEqual(json.loads((self.folder / "part/history.json").read_text())["sample"][0]["text"], "epoxy, 120 um")
        self.edit_json(self.folder / "photos/capture.json", lambda capture: capture.update(sample={"coating": ["epoxy"]}))
        self.fails(INPUT, "/sample/coating", "ingest", "photos/capture.json", "-o", "other")

    def test_the_scribe_is_found(self):
        self.succeeds("grade", self.panel, "--edge-mm", "2", "--scribe", "auto", "-o", "report")
        report = json.loads((self.folder / "report/report.json").read_text())
        (found,), true = report["scribes"], self.truth["scribe"]
        ends = sorted([(found["y0"], found["x0"]), (found["y1"], found["x1"])])
        for end, truth in zip(ends, sorted([true["from_mm"][::-1], true["to_mm"][::-1]])):
            self.assertAlmostEqual(end[0], truth[0], delta=0.3)
            self.assertAlmostEqual(end[1], truth[1], delta=0.1)
        self.assertTrue(any("scribe was found" in note for note in report["notes"]))
        # The ends that it prints give the same creep but for their rounding.
        values = next(note for note in report["notes"] if "scribe was found" in note).split(": ")[1].split(" ")[0]
        self.succeeds("grade", self.panel, "--edge-mm", "2", "--scribe", values, "-o", "given")
        last = self.truth["frames"][-1]["time"]
        given, _ = self.figures(json.loads((self.folder / "given/report.json").read_text()), last)
        auto, _ = self.figures(report, last)
        self.assertAlmostEqual(given["creep_mm"]["value"], auto["creep_mm"]["value"], delta=0.02)

    def test_both_arms_of_a_cross_are_found_and_graded(self):
        self.make("crossed", "--width", "400", "--height", "400", "--rust", "0", "--scribe", "--cross", "--creep", "4")
        self.succeeds("grade", self.made / "crossed", "--edge-mm", "2", "--scribe", "auto", "-o", "report")
        report = json.loads((self.folder / "report/report.json").read_text())
        self.assertEqual(len(report["scribes"]), 2)
        last = json.loads((self.made / "crossed_photos/truth/truth.json").read_text())["frames"][-1]
        figures, time = self.figures(report, last["time"])
        creep = (last["creep_left_mm"] + last["creep_right_mm"]) / 2
        # As for one scribe: half a pixel on each side, and places that are left out: at the ends, and where the arms' rust has merged.
        self.assertAlmostEqual(figures["creep_mm"]["value"], creep, delta=0.1 + 0.1 * creep)
        self.assertLessEqual(figures["creep_max_mm"]["value"], last["creep_max_mm"] + 0.1)
        self.assertEqual(figures["rusted_percent"]["value"], 0)  # All rust is creep.
        # The same by the arms that the notes print.
        arms = [note.split(": ")[1].split(" ")[0] for note in report["notes"] if "scribe was found" in note]
        self.succeeds("grade", self.made / "crossed", "--edge-mm", "2", "--scribe", arms[0], "--scribe", arms[1], "-o", "given")
        given, _ = self.figures(json.loads((self.folder / "given/report.json").read_text()), last["time"])
        self.assertAlmostEqual(given["creep_mm"]["value"], figures["creep_mm"]["value"], delta=0.02)

    def test_replicates_of_two_treatments_are_compared(self):
        for group, rust in (("good", "0.3"), ("bad", "6")):
            for seed in ("1", "2", "3", "4"):
                self.make(group + seed, "--rust", rust, "--seed", seed)
        good, bad = ([self.made / f"{group}{seed}" for seed in "1234"] for group in ("good", "bad"))
        self.succeeds("grade", *good, "--against", *bad, "--edge-mm", "2", "-o", "report")
        self.succeeds("validate", "report")
        report = json.loads((self.folder / "report/report.json").read_text())
        rusted = next(f for f in report["figures"] if f["name"] == "rusted_percent")
        # The smallest p of 4 against 4 is 2 of C(8, 4) = 70 labelings: every good panel has rusted less than every bad one.
        self.assertAlmostEqual(rusted["p"], 2 / 70)
        self.assertLess(max(rusted["a"]["values"]), min(rusted["b"]["values"]))
        self.assertAlmostEqual(rusted["a"]["mean"], sum(rusted["a"]["values"]) / 4, places=9)
        # A panel of the group has the report that it has alone.
        self.succeeds("grade", good[1], "--edge-mm", "2", "-o", "alone")
        alone, among = (json.loads((self.folder / name / "report.json").read_text()) for name in ("alone", "report/panels/2"))
        self.assertEqual((alone["regions"], alone["command"]), (among["regions"], among["command"]))
        self.assertEqual({g["scale"] for g in report["grades"]}, {"ri", "d610", "rp", "crack_size"})
        self.assertIn("Degree of rusting", (self.folder / "report/report.html").read_text())
        self.assertIn("none of 11 figures differs", self.succeeds("info", "report"))
        # Replicates alone have no test; a limit that one panel breaks is a failed run.
        (self.folder / "limits.txt").write_text("Ri <= 2 at 480 h\n")
        run = self.run_patinate("grade", *bad, "--edge-mm", "2", "--limits", "limits.txt", "-o", "one_group")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("a limit is not kept", run.stderr)
        self.assertIsNone(json.loads((self.folder / "one_group/report.json").read_text())["figures"][0]["p"])
        self.fails(INPUT, "one panel", "grade", good[0], "--against", *bad, "--edge-mm", "2", "-o", "out")
        self.fails(INPUT, "are the same history", "grade", good[0], good[0], "--edge-mm", "2", "-o", "out")

    def test_figures_are_forecast(self):
        for arguments in (["synth", "panel", "--width", "200", "--height", "160", "--num-frames", "9", "--edge", "2", "--rust", "4", "-o", "long_photos"],
                          ["ingest", "long_photos/capture.json", "-o", "long"]):
            subprocess.run([self.patinate, *arguments, "--quiet"], cwd=self.made, check=True)
        self.succeeds("grade", self.made / "long", "--edge-mm", "2", "--forecast", "800", "-o", "report")
        self.succeeds("validate", "report")
        region = json.loads((self.folder / "report/report.json").read_text())["regions"][0]
        last = {f["name"]: f["value"] for f in region["times"][-1]["figures"]}
        forecast = next(f for f in region["forecasts"] if f["figure"] == "rusted_percent")
        self.assertEqual(forecast["times"][-1]["time"], 800)
        values = [last["rusted_percent"], *(t["value"] for t in forecast["times"])]
        self.assertEqual(values, sorted(values))
        # A grade that the panel has not reached by its last photograph is reached later, and said to be forecast.
        states = {(g["scale"], g["grade"]): g for g in region["reached"]}
        self.assertIn("forecast", [g["state"] for g in states.values()])
        for g in states.values():
            if g["state"] == "forecast":
                self.assertGreater(g["time"], 480)
        for f in region["forecasts"]:
            if f["figure"] not in ("delta_l", "delta_a", "delta_b"):
                self.assertGreaterEqual(min(t["low"] for t in f["times"]), 0, f["figure"])
        self.assertIn("Forecast at 800", (self.folder / "report/report.html").read_text())
        self.fails(INPUT, "is not after the last photograph", "grade", self.panel, "--edge-mm", "2", "--forecast", "300", "-o", "out")

    def test_the_same_bytes_on_one_thread_and_by_the_command_that_it_states(self):
        self.succeeds("grade", self.panel, "--edge-mm", "2", "-o", "three", "--threads", "3")
        self.succeeds("grade", self.panel, "--edge-mm", "2", "-o", "one", "--threads", "1")
        for name in ("report.json", "report.html", "grades.csv"):
            self.assertEqual((self.folder / "one" / name).read_bytes(), (self.folder / "three" / name).read_bytes(), name)

    def test_regions_and_limits(self):
        (self.folder / "limits.txt").write_text("Ri <= 5 at 480 h\nrusted_percent <= 0.1 at 20 d\n")
        run = self.run_patinate("grade", self.panel, "--region", "left=1,1,14,1,14,19,1,19", "--region", "right=16,1,29,1,29,19,16,19",
                                "--limits", "limits.txt", "-o", "report")
        self.assertEqual(run.returncode, 1, run.stderr)
        report = json.loads((self.folder / "report/report.json").read_text())
        self.assertEqual([r["name"] for r in report["regions"]], ["left", "right"])
        self.assertEqual([l["state"] for l in report["limits"] if l["limit"].startswith("Ri")], ["pass", "pass"])
        self.assertIn("fail", [l["state"] for l in report["limits"]])
        # What no photograph shows is no pass.
        (self.folder / "limits.txt").write_text("Ri <= 5 at 24000 h\n")
        run = self.run_patinate("grade", self.panel, "--edge-mm", "2", "--limits", "limits.txt", "-o", "late")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("not tested", run.stderr)
        self.assertIn("--scribe auto", run.stderr)  # The panel has a scribe that nobody named.

    def test_bad_input_is_one_line(self):
        panel = self.panel
        self.fails(INPUT, "leaves nothing of a sample", "grade", panel, "-o", "out")
        self.fails(INPUT, "lies over region a", "grade", panel, "--region", "a=1,1,20,1,20,10,1,10", "--region", "b=5,5,25,5,25,15,5,15", "-o", "out")
        self.fails(INPUT, "lies outside of the picture", "grade", panel, "--region", "a=1,1,200,1,20,10", "-o", "out")
        self.fails(INPUT, "less than half a pixel", "grade", panel, "--region", "a=1,1,1,1,1,1", "-o", "out")
        self.fails(INPUT, "is given twice", "grade", panel, "--region", "a=1,1,9,1,9,9", "--region", "a=11,1,19,1,19,9", "-o", "out")
        self.fails(INPUT, "lies outside of the sample", "grade", panel, "--edge-mm", "2", "--scribe", "15,5,15,200,0.5", "-o", "out")
        self.fails(USAGE, "--region", "grade", panel, "--region", "1,2,3", "-o", "out")
        self.fails(USAGE, "give it alone", "grade", panel, "--scribe", "auto", "--scribe", "1,2,3,4,0.5", "-o", "out")
        self.fails(USAGE, "--scribe", "grade", panel, "--scribe", "1,2,3", "-o", "out")
        self.fails(USAGE, "--scribe", "grade", panel, "--scribe", "longest", "-o", "out")
        self.fails(INPUT, "no photograph has the time 7", "grade", panel, "--edge-mm", "2", "--unexposed", "7", "-o", "out")
        (self.folder / "limits.txt").write_text("rusty <= 5 at 480 h\n")
        self.fails(INPUT, "line 1", "grade", panel, "--edge-mm", "2", "--limits", "limits.txt", "-o", "out")
        self.fails(INPUT, "urn", "grade", self.shared / "urn", "-o", "out")
        # Without the size of a pixel: shares are graded, lengths are not.

    def test_without_the_size_of_a_pixel_shares_are_graded(self):
        shutil.copytree(self.panel, self.folder / "panel")
        self.edit_json(self.folder / "panel/history.json", lambda history: history.pop("texel_size_mm"))
        self.fails(INPUT, "size of a pixel", "grade", "panel", "--scribe", "15,5,15,15,0.5", "-o", "out")
        self.fails(INPUT, "size of a pixel", "grade", "panel", "--region", "a=1,1,9,1,9,9", "-o", "out")
        self.succeeds("grade", "panel", "-o", "report")
        figures, _ = self.figures(json.loads((self.folder / "report/report.json").read_text()), 480.0)
        self.assertIn("rusted_percent", figures)
        self.assertNotIn("crack_width_mm", figures)


if __name__ == "__main__":
    unittest.main()
