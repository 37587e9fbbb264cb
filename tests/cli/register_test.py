#!/usr/bin/env python3
"""Scans of one object into one frame. Usage: register_test.py PATINATE [unittest arguments]"""
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SIZE = 60


def height(x, y):
    hill = lambda cx, cy, w, h: h * math.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (w * w))
    return hill(-18, 12, 16, 14) + hill(25, 20, 11, 9) + hill(10, -24, 14, -11) + hill(-30, -28, 9, 7) + 1.2 * math.sin(0.31 * x + 0.12 * y)


def turned(point, angle_deg, shift):
    """About y up to 20 degrees; else about z, the line of sight: a range grid is seen from +z."""
    x, y, z = point
    a = math.radians(angle_deg)
    if abs(angle_deg) > 20:
        return (math.cos(a) * x - math.sin(a) * y + shift[0], math.sin(a) * x + math.cos(a) * y + shift[1], z + shift[2])
    return (math.cos(a) * x + math.sin(a) * z + shift[0], y + shift[1], -math.sin(a) * x + math.cos(a) * z + shift[2])


def write_scan(path, surface=height, seed=0, angle_deg=0.0, shift=(0, 0, 0), offset=0.0, mirror=1.0):
    """A range grid in ASCII PLY, with noise of 0.03 mm."""
    rng = random.Random(seed)
    step = 100.0 / SIZE
    points = []
    for j in range(SIZE):
        for i in range(SIZE):
            x, y = (i + offset) * step - 50, (j + offset) * step - 50
            points.append(turned((mirror * x, y, surface(x, y) + rng.gauss(0, 0.03)), angle_deg, shift))
    header = ["ply", "format ascii 1.0", f"obj_info num_cols {SIZE}", f"obj_info num_rows {SIZE}", f"element vertex {len(points)}",
              *[f"property double {a}" for a in "xyz"], f"element range_grid {SIZE * SIZE}", "property list uchar int vertex_indices", "end_header"]
    path.write_text("\n".join(header + ["%.9g %.9g %.9g" % p for p in points] + [f"1 {k}" for k in range(SIZE * SIZE)]) + "\n")


