#!/usr/bin/env python3
"""patinate control explain as a user runs it. Usage: explain_test.py PATINATE [unittest arguments]"""
import csv
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

import calibration_scene as scene
from command_case import INPUT, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
RESOLUTION = ["--resolution", "128"]
# 4 kinds of control need 79 shuffles to be told from chance.
QUICK = [*RESOLUTION, "--kind", "facing", "--kind", "height", "--kind", "accessibility", "--kind", "spray", "--num-samples", "2000", "--shuffles", "199", "--resamples", "50"]


def setUpModule():
    use(PATINATE)
    # Kept control maps of tests go with the module.
    os.environ["XDG_CACHE_HOME"] = str(CommandCase.shared / "cache")
    for kind in ("height", "accessibility"):
        subprocess.run([CommandCase.patinate, "control", "urn/mesh.obj", "--kind", kind, *RESOLUTION, "-o", f"{kind}.exr"], cwd=CommandCase.shared, check=True, capture_output=True)


class Explain(CommandCase):
    def explain(self, reference, *more, options=QUICK):
        self.succeeds("control", "explain", reference, self.shared / "urn/mesh.obj", "--unit", "mm", *options, *more, "-o", "why")
        return json.loads((self.folder / "why/explanation.json").read_text())

    def test_a_control_that_explains_nothing_is_said_to(self):
        numbers = random.Random(1)
        scene.write_png(self.folder / "noise.png", 64, 64, lambda x, y: numbers.random())
        result = self.run_patinate("control", "explain", "noise.png", self.shared / "urn/mesh.obj", "--unit", "mm", *QUICK, "-o", "why")
        self.assertEqual(result.returncode, 0, result.stderr)
        candidates = json.loads((self.folder / "why/explanation.json").read_text())["candidates"]
        said = {c["name"]: "explains nothing" in line for c in candidates for line in result.stderr.splitlines() if line.startswith(f"  {c['name']}: ")}
        self.assertEqual({c["name"]: said[c["name"]] for c in candidates if not c["even"]}, {c["name"]: not c["explains"] for c in candidates if not c["even"]})
        self.assertTrue(any(said.values()))

    def test_the_kind_that_a_reference_was_made_of_comes_first(self):
        for kind in ("height", "accessibility"):
            report = self.explain(self.shared / f"{kind}.exr", "--force")
            first = report["candidates"][0]
            self.assertEqual(first["name"], kind)
            # The same texels: what is less than 1 comes of places where the control is clamped.
            self.assertGreater(first["correlation"], 0.95)
            self.assertTrue(first["explains"])
            self.assertEqual(report["mix"]["expression"], kind)

    def test_every_kind_is_tried_and_the_page_shows_it(self):
        report = self.explain(self.shared / "height.exr", options=[*RESOLUTION, "--num-samples", "1000", "--share-rays", "16", "--sky-rays", "16", "--shuffles", "199", "--resamples", "50"])
        tried = {c["name"] for c in report["candidates"]} | {s["name"] for s in report["skipped"]}
        self.assertEqual(tried, {"accessibility", "ray_share", "tangent_sphere", "exposure", "sun", "facing", "height", "distance", "spray"})
        page = (self.folder / "why/report.html").read_text()
        self.assertGreaterEqual(page.count("data:image/png"), 5)
        self.assertNotIn("src=\"http", page)
        rows = list(csv.DictReader((self.folder / "why/figures.csv").read_text().splitlines()))
        self.assertEqual(rows[0]["control"], "height")
        self.assertEqual(sorted(p.name for p in (self.folder / "why").iterdir()), ["explanation.json", "figures.csv", "job.json", "report.html", "run.json"])

    def test_the_low_end_turns_the_sign(self):
        report = self.explain(self.shared / "height.exr", "--aged", "low")
        self.assertLess(report["candidates"][0]["correlation"], -0.95)
        self.assertTrue(report["candidates"][0]["inverse"])
        self.assertEqual(report["mix"]["expression"], "!height")

    def test_transfer_takes_the_mix(self):
        report = self.explain(self.shared / "height.exr", "--before", self.shared / "accessibility.exr", "--channel", "luminance")
        self.assertEqual({(m["name"], m["inverse"]) for m in report["mix"]["members"]}, {("height", False), ("accessibility", True)})
        self.succeeds("transfer", self.shared / "history", self.shared / "urn/mesh.obj", "--control", report["mix"]["expression"], "--resolution", "64", "-o", "aged")

    def test_the_same_again_is_up_to_date_and_has_the_same_bytes(self):
        self.explain(self.shared / "height.exr")
        before = tree_of(self.folder / "why")
        self.assertIn("up to date", self.run_patinate("control", "explain", self.shared / "height.exr", self.shared / "urn/mesh.obj", "--unit", "mm", *QUICK, "-o", "why").stderr)
        shutil.rmtree(self.folder / "why")
        self.explain(self.shared / "height.exr", "--threads", "1")
        self.assertEqual(tree_of(self.folder / "why"), before)

    def test_a_mask_keeps_the_rest_out(self):
        half = self.folder / "half.pgm"
        half.write_bytes(b"P5 128 128 255\n" + (b"\xff" * 64 + b"\x00" * 64) * 128)
        whole, inside = self.explain(self.shared / "height.exr"), self.explain(self.shared / "height.exr", "--mask", half, "--force")
        self.assertLess(inside["area_mm2"], 0.9 * whole["area_mm2"])

    def test_a_reference_of_another_size_is_brought_to_the_texels_and_said(self):
        report = self.explain(self.shared / "height.exr", options=["--resolution", "64", *QUICK[2:]])
        self.assertEqual(report["candidates"][0]["name"], "height")
        self.assertGreater(report["candidates"][0]["correlation"], 0.95)
        self.assertIn("128 x 128", " ".join(report["notes"]))

    def test_info_and_validate_know_its_folder(self):
        report = self.explain(self.shared / "height.exr")
        facts = json.loads(self.run_patinate("info", "why", "--json").stdout)
        self.assertEqual(facts["verdict"], report["verdict"])
        self.assertEqual(facts["candidates"][0]["name"], "height")
        self.assertIn("OK", self.run_patinate("validate", "why").stdout)
        (self.folder / "why/figures.csv").unlink()
        self.fails(INPUT, "figures.csv", "validate", "why")

    def test_a_transfer_is_explained_by_what_it_followed(self):
        # `aged` followed `facing`, at 64 texels.
        report = self.explain(self.shared / "aged", "--time", "0", "--channel", "thickness", options=["--resolution", "64", *QUICK[2:]])
        self.assertEqual(report["candidates"][0]["name"], "facing")

    def test_what_is_wrong_is_said_in_one_line(self):
        mesh, out = self.shared / "urn/mesh.obj", ("-o", "why")
        (self.folder / "flat.pgm").write_bytes(b"P5 64 64 255\n" + b"\x80" * 4096)
        (self.folder / "wide.pgm").write_bytes(b"P5 128 64 255\n" + bytes(range(128)) * 64)
        (self.folder / "bare.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nv 9 9 1\nf 1 2 3\nf 2 4 3\n")
        height, unit = self.shared / "height.exr", ("--unit", "mm")
        self.fails(INPUT, "is the same everywhere", "control", "explain", "flat.pgm", mesh, *unit, *QUICK, *out)
        self.fails(INPUT, "no picture of the atlas", "control", "explain", "wide.pgm", mesh, *unit, *QUICK, *out)
        self.fails(INPUT, "UV", "control", "explain", height, "bare.obj", *unit, *QUICK, *out)
        self.fails(INPUT, "does not exist", "control", "explain", "nothing.png", mesh, *unit, *QUICK, *out)
        self.fails(INPUT, "shuffles cannot tell", "control", "explain", height, mesh, *unit, *RESOLUTION, "--shuffles", "99", "--share-rays", "16", "--sky-rays", "16", *out)
        self.fails(INPUT, "no `position` map", "control", "explain", self.shared / "history", mesh, *unit, *QUICK, *out)
        self.fails(USAGE, "did you mean `luminance`?", "control", "explain", height, mesh, *unit, *QUICK, "--channel", "luminence", *out)
        self.fails(USAGE, "did you mean `height`?", "control", "explain", height, mesh, *unit, *RESOLUTION, "--kind", "heigth", *out)
        self.fails(USAGE, "--also takes expressions", "control", "explain", height, mesh, *unit, *RESOLUTION, "--kind", "!height", *out)


if __name__ == "__main__":
    unittest.main()
