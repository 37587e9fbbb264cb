#!/usr/bin/python3
"""Every block of docs/python.md runs, in order, as a reader would type it."""
import contextlib
import io
import os
import pathlib
import re
import shutil

from python_case import PythonCase, main

GUIDE = pathlib.Path(__file__).parents[2] / "docs/python.md"


class Guide(PythonCase):
    def test_its_blocks_run(self):
        folder = self.work / "guide"
        folder.mkdir()
        shutil.copytree(self.work / "capture", folder / "capture")
        shutil.copy(self.work / "urn/mesh.obj", folder)
        for name in ("scene.json", "plate.obj"):
            shutil.copy(self.work / name, folder)
        blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
        self.assertGreaterEqual(len(blocks), 5)
        before = os.getcwd()
        os.chdir(folder)
        self.addCleanup(os.chdir, before)
        names = {}
        for block in blocks:
            with self.subTest(block=block), contextlib.redirect_stdout(io.StringIO()):
                exec(compile(block, str(GUIDE), "exec"), names)
        self.assertEqual(names["mixed"].shape, names["texture"].shape)
        self.assertTrue((folder / "aged.png").exists() and (folder / "mine/history.json").exists())


if __name__ == "__main__":
    main()
