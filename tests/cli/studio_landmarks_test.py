"""Points marked in photographs through the studio: what the route reads, saves and refuses."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from series_files import movie, png
from studio_client import Server

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())

PROJECT = """{
  // A series by hand.
  "format": "patinate.capture", "version": 1, "name": "plate", "kind": "fixed",
  "frames": {"pattern": "photos/*.png", "interval": 1.50}%s
}
"""


def texture(x, y):
    """Blocks of 4 px with pseudo-random brightness."""
    return 60 + (((x // 4) * 7919 + (y // 4) * 104729 + (x // 4) * (y // 4) * 31) % 97)


class Landmarks(unittest.TestCase):
    def setUp(self):
        self.outside = pathlib.Path(tempfile.mkdtemp(prefix="patinate_marks_"))
        self.addCleanup(shutil.rmtree, self.outside)
        self.folder = self.outside / "served"
        (self.folder / "plate/photos").mkdir(parents=True)
        for i in range(3):
            (self.folder / f"plate/photos/f{i}.png").write_bytes(png(60 + i, 50, lambda x, y, i=i: (texture(x + 100 + 3 * i, y + 100),) * 3))
        self.write("")
        self.server = Server(PATINATE, self.folder)
        self.addCleanup(self.server.close)

    def write(self, more):
        (self.folder / "plate/capture.json").write_text(PROJECT % more)

    def ask(self, place="plate", body=None):
        """Status and JSON of the answer."""
        method, data = ("GET", None) if body is None else ("POST", json.dumps(body))
        status, _, answer = self.server.request(f"/api/landmarks?place={place}", method, data)
        return status, json.loads(answer)

    def marks(self, *marks):
        return [{"photo": photo, "point": point, "x": x, "y": y} for photo, point, x, y in marks]

    def save(self, marks, place="plate"):
        return self.ask(place, {"state": self.ask(place)[1]["state"], "marks": marks})

    def refused(self, status, about, body, place="plate"):
        before = {p: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}
        found, answer = self.ask(place, body)
        self.assertEqual(found, status, answer)
        self.assertIn(about, answer["error"])
        self.assertEqual({p: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}, before)

    def test_photographs_are_listed_with_what_is_needed_to_mark_them(self):
        status, info = self.ask()
        self.assertEqual(status, 200)
        self.assertEqual([(p["number"], p["name"], p["path"], p["width"], p["height"]) for p in info["photos"]],
                         [(i, f"f{i}.png", f"photos/f{i}.png", 60 + i, 50) for i in range(3)])
        self.assertEqual((info["marks"], info["table"], info["align"], info["uses_marks"]), ([], None, "off", False))

    def test_images_of_a_movie_are_photographs_like_others(self):
        def frame(i):
            return bytes(v for y in range(48) for x in range(64) for v in (texture(x + 100 + 3 * i, y + 100),) * 3)
        (self.folder / "plate/m.mov").write_bytes(movie([frame(i) for i in range(3)], 64, 48, [500] * 3))
        self.write(', "align": "landmarks"')
        (self.folder / "plate/capture.json").write_text((self.folder / "plate/capture.json").read_text().replace("photos/*.png", "m.mov"))
        status, info = self.ask()
        self.assertEqual(status, 200, info)
        self.assertEqual([(p["number"], p["name"], p["path"], p["image"]) for p in info["photos"]], [(i, f"m.mov, image {i}", "m.mov", i) for i in range(3)])
        shown = [self.server.request(f"/api/preview?place=plate&path=m.mov&image={i}") for i in range(3)]
        self.assertEqual([(s, h.get("content-type")) for s, h, _ in shown], [(200, "image/jpeg")] * 3)
        self.assertEqual(len({body for _, _, body in shown}), 3)
        self.assertEqual(self.server.request("/api/preview?place=plate&path=m.mov&image=3")[0], 400)
        self.assertEqual(self.server.request("/api/preview?place=plate&path=m.mov&image=-1")[0], 400)
        marks = self.marks(*[(i, name, x - 3 * i, y) for i in range(3) for name, x, y in (("1", 10, 20), ("2", 50, 30), ("3", 30, 44))])
        self.assertEqual(self.save(marks)[0], 200)
        self.assertEqual(self.ask()[1]["marks"], marks)
        run = subprocess.run([PATINATE, "ingest", "plate", "-o", "laid"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_saved_points_are_in_a_table_that_the_project_names_and_the_rest_of_it_stays_as_it_is_written(self):
        marks = self.marks((0, "1", 10, 20.5), (0, "2", 40, 30), (1, "1", 7, 20.5), (1, "2", 37, 30), (2, "1", 4, 20.5), (2, "2", 34, 30))
        status, info = self.save(marks)
        self.assertEqual(status, 200, info)
        self.assertEqual((info["marks"], info["table"], info["uses_marks"]), (marks, "landmarks.csv", True))
        self.assertEqual((self.folder / "plate/landmarks.csv").read_text(),
                         "photo,point,x,y\nf0.png,1,10,20.5\nf0.png,2,40,30\nf1.png,1,7,20.5\nf1.png,2,37,30\nf2.png,1,4,20.5\nf2.png,2,34,30\n")
        self.assertEqual((self.folder / "plate/capture.json").read_text(), PROJECT % ',\n  "landmarks": "landmarks.csv",\n  "align": "auto"')

    def test_what_was_clicked_lays_the_photographs_over_one_another(self):
        self.write(', "align": "landmarks"')
        self.assertEqual(self.save(self.marks(*[(i, name, x - 3 * i, y) for i in range(3) for name, x, y in (("1", 10, 20), ("2", 50, 30), ("3", 30, 44))]))[0], 200)
        made = self.outside / "out"
        result = subprocess.run([PATINATE, "ingest", self.folder / "plate", "-o", made], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        reference, *_ = json.loads((made / "alignment.json").read_text())["photos"]
        self.assertAlmostEqual(abs(reference["transform"][2]), 3, delta=0.01)  # From the one in the middle.
        self.assertIn('"align": "landmarks"', (self.folder / "plate/capture.json").read_text())

    def test_the_table_of_the_project_is_replaced_and_keeps_photographs_that_are_left_out(self):
        self.write(', "align": "auto", "landmarks": "points.csv", "exclude": [2]')
        (self.folder / "plate/points.csv").write_text('# by hand\nphoto,point,x,y\nf0.png,"rim, left",1,2\nf2.png,foot,5,6\n')
        info = self.ask()[1]
        self.assertEqual(info["marks"], self.marks((0, "rim, left", 1, 2)))
        text = (self.folder / "plate/capture.json").read_text()
        status, info = self.save(self.marks((0, "rim, left", 1.5, 2), (1, 'a "corner"', 3, 4)))
        self.assertEqual(status, 200, info)
        self.assertEqual((self.folder / "plate/points.csv").read_text(),
                         'photo,point,x,y\nf0.png,"rim, left",1.5,2\nf1.png,"a ""corner""",3,4\nf2.png,foot,5,6\n')
        self.assertEqual((self.folder / "plate/capture.json").read_text(), text)
        self.assertEqual(self.ask()[1]["marks"], self.marks((0, "rim, left", 1.5, 2), (1, 'a "corner"', 3, 4)))

    def test_a_file_of_the_users_is_not_taken_for_the_table(self):
        (self.folder / "plate/landmarks.csv").write_text("my own\n")
        self.assertEqual(self.save(self.marks((0, "1", 1, 2)))[1]["table"], "landmarks-2.csv")
        self.assertEqual((self.folder / "plate/landmarks.csv").read_text(), "my own\n")

    def test_a_project_or_table_that_was_changed_meanwhile_is_not_overwritten(self):
        marks = self.marks((0, "1", 1, 2))
        state = self.ask()[1]["state"]
        self.write(', "align": "features"')
        self.refused(409, "was changed", {"state": state, "marks": marks})
        self.assertEqual(self.save(marks)[0], 200)
        state = self.ask()[1]["state"]
        (self.folder / "plate/landmarks.csv").write_text("photo,point,x,y\nf1.png,1,3,4\n")
        self.refused(409, "was changed", {"state": state, "marks": marks})

    def test_what_is_wrong_is_refused_and_nothing_is_written(self):
        state = self.ask()[1]["state"]
        for about, marks in (("photograph", self.marks((7, "1", 1, 2))), ("photograph", self.marks((-1, "1", 1, 2))),
                             ("59.5", self.marks((0, "1", 59.6, 2))), ("49.5", self.marks((0, "1", 1, 50))), ("-0.5", self.marks((0, "1", -0.6, 2))),
                             ("once", self.marks((0, "1", 1, 2), (0, "1", 3, 4))), ("64", self.marks((0, "", 1, 2))), ("64", self.marks((0, "x" * 65, 1, 2))),
                             ("line break", self.marks((0, "a\nb", 1, 2))), ("blank", self.marks((0, " a", 1, 2))), ("no point", []),
                             ("number", [{"photo": 0, "point": "1", "x": "1", "y": 2}]), ("y", [{"photo": 0, "point": "1", "x": 1}]),
                             ("array", "all of them"), ("more", [{"photo": 0, "point": "1", "x": 1, "y": 2, "more": 3}])):
            with self.subTest(about, marks=str(marks)[:60]):
                self.refused(400, about, {"state": state, "marks": marks})
        self.refused(400, "state", {"marks": []})
        self.refused(404, "plates", {"state": state, "marks": []}, place="plates")

    def test_a_project_that_is_gone_is_not_made_again(self):
        state = self.ask()[1]["state"]
        (self.folder / "plate/capture.json").unlink()
        found, answer = self.ask(body={"state": state, "marks": self.marks((0, "1", 1, 2))})
        self.assertIn(found, (400, 404), answer)
        self.assertFalse((self.folder / "plate/capture.json").exists())
        self.assertFalse((self.folder / "plate/landmarks.csv").exists())

    def test_a_table_outside_of_the_served_folder_is_neither_read_nor_written(self):
        (self.outside / "secret.csv").write_text("photo,point,x,y\nf0.png,1,1,2\n")
        (self.folder / "plate/link.csv").symlink_to(self.outside / "secret.csv")
        for name in ("../../secret.csv", "link.csv"):
            self.write(f', "align": "auto", "landmarks": "{name}"')
            found, answer = self.ask()
            self.assertEqual(found, 400, answer)
            self.assertIn("outside", answer["error"])

    def test_a_project_of_another_name_is_a_place_too(self):
        (self.folder / "plate/capture.json").rename(self.folder / "plate/steel.json")
        status, info = self.save(self.marks((0, "1", 1, 2)), place="plate/steel.json")
        self.assertEqual(status, 200, info)
        self.assertIn("landmarks.csv", (self.folder / "plate/steel.json").read_text())


if __name__ == "__main__":
    unittest.main()
