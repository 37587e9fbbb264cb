#!/usr/bin/env python3
"""Calibration as a user does it, from photographs to a project that uses the result. Usage: calibrate_test.py PATINATE [unittest arguments]"""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import calibration_scene as scene

DOWN = scene.rotation([1, 0, 0], math.pi)  # A camera above a table looks down.


class Calibrate(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_calibrate_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_(self, *arguments):
        return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True)

    def succeeds(self, *arguments):
        result = self.run_(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def fails(self, code, message, kind, description, *more):
        scene.save(self.folder / "bad.json", description)
        result = self.run_("calibrate", kind, "bad.json", "-o", "bad_result.json", *more)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(message, result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        self.assertFalse((self.folder / "bad_result.json").exists())

    def description(self, kind, **more):
        return {"format": "patinate.calibrate", "version": 1, "kind": kind, **more}

    def load(self, name):
        return json.loads((self.folder / name).read_text())


class Camera(Calibrate):
    def views(self, tilt, num, scale):
        for i in range(num):
            turn = scene.rotation([math.cos(1.7 * i), math.sin(1.7 * i), 0], tilt)
            camera = scene.Pinhole(int(320 * scale), int(240 * scale), 400.0 * scale, turn, None)
            camera.shift = scene.add([0, 0, 190.0], scene.times(turn, [40, 25, 0]), -1)
            scene.write_png(self.folder / f"view{i}.png", camera.width, camera.height, scene.chessboard(camera, 9, 6, 10.0))
        return [f"view{i}.png" for i in range(num)]

    def test_a_chessboard_and_scanner_points_give_a_camera_that_projects_use(self):
        board = {"chessboard": [9, 6], "spacing": 1.0}
        truth = scene.Pinhole(240, 180, 300.0, DOWN, [5.0, -8.0, 300.0])
        points = [[x, y, (x * y) % 31] for x in (-60, -20, 30, 70) for y in (-50, 10, 45)]
        scanner = {"points": [[c / 10 for c in p] for p in points], "pixels": [truth.pixel(p) for p in points]}
        scene.save(self.folder / "board.json", self.description("camera", unit="cm", target=board, views=self.views(0.5, 4, 0.75), scanner=scanner))
        said = self.succeeds("calibrate", "camera", "board.json", "-o", "camera.json", "--lens", "none", "--picture", "residuals.png", "--json")
        report = json.loads(said.stdout)["report"]
        camera = self.load("camera.json")["camera"]
        # Corners of a rendered board are found to a few hundredths of a pixel.
        self.assertAlmostEqual(camera["matrix"][0][0], 300.0, delta=1.0)
        self.assertLess(abs(camera["matrix"][0][0] - 300.0), 4 * report["sd"]["fx"] + 0.5)
        for found, true in zip(camera["translation"], [5.0, -8.0, 300.0]):
            self.assertAlmostEqual(found, true, delta=1.5)
        self.assertEqual(len(report["views"]), 5)
        self.assertLess(report["rms_px"], 0.05)
        self.assertTrue((self.folder / "residuals.png").stat().st_size > 1000)
        self.assertIn("up to date", self.succeeds("calibrate", "camera", "board.json", "-o", "camera.json", "--lens", "none").stderr)
        self.succeeds("calibrate", "camera", "board.json", "-o", "camera.yml", "--lens", "none")
        self.assertTrue((self.folder / "camera.yml").read_text().startswith("%YAML:1.0"))
        facts = json.loads(self.succeeds("info", "camera.json", "--json").stdout)
        self.assertEqual((facts["kind"], facts["calibrated"], facts["unit"]), ("calibration", "camera", "mm"))
        self.assertEqual(facts["camera"]["width"], 240)
        self.succeeds("validate", "camera.json")
        # The result is what `camera` of a description takes.
        highlights = self.description("spheres", unit="mm", camera="camera.json", spheres=[{"radius": 20, "circle": [120, 90, 20]}],
                                      lights=[{"highlights": [[124, 88]]}])
        scene.save(self.folder / "one.json", highlights)
        self.succeeds("calibrate", "spheres", "one.json", "-o", "lights.json")
        again = self.run_("calibrate", "camera", "board.json", "-o", "camera.json", "--lens", "k1")
        self.assertEqual(again.returncode, 1, again.stderr)

    def test_mistakes_are_one_line(self):
        views = self.views(0.0, 2, 0.5)
        board = {"chessboard": [9, 6], "spacing": 10}
        self.fails(1, "tilt the target", "camera", self.description("camera", unit="mm", target=board, views=views), "--lens", "none")
        self.fails(3, "shows no chessboard of 8 x 6", "camera", self.description("camera", unit="mm", target={"chessboard": [8, 6], "spacing": 10}, views=views))
        self.fails(3, "`unit` is missing", "camera", self.description("camera", target=board, views=views))
        self.fails(3, "/target/spacing", "camera", self.description("camera", unit="mm", target={"chessboard": [9, 6], "spacing": 0}, views=views))
        self.fails(3, "as the command says", "camera", self.description("spheres", unit="mm"))
        self.fails(3, "did you mean `views`", "camera", self.description("camera", unit="mm", target=board, veiws=views))
        scene.write_png(self.folder / "small.png", 100, 80, lambda x, y: 0.5)
        self.fails(3, "small.png", "camera", self.description("camera", unit="mm", target=board, views=[views[0], "small.png"]))
        few = {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "pixels": [[1, 1], [2, 2], [3, 3]]}
        self.fails(3, "at least 6", "camera", self.description("camera", unit="mm", width=640, height=480, scanner=few))


class Spheres(Calibrate):
    CAMERA = scene.Pinhole(240, 180, 300.0, DOWN, [0.0, 0.0, 400.0])
    BALLS = [([-90.0, 50.0, 30.0], 30.0), ([90.0, -40.0, 30.0], 30.0)]
    LIGHT = [120.0, 80.0, 330.0]

    def setUp(self):
        super().setUp()
        scene.write_png(self.folder / "lamp.png", 240, 180, scene.mirror_spheres(self.CAMERA, self.BALLS, self.LIGHT, 15.0))
        for i, ball in enumerate(self.BALLS):
            scene.write_png(self.folder / f"mask{i}.png", 240, 180, scene.sphere_mask(self.CAMERA, *ball))
        self.spheres = [{"radius": 30, "mask": "mask0.png", "name": "left"}, {"radius": 30, "mask": "mask1.png"}]

    def good(self, **more):
        content = self.description("spheres", unit="mm", camera=self.CAMERA.json(), response="linear", spheres=self.spheres, lights=["lamp.png"])
        content.update(more)
        return content

    def test_a_photograph_of_two_spheres_gives_a_lights_position_and_mistakes_are_one_line(self):
        scene.save(self.folder / "rig.json", self.good())
        said = self.succeeds("calibrate", "spheres", "rig.json", "-o", "lights.json", "--picture", "spheres.png")
        self.assertIn("lamp.png: at ", said.stderr)
        light = self.load("lights.json")["lights"][0]
        # Pixels of 1.3 mm, and masks cut at pixels.
        self.assertLess(math.dist(light["position"], self.LIGHT), 15.0)
        report = self.load("lights.json")["report"]["lights"][0]
        self.assertEqual(report["status"], "position")
        self.assertLess(math.dist(light["position"], self.LIGHT), 5 * report["position_sd_mm"])
        wrong = self.run_("calibrate", "spheres", "rig.json", "-o", "lights.lp")
        self.assertEqual(wrong.returncode, 2)
        self.mistakes()

    def mistakes(self):
        scene.write_png(self.folder / "black.png", 240, 180, lambda x, y: 0.0)
        scene.write_png(self.folder / "white.png", 240, 180, lambda x, y: 1.0)
        self.fails(3, "no highlight", "spheres", self.good(lights=["black.png"]))
        self.fails(3, "no highlight", "spheres", self.good(lights=["white.png"]))
        self.fails(3, "missing.png", "spheres", self.good(lights=["missing.png"]))
        self.fails(3, "out of the picture", "spheres", self.good(spheres=[{"radius": 30, "circle": [-80, 100, 60]}]))
        self.fails(3, "/spheres/0/radius", "spheres", self.good(spheres=[{"radius": -1, "circle": [80, 100, 60]}]))
        self.fails(3, "focal lengths", "spheres", self.good(camera={**self.CAMERA.json(), "matrix": [[0, 0, 1], [0, 0, 1], [0, 0, 1]]}))
        self.fails(3, "as the camera", "spheres", self.good(camera={**self.CAMERA.json(), "width": 500}))
        self.fails(3, "`outline`", "spheres", self.good(spheres=[{"radius": 30}]))


class OneSphere(Calibrate):
    def test_one_sphere_without_a_camera_gives_an_lp_file(self):
        scene.write_png(self.folder / "lamp.png", 400, 300, lambda x, y: 0.0)
        # A lamp far away, seen from far away: the highlight's normal halves the angle to the camera.
        direction = scene.unit([0.3, 0.4, 0.8])
        normal = scene.unit(scene.add(direction, [0, 0, 1]))
        radius, middle = 100.0, [200.0, 150.0]
        content = self.description("spheres", unit="mm", spheres=[{"radius": 10, "circle": [*middle, radius]}],
                                   lights=[{"photo": "lamp.png", "name": "a.png", "highlights": [[middle[0] + radius * normal[0], middle[1] - radius * normal[1]]]}])
        scene.save(self.folder / "rti.json", content)
        self.succeeds("calibrate", "spheres", "rti.json", "-o", "lights.lp")
        count, line = (self.folder / "lights.lp").read_text().splitlines()
        self.assertEqual((count, line.split()[0]), ("1", "a.png"))
        for found, true in zip(map(float, line.split()[1:]), direction):
            self.assertAlmostEqual(found, true, delta=1e-3)


class Lambertian(Calibrate):
    CAMERA = scene.Pinhole(96, 72, 240.0, DOWN, [0.0, 0.0, 500.0])
    LIGHTS = [[150.0, 60.0, 300.0], [-120.0, 130.0, 340.0]]

    def poses(self, normals, intensity=2e5):
        poses = []
        for i, normal in enumerate(normals):
            photos = []
            for k, light in enumerate(self.LIGHTS):
                photos.append(f"pose{i}_{k}.png")
                scene.write_png(self.folder / photos[-1], 96, 72, scene.lit_plane(self.CAMERA, [0, 0, 4.0 * i], normal, light, intensity))
            poses.append({"plane": {"point": [0, 0, 4.0 * i], "normal": normal, "side": 1000}, "photos": photos})
        return poses

    def description_(self, poses, **more):
        return self.description("lambertian", unit="mm", camera=self.CAMERA.json(), response="linear", lights=["left", "right"], poses=poses, **more)

    def test_a_plane_at_four_poses_gives_positions_and_strengths(self):
        scene.save(self.folder / "plane.json", self.description_(self.poses([[0, 0, 1], [0.4, 0, 1], [-0.3, 0.3, 1], [0, -0.4, 1]])))
        self.succeeds("calibrate", "lambertian", "plane.json", "-o", "lights.json", "--sample-step", "3")
        result = self.load("lights.json")
        for light, truth, name in zip(result["lights"], self.LIGHTS, ["left", "right"]):
            self.assertEqual(light["name"], name)
            self.assertLess(math.dist(light["position"], truth), 2.0)  # 8 bits
            self.assertAlmostEqual(light["intensity"][0] / 2e5, 1.0, delta=0.02)
        self.assertIn("camera", result)

    def test_what_is_left_open_or_wrong_is_one_line(self):
        poses = self.poses([[0, 0, 1]])
        self.fails(3, "black", "lambertian", self.description_(self.poses([[0, 0, 1]], intensity=1.0)))
        self.fails(3, "saturated", "lambertian", self.description_(self.poses([[0, 0, 1]], intensity=1e8)))
        self.poses([[0, 0, 1]])
        self.fails(3, "sees nothing", "lambertian", self.description_([{**poses[0], "plane": {"point": [0, 0, 900], "normal": [0, 0, 1], "side": 10}}]))
        self.fails(3, "/poses/0/photos", "lambertian", self.description_([{**poses[0], "photos": poses[0]["photos"][:1]}]))
        self.fails(3, "/poses/0/plane/normal", "lambertian", self.description_([{**poses[0], "plane": {"point": [0, 0, 0], "normal": [0, 0, 0], "side": 10}}]))


class ResponseAndThickness(Calibrate):
    def test_an_exposure_series_tells_srgb(self):
        srgb = lambda v: 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055
        photos = []
        for i, exposure in enumerate([0.25, 0.5, 1, 2, 4]):
            scene.write_png(self.folder / f"{i}.png", 120, 60, lambda x, y: srgb(min(1.0, exposure * 0.002 * 500 ** ((x + y / 60) / 120))))
            photos.append({"photo": f"{i}.png", "exposure": exposure})
        scene.save(self.folder / "series.json", self.description("response", photos=photos))
        self.succeeds("calibrate", "response", "series.json", "-o", "response.json")
        self.assertEqual(self.load("response.json")["response"], "srgb")
        self.fails(3, "all alike", "response", self.description("response", photos=[{**p, "exposure": 1} for p in photos]))

    def test_thickness_of_a_wedge_rises_where_less_light_comes_through(self):
        scene.write_png(self.folder / "blank.png", 80, 60, lambda x, y: 0.8)
        scene.write_png(self.folder / "photo.png", 80, 60, lambda x, y: 0.8 / (1 + x / 40))
        said = self.succeeds("thickness", "photo.png", "--blank", "blank.png", "--response", "linear", "--spatial-sigma", "5", "-o", "map.exr", "--json")
        low, high = json.loads(said.stdout)["range"]
        # 1 / T of the wedge runs from 1 to 1 + 79 / 40.
        self.assertAlmostEqual(low, 1.0, delta=0.15)
        self.assertAlmostEqual(high, 1 + 79 / 40, delta=0.3)
        again = self.run_("thickness", "photo.png", "--blank", "blank.png", "--response", "linear", "--spatial-sigma", "5", "-o", "map.exr")
        self.assertIn("up to date", again.stderr)
        other = self.run_("thickness", "photo.png", "-o", "map.exr")
        self.assertEqual(other.returncode, 1)
        self.assertEqual(self.run_("thickness", "photo.png", "-o", "map.png").returncode, 2)
        self.assertEqual(self.run_("thickness", "photo.png", "--response", "film", "-o", "b.exr").returncode, 2)
        scene.write_png(self.folder / "small.png", 8, 6, lambda x, y: 0.8)
        wrong = self.run_("thickness", "photo.png", "--blank", "small.png", "-o", "b.exr")
        self.assertEqual((wrong.returncode, len(wrong.stderr.strip().splitlines())), (3, 1))

    def test_a_layer_with_a_hole_says_so_and_what_fills_it(self):
        """A hole of 48 px where the window is 10: thickness warns of it and its JSON and the history that ingest makes have it; info tells what 0 and 1 are."""
        hole = lambda x, y: math.hypot(x - 80, y - 60) < 24
        scene.write_png(self.folder / "light.png", 200, 160, lambda x, y: 0.95 if hole(x, y) or x % 20 < 2 else 0.4 + 0.0001 * y)
        for frame in "ab":
            scene.write_png(self.folder / f"{frame}.png", 200, 160, lambda x, y: 0.5)
        options = ("--spatial-sigma", "10")
        said = self.succeeds("thickness", "light.png", "--response", "linear", *options, "-o", "map.exr", "--json")
        result = json.loads(said.stdout)
        self.assertGreater(result["two_modes_share"], 0)
        self.assertAlmostEqual(result["hole_share"], math.pi * 24 ** 2 / (200 * 160), delta=0.01)
        self.assertEqual([w["about"] for w in result["warnings"]], ["control"])
        self.assertIn("--spatial-sigma", result["warnings"][0]["cure"])
        self.assertIn(result["warnings"][0]["text"], said.stderr)
        facts = json.loads(self.succeeds("info", "map.exr", "--json").stdout)
        self.assertEqual((facts["range"], facts["unit"]), (result["range"], "relative"))
        self.assertIn("0 stands for", self.succeeds("info", "map.exr").stdout)
        scene.save(self.folder / "capture.json", {"format": "patinate.capture", "version": 1, "name": "layer", "kind": "fixed", "time_unit": "d", "response": "linear",
                                                  "frames": [{"time": 0, "photo": "a.png"}, {"time": 1, "photo": "b.png"}], "transmission": {"photo": "light.png"}})
        self.succeeds("ingest", "capture.json", "-o", "history", *options)
        history = self.load("history/history.json")
        self.assertIn(result["warnings"][0]["text"], [w["text"] for w in history["warnings"]])
        facts = json.loads(self.succeeds("info", "history/controls/thickness.exr", "--json").stdout)
        self.assertEqual(facts["range"], history["controls"][0]["range"])


if __name__ == "__main__":
    unittest.main()
