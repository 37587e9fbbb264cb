#!/usr/bin/env python3
"""Lifted flakes in pictures and models. Usage: flakes_test.py PATINATE [unittest arguments]"""
import json
import math
import struct
import sys
import unittest

from command_case import CommandCase, use
from small_scene import PLATE, PLATE_SCENE

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"

# Paint of 0.4 mm that holds on the upper half of the plate alone. Its stress rises evenly, and with it the strain: R = 0.4 mm / (0.1 x 1) at the end.
LAYERS = [{"name": "iron", "composition": {"metal": 1}, "color": [0.4, 0.4, 0.4]},
          {"name": "paint", "thickness_um": 400, "adhesion": "smoothstep(0.49, 0.51, up)", "color": [0.5, 0.05, 0.04], "cracks": {"strength": 3, "shrinkage": 0.1}}]
SCENE = {**PLATE_SCENE, "maps": {"up": {"kind": "height"}}, "rules": [{"name": "drying", "layer": "paint", "driver": "1", "rate": 1, "products": {"stress": 1}}],
         "objects": [{"name": "plate", "mesh": "plate.obj", "layers": LAYERS}], "time": {"unit": "h", "per_iteration": 0.02}, "run": {"iterations": 50, "history_every": 25}}


def setUpModule():
    use(PATINATE)


def gltf_of(path):
    data = path.read_bytes()
    return json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])


def pixels_of(path):
    """The compressed rows of a PNG, without what it says of itself."""
    data, at, rows = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        rows += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return rows


def num_triangles(gltf, material):
    """Of primitives that show a material in some variant."""
    numbers = [i for i, m in enumerate(gltf["materials"]) if m["name"] == material]
    count = 0
    for mesh in gltf["meshes"]:
        for primitive in mesh["primitives"]:
            shown = [m["material"] for m in primitive["extensions"]["KHR_materials_variants"]["mappings"]]
            count += gltf["accessors"][primitive["indices"]]["count"] // 3 if set(shown) & set(numbers) else 0
    return count


class Flakes(CommandCase):
    def setUp(self):
        super().setUp()
        self.write("plate.obj", PLATE)
        self.write("scene.json", json.dumps(SCENE))
        self.succeeds("simulate", "scene.json", "-o", "peeling")

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def export(self, name, *options):
        self.succeeds("export", "peeling", "-o", name, *options)
        return self.folder / name

    def test_a_glb_shows_them_in_the_variant_of_their_time_alone(self):
        gltf = gltf_of(self.export("model.glb", "--times", "0,0.5,1"))
        names = [m["name"] for m in gltf["materials"]]
        # At the start there is no strain, so that nothing is bent: the flake lies flat.
        tops = [n for n in names if n.startswith("flakes")]
        self.assertEqual(tops, ["flakes 0 h", "flakes 0.5 h", "flakes 1 h"])
        self.assertEqual(sum(n == "unseen" for n in names), 3 * 2 * 2)
        for name in tops:
            self.assertGreater(num_triangles(gltf, name), 500)  # 32 x 16 texels, less what is beside what holds.
        unseen = gltf["materials"][names.index("unseen")]
        self.assertEqual((unseen["alphaMode"], unseen["pbrMetallicRoughness"]["baseColorFactor"][3]), ("MASK", 0))

    def test_models_load_again_with_their_shells(self):
        surface = self.export("flat.obj", "--no-flakes")
        curled = self.export("curled.obj")
        texts = [path.read_text() for path in (surface, curled)]
        self.assertNotIn("flakes", texts[0])
        self.assertIn("usemtl material_flakes", texts[1])
        self.assertIn("usemtl material_undersides", texts[1])
        # Off the plane of the plate.
        along = math.hypot(50, 86)
        heights = [[(86 * float(z) + 50 * float(y)) / along for _, x, y, z in (line.split() for line in text.splitlines() if line.startswith("v "))] for text in texts]
        self.assertLess(max(map(abs, heights[0])), 1e-3)
        # An arc of 1 radian and R = 4 mm, then straight on over the rest of half of the plate, whose texels are 3.1 mm.
        radius, length = 4.0, along / 2
        rise = radius * (1 - math.cos(1)) + (length - radius) * math.sin(1)
        self.assertAlmostEqual(max(heights[1]), rise, delta=along / 32)
        for name in ("curled.obj", "curled.glb"):
            if name.endswith("glb"):
                self.export(name, "--time", "1")
            info = self.succeeds("info", name, "--json")
            self.assertGreater(json.loads(info)["triangles"], 2000)

    def test_a_stage_shows_them_at_their_time_alone(self):
        text = self.export("stage.usda", "--times", "0.5,1").read_text()
        self.assertIn('def Mesh "flakes_1_h"', text)
        self.assertIn('visibility.timeSamples = { 0.5: "invisible", 1: "inherited" }', text)
        self.assertIn('visibility.timeSamples = { 0.5: "inherited", 1: "invisible" }', text)
        for line in text.splitlines():
            if "inputs:file =" in line:
                self.assertTrue((self.folder / line.split("@")[1]).is_file(), line)
        self.export("stage.usdz", "--times", "0.5,1")

    def test_equal_runs_give_equal_bytes_on_any_number_of_threads(self):
        one, two = (self.export(name, "--threads", threads).read_bytes().replace(b"two", b"one") for name, threads in (("one.glb", "1"), ("two.glb", "3")))
        self.assertEqual(one, two)

    def test_a_picture_shows_them_unless_it_is_told_not_to(self):
        for name, options in (("curled.png", []), ("flat.png", ["--no-flakes"]), ("smooth.png", ["--relief", "0"])):
            self.succeeds("render", "peeling", "-o", name, "--width", "96", "--height", "96", *options)
        pictures = {(self.folder / name).read_bytes() for name in ("curled.png", "flat.png", "smooth.png")}
        self.assertEqual(len(pictures), 3)

    def test_nothing_lifted_gives_the_same_bytes_with_and_without(self):
        layers = [LAYERS[0], {**LAYERS[1], "adhesion": 1}]
        self.write("held.json", json.dumps({**SCENE, "objects": [{**SCENE["objects"][0], "layers": layers}]}))
        self.succeeds("simulate", "held.json", "-o", "held")
        for name, options in (("with.png", []), ("without.png", ["--no-flakes"])):
            self.succeeds("render", "held", "-o", name, "--width", "64", "--height", "64", *options)
        self.assertEqual(*(pixels_of(self.folder / name) for name in ("with.png", "without.png")))
        for name, options in (("with.glb", []), ("without.glb", ["--no-flakes"])):
            self.succeeds("export", "held", "-o", name, *options)
        one, other = (gltf_of(self.folder / name) for name in ("with.glb", "without.glb"))
        for gltf in (one, other):
            del gltf["asset"], gltf["nodes"], gltf["meshes"][0]["name"]
        self.assertEqual(one, other)


if __name__ == "__main__":
    unittest.main()
