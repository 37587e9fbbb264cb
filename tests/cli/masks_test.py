#!/usr/bin/env python3
"""What is inside of a mask, however it was saved. Usage: masks_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from series_files import png, png_pixels

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())
WIDTH, HEIGHT = 48, 40


def is_inside(x, y):
    return (x - 22) ** 2 + (y - 18) ** 2 < 150


def picture(x, y):
    return (90 + 3 * x) % 256, (200 - 2 * y) % 256, (60 + 5 * ((x * y) % 23)) % 256


class Masks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for i in range(3):
            (self.folder / f"f{i}.png").write_bytes(png(WIDTH, HEIGHT, lambda x, y: [min(255, v + (5 * i if x > 20 else 0)) for v in picture(x, y)]))
        content = {"format": "patinate.capture", "version": 1, "name": "masked", "kind": "fixed", "frames": {"pattern": "f*.png", "interval": 1}, "mask": "mask.png"}
        (self.folder / "capture.json").write_text(json.dumps(content))

    def ingest(self, pixel, channels):
        (self.folder / "mask.png").write_bytes(png(WIDTH, HEIGHT, pixel, channels))
        return subprocess.run([PATINATE, "ingest", "capture.json", "-o", "out", "--force", "--highlights", "keep"], cwd=self.folder, capture_output=True, text=True, timeout=120)

    def expect_mask(self, pixel, channels, what):
        run = self.ingest(pixel, channels)
        self.assertEqual(run.returncode, 0, what + run.stderr)
        rows = png_pixels((self.folder / "out/mask.png").read_bytes())
        found = {(x, y) for y in range(HEIGHT) for x in range(WIDTH) if rows[y][x][0] >= 128}
        truth = {(x, y) for y in range(HEIGHT) for x in range(WIDTH) if is_inside(x, y)}
        self.assertGreaterEqual(len(found & truth) / len(found | truth), 0.99, what)

    def expect_refusal(self, pixel, channels, about):
        run = self.ingest(pixel, channels)
        self.assertEqual(run.returncode, 3, about)
        self.assertRegex(run.stderr, r"mask\.png: " + about)

    def test_an_object_that_is_cut_out_is_what_is_opaque(self):
        alpha = lambda x, y: 255 if is_inside(x, y) else 0
        self.expect_mask(lambda x, y: (*picture(x, y), alpha(x, y)), 4, "a photograph's colors everywhere")
        self.expect_mask(lambda x, y: (*picture(x, y), 255) if is_inside(x, y) else (0, 0, 0, 0), 4, "black outside")
        self.expect_mask(lambda x, y: (*picture(x, y), 255) if is_inside(x, y) else (255, 255, 255, 0), 4, "white outside")
        self.expect_mask(lambda x, y: (picture(x, y)[0], alpha(x, y)), 2, "gray")
        self.expect_mask(lambda x, y: (0, 0, 0, alpha(x, y)), 4, "all black")
        self.expect_mask(lambda x, y: (255, 255, 255, alpha(x, y)), 4, "all white")
        self.expect_mask(lambda x, y: (255, 255) if is_inside(x, y) else (0, 0), 2, "a mask in both")

    def test_alpha_that_is_the_same_everywhere_says_nothing(self):
        for alpha in (255, 0, 128):
            self.expect_mask(lambda x, y: (255 if is_inside(x, y) else 0, alpha), 2, f"gray with alpha {alpha}")
            self.expect_mask(lambda x, y: (*[255 if is_inside(x, y) else 0] * 3, alpha), 4, f"color with alpha {alpha}")

    def test_labels_are_inside_where_they_are_not_black(self):
        labels = [(0, 0, 255), (255, 0, 0), (0, 128, 0), (40, 0, 60)]
        for count in range(1, 5):
            self.expect_mask(lambda x, y: labels[(x // 8) % count] if is_inside(x, y) else (0, 0, 0), 3, f"{count} colors")
        self.expect_mask(lambda x, y: [1 + x // 16 if is_inside(x, y) else 0], 1, "indices in gray")
        self.expect_mask(lambda x, y: [1 if is_inside(x, y) else 0], 1, "zeros and ones")

    def test_gray_is_inside_from_the_middle_on(self):
        self.expect_mask(lambda x, y: [255 if is_inside(x, y) else 0], 1, "black and white")
        self.expect_mask(lambda x, y: [200 if is_inside(x, y) else 30] * 3, 3, "two grays")
        self.expect_mask(lambda x, y: [max(0, min(255, int(127.5 + 12 * (150 - (x - 22) ** 2 - (y - 18) ** 2) / 10)))], 1, "a soft edge")

    def test_what_does_not_say_what_is_inside_is_refused(self):
        self.expect_refusal(picture, 3, "is a picture in color without transparency")
        self.expect_refusal(lambda x, y: (255, 0, 0) if is_inside(x, y) else (0, 0, 255), 3, "has 2 colors, none of them black")
        self.expect_refusal(lambda x, y: [(85 if x < 22 else 255) if is_inside(x, y) else 0], 1, r"has several levels of gray \(0, 85, 255\)")
        self.expect_refusal(lambda x, y: [(0 if x < 22 else 255), 255] if is_inside(x, y) else [0, 0], 2, "has a transparent part, and is black and white")


if __name__ == "__main__":
    unittest.main()
