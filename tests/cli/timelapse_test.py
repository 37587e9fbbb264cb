"""Time-lapses as they are, as a user meets them: findings named, repairs on request, masks."""

import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = pathlib.Path(sys.argv.pop(1)).resolve()


def exif(seconds_inverse, f_number, iso, is_auto):
    """The bytes of EXIF data: exposure time 1 / seconds_inverse, f-number, ISO and white balance."""
    entries = [(0x829A, 5, 1, None), (0x829D, 5, 1, None), (0x8827, 3, 1, iso), (0xA403, 3, 1, 0 if is_auto else 1)]
    start = 8 + 2 + 12 + 4
    values = start + 2 + 12 * len(entries) + 4
    data = b"MM\0*" + struct.pack(">I", 8) + struct.pack(">HHHII", 1, 0x8769, 4, 1, start) + struct.pack(">I", 0)
    data += struct.pack(">H", len(entries))
    rationals = [(1, seconds_inverse), (round(10 * f_number), 10)]
    for k, (tag, kind, count, value) in enumerate(entries):
        data += struct.pack(">HHI", tag, kind, count)
        data += struct.pack(">I", values + 8 * k) if value is None else struct.pack(">HH", value, 0)
    return data + struct.pack(">I", 0) + b"".join(struct.pack(">II", *r) for r in rationals)