class Register(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_register_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_patinate(self, *arguments, code=0):
        return self.run_command("register", *arguments, code=code)

    def run_command(self, *arguments, code=0):
        result = subprocess.run([PATINATE, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=300)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def three_steps(self):
        write_scan(self.folder / "day00.ply", seed=1)
        write_scan(self.folder / "day07.ply", seed=2, angle_deg=8, shift=(3, -1, 2), offset=0.3)
        write_scan(self.folder / "day14.ply", seed=3, angle_deg=-170, shift=(40, 5, 9), offset=0.6)
        return ["day00.ply", "day07.ply", "day14.ply"]

    def assert_is_inverse(self, matrix, angle_deg, shift, most_mm=0.05):
        for p in [(-40, -40, 3), (30, 20, 0), (0, 45, -5)]:
            q = turned(p, angle_deg, shift)
            back = [sum(matrix[r][k] * q[k] for k in range(3)) + matrix[r][3] for r in range(3)]
            self.assertLess(math.dist(back, p), most_mm)

    def test_moved_steps_come_back_into_the_first_ones_frame(self):
        scans = self.three_steps()
        result = self.run_patinate(*scans, "--unit", "mm", "--merged", "--moved", "--json", "-o", "out")
        answer = json.loads(result.stdout)
        self.assertEqual([s["status"] for s in answer["scans"]], ["converged"] * 3)
        self.assert_is_inverse(answer["scans"][1]["matrix"], 8, (3, -1, 2))
        self.assert_is_inverse(answer["scans"][2]["matrix"], -170, (40, 5, 9))
        self.assertIn("day14.ply", result.stderr)
        self.assertIn("loops before the joint solve", result.stderr)
        for name in ["registration.json", "poses.conf", "registration.png", "merged.ply", "scans/day07.ply", "run.json"]:
            self.assertTrue((self.folder / "out" / name).stat().st_size > 0, name)
        registration = json.loads((self.folder / "out/registration.json").read_text())
        self.assertEqual(registration["unit"], "mm")
        self.assertTrue(registration["scans"][2]["found_by_search"])
        self.assertIn(f"element vertex {3 * SIZE * SIZE}", (self.folder / "out/merged.ply").read_bytes()[:200].decode(errors="replace"))
        self.assertIn("up to date", self.run_patinate(*scans, "--unit", "mm", "--merged", "--moved", "-o", "out").stderr)
        facts = json.loads(self.run_command("info", "out", "--json").stdout)
        self.assertEqual((facts["kind"], facts["reference"], facts["pairs"]), ("registration", "day00.ply", len(registration["pairs"])))
        self.assertEqual([s["status"] for s in facts["scans"]], ["converged"] * 3)
        self.run_command("validate", "out/registration.json")
        registration["scans"][1]["matrix"][0][0] *= 1.001
        (self.folder / "sheared.json").write_text(json.dumps(registration))
        self.assertIn("/scans/1/matrix", self.run_command("validate", "sheared.json", code=3).stderr)
        # What comes out goes in: the same poses again, from a .conf with the scans beside it.
        shutil.copy(self.folder / "out/poses.conf", self.folder / "poses.conf")
        again = json.loads(self.run_patinate("poses.conf", "--start", "given", "--json", "-o", "again").stdout)
        for a, b in zip(again["scans"], answer["scans"]):
            for row_a, row_b in zip(a["matrix"], b["matrix"]):
                for x, y in zip(row_a, row_b):
                    self.assertAlmostEqual(x, y, places=4)

    def test_a_folder_and_any_reference(self):
        folder = self.folder / "scans"
        folder.mkdir()
        write_scan(folder / "a.ply", seed=1)
        write_scan(folder / "b.ply", seed=2, angle_deg=10, shift=(1, 2, 3), offset=0.4)
        answer = json.loads(self.run_patinate("scans", "--reference", "b.ply", "--json", "-o", "out").stdout)
        self.assertEqual(answer["reference"], "b.ply")
        self.assertIsNone(answer["unit"])
        identity = [[float(i == j) for j in range(4)] for i in range(4)]
        self.assertEqual(answer["scans"][1]["matrix"], identity)
        self.assertIn("--reference: found `c.ply`", self.run_patinate("scans", "--reference", "c.ply", "-o", "o2", code=2).stderr)

    def test_a_mirrored_scan_is_an_error_unless_accepted(self):
        self.three_steps()
        write_scan(self.folder / "day07.ply", seed=2, mirror=-1.0, offset=0.3)
        result = self.run_patinate("day00.ply", "day07.ply", "day14.ply", "-o", "out", code=1)
        self.assertIn("patinate: error: day07.ply: ", result.stderr)
        self.assertIn("--accept-failed", result.stderr)
        self.assertFalse((self.folder / "out").exists())
        answer = json.loads(self.run_patinate("day00.ply", "day07.ply", "day14.ply", "--accept-failed", "--json", "-o", "out").stdout)
        self.assertIsNone(answer["scans"][1]["matrix"])
        self.assertEqual(answer["scans"][2]["status"], "converged")

    def test_what_a_shape_leaves_open_is_said(self):
        groove = lambda x, y: 5 * math.cos(y / 6)
        write_scan(self.folder / "a.ply", groove, seed=1)
        write_scan(self.folder / "b.ply", groove, seed=2, shift=(0, 0.4, 1), offset=0.3)
        self.assertIn("does not constrain a shift along (1, 0, 0)", self.run_patinate("a.ply", "b.ply", "-o", "out", code=1).stderr)
        self.run_patinate("a.ply", "b.ply", "--accept-failed", "-o", "out")

    def test_pcl_for_comparison(self):
        write_scan(self.folder / "a.ply", seed=1)
        write_scan(self.folder / "b.ply", seed=2, angle_deg=4, shift=(1, 0, 1), offset=0.4)
        answer = json.loads(self.run_patinate("a.ply", "b.ply", "--method", "pcl-plane", "--json", "-o", "out").stdout)
        self.assert_is_inverse(answer["scans"][1]["matrix"], 4, (1, 0, 1), 0.5)

    def test_bad_input_is_one_line(self):
        write_scan(self.folder / "a.ply", seed=1)
        (self.folder / "few.ply").write_text("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n")
        (self.folder / "bad.conf").write_text("bmesh a.ply 0 0 0\n")
        (self.folder / "cut.ply").write_bytes((self.folder / "a.ply").read_bytes()[:5000])
        for arguments, code, part in [(["a.ply"], 2, "at least 2 scans"), (["a.ply", "few.ply"], 3, "few.ply: "), (["bad.conf"], 3, "line 1: found 5 words"),
                                      (["a.ply", "cut.ply"], 3, "cut.ply: truncated"), (["a.ply", "no.ply"], 3, "no.ply")]:
            with self.subTest(arguments=arguments):
                error = self.run_patinate(*arguments, "-o", "out", code=code).stderr
                self.assertIn(part, error)
                self.assertEqual(error.count("\n"), 1, error)


if __name__ == "__main__":
    unittest.main()
