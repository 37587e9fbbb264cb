#!/usr/bin/python3
"""Captures in Python: ingest, survey, thickness, registration, unlighting."""
import json

import numpy as np
import patinate

from python_case import PythonCase, main

import calibration_scene as scene  # Beside small_scene, which python_case brings.


class Capture(PythonCase):
    def test_ingest_makes_the_commands_bytes(self):
        history = patinate.ingest(self.work / "capture", self.work / "ingested", deflicker=True)
        self.run_patinate("ingest", "capture", "--deflicker", "-o", "by_command")
        self.assertGreater(len(history), 1)
        for path in sorted((self.work / "by_command").rglob("*")):
            relative = path.relative_to(self.work / "by_command")
            if path.is_file() and path.name not in ("run.json", "job.json"):
                self.assertEqual(path.read_bytes(), (self.work / "ingested" / relative).read_bytes(), relative)
        self.assertEqual(patinate.survey(self.work / "ingested")["is_deflickered"], True)
        self.line_of(patinate.CannotComplete, lambda: patinate.ingest(self.work / "capture", self.work / "ingested"))

    def test_options_of_a_fixed_camera_are_refused_for_scans_under_lamps(self):
        (self.work / "relit.json").write_text(json.dumps({"format": "patinate.capture", "version": 1, "name": "bump", "kind": "relit"}))
        for name, value in {"align": "auto", "align_to": "x.png", "deviations": True, "stabilize": True, "deflicker": True, "flat_field": "estimate",
                            "highlights": "keep"}.items():
            said = self.line_of(patinate.InvalidInput, lambda: patinate.ingest(self.work / "relit.json", self.work / "refused", **{name: value}))
            self.assertIn(f"{name}: is for captures of a fixed camera", said)
        # What stands there anyway changes nothing: then the capture itself is read.
        self.line_of(patinate.IoError, lambda: patinate.ingest(self.work / "relit.json", self.work / "refused", highlights="mask"))

    def test_thickness_is_the_commands(self):
        light = np.random.default_rng(3).uniform(0.3, 0.5, (40, 48)).astype(np.float32)
        patinate.write_color(self.work / "light.exr", np.repeat(light[..., None], 3, axis=2))
        self.run_patinate("thickness", "light.exr", "--spatial-sigma", "4", "-o", "thickness.exr")
        stored = patinate.read_color(self.work / "light.exr")[..., 0]
        made = patinate.thickness(stored, spatial_sigma=4)
        normalized = np.clip((made["values"].astype(np.float64) - made["low"]) / (made["high"] - made["low"]), 0, 1)
        np.testing.assert_allclose(normalized, patinate.read_channels(self.work / "thickness.exr", ["Y"]), atol=1e-4)  # The command takes the mean of three channels.

    def test_a_known_motion_is_found(self):
        rng = np.random.default_rng(4)
        x, y = rng.uniform(-30, 30, (2, 4000))
        z = 4 * np.sin(x / 7) * np.cos(y / 9) + 0.01 * x * y
        points = np.stack([x, y, z], axis=1)
        angle = 0.06
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        moved = points @ turn.T + [1.0, -0.5, 0.8]
        found = patinate.register(moved, points, initial=np.eye(4))
        self.assertEqual(found["status"], "converged")
        np.testing.assert_allclose(found["target_from_source"][:3, :3], turn, atol=2e-3)
        np.testing.assert_allclose(found["target_from_source"][:3, 3], [1.0, -0.5, 0.8], atol=0.1)

    def test_height_change_is_the_commands(self):
        rng = np.random.default_rng(1)
        for name, lost in (("before", 0.0), ("after", 0.05)):
            x, y = rng.uniform(-4, 4, (2, 3000))
            z = 0.3 * np.sin(1.1 * x + 0.5 * y) + 0.2 * np.cos(0.8 * y) - lost * np.exp(-((x - 1) ** 2 + y ** 2)) + 0.005 * rng.standard_normal(x.size)
            header = ["ply", "format ascii 1.0", f"element vertex {x.size}", "property double x", "property double y", "property double z", "end_header"]
            (self.work / f"{name}.ply").write_text("\n".join(header + ["%.9g %.9g %.9g" % p for p in zip(x, y, z)]) + "\n")
        self.run_patinate("register", "before.ply", "after.ply", "--unit", "mm", "-o", "plates")
        (self.work / "by_command_too").mkdir()
        self.run_patinate("height-change", "plates", "--times", "0,30", "--toward", "0,0,1", "-o", "by_command_too/relief")
        (self.work / "by_python_too").mkdir()
        history = patinate.relief(self.work / "plates", self.work / "by_python_too/relief", times=[0, 30], toward=[0, 0, 1])
        self.assertEqual(list(history.times), [0, 30])
        self.same_files("by_command_too", "by_python_too")
        self.assertIn("increase", self.line_of(patinate.InvalidInput, lambda: patinate.relief(self.work / "plates", self.work / "x", times=[3, 3])))
        self.assertIn("expected um", self.line_of(patinate.InvalidInput, lambda: patinate.relief(self.work / "plates", self.work / "x", unit="inch")))
        self.assertFalse((self.work / "x").exists())

    def calibrated(self, kind, rest, options, keywords, extensions=("json", "png")):
        """What the function finds, when the files of command and function are equal, from a file and from a dict."""
        description = {"format": "patinate.calibrate", "version": 1, "kind": kind, **rest}
        (self.work / f"{kind}.json").write_text(json.dumps(description))
        picture = "png" in extensions
        self.run_patinate("calibrate", kind, f"{kind}.json", *options, "-o", f"{kind}_by_command.json", *(["--picture", f"{kind}_by_command.png"] if picture else []))
        calibrate = getattr(patinate, f"calibrate_{kind}")
        files = {"picture": self.work / f"{kind}_by_python.png"} if picture else {}
        made = calibrate(self.work / f"{kind}.json", output=self.work / f"{kind}_by_python.json", **files, **keywords)
        for extension in extensions:
            self.assertEqual((self.work / f"{kind}_by_command.{extension}").read_bytes(), (self.work / f"{kind}_by_python.{extension}").read_bytes())
        self.assertEqual(made, self.json_of(f"{kind}_by_command.json"))
        self.assertEqual(calibrate(description, folder=self.work, **keywords), made)
        return description, made

    def test_calibrations_of_camera_and_spheres_are_the_commands(self):
        camera = scene.Pinhole(240, 180, 300.0, scene.rotation([1, 0, 0], np.pi), [0.0, 0.0, 400.0])
        balls = [([-90.0, 50.0, 30.0], 30.0), ([90.0, -40.0, 30.0], 30.0)]
        scene.write_png(self.work / "lamp.png", 240, 180, scene.mirror_spheres(camera, balls, [120.0, 80.0, 330.0], 15.0))
        for i, ball in enumerate(balls):
            scene.write_png(self.work / f"ball{i}.png", 240, 180, scene.sphere_mask(camera, *ball))
        spheres, lights = self.calibrated("spheres", {"unit": "mm", "camera": camera.json(), "response": "linear", "spheres": [{"radius": 30, "mask": f"ball{i}.png"} for i in range(2)],
                                                      "lights": ["lamp.png"]}, ["--outline-sigma", "0.5"], {"outline_sigma": 0.5})
        self.assertLess(np.linalg.norm(np.subtract(lights["lights"][0]["position"], [120.0, 80.0, 330.0])), 15.0)  # Pixels of 1.3 mm.
        points = [[x, y, (x * y) % 31] for x in (-60, -20, 30, 70) for y in (-50, 10, 45)]
        board, _ = self.calibrated("camera", {"unit": "mm", "width": 240, "height": 180, "scanner": {"points": points, "pixels": [camera.pixel(p) for p in points]}}, ["--lens", "none"], {"lens": "none"})
        self.assertIn("as the command says", self.line_of(patinate.IoError, lambda: patinate.calibrate_lambertian(spheres, folder=self.work)))
        self.line_of(patinate.IoError, lambda: patinate.calibrate_response(self.work / "spheres.json"))
        self.line_of(patinate.InvalidInput, lambda: patinate.calibrate_spheres(spheres, folder=self.work, output=self.work / "x.lp"))
        self.line_of(patinate.InvalidInput, lambda: patinate.calibrate_camera(board, output=self.work / "x.docx"))
        self.assertIn("outline_sigma", self.line_of(TypeError, lambda: patinate.calibrate_spheres(spheres, folder=self.work, outline_sigmas=1)))
        self.line_of(patinate.CannotComplete, lambda: patinate.calibrate_camera(board, lens="k1", output=self.work / "camera_by_python.json"))
        self.assertFalse(list(self.work.glob("x.*")))

    def test_calibrations_of_a_plane_and_of_a_response_are_the_commands(self):
        camera = scene.Pinhole(96, 72, 240.0, scene.rotation([1, 0, 0], np.pi), [0.0, 0.0, 500.0])
        lamp, poses = [150.0, 60.0, 300.0], []
        for i, normal in enumerate(([0, 0, 1], [0.4, 0, 1], [-0.3, 0.3, 1], [0, -0.4, 1])):
            scene.write_png(self.work / f"pose{i}.png", 96, 72, scene.lit_plane(camera, [0, 0, 4.0 * i], normal, lamp, 2e5))
            poses.append({"plane": {"point": [0, 0, 4.0 * i], "normal": normal, "side": 1000}, "photos": [f"pose{i}.png"]})
        _, lights = self.calibrated("lambertian", {"unit": "mm", "camera": camera.json(), "response": "linear", "lights": ["left"], "poses": poses}, ["--sample-step", "3"], {"sample_step": 3}, ("json",))
        self.assertLess(np.linalg.norm(np.subtract(lights["lights"][0]["position"], lamp)), 2.0)  # Codes of 8 bits.
        series = []
        for i, exposure in enumerate((0.25, 0.5, 1, 2, 4)):
            scene.write_png(self.work / f"exposure{i}.png", 120, 60, lambda x, y: min(1.0, exposure * 0.002 * 500 ** ((x + y / 60) / 120)) ** (1 / 1.8))
            series.append({"photo": f"exposure{i}.png", "exposure": exposure})
        self.calibrated("response", {"photos": series}, [], {}, ("json",))

    def test_albedo_of_a_lambertian_scene_comes_back(self):
        rng = np.random.default_rng(5)
        albedo = rng.uniform(0.2, 0.8, (16, 16, 3)).astype(np.float32)
        normal = np.broadcast_to(np.float32([0, 0, 1]), (16, 16, 3))
        directions = [[0.3, 0, 1], [-0.3, 0.1, 1], [0, -0.4, 1], [0.2, 0.3, 1], [-0.2, -0.2, 1]]
        photos = [albedo / np.float32(np.pi) * np.float32(2.0 * d[2] / np.linalg.norm(d)) for d in directions]
        made = patinate.unlight(photos, [{"direction": d, "intensity": 2.0} for d in directions], normal=normal, normals="keep", specular="none")
        np.testing.assert_allclose(made["albedo"], albedo, rtol=1e-4)  # Rounding of floats.
        self.assertTrue((made["mask"] == 255).all())
        self.line_of(TypeError, lambda: patinate.unlight(photos, [{"direction": d} for d in directions], normal=normal, blockers=7))
        self.assertIn("lights[0]", self.line_of(patinate.InvalidInput, lambda: patinate.unlight(photos, [{"intensity": 1}] * 5)))


if __name__ == "__main__":
    main()
