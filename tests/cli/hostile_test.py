#!/usr/bin/env python3
"""Input that somebody made to do harm, or by mistake: pipes in the place of files, nesting, names, numbers and text beyond measure.
What must come out: the right exit code and one bounded line that a terminal shows as it is, within seconds. Usage: hostile_test.py PATINATE [unittest arguments]
"""
import base64
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from small_scene import make_small_scene

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
IS_SANITIZED = b"__asan_init" in pathlib.Path(PATINATE).read_bytes()
SECONDS = 300 if IS_SANITIZED else 60  # A hang is for ever; the slowest of these takes a second.
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_hostile_"))
SCENE = {
    "format": "patinate.scene", "version": 2, "unit": "mm", "seed": 1, "atlas": {"resolution": 32}, "materials": ["water", "metal", "patina"],
    "appearance": {"water": {"strength": 0.2}, "patina": {"strength": 0.5}}, "objects": [{"name": "plate", "mesh": "plate.obj", "preset": "copper"}],
    "emitters": [{"name": "rain", "shape": "sky", "speed": 300, "spread_deg": 5, "gammatons": 100, "carries": {"water": 0.8}}],
    "rules": ["patina"], "time": {"unit": "h", "per_iteration": 0.2}, "run": {"iterations": 12, "history_every": 3, "controls": ["hits"]}}
PLATE = "v -50 0 0\nv 50 0 0\nv 50 86 -50\nv -50 86 -50\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
LIGHTS = [{"direction": [0.3, 0, 1]}, {"direction": [-0.3, 0, 1]}, {"direction": [0, 0.4, 1]}, {"direction": [0, -0.4, 1]}]


def in_shared(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments), "--quiet"], cwd=SHARED, capture_output=True, text=True)


def setUpModule():
    make_small_scene(PATINATE, SHARED)
    (SHARED / "plate.obj").write_text(PLATE)
    (SHARED / "scene.json").write_text(json.dumps(SCENE))
    result = in_shared("synth", "crackle", "--width", "32", "--height", "32", "--num-frames", "8", "-o", "long_capture")
    assert result.returncode == 0 and in_shared("ingest", "long_capture", "-o", "long").returncode == 0, result.stderr


def tearDownModule():
    shutil.rmtree(SHARED)


def gltf(buffer, num_bytes=36, **more):
    return json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                       "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
                       "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": buffer, "byteLength": num_bytes}], **more})


TRIANGLE = "data:application/octet-stream;base64," + base64.b64encode(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)).decode()


