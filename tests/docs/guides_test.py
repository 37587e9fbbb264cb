#!/usr/bin/env python3
"""The command lines of the guides, run in order on small data that goes by the names that a page uses. Usage: guides_test.py PATINATE [unittest arguments]

A line keeps its options; sizes and counts are made smaller (SMALL for what it leaves open, SMALLER for what it says). Blocks marked ```sh are commands_test.py's.
"""
import base64
import json
import math
import os
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import calibration_scene as rig  # noqa: E402
from small_scene import PLATE, PLATE_SCENE  # noqa: E402

PATINATE = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate").resolve()
# As a user's environment would say it: options that a line leaves open.
SMALL = {"RESOLUTION": 64, "ITERATIONS": 12, "HISTORY_EVERY": 4, "EVALUATIONS": 30, "APPEARANCE_EVALUATIONS": 3, "SEEDS": 2, "STARTS": 1, "NUM_RESAMPLES": 20, "WIDTH": 64, "HEIGHT": 56, "SAMPLES": 1,
         "OCCLUSION_SAMPLES": 4, "NUM_FRAMES": 5, "CELLS": 4, "PERMUTATIONS": 99}
SMALLER = {"resolution": 64, "width": 64, "height": 64, "num-frames": 5, "num-times": 3, "frames": 3, "size": 64}
# What stands for a file in a line that says how a command is used.
NAMES = {"TRANSFER": "aged", "SIMULATION": "rain", "HISTORY": "copper", "MESH": "bust.obj", "SOURCE": "progress", "DESTINATION": "facing", "FOLDER": "photos"}
# Lines by how they begin.
NOT_RUN = {
    "patinate studio results$": "serves until it is stopped; tests/cli/studio_test.py asks it",
    "patinate studio plate/capture.json": "serves until it is stopped; tests/studio/landmarks_test.mjs clicks in it",
    "patinate cluster run copper.json --threads": "a job of Slurm; tests/slurm runs one",
    "patinate control explain fire_hydrant": "its scans and masks are real data; tests/cli/explain_test.py runs the same options",
    "patinate register bunny/": "the scans are Stanford's; tests/cli/register_test.py reads such a .conf"}

