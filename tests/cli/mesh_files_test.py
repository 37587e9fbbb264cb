#!/usr/bin/env python3
"""What mesh files say of themselves: extensions, skins, sparse accessors, byte order marks, rows; and models that lie far from the origin.
Usage: mesh_files_test.py PATINATE [unittest arguments]
"""
import base64
import json
import math
import re
import struct
import sys
import unittest

from command_case import INPUT, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"

FORMATS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
FLOAT, U16, U8, I16, I8 = 5126, 5123, 5121, 5122, 5120
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]

# A bent sheet of two squares; UVs as glTF has them, v down, none at a place of its own.
POINTS = [(0, 0, 0), (1, 0, 0), (2, 0, 1), (0, 1, 0), (1, 1, 0), (2, 1, 1)]
UVS = [(0.125, 0.875), (0.5, 0.875), (0.875, 0.875), (0.125, 0.25), (0.5, 0.25), (0.875, 0.25)]
TRIANGLES = [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)]


def setUpModule():
    use(PATINATE)


class Gltf:
    """A glTF that grows: accessors first, then its parts; `text` and `glb` are the files."""

    def __init__(self):
        self.buffer = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "sheet", "mesh": 0}],
                     "meshes": [{"primitives": [{"attributes": {}}]}], "accessors": [], "bufferViews": [], "buffers": []}
        self.primitive = self.json["meshes"][0]["primitives"][0]
        self.primitive["indices"] = self.add([i for t in TRIANGLES for i in t], "SCALAR", U16)

    def view(self, values, component):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        data = struct.pack(f"<{len(values)}{FORMATS[component]}", *values)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)})
        self.buffer += data
        return len(self.json["bufferViews"]) - 1

    def add(self, rows, shape, component=FLOAT, **more):
        values = [x for row in rows for x in row] if rows and isinstance(rows[0], (tuple, list)) else list(rows)
        accessor = {"bufferView": self.view(values, component), "componentType": component, "count": len(values) // COMPONENTS[shape], "type": shape, **more}
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def add_sparse(self, count, indices, values, base=None):
        """VEC3 of floats: zeros, or the accessor `base`, but for some."""
        flat = [x for row in values for x in row]
        accessor = {"componentType": FLOAT, "count": count, "type": "VEC3",
                    "sparse": {"count": len(indices), "indices": {"bufferView": self.view(indices, U8), "componentType": U8}, "values": {"bufferView": self.view(flat, FLOAT)}}}
        if base is not None:
            accessor["bufferView"] = self.json["accessors"][base]["bufferView"]
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def set(self, **attributes):
        self.primitive["attributes"].update(attributes)
        return self

    def needs(self, *extensions):
        self.json["extensionsRequired"] = self.json["extensionsUsed"] = list(extensions)
        return self

    def textures(self, **infos):
        """Texture infos by name; baseColorTexture and metallicRoughnessTexture stand in pbrMetallicRoughness."""
        self.json["images"], self.json["textures"] = [{"uri": "none.png"}], [{"source": 0}]
        material = {"name": "paint", "pbrMetallicRoughness": {}}
        for name, info in infos.items():
            (material["pbrMetallicRoughness"] if name in ("baseColorTexture", "metallicRoughnessTexture") else material)[name] = {"index": 0, **info}
        self.json["materials"], self.primitive["material"] = [material], 0

    def text(self):
        self.json["buffers"] = [{"byteLength": len(self.buffer), "uri": "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()}]
        return json.dumps(self.json).encode()

    def glb(self, version=2):
        self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        head = json.dumps(self.json).encode()
        head += b" " * (-len(head) % 4)
        body = self.buffer + b"\0" * (-len(self.buffer) % 4)
        return struct.pack("<4sIIII", b"glTF", version, 28 + len(head) + len(body), len(head), 0x4E4F534A) + head + struct.pack("<II", len(body), 0x004E4942) + body


def sheet(**more):
    gltf = Gltf()
    return gltf.set(POSITION=gltf.add(POINTS, "VEC3"), TEXCOORD_0=gltf.add(UVS, "VEC2"), **more)


def corners_of_obj(text):
    """Sorted (position, UV) of every corner."""
    rows = {"v": [], "vt": []}
    corners = []
    for line in text.splitlines():
        words = line.split()
        if words and words[0] in rows:
            rows[words[0]].append(tuple(map(float, words[1:])))
        elif words and words[0] == "f":
            for corner in words[1:]:
                place, uv = corner.split("/")[:2]
                corners.append(rows["v"][int(place) - 1] + rows["vt"][int(uv) - 1])
    return sorted(corners)


class Case(CommandCase):
    def write(self, name, content):
        (self.folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return name

    def info(self, name, content):
        return json.loads(self.succeeds("info", self.write(name, content), "--json"))

    def refuses(self, words, name, content):
        return self.fails(INPUT, words, "info", self.write(name, content))

    def corners(self, name, content):
        """What was read, in the file's numbers, by the mesh that a transfer keeps."""
        self.write(name, content)
        self.succeeds("transfer", self.shared / "history", name, "--control", "facing", "--unit", "mm", "--texel-size", 0.01, "--atlas", "uv", "--resolution", 16, "-o", "kept", "--force", "--quiet")
        return corners_of_obj((self.folder / "kept/mesh.obj").read_text())

    def assert_corners(self, found, points, uvs, tolerance=1e-6):
        """@param uvs  v down."""
        expected = sorted((*points[i], uvs[i][0], 1 - uvs[i][1]) for t in TRIANGLES for i in t)
        self.assertEqual(len(found), len(expected))
        for a, b in zip(found, expected):
            for x, y in zip(a, b):
                self.assertAlmostEqual(x, y, delta=tolerance)


class Extensions(Case):
    def test_what_a_file_requires_is_known_or_refused_by_its_name_before_its_buffers_are_opened(self):
        for name in ("KHR_meshopt_compression", "KHR_node_visibility", "CESIUM_RTC", "ACME_materials_of_surfaces", "x\x1b[31m"):
            for write in (Gltf.text, Gltf.glb):
                gltf = sheet().needs("KHR_materials_unlit", name)
                content = write(gltf)
                gltf.json["buffers"] = [{"byteLength": 4, "uri": "missing.bin"}]
                for file in ("a.gltf", "a.GLB") if write == Gltf.glb else ("a.gltf", "b.gltf"):
                    shown = name.replace("\x1b", "\\x1b")
                    line = self.refuses(f"needs the extension {shown}, which is not supported; export it without", file, json.dumps(gltf.json) if file == "b.gltf" else content)
                    self.assertNotIn("KHR_materials_unlit", line)
        self.refuses("needs the extensions A, B, which are not supported; export it without them", "a.gltf", sheet().needs("A", "KHR_mesh_quantization", "B").text())

    def test_what_is_no_draco_is_named_where_accessors_have_no_buffer_views(self):
        for requires in (True, False):
            gltf = sheet()
            self_view = gltf.json["accessors"][0]["bufferView"]
            for accessor in gltf.json["accessors"]:
                del accessor["bufferView"]
            gltf.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": self_view, "attributes": {"POSITION": 0}}}
            if requires:
                gltf.needs("KHR_draco_mesh_compression")
            for file, content in (("a.gltf", gltf.text()), ("a.glb", gltf.glb())):
                self.refuses("mesh 0: its Draco data are damaged", file, content)

    def test_draco_beside_plain_numbers_is_not_needed(self):
        gltf = sheet()
        gltf.json["extensionsUsed"] = ["KHR_draco_mesh_compression", "KHR_texture_transform"]
        gltf.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
        info = self.info("a.gltf", gltf.text())
        self.assertEqual((info["triangles"], info["extensions_read"], info["extensions_not_looked_at"], info["unit"]), (4, ["KHR_draco_mesh_compression", "KHR_texture_transform"], [], "m"))

    def test_another_version_is_refused_as_that(self):
        first = {"asset": {"version": "1.0"}, "meshes": {"a": {"primitives": []}}, "scenes": {"s": {"nodes": []}}}
        self.refuses("is glTF 1.0, which is not read; convert it to glTF 2.0", "a.gltf", json.dumps(first))
        self.refuses("is glTF 1.0, which", "a.gltf", json.dumps({**first, "asset": {}}))
        self.refuses("is glTF 0.8, which", "a.gltf", json.dumps({**first, "asset": {"version": 0.8}}))
        self.refuses("is glTF 1, which", "a.glb", sheet().glb(version=1))
        gltf = sheet()
        gltf.json["asset"] = {"version": "2.1", "minVersion": "2.1"}
        self.refuses("is glTF 2.1, which", "a.gltf", gltf.text())
        gltf.json["asset"] = {"version": "2.1", "minVersion": "2.0"}
        self.assertEqual(self.info("a.gltf", gltf.text())["triangles"], 4)
        del gltf.json["asset"]
        self.refuses("`asset` says no version", "a.gltf", gltf.text())

    def test_broken_json_is_one_line_in_our_words(self):
        whole = sheet().text()
        self.refuses("is no valid JSON at line 1, column 41", "a.gltf", whole[:40])
        for content in (b"[]", b"7", whole.replace(b'"nodes": [{', b'"nodes": [7, {'), whole.replace(b'"POSITION"', b'"POSITION": "x", "Q"'), whole.replace(b'"count": 6', b'"count": -1'),
                        whole.replace(b'"byteLength": ', b'"byteLength": 4611686018427387904'), whole.replace(b'"accessors"', b'"accessors": 1, "b"')):
            line = self.refuses("a.gltf: ", "a.gltf", content)
            self.assertNotRegex(line, "exception|alloc|std::")

    def test_texture_transforms_move_the_uvs_that_the_base_color_has(self):
        # Rotation is counter-clockwise where v points down, as three.js, Blender and the sample viewers have it.
        gltf = sheet().needs("KHR_texture_transform")
        transform = {"offset": [0.25, 0.75], "rotation": 0.5, "scale": [0.25, 0.5]}
        gltf.textures(baseColorTexture={"extensions": {"KHR_texture_transform": transform}})
        c, s = math.cos(0.5), math.sin(0.5)
        turned = [(0.25 + c * 0.25 * u + s * 0.5 * v, 0.75 - s * 0.25 * u + c * 0.5 * v) for u, v in UVS]
        moved = [(u, v - 0.5) for u, v in turned]  # Into the square.
        transform["offset"][1] -= 0.5
        self.assert_corners(self.corners("a.gltf", gltf.text()), POINTS, moved)
        gltf = sheet()
        gltf.set(TEXCOORD_1=gltf.add([(v, u) for u, v in UVS], "VEC2"))
        gltf.textures(baseColorTexture={"texCoord": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1, "scale": [0.5, 1]}}})
        self.assert_corners(self.corners("a.gltf", gltf.text()), POINTS, [(v / 2, u) for u, v in UVS])

    def test_the_uvs_are_those_of_the_base_color(self):
        swapped = [(v, u) for u, v in UVS]
        for infos, uvs in (({"baseColorTexture": {"texCoord": 1}}, swapped), ({"baseColorTexture": {}, "occlusionTexture": {"texCoord": 1}}, UVS),
                           ({"normalTexture": {"texCoord": 1}}, swapped), ({}, UVS)):
            gltf = sheet()
            gltf.set(TEXCOORD_1=gltf.add(swapped, "VEC2"))
            gltf.textures(**infos)
            self.assert_corners(self.corners("a.gltf", gltf.text()), POINTS, uvs)
            differ = "material `paint` has textures with different UVs; those of its base color are read"
            self.assertEqual(self.info("a.gltf", gltf.text())["notes"], [differ] if len(infos) > 1 else [])
        gltf = Gltf()
        gltf.set(POSITION=gltf.add(POINTS, "VEC3"), TEXCOORD_1=gltf.add(UVS, "VEC2"))
        self.assert_corners(self.corners("a.gltf", gltf.text()), POINTS, UVS)

    def test_quantized_attributes_are_numbers(self):
        for component, largest in ((I8, 127), (U8, 255), (I16, 32767), (U16, 65535)):
            gltf = Gltf().needs("KHR_mesh_quantization")
            places = [tuple(round(x * largest / 2) for x in p) for p in POINTS]
            gltf.set(POSITION=gltf.add(places, "VEC3", component, normalized=True), TEXCOORD_0=gltf.add([tuple(round(x * largest) for x in uv) for uv in UVS], "VEC2", component, normalized=True))
            gltf.json["nodes"][0]["scale"] = [2, 2, 2]
            self.assert_corners(self.corners("a.glb", gltf.glb()), POINTS, UVS, 2 / largest)
            gltf = Gltf()
            gltf.set(POSITION=gltf.add(POINTS, "VEC3", component), TEXCOORD_0=gltf.add(UVS, "VEC2"))
            self.assert_corners(self.corners("a.glb", gltf.glb()), POINTS, UVS)

    def test_instances_are_meshes_at_their_places(self):
        gltf = sheet().needs("EXT_mesh_gpu_instancing")
        half = math.sqrt(0.5)
        gltf.json["nodes"][0].update(scale=[2, 2, 2], extensions={"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": gltf.add([(0, 0, 0), (10, 0, 0), (0, 0, 20)], "VEC3"), "SCALE": gltf.add([(1, 1, 1), (3, 1, 1), (1, 1, 1)], "VEC3"),
            "ROTATION": gltf.add([tuple(round(32767 * x) for x in q) for q in ((0, 0, 0, 1), (0, 0, 0, 1), (0, 0, half, half))], "VEC4", I16, normalized=True)}}})
        info = self.info("a.glb", gltf.glb())
        self.assertEqual((info["triangles"], info["parts"]), (12, 3))
        for found, expected in zip(info["extent"], (2 * (10 + 6) + 2 * 1, 2 * 2, 2 * (20 + 1))):  # The third stands on end: x from -1, y to 2.
            self.assertAlmostEqual(found, expected, delta=1e-3)
        gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = gltf.add([(1, 1, 1)], "VEC3")
        self.refuses("node 0: instances: SCALE has 1 entries", "a.glb", gltf.glb())