class Hostile(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_hostile_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def take(self, *names):
        for name in names:
            source = SHARED / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, self.folder / name)

    def write(self, name, content):
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / name).write_bytes(content if isinstance(content, bytes) else (content if isinstance(content, str) else json.dumps(content)).encode())

    def changed(self, name, change):
        content = json.loads((self.folder / name).read_text())
        change(content)
        self.write(name, content)

    def run_it(self, *arguments):
        try:
            return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, timeout=SECONDS, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            self.fail(f"{arguments}: does not end")

    def check_shown(self, output, arguments):
        """What a terminal gets is characters of text in lines of bounded length."""
        text = output.decode("utf-8")  # Bytes that are none would raise.
        self.assertEqual(re.findall("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]", text), [], arguments)
        self.assertLessEqual(max(map(len, text.split("\n"))), 2100, arguments)
        self.assertNotRegex(text, r"json\.exception|_M_|std::|filesystem error", arguments)
        return text

    def refuses(self, code, words, *arguments):
        with self.subTest(arguments=arguments):
            result = self.run_it(*arguments, "--quiet")
            errors = self.check_shown(result.stderr, arguments)
            self.assertEqual(result.returncode, code, errors)
            self.assertRegex(errors, r"\Apatinate: error: [^\n]*\n\Z")
            self.assertIn(words, errors)

    def test_only_regular_files_are_read(self):
        self.take("history", "capture", "scene.json", "plate.obj", "urn", "aged")
        os.mkfifo(self.folder / "pipe")
        for target, words in ((self.folder / "pipe", "is a pipe; give a regular file"), ("/dev/zero", "is a device; give a regular file")):
            def link(name):
                (self.folder / name).parent.mkdir(exist_ok=True)
                (self.folder / name).unlink(missing_ok=True)
                (self.folder / name).symlink_to(target)
                return name
            for suffix in ("json", "obj", "ply", "gltf", "glb", "png", "exr", "jpg", "tif", "gif", "mp4", "webm", "nef", "xyz"):
                self.refuses(3, words, "info", link("a." + suffix))
            self.refuses(3, words, "validate", link("a.json"))
            self.refuses(3, words, "control", link("a.obj"), "--kind", "facing", "-o", "x.exr")
            self.refuses(3, words, "control", "plate.obj", "--kind", link("a.exr"), "-o", "x.exr")
            self.refuses(3, words, "transfer", "history", "urn/mesh.obj", "--control", link("a.exr"), "--resolution", 32, "-o", "x")
            self.refuses(3, words, "register", link("a.ply"), link("b.ply"), "-o", "x")
            self.refuses(3, words, "control", "accessibility", link("a.ply"), "-o", "x")
            self.refuses(3, words, "calibrate", "spheres", link("a.json"), "-o", "x.json")
            self.refuses(3, words, "unlight", link("a.json"), "-o", "x")
            self.refuses(3, words, "simulate", link("a.json"), "-o", "x")
            self.refuses(3, words, "fit", "scene.json", "history", "--parameters", link("a.json"), "-o", "x")
            self.refuses(3, words, "synth", "crackle", "--config", link("a.toml"), "-o", "x")
            self.write("mesh.gltf", gltf(link("buffer.bin")))
            self.refuses(3, "is a ", "info", "mesh.gltf")
            self.write("history/frames/0001.exr", b"")
            link("history/frames/0001.exr")
            self.refuses(3, words, "validate", "history")
            self.refuses(3, words, "render", "history", "-o", "x.png")
            link("history/history.json")
            self.refuses(3, words, "info", "history")
            shutil.rmtree(self.folder / "history")
            self.take("history")
            link("capture/frames/0001.png")
            self.refuses(3, words, "ingest", "capture", "-o", "x")
            link("aged/coordinates.exr")
            self.refuses(3, words, "texture", "aged", "--time", 1, "-o", "x.png")
            # Where something is written, what lies there is looked at first.
            for name in ("out.png", "out.glb", "out.mp4", "out.gif"):
                link(name)
                result = self.run_it("export" if name != "out.png" else "render", "history" if name.endswith(("png", "mp4", "gif")) else "aged", "-o", name)
                self.assertIn(result.returncode, (1, 3), result.stderr)
        # Lists of other files, which FFmpeg would open.
        for name, text in (("a.mp4", "ffconcat version 1.0\nfile pipe.mp4\n"), ("b.mkv", "#EXTM3U\n#EXT-X-TARGETDURATION:10\n#EXTINF:10,\npipe.mp4\n#EXT-X-ENDLIST\n"),
                           ("c.mov", b"\x80<MPD profiles='urn:mpeg:dash:profile:isoff-on-demand:2011'></MPD>")):
            (self.folder / name).unlink(missing_ok=True)
            self.write(name, text)
            self.refuses(3, "no movie", "info", name)
        self.write("folder.gltf", gltf("."))
        self.refuses(3, "is a folder", "info", "folder.gltf")

    def test_what_stands_behind_standard_input_counts(self):
        self.take("plate.obj")
        with open(self.folder / "plate.obj") as redirected:
            (self.folder / "stdin.obj").symlink_to("/dev/stdin")
            result = subprocess.run([PATINATE, "info", "stdin.obj"], cwd=self.folder, stdin=redirected, capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("triangles:", result.stdout)
        result = subprocess.run([PATINATE, "info", "stdin.obj"], cwd=self.folder, input=PLATE, capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("is a pipe", result.stderr)

    def test_nesting_ends_in_a_line(self):
        deep = 50_000
        self.write("dots.toml", ".".join("a" * deep) + " = 1\n")
        self.write("table.toml", "[" + ".".join("a" * deep) + "]\nx = 1\n")
        self.write("quoted.toml", "x = \"'\"\ny = '''\n\"'''\n" + ".".join(["\"a\"", "'b'"] * deep) + " = 1\n")
        for name, line in (("dots", 1), ("table", 1), ("quoted", 4)):
            self.refuses(3, f"{name}.toml: line {line}: a key of so many parts", "synth", "crackle", "--config", f"{name}.toml", "-o", "x")
        self.write("brackets.toml", "a = " + "[" * deep + "]" * deep)
        self.write("braces.toml", "a = " + "{a=" * deep + "1" + "}" * deep)
        for name in ("brackets", "braces"):
            self.refuses(3, f"{name}.toml: line 1: ", "synth", "crackle", "--config", f"{name}.toml", "-o", "x")
        self.write("fine.toml", "threads = 1\n[synth]\n# a.b.c.d.e.f.g.h.i.j.k.l\nflavor = \"a.b.c.d.e.f.g.h.i.j.k.l.m.n\"\n")
        self.refuses(3, "`synth` has no such option", "synth", "crackle", "--config", "fine.toml", "-o", "x")
        for name, text in (("arrays", "[" * deep), ("objects", '{"a":' * deep), ("whole", "[" * deep + "]" * deep)):
            self.write(f"{name}.json", text)
            self.refuses(3, f"{name}.json: is nested more than 64 levels deep", "info", f"{name}.json")
            self.write(f"{name}.gltf", text)
            self.refuses(3, "nested more than", "info", f"{name}.gltf")
        self.write("members.json", "{" + ",".join(f'"{i}":0' for i in range(300_000)) + "}")
        self.refuses(3, "/: has more than 4096 members", "info", "members.json")
        # A chain of nodes is no nesting of JSON; nobody walks it by recursion.
        nodes = [{"children": [i + 1]} for i in range(deep)] + [{"mesh": 0}]
        self.write("chain.gltf", gltf(TRIANGLE, nodes=nodes))
        self.assertEqual(self.run_it("info", "chain.gltf").returncode, 0)
        nodes[-1]["children"] = [0]
        self.write("ring.gltf", gltf(TRIANGLE, nodes=nodes))
        self.refuses(3, "nodes must form a tree", "info", "ring.gltf")
        self.take("plate.obj")
        for text in ("(" * 5000 + "1", "-" * 5000 + "1", "min(" * 1500 + "1", "1" + "+1" * 4999):
            result = self.run_it("control", "plate.obj", "--kind", text, "--resolution", 16, "-o", "x.exr", "--quiet", "--force")
            self.assertIn(result.returncode, (0, 2), text[:20])
            self.check_shown(result.stderr, text[:20])
        for suffix, text in (("xml", "<a>" * deep), ("yml", "%YAML:1.0\n---\na: " + "[" * deep), ("yml", "%YAML:1.0\n---\n" + "".join(" " * i + "a:\n" for i in range(2000)))):
            self.write("camera." + suffix, text)
            self.write("unlight.json", {"format": "patinate.unlight", "version": 1, "unit": "mm", "camera": "camera." + suffix, "photos": ["a.png"], "lights": LIGHTS})
            self.refuses(3, "", "unlight", "unlight.json", "-o", "x")

    def test_keys_are_given_once(self):
        self.take("history", "capture", "scene.json", "plate.obj", "aged")
        self.write("parameters.json", {"format": "patinate.parameters", "version": 1, "vary": [{"pointer": "/rules/0/rate", "low": 0.1, "high": 1}]})
        self.write("unlight.json", {"format": "patinate.unlight", "version": 1})
        self.write("calibrate.json", {"format": "patinate.calibrate", "version": 1})
        for name, arguments in (("history/history.json", ("validate", "history")), ("capture/capture.json", ("validate", "capture")), ("aged/transfer.json", ("validate", "aged")),
                                ("scene.json", ("simulate", "scene.json", "-o", "x")), ("parameters.json", ("fit", "scene.json", "history", "--parameters", "parameters.json", "-o", "x")),
                                ("unlight.json", ("unlight", "unlight.json", "-o", "x")), ("calibrate.json", ("calibrate", "spheres", "calibrate.json", "-o", "x.json"))):
            whole = (self.folder / name).read_text()
            self.write(name, re.sub(r'("version": ?\d+)', r'\1, \1', whole, count=1))
            self.refuses(3, "/version: is given twice; keep one of them", *arguments)
            self.write(name, whole)
        text = (self.folder / "history/history.json").read_text()
        self.write("history/history.json", text.replace('"file": "frames/0001.exr"', '"file": "frames/0001.exr", "file": "frames/0002.exr"'))
        self.refuses(3, "/frames/1/file: is given twice", "validate", "history")

    def test_names_that_become_files_stay_in_their_folder(self):
        self.take("history", "aged", "scene.json", "plate.obj", "capture")
        control = json.loads((self.folder / "history/history.json").read_text())["controls"][0]["name"]
        for name in ("../../evil", "a/b", "", ".", "..", ".hidden", "two words", "x" * 129, "a\u0000b"):
            self.changed("history/history.json", lambda h: h["controls"][0].update(name=name))
            self.refuses(3, "/controls/0/name: found", "validate", "history")
            self.refuses(3, "/controls/0/name: found", "history", "factorize", "history", "-o", "x")
        self.changed("history/history.json", lambda h: h["controls"][0].update(name=control))
        self.assertEqual(self.run_it("validate", "history").returncode, 0)
        self.write("scene.json", json.dumps(SCENE).replace('"patina"', '"../evil"').replace('"rules": ["../evil"]', '"rules": []').replace('"hits"', '"../evil.deposited"'))
        self.refuses(3, "/run/controls/0: found", "simulate", "scene.json", "-o", "x")
        self.assertFalse((self.folder.parent / "evil.deposited.exr").exists())

    def test_times_that_cannot_be_computed_with(self):
        self.take("long", "history", "scene.json", "plate.obj")
        whole = (self.folder / "long/history.json").read_text()
        commands = (("validate", "long"), ("info", "long"), ("factorize", "long", "-o", "x"), ("combine", "long", "history", "--clock", "span", "-o", "x"),
                    ("combine", "history", "long", "--clock", "span", "-o", "x"), ("compare", "history", "long", "-o", "x"), ("render", "long", "-o", "x.png"))
        for label, times in (("far", [-1e308, -1, 0, 1, 2, 3, 4, 1e308]), ("subnormal", [i * 5e-324 for i in range(8)]), ("tiny", [i * 1e-300 for i in range(8)]),
                             ("one far", [0, 1, 2, 3, 4, 5, 6, 1.7e308]), ("one near", [0, 5e-324, 1, 2, 3, 4, 5, 6])):
            def set_times(history):
                for frame, time in zip(history["frames"], times):
                    frame["time"] = time
            self.changed("long/history.json", set_times)
            for command in commands:
                self.refuses(3, "has time", *command)
            self.write("long/history.json", whole)
        for time in ("1e308", "-1e308"):
            self.refuses(3, "use -1e18 to 1e18", "history", "factorize", "long", "--times", time, "-o", "x")
        self.refuses(3, "nearly that of the one before", "history", "factorize", "long", "--times", "1e-300", "-o", "x")
        for step in (5e-324, 1e-20):
            self.write("scene.json", {**SCENE, "time": {"per_iteration": step}})
            self.refuses(3, "/time/per_iteration: found", "simulate", "scene.json", "-o", "x")
        self.take("capture")
        self.changed("capture/capture.json", lambda c: c["frames"].update(interval=5e-324))
        self.refuses(3, "time", "ingest", "capture", "-o", "x")
        self.changed("capture/capture.json", lambda c: c["frames"].update(interval=1e308))
        self.refuses(3, "time", "ingest", "capture", "-o", "x")

    def test_cameras_and_scales_beyond_measure(self):
        self.take("history", "urn", "capture")
        frames = sorted((self.folder / "capture/frames").glob("*.png"))[:4]
        camera = {"width": 48, "height": 40, "matrix": [[96, 0, 23.5], [0, 96, 19.5], [0, 0, 1]], "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "translation": [0, 0, 100]}
        step = {"format": "patinate.unlight", "version": 1, "unit": "mm", "camera": camera, "photos": [str(f.relative_to(self.folder)) for f in frames], "lights": LIGHTS}
        for focal in (1e-320, 1e-5, 1e300):
            camera["matrix"][0][0] = focal
            self.write("unlight.json", step)
            self.refuses(3, "focal lengths", "unlight", "unlight.json", "-o", "x")
            self.write("camera.yml", "%YAML:1.0\n---\nimage_width: 48\nimage_height: 40\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ " + repr(focal) +
                       ", 0., 23.5, 0., 96., 19.5, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\nrotation: !!opencv-matrix\n   rows: 3\n"
                       "   cols: 3\n   dt: d\n   data: [ 1., 0., 0., 0., -1., 0., 0., 0., -1. ]\ntranslation: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0., 0., 100. ]\n")
            self.write("unlight.json", {**step, "camera": "camera.yml"})
            self.refuses(3, "focal lengths", "unlight", "unlight.json", "-o", "x")
        # The urn is about 100 units large and a pixel of the history 0.12 mm.
        small = "".join("v " + " ".join(str(0.01 * float(v)) for v in line.split()[1:]) + "\n" if line.startswith("v ") else line + "\n" for line in (self.folder / "urn/mesh.obj").read_text().splitlines())
        self.write("small.obj", small)
        self.refuses(3, "are --unit and --texel-size right?", "transfer", "history", "small.obj", "--unit", "um", "--control", "facing", "-o", "x")
        self.refuses(3, "are --unit and --texel-size right?", "transfer", "history", "small.obj", "--unit", "um", "--control", "facing", "--resolution", 64, "-o", "x")
        for size in ("1e300", "1e-300"):
            self.refuses(2, "--texel-size", "transfer", "history", "urn/mesh.obj", "--texel-size", size, "--control", "facing", "-o", "x")
        self.refuses(3, "are --unit and --texel-size right?", "transfer", "history", "urn/mesh.obj", "--unit", "m", "--texel-size", "1e-7", "--control", "facing", "-o", "x")

    def test_text_of_files_is_shown_as_text(self):
        self.take("history", "scene.json", "plate.obj")
        evil = "\x1b]0;owned\x07\x1b[2J\u009b31m\u202e" + "x" * 3_000_000
        whole = json.loads((self.folder / "history/history.json").read_text())
        self.write("history/history.json", {**whole, evil: 1})
        self.refuses(3, "\\x1b]0;owned\\x07\\x1b[2J\\xc2\\x9b31m\\xe2\\x80\\xaexxx", "validate", "history")
        self.write("history/history.json", {**whole, "name": evil})
        result = self.run_it("info", "history")
        self.assertEqual(result.returncode, 0)
        self.assertIn("\\x1b]0;owned", self.check_shown(result.stdout, "info"))
        self.write("a.toml", f'[synth]\n"{evil[:4]}" = 1\n'.replace("\x1b", "\\u001b"))
        self.refuses(3, "a.toml: line 2", "synth", "crackle", "--config", "a.toml", "-o", "x")
        self.write("a.toml", b"[synth]\nx = \"\x1b[31m\xff\"\n")
        self.refuses(3, "a.toml: line 2", "synth", "crackle", "--config", "a.toml", "-o", "x")
        for name, text in (("a.obj", "v 0 0 0\nf " + evil + "\n"), ("a.ply", "ply\n" + evil + "\n"), ("a.gltf", gltf(evil))):
            self.write(name, text)
            self.refuses(3, name, "info", name)
        self.refuses(2, "\\x1b[31m", "\x1b[31mred")
        self.refuses(3, "\\x1b[31m", "info", "\x1b[31mred.obj")
        self.refuses(3, "\\xff", "info", b"\xff.obj".decode("utf-8", "surrogateescape"))
        self.write("numbers.json", "[1e999999]")
        self.refuses(3, "numbers.json: is no valid JSON: it holds a number too large", "info", "numbers.json")

    def test_libraries_speak_in_our_words(self):
        # A size that nothing can have, a folder in the place of a buffer, fields of other types.
        for num_bytes in (2**62, 2**40):
            self.write("a.gltf", gltf(TRIANGLE, num_bytes))
            self.refuses(3, "a.gltf: is not valid glTF", "info", "a.gltf")
        self.write("registration.json", {"format": "patinate.registration", "version": 2, "unit": "mm", "reference": "a.ply", "scans": [{"file": "a.ply", "status": "reference", "residual": 0, "overlap": 1, "unconstrained_dofs": [],
                   "covariance": [[0] * 6] * 6, "matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}], "pairs": [], "closure": {"median_deg": 0, "median": 0, "largest_deg": 0, "largest": 0}, "key": "k"})
        self.assertEqual(self.run_it("info", "registration.json").returncode, 0)
        for name in ("../a.ply", "a/b.ply", ""):
            self.changed("registration.json", lambda r: (r["scans"][0].update(file=name), r.update(reference=name)))
            self.refuses(3, "the name of a file, without its folder", "info", "registration.json")

    def test_what_is_wrong_in_a_file_of_parameters_is_the_files_fault(self):
        self.take("scene.json", "plate.obj", "history")
        vary = {"pointer": "/rules/0/rate", "low": 0.01, "high": 1}
        for change, words in ((dict(pointer="/rules/0/alfa"), "/vary/0: /rules/0/alfa is not in scene.json"), (dict(pointer="/seed"), "/vary/0: /seed cannot be varied"),
                              (dict(pointer="/emitters/0/name"), "/vary/0: /emitters/0/name is \"rain\""), (dict(low=2), "upside down"), (dict(low="a"), "/vary/0/low"), (dict(pointer="rules"), "a JSON pointer")):
            self.write("p.json", {"format": "patinate.parameters", "version": 1, "vary": [{**vary, **change}]})
            self.refuses(3, words, "fit", "scene.json", "history", "--parameters", "p.json", "-o", "x")
        self.write("p.json", {"format": "patinate.parameters", "version": 1, "vary": [vary, vary]})
        self.refuses(3, "/vary/1: /rules/0/rate is given twice", "fit", "scene.json", "history", "--parameters", "p.json", "-o", "x")
        self.write("p.json", {"format": "patinate.parameters", "version": 1, "vary": []})
        self.refuses(3, "/vary: found an array of 0; expected at least one range", "fit", "scene.json", "history", "--parameters", "p.json", "-o", "x")
        self.write("p.json", {"format": "patinate.parameters", "version": 1, "vary": [vary], "objective": {"color": 1}})
        self.refuses(3, "/objective/color", "fit", "scene.json", "history", "--parameters", "p.json", "-o", "x")

    def test_a_scan_of_one_place_is_a_scan(self):
        self.take("scene.json", "plate.obj")
        self.assertEqual(self.run_it("simulate", "scene.json", "-o", "aged", "--quiet").returncode, 0)
        result = self.run_it("fit", "scene.json", "aged", "--vary", "/appearance/patina/strength=0.1:3", "--scan", 1, "--seeds", 0, "--evaluations", 13, "-o", "fitted", "--quiet")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads((self.folder / "fitted/report.json").read_text())
        self.assertNotEqual(report["parameters"][0]["determination"], "not_examined")


if __name__ == "__main__":
    unittest.main()