# What each page's commands find. `made` holds what MADE makes once.
MADE = """
patinate synth crackle --num-frames 12 --width 64 --height 56 -o crackle
patinate ingest crackle/capture.json -o paint
mkdir photos
cp crackle/frames/*.png photos
patinate init photos
sed -i 's/"interval":1/"interval":44/' photos/capture.json
patinate ingest photos/capture.json -o copper
patinate synth crackle --num-frames 12 --width 64 --height 64 -o square
sed -i 's/"interval": *7.5/"interval":44/' square/capture.json
patinate ingest square/capture.json -o square_copper
patinate synth sculpture --resolution 24 -o urn
patinate transfer copper urn/mesh.obj --control accessibility --resolution 64 -o aged
patinate lookup aged --time 484 -o aged.png
patinate lookup aged --time 0 -o clean.png
patinate export aged --time 0 -o urn.glb
patinate control urn/mesh.obj --kind height --resolution 64 -o age.exr
patinate synth ledge --cells 4 -o ledge
patinate simulate ledge/scene.json --resolution 64 --iterations 12 --history-every 4 --controls hits -o rain
patinate synth mold --width 64 --height 56 -o mold
"""
COPPER = "cp -r $made/copper $made/photos . && cp $made/urn/mesh.obj bust.obj && cp $made/urn.glb bust.glb && cp $made/urn.gltf hydrant.gltf"
MANY = "copper_lab copper_outdoors copper_simulated hydrant_simulated banana"
# Commands that put what a page names where it looks for it.
PAGES = {
    "README.md": "mkdir photos && cp $made/crackle/frames/*.png photos && cp $made/urn/mesh.obj object.obj",
    "docs/synthetic.md": "true",
    "docs/python.md": "true",
    "docs/configuration.md": COPPER + " && printf '[transfer]\\ncontrol = [\"accessibility\"]\\n' >run.toml && mv copper before && cp -r before copper && mkdir -p .local/share/bash-completion/completions .zfunc .config/fish/completions",
    "docs/output.md": COPPER + " && cp -r $made/aged $made/rain $made/ledge $made/paint . && cp $made/sky.hdr .",
    "docs/unlighting.md": "cp -r $made/mold . && cp $made/step.json .",
    "docs/calibration.md": "cp $made/rig/* .",
    "docs/devices.md": "true",
    "docs/grading.md": f"cp {ROOT / 'analysis/grading/assets/grades.json'} $made/marked.png . && mkdir rear && cp $made/photos/*.png rear && "
                       "for i in 1 2 3 4; do for name in coated bare; do env -u PATINATE_WIDTH -u PATINATE_HEIGHT patinate synth panel --width 400 --height 300 --num-frames 3 --scribe "
                       "--seed $i$((${#name})) -o made_$name$i; patinate ingest made_$name$i -o ${name}_$i; done; done",
    "docs/compare.md": COPPER + f" && for name in {MANY}; do cp -r copper $name; done; cp -r $made/aged copper_hydrant; "
                       # Replicates have to be different histories.
                       "for i in 1 2 3 4; do patinate history appearance copper --roughness 0.$i -o copper_$i; patinate history appearance copper --specular 0.$i -o simulated_$i; done",
    "docs/simulation.md": "mkdir -p docs/examples && cp -r $made/scenes docs/examples && cp $made/ledge/* . && cp scene.json hydrant.json && cp -r $made/copper . && cp $made/urn.gltf hydrant.gltf",
    "docs/studies/crack_cells.md": "cp $made/plate.obj .",
    # What stays, as large as the maps are.
    "docs/relief.md": "cp $made/scans/* . && patinate register day00.ply day30.ply day90.ply --unit mm -o first && patinate relief first --times 0,30,90 -o sized && "
                      "oiiotool $(ls sized/change/*.png | head -n 1) --ch R --mulc 0 --addc 1 -d uint8 -o stays.png",
    "docs/capture.md": "cp -r $made/copper $made/photos . && cp photos/* . && rm photos/capture.json && cp -r copper bronze && cp $made/copper_and_patina.json .",
    "docs/factorize.md": COPPER,
    "docs/cluster.md": COPPER + " && cp $made/study.json . && mkdir meshes && cp bust.obj meshes",
    "docs/study.md": "mkdir meshes",
    "docs/explain.md": COPPER + " && cp $made/aged.png aged.jpg && cp $made/clean.png clean.jpg && cp $made/aged.png bust_diff.jpg && cp $made/mask.png paint.png && cp $made/view.png photo.jpg && cp $made/camera.yml . && cp $made/urn.ply statue.ply",
    "docs/library.md": COPPER + " && cp $made/urn/mesh.obj object.obj && cp $made/crackle/frames/0003.png photo.jpg && cp -r copper my_history",
    "docs/transfer.md": COPPER + " && cp -r copper clay && cp -r $made/paint crackle && cp $made/strokes.json . && cp bust.obj vase.obj && cp $made/urn/mesh.obj asset.obj && cp $made/mask.png which.png && mkdir maps && cp $made/age.exr maps",
    # Places of a plate's atlas are square.
    "docs/fit.md": COPPER + " && rm -r copper && cp -r $made/square_copper copper && cp $made/plate.json $made/plate.obj $made/ranges.json . && cp plate.json one_layer.json && cp plate.json two_layers.json && cp -r copper open && cp -r copper shaded",
    "docs/registration.md": "cp $made/scans/* . && mkdir scans && cp day*.ply scans",
    "docs/meshes.md": COPPER + " && cp $made/urn.ply scan.ply",
    "docs/controls.md": COPPER,
    "docs/scaling.md": "cp -r $made/photos .",
    "docs/studio.md": "mkdir results && cp -r $made/aged $made/copper results",
}


# urn/mesh.obj as urn.ply, which has no UVs.
TO_PLY = '''
rows = [line.split() for line in open("urn/mesh.obj")]
points = [row[1:4] for row in rows if row and row[0] == "v"]
faces = [[str(int(corner.split("/")[0]) - 1) for corner in row[1:]] for row in rows if row and row[0] == "f"]
with open("urn.ply", "w") as out:
    print("ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz"), f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", sep="\\n", file=out)
    for row in points:
        print(*row, file=out)
    for row in faces:
        print(len(row), *row, file=out)
'''


# Of small objects in a photograph enough texels have to be seen.
MORE = {"docs/explain.md": {"PATINATE_RESOLUTION": "128"}}


