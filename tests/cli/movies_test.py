#!/usr/bin/env python3
"""Movies as they say that they are to be seen: times, turns, pixels, colors. Usage: movies_test.py PATINATE [unittest arguments]"""
import itertools
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from series_files import movie, png_pixels

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())
WIDTH, HEIGHT = 24, 16
# Numbers of ITU-T H.273.
BT709, P3, BT2020, FILM, SRGB, HLG, PQ, LOG = 1, 12, 9, 8, 13, 18, 16, 9


def scene(x, y, i):
    """Linear Rec. 709 of a pixel: a ramp to the right, two hues down; it gets darker from frame to frame."""
    level = (0.15 + 0.7 * x / (WIDTH - 1)) * (1 - 0.1 * i)
    return (level, 0.6 * level, 0.3 * level) if y < HEIGHT / 2 else (0.4 * level, 0.7 * level, level)


def srgb(v):
    return 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055


def hlg(v):
    """Code of scene light whose white, 1, has the code 0.75 [BT.2100-2, table 5]."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    e = v * (math.exp((0.75 - c) / a) + b) / 12
    return math.sqrt(3 * e) if e <= 1 / 12 else a * math.log(12 * e - b) + c


def pq(v):
    """Code of display light whose white, 1, has 203 cd/m2 [BT.2100-2, table 4; BT.2408]."""
    y = (v * 203 / 10000) ** (2610 / 16384)
    return ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32)


MATRIX_TO = {BT2020: ((0.627404, 0.329283, 0.043313), (0.069097, 0.919540, 0.011362), (0.016391, 0.088013, 0.895595)),
             P3: ((0.822462, 0.177538, 0.0), (0.033194, 0.966806, 0.0), (0.017083, 0.072397, 0.910520)), BT709: ((1, 0, 0), (0, 1, 0), (0, 0, 1))}


def frames_of(count, encode=srgb, primaries=BT709, pixel=scene):
    def code(x, y, i):
        light = pixel(x, y, i)
        return bytes(round(255 * min(1, max(0, encode(sum(m * v for m, v in zip(row, light)))))) for row in MATRIX_TO[primaries])
    return [b"".join(code(x, y, i) for y in range(HEIGHT) for x in range(WIDTH)) for i in range(count)]


def packed(values):
    """Pairs of number and bits, the lowest bit first."""
    bits = sum(value << at for value, at in zip((v for v, _ in values), itertools.accumulate((0, *(n for _, n in values)))))
    return bits.to_bytes((sum(n for _, n in values) + 7) // 8, "little")


def gif(hundredths, side=4):
    """Gray pictures, each shown for so long; codes start anew before they would need a fourth bit."""
    clear, end = 4, 5
    pictures = b""
    for i, delay in enumerate(hundredths):
        pixels = [(clear if j % 3 == 0 else i % 4, 3) for j in range(side * side * 3 // 2)]
        data = packed([*pixels, (end, 3)])
        control = b"" if delay is None else b"\x21\xf9\x04" + struct.pack("<BHBB", 0, delay, 0, 0)
        pictures += b"\x21\xfe\x04note\0" + control + struct.pack("<BHHHHB", 0x2c, 0, 0, side, side, 0)
        pictures += bytes([2, len(data)]) + data + b"\0"
    colors = b"".join(bytes([level] * 3) for level in (20, 90, 160, 230))
    return b"GIF89a" + struct.pack("<HHBBB", side, side, 0x81, 0, 0) + colors + pictures + b"\x3b"


def webp(milliseconds, side=4):
    """Pictures of one color [RFC 9649], each shown for so long."""
    def chunk(name, data):
        return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)
    frames = b""
    for i, delay in enumerate(milliseconds):
        codes = [(part, bits) for symbol in (40 * i, 40 * i, 40 * i, 255, 0) for part, bits in ((1, 1), (0, 1), (1, 1), (symbol, 8))]
        bits = packed([(0x2f, 8), (side - 1, 14), (side - 1, 14), (0, 1), (0, 3), (0, 1), (0, 1), (0, 1), *codes])
        place = b"".join(n.to_bytes(3, "little") for n in (0, 0, side - 1, side - 1, delay)) + b"\0"
        frames += chunk(b"ANMF", place + chunk(b"VP8L", bits))
    head = chunk(b"VP8X", b"\x02\0\0\0" + 2 * (side - 1).to_bytes(3, "little")) + chunk(b"ANIM", bytes(6))
    return b"RIFF" + struct.pack("<I", 4 + len(head + frames)) + b"WEBP" + head + frames


class Movies(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_patinate(self, *arguments):
        return subprocess.run([PATINATE, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120)

    def ingest(self, data, **frames):
        (self.folder / "m.mov").write_bytes(data)
        content = {"format": "patinate.capture", "version": 1, "name": "movie", "kind": "fixed", "frames": {"pattern": "m.mov", **frames}}
        (self.folder / "capture.json").write_text(json.dumps(content))
        return self.run_patinate("ingest", "capture.json", "-o", "out", "--force")

    def history(self, data, **frames):
        run = self.ingest(data, **frames)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stderr

    def times(self):
        return [frame["time"] for frame in json.loads((self.folder / "out/history.json").read_text())["frames"]]

    def shown(self, i=0):
        """Pixels of a frame of the history, in sRGB codes."""
        run = self.run_patinate("export", "out", "-o", "images", "--format", "png", "--force")
        self.assertEqual(run.returncode, 0, run.stderr)
        return png_pixels(sorted((self.folder / "images").glob("*.png"))[i].read_bytes())

    def expect_scene(self, tolerance, i=0):
        rows = self.shown(i)
        self.assertEqual((len(rows), len(rows[0])), (HEIGHT, WIDTH))
        for y in range(HEIGHT):
            for x in range(WIDTH):
                for found, light in zip(rows[y][x], scene(x, y, i)):
                    self.assertLessEqual(abs(found - 255 * srgb(light)), tolerance, (x, y, rows[y][x], scene(x, y, i)))

    def test_frames_have_the_times_at_which_they_are_shown(self):
        durations = [120, 80, 120, 1000, 1000]
        stderr = self.history(movie(frames_of(5), WIDTH, HEIGHT, durations))
        self.assertEqual(self.times(), [0, 0.12, 0.2, 0.32, 1.32])
        self.assertIn("times from when the movie shows its images", stderr)
        self.assertIn("shown from 0 to 1.32 s", self.run_patinate("info", "m.mov").stdout)
        self.history(movie(frames_of(5), WIDTH, HEIGHT, durations), every=2)
        self.assertEqual(self.times(), [0, 0.2, 1.32])
        self.history(movie(frames_of(4), WIDTH, HEIGHT, [1001] * 4, timescale=30000))
        self.assertEqual([round(t, 9) for t in self.times()], [round(i * 1001 / 30000, 9) for i in range(4)])

    def test_animations_have_the_times_at_which_they_are_shown(self):
        for name, data in (("a.gif", gif([12, 8, 12, 100, 0])), ("a.webp", webp([120, 80, 120, 1000, 0]))):
            (self.folder / name).write_bytes(data)
            with self.subTest(name):
                stderr = self.history(b"", pattern=name)
                self.assertEqual(self.times(), [0, 0.12, 0.2, 0.32, 1.32])
                self.assertIn("times from when the movie shows its images", stderr)
                self.assertIn("shown from 0 to 1.32 s", self.run_patinate("info", name).stdout)
                # What the project states counts.
                self.history(b"", pattern=name, interval=2)
                self.assertEqual(self.times(), [0, 2, 4, 6, 8])

    def test_an_animation_without_times_asks_for_them(self):
        for delays in ([10, 0, 10], [0, 0, 0], [None, None, None]):
            (self.folder / "a.gif").write_bytes(gif(delays))
            self.assertIn("does not say when its images were taken; give `interval`", self.ingest(b"", pattern="a.gif").stderr)

    def test_further_pictures_of_a_photograph_are_said(self):
        self.history(movie(frames_of(2), WIDTH, HEIGHT, [100, 100]))
        self.assertEqual(self.run_patinate("render", "out", "--time", "0", "-o", "plain.jpg").returncode, 0)
        plain = (self.folder / "plain.jpg").read_bytes()
        for order, mark in (("<", b"II*\0"), (">", b"MM\0*")):
            for count, said in ((1, None), (2, "the first picture of 2 (MPF)"), (300, "the first picture of 300 (MPF)")):
                index = mark + struct.pack(order + "IH", 8, 2) + struct.pack(order + "HHI4s", 0xb000, 7, 4, b"0100")
                index += struct.pack(order + "HHII", 0xb001, 4, 1, count) + bytes(4)
                (self.folder / "photo.jpg").write_bytes(plain[:2] + b"\xff\xe2" + struct.pack(">H", 6 + len(index)) + b"MPF\0" + index + plain[2:])
                self.assertEqual(json.loads(self.run_patinate("info", "photo.jpg", "--json").stdout).get("page"), said)

    def test_an_edit_list_takes_frames_away(self):
        # 0.32 s of the movie from 0.2 s on: the frames from the third on.
        self.history(movie(frames_of(5), WIDTH, HEIGHT, [120, 80, 120, 1000, 1000], edits=[(1120, 200)]))
        self.assertEqual(self.times(), [0, 0.12])

    def test_pictures_lie_as_players_show_them(self):
        stored = [[scene(x, y, 0) for x in range(WIDTH)] for y in range(HEIGHT)]
        turns = {(0, 1, -1, 0): lambda r: [list(c) for c in zip(*r[::-1])], (-1, 0, 0, -1): lambda r: [row[::-1] for row in r[::-1]],
                 (0, -1, 1, 0): lambda r: [list(c) for c in zip(*r)][::-1], (-1, 0, 0, 1): lambda r: [row[::-1] for row in r]}
        for turn, of in turns.items():
            self.history(movie(frames_of(2), WIDTH, HEIGHT, [100, 100], turn=turn))
            expected, found = of(stored), self.shown()
            self.assertEqual((len(found), len(found[0])), (len(expected), len(expected[0])), turn)
            for y in range(len(expected)):
                for x in range(len(expected[0])):
                    for a, b in zip(found[y][x], expected[y][x]):
                        self.assertLessEqual(abs(a - 255 * srgb(b)), 1, (turn, x, y))

    def test_a_turn_that_is_no_quarter_is_refused(self):
        run = self.ingest(movie(frames_of(2), WIDTH, HEIGHT, [100, 100], turn=(1, 1, -1, 1)))
        self.assertEqual(run.returncode, 3)
        self.assertIn("m.mov: is shown rotated by an angle that is no multiple of 90 degrees", run.stderr)

    def test_pixels_become_square(self):
        for aspect, width in (((4, 3), 32), ((1, 2), 12), ((16, 11), 35)):
            self.history(movie(frames_of(2), WIDTH, HEIGHT, [100, 100], aspect=aspect))
            rows = self.shown()
            self.assertEqual((len(rows), len(rows[0])), (HEIGHT, width), aspect)
            for x in range(2, width - 2):  # Inside, a ramp stays one; a code of 8 bits differs by 5 from pixel to pixel.
                light = scene((x + 0.5) * WIDTH / width - 0.5, 2, 0)
                self.assertLessEqual(abs(rows[2][x][0] - 255 * srgb(light[0])), 2, (aspect, x))
        self.history(movie(frames_of(2), WIDTH, HEIGHT, [100, 100], aspect=(4, 3), turn=(0, 1, -1, 0)))
        self.assertEqual((len(self.shown()), len(self.shown()[0])), (32, HEIGHT))

    def test_colors_are_those_that_the_movie_says(self):
        # A code of 8 bits more or less is up to 5 of sRGB's in the dark parts of HLG and PQ (their slopes differ).
        for encode, primaries, transfer, tolerance, said in ((hlg, BT2020, HLG, 3, "HLG with BT.2020"), (pq, BT2020, PQ, 6, "PQ with BT.2020"), (hlg, BT709, HLG, 3, "HLG with BT.709"),
                                                             (srgb, P3, SRGB, 2, "sRGB with Display P3"), (srgb, BT2020, BT709, 3, "sRGB with BT.2020"), (srgb, BT709, BT709, 1, "")):
            stderr = self.history(movie(frames_of(2, encode, primaries), WIDTH, HEIGHT, [100, 100], color=(primaries, transfer, 0)))
            self.assertEqual(said != "", f"color: {said} colors, made linear Rec. 709" in stderr, stderr)
            self.expect_scene(tolerance)
            self.expect_scene(tolerance, 1)
            self.assertIn(said, self.run_patinate("info", "m.mov").stdout)

    def test_colors_that_are_not_read_are_refused_by_their_names(self):
        for color, name in (((BT709, LOG, 0), "log"), ((FILM, BT709, 0), "film")):
            run = self.ingest(movie(frames_of(2), WIDTH, HEIGHT, [100, 100], color=color))
            self.assertEqual(run.returncode, 3, run.stderr)
            self.assertRegex(run.stderr, rf"m\.mov: has the (transfer|primaries) {name}")

    def test_an_odd_movie_has_the_same_bytes_every_time(self):
        self.history(movie(frames_of(3), WIDTH, HEIGHT, [100] * 3))
        made = set()
        for k in range(3):
            run = subprocess.run([PATINATE, "export", "out", "-o", f"{k}.mp4", "--num-times", "3"], cwd=self.folder, capture_output=True, text=True, timeout=120,
                                 env={"MALLOC_PERTURB_": str(60 * k + 1), "PATH": "/usr/bin:/bin"})
            if "no encoder" in run.stderr:
                self.skipTest("libavcodec has no encoder for it here")
            self.assertEqual(run.returncode, 0, run.stderr)
            made.add((self.folder / f"{k}.mp4").read_bytes())
        self.assertEqual(len(made), 1)


if __name__ == "__main__":
    unittest.main()
