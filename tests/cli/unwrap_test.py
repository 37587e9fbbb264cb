"""--atlas as a user runs it on a mesh without UVs; Blender is played by a script, and run itself where it is installed."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PATINATE = str(Path(sys.argv.pop(1)).resolve())

TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

# Lays triangle i in cell i of a 2 x 2 grid; $PLAY says what goes wrong.
BLENDER = f"""#!{sys.executable}
import os, sys, time
source, target, margin = sys.argv[sys.argv.index("--") + 1:]
play = os.environ["PLAY"]
if play == "fail":
    print("Error: no such operator")
    sys.exit(1)
lines = open(source).read().splitlines()
num_positions, num_triangles = map(int, lines[0].split())
triangles = [list(map(int, line.split())) for line in lines[1 + num_positions:]]
if play == "fewer":
    triangles.pop()
if play == "order":
    triangles.reverse()
with open(target, "w") as out:
    print(len(triangles), file=out)
    for i, corners in enumerate(triangles):
        for corner, (u, v) in zip(corners, ((0.05, 0.05), (0.45, 0.05), (0.05, 0.45))):
            print(corner, u + i % 2 / 2, v + i // 2 / 2 + (9 if play == "outside" else 0), file=out)
"""


class Atlas(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)
        (self.path / "mesh.obj").write_text(TETRAHEDRON)
        (self.path / "bin").mkdir()

    def run_control(self, atlas, code=0, play=None, path=None):
        environment = dict(os.environ, PATH=str(self.path / "bin") if path is None else path)
        if play:
            program = self.path / "bin/blender"
            program.write_text(BLENDER)
            program.chmod(0o755)
            environment["PLAY"] = play
        arguments = [PATINATE, "control", "mesh.obj", "--kind", "facing", "-o", "map.exr", "--resolution", "64", "--force", "--atlas", atlas]
        done = subprocess.run(arguments, cwd=self.path, capture_output=True, text=True, timeout=300, env=environment)
        self.assertEqual(done.returncode, code, done.stderr)
        if code != 0:
            self.assertEqual(len([line for line in done.stderr.splitlines() if "blender" in line]), 1, done.stderr)
        return done.stderr

    def test_unwrap_needs_no_uvs_and_no_other_program(self):
        self.run_control("unwrap")
        self.assertTrue((self.path / "map.exr").exists())

    def test_blender_lays_out_the_mesh(self):
        self.run_control("blender", play="well")
        self.assertTrue((self.path / "map.exr").exists())

    def test_without_blender_one_line_says_so(self):
        self.assertIn("is not installed", self.run_control("blender", code=1))

    def test_what_blender_says_is_passed_on(self):
        self.assertIn("no such operator", self.run_control("blender", code=1, play="fail"))

    def test_another_mesh_than_was_given_is_refused(self):
        self.assertIn("returned 3 triangles of 4", self.run_control("blender", code=1, play="fewer"))
        self.assertIn("another order", self.run_control("blender", code=1, play="order"))
        self.assertIn("outside [0, 1]", self.run_control("blender", code=1, play="outside"))

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_blender_itself_lays_out_the_mesh(self):
        self.run_control("blender", path=os.environ["PATH"])
        self.assertTrue((self.path / "map.exr").exists())


if __name__ == "__main__":
    unittest.main()
