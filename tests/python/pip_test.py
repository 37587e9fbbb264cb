#!/usr/bin/python3
"""`pip install .` into a virtual environment without a network: the module, the programs that it starts, and the command. Usage: pip_test.py PATINATE (of a finished build)"""
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
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
    def test_an_environment_has_module_and_command(self):
        with tempfile.TemporaryDirectory(prefix="patinate_pip_") as folder:
            def run(*command):
                result = subprocess.run([*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True)
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                return result.stdout
            environment = {"PATH": os.environ["PATH"], "HOME": folder, "PATINATE_BUILD": str(PATINATE.parents[1])}
            run("/usr/bin/python3", "-m", "venv", "--system-site-packages", "env")
            run("env/bin/pip", "install", "--no-index", ROOT)
            run("env/bin/python", "-c", USE)
            self.assertIn("thickness=facing", run("env/bin/patinate", "info", "aged"))
            pathlib.Path(folder, "study.json").write_text(json.dumps(STUDY))
            run("env/bin/patinate", "study", "run", "study.json", "-o", "study", "--dry-run")
            run("env/bin/pip", "uninstall", "-y", "patinate")
            self.assertEqual([p for p in pathlib.Path(folder, "env").rglob("*patinate*")], [])


if __name__ == "__main__":
    unittest.main()
