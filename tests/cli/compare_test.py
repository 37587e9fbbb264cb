#!/usr/bin/env python3
"""Two histories compared, as a user would. Usage: compare_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_compare_"))


def patinate(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True)


def setUpModule():
    for name, seed in (("one", 1), ("two", 2)):
        patinate("synth", "crackle", "--width", 96, "--height", 80, "--num-frames", 6, "--seed", seed, "-o", f"{name}_photos")
        result = patinate("ingest", f"{name}_photos", "-o", name)
        assert result.returncode == 0, result.stderr
    patinate("synth", "sculpture", "--resolution", 24, "-o", "urn")
    result = patinate("transfer", "one", "urn/mesh.obj", "--control", "facing", "--resolution", 64, "-o", "aged")
    assert result.returncode == 0, result.stderr


def tearDownModule():
    shutil.rmtree(WORK)


class Replicates(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for seed in (3, 4):
            patinate("synth", "crackle", "--width", 96, "--height", 80, "--num-frames", 6, "--seed", seed, "-o", f"crackle{seed}_photos")
            patinate("ingest", f"crackle{seed}_photos", "-o", f"crackle{seed}")

    def test_two_sides_of_any_number_are_compared(self):
        result = patinate("history", "compare", "one", "two", "--against", "crackle3", "crackle4", "--num-times", 4, "-o", "replicates")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the smallest that 2 against 2 can give is 0.333", result.stderr)  # 2 of 6 ways: A and B exchanged are as far apart.
        report = json.loads((WORK / "replicates/report.json").read_text())
        self.assertEqual([[side["name"] for side in report[s]] for s in "ab"], [["one", "two"], ["crackle3", "crackle4"]])
        self.assertEqual(report["command"], "patinate history compare one two --against crackle3 crackle4 --num-times 4 -o OUT")
        self.assertEqual(report["labelings"], 6)
        again = patinate("history", "compare", "one", "two", "--num-times", 4, "-o", "replicates", "--against", "crackle3", "crackle4")
        self.assertIn("up to date", again.stderr)

    def test_what_cannot_be_compared_is_one_line(self):
        for code, what, arguments in ((2, "behind --against", ("one", "two", "crackle3")), (2, "B: is missing", ("one",)), (3, "one replicate", ("one", "--against", "two", "crackle3")),
                                      (3, "same history", ("one", "one", "--against", "two", "crackle3")), (3, "does not exist", ("one", "two", "--against", "crackle3", "nothing")),
                                      (2, "--through", ("one", "two", "--against", "crackle3", "crackle4", "--through", "aged"))):
            result = patinate("history", "compare", *arguments, "-o", "refused")
            self.assertEqual((result.returncode, result.stderr.count("\n")), (code, 1), result.stderr)
            self.assertIn(what, result.stderr)
        self.assertFalse((WORK / "refused").exists())


class Compare(unittest.TestCase):
    def test_says_its_figures_and_writes_a_page_that_needs_nothing_else(self):
        result = patinate("history", "compare", "one", "two", "--num-resamples", 20, "-o", "report")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("color_distribution: ", result.stderr)
        self.assertIn("A split in two", result.stderr)
        page = (WORK / "report/report.html").read_text()
        self.assertIn("Methods", page)
        for curve in json.loads((WORK / "report/report.json").read_text())["curves"]:
            drawing = (WORK / "report" / curve["drawing"]).read_text()
            self.assertEqual(xml.etree.ElementTree.fromstring(drawing).tag, "{http://www.w3.org/2000/svg}svg")
            self.assertIn(drawing.replace(' xmlns="http://www.w3.org/2000/svg"', ""), page)
        self.assertFalse("http:" in page)
        self.assertFalse("src=\"curves" in page)
        self.assertTrue("patinate history compare one two --num-resamples 20 -o OUT" in page)
        report = json.loads((WORK / "report/report.json").read_text())
        for curve in report["curves"]:
            rows = (WORK / "report" / curve["file"]).read_text().splitlines()
            self.assertGreater(len(rows), 1)
            self.assertEqual({row.count(",") for row in rows}, {rows[0].count(",")})
        self.assertIn("up to date", patinate("history", "compare", "one", "two", "--num-resamples", 20, "-o", "report").stderr)

    def test_what_the_surfaces_are_made_of_is_compared_where_a_side_states_it(self):
        for name, roughness in (("dull", 0.7), ("bright", 0.3)):
            self.assertEqual(patinate("history", "material", "one", "--roughness", roughness, "--metalness", 1, "-o", name).returncode, 0)
        result = patinate("history", "compare", "dull", "bright", "--num-times", 3, "--num-resamples", 0, "-o", "gloss", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        figures = {f["name"]: f["value"] for f in json.loads(result.stdout)["figures"]}
        self.assertAlmostEqual(figures["roughness_distance"], 0.4, places=3)
        self.assertEqual(figures["metalness_distance"], 0)
        self.assertGreater(figures["brdf_by_place"], 0)
        self.assertIn("Material beside color", (WORK / "gloss/report.html").read_text())
        self.assertTrue((WORK / "gloss/curves/roughness.csv").is_file())
        self.assertEqual(patinate("history", "compare", "one", "two", "--num-times", 3, "--num-resamples", 0, "-o", "colors").returncode, 0)
        self.assertNotIn("Material beside color", (WORK / "colors/report.html").read_text())

    def test_a_history_against_itself_differs_nowhere(self):
        result = patinate("history", "compare", "one", "one", "--num-resamples", 0, "-o", "same", "--json")
        figures = {f["name"]: f["value"] for f in json.loads(result.stdout)["figures"]}
        for name in ("ciede2000_mean", "ciede2000_p95", "residual_before_warp", "color_distribution", "spectrum_distance", "color_by_thickness"):
            self.assertEqual(figures[name], 0, name)
        self.assertEqual(figures["ssim_mean"], 1)
        page = (WORK / "same/report.html").read_text()
        self.assertIn("figures are 0: CIEDE2000, mean over places and times; ", page)
        self.assertNotIn("<td>CIEDE2000, mean over places and times</td>", page)

    def test_the_command_on_the_page_repeats_the_page(self):
        patinate("history", "compare", "one", "two", "--num-resamples", 12, "--clock", "span", "-o", "first")
        command = json.loads((WORK / "first/report.json").read_text())["command"]
        page = (WORK / "first/report.html").read_bytes()
        self.assertEqual(subprocess.run(command.replace("patinate", PATINATE, 1), shell=True, cwd=WORK, capture_output=True).returncode, 0)
        self.assertEqual(page, (WORK / "OUT/report.html").read_bytes())

    def test_a_transfer_over_time_and_a_history_through_it_are_the_same(self):
        result = patinate("history", "compare", "one", "aged", "--through", "aged", "--num-resamples", 0, "-o", "through", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        figures = {f["name"]: f["value"] for f in json.loads(result.stdout)["figures"]}
        self.assertEqual(figures["ciede2000_p95"], 0)
        self.assertEqual(figures["time_shift_median"], 0)

    def test_a_moment_between_two_photographs_is_stated_as_the_interval(self):
        # What trim leaves is every second frame: its moments are known half as well.
        self.assertEqual(patinate("trim", "two", "--every", 2, "-o", "coarse").returncode, 0)
        for clock, unit in (("absolute", 1.0), ("span", None)):
            result = patinate("compare", "one", "coarse", "--clock", clock, "--num-resamples", 0, "-o", f"moments_{clock}", "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            figures = {f["name"]: f for f in json.loads(result.stdout)["figures"]}
            page = (WORK / f"moments_{clock}/report.html").read_text()
            for side, name in (("a", "one"), ("b", "coarse")):
                times = [f["time"] for f in json.loads((WORK / name / "history.json").read_text())["frames"]]
                on_clock = times if unit else [(t - times[0]) / (times[-1] - times[0]) for t in times]
                for what in ("onset", "saturation"):
                    figure = figures[f"{what}_median_{side}"]
                    if "after" not in figure:
                        self.assertTrue(any(abs(figure["value"] - t) < 1e-6 for t in on_clock), figure)
                        continue
                    self.assertLessEqual(figure["after"], figure["value"])
                    self.assertLessEqual(figure["value"], figure["before"])
                    self.assertTrue(any(abs(figure["after"] - a) < 1e-6 and abs(figure["before"] - b) < 1e-6 for a, b in zip(on_clock, on_clock[1:])), (figure, on_clock))
                    self.assertRegex(page, rf"median of {side.upper()}</td><td>between [\d.]+ and [\d.]+</td>")
            rows = (WORK / f"moments_{clock}/figures.csv").read_text().splitlines()
            self.assertTrue(rows[0].endswith(",after,before"))
            self.assertEqual({row.count(",") for row in rows}, {rows[0].count(",")})

    def test_bad_input_is_one_line(self):
        (WORK / "picture.png").write_bytes((WORK / "one_photos/frames/0000.png").read_bytes())
        for arguments, code, words in ((("one", "nowhere"), 3, "nowhere"), (("one", "picture.png"), 3, "is no history or transfer"), (("one",), 2, "B"),
                                       (("one", "two", "--clock", "lunar"), 2, "absolute, span"), (("one", "two", "--num-blocks", 1), 2, "[2, 64]"),
                                       (("one", "two", "--through", "two"), 3, "two"), (("aged", "one", "--through", "aged"), 3, "is for a history")):
            result = patinate("history", "compare", *arguments, "-o", "bad")
            with self.subTest(arguments=arguments):
                self.assertEqual(result.returncode, code, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
                self.assertFalse((WORK / "bad").exists())


if __name__ == "__main__":
    unittest.main()
