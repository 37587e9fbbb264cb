#!/usr/bin/env python3
"""Damaged files of every kind through the command line: exit code 0 or 3, one line for each problem, never a crash.
Usage: robust_test.py PATINATE [--all] [unittest arguments]

Files of ours are cut off at many lengths and get bits flipped; --all takes more of them, and every mesh of PATINATE_DATA/meshes/robustness_assimp.
The readers are fuzzed besides (tests/fuzz).
"""
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

ALL = "--all" in sys.argv
if ALL:
    sys.argv.remove("--all")
PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
IS_SANITIZED = b"__asan_init" in pathlib.Path(PATINATE).read_bytes()
CUTS, FLIPS = (24, 40) if ALL else (3, 3)
DATA = pathlib.Path(os.environ.get("PATINATE_DATA", "/nowhere"))
MESHES = {".obj", ".ply", ".gltf", ".glb"}


class Damaged(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = pathlib.Path(tempfile.mkdtemp(prefix="patinate_robust_"))
        for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "capture"],
                          ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["ingest", "capture", "-o", "history"],
                          ["transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "48", "-o", "aged"],
                          ["export", "aged", "-o", "aged.glb"]):
            result = subprocess.run([PATINATE, *arguments], cwd=cls.shared, capture_output=True, text=True)
            if result.returncode != 0:
                raise RuntimeError(f"{arguments}: {result.stderr}")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.shared)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_robust_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.random = random.Random(1)

    def survives(self, label, *arguments):
        result = subprocess.run([PATINATE, *map(str, arguments), "--quiet"], cwd=self.folder, capture_output=True, timeout=300)
        errors = result.stderr.decode("utf-8", "replace")
        lines = [line for line in errors.splitlines() if line and not (IS_SANITIZED and line.startswith("libpng error: "))]
        self.assertIn(result.returncode, (0, 3), f"{label}: {arguments}: {errors}")
        for line in lines:
            self.assertTrue(line.startswith("patinate: error: "), f"{label}: {line}")
        if result.returncode != 0:
            self.assertTrue(lines, f"{label}: {arguments} failed without a word")
            self.assertTrue(len(lines) == 1 or arguments[0] == "validate", f"{label}: {errors}")

    def damaged(self, path):
        """Yields the file cut off, then with bits flipped; whole again at the end."""
        whole = path.read_bytes()
        for i in range(CUTS):
            path.write_bytes(whole[:len(whole) * i // CUTS])
            yield f"{path.name} cut off at {len(whole) * i // CUTS}"
        for i in range(FLIPS):
            data = bytearray(whole)
            for _ in range(1 + i % 4):
                at = self.random.randrange(min(len(data), 512) if i % 2 else len(data))
                data[at] ^= 1 << self.random.randrange(8)
            path.write_bytes(data)
            yield f"{path.name} with bits flipped, {i}"
        path.write_bytes(whole)

    def take(self, name):
        source = self.shared / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, self.folder / name)
        return self.folder / name

    def test_files_of_a_capture(self):
        capture = self.take("capture")
        for file in ("capture.json", "frames/0001.png", "backlight.png"):
            for label in self.damaged(capture / file):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                shutil.rmtree(self.folder / "out.partial", ignore_errors=True)
                self.survives(label, "ingest", "capture", "-o", "out")
                self.survives(label, "info", "capture/capture.json")

    def test_photographs_of_every_format_that_lack_rows_are_refused(self):
        for suffix in ("png", "jpg", "tif", "exr"):
            picture = self.folder / f"x.{suffix}"
            self.run_whole("render", self.shared / "aged", "--width", "96", "--height", "300", "-o", picture)
            whole = picture.read_bytes()
            for i in range(1, CUTS):
                picture.write_bytes(whole[:len(whole) * i // CUTS])
                result = subprocess.run([PATINATE, "thickness", picture, "-o", self.folder / "t.exr", "--quiet", "--force"], cwd=self.folder, capture_output=True, text=True, timeout=300)
                self.assertEqual(result.returncode, 3, f"{suffix} cut off at {len(whole) * i // CUTS} of {len(whole)}: {result.stderr}")
                self.assertIn(picture.name, result.stderr)

    def run_whole(self, *arguments):
        result = subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_files_of_a_history(self):
        history = self.take("history")
        for file in ("history.json", "frames/0001.exr", "controls/thickness.exr", "job.json"):
            for label in self.damaged(history / file):
                self.survives(label, "validate", "history")
                self.survives(label, "render", "history", "--width", "64", "-o", "x.png", "--force")

    def test_files_of_a_transfer(self):
        self.take("history")
        aged = self.take("aged")
        for file in ("transfer.json", "coordinates.exr", "mesh.obj"):
            for label in self.damaged(aged / file):
                self.survives(label, "validate", "aged")
                self.survives(label, "texture", "aged", "--time", "1", "-o", "x.png", "--force")

    def test_meshes_and_maps(self):
        (self.folder / "mesh.obj").write_bytes((self.shared / "urn/mesh.obj").read_bytes())
        shutil.copy(self.shared / "aged.glb", self.folder / "mesh.glb")
        for name in ("mesh.obj", "mesh.glb"):
            for label in self.damaged(self.folder / name):
                self.survives(label, "control", name, "--kind", "facing", "--resolution", "16", "-o", "x.exr", "--force")
                self.survives(label, "info", name)

    def test_point_clouds_of_other_programs_are_refused(self):
        (self.folder / "scan.pcd").write_text("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nDATA ascii\n0 0 0\n")
        for verb in (["info", "scan.pcd"], ["control", "scan.pcd", "--kind", "facing", "-o", "x.exr"]):
            self.survives("pcd", *verb)

    @unittest.skipUnless((DATA / "meshes/robustness_assimp").is_dir(), "PATINATE_DATA has no meshes/robustness_assimp")
    def test_files_made_to_break_readers(self):
        files = sorted(p for p in (DATA / "meshes/robustness_assimp").rglob("*") if p.is_file() and (ALL or p.suffix.lower() in MESHES))
        for file in files:
            self.survives(file.name, "info", file)
            if file.suffix.lower() in MESHES:
                self.survives(file.name, "control", file, "--kind", "facing", "--resolution", "16", "-o", "x.exr", "--force")


if __name__ == "__main__":
    unittest.main()
