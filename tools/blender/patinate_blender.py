"""Blender add-on: a transfer, simulation or history of patinate as an object whose material ages with the scene's frame.

File > Import > patinate, or from a script:

    import patinate_blender
    thing = patinate_blender.load("aged_bust")      # the material's time runs over the scene's frames
    thing["patinate_time"]                          # in the history's unit; a curve of it can be edited like any other
"""
import hashlib
import json
import pathlib
import re
import shutil
import subprocess

import bpy
import numpy
from bpy.props import FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

bl_info = {"name": "patinate", "author": "The patinate authors", "version": (0, 1, 0), "blender": (3, 4, 0), "location": "File > Import > patinate",
           "description": "Meshes that age as a photographed or simulated material does", "category": "Import-Export"}

MANIFESTS = ("transfer.json", "simulation.json", "history.json")
# Kinds of maps, and what their pixels are.
COLOR_SPACES = {"color": "sRGB", "normal": "Non-Color", "roughness": "Non-Color", "metalness": "Non-Color", "height": "Non-Color"}


class Failure(Exception):
    """What a user is told."""


# --- Files ---------------------------------------------------------------------------------------------------------


def subject_of(path):
    """(folder, "transfer" | "simulation" | "history") of a folder or of its manifest."""
    path = pathlib.Path(bpy.path.abspath(str(path)))
    folder = path.parent if path.name in MANIFESTS else path
    for manifest in MANIFESTS:
        if (folder / manifest).is_file():
            return folder, manifest.removesuffix(".json")
    raise Failure(f"{folder} is no transfer, simulation or history: it holds no {', '.join(MANIFESTS)}")


def run(program, *arguments):
    """@throws Failure with the one line that patinate says."""
    if not shutil.which(program):
        raise Failure(f"the program {program} is not found; name it in the add-on's preferences")
    result = subprocess.run([program, *map(str, arguments), "--quiet"], capture_output=True, text=True)
    if result.returncode != 0:
        raise Failure((result.stderr.strip().splitlines() or [f"{program} ended with {result.returncode}"])[-1])
    return result.stdout


def numbers_of(text, name, kind):
    """The list that a line of a stage gives `name`."""
    found = re.search(rf"^\s*\S+ {re.escape(name)} = \[(.*?)\]", text, re.MULTILINE)
    return numpy.array(re.findall(r"[^\s,()]+", found[1]), dtype=kind) if found else None


class Stage:
    """What `patinate export -o x.usda` wrote. It is read here, and not by Blender's importer, which follows no textures over time."""

    def __init__(self, path):
        self.folder = path.parent
        text = path.read_text()
        self.meters_per_unit = float(re.search(r"metersPerUnit = (\S+)", text)[1])
        self.time_unit = re.search(r'string time_unit = "([^"]*)"', text)[1]
        self.credits = (re.findall(r'string credits = "([^"]*)"', text) or [""])[0]
        head, *meshes = re.split(r"\n    def Mesh ", text.split("    def Scope \"Materials\"")[0])
        self.meshes = [self.mesh_of(part) for part in meshes]
        self.default_scale = 1.0
        self.materials = dict(self.material_of(part) for part in re.split(r"\n        def Material ", text.split('    def Scope "Materials"')[1])[1:])
        self.times = sorted(next(iter(self.materials.values()))["color"])

    @staticmethod
    def mesh_of(text):
        own, *subsets = text.split("def GeomSubset ")
        mesh = {"name": re.match(r'"(\w+)"', own)[1], "points": numbers_of(own, "points", float).reshape(-1, 3), "corners": numbers_of(own, "faceVertexIndices", int),
                "uvs": numbers_of(own, "primvars:st", float).reshape(-1, 2), "uv_corners": numbers_of(own, "primvars:st:indices", int), "normals": numbers_of(own, "normals", float)}
        parts = subsets or [own]
        mesh["materials"] = [re.search(r"material:binding = <[^>]*/(\w+)>", part)[1] for part in parts]
        mesh["faces"] = [numbers_of(part, "indices", int) for part in subsets]
        return mesh

    def material_of(self, text):
        """Kind of map -> time -> file."""
        maps = {}
        for shader in text.split("def Shader ")[1:]:
            name = re.match(r'"(\w+)"', shader)[1]
            if name not in COLOR_SPACES:
                continue
            samples = re.findall(r"([-+.\de]+): @+([^@]+)@+", shader)
            first = re.search(r"inputs:file = @+([^@]+)@+", shader)[1]
            maps[name] = {float(t): self.folder / file for t, file in samples} or {0.0: self.folder / first}
        color = next(iter(maps["color"].values()))
        heights = {t: file.with_name(file.name.replace("color.", "height.", 1)).with_suffix(".exr") for t, file in maps["color"].items()}
        if all(file.is_file() for file in heights.values()):
            maps["height"] = heights  # Not in UsdPreviewSurface; beside the other maps.
        assert color.is_file(), color
        return re.match(r'"(\w+)"', text)[1], maps