def smaller(line, page=""):
    for option, number in SMALLER.items():
        line = re.sub(rf"--{option} \d+", f"--{option} {number}", line)
    line = re.sub(r"--items 0-\d+", "--items 0-13", line)  # As many as the small capture has.
    line = re.sub(r"--at \d+,\d+", "--at 12,8", line)
    if re.match("patinate synth (ledge|fence|panel)", line):  # Whose width is a length, or which has an edge of 10 mm.
        line = "env -u PATINATE_WIDTH -u PATINATE_HEIGHT " + line
    for name, stands_for in {**NAMES, **({"HISTORY": "paint"} if page == "docs/output.md" else {})}.items():
        line = re.sub(rf"(?<![\w-]){name}(?![\w-])", stands_for, line)
    return line


def commands_of(page):
    """Lines of indented blocks that run the program, and the `cp` between them."""
    lines = []
    for block in re.findall(r"(?:^ {4}.*\n)+", page.read_text(), re.MULTILINE):
        rows = [row[4:] for row in block.splitlines()]
        if any(re.match(r"(PATINATE_\w+=\S+ )*patinate ", row) for row in rows):
            lines += [row for row in rows if re.match(r"(PATINATE_\w+=\S+ )*patinate |cp |sed ", row)]
    return lines


def write_studies(page, folder):
    """The studies that a page shows whole, under the names by which it runs them."""
    text = page.read_text()
    blocks = [block for block in re.findall(r"(?:^ {4}.*\n)+", text, re.MULTILINE) if '"patinate.study"' in block]
    for block, name in zip(blocks, dict.fromkeys(re.findall(r"patinate study run (\S+)", text))):
        study = json.loads(block)
        for part in study.values():
            if isinstance(part, dict):
                if "histories" in part and "scenes" in part:
                    continue  # A fit takes its size from the scene.
                part["options"].update(resolution=64, **({"iterations": 4} if "scenes" in part else {}))
                for output in part["outputs"]:
                    if output["command"] == "evaluate":
                        output["options"] = {"samples": 500}
        (folder / name).write_text(json.dumps(study))


