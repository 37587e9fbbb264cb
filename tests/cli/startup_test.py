#!/usr/bin/env python3
"""What a start costs: which libraries commands load, and what they say of modules. Usage: startup_test.py PATINATE [unittest arguments]"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_startup_"))
MODULES_ONLY = re.compile(r"libOpenImageIO|libav(codec|format|util|filter)|libsw(scale|resample)|libpcl_|patinate-")
MOST_LIBRARIES = 80


def run(*arguments, code=0, **environment):
    done = subprocess.run([PATINATE, *map(str, arguments), "--quiet"], cwd=SHARED, env=os.environ | environment, capture_output=True, text=True, timeout=600)
    if done.returncode != code:
        raise RuntimeError(f"{arguments}: exit code {done.returncode}\n{done.stderr}")
    return done


def libraries(*arguments, code=0):
    """Those that the program itself has loaded when it ends, by the loader's own account; programs that it starts are left out."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([PATINATE, *map(str, arguments)], cwd=SHARED, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   env=os.environ | {"LD_DEBUG": "files", "LD_DEBUG_OUTPUT": f"{folder}/log"})
        error = process.communicate(timeout=600)[1]
        if process.returncode != code:
            raise RuntimeError(f"{arguments}: exit code {process.returncode}\n{error}")
        log = pathlib.Path(folder, f"log.{process.pid}").read_text(errors="replace")
    return {pathlib.Path(name).name for name in re.findall(r"calling init: (\S+)", log)}


def setUpModule():
    run("synth", "crackle", "--width", 96, "--height", 96, "--num-frames", 3, "-o", "capture")
    run("synth", "sculpture", "--resolution", 24, "-o", "urn")
    run("ingest", "capture", "-o", "history")
    run("transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", 64, "-o", "aged")
    for name in ("frame.png", "frame.tif"):
        run("texture", "aged", "--time", 1, "-o", name)


def tearDownModule():
    shutil.rmtree(SHARED)


class Startup(unittest.TestCase):
    def test_commands_load_few_libraries_and_none_that_only_modules_need(self):
        for arguments in (["--help"], ["--version"], ["help", "texture"], ["info", "history"], ["info", "aged"], ["texture", "aged", "--time", "2", "-o", "later.png"],
                          ["texture", "aged", "--time", "2", "-o", "later.exr"], ["info", "frame.png"]):
            with self.subTest(arguments=arguments):
                loaded = libraries(*arguments)
                self.assertIn("libc.so.6", loaded)  # The check has looked at something.
                self.assertEqual({name for name in loaded if MODULES_ONLY.match(name)}, set())
                self.assertLessEqual(len(loaded), MOST_LIBRARIES)

    def test_a_file_that_needs_the_module_loads_it(self):
        loaded = libraries("info", "frame.tif")
        self.assertIn("patinate-media.so", loaded)
        self.assertTrue(any(name.startswith("libOpenImageIO") for name in loaded))
        self.assertFalse(any(name.startswith("libpcl_") for name in loaded))


class Modules(unittest.TestCase):
    def assert_one_line(self, done, *parts):
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for part in parts:
            self.assertIn(part, done.stderr)

    def test_a_missing_module_is_one_line_that_names_it(self):
        empty = SHARED / "empty"
        empty.mkdir(exist_ok=True)
        self.assert_one_line(run("info", "frame.tif", code=1, PATINATE_MODULES=str(empty)), f"patinate: error: {empty}/patinate-media.so: cannot be loaded (")
        self.assert_one_line(run("texture", "aged", "--time", 1, "-o", "no.jpg", code=1, PATINATE_MODULES=str(empty)), f"{empty}/patinate-media.so")
        self.assertFalse((SHARED / "no.jpg").exists())
        run("info", "frame.png", PATINATE_MODULES=str(empty))  # Which needs none.

    def test_a_module_of_another_version_is_one_line_that_names_it(self):
        other = SHARED / "other"
        other.mkdir(exist_ok=True)
        shutil.copy(pathlib.Path(PATINATE).parent / "patinate-pcl.so", other / "patinate-media.so")  # It lacks what is asked for.
        self.assert_one_line(run("info", "frame.tif", code=1, PATINATE_MODULES=str(other)), f"{other}/patinate-media.so: is of another version than this program")

    def test_a_program_without_its_modules_says_so(self):
        alone = SHARED / "alone"
        alone.mkdir(exist_ok=True)
        shutil.copy(PATINATE, alone / "patinate")
        done = subprocess.run([str(alone / "patinate"), "info", "frame.tif"], cwd=SHARED, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assert_one_line(done, "patinate-media.so: cannot be loaded (")


if __name__ == "__main__":
    unittest.main()
