#!/usr/bin/python3
"""`pip install .` into a virtual environment without a network: the module, the programs that it starts, and the command. Usage: pip_test.py PATINATE (of a finished build)"""
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest

PATINATE = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
STUDY = {"format": "patinate.study", "version": 1, "transfer": {"histories": ["history"], "meshes": ["urn/mesh.obj"], "controls": ["facing"], "options": {"resolution": [32]}}}
USE = """
import pathlib, sys
import patinate
assert pathlib.Path(patinate.__file__).is_relative_to(sys.prefix), patinate.__file__
patinate.synth_crackle("crackle", width=48, height=40, num_frames=3)
history = patinate.ingest("crackle", "history")
patinate.synth_sculpture("urn", resolution=24)
aged = patinate.transfer(history, patinate.read_mesh("urn/mesh.obj"), "thickness=facing", resolution=64)
aged.save("aged")
patinate.render("aged", "aged.jpg", width=48, height=48, samples=1)
"""


@unittest.skipUnless(importlib.util.find_spec("ensurepip"), "python3-venv is not installed")
class Pip(unittest.TestCase):
    def setUp(self):
        room = tempfile.TemporaryDirectory(prefix="patinate_pip_")
        self.addCleanup(room.cleanup)
        self.folder = pathlib.Path(room.name)
        self.environment = {"PATH": os.environ["PATH"], "HOME": room.name, "PATINATE_BUILD": str(PATINATE.parents[1])}
        self.run_command("/usr/bin/python3", "-m", "venv", "--system-site-packages", "env")

    def run_command(self, *command, folder=None):
        result = subprocess.run([*map(str, command)], cwd=folder or self.folder, env=self.environment, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def uninstall(self):
        self.run_command("env/bin/pip", "uninstall", "-y", "patinate")
        self.assertEqual([p for p in (self.folder / "env").rglob("*patinate*")], [])

    def test_an_environment_has_module_and_command(self):
        # From a source distribution, which holds what the tree does.
        sys.path.insert(0, str(ROOT / "python"))
        import build_wheel
        name = build_wheel.build_sdist(self.folder)
        with tarfile.open(self.folder / name) as tar:
            names = {member.name.split("/", 1)[1]: member.mode for member in tar.getmembers()}
        self.assertEqual(set(build_wheel.source_files()) | {"PKG-INFO"}, set(names))
        self.assertLessEqual({"pyproject.toml", "CMakeLists.txt", "python/build_wheel.py", "LICENSE"}, set(names))
        self.assertTrue(names["tools/setup"] & 0o100)
        self.run_command("env/bin/pip", "install", "--no-index", self.folder / name)
        self.run_command("env/bin/python", "-c", USE)
        self.assertIn("thickness=facing", self.run_command("env/bin/patinate", "info", "aged"))
        (self.folder / "study.json").write_text(json.dumps(STUDY))
        self.run_command("env/bin/patinate", "study", "run", "study.json", "-o", "study", "--dry-run")
        self.uninstall()

    def test_an_editable_environment_has_those_of_the_build(self):
        self.run_command("env/bin/pip", "install", "--no-index", "--no-build-isolation", "-e", ROOT)
        where = self.run_command("env/bin/python", "-c", "import patinate; patinate.write_color('a.jpg', patinate.linear_from_srgb(__import__('numpy').zeros((8, 8, 3), 'uint8'))); print(patinate.__file__)")
        self.assertEqual(pathlib.Path(where.strip()).parent, PATINATE.parents[1] / "python/patinate")
        self.assertEqual(self.run_command("env/bin/patinate", "--version"), self.run_command(PATINATE, "--version"))
        self.uninstall()


if __name__ == "__main__":
    unittest.main()
