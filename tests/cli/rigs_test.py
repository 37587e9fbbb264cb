#!/usr/bin/env python3
"""Lamps that are named after photographs, and cameras that say their lens model. Usage: rigs_test.py PATINATE [unittest arguments]"""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from series_files import png

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())
SIZE, RADIUS = 20, 8
LAMPS = {f"img_{k + 1}.png": (math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t))
         for k, (t, p) in enumerate((0.3 + 0.04 * k, 2.4 * k) for k in range(11))}
FOCAL, DISTANCE = 60.0, 100.0


def sphere(lamp):
    """Gray codes of a sphere of albedo 0.8 under a lamp, in linear light."""
    def pixel(x, y):
        nx, ny = (x - (SIZE - 1) / 2) / RADIUS, -(y - (SIZE - 1) / 2) / RADIUS
        nz = math.sqrt(max(0.0, 1 - nx * nx - ny * ny))
        return [round(255 * 0.8 * max(0.0, nx * lamp[0] + ny * lamp[1] + nz * lamp[2]))]
    return pixel


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_patinate(self, *arguments):
        return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120)


class Photographs(Case):
    def setUp(self):
        super().setUp()
        for name, lamp in LAMPS.items():
            (self.folder / name).write_bytes(png(SIZE, SIZE, sphere(lamp), 1))
        inside = lambda x, y: [255 if math.hypot(x - (SIZE - 1) / 2, y - (SIZE - 1) / 2) < 0.9 * RADIUS else 0]
        (self.folder / "mask.png").write_bytes(png(SIZE, SIZE, inside, 1))


class Lamps(Photographs):
    def unlight(self, lines, photos=None):
        text = f"{len(lines)}\n" + "".join(f"{name} {' '.join(map(repr, LAMPS[lamp]))}\n".lstrip() for name, lamp in lines)
        (self.folder / "rig.lp").write_text(text)
        (self.folder / "step.json").write_text(json.dumps({"format": "patinate.unlight", "version": 1, "response": "linear", "lights": "rig.lp",
                                                           "photos": photos or {"pattern": "img_*.png"}, "mask": "mask.png"}))
        return self.run_patinate("unlight", "step.json", "--specular", "none", "-o", "unlit", "--force")

    def normals(self, lines, photos=None):
        run = self.unlight(lines, photos)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.stderr = run.stderr
        return (self.folder / "unlit/normal.exr").read_bytes()

    def test_lamps_go_with_the_photographs_that_they_name(self):
        in_order = self.normals([("", name) for name in LAMPS])
        shuffled = sorted(LAMPS)  # img_1, img_10, img_11, img_2, ...
        for form in ("{}", "photos/day 1/{}", "C:\\domes\\{}", '"{}"', "'C:\\my domes\\{}'"):
            self.assertEqual(self.normals([(form.format(name), name) for name in shuffled]), in_order, form)
        self.assertEqual(self.normals([(name.upper(), name) for name in shuffled]), in_order)
        self.assertEqual(self.normals([(name.replace(".png", ".CR2"), name) for name in shuffled]), in_order)
        self.assertEqual(self.normals([(name.replace(".png", ""), name) for name in shuffled]), in_order)
        self.assertNotIn("other names", self.stderr)

    def test_lamps_that_no_photograph_needs_are_left(self):
        used = list(LAMPS)[:8]
        self.assertEqual(self.normals([(name, name) for name in sorted(LAMPS)], used), self.normals([("", name) for name in used], used))

    def test_lamps_with_other_names_go_by_their_order_and_it_is_said(self):
        in_order = self.normals([("", name) for name in LAMPS])
        self.assertEqual(self.normals([(f"lamp{k}", name) for k, name in enumerate(LAMPS)]), in_order)
        self.assertIn("the lights have other names than the photographs, and go by their order: lamp0 with img_1.png", self.stderr)

    def test_names_that_fit_only_in_part_are_refused(self):
        names = sorted(LAMPS)
        for lines, about in (([(n if n != "img_5.png" else "img_55.png", n) for n in names], "none is named `img_5.png`"),
                             ([(n if n != "img_5.png" else "img_6.png", n) for n in names], "one light named `img_6.png`; there are 2")):
            run = self.unlight(lines)
            self.assertEqual(run.returncode, 3, run.stderr)
            self.assertIn(about, run.stderr)


YAML = """%YAML:1.0
---
image_width: 20
image_height: 20
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 60.0, 0.0, 9.5, 0.0, 60.0, 9.5, 0.0, 0.0, 1.0 ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 4
   dt: d
   data: [ 0.05, -0.02, 0.01, 0.003 ]
rotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0 ]
translation: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 0.0, 0.0, 100.0 ]
"""
# Number in binary models, name, and a camera's parameters.
COLMAP = {"PINHOLE": (1, [60, 61, 10, 10]), "OPENCV": (4, [60, 61, 10, 10, 0.05, -0.02, 0.01, 0.003]), "OPENCV_FISHEYE": (5, [60, 61, 10, 10, 0.05, -0.02, 0.01, 0.003]),
          "FOV": (7, [60, 61, 10, 10, 0.9]), "THIN_PRISM_FISHEYE": (10, [60, 61, 10, 10] + [0.01] * 8)}