def write_png(path, width, height, color, exif_data=None):
    rows = b"".join(b"\0" + bytes(v for x in range(width) for v in color(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + (chunk(b"eXIf", exif_data) if exif_data else b"")
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


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

    def one_photograph(self, color):
        for i in range(1, 8):
            (self.folder / f"frames/{i}.png").unlink()
        write_png(self.folder / "frames/0.png", 96, 96, color)

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

    def write_frame(self, number, color):
        write_png(self.folder / f"frames/{number}.png", 96, 96, color)

    def test_photographs_of_other_things_are_named_with_what_to_exclude(self):
        (self.folder / "capture.json").write_text(json.dumps({
            "format": "patinate.capture", "version": 1, "name": "test", "kind": "fixed", "exclude": [1],
            "frames": {"pattern": "frames/*.png", "interval": 1}}))
        self.write_frame(5, lambda x, y: (texture(300 - y, 7 * x % 400),) * 3)
        run = self.run_ingest("--stabilize", "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        lost = [w for w in json.loads(run.stdout)["warnings"] if w.get("photos") == ["5.png"]]
        self.assertEqual(len(lost), 1, run.stdout)
        self.assertIn("cannot be aligned with the others", lost[0]["text"])
        self.assertIn('"exclude": [1, 5]', lost[0]["cure"])  # With what is excluded already: ready to paste.
        frames = json.loads((self.folder / "out/survey.json").read_text())["frames"]
        status = {frame["photo"]: frame["status"] for frame in frames}
        self.assertEqual((status["0.png"], status["5.png"], status["6.png"]), ("not moved", "unlinked", "registered"))

    def test_what_cannot_be_compared_is_named_once_and_its_neighbors_are_not(self):
        for i in (0, 2, 4, 6):
            self.write_frame(i, lambda x, y: (texture(300 - y, 7 * x % 400),) * 3)
        for i in (1, 3, 5, 7):
            self.write_frame(i, lambda x, y: (texture(x + 100, y + 100),) * 3)
        run = self.run_ingest("--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        about = [w for w in json.loads(run.stdout)["warnings"] if w["about"] in ("series", "motion", "light")]
        self.assertEqual([w["photos"] for w in about], [["1.png", "3.png", "5.png", "7.png"]])

    def test_a_move_too_far_to_measure_is_bridged_over_earlier_photographs(self):
        for i, moved in enumerate([0, 0, 20, 20, 20, -20, -20, -20]):  # A quarter of 96 px can be measured.
            self.write_frame(i, lambda x, y: (texture(x + 100 - moved, y + 100) - 2 * i,) * 3)
        run = self.run_ingest("--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        warnings = json.loads(run.stdout)["warnings"]
        self.assertEqual([w for w in warnings if "cannot be aligned with the others" in w["text"]], [], "5 fits 0 and 1")
        self.assertEqual([w["photos"] for w in warnings if "cannot be aligned with the one before" in w["text"]], [["5.png"]])

    def test_a_series_in_which_nothing_fits_is_not_stabilized_and_says_so_without(self):
        for i in range(8):
            self.write_frame(i, lambda x, y: (texture(977 * (i + 1) + (3 + i) * x, 613 * i + (11 - i) * y),) * 3)
        run = self.run_ingest("--stabilize")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("none of the 8 photographs can be aligned with another one", run.stderr)
        self.assertFalse((self.folder / "out/history.json").exists())
        run = self.run_ingest("--json", "--force")
        self.assertEqual(run.returncode, 0, run.stderr)
        worst = json.loads(run.stdout)["warnings"][0]
        self.assertEqual((worst["share"], worst["photos"]), (1.0, [f"{i}.png" for i in range(8)]))

    def test_a_first_photograph_that_is_larger_and_bluer_is_blamed_wherever_the_history_goes(self):
        def color(i, x, y):
            value = (texture(x + 100, y + 100) - 2 * i)
            return (value, value, value)

        for i in range(8):
            self.write_frame(i, lambda x, y: color(i, x, y))
        self.write_frame(0, lambda x, y: color(0, round(x / 1.05), round(y / 1.05))[:2] + (min(255, int(color(0, round(x / 1.05), round(y / 1.05))[2] * 1.3)),))
        self.assertEqual(self.run_ingest().returncode, 0)
        warnings = json.loads((self.folder / "out/history.json").read_text())["warnings"]
        found = {w["about"]: w for w in warnings if w.get("photos") == ["0.png"]}
        self.assertIn("% larger against the one after it", found["motion"]["text"])
        self.assertIn("light times", found["light"]["text"])
        self.assertIn('"exclude": [0]', found["light"]["cure"])
        compare = subprocess.run([PATINATE, "history", "compare", "out", "out", "-o", "report"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(compare.returncode, 0, compare.stderr)
        self.assertIn(f"out has {len(warnings)} warnings about its photographs; `patinate info out` lists them\n", compare.stderr)
        for text in ((self.folder / "report" / name).read_text() for name in ("report.json", "report.html")):
            for about in ("motion", "light"):
                self.assertIn(found[about]["text"].split(": ")[1], text)

    def test_photographs_of_one_name_have_names_of_their_own(self):
        (self.folder / "more").mkdir()
        for name, of in (("frames", 0), ("more", 1)):
            write_png(self.folder / name / "same.png", 96, 96, lambda x, y: (texture(x + 3 * of, y),) * 3)
        (self.folder / "capture.json").write_text(json.dumps({
            "format": "patinate.capture", "version": 1, "name": "test", "kind": "fixed",
            "frames": [{"time": 0, "photo": "frames/same.png"}, {"time": 1, "photo": "more/same.png"}]}))
        self.assertEqual(self.run_ingest("--stabilize").returncode, 0)
        frames = json.loads((self.folder / "out/survey.json").read_text())["frames"]
        self.assertEqual([f["photo"] for f in frames], ["same.png (number 0)", "same.png (number 1)"])

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

    def test_a_single_photograph_says_how_much_is_masked(self):
        # Stripes of pure white, 12 px wide, on black: reflections, for all that one photograph tells. They cover half of it.
        self.one_photograph(lambda x, y: (255, 255, 255) if x // 12 % 2 else (40, 40, 40))
        run = self.run_ingest("--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        result = json.loads(run.stdout)
        self.assertGreater(result["outside_share"], 0.2)
        warnings = json.loads((self.folder / "out/history.json").read_text())["warnings"]
        self.assertEqual([w["about"] for w in warnings], ["mask"])
        self.assertAlmostEqual(warnings[0]["share"], result["outside_share"], places=3)
        self.assertIn("saturated or in a highlight", run.stderr)
        self.assertIn("--highlights keep", run.stderr)

    def test_a_single_photograph_of_white_material_is_kept(self):
        # Gray blocks of 4 px, 225 to 255 bright, with dark cracks: the brightest blocks are clipped.
        self.one_photograph(lambda x, y: (60, 60, 60) if x % 24 < 2 or y % 24 < 2 else (min(255, texture(x, y) * 3 // 8 + 204),) * 3)
        run = self.run_ingest("--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertLess(json.loads(run.stdout)["outside_share"], 0.05)
        self.assertNotIn("warning", run.stderr)

    def test_repairs_resume_and_are_up_to_date(self):
        self.assertEqual(self.run_ingest("--stabilize", "--deflicker").returncode, 0)
        again = self.run_ingest("--stabilize", "--deflicker")
        self.assertEqual(again.returncode, 0)
        self.assertIn("up to date", again.stderr)
        other = self.run_ingest("--stabilize")
        self.assertEqual(other.returncode, 1, "another option is another history")

    def rewrite(self, num_frames, color, exif_of=lambda i: None):
        """Frames of 64 x 64 that replace those of setUp()."""
        for file in (self.folder / "frames").iterdir():
            file.unlink()
        for i in range(num_frames):
            write_png(self.folder / f"frames/{i}.png", 64, 64, lambda x, y: color(i, x, y), exif_of(i))

    def test_exposure_by_exif_is_listed_and_warned_of_when_it_varies(self):
        def gray(i, x, y):
            return (texture(x, y),) * 3

        self.rewrite(4, gray, lambda i: exif(60 if i < 3 else 900, 2.0, 100, i != 2))
        info = json.loads(subprocess.run([PATINATE, "info", "frames/0.png", "--json"], cwd=self.folder, capture_output=True, text=True).stdout)
        self.assertAlmostEqual(info["exposure_time_s"], 1 / 60, places=6)
        self.assertEqual((info["f_number"], info["iso"], info["white_balance"]), (2.0, 100.0, "auto"))
        run = self.run_ingest()
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, r"exposure varies 15-fold by EXIF, from 3\.png \(1/900 s, f/2, ISO 100\) to 0\.png")
        self.assertIn("white balance is automatic in some", run.stderr)
        self.rewrite(4, gray, lambda i: exif(60, 2.0, 100, True))
        self.assertNotIn("EXIF", self.run_ingest("--force").stderr)

    def test_uneven_light_is_warned_of_and_what_was_divided_out_is_said(self):
        def lit(i, x, y):
            surface = 90 + (((x // 4) * 7919 + (y // 4) * 104729 + (i // 3) * 3571 * (x // 4 + 7) * (y // 4 + 3)) % 97)
            return (round(surface * 1.56 ** (-x / 63 / 2.2)),) * 3  # 1.56 : 1 of light, 2.2 being about the gamma of sRGB.

        self.rewrite(6, lit)
        run = self.run_ingest()
        self.assertRegex(run.stderr, r"the light is uneven, 1\.[56]\d? : 1 over the picture")
        self.assertIn("--flat-field estimate", run.stderr)
        repaired = self.run_ingest("--flat-field", "estimate", "--force")
        self.assertNotIn("light is uneven", repaired.stderr)
        self.assertRegex(repaired.stderr, r"flat field: 1\.[56]\d? : 1 divided out, factors .*; 1(\.0\d)? : 1 is left")
        survey = json.loads((self.folder / "out/survey.json").read_text())
        self.assertLess(survey["uneven_light"]["ratio"], 1.1)
        self.assertEqual(len(survey["flat_field"]["ranges"]), 3)

    def test_what_a_new_plate_mirrors_is_taken_out_as_far_as_it_still_shows(self):
        shares = (1.0, 0.6, 0.3)

        def polished(i, x, y):
            stain = 25 if i > 0 and (x // 6 + y // 5) % 4 == 0 else 0
            return (round((90 + stain) * (1 + 0.4 * math.sin(0.15 * x)) ** shares[i]),) * 3

        self.rewrite(len(shares), polished)
        run = self.run_ingest("--flat-field", "first")
        self.assertEqual(run.returncode, 0, run.stderr)
        last = json.loads((self.folder / "out/survey.json").read_text())["flat_field"]["last_shares"]
        self.assertLess(max(abs(share - shares[-1]) for share in last), 0.05)
        self.assertRegex(run.stderr, r"flat field: .*; the last photograph still showed 0\.[23]\d*, .* of it")
        self.assertEqual(self.run_ingest("--flat-field", "first").returncode, 0)

    def test_a_first_photograph_that_is_even_already_divides_nothing_out(self):
        # A step of 3 codes of 90 is 1.033^2.2 = 1.07 of the light, one of 1 code 1.025; the limit is 1.05.
        for step, is_even in ((1, True), (3, False)):
            self.rewrite(3, lambda i, x, y, step=step: (90 + step * (x >= 32) + (25 if i > 0 and (x // 6 + y // 5) % 4 == 0 else 0),) * 3)
            plain = self.run_ingest("--force")
            frames = [p.read_bytes() for p in sorted((self.folder / "out/frames").glob("*.exr"))]
            divided = self.run_ingest("--flat-field", "first", "--force")
            self.assertEqual((plain.returncode, divided.returncode), (0, 0), divided.stderr)
            self.assertEqual("flat field: the first photograph is even already (1.0" in divided.stderr, is_even, divided.stderr)
            self.assertEqual("; nothing is divided out\n" in divided.stderr, is_even)
            self.assertEqual("still showed" in divided.stderr, not is_even)
            self.assertEqual([p.read_bytes() for p in sorted((self.folder / "out/frames").glob("*.exr"))] == frames, is_even)

    def test_a_flat_field_is_estimated_inside_the_mask(self):
        def on_a_table(i, x, y):
            if 16 <= x < 48 and 16 <= y < 48:
                return (60 + ((x // 4) * 7919 + (y // 4) * 104729) % 3 + i,) * 3
            return (120 + 2 * x,) * 3  # The table is brighter on one side.

        self.rewrite(4, on_a_table)
        write_png(self.folder / "mask.png", 64, 64, lambda x, y: (255 if 16 <= x < 48 and 16 <= y < 48 else 0,) * 3)
        project = json.loads((self.folder / "capture.json").read_text())
        for given, options in (({"mask": "mask.png"}, ()), ({}, ("--mask-background", "unchanging"))):
            (self.folder / "capture.json").write_text(json.dumps({**project, **given}))
            run = self.run_ingest("--flat-field", "estimate", *options, "--force")
            self.assertEqual(run.returncode, 0, run.stderr)
            ratio = json.loads((self.folder / "out/survey.json").read_text())["flat_field"]["ratio"]
            self.assertLess(ratio, 1.1, "the plate is even; over all of the picture it is 1.5 and more")

    def test_deflicker_changes_no_photograph_that_it_does_not_name(self):
        factors = [1.0, 1.004, 0.996, 1.4, 0.997, 1.003, 1.0, 1.3]
        self.rewrite(len(factors), lambda i, x, y: (min(255, round(texture(x, y) * factors[i] ** (1 / 2.2))),) * 3)
        self.assertEqual(self.run_ingest().returncode, 0)
        before = [(self.folder / f"out/frames/{i:04d}.exr").read_bytes() for i in range(len(factors))]
        run = self.run_ingest("--deflicker", "--force")
        self.assertEqual(run.returncode, 0, run.stderr)
        named = {p["photo"] for p in json.loads((self.folder / "out/survey.json").read_text())["deflicker"]["changed"]}
        self.assertIn("3.png", named)
        for i in range(len(factors)):
            is_same = (self.folder / f"out/frames/{i:04d}.exr").read_bytes() == before[i]
            self.assertEqual(is_same, f"{i}.png" not in named, i)
            self.assertEqual(f"{i}.png" in run.stderr.split("deflicker: ")[-1].splitlines()[0], f"{i}.png" in named, i)

    def cracks(self, blank, color=(150, 150, 150)):
        """Grain that differs a little from photograph to photograph, and lines that widen; none where it is blank."""
        def photograph(i, x, y):
            grain = (x * 7919 + y * 104729 + x * y * 31) % 5 + (x * 31 + y * 17 + i * 101) % 4
            if i in blank:
                return tuple(v + grain for v in color)
            is_line = any(abs(a * x + b * y - c) < 0.3 + 0.15 * i for a, b, c in ((1, 0.2, 19), (0.3, 1, 41), (0.8, -0.6, 7), (0.6, 0.8, 61), (1, 0, 52)))
            return ((60 if is_line else 150) + grain,) * 3

        self.rewrite(8, photograph)

    def test_a_photograph_on_which_nothing_has_happened_yet_belongs_to_its_series(self):
        for blank in ({0}, {0, 1}):
            self.cracks(blank)
            run = self.run_ingest("--force")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertNotIn("cannot be aligned with", run.stderr)
            self.assertNotIn("exclude", run.stderr)
            run = self.run_ingest("--stabilize", "--force")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertNotIn("exclude", run.stderr)
            self.assertIn("too little detail to be aligned with the others, and " + ("stays as it is" if len(blank) == 1 else "stay as they are"), run.stderr)
        self.cracks({0}, (60, 90, 200))  # Its color says that it is something else.
        self.assertRegex(self.run_ingest("--force").stderr, r'0\.png .*cannot be aligned with the others.*"exclude": \[0\]')

    def test_warnings_are_said_once_and_referred_to(self):
        made = self.run_ingest("--json")
        warnings = json.loads(made.stdout)["warnings"]
        for warning in warnings:
            self.assertIn("warning: out: " + warning["text"], made.stderr)
        count = f"{len(warnings)} warning" + ("" if len(warnings) == 1 else "s")
        for command in (("info", "out", "--stats"), ("factorize", "out", "-o", "factors")):
            run = subprocess.run([PATINATE, *command], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn(f"out has {count} about its photographs; `patinate info out` lists them\n", run.stderr)
            self.assertFalse(any(w["text"] in run.stderr for w in warnings), run.stderr)

    def test_one_tinted_photograph_of_four_is_named_and_mended(self):
        def tinted(i, x, y):
            value = texture(x, y)
            return (value, value, min(255, round(value * (1.3 if i == 1 else 1.0))))

        self.rewrite(4, tinted)
        run = self.run_ingest()
        self.assertRegex(run.stderr, r"1\.png .*light times 1, 1, 1\.[6-9]")
        repaired = self.run_ingest("--deflicker", "--force")
        self.assertRegex(repaired.stderr, r"deflicker: factors .*most changed: 1\.png \(1, 1, 0\.5\d\)")
        most = json.loads((self.folder / "out/survey.json").read_text())["deflicker"]["changed"]
        self.assertEqual([m["photo"] for m in most], ["1.png"])

    def test_light_that_goes_up_and_down_is_warned_of_and_what_hides_in_it(self):
        factors = [1.0, 0.8, 1.2, 0.9, 1.1, 0.75, 1.25, 0.95, 1.15, 0.85]

        def restless(i, x, y):
            # Half of the places brighten by themselves, so that no factor is shared by most.
            aging = 1.0 + 0.05 * i * ((x // 8 + y // 8) % 2)
            return (min(255, round(texture(x, y) * 0.6 * aging * factors[i] ** (1 / 2.2))),) * 3

        self.rewrite(len(factors), restless)
        run = self.run_ingest("--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, r"varies from photograph to photograph, by \d+ % in (red|green|blue), so that .* less than [\d.]+ times cannot be detected")
        self.assertIn("reference_patch", run.stderr)
        survey = json.loads((self.folder / "out/survey.json").read_text())
        self.assertGreater(survey["restless_light"]["hidden"], 2 ** (1 / 3), "a third of a stop")
        warnings = json.loads((self.folder / "out/history.json").read_text())["warnings"]
        self.assertTrue(any("varies from photograph to photograph" in w["text"] for w in warnings))
        self.assertNotIn("varies from photograph to photograph", self.run_ingest("--deflicker", "--force").stderr)

    def test_mistakes_are_named(self):
        self.assertEqual(self.run_ingest("--highlights", "hide").returncode, 2)
        for word, meant in (("card.png", ""), ("frist", "; did you mean `first`?"), ("estimated", "; did you mean `estimate`?"), ("off", "")):
            missing = self.run_ingest("--flat-field", word)
            self.assertEqual(missing.returncode, 2)
            self.assertEqual(missing.stderr, f"patinate: error: --flat-field: found `{word}`, which is no file; expected estimate, first, or a photograph of a uniform surface{meant}\n")
        write_png(self.folder / "small.png", 8, 8, lambda x, y: (200, 200, 200))
        small = self.run_ingest("--flat-field", "small.png")
        self.assertEqual(small.returncode, 3)
        self.assertIn("as large as the frames", small.stderr)


if __name__ == "__main__":
    unittest.main()
