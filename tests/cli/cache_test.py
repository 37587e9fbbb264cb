#!/usr/bin/env python3
"""What `patinate transfer` keeps of a history's analysis: it saves time, and shows nowhere else. Usage: cache_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from command_case import nightly

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_cache_"))


def command(history, output, *more):
    return [PATINATE, "transfer", str(history), str(SHARED / "hill.obj"), "--control", "height", "--resolution", "48", "--flow", "uv", *more, "-o", str(output)]


def run(*arguments, cwd=SHARED):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120)


def setUpModule():
    # A hill of 8 x 8 squares; all that is written of its transfers is smaller than what is kept.
    vertices = [f"v {x} {y} {(x * (8 - x) + y * (8 - y)) / 16}\nvt {x / 8} {y / 8}\n" for y in range(9) for x in range(9)]
    faces = [" ".join(["f", *(f"{v}/{v}" for v in (i, i + 1, i + 10, i + 9))]) + "\n" for i in (9 * y + x + 1 for y in range(8) for x in range(8))]
    (SHARED / "hill.obj").write_text("".join(vertices + faces))
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "capture"], ["ingest", "capture", "-o", "history"]):
        result = run(*arguments)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")
    subprocess.run(command(SHARED / "history", SHARED / "without", "--no-cache", "--quiet"), check=True, timeout=120)


def tearDownModule():
    shutil.rmtree(SHARED)


def tree_of(folder):
    """Relative path -> bytes, hidden files too; run.json differs from run to run."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "run.json"}


def transfer_of(folder):
    """The same of a transfer, but for where its history lies."""
    tree = tree_of(folder)
    tree["transfer.json"] = json.loads(tree["transfer.json"])
    del tree["transfer.json"]["history"]["path"]
    return tree