class AtRest(Case):
    def skinned(self, joints, inverse_bind=None, weights=(1, 0, 0, 0)):
        gltf = sheet()
        numbers = [(0, 1, 0, 0)] * len(POINTS)
        gltf.set(JOINTS_0=gltf.add(numbers, "VEC4", U8), WEIGHTS_0=gltf.add([weights] * len(POINTS), "VEC4"))
        gltf.json["nodes"] = [{"name": "sheet", "mesh": 0, "skin": 0, "scale": [0.01] * 3, "rotation": [0.5, 0.5, 0.5, 0.5]}, *joints]
        gltf.json["scenes"][0]["nodes"] = list(range(1 + len(joints)))
        gltf.json["skins"] = [{"joints": list(range(1, 1 + len(joints)))}]
        if inverse_bind:
            gltf.json["skins"][0]["inverseBindMatrices"] = gltf.add(inverse_bind, "MAT4")
        return gltf

    def test_a_skin_stands_where_its_joints_are_and_not_where_its_node_is(self):
        self.assert_corners(self.corners("a.glb", self.skinned([{}, {}], [IDENTITY, IDENTITY]).glb()), POINTS, UVS)
        self.assert_corners(self.corners("a.glb", self.skinned([{}, {}]).glb()), POINTS, UVS)
        # A joint that stands where it was bound changes nothing; a figure is bound in centimeters and stands in meters.
        bound = [*IDENTITY[:12], -3, -4, -5, 1]
        self.assert_corners(self.corners("a.glb", self.skinned([{"translation": [3, 4, 5]}, {}], [bound, IDENTITY]).glb()), POINTS, UVS)
        self.assert_corners(self.corners("a.glb", self.skinned([{"scale": [10, 10, 10]}, {}]).glb()), [tuple(10 * x for x in p) for p in POINTS], UVS)
        # Two joints with half the weight each; weights that do not sum to 1.
        moved = [tuple(x + d for x, d in zip(p, (2, 0, 0))) for p in POINTS]
        self.assert_corners(self.corners("a.glb", self.skinned([{}, {"translation": [4, 0, 0]}], weights=(0.25, 0.25, 0, 0)).glb()), moved, UVS)

    def test_a_skin_that_does_not_fit_is_named(self):
        gltf = self.skinned([{}])
        gltf.json["skins"][0]["joints"] = [9]
        self.refuses("skin 0: joint 9 does not exist", "a.glb", gltf.glb())
        self.refuses("joint 1 is out of range; the skin has 1", "a.glb", self.skinned([{}], weights=(0.5, 0.5, 0, 0)).glb())
        gltf.json["nodes"][0]["skin"] = 5
        self.refuses("skin 5 does not exist", "a.glb", gltf.glb())
        self.refuses("not a 4 x 4 matrix for every joint", "a.glb", self.skinned([{}, {}], [IDENTITY]).glb())

    def test_morph_targets_count_by_their_default_weights(self):
        shift = [(0, 0, 1)] * len(POINTS)
        for mesh_weights, node_weights, moved in (([0.5], None, 0.5), ([0.5], [2], 2), (None, None, 0), ([0], None, 0)):
            gltf = sheet()
            gltf.primitive["targets"] = [{"POSITION": gltf.add(shift, "VEC3")}]
            if mesh_weights:
                gltf.json["meshes"][0]["weights"] = mesh_weights
            if node_weights:
                gltf.json["nodes"][0]["weights"] = node_weights
            self.assert_corners(self.corners("a.glb", gltf.glb()), [(x, y, z + moved) for x, y, z in POINTS], UVS)

    def test_sparse_accessors_replace_some_of_zeros_or_of_a_buffer_view(self):
        raised = [(x, y, 3) if i in (1, 4) else (x, y, z) for i, (x, y, z) in enumerate(POINTS)]
        gltf = sheet()
        gltf.set(POSITION=gltf.add_sparse(6, [1, 4], [raised[1], raised[4]], base=gltf.primitive["attributes"]["POSITION"]))
        self.assert_corners(self.corners("a.glb", gltf.glb()), raised, UVS)
        gltf.set(POSITION=gltf.add_sparse(6, [1, 2, 3, 4, 5], raised[1:]))
        self.assert_corners(self.corners("a.glb", gltf.glb()), raised, UVS)
        gltf = sheet()
        gltf.primitive["targets"] = [{"POSITION": gltf.add_sparse(6, [1, 4], [(0, 0, 3)] * 2)}]
        gltf.json["meshes"][0]["weights"] = [1]
        self.assert_corners(self.corners("a.glb", gltf.glb()), raised, UVS)
        for indices in ([4, 1], [1, 6], [1, 1]):
            gltf.set(POSITION=gltf.add_sparse(6, indices, [(0, 0, 0)] * 2))
            self.refuses("its sparse indices do not increase, or exceed its 6 elements", "a.glb", gltf.glb())
        gltf.set(POSITION=gltf.add_sparse(10**12, [1], [(0, 0, 0)]))
        self.refuses("more than the file has bytes", "a.glb", gltf.glb())

    def test_animations_are_said_to_be_left_out(self):
        gltf = sheet()
        gltf.json["animations"] = [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}], "samplers": [{"input": 0, "output": 1}]}]
        gltf.json["scenes"].append({"nodes": []})
        self.assertEqual(self.info("a.glb", gltf.glb())["notes"], ["of its 2 scenes only number 0 is read", "its animations are not looked at: it is read at rest"])


