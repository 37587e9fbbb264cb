#!/usr/bin/env python3
"""A shape through time, as the documentation has it: synth, info, validate, ingest, transfer. Usage: relit_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_relit_"))
MOLD = ["synth", "mold", "--width", "96", "--height", "72", "--steps", "3", "--lights", "4", "--scan-spacing", "1.5", "-o", "mold"]


def run(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True, timeout=300)


def setUpModule():
    assert run(*MOLD).returncode == 0


def tearDownModule():
    shutil.rmtree(WORK)


class Relit(unittest.TestCase):
    def test_options_of_a_fixed_camera_are_refused(self):
        for option in ("--align auto", "--align-model auto", "--align-to x.png", "--mask-background plain", "--static-light off", "--deviations",
                       "--stabilize", "--deflicker", "--flat-field estimate", "--highlights keep"):
            refused = run("ingest", "mold/capture.json", "-o", "refused", *option.split())
            self.assertEqual(refused.returncode, 2, option)
            self.assertIn("error: " + option.split()[0] + ": is for captures of a fixed camera", refused.stderr)

    def test_options_of_lamps_are_refused_for_a_fixed_camera(self):
        self.assertEqual(run("synth", "crackle", "--width", "32", "--height", "32", "--num-frames", "2", "-o", "paint").returncode, 0)
        for option in ("--specular material", "--specular auto", "--normals keep", "--heights", "--poses each", "--method symmetric", "--strengths"):
            refused = run("ingest", "paint", "-o", "refused", *option.split())
            self.assertEqual(refused.returncode, 2, option)
            self.assertIn("error: " + option.split()[0] + ": is for captures under lamps", refused.stderr)
            self.assertEqual(refused.stderr.count("\n"), 1)
        self.assertEqual(run("ingest", "paint", "-o", "taken", "--accept-failed").returncode, 0)

    def test_mold_becomes_a_history_with_a_report(self):
        self.assertEqual(run("validate", "mold").returncode, 0)
        facts = json.loads(run("info", "mold", "--json").stdout)
        self.assertEqual((facts["capture_kind"], facts["lights"], facts["times"]), ("relit", 4, [0, 20, 40]))
        result = run("ingest", "mold/capture.json", "-o", "copper", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual((report["frames"], report["controls"], report["excluded"]), (3, ["accessibility"], []))
        self.assertEqual(run("validate", "copper").returncode, 0)
        page = (WORK / "copper/report.html").read_text()
        for picture in ("albedo", "light", "samples", "stddev"):
            self.assertIn(f"report/{picture}_0002.png", page)
            self.assertTrue((WORK / f"copper/report/{picture}_0002.png").stat().st_size > 100)
        steps = json.loads((WORK / "copper/relit.json").read_text())["steps"]
        self.assertTrue(all(s["determined_share"] > 0.7 for s in steps), steps)
        self.assertIn("up to date", run("ingest", "mold/capture.json", "-o", "copper").stderr)

    def test_relief_and_gloss_go_along_to_another_object(self):
        self.assertEqual(run("ingest", "mold/capture.json", "-o", "copper").returncode, 0)
        (WORK / "plane.obj").write_text("v 0 0 0\nv 40 0 0\nv 40 40 6\nv 0 40 6\nvt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\nf 1/1 2/2 3/3 4/4\n")
        result = run("transfer", "copper", "plane.obj", "--control", "accessibility=height", "--unit", "mm", "--resolution", "64", "-o", "aged")
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ("normal.png", "normal.exr", "roughness.png", "specular.exr", "height.exr"):
            result = run("texture", "aged", "--time", "20", "--map", name.split(".")[0], "-o", name)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("up to date", run("texture", "aged", "--time", "20", "--map", name.split(".")[0], "-o", name).stderr)
        self.assertEqual(json.loads(run("info", "normal.exr", "--json").stdout)["channels"], ["X", "Y", "Z"])
        self.assertEqual(run("texture", "aged", "--time", "20", "--map", "height", "-o", "height.png").returncode, 2)
        self.assertEqual(run("texture", "aged", "--time-map", "height", "--map", "normal", "-o", "x.png").returncode, 2)
        self.assertEqual(run("export", "aged", "-o", "aged.glb", "--times", "0,40").returncode, 0)
        data = (WORK / "aged.glb").read_bytes()
        gltf = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])
        for material in gltf["materials"]:
            self.assertIn("normalTexture", material)
            self.assertIn("metallicRoughnessTexture", material["pbrMetallicRoughness"])
        self.assertEqual(run("render", "aged", "--time", "40", "--width", "64", "--height", "64", "-o", "aged.png").returncode, 0)

    def test_what_is_wrong_is_one_line_and_an_exit_code(self):
        project = json.loads((WORK / "mold/capture.json").read_text())
        for change, code, said in (({"lights": project["lights"][:2]}, 3, "2 photographs"), ({"unit": "feet"}, 3, "/unit"),
                                   ({"steps": [{**project["steps"][0], "scan": "none.ply"}]}, 3, "none.ply"),
                                   ({"steps": [project["steps"][0], {**project["steps"][1], "transform": [[1, 0, 0, 400], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}, 1, "overlap")):
            (WORK / "mold/wrong.json").write_text(json.dumps({**project, **change}))
            result = run("ingest", "mold/wrong.json", "-o", "wrong")
            lines = [line for line in result.stderr.splitlines() if "error:" in line]
            self.assertEqual((result.returncode, len(lines)), (code, 1), result.stderr)
            self.assertIn(said, lines[0])
            self.assertFalse((WORK / "wrong").exists())


if __name__ == "__main__":
    unittest.main()
