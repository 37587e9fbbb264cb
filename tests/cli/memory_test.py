#!/usr/bin/env python3
"""How much memory grows with an atlas. Usage: memory_test.py PATINATE [unittest arguments]"""
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_memory_"))
SMALL, LARGE = 512, 2048


def peak_bytes(*arguments):
    """Of one command, which must succeed."""
    child = os.posix_spawn(PATINATE, [PATINATE, *map(str, arguments), "--quiet"], os.environ)
    _, status, usage = os.wait4(child, 0)
    if status != 0:
        raise RuntimeError(f"{arguments}: status {status}")
    return usage.ru_maxrss * 1024


def setUpModule():
    peak_bytes("synth", "crackle", "--width", "96", "--height", "96", "--num-frames", "3", "-o", SHARED / "capture")
    peak_bytes("synth", "sculpture", "--resolution", "24", "-o", SHARED / "urn")
    peak_bytes("ingest", SHARED / "capture", "-o", SHARED / "history")


def tearDownModule():
    shutil.rmtree(SHARED)


class Memory(unittest.TestCase):
    """Between two sizes: what the program, its libraries and the history take is in both. Allocators round by some MB, which is 1 byte a texel here."""

    def growth(self, command):
        return (command(LARGE) - command(SMALL)) / (LARGE**2 - SMALL**2)

    def test_a_transfer_takes_at_most_24_bytes_a_texel_and_its_textures_go_by_strips(self):
        quick = ["--coarse-passes", "1", "--fine-passes", "1", "--random-candidates", "0", "--quality", "draft"]  # Passes take time, not memory.
        self.assertLess(self.growth(lambda side: peak_bytes("transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--resolution", side, "--control", "thickness=facing",
                                                            "--atlas", "uv", *quick, "-o", SHARED / f"aged{side}")), 24 + 1)
        # Coordinates are kept up to 4k: 4 bytes a texel. A strip of 2^21 texels, its gutters and what is written of it take 26 bytes a texel, which the small atlas has an eighth of.
        strips = 4 + 26 * (2**21 - SMALL**2) / (LARGE**2 - SMALL**2)
        for name, command in (("x.png", ["texture", "--time", "7.5"]), ("x.glb", ["export", "--times", "0,7.5,15"])):
            with self.subTest(name):
                self.assertLess(self.growth(lambda side: peak_bytes(command[0], SHARED / f"aged{side}", *command[1:], "-o", SHARED / f"{side}{name}")), strips)

    def test_borders_are_refined_window_by_window(self):
        quick = ["--coarse-passes", "1", "--fine-passes", "1", "--random-candidates", "0"]
        peaks = [peak_bytes("transfer", SHARED / "history", SHARED / "urn/mesh.obj", "--resolution", 768, "--control", "thickness=facing",
                            "--atlas", "uv", *quick, "--quality", quality, "-o", SHARED / f"aged_{quality}") for quality in ("draft", "good")]
        # A byte a texel says what is taken, bands beside seams are stored once more, and each of the threads has a window; all patches of a round would take 160 bytes a texel.
        self.assertLess(peaks[1] - peaks[0], 8 * 768**2 + 2**25)


if __name__ == "__main__":
    unittest.main()
