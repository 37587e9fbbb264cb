#!/usr/bin/env python3
"""Where a scene's numbers differ from place to place, as a user would ask. Usage: field_test.py PATINATE [unittest arguments]"""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from small_scene import PLATE, PLATE_SCENE

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_field_"))

# Enough drops that what differs from place to place is the field more than where they happened to fall.
SCENE = {**PLATE_SCENE, "emitters": [{**PLATE_SCENE["emitters"][0], "gammatons": 1000}], "run": {"iterations": 30, "history_every": 3}}
LOW, HIGH, RATE = 0.1, 10.0, 1.0
VARY = ["--vary", f"/rules/0/rate={LOW}:{HIGH}:log"]


def patinate(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True, timeout=600)


def scene(**rule):
    copy = json.loads(json.dumps(SCENE))
    copy["rules"][0] = {"name": "patina", "rate": RATE, **rule}
    return copy


def true_rate(y):
    """Of the truth below: `height` is 0 at the foot of the plate, where y is 1, and 1 at its top."""
    return 4 * (0.1 + 0.9 * (1 - y))


def field_at(field, x, y):
    """The value of a field of report.json at a place."""
    waves, c = field["waves"], field["coefficients"]
    unit = sum(c[j * waves + i] * math.cos(math.pi * i * x) * math.cos(math.pi * j * y) for j in range(waves) for i in range(waves))
    low, high = field["range"]
    return low * (high / low) ** min(max(unit, 0), 1)


def setUpModule():
    (WORK / "plate.obj").write_text(PLATE)
    (WORK / "start.json").write_text(json.dumps(scene()))
    truth = scene(rate=4, where="0.1 + 0.9*height")
    truth["seed"] = 2  # Other drops than those of the search.
    (WORK / "truth.json").write_text(json.dumps(truth))
    assert patinate("simulate", "truth.json", "-o", "captured").returncode == 0


def tearDownModule():
    shutil.rmtree(WORK)


