#!/usr/bin/env python3
"""tools/blender in a Blender without display (Debian's 3.4). Usage: addon_test.py PATINATE. Skipped, saying so, where Blender is not installed (tools/nightly installs it)."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_case import CommandCase, use  # noqa: E402

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
ADDON = pathlib.Path(__file__).resolve().parents[2] / "tools/blender"
BLENDER = shutil.which("blender")
if not BLENDER:
    print("addon_test: skipped, blender is not installed")
    sys.exit(77)

# Blender looks relative names up from PWD, and for the libraries of its Python (numpy) where the first python3 of PATH is: Debian's is the one.
ENVIRONMENT = os.environ | {"PATH": "/usr/bin:/bin"}


# What every script begins with: the add-on, and a flat picture of a material's color at a frame.
BEGIN = f"""
import json, sys
sys.path.insert(0, {str(ADDON)!r})
import bpy, numpy, patinate_blender
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, 25

def load(path, **more):
    return patinate_blender.load(path, program={PATINATE!r}, cache="textures", **more)

def pixels(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"  # As they are.
    width, height = image.size
    return numpy.array(image.pixels[:]).reshape(height, width, -1)[..., :3]

def flat_picture(thing, frame, width, height):
    scene.render.engine, scene.cycles.device, scene.cycles.samples, scene.cycles.pixel_filter_type, scene.cycles.filter_width = "CYCLES", "CPU", 1, "BLACKMAN_HARRIS", 0.01
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    for slot in thing.material_slots:
        nodes, links = slot.material.node_tree.nodes, slot.material.node_tree.links
        emission = nodes.new("ShaderNodeEmission")
        links.new(nodes["Principled BSDF"].inputs["Base Color"].links[0].from_socket, emission.inputs["Color"])
        links.new(emission.outputs["Emission"], nodes["Material Output"].inputs["Surface"])
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", max(thing.dimensions)
    camera.location, camera.rotation_euler = (0, -10, 0), (numpy.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.frame_set(frame)
    scene.render.filepath = bpy.path.abspath(f"//picture_{{frame}}.exr") if bpy.data.filepath else f"{{__import__('os').getcwd()}}/picture_{{frame}}.exr"
    bpy.ops.render.render(write_still=True)
    return pixels(scene.render.filepath)
"""


def setUpModule():
    use(PATINATE)


class Addon(CommandCase):
    def blender(self, script):
        """What the script gives to `print("SAID", json.dumps(...))`."""
        (self.folder / "script.py").write_text(BEGIN + script)
        result = subprocess.run([BLENDER, "--background", "--factory-startup", "--python-exit-code", "1", "--python", self.folder / "script.py"], cwd=self.folder, env=ENVIRONMENT | {"PWD": str(self.folder)}, capture_output=True, text=True, timeout=300)
        said = [line[5:] for line in result.stdout.splitlines() if line.startswith("SAID ")]
        self.assertEqual((result.returncode, len(said)), (0, 1), result.stdout + result.stderr)
        return json.loads(said[0])

    def test_a_history_shows_its_own_colors_at_every_frame(self):
        # 25 frames over the 22.5 s of four images: 7 is a quarter of the way, between two images; 25 is the end.
        for frame in (1, 7, 25):
            self.succeeds("export", self.shared / "history", "--time", 22.5 * (frame - 1) / 24, "--format", "exr", "-o", f"true_{frame}")
        said = self.blender(f"""
thing = load({str(self.shared / "history")!r}, num_times=4)
found = {{}}
for frame in (1, 7, 25):
    truth = pixels(f"true_{{frame}}/00000.exr")
    shown = flat_picture(thing, frame, truth.shape[1], truth.shape[0])
    found[frame] = [float(abs(shown - truth).max()), thing["patinate_time"]]
print("SAID", json.dumps(found))
""")
        for frame, (error, time) in said.items():
            self.assertAlmostEqual(time, 22.5 * (int(frame) - 1) / 24, places=5)
            # Images hold codes: half a code is at most 1 / 255 / 2 x the greatest slope of sRGB, 2.28, and single precision.
            self.assertLess(error, 2.28 / 510 + 1e-3, frame)

    def test_a_transfer_has_its_mesh_uvs_and_material_over_time(self):
        said = self.blender(f"""
thing = load({str(self.shared / "aged")!r}, num_times=3)
nodes = thing.data.materials[0].node_tree.nodes
image = next(n for n in nodes if n.type == "TEX_IMAGE")
offsets = []
for frame in (1, 12, 13, 14, 25):
    scene.frame_set(frame)
    offsets.append(image.image_user.frame_offset)
print("SAID", json.dumps({{"triangles": len(thing.data.polygons), "uvs": len(thing.data.uv_layers[0].data), "size": max(thing.dimensions), "offsets": offsets,
                           "image": image.image.filepath, "unit": thing["patinate_time_unit"], "materials": [m.name for m in thing.data.materials]}}))
""")
        faces = sum(line.startswith("f ") for line in (self.shared / "aged/mesh.obj").read_text().splitlines())
        self.assertEqual((said["triangles"], said["uvs"], said["unit"], said["materials"]), (faces, 3 * faces, "s", ["aged_material"]))
        self.assertEqual(said["offsets"], [-1, -1, 0, 0, 0])  # The number of the file is 1 + offset: the first of three, from the middle on the second, blended into the third.
        self.assertTrue(said["image"].endswith("color.0000.png"))
        points = [list(map(float, line.split()[1:])) for line in (self.shared / "aged/mesh.obj").read_text().splitlines() if line.startswith("v ")]
        meters = float(re.search(r"metersPerUnit = (\S+)", next(self.folder.glob("textures/aged-*-3/aged.usda")).read_text())[1])
        size = meters * max(max(p[a] for p in points) - min(p[a] for p in points) for a in range(3))
        self.assertAlmostEqual(said["size"] / size, 1, places=5)

    def test_equal_names_and_other_numbers_of_images_keep_their_own_textures(self):
        # Two results called "aged": what was imported first must not change when the second comes, nor when the file is read again.
        for name, seed in (("one", 1), ("two", 2)):
            (self.folder / name).mkdir()
            self.succeeds("transfer", self.shared / "history", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", 64, "--seed", seed, "-o", f"{name}/aged")
        said = self.blender("""
def shown(thing):
    image = next(n for n in thing.data.materials[0].node_tree.nodes if n.type == "TEX_IMAGE").image
    return image.filepath_from_user(), float(pixels(bpy.path.abspath(image.filepath)).sum())

things = [load("one/aged", num_times=3)]
first = shown(things[0])
things += [load("two/aged", num_times=3), load("one/aged", num_times=2)]
names = [thing.name for thing in things]
now = [shown(thing) for thing in things]
import os
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("all.blend"))
bpy.ops.wm.open_mainfile(filepath=os.path.abspath("all.blend"))
later = [shown(bpy.data.objects[name]) for name in names]
print("SAID", json.dumps({"first": first, "now": now, "later": later}))
""")
        self.assertEqual(said["first"], said["now"][0])
        self.assertEqual(said["now"], said["later"])
        self.assertEqual(len({path for path, _ in said["now"]}), 3)
        self.assertNotEqual(said["now"][0][1], said["now"][1][1])

    def test_a_simulation_has_its_objects_and_all_maps(self):
        self.succeeds("synth", "ledge", "--cells", "4", "-o", "ledge")
        self.succeeds("simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "4", "-o", "dirty")
        said = self.blender("""
thing = load("dirty", num_times=2)
parts = [thing] if thing.data else list(thing.children)
inputs = parts[0].data.materials[0].node_tree.nodes["Principled BSDF"].inputs
print("SAID", json.dumps({"linked": [i.name for i in inputs if i.is_linked], "uvs": [len(p.data.uv_layers) for p in parts], "displaced": any(n.type == "DISPLACEMENT" for n in parts[0].data.materials[0].node_tree.nodes)}))
""")
        self.assertLessEqual({"Base Color", "Roughness", "Normal"}, set(said["linked"]))
        self.assertTrue(said["displaced"])
        self.assertEqual(set(said["uvs"]), {1})

    def test_a_changed_result_is_read_again_in_place(self):
        shutil.copytree(self.shared / "history", self.folder / "history")
        self.succeeds("transfer", "history", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", 64, "-o", "aged")
        said = self.blender(f"""
import subprocess
thing = load("aged", num_times=3)
thing.location = (1, 2, 3)
def state():
    nodes = [n for n in thing.data.materials[0].node_tree.nodes if n.type == "TEX_IMAGE"]
    return [len(bpy.data.meshes), len(bpy.data.materials), thing.name, list(thing.location), round(thing.scale[0], 9), len(nodes), nodes[0].image.filepath_from_user(), float(pixels(bpy.path.abspath(nodes[0].image.filepath)).sum()),
            [list(k.co) for c in thing.animation_data.action.fcurves for k in c.keyframe_points]]
states = [state()]
subprocess.run([{PATINATE!r}, "transfer", "history", {str(self.shared / "urn/mesh.obj")!r}, "--control", "facing", "--resolution", "64", "--seed", "5", "-o", "aged", "--force", "--quiet"], check=True)
patinate_blender.reload(thing, program={PATINATE!r})
states.append(state())
patinate_blender.reload(thing, program={PATINATE!r}, num_times=5, scale=2.0)
states.append(state())
print("SAID", json.dumps(states))
""")
        first, again, larger = said
        self.assertEqual(first[:6], again[:6])  # No mesh and no material is left over; place and size stay.
        self.assertNotEqual(first[6:8], again[6:8])
        self.assertEqual(first[8], again[8])
        self.assertAlmostEqual(larger[4], 2 * first[4])
        self.assertIn("-5/", larger[6])

    def test_the_panel_shows_what_is_selected_and_reloads_it(self):
        said = self.blender(f"""
import os
os.environ["PATH"] = {str(pathlib.Path(PATINATE).parent)!r} + ":" + os.environ["PATH"]
patinate_blender.register()
thing = load({str(self.shared / "history")!r}, num_times=2)
bpy.context.view_layer.update()
size = max(thing.dimensions)
bpy.context.view_layer.objects.active = thing
done = list(bpy.ops.object.patinate_reload(num_times=3, scale=1.0))
bpy.context.view_layer.update()
image = bpy.data.images.new("sky", 8, 4, float_buffer=True)
image.filepath_raw, image.file_format = os.path.abspath("sky.hdr"), "HDR"
image.save()
done += list(bpy.ops.world.patinate_environment(filepath=os.path.abspath("sky.hdr"), strength=0.5))
links = [[link.from_node.type, link.to_node.type] for link in scene.world.node_tree.links]

class Layout:  # What a panel may call.
    said = []
    def label(self, text): self.said.append(text)
    def prop(self, owner, path, text): self.said.append(text); assert owner.path_resolve(path) is not None
    def operator(self, name, text=""): self.said.append(name)
class Panel:
    layout = Layout()
patinate_blender.AgingPanel.draw(Panel, bpy.context)
patinate_blender.unregister()
print("SAID", json.dumps([size, max(thing.dimensions), done, links, Layout.said]))
""")
        width = json.loads((self.shared / "history/history.json").read_text())
        self.assertAlmostEqual(said[0], 1, places=5)  # A history of some centimeters is 1 m long until one says otherwise.
        self.assertAlmostEqual(said[1], max(width["width"], width["height"]) * width["texel_size_mm"] / 1000, places=6)
        self.assertEqual(said[2], ["FINISHED", "FINISHED"])
        self.assertIn(["TEX_ENVIRONMENT", "BACKGROUND"], said[3])
        self.assertEqual(said[4], ["history", "Time (s)", "3 images, scale 1", "object.patinate_reload", "import_scene.patinate", "world.patinate_environment"])

    def test_a_blend_that_moves_with_its_textures_finds_them(self):
        shutil.copytree(self.shared / "aged", self.folder / "here/aged")
        shutil.copytree(self.shared / "history", self.folder / "here/history")
        said = self.blender(f"""
import os
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("here/all.blend"))
name = patinate_blender.load(os.path.abspath("here/aged"), program={PATINATE!r}, num_times=2).name
bpy.ops.wm.save_mainfile()
os.rename("here", "there")
bpy.ops.wm.open_mainfile(filepath=os.path.abspath("there/all.blend"))
def found():
    node = next(n for n in bpy.data.objects[name].data.materials[0].node_tree.nodes if n.type == "TEX_IMAGE")
    return os.path.exists(node.image.filepath_from_user()), bpy.data.objects[name]["patinate_path"]