def plate_obj(number=str, scale=1.0, origin=(0.0, 0.0, 0.0)):
    lines = []
    for word, rows in (("v", [tuple(o + scale * x for o, x in zip(origin, p)) for p in POINTS]), ("vt", [(u, 1 - v) for u, v in UVS])):
        lines += [word + " " + " ".join(number(float(x)) for x in row) for row in rows]
    return "\n".join(lines + ["f " + " ".join(f"{i + 1}/{i + 1}" for i in t) for t in TRIANGLES]) + "\n"


def comma(x):
    return repr(x).replace(".", ",")


class Text(Case):
    def test_a_byte_order_mark_is_no_statement(self):
        corners = sorted((*POINTS[i], UVS[i][0], 1 - UVS[i][1]) for t in TRIANGLES for i in t)
        self.assertEqual(self.corners("a.obj", "\ufeff" + plate_obj()), corners)
        self.assertEqual(self.corners("a.obj", "\ufeff" + plate_obj().replace("\n", "\r\n")), corners)
        self.assertEqual(self.info("a.ply", "\ufeff" + PLY + PLY_ROWS)["triangles"], 4)
        self.assertEqual(self.info("a.stl", "\ufeff" + stl())["triangles"], 4)
        for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-32"):
            for name, text in (("a.obj", plate_obj()), ("a.stl", stl())):
                mark = "" if encoding in ("utf-16", "utf-32") else "\ufeff"
                self.refuses("is UTF-16 or UTF-32 text; save it as UTF-8", name, (mark + text).encode(encoding))

    def test_free_form_surfaces_are_refused(self):
        points = "".join("v %g %g %g\n" % p for p in POINTS)
        for faces in ("", "f 1 2 5\n"):
            self.refuses("holds a free-form surface (`surf`)", "a.obj", points + faces + "cstype bspline\ndeg 1 1\nsurf 0 1 0 1 1 2 4 5\nend\n")

    def test_formats_of_other_programs_are_no_images(self):
        for name, content in (("a.fbx", b"Kaydara FBX Binary  \0\x1a\0"), ("a.off", "OFF\n3 1 0\n"), ("a.usda", "#usda 1.0\n"), ("A.DAE", "<COLLADA/>")):
            self.refuses("no mesh format has the extension", name, content)
        self.refuses("is neither glTF (JSON) nor GLB", "a.glb", b"PK\3\4" + bytes(40))

    def test_decimal_commas_are_refused_with_their_line(self):
        text = plate_obj(comma)
        self.refuses("line 1: `0,0` is not a finite number; decimals begin with a point, not a comma", "a.obj", text)
        lines = plate_obj().splitlines()
        lines[7] = lines[7].replace(".", ",")
        self.refuses("line 8: `0,5` is not a finite number", "a.obj", "\n".join(lines))
        self.refuses("line 7: `0,5` is not a finite number", "a.obj", "\n".join([*lines[:6], "vn 0,5 0 1", *lines[6:]]))
        self.refuses("line 4: found `0,5`", "a.stl", stl().replace("vertex 0.0", "vertex 0,5", 1))
        self.refuses("line 14: element `vertex`, row 0: `0,5` is not a number", "a.ply", PLY + PLY_ROWS.replace("0 0 0", "0,5 0 0", 1))

    def test_numbers_are_numbers_to_their_end(self):
        for word in ("1.0f", "1e", "0x1", "1_0", "1.0.0", "--1"):
            self.refuses(f"line 1: `{word}` is not a finite number", "a.obj", f"v {word} 0 0\n" + plate_obj())
        self.assertEqual(self.info("a.obj", plate_obj().replace("v 2.0 0.0 1.0", "v .2+e1 +0. 1.0E+0"))["extent"], [2, 1, 1])


