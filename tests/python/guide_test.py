#!/usr/bin/python3
"""Every block of docs/python.md runs, in order, as a reader would type it, and once more."""
import contextlib
import io
import os
import pathlib
import re
import shutil

import patinate

from python_case import PythonCase, main

GUIDE = pathlib.Path(__file__).parents[2] / "docs/python.md"


class Guide(PythonCase):
    def test_its_blocks_run(self):
        folder = self.work / "guide"
        folder.mkdir()
        for name in ("capture", "history", "urn"):
            shutil.copytree(self.work / name, folder / name)
        for name in ("scene.json", "plate.obj"):
            shutil.copy(self.work / name, folder)
        blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
        self.assertGreaterEqual(len(blocks), 5)
        before = os.getcwd()
        os.chdir(folder)
        self.addCleanup(os.chdir, before)
        names = {}
        for time in ("first", "second"):
            for block in blocks:
                with self.subTest(time=time, block=block), contextlib.redirect_stdout(io.StringIO()):
                    exec(compile(block, str(GUIDE), "exec"), names)
        self.assertEqual(names["mixed"].shape, names["mine"].shape + (3,))
        for file in ("strip.png", "aged/transfer.json", "aged.glb", "mine/history.json"):
            self.assertTrue((folder / file).exists(), file)

    def test_its_table_names_what_there_is(self):
        public = {name for name in dir(patinate) if not name.startswith("_")}
        said = set(re.findall(r"`([A-Za-z_]+)`", GUIDE.read_text()[GUIDE.read_text().index("## What there is"):GUIDE.read_text().index("## From photographs")]))
        errors = {name for name in public if isinstance(getattr(patinate, name), type) and issubclass(getattr(patinate, name), Exception)}
        self.assertEqual(sorted(public - said - errors - {name for name in public if name.startswith("synth_")}), [])


if __name__ == "__main__":
    main()
