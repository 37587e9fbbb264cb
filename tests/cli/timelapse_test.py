"""Time-lapses as they are, as a user meets them: findings named, repairs on request, masks."""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = pathlib.Path(sys.argv.pop(1)).resolve()


def write_png(path, width, height, color):
    rows = b"".join(b"\0" + bytes(v for x in range(width) for v in color(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def texture(x, y):
    """Blocks of 4 px with pseudo-random brightness."""
    return 60 + (((x // 4) * 7919 + (y // 4) * 104729 + (x // 4) * (y // 4) * 31) % 97)


class TimeLapse(unittest.TestCase):
    def setUp(self):
        self.temp = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temp.name)
        (self.folder / "frames").mkdir()
        for i in range(8):
            moved = 3 if i >= 4 else 0
            glint = i == 2

            def color(x, y):
                value = texture(x + 100 - moved, y + 100) - 2 * i
                return (255, 255, 255) if glint and 40 <= x < 44 and 40 <= y < 44 else (value, value, value)

            write_png(self.folder / f"frames/{i}.png", 96, 96, color)
        (self.folder / "capture.json").write_text(json.dumps({
            "format": "patinate.capture", "version": 1, "name": "test", "kind": "fixed",
            "frames": {"pattern": "frames/*.png", "interval": 1}}))

    def tearDown(self):
        self.temp.cleanup()

    def run_ingest(self, *options):
        return subprocess.run([PATINATE, "ingest", "capture.json", "-o", "out", *options], cwd=self.folder, capture_output=True, text=True)

    def test_a_moved_photograph_is_named_with_its_direction(self):
        run = self.run_ingest()
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, r"4\.png .*moved by 3 px right and 0 px")
        self.assertIn("--stabilize", run.stderr)
        warnings = json.loads((self.folder / "out/history.json").read_text())["warnings"]
        self.assertEqual([(w["about"], w["photos"]) for w in warnings if w["about"] == "motion"], [("motion", ["4.png"])])
        info = subprocess.run([PATINATE, "info", "out"], cwd=self.folder, capture_output=True, text=True)
        self.assertIn(warnings[0]["text"], info.stdout)
        survey = json.loads((self.folder / "out/survey.json").read_text())
        self.assertEqual([f["photo"] for f in survey["findings"] if f["is_shifted"]], ["4.png"])
        self.assertAlmostEqual(survey["findings"][0]["shift_px"][0], 3.0, delta=0.1)

    def test_stabilizing_masks_what_left_the_view(self):
        run = self.run_ingest("--stabilize", "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual([w for w in json.loads(run.stdout)["warnings"] if w["about"] == "motion"], [], "repaired")
        result = json.loads(run.stdout)
        self.assertGreaterEqual(result["outside_share"], 0.02)  # 3 of 96 columns are not seen at the end.
        self.assertLess(result["outside_share"], 0.08)  # A few rows and columns more: the motion is measured, not known.
        self.assertIn("mask", json.loads((self.folder / "out/history.json").read_text()))

    def test_a_glint_is_masked_in_its_frame_and_filled(self):
        self.assertEqual(self.run_ingest().returncode, 0)
        frames = json.loads((self.folder / "out/history.json").read_text())["frames"]
        self.assertEqual(frames[2]["file"], "filled/0002.exr")
        self.assertEqual(frames[2]["mask"], "masks/0002.png")
        self.assertEqual(frames[1]["file"], "frames/0001.exr")

    def test_kept_highlights_leave_frames_as_they_are(self):
        self.assertEqual(self.run_ingest("--highlights", "keep").returncode, 0)
        frames = json.loads((self.folder / "out/history.json").read_text())["frames"]
        self.assertTrue(all("mask" not in f and f["file"].startswith("frames/") for f in frames))

    def test_repairs_resume_and_are_up_to_date(self):
        self.assertEqual(self.run_ingest("--stabilize", "--deflicker").returncode, 0)
        again = self.run_ingest("--stabilize", "--deflicker")
        self.assertEqual(again.returncode, 0)
        self.assertIn("up to date", again.stderr)
        other = self.run_ingest("--stabilize")
        self.assertEqual(other.returncode, 1, "another option is another history")

    def test_mistakes_are_named(self):
        self.assertEqual(self.run_ingest("--highlights", "hide").returncode, 2)
        missing = self.run_ingest("--flat-field", "card.png")
        self.assertEqual(missing.returncode, 3)
        self.assertIn("card.png", missing.stderr)
        write_png(self.folder / "small.png", 8, 8, lambda x, y: (200, 200, 200))
        small = self.run_ingest("--flat-field", "small.png")
        self.assertEqual(small.returncode, 3)
        self.assertIn("as large as the frames", small.stderr)


if __name__ == "__main__":
    unittest.main()
