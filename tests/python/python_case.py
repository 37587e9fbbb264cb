"""Test cases of the Python module, which say of each function that it does what the command line does. Usage of each: X_test.py PATINATE FOLDER (of the package)"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "cli"))
from small_scene import PLATE, PLATE_SCENE, make_small_scene  # noqa: E402

SCENE = {**PLATE_SCENE, "run": {"iterations": 30, "history_every": 10, "controls": ["hits"]}}


def half(values):
    """As EXR files of colors keep them."""
    return np.asarray(values).astype(np.float16).astype(np.float32)


class PythonCase(unittest.TestCase):
    """`work` holds capture, urn, history and aged of the small scene, scene.json, and what `run` makes beside them."""
    patinate = work = package = None

    def run_patinate(self, *arguments):
        result = subprocess.run([self.patinate, *map(str, arguments)], cwd=self.work, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def line_of(self, kind, work):
        """The one line of the error that `work` raises."""
        with self.assertRaises(kind) as caught:
            work()
        self.assertNotIn("\n", str(caught.exception))
        return str(caught.exception)

    def same_files(self, one, other):
        """Two folders of `work` hold the same, but for how and when they were made."""
        trees = [{p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.name not in ("job.json", "run.json")}
                 for folder in (self.work / one, self.work / other)]
        self.assertEqual(sorted(trees[0]), sorted(trees[1]))
        self.assertEqual([file for file in trees[0] if trees[0][file] != trees[1][file]], [])

    def json_of(self, *path):
        return json.loads(self.work.joinpath(*path).read_text())


def main():
    PythonCase.patinate = str(pathlib.Path(sys.argv.pop(1)).resolve())
    PythonCase.package = pathlib.Path(sys.argv.pop(1)).resolve()
    PythonCase.work = pathlib.Path(tempfile.mkdtemp(prefix="patinate_python_"))
    try:
        make_small_scene(PythonCase.patinate, PythonCase.work)
        (PythonCase.work / "plate.obj").write_text(PLATE)
        (PythonCase.work / "scene.json").write_text(json.dumps(SCENE))
        program = unittest.main(module="__main__", exit=False)
    finally:
        shutil.rmtree(PythonCase.work)
    if program.result.testsRun == 0:
        raise SystemExit("no test was run")
    raise SystemExit(not program.result.wasSuccessful())
