#!/usr/bin/env python3
"""OBJ with MTL, and MaterialX beside it and beside USD, against the rules of the formats. Usage: obj_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import re
import sys
import unittest
import xml.etree.ElementTree as ElementTree

from command_case import CANNOT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"

# Of the nodes that are used, their inputs and types, and what they give [MaterialX Specification v1.38: Standard Nodes, Physically Based Shading Nodes; libraries/bxdf/standard_surface.mtlx].
NODES = {
    "image": ({"file": {"filename"}, "uaddressmode": {"string"}, "vaddressmode": {"string"}}, {"float", "color3", "vector3"}),
    "normalmap": ({"in": {"vector3"}}, {"vector3"}),
    "standard_surface": ({"base_color": {"color3"}, "specular_roughness": {"float"}, "metalness": {"float"}, "normal": {"vector3"}}, {"surfaceshader"}),
    "displacement": ({"displacement": {"float"}, "scale": {"float"}}, {"displacementshader"}),
    "surfacematerial": ({"surfaceshader": {"surfaceshader"}, "displacementshader": {"displacementshader"}}, {"material"}),
}


def setUpModule():
    use(PATINATE)


def check_materialx(case, path):
    """What a reader relies on. @returns the names of the looks."""
    root = ElementTree.parse(path).getroot()
    case.assertEqual((root.tag, root.attrib["version"], root.attrib["colorspace"]), ("materialx", "1.38", "lin_rec709"))
    graphs = {g.attrib["name"]: g for g in root.iter("nodegraph")}

    def check_scope(scope):
        names = [child.attrib["name"] for child in scope]
        case.assertEqual(len(names), len(set(names)), "names are unique in their scope")
        types = {child.attrib["name"]: child.attrib.get("type") for child in scope}
        for child in scope:
            case.assertRegex(child.attrib["name"], r"^[A-Za-z_][A-Za-z0-9_]*$")
            if child.tag == "output":
                case.assertEqual(child.attrib["type"], types[child.attrib["nodename"]])
            if child.tag not in NODES:
                case.assertIn(child.tag, ("nodegraph", "output", "look"))
                continue
            inputs, gives = NODES[child.tag]
            case.assertIn(child.attrib["type"], gives)
            for entry in child:
                case.assertEqual(entry.tag, "input")
                name, kind = entry.attrib["name"], entry.attrib["type"]
                case.assertIn(kind, inputs[name])
                how = [k for k in ("value", "nodename", "nodegraph") if k in entry.attrib]
                case.assertEqual(len(how), 1)
                if how == ["nodename"]:
                    case.assertEqual(types[entry.attrib["nodename"]], kind)
                if how == ["nodegraph"]:
                    outputs = {o.attrib["name"]: o.attrib["type"] for o in graphs[entry.attrib["nodegraph"]].iter("output")}
                    case.assertEqual(outputs[entry.attrib["output"]], kind)
                if kind == "filename":
                    case.assertTrue((path.parent / entry.attrib["value"]).is_file(), entry.attrib["value"])
                    case.assertEqual(entry.attrib.get("colorspace"), "srgb_texture" if child.attrib["type"] == "color3" else None)

    check_scope(root)
    for graph in graphs.values():
        check_scope(graph)
    materials = {m.attrib["name"] for m in root.iter("surfacematerial")}
    assigned = [a.attrib["material"] for a in root.iter("materialassign")]
    case.assertEqual(sorted(assigned), sorted(materials))  # Each is shown by one look.
    return [look.attrib["uiname"] for look in root.iter("look")]


def statements(path):
    """Words of every line that is no comment."""
    return [line.split() for line in path.read_text().splitlines() if line and not line.startswith("#")]


class Obj(CommandCase):
    def check_obj(self, path):
        """@returns (objects, materials in use), and what materials say."""
        lines = statements(path)
        self.assertEqual([l[1] for l in lines if l[0] == "mtllib"], [path.stem + ".mtl"])
        counts = {kind: sum(l[0] == kind for l in lines) for kind in ("v", "vt", "vn")}
        for line in lines:
            if line[0] == "f":
                self.assertEqual(len(line), 4)
                for corner in line[1:]:
                    v, t, n = map(int, corner.split("/"))
                    self.assertTrue(1 <= v <= counts["v"] and 1 <= t <= counts["vt"] and 1 <= n <= counts["vn"])
        materials = {}
        for words in statements(path.with_suffix(".mtl")):
            if words[0] == "newmtl":
                self.assertNotIn(words[1], materials)
                materials[words[1]] = {}
                said = materials[words[1]]
            else:
                said[words[0]] = words[1:]
        used = [l[1] for l in lines if l[0] == "usemtl"]
        self.assertEqual(set(used), set(materials))
        for said in materials.values():
            for key in ("map_Kd", "map_Pr", "map_Pm", "norm", "disp"):
                if key in said:
                    self.assertTrue((path.parent / said[key][0]).is_file(), said[key])
        return [l[1] for l in lines if l[0] == "o"], used, materials

    def test_an_obj_shows_the_mesh_and_its_texture_at_one_time(self):
        self.succeeds("export", self.shared / "aged", "--time", "7.5", "-o", "urn.obj")
        objects, used, materials = self.check_obj(self.folder / "urn.obj")
        self.assertEqual((objects, used), (["urn"], ["material"]))
        self.assertIn("Pr", materials["material"])  # The history knows color alone.
        self.assertEqual(check_materialx(self, self.folder / "urn.obj.mtlx"), ["7.5 s"])
        self.succeeds("texture", self.shared / "aged", "--time", "7.5", "-o", "then.png")
        # Pixels of a PNG whose writer filters equal rows equally.
        packed = [b"".join(re.findall(rb"IDAT(.*?)....IEND", (self.folder / name).read_bytes(), re.DOTALL)) for name in ("then.png", "urn.obj.textures/color.0000.png")]
        self.assertEqual(*packed)
        # What is read is the mesh that was aged.
        self.assertEqual(json.loads(self.succeeds("info", "urn.obj", "--json"))["triangles"], json.loads(self.succeeds("info", self.shared / "aged/mesh.obj", "--json"))["triangles"])

    def test_the_last_time_is_shown_when_none_is_given_and_several_are_refused(self):
        self.succeeds("export", self.shared / "aged", "-o", "urn.obj")
        self.assertEqual(check_materialx(self, self.folder / "urn.obj.mtlx"), ["22.5 s"])
        self.fails(USAGE, "one time", "export", self.shared / "aged", "--num-times", "2", "-o", "other.obj")

    def test_a_mesh_whose_z_points_up_stands_in_every_model(self):
        # A block of 1 x 2 x 3 m whose longest side points up, as scans are; glTF and USD want y there. Its volume, by the divergence theorem, says that no side was turned inside out.
        corners = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]
        sides = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
        sides = [tuple(reversed(s)) if self.volume(corners, sides) < 0 else s for s in sides]
        (self.folder / "block.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in sides))
        self.succeeds("transfer", self.shared / "history", "block.obj", "--unit", "m", "--control", "facing", "--direction", "0,0,1", "--up", "0,0,1", "--resolution", "64", "-o", "aged")
        for name in ("block_up.obj", "block_up.glb", "block_up.usda"):
            self.succeeds("export", "aged", "--time", "7.5", "--up", "z", "-o", name)
        for name in ("block_up.obj", "block_up.glb"):
            facts = json.loads(self.succeeds("info", name, "--json"))
            self.assertEqual([round(side, 5) for side in facts["extent"]], [1, 3, 2], name)
        lines = statements(self.folder / "block_up.obj")
        positions = [tuple(map(float, l[1:])) for l in lines if l[0] == "v"]
        self.assertAlmostEqual(self.volume(positions, [[int(c.split("/")[0]) for c in l[1:]] for l in lines if l[0] == "f"]), 6, 4)
        normals = [tuple(map(float, l[1:])) for l in lines if l[0] == "vn"]
        for line in lines:
            if line[0] == "f":  # Normals of a block are those of its sides.
                for corner in line[1:]:
                    v, _, n = map(int, corner.split("/"))
                    axis = max(range(3), key=lambda a: abs(normals[n - 1][a]))
                    self.assertEqual(normals[n - 1][axis] > 0, positions[v - 1][axis] > sum(p[axis] for p in positions) / len(positions))
        stage = (self.folder / "block_up.usda").read_text()
        self.assertIn('upAxis = "Y"', stage)
        unit = float(re.search(r"metersPerUnit = (\S+)", stage)[1])
        points = re.search(r"point3f\[\] points = \[(.*?)\]", stage, re.DOTALL)[1]
        numbers = [tuple(map(float, triple.split(","))) for triple in re.findall(r"\(([^)]*)\)", points)]
        self.assertEqual([round(unit * (max(c) - min(c)), 5) for c in zip(*numbers)], [1, 3, 2])
        self.fails(CANNOT, "--force", "export", "aged", "--time", "7.5", "-o", "block_up.glb")  # Another model.
        for name in ("pictures", "aged.mp4"):
            self.fails(USAGE, "--up: is of models", "export", "aged", "--up", "z", "-o", name)

    @staticmethod
    def volume(positions, faces):
        six = 0
        for face in faces:
            (ax, ay, az) = positions[face[0] - 1]
            for k in range(1, len(face) - 1):
                (bx, by, bz), (cx, cy, cz) = positions[face[k] - 1], positions[face[k + 1] - 1]
                six += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        return six / 6

    def test_an_obj_is_as_large_as_the_mesh_that_was_aged(self):
        sizes = json.loads(self.succeeds("info", self.shared / "urn/mesh.obj", "--json"))["extent"]
        for unit in ([], ["--unit", "cm"]):
            self.succeeds("transfer", self.shared / "history", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "64", *unit, "-o", "aged", "--force")
            self.succeeds("export", "aged", "-o", "urn.obj", "--force")
            for found, expected in zip(json.loads(self.succeeds("info", "urn.obj", "--json"))["extent"], sizes):
                self.assertAlmostEqual(found / expected, 1, 6)

    def test_a_folder_that_is_not_there_is_said_of_the_name_that_was_given(self):
        for name in ("nowhere/urn.glb", "nowhere/urn.usda", "nowhere/urn.usdz", "nowhere/urn.obj"):
            self.fails(CANNOT, f"{name}: cannot be written; the folder nowhere does not exist", "export", self.shared / "aged", "--time", "7.5", "-o", name)

    def test_a_simulation_has_its_objects_and_all_maps(self):
        self.succeeds("synth", "ledge", "--cells", "4", "-o", "ledge")
        self.succeeds("simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "4", "-o", "dirty")
        self.succeeds("export", "dirty", "-o", "wall.obj")
        objects, used, materials = self.check_obj(self.folder / "wall.obj")
        scene = json.loads(re.sub(r"(?m)^\s*//.*$", "", (self.folder / "ledge/scene.json").read_text()))
        if len(scene["objects"]) > 1:
            self.assertEqual(sorted(objects), sorted(o["name"] for o in scene["objects"]))
        for key in ("map_Kd", "map_Pr", "norm", "disp"):
            self.assertIn(key, materials[used[0]])
        check_materialx(self, self.folder / "wall.obj.mtlx")

    def test_udim_tiles_are_materials_of_their_own(self):
        text = (self.shared / "urn/mesh.obj").read_text().splitlines()
        (self.folder / "tiles.obj").write_text("\n".join(text + [  # A square in the second tile.
            "v 100 0 0", "v 130 0 0", "v 130 30 0", "v 100 30 0", "vt 1.1 0.1", "vt 1.9 0.1", "vt 1.9 0.9", "vt 1.1 0.9",
            "f -4/-4 -3/-3 -2/-2", "f -4/-4 -2/-2 -1/-1"]) + "\n")
        self.succeeds("transfer", self.shared / "history", "tiles.obj", "--control", "facing", "--resolution", "64", "-o", "aged")
        self.succeeds("export", "aged", "-o", "two.obj")
        objects, used, materials = self.check_obj(self.folder / "two.obj")
        self.assertEqual(sorted(materials), ["material_1001", "material_1002"])
        self.assertEqual(used, ["material_1001", "material_1002"])
        check_materialx(self, self.folder / "two.obj.mtlx")
        self.succeeds("export", "aged", "--num-times", "2", "-o", "two.usda")
        check_materialx(self, self.folder / "two.mtlx")
        stage = (self.folder / "two.usda").read_text()
        for geometry in re.findall(r'geom="([^"]+)"', (self.folder / "two.mtlx").read_text()):
            self.assertIn(f'def GeomSubset "{geometry.rsplit("/", 1)[1]}"', stage)

    def test_a_stage_has_a_look_for_each_of_its_times(self):
        self.succeeds("export", self.shared / "aged", "--times", "0,7.5,15", "-o", "urn.usda")
        self.assertEqual(check_materialx(self, self.folder / "urn.mtlx"), ["0 s", "7.5 s", "15 s"])

    def test_an_obj_and_a_stage_of_one_name_have_textures_of_their_own(self):
        self.succeeds("export", self.shared / "aged", "--time", "15", "-o", "urn.obj")
        shown = (self.folder / "urn.obj.textures/color.0000.png").read_bytes()
        self.succeeds("export", self.shared / "aged", "--times", "0,7.5", "-o", "urn.usda")
        self.assertEqual((self.folder / "urn.obj.textures/color.0000.png").read_bytes(), shown)
        self.check_obj(self.folder / "urn.obj")
        self.assertEqual(check_materialx(self, self.folder / "urn.obj.mtlx"), ["15 s"])

    def test_files_of_others_in_the_folder_of_textures_are_kept(self):
        (self.folder / "urn.obj.textures").mkdir()
        (self.folder / "urn.obj.textures/mine.png").write_bytes(b"mine")
        self.fails(CANNOT, "holds mine.png", "export", self.shared / "aged", "-o", "urn.obj")
        self.assertEqual((self.folder / "urn.obj.textures/mine.png").read_bytes(), b"mine")

    def test_equal_input_gives_equal_bytes_and_what_is_missing_is_made_again(self):
        for name in ("a.obj", "again/a.obj"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            self.succeeds("export", self.shared / "aged", "-o", name)
        for suffix in (".obj", ".mtl", ".obj.mtlx"):
            self.assertEqual((self.folder / f"a{suffix}").read_bytes(), (self.folder / f"again/a{suffix}").read_bytes())
        status = lambda: json.loads(self.succeeds("export", self.shared / "aged", "-o", "a.obj", "--json"))["status"]
        self.assertEqual(status(), "up to date")
        (self.folder / "a.mtl").unlink()
        self.assertEqual(status(), "done")


if __name__ == "__main__":
    unittest.main()