class Sheet:
    """The frames of a history, on a plane: as Stage."""

    def __init__(self, folder, images):
        manifest = json.loads((folder / "history.json").read_text())
        sequence = json.loads((images / "sequence.json").read_text())
        self.time_unit, self.meters_per_unit, self.credits = sequence["time_unit"], 1.0, ""
        width = manifest["width"] * manifest["texel_size_mm"] / 1000 if manifest.get("texel_size_mm") else 1.0
        height = width * manifest["height"] / manifest["width"]
        self.default_scale = 1.0 / max(width, height)  # A photograph of some centimeters would be a speck.
        self.times = [image["time"] for image in sequence["images"]]
        self.materials = {"material": {"color": {image["time"]: images / image["file"] for image in sequence["images"]}}}
        corners = numpy.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
        # In the stage's axes: y up, z to the viewer.
        self.meshes = [{"name": "sheet", "points": numpy.column_stack([(corners - 0.5) * (width, height), numpy.zeros(4)]), "corners": numpy.array([0, 1, 2, 0, 2, 3]),
                        "uvs": corners, "uv_corners": numpy.array([0, 1, 2, 0, 2, 3]), "normals": None, "materials": ["material"], "faces": []}]


def content_key(folder, kind):
    """What tells results of equal names apart: the manifest's content key; of a history that has none, its manifest."""
    manifest = (folder / f"{kind}.json").read_bytes()
    return (json.loads(manifest).get("key") or hashlib.sha256(manifest).hexdigest())[:12]


def export(program, folder, kind, cache, num_times):
    """Textures and geometry in a folder of `cache` that is named by content and number of images: another import, of an equal name or with other times, has files of its own.
    What is there already is not made again."""
    cache = cache / f"{folder.resolve().name}-{content_key(folder, kind)}-{num_times}"
    cache.mkdir(parents=True, exist_ok=True)
    if kind == "history":
        images = cache / f"{folder.name}_images"
        run(program, "export", folder, "--num-times", num_times, "--format", "png", "-o", images, "--force")
        return Sheet(folder, images)
    stage = cache / f"{folder.name}.usda"
    run(program, "export", folder, "--num-times", num_times, "-o", stage, "--force")
    return Stage(stage)


# --- Materials -----------------------------------------------------------------------------------------------------


def drive(target, path, owner, expression):
    """A driver of simple arithmetic, which Blender evaluates without being asked to trust the file."""
    driver = target.driver_add(path).driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "t"
    variable.targets[0].id = owner
    variable.targets[0].data_path = '["patinate_time"]'
    driver.expression = expression


def step_expression(times):
    """Number of the image at or before the time, of images at even times; the last one but one at most, so that one follows."""
    if len(times) < 2:
        return "0"
    span = times[-1] - times[0]
    return f"min({len(times) - 2}, max(0, floor((t - {times[0]!r}) * {(len(times) - 1) / span!r} + 1e-6)))"


def fraction_expression(times):
    span = times[-1] - times[0]
    place = f"min({len(times) - 1}, max(0, (t - {times[0]!r}) * {(len(times) - 1) / span!r}))"
    return f"{place} - {step_expression(times)}"


def from_blend(path):
    """A path as it stays true when the saved .blend moves together with it."""
    return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)


