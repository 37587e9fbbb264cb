"""patinate control and the controls of transfer, as a user runs them."""
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PATINATE = str(Path(sys.argv.pop(1)).resolve())

# A square of 10 mm that faces +z and fills the atlas.
PLANE = """v 0 0 0
v 10 0 0
v 10 10 0
v 0 10 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
"""


class Control(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)
        (self.path / "plane.obj").write_text(PLANE)

    def run_control(self, kind, *options, code=0, output="map.exr"):
        arguments = [PATINATE, "control", "plane.obj", "--kind", kind, "-o", output, "--resolution", "16", "--force", *options]
        done = subprocess.run(arguments, cwd=self.path, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_help_lists_every_kind_on_a_line_of_its_own(self):
        text = subprocess.run([PATINATE, "control", "--help"], capture_output=True, text=True).stdout
        for kind in ["accessibility", "ray_share", "tangent_sphere", "exposure", "sun", "facing", "height", "distance", "spray", "image"]:
            self.assertRegex(text, re.compile(rf"^  {kind} +\w", re.M))

    def test_every_kind_without_input_makes_a_map(self):
        for kind in ["accessibility", "ray_share", "tangent_sphere", "exposure", "sun", "facing", "height", "spray"]:
            self.run_control(kind)

    def test_a_map_that_is_even_is_said(self):
        text = self.run_control("facing", "--direction", "0,0,-1")
        self.assertIn("control `facing` is 0 on the whole surface; a map that is even guides nothing", text)
        self.assertNotIn("guides nothing", self.run_control("height"))

    def test_a_direction_without_length_is_wrong_input(self):
        self.assertIn("up: needs a finite length > 0", self.run_control("height", "--up", "0,0,0", code=3))

    def test_a_missing_panorama_is_named(self):
        self.assertIn("no_sky.exr", self.run_control("exposure", "--sky", "no_sky.exr", code=3))

    def test_distance_asks_from_what(self):
        self.assertIn("needs --distance-from", self.run_control("distance", code=2))
        text = self.run_control("distance", "--distance-from", "boundry", code=2)
        self.assertIn("did you mean `boundary`?", text)
        self.run_control("!distance", "--distance-from", "boundary")

    def test_strokes_come_from_a_file(self):
        (self.path / "s.csv").write_text("stroke,x,y,z\na,0,5,9\na,10,5,9\n")
        self.assertNotIn("control `spray`", self.run_control("spray", "--spray-path", "s.csv"))
        (self.path / "s.csv").write_text("stroke,x,y,z\na,0,5,9000\n")
        self.assertIn("in the same unit?", self.run_control("spray", "--spray-path", "s.csv"))
        (self.path / "s.csv").write_text("stroke,x,y,z,spred\na,0,5,9,1\n")
        self.assertIn("s.csv: line 1: unknown column `spred`; did you mean `spread`?",
                      self.run_control("spray", "--spray-path", "s.csv", code=3))


if __name__ == "__main__":
    unittest.main()
