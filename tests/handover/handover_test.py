#!/usr/bin/env python3
"""USD and MaterialX that export writes, opened by readers of others: tinyusdz, three.js and MaterialX's own (read.mjs). Usage: handover_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
from command_case import CommandCase, use  # noqa: E402

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
# A history with everything that a material may say.
STATED = {"format": "patinate.appearance", "version": 1,
          "materials": [{"color": "#f0e8d8", "metalness": 0, "roughness": 0.9}, {"color": "#302010", "metalness": 1, "roughness": 0.25, "tint": "#f0ae8c"}]}


def setUpModule():
    use(PATINATE)


class Handover(CommandCase):
    def read(self, *files):
        said = subprocess.run(["node", HERE / "read.mjs", *files], cwd=self.folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(said.returncode, 0, said.stderr[-2000:])
        return [json.loads(line) for line in said.stdout.splitlines()]

    def stated(self):
        """A transfer whose material has maps: its folder."""
        (self.folder / "stated.json").write_text(json.dumps(STATED))
        self.succeeds("history", "material", self.shared / "history", "stated.json", "-o", "stated")
        self.succeeds("transfer", "stated", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "metal")
        return self.folder / "metal"

    def num_corners(self, transfer):
        faces = [line.split()[1:] for line in (transfer / "mesh.obj").read_text().splitlines() if line.startswith("f ")]
        return sum(map(len, faces))

    def test_a_stage_and_a_package_are_read_with_mesh_and_textures(self):
        for transfer in (self.shared / "aged", self.stated()):
            for name in ("urn.usda", "urn.usdz"):
                self.succeeds("export", transfer, "--num-times", "3", "-o", name, "--force")
            loose, packed = self.read("urn.usda", "urn.usdz")
            for found in (loose, packed):
                self.assertNotIn("error", found)
                self.assertEqual(sum(mesh["corners"] for mesh in found["meshes"]), self.num_corners(transfer))
                for mesh in found["meshes"]:
                    self.assertIn(mesh["uvs"], (mesh["points"], mesh["corners"]))
                    self.assertIn("diffuseColor", mesh["images"])
            self.assertTrue(loose["three"])
            for texture in loose["three"]:
                self.assertTrue((self.folder / texture).is_file(), texture)
            # A package's textures are decoded from it.
            for mesh in packed["meshes"]:
                for image in mesh["images"].values():
                    self.assertEqual((image["width"], image["height"]), (64, 64))
        self.assertIn("roughness", packed["meshes"][0]["images"])
        self.assertIn("metallic", packed["meshes"][0]["images"])

    def test_materialx_is_valid_and_becomes_a_shader(self):
        for transfer in (self.shared / "aged", self.stated()):
            self.succeeds("export", transfer, "--num-times", "3", "-o", "urn.usda", "--force")
            self.succeeds("export", transfer, "-o", "urn.obj", "--force")
            for found, num_times in zip(self.read("urn.mtlx", "urn.obj.mtlx"), (3, 1)):
                self.assertTrue(found["valid"])
                self.assertNotIn("error", found)
                self.assertEqual(len(found["materials"]), num_times)
                self.assertGreater(found["shader"], 1000)

    def test_what_is_wrong_is_seen(self):
        self.succeeds("export", self.shared / "aged", "-o", "urn.usda")
        text = (self.folder / "urn.mtlx").read_text()
        (self.folder / "wrong.mtlx").write_text(text.replace('name="base_color" type="color3"', 'name="base_color" type="surfaceshader"'))
        (self.folder / "wrong.usda").write_text((self.folder / "urn.usda").read_text().replace("int[] faceVertexIndices", "int[ faceVertexIndices"))
        material, stage = self.read("wrong.mtlx", "wrong.usda")
        self.assertFalse(material["valid"])
        self.assertTrue(stage["error"])


if __name__ == "__main__":
    unittest.main()