def sequence_node(nodes, material, files, color_space, owner, times, later):
    """The image at the time, or (later) the one that follows."""
    node = nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(from_blend(files[0]), check_existing=True)
    node.image.colorspace_settings.name = color_space
    node.extension = "EXTEND"
    if len(files) < 2:
        return node
    node.image.source = "SEQUENCE"
    user = node.image_user
    # One frame that lasts from long before the scene: the number of the file is 1 + offset.
    user.frame_duration, user.frame_start, user.use_auto_refresh = 1, -100000, True
    first = int(re.search(r"(\d+)\.\w+$", files[0].name)[1])
    drive(material.node_tree, f'nodes["{node.name}"].image_user.frame_offset', owner, f"{step_expression(times)} + {first - 1 + int(later)}")
    return node


def map_output(material, files_at, color_space, owner, times):
    """A map at the object's time: the blend of two images, linear in what they stand for, as `patinate lookup` gives it."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    files = [files_at[t] for t in sorted(files_at)]
    now = sequence_node(nodes, material, files, color_space, owner, times, False)
    if len(files) < 2:
        return now.outputs["Color"]
    following = sequence_node(nodes, material, files, color_space, owner, times, True)
    mix = nodes.new("ShaderNodeMixRGB")
    drive(material.node_tree, f'nodes["{mix.name}"].inputs[0].default_value', owner, fraction_expression(times))
    links.new(now.outputs["Color"], mix.inputs["Color1"])
    links.new(following.outputs["Color"], mix.inputs["Color2"])
    return mix.outputs["Color"]


def make_material(name, maps, owner, times):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = nodes["Principled BSDF"]
    (shader.inputs.get("Specular") or shader.inputs["Specular IOR Level"]).default_value = 0.5  # Its name from Blender 4.0 on.
    outputs = {kind: map_output(material, files_at, COLOR_SPACES[kind], owner, times) for kind, files_at in maps.items()}
    links.new(outputs["color"], shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.8
    for kind, slot in (("roughness", "Roughness"), ("metalness", "Metallic")):
        if kind in outputs:
            links.new(outputs[kind], shader.inputs[slot])
    if "normal" in outputs:
        normal = nodes.new("ShaderNodeNormalMap")
        links.new(outputs["normal"], normal.inputs["Color"])
        links.new(normal.outputs["Normal"], shader.inputs["Normal"])
    if "height" in outputs:
        displacement = nodes.new("ShaderNodeDisplacement")
        displacement.inputs["Midlevel"].default_value, displacement.inputs["Scale"].default_value = 0.0, 1.0
        links.new(outputs["height"], displacement.inputs["Height"])
        if "normal" not in outputs:  # Else relief would be there twice; link it for true displacement, and unlink the normal.
            links.new(displacement.outputs["Displacement"], nodes["Material Output"].inputs["Displacement"])
    for at, node in enumerate(n for n in nodes if n not in (shader, nodes["Material Output"])):
        node.location = (-900 + 300 * (at % 3), 300 - 300 * (at // 3))
    return material


# --- Objects -------------------------------------------------------------------------------------------------------


def make_mesh(described):
    mesh = bpy.data.meshes.new(described["name"])
    corners = described["corners"]
    mesh.from_pydata(described["points"].tolist(), [], corners.reshape(-1, 3).tolist())
    layer = mesh.uv_layers.new(name="st")
    layer.data.foreach_set("uv", described["uvs"][described["uv_corners"]].astype(numpy.float32).ravel())
    for number, faces in enumerate(described["faces"]):
        for face in faces:
            mesh.polygons[face].material_index = number
    if described["normals"] is not None:
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.normals_split_custom_set(described["normals"].reshape(-1, 3).tolist())
        if hasattr(mesh, "use_auto_smooth"):  # Needless from Blender 4.1 on.
            mesh.use_auto_smooth = True
    mesh.update()
    return mesh


def build(owner, described, name, scale):
    """Gives `owner`, or the objects below it, the meshes and materials of `described`, in place of those that they had."""
    found = {part.get("patinate_mesh"): part for part in ([owner] if owner.data else owner.children)}
    if set(found) != {mesh["name"] for mesh in described.meshes}:
        raise Failure(f"{name} consists of other objects now; import it again")
    parts = [found[mesh["name"]] for mesh in described.meshes]
    before = [(part.data, list(part.data.materials)) for part in parts]
    owner["patinate_time_unit"] = described.time_unit
    owner["patinate_scale"] = scale
    if described.credits:
        owner["patinate_credits"] = described.credits
    first, last = float(described.times[0]), float(described.times[-1])
    owner["patinate_time"] = min(max(owner.get("patinate_time", first), first), last)
    owner.id_properties_ui("patinate_time").update(description=f"Time of the material, {described.time_unit}", min=first, max=last)
    owner.scale = [described.meters_per_unit * scale] * 3
    materials = {key: make_material(f"{name}_{key}", maps, owner, described.times) for key, maps in described.materials.items()}
    for part, mesh in zip(parts, described.meshes):
        part.data = make_mesh(mesh)
        for key in mesh["materials"]:
            part.data.materials.append(materials[key])
    for mesh, old in before:
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
        for material in old:
            if material and material.users == 0:
                bpy.data.materials.remove(material)


def read(path, program, num_times, cache):
    """@returns what was exported, the folder, and where textures lie."""
    folder, kind = subject_of(path)
    beside = pathlib.Path(bpy.data.filepath).parent if bpy.data.filepath else folder.resolve().parent
    cache = (pathlib.Path(bpy.path.abspath(str(cache))) if cache else beside / "patinate_textures").absolute()
    return export(program or default_program(), folder, kind, cache, num_times), folder.resolve(), cache


def load(path, program=None, num_times=24, frame_start=None, frame_end=None, cache=None, scale=None):
    """Adds a transfer, simulation or history to the scene.

    @param path  Its folder or manifest. @param num_times  Images over its span; between them they are blended. @param frame_start, frame_end  Scene frames of its first and last time; the scene's own when not given.
    @param cache  Where textures go; beside the .blend file, or beside `path` where that is not saved yet. @param scale  Size in the scene over true size; not given: 1, but a history becomes 1 m long.
    @returns the object, or the empty that holds several; its property `patinate_time` is what the materials follow.
    @throws Failure
    """
    scene = bpy.context.scene
    frame_start = scene.frame_start if frame_start is None else frame_start
    frame_end = scene.frame_end if frame_end is None else frame_end
    if frame_end <= frame_start:
        raise Failure(f"the last frame is {frame_end}; expected one after the first, {frame_start}")
    described, folder, cache = read(path, program, num_times, cache)
    thing = [bpy.data.objects.new(folder.name if len(described.meshes) == 1 else mesh["name"], bpy.data.meshes.new(mesh["name"])) for mesh in described.meshes]
    owner = thing[0] if len(thing) == 1 else bpy.data.objects.new(folder.name, None)
    owner.rotation_euler = (numpy.pi / 2, 0, 0)  # Up is y there, z here.
    for part, mesh in zip(thing, described.meshes):
        part["patinate_mesh"] = mesh["name"]
        if part != owner:
            part.parent = owner
    owner["patinate_path"], owner["patinate_cache"], owner["patinate_images"] = from_blend(folder), from_blend(cache), num_times
    build(owner, described, folder.name, scale or described.default_scale)
    for part in dict.fromkeys([owner, *thing]):
        scene.collection.objects.link(part)
    times = described.times
    for frame, time in ((frame_start, times[0]), (frame_end, times[-1])):
        owner["patinate_time"] = float(time)
        owner.keyframe_insert('["patinate_time"]', frame=frame)
    for curve in owner.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.frame_set(scene.frame_current)
    return owner


def reload(thing, program=None, num_times=None, scale=None):
    """Reads what `load()` made again from its folder, with as many images and in the scale it has, or others. Place, parent and the curve of its time stay.

    @throws Failure
    """
    if "patinate_path" not in thing:
        raise Failure(f"{thing.name} was not imported from patinate")
    num_times = num_times or thing["patinate_images"]
    described, folder, _ = read(thing["patinate_path"], program, num_times, thing["patinate_cache"])
    build(thing, described, folder.name, scale or thing["patinate_scale"])
    thing["patinate_images"] = num_times
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)


def set_environment(path, strength=1.0):
    """Lights the scene with a picture of its surroundings: 360 x 180 degrees, HDR or EXR."""
    world = bpy.context.scene.world or bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes = world.node_tree.nodes
    picture = nodes.get("patinate environment") or nodes.new("ShaderNodeTexEnvironment")
    picture.name, picture.location = "patinate environment", (-300, 300)
    try:
        picture.image = bpy.data.images.load(from_blend(path), check_existing=True)
    except RuntimeError as error:
        raise Failure(str(error).strip()) from None
    background = next((node for node in nodes if node.type == "BACKGROUND"), None) or nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = strength
    output = next((node for node in nodes if node.type == "OUTPUT_WORLD"), None) or nodes.new("ShaderNodeOutputWorld")
    world.node_tree.links.new(picture.outputs["Color"], background.inputs["Color"])
    world.node_tree.links.new(background.outputs["Background"], output.inputs["Surface"])


# --- Blender -------------------------------------------------------------------------------------------------------


def default_program():
    addon = bpy.context.preferences.addons.get(__name__)
    return addon.preferences.program if addon else "patinate"


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: StringProperty(name="patinate", description="The program", default="patinate", subtype="FILE_PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


class ImportAging(bpy.types.Operator, ImportHelper):
    """Add a transfer, simulation or history of patinate: choose its transfer.json, simulation.json or history.json"""

    bl_idname = "import_scene.patinate"
    bl_label = "Import patinate"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    num_times: IntProperty(name="Images", description="Over its span; between them they are blended", default=24, min=1, max=9999)
    scale: FloatProperty(name="Scale", description="Size in the scene over true size; 0: true size, but a history becomes 1 m long", default=0, min=0, max=1e6)
    frame_start: IntProperty(name="First frame", description="Frame of the scene at the first time", options={"SKIP_SAVE"})
    frame_end: IntProperty(name="Last frame", description="Frame of the scene at the last time", options={"SKIP_SAVE"})

    def invoke(self, context, event):
        for name in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(context.scene, name))
        return ImportHelper.invoke(self, context, event)

    def execute(self, _context):
        frames = {name: getattr(self, name) for name in ("frame_start", "frame_end") if self.properties.is_property_set(name)}
        try:
            load(self.filepath, num_times=self.num_times, scale=self.scale or None, **frames)
        except Failure as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


def owner_of(thing):
    """What load() gave: the object, or the empty above it."""
    while thing and "patinate_path" not in thing:
        thing = thing.parent
    return thing


class ReloadAging(bpy.types.Operator):
    """Read the object again from its folder, with another number of images or in another size"""

    bl_idname = "object.patinate_reload"
    bl_label = "Reload"
    bl_options = {"REGISTER", "UNDO"}
    num_times: IntProperty(name="Images", description="Over its span; between them they are blended", default=24, min=1, max=9999)
    scale: FloatProperty(name="Scale", description="Size in the scene over true size", default=1, min=1e-6, max=1e6)

    @classmethod
    def poll(cls, context):
        return owner_of(context.object) is not None

    def invoke(self, context, _event):
        thing = owner_of(context.object)
        self.num_times, self.scale = thing["patinate_images"], thing["patinate_scale"]
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            reload(owner_of(context.object), num_times=self.num_times, scale=self.scale)
        except Failure as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


class SetEnvironment(bpy.types.Operator, ImportHelper):
    """Light the scene with a picture of its surroundings: 360 x 180 degrees, HDR or EXR"""

    bl_idname = "world.patinate_environment"
    bl_label = "Environment"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".hdr"
    filter_glob: StringProperty(default="*.hdr;*.exr", options={"HIDDEN"})
    strength: FloatProperty(name="Strength", default=1, min=0)

    def execute(self, _context):
        try:
            set_environment(self.filepath, self.strength)
        except Failure as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


class AgingPanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_patinate"
    bl_label = "patinate"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "patinate"

    def draw(self, context):
        layout, thing = self.layout, owner_of(context.object)
        if thing:
            layout.label(text=pathlib.Path(bpy.path.abspath(thing["patinate_path"])).name)
            layout.prop(thing, '["patinate_time"]', text=f"Time ({thing['patinate_time_unit']})")
            layout.label(text=f"{thing['patinate_images']} images, scale {thing['patinate_scale']:.3g}")
            layout.operator(ReloadAging.bl_idname)
        else:
            layout.label(text="Select an imported object, or import one")
        layout.operator(ImportAging.bl_idname, text="Import")
        layout.operator(SetEnvironment.bl_idname)


def menu_entry(self, _context):
    self.layout.operator(ImportAging.bl_idname, text="patinate (transfer.json, simulation.json, history.json)")


CLASSES = (Preferences, ImportAging, ReloadAging, SetEnvironment, AgingPanel)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