PLY = """ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
property uchar red
property uchar green
property uchar blue
property uchar alpha
end_header
"""
PLY_ROWS = "\n".join([" ".join(map(str, p)) for p in POINTS] + ["3 {} {} {} 1 2 3 4".format(*t) for t in TRIANGLES]) + "\n"


class PlyRows(Case):
    def test_an_ascii_row_is_a_line(self):
        self.assertEqual(self.info("a.ply", PLY.replace("end", "comment x\nend") + "\n" + PLY_ROWS.replace("\n", " \r\n\r\n"))["triangles"], 4)
        more = "element `face`, row 1: has 6 more values than the header declares, from `9` on"
        rows = PLY_ROWS.splitlines()
        rows[7] += " 9 8 7 6 5 4"
        self.refuses(f"line 21: {more}", "a.ply", PLY + "\n".join(rows))
        self.refuses(f"line 21: {more}", "a.ply", (PLY + "\n".join(rows)).replace("\n", "\r"))
        rows = PLY_ROWS.splitlines()
        rows[2] += " 255 0 0"
        self.refuses("line 16: element `vertex`, row 2: has 3 more values", "a.ply", PLY + "\n".join(rows))
        rows[2] = "2 0"
        self.refuses("line 16: element `vertex`, row 2: ends before all values", "a.ply", PLY + "\n".join(rows))
        self.refuses("line 24: holds more rows than its header declares", "a.ply", PLY + PLY_ROWS + "3 0 1 2 1 2 3 4\n")
        self.write("c.ply", PLY + PLY_ROWS)
        self.fails(INPUT, "has 6 more values", "register", self.write("b.ply", PLY + PLY_ROWS.replace("3 1 5 4 1 2 3 4", "3 1 5 4 1 2 3 4 9 8 7 6 5 4")), "c.ply", "-o", "x")

    def test_binary_rows_end_with_the_file(self):
        header = PLY.replace("ascii", "binary_little_endian").encode()
        body = b"".join(struct.pack("<3f", *p) for p in POINTS)
        faces = b"".join(struct.pack("<B3i4B", 3, *t, 1, 2, 3, 4) for t in TRIANGLES)
        self.assertEqual(self.info("a.ply", header + body + faces)["triangles"], 4)
        self.assertEqual(self.info("a.ply", header + body + faces + b"\r\n\0")["triangles"], 4)
        self.refuses("holds 8 bytes more than its header declares", "a.ply", header + body + faces + b"12345678")
        colored = b"".join(struct.pack("<3f4B", *p, 9, 9, 9, 9) for p in POINTS)
        self.refuses("a.ply: ", "a.ply", header + colored + faces)
        for kind, form, count in (("float", "f", 2.5), ("char", "b", -1), ("double", "d", float("nan"))):
            odd = header.replace(b"list uchar int", f"list {kind} int".encode())
            self.refuses("row 0: the length of a list is negative or no whole number", "a.ply", odd + body + struct.pack("<" + form, count) + faces)


