#!/usr/bin/env python3
"""What a finished or interrupted output is worth to the next command, and what --dry-run says. Usage: job_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from small_scene import make_small_scene

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_job_"))


def run(*arguments, cwd=SHARED):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120)


def setUpModule():
    make_small_scene(PATINATE, SHARED)


def tearDownModule():
    shutil.rmtree(SHARED)


def tree_of(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "run.json" and ".cache" not in p.parts}


def stamps_of(folder):
    return {str(p): (p.stat().st_mtime_ns, p.stat().st_ino) for p in [folder, *sorted(folder.rglob("*"))]}


class JobCase(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_job_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def succeeds(self, *arguments):
        result = run(*arguments, cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def short_capture(self, num_frames):
        """The shared capture with its first frames only."""
        shutil.copytree(SHARED / "capture", self.folder / "capture")
        for frame in sorted((self.folder / "capture/frames").iterdir())[num_frames:]:
            frame.unlink()


class DryRun(JobCase):
    COMMANDS = (["synth", "crackle", "--width", "48", "--height", "40", "-o", "out"], ["synth", "sculpture", "-o", "out"],
                ["ingest", SHARED / "capture", "-o", "out"],
                ["transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "out"],
                ["export", SHARED / "aged", "--times", "0,7", "-o", "out"], ["export", SHARED / "aged", "-o", "out.glb"],
                ["texture", SHARED / "aged", "--time", "3", "-o", "out.png"], ["render", SHARED / "history", "-o", "out.png"],
                ["control", SHARED / "urn/mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "out.exr"])

    def test_nothing_is_touched_and_the_need_is_said(self):
        for command in self.COMMANDS:
            with self.subTest(command=command[0]):
                before = stamps_of(self.folder), stamps_of(SHARED)
                self.assertIn("would make it", self.succeeds(*command, "--dry-run"))
                self.assertEqual(json.loads(self.succeeds(*command, "--dry-run", "--json"))["would"], "make")
                self.assertEqual((stamps_of(self.folder), stamps_of(SHARED)), before)
                self.succeeds(*command)
                before = stamps_of(self.folder)
                self.assertEqual(json.loads(self.succeeds(*command, "--dry-run", "--json"))["would"], "nothing")
                self.assertEqual(stamps_of(self.folder), before)
            for made in self.folder.iterdir():
                shutil.rmtree(made) if made.is_dir() else made.unlink()

    def test_a_changed_option_is_named_with_its_values(self):
        self.succeeds("ingest", SHARED / "capture", "-o", "out")
        text = self.succeeds("ingest", SHARED / "capture", "--spatial-sigma", "7", "-o", "out", "--dry-run")
        self.assertIn("--spatial-sigma was not given, is `7`", text)
        self.assertIn("--force", text)
        self.assertRegex(text, "kept .*frame-0000, frame-0001, frame-0002, frame-0003")
        report = json.loads(self.succeeds("ingest", SHARED / "capture", "--spatial-sigma", "7", "-o", "out", "--dry-run", "--json"))
        self.assertTrue(report["needs_force"])
        self.assertEqual([c["name"] for c in report["changes"]], ["--spatial-sigma"])

    def test_a_changed_photograph_is_named(self):
        self.short_capture(4)
        self.succeeds("ingest", "capture", "-o", "out")
        shutil.copy(self.folder / "capture/frames/0001.png", self.folder / "capture/frames/0002.png")
        text = self.succeeds("ingest", "capture", "-o", "out", "--dry-run")
        self.assertIn("frames/0002.png has other content", text)
        self.assertRegex(text, "kept .*frame-0000, frame-0001, frame-0003")
        self.assertRegex(text, "to make .*frame-0002")

    def test_a_transfer_says_what_differs(self):
        self.succeeds(*self.COMMANDS[3])
        text = self.succeeds(*self.COMMANDS[3], "--dry-run", "--neighborhood", "2")
        self.assertIn("--neighborhood was `0`, is `2`", text)
        other = [str(a).replace("facing", "accessibility") for a in self.COMMANDS[3]]
        self.assertIn("--control thickness", self.succeeds(*other, "--dry-run"))


class Append(JobCase):
    def test_a_photograph_more_costs_one_frame_and_gives_the_bytes_of_a_fresh_history(self):
        self.short_capture(3)
        self.succeeds("ingest", "capture", "-o", "out")
        kept = {p.name: p.stat().st_ino for p in (self.folder / "out/frames").iterdir()}
        shutil.copy(SHARED / "capture/frames/0003.png", self.folder / "capture/frames/0003.png")
        self.assertEqual(json.loads(self.succeeds("ingest", "capture", "-o", "out", "--dry-run", "--json"))["would"], "grow")
        self.succeeds("ingest", "capture", "-o", "out")
        self.assertEqual(tree_of(self.folder / "out"), tree_of(SHARED / "history"))
        now = {p.name: p.stat().st_ino for p in (self.folder / "out/frames").iterdir()}
        self.assertEqual({name: now[name] for name in kept}, kept)
        self.assertEqual(len(now), 4)

    def test_an_option_that_concerns_no_frame_keeps_all_frames(self):
        self.succeeds("ingest", SHARED / "capture", "-o", "out")
        kept = {p.name: p.stat().st_ino for p in (self.folder / "out/frames").iterdir()}
        self.succeeds("ingest", SHARED / "capture", "--spatial-sigma", "7", "-o", "out", "--force")
        self.succeeds("ingest", SHARED / "capture", "--spatial-sigma", "7", "-o", "fresh")
        self.assertEqual(tree_of(self.folder / "out"), tree_of(self.folder / "fresh"))
        self.assertEqual({p.name: p.stat().st_ino for p in (self.folder / "out/frames").iterdir()}, kept)


if __name__ == "__main__":
    unittest.main()