def make(folder, run):
    """What all pages draw from, in `folder`."""
    run(MADE)
    run("oiiotool --pattern constant:color=0.4,0.5,0.7 32x16 3 -o sky.hdr")
    glb = (folder / "urn.glb").read_bytes()
    size = struct.unpack_from("<I", glb, 12)[0]
    content = json.loads(glb[20:20 + size])
    data = glb[28 + size:28 + size + content["buffers"][0]["byteLength"]]
    content["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    content["nodes"][0]["name"] = content["materials"][0]["name"] = "fire_hydrant"
    (folder / "urn.gltf").write_text(json.dumps(content))
    # Within the largest spot of rust on the guide's panel.
    rig.write_png(folder / "marked.png", 600, 400, lambda x, y: 1.0 if 115 <= x < 150 and 50 <= y < 85 else 0.0)
    rig.write_png(folder / "mask.png", 64, 64, lambda x, y: 1.0 if x < 40 else 0.0)
    (folder / "plate.obj").write_text(PLATE)
    plate = {**PLATE_SCENE, "run": {"iterations": 12, "history_every": 3}}
    (folder / "plate.json").write_text(json.dumps(plate))
    (folder / "ranges.json").write_text(json.dumps({"format": "patinate.parameters", "version": 1, "vary": [{"pointer": "/rules/0/rate", "low": 0.01, "high": 10, "scale": "log"}]}))
    (folder / "study.json").write_text(json.dumps({"format": "patinate.study", "version": 1, "name": "copper", "transfer": {
        "histories": ["copper"], "meshes": ["meshes/*.obj"], "controls": ["accessibility"], "options": {"resolution": 64}}}))
    (folder / "copper_and_patina.json").write_text(json.dumps({"format": "patinate.appearance", "version": 1, "materials": [
        {"color": "#f0e8d8", "metalness": 1, "roughness": 0.3}, {"color": "#302010", "metalness": 0, "roughness": 0.9}]}))
    (folder / "strokes.json").write_text(json.dumps({"format": "patinate.edits", "version": 1, "edits": [
        {"kind": "stroke", "control": "thickness", "value": 0.9, "flow": 0.5, "radius_mm": 60, "points_mm": [[0, 0, 0]]}, {"kind": "refine"}]}))
    shutil.copytree(ROOT / "docs/examples/scenes", folder / "scenes")
    make_scans(folder / "scans")
    make_rig(folder / "rig")
    mold = json.loads((folder / "mold/capture.json").read_text())
    at = lambda name: f"mold/{name}"
    step = mold["steps"][0]
    (folder / "step.json").write_text(json.dumps({"format": "patinate.unlight", "version": 1, "name": "day 0", "unit": "mm", "response": mold["response"], "camera": mold["camera"] if isinstance(mold["camera"], dict) else at(mold["camera"]),
                                                  "lights": mold["lights"], "scan": at(step["scan"]), "photos": [at(photo) for photo in step["photos"]], "ambient": at(step["ambient"])}))
    # A photograph of the urn, and the camera that took it.
    run("patinate calibrate camera rig/view.json --lens none -o camera.yml")
    rig.write_png(folder / "view.png", 240, 180, lambda x, y: 0.2 + 0.6 * y / 180)
    run("python3 - <<'PY'\n" + TO_PLY + "PY\n")


def make_scans(folder):
    """Points of one plate that is worn a little more from scan to scan, and where it is not."""
    folder.mkdir()
    chance = random.Random(1)
    for day, lost in ((0, 0.0), (7, 0.0), (14, 0.02), (30, 0.05), (90, 0.1)):
        points = []
        for _ in range(9000):
            x, y = chance.uniform(-7, 7), chance.uniform(-7, 7)
            z = 0.3 * math.sin(1.1 * x + 0.5 * y) + 0.2 * math.cos(0.8 * y) - lost * math.exp(-(x - 1) ** 2 - y ** 2)
            points.append(f"{x:.6f} {y:.6f} {z + chance.gauss(0, 0.005):.6f}")
        head = ["ply", "format ascii 1.0", f"element vertex {len(points)}", "property double x", "property double y", "property double z", "end_header"]
        (folder / f"day{day:02d}.ply").write_text("\n".join(head + points) + "\n")


def make_rig(folder):
    """What docs/calibration.md describes, drawn by formulas."""
    folder.mkdir()
    down = rig.rotation([1, 0, 0], math.pi)
    described = lambda kind, **more: {"format": "patinate.calibrate", "version": 1, "kind": kind, **more}
    for i in range(6):
        turn = rig.rotation([math.cos(1.7 * i), math.sin(1.7 * i), 0], 0.5)
        camera = rig.Pinhole(240, 180, 300.0, turn, None)
        camera.shift = rig.add([0, 0, 190.0], rig.times(turn, [40, 25, 0]), -1)
        rig.write_png(folder / f"board{i}.png", camera.width, camera.height, rig.chessboard(camera, 9, 6, 10.0))
    rig.save(folder / "board.json", described("camera", unit="mm", target={"chessboard": [9, 6], "spacing": 10}, views=[f"board{i}.png" for i in range(6)]))
    camera = rig.Pinhole(240, 180, 300.0, down, [0.0, 0.0, 400.0])
    balls = [([-90.0, 50.0, 30.0], 30.0), ([90.0, -40.0, 30.0], 30.0)]
    rig.write_png(folder / "lamp.png", 240, 180, rig.mirror_spheres(camera, balls, [120.0, 80.0, 330.0], 15.0))
    for i, ball in enumerate(balls):
        rig.write_png(folder / f"mask{i}.png", 240, 180, rig.sphere_mask(camera, *ball))
    rig.save(folder / "rig.json", described("spheres", unit="mm", camera=camera.json(), response="linear", spheres=[{"radius": 30, "mask": f"mask{i}.png"} for i in range(2)], lights=["lamp.png"]))
    near, lights, poses = rig.Pinhole(96, 72, 240.0, down, [0.0, 0.0, 500.0]), [[150.0, 60.0, 300.0], [-120.0, 130.0, 340.0]], []
    for i, normal in enumerate([[0, 0, 1], [0.4, 0, 1], [-0.3, 0.3, 1], [0, -0.4, 1]]):
        photos = [f"pose{i}_{k}.png" for k in range(2)]
        for photo, light in zip(photos, lights):
            rig.write_png(folder / photo, 96, 72, rig.lit_plane(near, [0, 0, 4.0 * i], normal, light, 2e5))
        poses.append({"plane": {"point": [0, 0, 4.0 * i], "normal": normal, "side": 1000}, "photos": photos})
    rig.save(folder / "plane.json", described("lambertian", unit="mm", camera=near.json(), response="linear", lights=["left", "right"], poses=poses))
    srgb = lambda v: 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055
    for i, exposure in enumerate([0.25, 0.5, 1, 2, 4]):
        rig.write_png(folder / f"exposure{i}.png", 120, 60, lambda x, y: srgb(min(1.0, exposure * 0.002 * 500 ** ((x + y / 60) / 120))))
    rig.save(folder / "series.json", described("response", photos=[{"photo": f"exposure{i}.png", "exposure": e} for i, e in enumerate([0.25, 0.5, 1, 2, 4])]))
    rig.write_png(folder / "lightbox.png", 80, 60, lambda x, y: 0.8)
    rig.write_png(folder / "backlight.png", 80, 60, lambda x, y: 0.8 * math.exp(-0.02 * x))
    rig.write_png(folder / "layer.png", 80, 60, lambda x, y: 1.0)
    points = [[x, y, (x * y) % 31] for x in (-60, -20, 30, 70) for y in (-50, 10, 45)]
    rig.save(folder / "view.json", described("camera", unit="mm", width=240, height=180, scanner={"points": points, "pixels": [camera.pixel(p) for p in points]}))


class Guides(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_guides_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.made = cls.folder / "made"
        cls.made.mkdir()
        bin_folder = cls.folder / "bin"
        bin_folder.mkdir()
        for name in ("man", "xdg-open"):  # documents_test.py shows the page to the real one.
            (bin_folder / name).write_text("#!/bin/sh\nexec cat\n")
            (bin_folder / name).chmod(0o755)
        cls.environment = {"HOME": str(cls.folder), "LC_ALL": "C.UTF-8", "PATH": f"{PATINATE.parent}{os.pathsep}{bin_folder}{os.pathsep}{os.environ['PATH']}", "made": str(cls.made),
                           "PATINATE_LIBRARY": str(cls.folder / "library")}
        make(cls.made, lambda code: cls.run_code(code, cls.made, {}))
        (cls.folder / "library").mkdir()
        (cls.folder / "library/rust").symlink_to(cls.made / "copper")
        builder = pathlib.Path(__file__).resolve().parents[2] / "tools/library/build"
        subprocess.run([builder, cls.folder / "library", "--patinate", PATINATE, "--size", "64", "--only", "crackle_thick", "copper"], check=True, capture_output=True)

    @classmethod
    def run_code(cls, code, folder, more):
        result = subprocess.run(["bash", "-euo", "pipefail", "-c", code], cwd=folder, env={**cls.environment, **more}, capture_output=True, text=True, timeout=600)
        if result.returncode:
            raise AssertionError(f"exit code {result.returncode}\n{code}\n{result.stdout[-1000:]}{result.stderr[-2000:]}")

    def test_every_command_of_every_guide_runs(self):
        pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
        found = {str(page.relative_to(ROOT)): commands_of(page) for page in pages if page.name != "commands.md"}  # Made by the program, as --help.
        left_out = set()
        num_run = 0
        for page, lines in found.items():
            with self.subTest(page=page):
                lines = [line for line in lines if not any(re.match(begin, line) and not left_out.add(begin) for begin in NOT_RUN)]
                if not any("patinate " in line for line in lines):
                    continue
                self.assertIn(page, PAGES, "says what its commands find")
                folder = self.folder / page.replace("/", "_")
                folder.mkdir()
                self.run_code(PAGES[page], folder, {})
                write_studies(ROOT / page, folder)
                small = {f"PATINATE_{name}": str(value) for name, value in SMALL.items()}
                # What one line makes may be in the way of the next, which shows another way to make it.
                code = "cd . \n" + "".join(f"{clear(line)}{smaller(line, page)}\n" for line in lines)
                self.run_code(code, folder, {**small, **MORE.get(page, {}), "HOME": str(folder)})
                num_run += len(lines)
        self.assertEqual(left_out, set(NOT_RUN))
        self.assertGreater(num_run, 90)


def clear(line):
    output = re.search(r" -o (\S+)", line)
    return f"rm -rf {smaller(output[1])}\n" if output and "--dry-run" not in line else ""


if __name__ == "__main__":
    unittest.main()