def stl():
    lines = ["solid Sheet"]
    for t in TRIANGLES:
        lines += ["facet normal 0 0 1", "outer loop", *("vertex {!r} {!r} {!r}".format(*map(float, POINTS[i])) for i in t), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid Sheet"]) + "\n"


class Stl(Case):
    def test_ascii_is_read_in_any_case_and_layout(self):
        text = stl()
        self.assertEqual(self.info("a.stl", text)["surfaces"][0]["node"], "Sheet")
        indented = "\n".join("\t " * (1 + line.startswith("vertex")) + line for line in text.splitlines())
        for variant in (text.upper(), text.title(), "Solid" + text[5:], "\n" + text, " \r\n\t" + text, "\ufeff\n" + text.upper(), indented, text.replace("\n", "\r\n"), text.replace("\n", "\r"),
                        text.replace("solid Sheet", "solid"), text.upper() + text):
            info = self.info("a.stl", variant)
            self.assertEqual(info["triangles"], 8 if len(variant) > 1.5 * len(indented) else 4, variant[:30])
            self.assertEqual(info["extent"], [2, 1, 1])

    def test_binary_that_calls_itself_solid_is_binary(self):
        for word in (b"solid x", b"SOLID facet normal", b"\xef\xbb\xbfsolid"):
            facets = b"".join(struct.pack("<12fH", 0, 0, 1, *(x for i in t for x in POINTS[i]), 0) for t in TRIANGLES)
            self.assertEqual(self.info("a.stl", word.ljust(80) + struct.pack("<I", len(TRIANGLES)) + facets)["triangles"], 4)
            self.refuses("is no STL file, or cut off", "a.stl", word.ljust(80) + struct.pack("<I", len(TRIANGLES)) + facets[:-1])


FAR = {"map": (461_234.5, 5_432_109.25, 312.5), "earth": (4_201_234.5, 172_345.25, 4_780_123.75), "farther": (-3e9, 2e9, 1e9)}


def distances(points):
    return [math.dist(a, b) for i, a in enumerate(points) for b in points[:i]]


class FarFromTheOrigin(Case):
    """The sheet, half a meter large, in the coordinates of maps and of the earth."""
    SCALE = 0.25

    def plain(self):
        return sorted(distances([tuple(self.SCALE * x for x in p) for p in POINTS]))

    def assert_distances(self, points, factor=1.0, origin=None):
        self.assertEqual(len(points), len(POINTS))
        for found, expected in zip(sorted(distances(points)), self.plain()):
            self.assertAlmostEqual(factor * found, expected, delta=1e-6 * 2 * self.SCALE + self.rounding(origin))

    def rounding(self, origin):
        """Of the coordinates themselves, in double precision."""
        return 4 * math.ulp(max(map(abs, origin)))

    def age(self, origin):
        self.write("sheet.obj", plate_obj(repr, self.SCALE, origin))
        self.succeeds("transfer", self.shared / "history", "sheet.obj", "--unit", "m", "--control", "facing", "--texel-size", 10, "--resolution", 16, "-o", "aged", "--force", "--quiet")

    def test_exports_keep_distances_and_places(self):
        for origin in FAR.values():
            self.age(origin)
            for up in ("y", "z"):
                self.succeeds("export", "aged", "--num-times", 2, "--up", up, "-o", "aged.glb", "--force", "--quiet")
                content = (self.folder / "aged.glb").read_bytes()
                head = json.loads(content[20:20 + struct.unpack("<I", content[12:16])[0]])
                accessor = head["accessors"][head["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
                begin = 28 + struct.unpack("<I", content[12:16])[0] + head["bufferViews"][accessor["bufferView"]]["byteOffset"]
                local = [struct.unpack_from("<3f", content, begin + 12 * i) for i in range(accessor["count"])]
                self.assert_distances(local, origin=origin)
                moved = [tuple(x + t for x, t in zip(p, head["nodes"][0]["translation"])) for p in local]
                middle = tuple(o + self.SCALE * x for o, x in zip(origin, (1, 0.5, 0.5)))
                middle = middle if up == "y" else (middle[0], middle[2], -middle[1])
                for k in range(3):
                    self.assertAlmostEqual((min(p[k] for p in moved) + max(p[k] for p in moved)) / 2, middle[k], delta=1e-6 + self.rounding(origin))
                self.assert_distances([c[:3] for c in sorted({c[:3] for c in self.corners("again.glb", content)})], origin=origin)
            self.succeeds("export", "aged", "--num-times", 2, "-o", "aged.usda", "--force", "--quiet")
            text = (self.folder / "aged.usda").read_text()
            numbers = [float(x) for x in re.findall(r"[-0-9.e]+", re.search(r"points = \[(.*)\]", text).group(1))]
            self.assert_distances(list(zip(*[iter(numbers)] * 3)), 0.001, origin)
            shift = [0.001 * float(x) for x in re.search(r"double3 xformOp:translate = \((.*)\)", text).group(1).split(",")]
            for k in range(3):
                self.assertAlmostEqual(shift[k], origin[k] + self.SCALE * (1, 0.5, 0.5)[k], delta=1e-6 + self.rounding(origin))
            self.succeeds("export", "aged", "--time", 1, "-o", "aged.obj", "--force", "--quiet")
            self.assert_distances(sorted({c[:3] for c in corners_of_obj((self.folder / "aged.obj").read_text())}), origin=origin)

    def test_near_the_origin_nothing_is_moved(self):
        self.age((0.1, 0, 0))
        self.succeeds("export", "aged", "--num-times", 2, "-o", "aged.glb", "--quiet")
        self.assertNotIn(b"translation", (self.folder / "aged.glb").read_bytes())
        self.succeeds("export", "aged", "--num-times", 2, "-o", "aged.usda", "--quiet")
        self.assertNotIn("xformOp", (self.folder / "aged.usda").read_text())


    def test_a_scene_far_away_is_brought_near_or_refused(self):
        for origin, translate, is_near in ((FAR["map"], None, False), (FAR["map"], [-x for x in FAR["map"]], True), ((4612.5, 5432.25, 3.5), None, True)):
            self.write("sheet.obj", plate_obj(repr, self.SCALE, origin))
            thing = {"name": "sheet", "mesh": "sheet.obj", "preset": "copper", **({"translate": translate} if translate else {})}
            self.write("scene.json", json.dumps({**Speed.SCENE, "unit": "m", "objects": [thing]}))
            if is_near:
                self.succeeds("simulate", "scene.json", "-o", "out", "--force", "--quiet")
            else:
                self.fails(INPUT, "object 'sheet' lies more than 1000 km from the origin; let its `translate` bring it nearer", "simulate", "scene.json", "-o", "out")


class Lines(Case):
    def test_control_characters_of_names_are_written_as_text(self):
        history = self.take("history")
        evil = self.folder / "x\x1b[31m\u009b\u202e"
        history.rename(evil)
        for arguments in (("plan", "transfer", evil.name, self.shared / "urn/mesh.obj", "--control", "facing", "-o", "out\x1b[2J"), ("info", evil.name), ("validate", evil.name),
                          ("transfer", evil.name, self.shared / "urn/mesh.obj", "--control", "facing", "-o", "out\x1b[2J", "--dry-run")):
            for more in ((), ("--json",)):
                result = self.run_patinate(*arguments, *more)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertNotRegex(result.stdout + result.stderr, "[\x1b\u009b\u202e]")
        result = self.run_patinate("cluster", "plan", "transfer", evil.name, self.shared / "urn/mesh.obj", "--control", "facing", "-o", "out\x1b[2J", "--json")
        self.assertIn("out\x1b[2J", json.dumps(json.loads(result.stdout), ensure_ascii=False).replace("\\u001b", "\x1b"))

    def test_problems_are_twenty_lines_and_a_count(self):
        history = self.take("history")
        def repeat(h):
            frame = h["frames"][0]
            h["frames"] = [{**frame, "time": float(i)} for i in range(60)]
        self.edit_json(history / "history.json", repeat)
        frame = json.loads((history / "history.json").read_text())["frames"][0]["file"]
        (history / frame).write_bytes((history / frame).read_bytes()[:-200])
        result = self.run_patinate("validate", "history")
        self.assertEqual(result.returncode, INPUT)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 21, result.stderr[-500:])
        self.assertRegex(lines[-1], r"^patinate: error: and \d+ more problems; --json lists all$")
        self.assertGreaterEqual(len(json.loads(self.run_patinate("validate", "history", "--json").stdout)["problems"]), 60)


class Speed(Case):
    SCENE = {"format": "patinate.scene", "version": 2, "unit": "mm", "seed": 1, "atlas": {"resolution": 16}, "materials": ["water", "patina"], "objects": [{"name": "sheet", "mesh": "sheet.obj", "preset": "copper"}],
             "emitters": [{"name": "rain", "shape": "sky", "speed": 3000, "gammatons": 10, "carries": {"water": 0.8}}], "rules": [], "time": {"unit": "h", "per_iteration": 1}, "run": {"iterations": 2}}

    def notes(self, unit, speed, size, **more):
        self.write("sheet.obj", plate_obj(repr, size))
        self.write("scene.json", json.dumps({**self.SCENE, "unit": unit, **more, "emitters": [{**self.SCENE["emitters"][0], "speed": speed}]}))
        result = self.run_patinate("simulate", "scene.json", "-o", "out", "--force", "--dry-run")
        self.assertEqual(result.returncode, 0, result.stderr)
        return [line for line in result.stderr.splitlines() if "`speed`" in line]

    def test_a_speed_of_another_unit_or_size_is_said(self):
        self.assertEqual(self.notes("mm", 3000, 100), [])
        self.assertEqual(self.notes("m", 3, 0.1), [])
        self.assertEqual(self.notes("mm", 9000, 10), [])
        self.assertIn("fly straight, as without gravity", self.notes("m", 3000, 0.1)[0])
        self.assertIn("fall straight down, wherever they are sent", self.notes("mm", 3, 1000)[0])
        self.assertEqual(self.notes("m", 3000, 0.1, gravity=[0, 0, 0]), [])


if __name__ == "__main__":
    unittest.main()
