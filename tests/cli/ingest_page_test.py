"""The page that every ingest writes: one file with all pictures, warnings with their places, the same bytes on every run."""
import html
import json
import os
import re
import sys
import unittest

from command_case import CommandCase, use
from series_files import exif, png

PATINATE = sys.argv.pop(1)


def setUpModule():
    use(PATINATE)


def texture(x, y):
    """Blocks of 4 px with pseudo-random brightness."""
    return 60 + (((x // 4) * 7919 + (y // 4) * 104729 + (x // 4) * (y // 4) * 31) % 97)


class IngestPage(CommandCase):
    def project(self, frames, **more):
        """`frames`: bytes of PNG files by name. Written with a capture.json."""
        (self.folder / "photos").mkdir()
        for name, data in frames.items():
            (self.folder / "photos" / name).write_bytes(data)
        (self.folder / "capture.json").write_text(json.dumps({
            "format": "patinate.capture", "version": 1, "name": "steel & rust", "kind": "fixed", "time_unit": "d",
            "frames": {"pattern": "photos/*.png", "interval": 2}, **more}))

    def ingest(self, *options, project="capture.json", output="out"):
        """The page, after an ingest that succeeds."""
        result = self.run_patinate("ingest", project, "-o", output, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        page = f"{output}/report.html"
        self.assertIn(page, " ".join(result.stderr.splitlines()[-2:]))
        return self.checked((self.folder / page).read_text())

    def checked(self, page):
        """A page that needs no network and names no folder of this machine."""
        self.assertNotIn("http", page)
        self.assertNotIn(str(self.folder), page)
        for heading in ("Warnings", "Mask"):
            self.assertIn(f"<h2>{heading}</h2>", page)
        return page

    def thumbnails(self, page):
        """(picture, caption) of each."""
        part = re.search(r'<div class="thumbnails">(.*?)</div>', page, re.S).group(1)
        return re.findall(r'<img src="(data:image/jpeg;base64,[^"]+)".*?<figcaption>(.*?)</figcaption>', part, re.S)

    def rows(self, page, heading):
        """Cells of the rows of the table below a heading, the head first."""
        part = page.split(f"<h2>{html.escape(heading)}</h2>")[1].split("<h2>")[0]
        return [[html.unescape(cell) for cell in re.findall(r"<t[hd]>(.*?)</t[hd]>", row, re.S)] for row in re.findall(r"<tr>(.*?)</tr>", part, re.S)]

    def moved_series(self, count=8):
        """The camera moves at 4, and a light is mirrored at 2."""
        def frame(i):
            def pixel(x, y):
                value = texture(x + 100 - (3 if i >= 4 else 0), y + 100) - 2 * i
                return (255, 255, 255) if i == 2 and 40 <= x < 44 and 20 <= y < 24 else (value, value, value)
            return png(96, 96, pixel)
        return {f"f{i}.png": frame(i) for i in range(count)}

    def test_every_photograph_and_every_warning_is_on_the_page_with_its_place(self):
        self.project(self.moved_series())
        page = self.ingest()
        self.assertIn("steel &amp; rust", page)
        thumbnails = self.thumbnails(page)
        self.assertEqual([caption.split("\n")[:2] for _, caption in thumbnails], [[f"{2 * i} d", f"f{i}.png"] for i in range(8)])
        warnings = json.loads((self.folder / "out/history.json").read_text())["warnings"]
        rows = self.rows(page, "Warnings")[1:]
        self.assertEqual(len(rows), len(warnings))
        for number, (row, warning) in enumerate(zip(rows, warnings), 1):
            self.assertTrue(row[0].startswith(f"{number}. {warning['text']}"), row[0])
            for photo in warning.get("photos", []):
                self.assertIn(photo, row[1])
        moved = next(i for i, w in enumerate(warnings) if w["about"] == "motion")
        self.assertEqual(rows[moved][1], "f4.png (8 d)")
        self.assertRegex(thumbnails[4][1], rf"\nwarnings? [^\n]*\b{moved + 1}\b")

    def test_the_table_says_where_a_photograph_is_masked_and_what_was_found(self):
        self.project(self.moved_series())
        head, *rows = self.rows(self.ingest(), "All photographs")
        self.assertEqual([row[0] for row in rows], [f"f{i}.png" for i in range(8)])
        masked = {row[0]: row[head.index("masked")] for row in rows}
        self.assertEqual([name for name, text in masked.items() if text != "-"], ["f2.png"])
        left, right, top, bottom = map(int, re.search(r"x (\d+) to (\d+), y (\d+) to (\d+)", masked["f2.png"]).groups())
        for found, expected in ((left, 40), (right, 43), (top, 20), (bottom, 23)):
            self.assertAlmostEqual(found, expected, delta=3)  # Highlights have a rim.
        self.assertIn("moved by 3 px right", rows[4][-1])
        self.assertEqual(rows[1][-1], "-")

    def test_what_files_say_is_a_row_once_and_a_column_where_photographs_differ(self):
        def frame(i):
            return png(32, 24, lambda x, y: (texture(x, y),) * 3, exif=exif(DateTimeOriginal=f"2026:03:0{i + 1} 08:00:00"))
        frames = {f"f{i}.png": frame(i) for i in range(3)}
        self.project(frames, response="linear")
        self.edit_json(self.folder / "capture.json", lambda project: project["frames"].pop("interval"))
        page = self.ingest()
        understood = dict(self.rows(page, "What was understood")[1:])
        self.assertEqual(understood["size"], "32 x 24 pixels")
        self.assertIn("from EXIF DateTimeOriginal", understood["times"])
        head, *rows = self.rows(page, "All photographs")
        self.assertEqual([row[head.index("the file's time")] for row in rows],
                         [f"2026-03-0{i + 1} 08:00:00 (EXIF DateTimeOriginal)" for i in range(3)])
        self.assertNotIn("size", head)

    def test_equal_photographs_give_equal_pages_on_any_number_of_threads_in_any_folder(self):
        self.project(self.moved_series())
        first = self.ingest("--threads", "1")
        self.assertEqual(first, self.ingest("--threads", "4", output="again"))
        (self.folder / "elsewhere").mkdir()
        for name in ("photos", "capture.json"):
            (self.folder / name).rename(self.folder / "elsewhere" / name)
        self.assertEqual(first, self.ingest(project="elsewhere/capture.json", output="third"))

    def test_a_page_that_was_lost_is_made_again_and_one_that_was_changed_is_named(self):
        self.project(self.moved_series(3))
        page = self.ingest()
        file = self.folder / "out/report.html"
        file.unlink()
        self.assertEqual(self.ingest(), page)
        file.write_text(page[:1000])
        self.fails(1, "report.html", "ingest", "capture.json", "-o", "out")
        self.succeeds("ingest", "capture.json", "-o", "out", "--force")
        self.assertEqual(file.read_text(), page)

    def test_of_a_long_series_sixty_are_shown_and_all_are_in_the_table(self):
        frames = {f"f{i:03}.png": png(16, 16, lambda x, y, i=i: (texture(4 * x, 4 * y) + (60 if i == 41 else 0) - i // 4,) * 3) for i in range(90)}
        self.project(frames)
        page = self.ingest()
        shown = [caption.split("\n")[1] for _, caption in self.thumbnails(page)]
        self.assertLessEqual(len(shown), 60)
        self.assertGreaterEqual(len(shown), 45)
        self.assertEqual((shown[0], shown[-1]), ("f000.png", "f089.png"))
        self.assertIn("f041.png", shown)  # A warning names it.
        self.assertEqual(len(self.rows(page, "All photographs")), 91)
        # 60 pictures of some kB as base64, charts and a table.
        self.assertLess(len(page), 600_000)

    def test_one_photograph_has_a_page_without_curves(self):
        self.project({"flatbed.png": png(200, 100, lambda x, y: (texture(x, y), 90, 60))})
        page = self.ingest()
        self.assertEqual(len(self.thumbnails(page)), 1)
        self.assertNotIn("Over time", page)
        self.assertIn("The whole picture is inside the mask.", page)

    def test_png_photographs_need_no_module_for_their_page(self):
        self.project(self.moved_series(2))
        result = self.run_patinate("ingest", "capture.json", "-o", "out", env={**os.environ, "PATINATE_MODULES": "/nowhere"})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((self.folder / "out/report.html").read_text().count('src="data:image/jpeg'), 3)  # And the control.

    def test_photographs_laid_over_one_another_have_their_residuals(self):
        def frame(dx):
            return png(160, 160, lambda x, y: (texture(x + 100 + dx, y + 100),) * 3)
        self.project({f"f{i}.png": frame(3 * i) for i in range(3)}, align="landmarks", align_to="f0.png", landmarks="points.csv")
        marks = [("left", 40, 50), ("right", 120, 60), ("top", 80, 30), ("foot", 70, 130)]
        (self.folder / "points.csv").write_text("".join(f"f{i}.png,{name},{x - 3 * i},{y}\n" for i in range(3) for name, x, y in marks))
        page = self.ingest()
        self.assertIn("`align` landmarks, over f0.png", dict(self.rows(page, "What was understood")[1:])["alignment"])
        head, *rows = self.rows(page, "All photographs")
        self.assertEqual([row[head.index("aligned with")] for row in rows], ["reference", "aligned", "aligned"])
        self.assertLess(float(rows[2][head.index("residual (px)")]), 0.01)  # The marks are exact.
        self.assertIn("residual (px of the reference)", page)

    def test_movies_plates_under_a_lamp_and_captures_under_lamps_have_the_page(self):
        self.succeeds("export", self.shared / "history", "-o", "clip.gif")
        (self.folder / "movie.json").write_text(json.dumps({
            "format": "patinate.capture", "version": 1, "name": "movie", "kind": "fixed", "frames": {"pattern": "clip.gif", "interval": 1, "every": 20}}))
        self.assertEqual(len(self.thumbnails(self.ingest(project="movie.json", output="movie"))), 5)  # Of 100 images.
        self.succeeds("synth", "plate", "-o", "plate", "--size", "48", "--num-frames", "3")
        self.assertIn("under a known lamp", self.ingest(project="plate/capture.json", output="plated"))
        self.succeeds("synth", "mold", "-o", "mold", "--width", "64", "--height", "48", "--steps", "2")
        page = self.ingest(project="mold/capture.json", output="molded")
        self.assertEqual(len(self.thumbnails(page)), 2)
        self.assertIn("step00/light0.png", page)
        self.assertIn("<h2>Controls</h2>", page)


if __name__ == "__main__":
    unittest.main()