class Field(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        times = [f["time"] for f in json.loads((WORK / "captured/history/history.json").read_text())["frames"]]
        cls.until = times[2 * len(times) // 3]
        cls.result = patinate("fit", "field", "start.json", "captured", *VARY, "--places", "equal", "--waves", 4, "--until", cls.until, "-o", "found", "--json")
        assert cls.result.returncode == 0, cls.result.stderr
        cls.report = json.loads((WORK / "found/report.json").read_text())

    def test_a_rate_that_rises_from_foot_to_top_is_found_again(self):
        field = self.report["fields"][0]
        places = [((i + 0.5) / 16, (j + 0.5) / 16) for i in range(16) for j in range(16)]
        found = [math.log2(field_at(field, x, y)) for x, y in places]
        true = [math.log2(true_rate(y)) for _, y in places]
        mean = [sum(v) / len(v) for v in (found, true)]
        covariance = sum((f - mean[0]) * (t - mean[1]) for f, t in zip(found, true))
        spread = [math.sqrt(sum((v - m) ** 2 for v in values)) for values, m in ((found, mean[0]), (true, mean[1]))]
        self.assertGreater(covariance / (spread[0] * spread[1]), 0.9)
        # Levels are an octave apart (8 steps over 6.6 octaves); half of that is what reading between them leaves at most.
        error = math.sqrt(sum((f - t) ** 2 for f, t in zip(found, true)) / len(places))
        self.assertLess(error, 0.5)

    def test_fields_explain_most_of_what_one_number_leaves_on_frames_that_were_not_seen_too(self):
        # Other drops leave something even to the true scene: of the rest, fields are to explain more than half.
        truth = json.loads((WORK / "truth.json").read_text())
        truth["seed"] = SCENE["seed"]
        (WORK / "oracle.json").write_text(json.dumps(truth))
        self.assertEqual(patinate("fit", "field", "oracle.json", "captured", *VARY, "--places", "equal", "--waves", 1, "--levels", 3, "--until", self.until, "-o", "oracle").returncode, 0)
        oracle = json.loads((WORK / "oracle/report.json").read_text())["before"]
        for frames in ("seen", "held_out"):
            least, after, single = (r[frames]["by_place"] ** 2 for r in (oracle, self.report["after"], self.report["single"]))
            self.assertLess(after - least, 0.5 * (single - least), frames)
        self.assertAlmostEqual(self.report["explained_seen"], 1 - self.report["after"]["seen"]["by_place"] ** 2 / self.report["single"]["seen"]["by_place"] ** 2)
        self.assertIn("held-out frames", self.result.stderr)
        page = (WORK / "found/report.html").read_text()
        for said in ("octaves (doublings) over the best for all places", "best numbers for all places", "frames that no search saw", "Choice of the smoothness"):
            self.assertIn(said, page)

    def test_the_scene_with_the_field_is_a_scene_like_any_other(self):
        made = json.loads((WORK / "found/scene.json").read_text())
        self.assertEqual(made["rules"][0]["where"], "field_1")
        self.assertEqual(made["maps"]["field_1"], {"kind": "image", "image": "fields/field_1.exr"})
        self.assertTrue(LOW <= made["rules"][0]["rate"] <= HIGH)
        result = patinate("simulate", "found/scene.json", "-o", "again")
        self.assertEqual(result.returncode, 0, result.stderr)
        # The picture has what the search gave in memory, so the amounts are the same.
        for k in (0, 5, 10):
            self.assertEqual((WORK / f"again/history/frames/{k:04d}.exr").read_bytes(), (WORK / f"found/after/frames/{k:04d}.exr").read_bytes())
        # And fit takes it, from another folder.
        (WORK / "deep").mkdir()
        fitted = patinate("fit", "found/scene.json", "captured", "--vary", "/appearance/patina/strength=0.1:3", "--evaluations", 13, "--seeds", 1, "--scan", 2, "-o", "deep/fitted")
        self.assertEqual(fitted.returncode, 0, fitted.stderr)
        self.assertEqual(patinate("simulate", "deep/fitted/scene.json", "-o", "third").returncode, 0)

    def test_a_second_field_is_laid_over_the_first(self):
        result = patinate("fit", "field", "found/scene.json", "captured", "--vary", "/objects/0/initial/patina=0:1", "--vary", "/rules/0/rate=0.1:10:log", "--places", "equal", "--levels", 3, "--sweeps", 1, "--waves", 2, "-o", "wrong")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("/objects/0/initial/patina: is not in", result.stderr)
        laid = json.loads((WORK / "start.json").read_text())
        laid["objects"][0]["initial"] = {"patina": 0.1}
        (WORK / "laid.json").write_text(json.dumps(laid))
        result = patinate("fit", "field", "laid.json", "captured", "--vary", "/objects/0/initial/patina=0:1", *VARY, "--places", "equal", "--levels", 5, "--sweeps", 1, "--waves", 3, "-o", "two", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads((WORK / "two/report.json").read_text())
        self.assertEqual([f["pointer"] for f in report["fields"]], ["/objects/0/initial/patina", "/rules/0/rate"])
        self.assertGreater(report["fields"][1]["explained_seen"], report["fields"][0]["explained_seen"])
        self.assertEqual(patinate("simulate", "two/scene.json", "-o", "two_run").returncode, 0)

    def test_same_bytes_for_any_number_of_threads_and_up_to_date_after(self):
        for threads in (1, 2):
            self.assertEqual(patinate("fit", "field", "start.json", "captured", *VARY, "--places", "equal", "--levels", 3, "--waves", 2, "-o", f"out{threads}", "--threads", threads).returncode, 0)
        for file in ("report.html", "report.json", "scene.json", "fields/field_1.exr", "after/frames/0005.exr"):
            if (WORK / "out1" / file).exists() or file.startswith("report"):
                self.assertEqual((WORK / "out1" / file).read_bytes(), (WORK / "out2" / file).read_bytes(), file)
        self.assertIn("up to date", patinate("fit", "field", "start.json", "captured", *VARY, "--places", "equal", "--levels", 3, "--waves", 2, "-o", "out1").stderr)

    def test_what_cannot_be_a_field_is_said_in_a_line_and_nothing_is_made(self):
        for arguments, said in (((*VARY,), "--places equal"), (("--places", "equal"), "nothing may vary"), (("--vary", "/exchange/rates/water=0.1:1", "--places", "equal"), "only the rate of a rule"),
                                (("--vary", "/rules/0/rate=2:10:log", "--places", "equal"), "outside 2 to 10"), (("--vary", "/rules/7/rate=2:10:log", "--places", "equal"), "is not in")):
            result = patinate("fit", "field", "start.json", "captured", *arguments, "-o", "refused")
            self.assertNotEqual(result.returncode, 0, arguments)
            errors = [line for line in result.stderr.splitlines() if "error" in line]
            self.assertEqual(len(errors), 1, result.stderr)
            self.assertIn(said, errors[0])
            self.assertFalse((WORK / "refused").exists())


if __name__ == "__main__":
    unittest.main()