first = found()
patinate_blender.reload(bpy.data.objects[name], program={PATINATE!r}, num_times=3)
print("SAID", json.dumps([first, found(), os.path.exists("here")]))
""")
        self.assertEqual(said, [[True, "//aged"], [True, "//aged"], False])

    def test_what_is_none_of_ours_is_one_line(self):
        said = self.blender("""
lines = []
for path, program in ((".", None), ("nowhere", None), (%r, "no_such_program")):
    try:
        patinate_blender.load(path, program=program or %r, cache="textures")
    except patinate_blender.Failure as failure:
        lines.append(str(failure))
print("SAID", json.dumps(lines))
""" % (str(self.shared / "history"), PATINATE))
        self.assertEqual(len(said), 3)
        self.assertIn("is no transfer, simulation or history", said[0])
        self.assertIn("no_such_program is not found", said[2])

    def test_the_operator_is_in_the_import_menu_and_reports(self):
        said = self.blender(f"""
import addon_utils
patinate_blender.register()
bpy.context.preferences  # As a user: with the program on the PATH.
import os
os.environ["PATH"] = {str(pathlib.Path(PATINATE).parent)!r} + ":" + os.environ["PATH"]
bpy.ops.wm.save_as_mainfile(filepath=bpy.path.abspath({str(self.folder / "scene.blend")!r}))
result = bpy.ops.import_scene.patinate(filepath={str(self.shared / "aged/transfer.json")!r}, num_times=2)
patinate_blender.unregister()
print("SAID", json.dumps([list(result), "aged" in bpy.data.objects]))
""")
        self.assertEqual(said, [["FINISHED"], True])
        self.assertTrue(next(self.folder.glob("patinate_textures/aged-*/aged.textures")).is_dir())

    def test_the_import_dialog_has_images_scale_and_frames(self):
        said = self.blender(f"""
