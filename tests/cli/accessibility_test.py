#!/usr/bin/env python3
"""patinate control accessibility: scans and meshes, with and without a camera. Usage: accessibility_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_accessibility_"))


def run(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True, timeout=300)


def setUpModule():
    assert run("synth", "mold", "--width", "64", "--height", "48", "--steps", "1", "--lights", "1", "--scan-spacing", "2", "-o", "mold").returncode == 0


def tearDownModule():
    shutil.rmtree(WORK)


class Accessibility(unittest.TestCase):
    def test_a_scan_gives_three_maps_and_how_far_they_agree(self):
        result = run("control", "accessibility", "mold/step00/scan.ply", "--resolution", "64", "--share-rays", "32", "--scale", "4", "-o", "out", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        correlation = json.loads(result.stdout)["correlation"]
        self.assertEqual([len(row) for row in correlation], [3, 3, 3])
        self.assertTrue(all(row[i] == 1 for i, row in enumerate(correlation)))
        report = json.loads((WORK / "out/accessibility.json").read_text())
        self.assertEqual([d["name"] for d in report["definitions"]], ["accessibility", "ray_share", "tangent_sphere"])
        self.assertLess(report["definitions"][0]["range"][0], 0)
        for d in report["definitions"]:
            self.assertTrue((WORK / "out" / d["file"]).exists())
            self.assertIn(d["name"] + ".png", (WORK / "out/report.html").read_text())
        self.assertIn("up to date", run("control", "accessibility", "mold/step00/scan.ply", "--resolution", "64", "--share-rays", "32", "--scale", "4", "-o", "out").stderr)

    def test_what_is_wrong_is_one_line(self):
        for arguments, code, said in ((["none.ply"], 3, "none.ply"), (["mold/step00/scan.ply", "--scale", "0"], 2, "scale"),
                                      (["mold/step00/scan.ply", "--direction", "0,0,0"], 2, "direction"), (["mold/step00/scan.ply", "--scale", "0.01"], 3, "width")):
            result = run("control", "accessibility", *arguments, "-o", "wrong")
            lines = [line for line in result.stderr.splitlines() if "error:" in line]
            self.assertEqual((result.returncode, len(lines)), (code, 1), f"{arguments} {result.returncode} {result.stderr}")
            self.assertIn(said, lines[0])


if __name__ == "__main__":
    unittest.main()