class Cameras(Photographs):
    def look(self, camera, output="out"):
        lights = [{"name": name, "direction": lamp} for name, lamp in LAMPS.items()]
        (self.folder / "step.json").write_text(json.dumps({"format": "patinate.unlight", "version": 1, "response": "linear", "lights": lights, "unit": "mm", "camera": str(camera),
                                                           "photos": {"pattern": "img_*.png"}, "mask": "mask.png"}))
        return self.run_patinate("unlight", "step.json", "--specular", "none", "-o", output)

    def test_a_lens_model_that_is_not_read_is_refused_by_its_name(self):
        for line in ("distortion_model: equidistant", 'distortion_model: "fisheye"', "distortion_model: thin_prism_fisheye", "model_type: KANNALA_BRANDT", "camera_model: omni",
                     "camera_model: MEI", "lens_model: fov", "projection_model: stereographic"):
            (self.folder / "camera.yml").write_text(YAML + line + "\n")
            run = self.look("camera.yml")
            self.assertEqual(run.returncode, 3, line)
            name, model = line.replace('"', "").split(": ")
            self.assertIn(f"camera.yml: `{name}` says {model}, a lens model that is not read", run.stderr)
        for line, about in (("fisheye_model: 1", "`fisheye_model` says fisheye"), ("xi: 1.2", "`xi` says that the camera is omnidirectional")):
            (self.folder / "camera.yml").write_text(YAML + line + "\n")
            self.assertIn(about, self.look("camera.yml").stderr)
        xml = ("<?xml version=\"1.0\"?><opencv_storage><image_width>20</image_width><image_height>20</image_height><distortion_model>equidistant</distortion_model>"
               "<camera_matrix><rows>3</rows><cols>3</cols><data>60 0 15.5 0 60 11.5 0 0 1</data></camera_matrix></opencv_storage>")
        (self.folder / "camera.xml").write_text(xml)
        self.assertIn("says equidistant", self.look("camera.xml").stderr)
        (self.folder / "camera.json").write_text(json.dumps({"image_width": 20, "image_height": 20, "camera_matrix": [60, 0, 15.5, 0, 60, 11.5, 0, 0, 1], "distortion_model": "equidistant"}))
        self.assertIn("says equidistant", self.look("camera.json").stderr)

    def test_the_names_of_browns_model_are_read(self):
        for line in ("", "distortion_model: plumb_bob", "distortion_model: radtan", "camera_model: pinhole", "camera_model: EOS 5D", "fisheye_model: 0"):
            (self.folder / "camera.yml").write_text(YAML + line + "\n")
            run = self.look("camera.yml", f"out {line[-5:]}")
            self.assertEqual(run.returncode, 0, line + run.stderr)

    def colmap(self, model, is_binary):
        folder = self.folder / f"{model}_{'binary' if is_binary else 'text'}"
        folder.mkdir()
        number, values = COLMAP[model]
        pose = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 100.0)
        if not is_binary:
            (folder / "cameras.txt").write_text(f"# Cameras\n7 {model} 20 20 {' '.join(map(str, values))}\n")
            (folder / "images.txt").write_text(f"1 {' '.join(map(str, pose))} 7 view.png\n1.0 2.0 -1\n")
            return folder
        (folder / "cameras.bin").write_bytes(struct.pack("<QIiQQ", 2, 3, 0, 8, 8) + struct.pack("<3d", 1, 2, 3) + struct.pack("<IiQQ", 7, number, 20, 20) + struct.pack(f"<{len(values)}d", *values))
        (folder / "images.bin").write_bytes(struct.pack("<QI7dI", 1, 1, *pose, 7) + b"view.png\0" + struct.pack("<QddQ", 1, 1.0, 2.0, 2 ** 64 - 1))
        return folder

    def test_colmap_models_are_read_as_text_and_binary(self):
        for model in ("PINHOLE", "OPENCV"):
            made = []
            for is_binary in (False, True):
                output = self.folder / f"{model}{is_binary}"
                run = self.look(self.colmap(model, is_binary), output)
                self.assertEqual(run.returncode, 0, run.stderr)
                # What the result depends on: the camera by its numbers.
                made.append([e for e in json.loads((output / "job.json").read_text())["depends_on"] if "camera" in e["name"]])
            self.assertTrue(made[0])
            self.assertEqual(made[0], made[1])

    def test_colmap_lenses_that_are_not_read_are_refused_by_their_names(self):
        for model in ("OPENCV_FISHEYE", "FOV", "THIN_PRISM_FISHEYE"):
            for is_binary in (False, True):
                run = self.look(self.colmap(model, is_binary))
                self.assertEqual(run.returncode, 3, run.stderr)
                self.assertIn(f"the lens model `{model}` is not read", run.stderr)

    def test_damaged_binary_models_are_refused(self):
        whole = self.colmap("OPENCV", True)
        for name in ("cameras.bin", "images.bin"):
            data = (whole / name).read_bytes()
            for size in range(0, len(data), 31):
                (whole / name).write_bytes(data[:size])
                run = self.look(whole)
                self.assertEqual(run.returncode, 3, run.stderr)
                self.assertIn(f"{name}: ", run.stderr)
            (whole / name).write_bytes(data)


if __name__ == "__main__":
    unittest.main()