import os
os.environ["PATH"] = {str(pathlib.Path(PATINATE).parent)!r} + ":" + os.environ["PATH"]
patinate_blender.register()
shown = [p.name for p in bpy.ops.import_scene.patinate.get_rna_type().properties if not p.is_hidden and p.identifier not in ("rna_type", "filepath")]
bpy.ops.import_scene.patinate(filepath={str(self.shared / "aged/transfer.json")!r}, num_times=2)
bpy.ops.import_scene.patinate(filepath={str(self.shared / "aged/transfer.json")!r}, num_times=3, scale=50, frame_start=10, frame_end=40)
plain, asked = bpy.data.objects["aged"], bpy.data.objects["aged.001"]
def frames(thing):
    return [int(key.co[0]) for curve in thing.animation_data.action.fcurves for key in curve.keyframe_points]
try:
    backwards = list(bpy.ops.import_scene.patinate(filepath={str(self.shared / "aged/transfer.json")!r}, frame_start=10, frame_end=10))
except RuntimeError as error:
    backwards = str(error)
print("SAID", json.dumps([shown, frames(plain), frames(asked), asked.scale[0] / plain.scale[0], asked["patinate_images"], backwards, len(bpy.data.objects)]))
""")
        self.assertEqual(said[0], ["Images", "Scale", "First frame", "Last frame"])
        self.assertEqual(said[1:3], [[1, 25], [10, 40]])
        self.assertAlmostEqual(said[3], 50, places=4)
        self.assertEqual(said[4], 3)
        self.assertIn("the last frame is 10; expected one after the first, 10", said[5])
        self.assertEqual(said[6], 2)

    def test_the_obj_is_read_by_blenders_importer(self):
        self.succeeds("export", self.shared / "aged", "-o", "urn.obj")
        said = self.blender("""
bpy.ops.wm.obj_import(filepath="urn.obj")
thing = next(o for o in bpy.data.objects if o.type == "MESH")
image = [n.image.filepath for n in thing.data.materials[0].node_tree.nodes if n.type == "TEX_IMAGE"]
print("SAID", json.dumps([thing.name, len(thing.data.uv_layers), thing.data.materials[0].name, image]))
""")
        self.assertEqual(said[:3], ["urn", 1, "material"])
        self.assertTrue(said[3][0].endswith("urn.obj.textures/color.0000.png"))


if __name__ == "__main__":
    unittest.main()