class Cache(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_cache_", dir=SHARED))
        self.history = self.folder / "history"
        shutil.copytree(SHARED / "history", self.history)
        self.kept = self.history / ".cache"

    def transfer(self, *more, output="aged", history=None, **popen):
        shutil.rmtree(self.folder / output, ignore_errors=True)
        result = subprocess.run(command(history or self.history, self.folder / output, *more), capture_output=True, text=True, timeout=120, **popen)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse(".cache" in result.stderr or "appearance" in result.stderr, result.stderr)
        self.assertEqual(transfer_of(self.folder / output), transfer_of(SHARED / "without"))

    def entries(self):
        return sorted(p.name for p in self.kept.glob("*.bin")) if self.kept.is_dir() else []

    def test_a_second_transfer_takes_what_the_first_has_kept(self):
        self.transfer()
        kept = tree_of(self.kept)
        self.assertEqual(sorted(pathlib.Path(name).suffix for name in kept), [".TAG", ".bin"])
        inode = (self.kept / self.entries()[0]).stat().st_ino
        self.transfer(output="again")
        self.assertEqual(tree_of(self.folder / "again"), tree_of(self.folder / "aged"))
        self.assertEqual(tree_of(self.kept), kept)
        self.assertEqual((self.kept / self.entries()[0]).stat().st_ino, inode, "written again")

    def test_without_it_nothing_is_kept_or_looked_at(self):
        self.transfer("--no-cache")
        self.assertFalse(self.kept.exists())
        self.assertEqual(tree_of(self.history), tree_of(SHARED / "history"))

    def test_a_damaged_file_is_mended(self):
        self.transfer()
        file = self.kept / self.entries()[0]
        whole = file.read_bytes()
        for damaged in (whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:],):
            file.write_bytes(damaged)
            self.transfer()
            self.assertEqual(file.read_bytes(), whole)

    def test_nothing_else_sees_it(self):
        self.transfer()
        for arguments in (["validate", "history"], ["info", "history"], ["history", "combine", "history", "history", "-o", "library"]):
            result = run(*arguments, cwd=self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertNotIn(".cache", result.stdout + result.stderr)
        self.assertFalse(list(self.folder.glob("library/**/.cache")))
        self.assertIn("up to date", run("ingest", "../capture", "-o", "history", cwd=self.folder).stderr)
        self.assertEqual(len(self.entries()), 1)
        self.assertEqual(run("ingest", "../capture", "--spatial-sigma", "5", "--force", "-o", "history", cwd=self.folder).returncode, 0)
        self.assertFalse(self.kept.exists(), "another history")

    @nightly
    def test_an_audit_takes_it_too(self):
        self.transfer()
        kept = tree_of(self.kept)
        for output, more in (("with", []), ("without", ["--no-cache"])):
            result = run("evaluate", "aged", "--audits", "50", *more, "-o", output, cwd=self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)
        figures = [json.loads((self.folder / name / "evaluation.json").read_text())["maps"] for name in ("with", "without")]
        self.assertEqual(figures[0], figures[1])
        self.assertEqual(tree_of(self.kept), kept)

    def test_two_at_once(self):
        processes = [subprocess.Popen(command(self.history, self.folder / f"aged{i}", "--quiet")) for i in range(2)]
        self.assertEqual([p.wait(timeout=120) for p in processes], [0, 0])
        for i in range(2):
            self.assertEqual(transfer_of(self.folder / f"aged{i}"), transfer_of(SHARED / "without"))
        self.assertEqual(len(self.entries()), 1)

    def test_killed_at_any_time_it_leaves_nothing_wrong(self):
        chance = random.Random(1)
        for i in range(5):
            shutil.rmtree(self.folder / "killed.partial", ignore_errors=True)
            shutil.rmtree(self.folder / "killed", ignore_errors=True)
            if i % 2 == 0:
                shutil.rmtree(self.kept, ignore_errors=True)
            process = subprocess.Popen(command(self.history, self.folder / "killed", "--quiet"))
            try:
                process.wait(timeout=chance.uniform(0.02, 0.15))
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
        (self.kept / f".appearance-0.tmp{process.pid}.bin").parent.mkdir(exist_ok=True)
        (self.kept / f".appearance-0.tmp{process.pid}.bin").write_bytes(b"half")
        self.transfer()
        for file in self.kept.glob("*.bin"):
            file.unlink()
        self.transfer()
        self.assertEqual(sorted(p.name for p in self.kept.iterdir()), sorted(["CACHEDIR.TAG", *self.entries()]), "what killed writers left is gone")

    def test_a_limit_for_files_keeps_nothing(self):
        """What a full disk does to a file, for the larger ones alone."""
        largest = max(p.stat().st_size for p in (SHARED / "without").iterdir())

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest + 1000, largest + 1000))
        self.transfer()
        self.assertGreater((self.kept / self.entries()[0]).stat().st_size, largest + 1000)
        shutil.rmtree(self.kept)
        self.transfer(preexec_fn=limit)
        self.assertEqual(self.entries(), [])

    def test_a_folder_that_cannot_be_written(self):
        place = self.folder / "place"
        place.mkdir()
        result = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", place], capture_output=True, text=True)
        if result.returncode != 0:
            if os.geteuid() == 0:
                self.skipTest("nothing can be mounted here: " + result.stderr.strip())
            shutil.copytree(SHARED / "history", place / "history")
            (place / "history").chmod(0o555)
            self.addCleanup((place / "history").chmod, 0o755)
            return self.transfer(history=place / "history")
        self.addCleanup(subprocess.run, ["umount", "-l", place])
        shutil.copytree(SHARED / "history", place / "history")
        free = os.statvfs(place).f_bavail * os.statvfs(place).f_frsize
        with open(place / "full", "wb") as file:
            file.write(bytes(free - 20000))
        self.transfer(history=place / "history")
        self.assertFalse(list(place.glob("history/.cache/*.bin")), "on a disk that is nearly full")
        (place / "full").unlink()
        subprocess.run(["mount", "-o", "remount,ro", place], check=True)
        self.transfer(history=place / "history")
        self.assertFalse(list(place.glob("history/.cache/*.bin")))
        subprocess.run(["mount", "-o", "remount,rw", place], check=True)
        self.transfer(history=place / "history")
        subprocess.run(["mount", "-o", "remount,ro", place], check=True)
        self.transfer(history=place / "history")
        self.assertEqual(len(list(place.glob("history/.cache/*.bin"))), 1)


if __name__ == "__main__":
    unittest.main()
