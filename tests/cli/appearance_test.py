#!/usr/bin/env python3
"""`patinate history appearance`, and `appearance` in a capture project, through lookup, render and models. Usage: appearance_test.py PATINATE [unittest arguments]"""
import json
import struct
import sys
import unittest

from command_case import INPUT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
MATERIALS = {"materials": [{"color": "#f0e8d8", "metalness": 0, "roughness": 0.9}, {"color": "#302010", "metalness": 1, "roughness": 0.25, "tint": "#f0ae8c"}]}


def setUpModule():
    use(PATINATE)


def glb_document(path):
    data = path.read_bytes()
    return json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])


class Appearance(CommandCase):
    def setUp(self):
        super().setUp()
        (self.folder / "history").symlink_to(self.shared / "history")

    def manifest(self, name):
        return json.loads((self.folder / name / "history.json").read_text())

    def write(self, name, members):
        (self.folder / name).write_text(json.dumps({"format": "patinate.appearance", "version": 1, **members}))

    def test_stated_in_the_project_or_afterwards_is_the_same_maps(self):
        self.write("stated.json", MATERIALS)
        self.succeeds("history", "material", "history", "stated.json", "-o", "after")
        project = json.loads((self.shared / "capture/capture.json").read_text())
        (self.folder / "capture").mkdir()
        for item in (self.shared / "capture").iterdir():
            if item.name != "capture.json":
                (self.folder / "capture" / item.name).symlink_to(item)
        (self.folder / "capture/capture.json").write_text(json.dumps({**project, "appearance": MATERIALS}))
        self.succeeds("ingest", "capture", "-o", "before")
        before, after, plain = self.manifest("before"), self.manifest("after"), self.manifest("history")
        for number, frame in enumerate(before["frames"]):
            self.assertEqual(set(frame) - set(plain["frames"][number]), {"specular", "metalness", "tint"})
            for name in ("specular", "metalness", "tint"):
                self.assertEqual((self.folder / "before" / frame[name]).read_bytes(), (self.folder / "after" / after["frames"][number][name]).read_bytes())
        self.succeeds("validate", "before")
        self.assertIn("up to date", self.run_patinate("ingest", "capture", "-o", "before").stderr)
        self.assertIn("up to date", self.run_patinate("history", "material", "history", "stated.json", "-o", "after").stderr)

    def test_metal_reaches_textures_pictures_and_models(self):
        self.write("stated.json", {"metalness": {"control": "thickness", "values": [[0, 1]]}, "roughness": [[0, 0.25], [1e6, 0.5]], "specular": 0.16})
        self.succeeds("history", "material", "history", "stated.json", "-o", "metal")
        self.succeeds("transfer", "metal", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "aged")
        for name in ("metalness", "roughness", "orm", "base"):
            self.succeeds("texture", "aged", "--time", "0", "--map", name, "-o", f"{name}.png")
        self.fails(INPUT, "no `tint`", "texture", "aged", "--time", "0", "--map", "tint", "-o", "tint.png")
        self.succeeds("render", "aged", "--time", "0", "--width", "48", "--height", "48", "-o", "all.png")
        self.succeeds("render", "aged", "--time", "0", "--width", "48", "--height", "48", "--maps", "color", "-o", "color.png")
        self.assertNotEqual((self.folder / "all.png").read_bytes(), (self.folder / "color.png").read_bytes())
        self.succeeds("export", "aged", "--num-times", "2", "-o", "aged.glb")
        model = glb_document(self.folder / "aged.glb")
        for material in model["materials"]:
            self.assertEqual(material["pbrMetallicRoughness"]["metallicFactor"], 1)
            # Half floats keep 0.16 to a part in 2000.
            self.assertAlmostEqual(material["extensions"]["KHR_materials_ior"]["ior"], 1.4 / 0.6, delta=2e-3)
        self.assertIn("KHR_materials_ior", model["extensionsUsed"])
        self.succeeds("export", "aged", "--time", "0", "-o", "aged.obj")
        mtl = (self.folder / "aged.mtl").read_text()
        self.assertIn("map_Pm", mtl)
        self.assertIn("\nNi 2.33", mtl)
        self.assertIn('name="specular_IOR"', (self.folder / "aged.obj.mtlx").read_text())
        self.succeeds("export", "aged", "--times", "0,1", "-o", "aged.usda")
        self.assertIn("inputs:metallic.connect", (self.folder / "aged.usda").read_text())

    def test_a_simulation_of_copper_leaves_as_metal(self):
        self.succeeds("synth", "ledge", "--cells", "4", "-o", "ledge")
        scene = json.loads((self.folder / "ledge/scene.json").read_text())
        for thing in scene["objects"]:
            thing["preset"] = "copper"
        (self.folder / "ledge/scene.json").write_text(json.dumps(scene))
        self.succeeds("simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "20", "--history-every", "10", "-o", "rain")
        frames = self.manifest("rain/history")["frames"]
        self.assertTrue(all("metalness" in frame for frame in frames))
        self.succeeds("validate", "rain/history")
        self.succeeds("export", "rain", "--num-times", "2", "-o", "rain.glb")
        for material in glb_document(self.folder / "rain.glb")["materials"]:
            self.assertEqual(material["pbrMetallicRoughness"]["metallicFactor"], 1)
            self.assertNotIn("extensions", material)  # 0.04 is what viewers assume.

    def test_one_number_for_all_is_one_map(self):
        self.succeeds("history", "material", "history", "--metalness", "1", "--roughness", "0.3", "-o", "metal")
        made = self.manifest("metal")
        self.assertEqual(set(made["maps"]), {"specular", "metalness"})
        self.assertNotIn("metalness", made["frames"][0])
        info = json.loads(self.succeeds("info", "metal", "--json"))
        self.assertEqual(info["constant_maps"], "specular, metalness")
        self.succeeds("history", "combine", "metal", "history", "-o", "library")
        self.assertIn("metalness", self.manifest("library")["frames"][0])
        self.succeeds("history", "trim", "metal", "--every", "2", "-o", "short")
        self.assertEqual(set(self.manifest("short")["maps"]), {"specular", "metalness"})

    def test_bad_input_is_one_line(self):
        self.write("wrong.json", {"metalness": 1.5})
        self.fails(INPUT, "found 1.5", "history", "material", "history", "wrong.json", "-o", "out")
        self.write("control.json", {"metalness": {"control": "thicknes", "values": [[0, 1]]}})
        self.fails(INPUT, "thickness", "history", "material", "history", "control.json", "-o", "out")
        self.fails(USAGE, "expected a file", "history", "material", "history", "-o", "out")
        self.fails(USAGE, "metalness", "history", "material", "history", "--metalness", "2", "-o", "out")
        self.fails(INPUT, "urn", "history", "material", self.shared / "urn", "--metalness", "1", "-o", "out")
        self.succeeds("history", "material", "history", "--metalness", "1", "-o", "metal")
        self.fails(INPUT, "has `metalness` already", "history", "material", "metal", "--metalness", "1", "-o", "out")


if __name__ == "__main__":
    unittest.main()
