#!/usr/bin/env python3
"""docs/testing.md says of every test program and script when it runs, and of every part of tools/nightly what it is. Usage: testing_page_test.py BUILD_FOLDER"""
import json
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else ROOT / "build/release"
PAGE = (ROOT / "docs/testing.md").read_text()


def stated():
    """{name: "commit" or "nightly"} of the tables' rows."""
    return {name: when for name, when in re.findall(r"^\| `([\w-]+)` \|.*\| (commit|nightly) \|$", PAGE, re.MULTILINE)}


def registered():
    """{name: "commit" or "nightly"} of what ctest knows, a program for its suites or a script, and the suites that run nightly of a program that runs
    per commit."""
    shown = subprocess.run(["ctest", "--test-dir", str(BUILD), "--show-only=json-v1"], capture_output=True, text=True, check=True).stdout
    found, suites = {}, {}
    for test in json.loads(shown)["tests"]:
        labels = next((p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"), [])
        program = next((label for label in labels if label != "nightly"), None)
        when = "nightly" if "nightly" in labels else "commit"
        found.setdefault(program or test["name"], set()).add(when)
        if program and when == "nightly":
            suites[test["name"]] = program
    programs = {name: "commit" if "commit" in when else "nightly" for name, when in found.items()}
    return programs, sorted(suite for suite, program in suites.items() if programs[program] == "commit")


class TestingPage(unittest.TestCase):
    def test_every_program_and_script_is_on_the_page_with_when_it_runs(self):
        (programs, suites), page = registered(), stated()
        self.assertGreater(len(programs), 60)
        # What a machine lacks (Chromium, the Khronos validator, Python's module) is on the page all the same.
        self.assertEqual({name: when for name, when in page.items() if name in programs}, programs)
        sources = "".join(path.read_text() for path in [ROOT / "tests/CMakeLists.txt", *(ROOT / "tests").glob("*/CMakeLists.txt")])
        gone = [name for name in page if name not in programs and not re.search(rf"\b{re.sub('^(cli|python|architecture)_', '', name)}\b", sources)]
        self.assertEqual(gone, [])
        self.assertEqual(sorted(re.findall(r"`(\w+)`", re.search(r"^Suites that run nightly: (.*)$", PAGE, re.MULTILINE).group(1))), suites)

    def test_every_test_source_is_built_into_a_program(self):
        text = "".join(path.read_text() for path in (ROOT / "tests").rglob("CMakeLists.txt"))
        left_out = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").rglob("*_test.cpp")) if not re.search(rf"\b{path.name}\b", text)]
        self.assertEqual(left_out, [])
        scripts = [path for path in sorted((ROOT / "tests").rglob("*_test.py")) if "node_modules" not in path.parts and path.parent.name != "slurm"]
        left_out = [str(path.relative_to(ROOT)) for path in scripts if not re.search(rf"\b{path.name.removesuffix('_test.py')}\b|\b{path.name}", text)]
        self.assertEqual(left_out, [])

    def test_every_part_of_the_nightly_set_is_on_the_page(self):
        parts = set(re.findall(r"^\s*(?:if )?part ([\w-]+)", (ROOT / "tools/nightly").read_text(), re.MULTILINE))
        self.assertGreater(len(parts), 8)
        self.assertEqual(parts - set(re.findall(r"`([\w-]+)`", PAGE)), set())


if __name__ == "__main__":
    unittest.main()
