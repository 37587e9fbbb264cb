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
        text = self.run_control("facing(direction=-z)")
        self.assertIn("control `facing` is 0 on the whole surface; a map that is even guides nothing", text)
        self.assertNotIn("guides nothing", self.run_control("height"))

    def test_a_direction_without_length_is_wrong_input(self):
        self.assertIn("up: needs a finite length > 0", self.run_control("height(up=0,0,0)", code=3))

    def test_a_missing_panorama_is_named(self):
        self.assertIn("no_sky.exr", self.run_control("exposure(sky=no_sky.exr)", code=3))

    def test_distance_asks_from_what(self):
        self.assertIn("distance(from=creases)", self.run_control("distance", code=2))
        text = self.run_control("distance(from=boundry)", code=2)
        self.assertIn("did you mean `boundary`?", text)
        self.run_control("!distance(from=boundary)")

    def test_strokes_come_from_a_file(self):
        (self.path / "s.csv").write_text("stroke,x,y,z\na,0,5,9\na,10,5,9\n")
        self.assertNotIn("control `spray`", self.run_control("spray(path=s.csv)"))
        (self.path / "s.csv").write_text("stroke,x,y,z\na,0,5,9000\n")
        self.assertIn("in the same unit?", self.run_control("spray(path=s.csv)"))
        (self.path / "s.csv").write_text("stroke,x,y,z,spred\na,0,5,9,1\n")
        self.assertIn("s.csv: line 1: unknown column `spred`; did you mean `spread`?",
                      self.run_control("spray(path=s.csv)", code=3))

    # Each kind with an option as its argument, and as the option of the command that it was.
    ARGUMENTS = [("accessibility(scale=2)", ["--scale", "2"]), ("accessibility(low-percent=5, high_percent=90)", ["--low-percent", "5", "--high-percent", "90"]),
                 ("ray_share(rays=32, reach=4)", ["--share-rays", "32", "--reach", "4"]), ("tangent_sphere( largest = 7 , angle=6,percent=98)",
                 ["--largest-sphere", "7", "--sphere-angle", "6", "--sphere-percent", "98"]), ("exposure(sky_rays=32, sun_share=0.5, axis=z, sun_direction=0,1,1)",
                 ["--sky-rays", "32", "--sun-share", "0.5", "--up", "0,0,1", "--sun-direction", "0,1,1"]), ("sun(direction=0,1,1, radius=3, arc=90)",
                 ["--sun-direction", "0,1,1", "--sun-radius", "3", "--sun-arc", "90"]), ("facing(direction=0,1,1)", ["--direction", "0,1,1"]), ("facing(direction=z)", ["--direction", "0,0,1"]),
                 ("height(axis=-y)", ["--up", "0,-1,0"]), ("distance(from=boundary, metric=euclidean, range=4)",
                 ["--distance-from", "boundary", "--distance-metric", "euclidean", "--distance-range", "4"]), ("distance(distance_from=boundary)", ["--distance-from", "boundary"]),
                 ("spray(spread=20, shadows=false, full_percent=95)", ["--spread", "20", "--no-spray-shadows", "--full-percent", "95"]), ("image(file=\"a, map.exr\")", ["--image", "a, map.exr"])]

    def test_arguments_of_a_kind_are_what_options_were(self):
        self.run_control("facing(direction=0,1,1)", output="a, map.exr")
        for text, options in self.ARGUMENTS:
            with self.subTest(text=text):
                kind = re.match(r"\w+", text)[0]
                self.assertNotIn("is written in the control", self.run_control(text, output="new.exr"))
                said = self.run_control(kind, *options, output="old.exr")
                names = [o for o in options if o.startswith("--")]
                advice = [line.split(": is written in the control now, as ") for line in said.splitlines() if "is written in" in line]
                self.assertEqual(sorted(option.replace("--spray-s", "--no-spray-s") for option, _ in advice), sorted(names))
                self.assertEqual((self.path / "new.exr").read_bytes(), (self.path / "old.exr").read_bytes())
                for _, forms in advice:  # What is advised can be written.
                    for form in forms.split(" or "):
                        self.run_control(form if "distance" not in form or "from" in form else form[:-1] + ", from=boundary)")

    def test_two_maps_of_a_kind_in_one_formula(self):
        self.run_control("0.5*facing(direction=z) + 0.5*facing(direction=y)", output="mix.exr")
        self.run_control("0.5*facing(direction=z) + 0.5*facing(direction=0,0,1)", output="twice.exr")
        self.run_control("facing(direction=z)", output="once.exr")
        self.assertNotEqual((self.path / "mix.exr").read_bytes(), (self.path / "twice.exr").read_bytes())

    def test_arguments_that_are_wrong_are_named_with_their_place(self):
        for text, words in (("accessibility(scal=3)", "position 15: `accessibility` has no argument `scal`; did you mean `scale`?; it has scale, low_percent, high_percent"),
                            ("!accessibility(scale=0)", "position 16: accessibility(scale=...): found `0`; expected a number > 0"),
                            ("accessibility(scale=3, scale=4)", "position 24: `scale` is given twice"), ("facing(scale=3)", "no argument `scale`"),
                            ("facing(direction=1,2)", "expected x, y, z, -x, -y, -z or 3 numbers"), ("facing(direction=w)", "expected x, y, z"),
                            ("distance(from=boundary, metric=euclid)", "expected one of geodesic, euclidean"), ("spray(shadows=no)", "expected true or false"),
                            ("ray_share(rays=32.5)", "expected an integer"), ("facing(direction=", "expected a value"), ("facing()", "expected an argument"), ("facing(z)", "expected an argument"),
                            ("facing(direction=z", "expected `)`"), ("image(file=\"x)", "between two")):
            with self.subTest(text=text):
                said = self.run_control(text, code=2)
                self.assertIn(words, said)
                self.assertEqual(said.count("\n"), 1)

    def test_help_lists_the_arguments_in_place_of_options(self):
        first, everything = (subprocess.run([PATINATE, "control", option], capture_output=True, text=True).stdout for option in ("--help", "--help-all"))
        self.assertIn("accessibility(scale=X)", everything)
        self.assertNotIn("accessibility(scale=X)", first)
        for options in (["control"], ["control", "explain"], ["transfer"]):
            text = subprocess.run([PATINATE, *options, "--help-all"], capture_output=True, text=True).stdout
            for name in ("--scale", "--sun-arc", "--spray-path", "--image", "--distance-from"):
                self.assertNotIn(f"\n  {name} ", text)
        self.assertEqual(self.run_control("facing", "--sprad", "3", code=2).count("did you mean"), 0)  # Nothing leads to them.


if __name__ == "__main__":
    unittest.main()
