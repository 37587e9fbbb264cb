#!/usr/bin/env python3
"""Runs the binary as a user does, on bad input above all. Usage: basics_test.py PATINATE [unittest arguments]

Every failure is one line `patinate: error: ...` and the right exit code, leaves nothing half-written, and the repaired command
succeeds. What becomes of outputs, and of commands that are stopped, is outputs_test.py's.
"""
import json
import shutil
import struct
import subprocess
import sys
import unittest
import zlib

from command_case import CANNOT, INPUT, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def write_png(path, width, height, gray):
    """8-bit gray; `gray(x, y)` gives the code."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(gray(x, y) for x in range(width)) for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_exr(path, width, height, value):
    """Uncompressed, one float channel Y; `value(x, y)` may be NaN."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<2i", 20000630, 2) + attribute(b"channels", b"chlist", b"Y\0" + struct.pack("<4i", 2, 0, 1, 1) + b"\0")
    head += attribute(b"compression", b"compression", b"\0") + attribute(b"dataWindow", b"box2i", box)
    head += attribute(b"displayWindow", b"box2i", box) + attribute(b"lineOrder", b"lineOrder", b"\0")
    head += attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1.0))
    head += attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
    head += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1.0)) + b"\0"
    row_size = 8 + 4 * width
    offsets = struct.pack(f"<{height}Q", *(len(head) + 8 * height + y * row_size for y in range(height)))
    rows = b"".join(struct.pack("<2i", y, 4 * width) + struct.pack(f"<{width}f", *(value(x, y) for x in range(width)))
                    for y in range(height))
    path.write_bytes(head + offsets + rows)


def setUpModule():
    use(PATINATE)


