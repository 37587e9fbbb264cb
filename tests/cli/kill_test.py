#!/usr/bin/env python3
"""kill -9 at random times: the same command, run again, ends in the bytes of an uninterrupted run.
Usage: kill_test.py PATINATE [--kills N] [--seed S] [unittest arguments]

Every command (per commit four of them) is killed N times (2 unless told), at times drawn evenly over how long it takes, in groups: some kills hit a fresh start, others a
run that resumes after kills. tools/nightly runs 50 of each. Then a disk that is full: exit code 1, one line, and the same end once there is
space.
"""
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from command_case import four_per_commit, nightly


def take_argument(name, default):
    if name not in sys.argv:
        return default
    at = sys.argv.index(name)
    value = int(sys.argv[at + 1])
    del sys.argv[at:at + 2]
    return value


KILLS, SEED = take_argument("--kills", 2), take_argument("--seed", 1)
PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_kill_"))
CANNOT = 1

CRACKLE = ["synth", "crackle", "--width", "96", "--height", "80", "--num-frames", "10"]
MOLD = ["synth", "mold", "--width", "96", "--height", "72", "--steps", "4", "--lights", "4", "--scan-spacing", "2"]
COMMANDS = {
    "synth": [*CRACKLE, "-o", "out"],
    "ingest": ["ingest", SHARED / "capture", "--progress", "-o", "out"],
    "mold": [*MOLD, "-o", "out"],
    "relit": ["ingest", SHARED / "mold", "-o", "out"],
    "append": ["ingest", SHARED / "capture", "--progress", "-o", "out"],
    "transfer": ["transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "160", "-o", "out"],
    "reference": ["transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "64",
                  "--method", "reference", "--window", "24", "-o", "out"],
    "sequence": ["export", SHARED / "aged", "--num-times", "10", "-o", "out"],
    "glb": ["export", SHARED / "aged", "-o", "out.glb"],
    "lookup": ["texture", SHARED / "aged", "--time", "20", "-o", "out.png"],
    "render": ["render", SHARED / "aged", "--time", "20", "--width", "200", "-o", "out.png"],
    "movie": ["export", SHARED / "aged", "--num-times", "12", "-o", "out.gif"],
    "factorize": ["history", "factorize", SHARED / "history", "--num-intervals", "16", "--num-training", "48", "-o", "out"],
    "compare": ["history", "compare", SHARED / "history", SHARED / "history", "--num-resamples", "10", "-o", "out"],
    "evaluate": ["evaluate", SHARED / "aged", "-o", "out"],
    "simulate": ["simulate", SHARED / "ledge/scene.json", "--resolution", "128", "--iterations", "60", "--history-every", "10", "-o", "out"],
    "control": ["control", SHARED / "urn/mesh.obj", "--kind", "accessibility", "--resolution", "128", "-o", "out.exr"],
}


def start(arguments, cwd, **more):
    return subprocess.Popen([PATINATE, *map(str, arguments), "--quiet"], cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                            text=True, **more)


def finish(arguments, cwd):
    process = start(arguments, cwd)
    errors = process.communicate(timeout=600)[1]
    if process.returncode != 0:
        raise AssertionError(f"{arguments}: {process.returncode}: {errors}")


def tree_of(folder):
    """Relative path -> bytes, hidden and temporary files too; run.json differs from run to run."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "run.json"}


def setUpModule():
    for arguments in ([*CRACKLE, "-o", "capture"], [*MOLD, "-o", "mold"], ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["synth", "ledge", "-o", "ledge"],
                      ["ingest", "capture", "--progress", "-o", "history"],
                      ["transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "160", "-o", "aged"]):
        finish(arguments, SHARED)
    shutil.copytree(SHARED / "capture", SHARED / "short")
    for frame in sorted((SHARED / "short/frames").iterdir())[7:]:
        frame.unlink()


def tearDownModule():
    shutil.rmtree(SHARED)


class Killed(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_kill_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.random = random.Random(SEED)

    def prepare(self, name):
        """An empty folder, or, to be appended to, the history of the first photographs."""
        for made in self.folder.iterdir():
            shutil.rmtree(made) if made.is_dir() else made.unlink()
        if name == "append":
            finish(["ingest", SHARED / "short", "--progress", "-o", "out"], self.folder)

    def kill_after(self, name, seconds):
        """@returns whether the command was still running."""
        process = start(COMMANDS[name], self.folder)
        try:
            errors = process.communicate(timeout=seconds)[1]
            self.assertEqual(process.returncode, 0, errors)
            return False
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
            return True

    def check(self, name):
        self.prepare(name)
        begin = time.monotonic()
        finish(COMMANDS[name], self.folder)
        duration = time.monotonic() - begin
        whole = tree_of(self.folder)
        old = None
        num_killed = 0
        for attempt in range(20 * KILLS):
            if num_killed >= KILLS:
                break
            self.prepare(name)
            old = tree_of(self.folder)
            for _ in range(self.random.randint(1, 4)):
                num_killed += self.kill_after(name, self.random.uniform(0.0, duration))
                finished = {path: bytes for path, bytes in tree_of(self.folder).items() if ".partial/" not in path and "/." not in path
                            and not path.startswith(".")}
                self.assertIn(finished, (old, whole), f"{name}: the output is neither whole nor as it was; kill {num_killed}")
            finish(COMMANDS[name], self.folder)
            self.assertEqual(sorted(tree_of(self.folder)), sorted(whole), f"{name}: kill {num_killed}, seed {SEED}")
            self.assertEqual(tree_of(self.folder), whole, f"{name}: kill {num_killed}, seed {SEED}")
        self.assertGreaterEqual(num_killed, KILLS, f"{name}: too quick to be killed")
        if "-v" in sys.argv:
            print(f"{name}: {num_killed} kills of a run of {duration:.2f} s", file=sys.stderr)


for command in four_per_commit(COMMANDS):
    setattr(Killed, f"test_{command}", lambda self, name=command: self.check(name))


class FileSizeLimit(unittest.TestCase):
    """What a full disk does to a file, without root."""

    def test_ends_in_one_line_and_the_same_command_finishes_later(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
        for name, arguments in {**four_per_commit(COMMANDS), "lookup": COMMANDS["lookup"]}.items():
            with self.subTest(command=name), tempfile.TemporaryDirectory() as folder:
                process = start(arguments, folder, preexec_fn=limit)
                errors = process.communicate(timeout=300)[1]
                self.assertEqual(process.returncode, CANNOT, errors)
                self.assertEqual(len(errors.splitlines()), 1, errors)
                self.assertFalse([p for p in pathlib.Path(folder).iterdir() if not p.name.endswith(".partial")])
                if name in ("lookup", "ingest"):
                    finish(arguments, folder)
                    self.assertEqual([p.name for p in pathlib.Path(folder).iterdir()], [arguments[-1]])


@nightly
class FullDisk(unittest.TestCase):
    """A small tmpfs; needs root (or skips), as only a mount is full in the way that disks are."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_full_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def mount(self, kilobytes):
        result = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", self.folder], capture_output=True, text=True)
        if result.returncode != 0:
            self.skipTest("a tmpfs cannot be mounted here: " + result.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", "-l", self.folder])

    def test_ends_in_one_line_and_goes_on_when_there_is_space(self):
        self.mount(64)
        for name in ("synth", "ingest", "transfer", "sequence", "glb", "movie", "lookup", "render", "control", "factorize", "compare", "evaluate", "simulate"):
            with self.subTest(command=name):
                with tempfile.TemporaryDirectory() as other:
                    finish(COMMANDS[name], other)
                    whole = tree_of(pathlib.Path(other))
                for kilobytes in (8, 64, 200):
                    subprocess.run(["mount", "-o", f"remount,size={kilobytes}k", self.folder], check=True)
                    process = start(COMMANDS[name], self.folder)
                    errors = process.communicate(timeout=300)[1]
                    if process.returncode == 0:
                        break
                    self.assertEqual(process.returncode, CANNOT, errors)
                    self.assertEqual(len(errors.splitlines()), 1, errors)
                    self.assertTrue(errors.startswith("patinate: error: "), errors)
                    self.assertIn("out", errors.split(": ")[2], "which file it is")
                    self.assertFalse(any(self.folder.glob("out")) or any(self.folder.glob("out.[!p]*")), "no output but a whole one")
                subprocess.run(["mount", "-o", "remount,size=50m", self.folder], check=True)
                finish(COMMANDS[name], self.folder)
                self.assertTrue(tree_of(self.folder) == whole, "other bytes")
            for made in self.folder.iterdir():
                shutil.rmtree(made) if made.is_dir() else made.unlink()


if __name__ == "__main__":
    unittest.main()
