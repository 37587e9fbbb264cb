#!/usr/bin/env python3
"""Every source is laid out as clang-format 14 does with .clang-format. Usage: format_test.py REPOSITORY

Other versions lay some lines out otherwise: without this one the test is skipped, and says so.
"""
import pathlib
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
FOLDERS = ("libcommon", "capture", "transfer", "simulation", "analysis", "datasets_synthetic", "app", "tools", "tests", "docs")
SUFFIXES = {".h", ".cpp", ".inc", ".inl"}
PROGRAM = shutil.which("clang-format-14")


def sources():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SUFFIXES and "node_modules" not in path.parts and "fuzz/corpus" not in str(path):
                yield str(path.relative_to(ROOT))


class Format(unittest.TestCase):
    def test_every_source_is_laid_out_as_clang_format_does(self):
        if PROGRAM is None:
            self.skipTest("clang-format-14 is not installed (tools/setup --tests)")
        paths = list(sources())
        self.assertGreater(len(paths), 500)  # The check has looked at something.
        said = subprocess.run([PROGRAM, "--dry-run", "--Werror", *paths], cwd=ROOT, capture_output=True, text=True).stderr
        wrong = sorted({line.split(":")[0] for line in said.splitlines() if ": error:" in line})
        self.assertEqual(wrong, [], "lay them out with: clang-format-14 -i " + " ".join(wrong))


if __name__ == "__main__":
    unittest.main()