class CommandLine(CommandCase):
    def test_help_and_version_need_nothing_else(self):
        self.assertIn("Usage:", self.succeeds("--help"))
        self.assertRegex(self.succeeds("--version"), r"^patinate \d+\.\d+\.\d+ \((commit [0-9a-f]{8}( with changes)?|no commit), \w+, \w+ [\d.]+\)\n$")
        for verb in ("ingest", "control", "transfer", "texture", "export", "render", "info", "validate", "synth"):
            with self.subTest(verb=verb):
                self.assertIn(verb, self.succeeds("--help"))
                text = self.succeeds(verb, "--help")
                self.assertIn("Examples:", text)
                self.assertIn("--threads", text)

    def test_misspelt_words_are_named_with_what_was_meant(self):
        self.fails(USAGE, "did you mean `ingest`?", "ingset")
        self.fails(USAGE, "did you mean `--quiet`?", "info", "--quite", "x")
        self.fails(USAGE, "did you mean `crackle`?", "synth", "crackel", "-o", "x")
        self.fails(USAGE, "did you mean `--kind`?", "control", "mesh.obj", "--kinds", "facing", "-o", "x.exr")

    def test_missing_and_surplus_arguments_are_named(self):
        self.fails(USAGE, "no command")
        self.fails(USAGE, "-o", "ingest", "capture.json")
        self.fails(USAGE, "CAPTURE", "ingest", "-o", "x")
        self.fails(USAGE, "too many", "info", "a", "b")
        self.fails(USAGE, "--seed", "info", "a", "--seed")
        self.fails(USAGE, "-o", "info", "a", "-o", "b")

    def test_options_out_of_range_are_usage_errors(self):
        self.take("urn")
        self.fails(USAGE, "--threads", "info", "urn", "--threads", "-1")
        self.fails(USAGE, "--seed", "info", "urn", "--seed", "one")
        self.fails(USAGE, "--width", "synth", "crackle", "--width", "0", "-o", "x")
        self.fails(USAGE, "--noise", "synth", "crackle", "--noise", "nan", "-o", "x")
        self.fails(USAGE, "--law", "synth", "crackle", "--law", "newton", "-o", "x")
        self.fails(USAGE, "3 numbers", "control", "urn/mesh.obj", "--kind", "facing(direction=0,1)", "-o", "x.exr")
        self.fails(USAGE, "--resolution", "control", "urn/mesh.obj", "--kind", "facing", "--resolution", "1e9", "-o", "x.exr")

    def test_negative_numbers_are_values_not_options(self):
        self.take("urn")
        self.succeeds("control", "urn/mesh.obj", "--kind", "facing", "--direction", "-1,0,0", "--resolution", "32", "-o", "x.exr")

    def test_json_is_one_object_on_stdout(self):
        self.assertEqual(json.loads(self.succeeds("info", self.shared / "history", "--json"))["kind"], "history")
        self.assertEqual(json.loads(self.succeeds("validate", self.shared / "aged", "--json"))["valid"], True)
        result = json.loads(self.succeeds("synth", "sculpture", "--resolution", "24", "-o", "x", "--json"))
        self.assertEqual(result, {"output": "x", "status": "done"})

    def test_quiet_says_nothing(self):
        result = self.run_patinate("synth", "sculpture", "--resolution", "24", "-o", "x", "--quiet")
        self.assertEqual((result.stdout, result.stderr, result.returncode), ("", "", 0))

    def test_a_full_disk_under_stdout_is_said(self):
        for arguments in (["info", self.shared / "history"], ["--version"], ["--help"], ["texture", "--help"], ["help"], ["help", "--man"], ["help", "completion", "bash"],
                          ["validate", self.shared / "history"], ["texture", self.shared / "aged", "--time", "1", "-o", self.folder / "x.png", "--dry-run"]):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                result = subprocess.run([self.patinate, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual(result.returncode, CANNOT, result.stderr)
                self.assertEqual(result.stderr.splitlines(), ["patinate: error: standard output: cannot be written; is the disk full?"])

    def test_an_output_that_is_or_holds_an_input_or_lies_in_what_was_made_is_refused(self):
        aged, history = self.take("aged"), self.take("history")
        self.take("urn")
        self.succeeds("control", "urn/mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "when.exr")
        (self.folder / "link").symlink_to(aged)
        before = tree_of(self.folder)
        for about, arguments in (("is an input (--time-map)", ["texture", "aged", "--time-map", "when.exr", "-o", "when.exr"]),
                                 ("is an input (--time-map)", ["texture", "aged", "--time-map", "0.5*when.exr+facing", "-o", "./when.exr"]),
                                 ("is an input (--time-map)", ["texture", "aged", "--time-map", "when.exr", "-o", self.folder / "when.exr"]),
                                 ("lies inside", ["texture", "aged", "--time", "1", "-o", "aged/coordinates.exr"]),
                                 ("lies inside", ["texture", "aged", "--time", "1", "-o", "link/coordinates.exr"]),
                                 ("lies inside", ["texture", "aged", "--time", "1", "-o", "history/frames/0000.exr"]),
                                 ("lies inside", ["render", "history", "-o", "history/picture.png"]),
                                 ("is an input (SUBJECT)", ["export", "aged", "-o", "aged"]),
                                 ("is an input (MESH)", ["transfer", "history", "urn/mesh.obj", "--control", "facing", "-o", "urn/mesh.obj"]),
                                 ("holds an input (MESH)", ["transfer", "history", "aged/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "aged"]),
                                 ("holds an input", ["transfer", "history", "urn/mesh.obj", "--control", "facing", "-o", "."])):
            for force in ([], ["--force"]):
                with self.subTest(arguments=arguments, force=force):
                    self.fails(USAGE, about, *arguments, *force)
        self.assertEqual(tree_of(self.folder), before)
        self.succeeds("texture", "aged", "--time-map", "when.exr", "-o", "made.exr")
        self.assertTrue(history.exists())


class Photographs(CommandCase):
    def damaged_frame(self, damage):
        capture = self.take("capture")
        damage(sorted((capture / "frames").iterdir())[2])
        try:
            return self.fails(INPUT, "frames/0002.png", "ingest", "capture", "-o", "out")
        finally:
            shutil.rmtree(capture)

    def test_truncated_frames(self):
        size = (self.shared / "capture/frames/0002.png").stat().st_size
        for length in (1, 8, 20, 50, size // 2, size - 20):
            with self.subTest(length=length):
                self.damaged_frame(lambda p: p.write_bytes(p.read_bytes()[:length]))

    def test_zero_bytes(self):
        self.damaged_frame(lambda p: p.write_bytes(b""))

    def test_text_named_png(self):
        self.damaged_frame(lambda p: p.write_text("not an image"))

    def test_wrong_size(self):
        self.damaged_frame(lambda p: write_png(p, 47, 40, lambda x, y: 9))

    def test_dangling_link(self):
        self.damaged_frame(lambda p: (p.unlink(), p.symlink_to("nowhere.png")))

    def test_the_repaired_command_succeeds(self):
        capture = self.take("capture")
        frame = capture / "frames/0002.png"
        whole = frame.read_bytes()
        frame.write_bytes(whole[:100])
        self.fails(INPUT, "0002.png", "ingest", "capture", "-o", "out")
        frame.write_bytes(whole)
        self.succeeds("ingest", "capture", "-o", "out")
        self.assertEqual(tree_of(self.folder / "out"), tree_of(self.shared / "history"))

    def test_a_missing_project_file(self):
        self.fails(INPUT, "nowhere.json", "ingest", "nowhere.json", "-o", "out")
        self.take("urn")
        self.fails(INPUT, "capture.json", "ingest", "urn", "-o", "out")

    def test_broken_project_files(self):
        capture = self.take("capture") / "capture.json"
        whole = capture.read_text()
        for text, about in (("", "JSON"), ("{", "JSON"), ("[]", "object"), ("{}", "format"), (whole[:-40], "JSON"),
                            (whole.replace('"kind"', '"knid"'), "kind"), (whole.replace("patinate.capture", "other"), "format")):
            with self.subTest(text=text[:20]):
                capture.write_text(text)
                self.fails(INPUT, about, "ingest", "capture", "-o", "out")

    def test_equal_and_falling_times(self):
        capture = self.take("capture")
        for times in ((0, 1, 1), (0, 2, 1), (float("nan"), 1, 2)):
            with self.subTest(times=times):
                frames = [{"time": t, "photo": f"frames/000{i}.png"} for i, t in enumerate(times)]
                self.edit_json(capture / "capture.json", lambda c: c.update(frames=frames))
                self.fails(INPUT, "capture.json", "ingest", "capture", "-o", "out")

    def test_empty_masks_and_wrong_masks(self):
        capture = self.take("capture")
        self.edit_json(capture / "capture.json", lambda c: c.update(mask="mask.png"))
        self.fails(INPUT, "mask.png", "ingest", "capture", "-o", "out")
        write_png(capture / "mask.png", 48, 40, lambda x, y: 0)
        self.fails(INPUT, "mask.png", "ingest", "capture", "-o", "out")
        write_png(capture / "mask.png", 7, 7, lambda x, y: 255)
        self.fails(INPUT, "mask.png", "ingest", "capture", "-o", "out")
        write_png(capture / "mask.png", 48, 40, lambda x, y: 255 if x > 3 else 0)
        self.succeeds("ingest", "capture", "-o", "out")

    def test_controls_with_nan(self):
        capture = self.take("capture")
        self.edit_json(capture / "capture.json", lambda c: c.update(controls=[{"name": "wet", "file": "wet.exr"}]))
        write_exr(capture / "wet.exr", 48, 40, lambda x, y: float("nan") if (x, y) == (5, 6) else 0.5)
        self.fails(INPUT, "wet.exr", "ingest", "capture", "-o", "out")
        write_exr(capture / "wet.exr", 48, 40, lambda x, y: x / 48)
        self.succeeds("ingest", "capture", "-o", "out")


class Meshes(CommandCase):
    TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    UVS = "vt 0 0\nvt 1 0\nvt 0 1\n"

    def refused(self, text, about="mesh.obj", name="mesh.obj"):
        (self.folder / name).write_text(text)
        self.fails(INPUT, about, "control", name, "--kind", "facing", "--resolution", "32", "-o", "x.exr")

    def test_without_faces(self):
        self.refused(self.TRIANGLE)
        self.refused("")

    def test_with_nan(self):
        self.refused(self.TRIANGLE.replace("v 1", "v nan") + self.UVS + "f 1/1 2/2 3/3\n")
        self.refused(self.TRIANGLE + self.UVS.replace("vt 1", "vt nan") + "f 1/1 2/2 3/3\n")

    def test_with_indices_out_of_range(self):
        self.refused(self.TRIANGLE + self.UVS + "f 1/1 2/2 9/3\n")
        self.refused(self.TRIANGLE + self.UVS + "f 1/1 2/2 3/9\n")

    def test_that_are_something_else(self):
        self.refused("{", name="mesh.gltf", about="mesh.gltf")
        self.refused("ply\nformat ascii 1.0\nelement vertex 999999999\n", name="mesh.ply", about="mesh.ply")
        self.refused("hello", name="mesh.stl", about="mesh.stl")
        self.fails(INPUT, "nowhere.obj", "control", "nowhere.obj", "--kind", "facing", "-o", "x.exr")

    def test_a_whole_triangle_is_accepted(self):
        (self.folder / "mesh.obj").write_text(self.TRIANGLE + self.UVS + "f 1/1 2/2 3/3\n")
        self.succeeds("control", "mesh.obj", "--kind", "facing", "--resolution", "32", "-o", "x.exr")

    def test_surfaces_that_do_not_exist_are_listed(self):
        self.take("urn")
        line = self.fails(INPUT, "", "control", "urn/mesh.obj", "--material", "gold", "--kind", "facing", "-o", "x.exr")
        self.assertIn("clay", line)


class Histories(CommandCase):
    def test_validate_finds_each_damage(self):
        def resize(folder):
            write_exr(folder / "frames/0001.exr", 7, 7, lambda x, y: 0.5)

        def truncate(folder):
            path = folder / "frames/0001.exr"
            path.write_bytes(path.read_bytes()[:-200])

        for damage in (lambda f: (f / "frames/0001.exr").unlink(), lambda f: (f / "frames/0001.exr").write_bytes(b""),
                       resize, truncate, lambda f: (f / "history.json").write_text("{}")):
            history = self.take("history")
            damage(history)
            result = self.run_patinate("validate", "history")
            self.assertEqual(result.returncode, INPUT)
            for line in result.stderr.splitlines():
                self.assertTrue(line.startswith("patinate: error: history"), line)
            self.assertTrue(result.stderr)
            shutil.rmtree(history)

    def test_a_problem_is_one_line_whatever_the_name_of_the_folder(self):
        self.take("history").rename(self.folder / "two\nlines")
        (self.folder / "two\nlines/frames/0001.exr").write_bytes(b"")
        self.fails(INPUT, "two lines/", "validate", "two\nlines")

    def test_unsorted_times(self):
        history = self.take("history")
        self.edit_json(history / "history.json", lambda h: h["frames"].reverse())
        self.fails(INPUT, "history.json", "render", "history", "-o", "x.png")

    def test_a_transfer_whose_history_has_gone(self):
        self.take("aged")
        self.fails(INPUT, "history", "texture", "aged", "--time", "1", "-o", "x.png")

    def test_info_and_validate_refuse_what_is_nothing_of_ours(self):
        (self.folder / "notes.txt").write_text("hello")
        for verb in ("info", "validate"):
            self.fails(INPUT, "notes.txt", verb, "notes.txt")
            self.fails(INPUT, "nowhere", verb, "nowhere")


if __name__ == "__main__":
    unittest.main()
