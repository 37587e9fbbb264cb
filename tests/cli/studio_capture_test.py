#!/usr/bin/env python3
"""Photographs come into the folder through patinate studio, and projects get crop, mask, scale and chart: nothing else is written. Usage: studio_capture_test.py PATINATE [unittest arguments]"""
import http.client
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

from series_files import png, png_pixels
from studio_client import Server

PATINATE = str(pathlib.Path(sys.argv.pop(1)).resolve())
PHOTO = png(40, 30, lambda x, y: (5 * x, 6 * y, 90))
PROJECT = """{
  // A series by hand.
  "format": "patinate.capture", "version": 1, "name": "plate", "kind": "fixed",
  "frames": {"pattern": "*.png", "interval": 1.50}%s
}
"""


class Case(unittest.TestCase):
    def setUp(self):
        self.base = pathlib.Path(tempfile.mkdtemp(prefix="patinate_capture_"))
        self.addCleanup(shutil.rmtree, self.base)
        self.served, self.outside = self.base / "served", self.base / "outside"
        self.served.mkdir()
        self.outside.mkdir()
        (self.outside / "a.png").write_bytes(PHOTO)
        self.server = Server(PATINATE, self.served)
        self.addCleanup(self.server.close)

    def files(self):
        return {str(p.relative_to(self.base)): p.read_bytes() if p.is_file() else None for p in self.base.rglob("*") if ".studio" not in p.parts}

    def post(self, path, body, **more):
        status, _, data = self.server.request(path, "POST", body if isinstance(body, bytes) else json.dumps(body), **more)
        return status, json.loads(data) if data.startswith(b"{") else data.decode()

    def refused(self, expected, about, path, body, **more):
        before = self.files()
        status, answer = self.post(path, body, **more)
        self.assertEqual(status, expected, (path, answer))
        self.assertIn(about, str(answer))
        self.assertNotIn(str(self.base), str(answer))
        self.assertEqual(self.files(), before, path)


class Photographs(Case):
    def folder(self, name="paint"):
        return self.post("/api/photographs/folder", {"name": name})

    def photo(self, name="a.png", body=PHOTO, folder="paint", **more):
        return self.post(f"/api/photographs?folder={folder}&name={name}", body, **more)

    def test_photographs_come_byte_for_byte_and_become_a_capture(self):
        self.assertEqual(self.folder(), (200, {"folder": "paint"}))
        for name in ("2020-05-28.png", "2020-05-30.png"):
            self.assertEqual(self.photo(name), (200, {"path": "paint/" + name}))
            self.assertEqual((self.served / "paint" / name).read_bytes(), PHOTO)
        self.assertEqual(self.server.get_json("/api/commands")["photographs"], ["paint"])
        run = subprocess.run([PATINATE, "init", "paint"], cwd=self.served, capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.refused(400, "more than photographs", "/api/photographs?folder=paint&name=c.png", PHOTO)

    def test_only_who_knows_the_token_may_bring_them(self):
        self.folder()
        for path in ("/api/photographs/folder", "/api/photographs?folder=paint&name=a.png", "/api/mask?place=paint", "/api/project?place=paint"):
            self.refused(403, "", path, b"{}", token=False)
            self.refused(403, "", path, b"{}", headers={"Origin": "http://elsewhere.example"})

    def test_folders_are_new_and_lie_in_the_served_one(self):
        (self.served / "there").mkdir()
        (self.served / "file").write_text("x")
        (self.served / "link").symlink_to(self.outside)
        (self.served / "dangling").symlink_to(self.outside / "none")
        for name in ("there", "file", "link", "dangling", "../x", "/tmp/x", "a/b", "..", ".", "", ".hidden", "a b", "x\u0000y", "x\n", "\u00e4", "x" * 129, "aged.partial", "link/x", "~", "a%04d", 5, None):
            self.refused(400, "", "/api/photographs/folder", {"name": name})
        for body in (b"", b"[]", b"{", b"{}", b'{"name": "x", "more": 1}', b'{"name": "\xff"}'):
            self.refused(400, "", "/api/photographs/folder", body)

    def test_names_lead_nowhere_else(self):
        self.folder()
        (self.served / "paint/taken.png").write_bytes(b"mine")
        (self.served / "linked").symlink_to(self.outside)
        (self.served / "inside").symlink_to(self.served / "paint")
        for name in ("taken.png", "..%2Fx.png", "%2Ftmp%2Fx.png", "a%2Fx.png", "..%5Cx.png", ".x.png", "x.png%00.jpg", "..", "", "x%20y.png", "x.png%0A", "%C3%A4.png", "%FF.png", "a" * 200 + ".png",
                     "x", "x.html", "capture.json", "history.json", "x.sh", "x.png.sh", "x.svg", "x.obj", "x.csv"):
            self.refused(400, "", f"/api/photographs?folder=paint&name={name}", PHOTO)
        for folder in ("", ".", "..", "none", "linked", "inside", "..%2Foutside", "paint%2F..%2F..%2Foutside", "%2Ftmp", "paint%2F", ".studio"):
            self.refused(400, "", f"/api/photographs?folder={folder}&name=x.png", PHOTO)
        (self.served / "paint/link.png").symlink_to(self.outside / "a.png")
        self.refused(400, "more than photographs", "/api/photographs?folder=paint&name=x.png", PHOTO)

    def test_folders_of_others_stay_as_they_are(self):
        for name, file in (("scene", "scene.json"), ("notes", "notes.txt"), ("deep", "sub/a.png")):
            (self.served / name / file).parent.mkdir(parents=True)
            (self.served / name / file).write_bytes(PHOTO)
            self.refused(400, "more than photographs", f"/api/photographs?folder={name}&name=x.png", PHOTO)

    def test_only_photographs_come(self):
        self.folder()
        for name, body in (("x.png", b""), ("x.png", b"<html><script>alert(1)</script>"), ("x.jpg", b"no picture"), ("x.png", PHOTO[:20]), ("x.tif", b"II*\0" + bytes(60)), ("x.exr", PHOTO[:30]), ("x.gif", b"GIF89a"),
                           ("x.cr2", b"II*\0" + bytes(200)), ("x.mp4", bytes(300)), ("x.mp4", b"#!/bin/sh\n")):
            self.refused(400, "x.", f"/api/photographs?folder=paint&name={name}", body)

    def test_what_the_page_offers_is_what_the_server_takes(self):
        page = pathlib.Path(__file__).parents[2] / "tools/studio/client/src/capture/photograph_files.ts"
        ends = re.search(r'kEnds = "([^"]+)"', page.read_text()).group(1).split()
        said = {end: self.photo("x." + end, b"x")[1]["error"] for end in ends}
        self.assertEqual({end for end, error in said.items() if not error.startswith("there is no folder")}, set())

    def test_large_ones_and_too_many_are_refused(self):
        self.folder()
        for target, length in (("/api/photographs?folder=paint&name=s.png", 129 << 20), ("/api/mask?place=x", 1 << 62), ("/api/photographs/folder", 2 << 20), ("/api/project?place=x", 2 << 20)):
            connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
            connection.putrequest("POST", target)
            connection.putheader("Authorization", "Bearer " + self.server.token)
            connection.putheader("Content-Length", str(length))
            connection.endheaders()
            self.assertEqual(connection.getresponse().status, 413, target)
            connection.close()
        for i in range(1999):
            (self.served / f"paint/{i}.png").touch()
        self.assertEqual(self.photo("last.png")[0], 200)
        self.refused(400, "2000 photographs", "/api/photographs?folder=paint&name=more.png", PHOTO)
        self.folder("large")
        with open(self.served / "large/sparse.mp4", "wb") as file:
            file.truncate(8 << 30)
        status, answer = self.photo("more.png", folder="large")
        self.assertEqual(status, 400, answer)
        self.assertIn("8 GB", answer["error"])
        self.assertEqual([p.name for p in (self.served / "large").iterdir()], ["sparse.mp4"])

    def test_two_at_a_time_do_not_pass_the_limit(self):
        self.folder()
        for i in range(1998):
            (self.served / f"paint/{i}.png").touch()
        said = []
        threads = [threading.Thread(target=lambda i=i: said.append(self.photo(f"n{i}.png")[0])) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertLessEqual(len(list((self.served / "paint").iterdir())), 2000, said)


class Projects(Case):
    def setUp(self):
        super().setUp()
        self.plate = self.served / "plate"
        self.plate.mkdir()
        for i in range(3):
            (self.plate / f"{i}.png").write_bytes(png(40, 30, lambda x, y, i=i: (5 * x, 6 * y, 40 * i)))
        self.write("")

    def write(self, more):
        (self.plate / "capture.json").write_text(PROJECT % more)

    def text(self):
        return (self.plate / "capture.json").read_text()

    def get(self, place="plate"):
        return self.server.get_json(f"/api/project?place={place}")

    def set(self, **members):
        status, answer = self.post("/api/project?place=plate", {"state": self.get()["state"], "members": members})
        self.assertEqual(status, 200, answer)
        return answer

    def mask(self, inside, width=40, height=30):
        return png(width, height, lambda x, y: (255 if inside(x, y) else 0,) * 3)

    def save_mask(self, body, state=None):
        return self.post(f"/api/mask?place=plate&state={state or self.get()['state']}", body)

    def test_what_is_set_is_in_the_project_and_the_rest_of_it_stays_as_it_is_written(self):
        info = self.get()
        self.assertEqual((info["width"], info["height"], info["reference"], info["roi"], info["mask"], info["texel_size_mm"], info["chart"]), (40, 30, None, None, None, None, None))
        self.assertEqual([(p["number"], p["path"]) for p in info["photos"]], [(i, f"{i}.png") for i in range(3)])
        corners = [[2, 3], [20.5, 3], [20, 15], [2, 15]]
        info = self.set(roi=[4, 5, 20, 10], texel_size_mm=0.125, chart={"corners": corners})
        self.assertEqual((info["roi"], info["texel_size_mm"], info["chart"]), ([4, 5, 20, 10], 0.125, {"corners": corners}))
        self.assertTrue(self.text().startswith(PROJECT.split("%s")[0]))
        self.set(chart="auto")
        self.assertIn('"chart": "auto"', self.text())
        self.set(roi=None, texel_size_mm=None, chart=None)
        self.assertEqual(self.text(), PROJECT % "")

    def test_all_else_that_is_said_of_a_chart_stays(self):
        self.write(', "chart": {"edition": "before 2014", "missing": "interpolate"}')
        corners = [[2, 3], [20, 3], [20, 15], [2, 15]]
        self.assertEqual(self.set(chart={"corners": corners})["chart"], {"edition": "before 2014", "missing": "interpolate", "corners": corners})
        self.assertEqual(self.set(chart="auto")["chart"], {"edition": "before 2014", "missing": "interpolate"})

    def test_a_mask_is_a_new_file_that_ingest_uses(self):
        status, info = self.save_mask(self.mask(lambda x, y: x < 10))
        self.assertEqual((status, info["mask"], info["is_mask_shown"]), (200, "masks/mask.png", True), info)
        first = (self.plate / "masks/mask.png").read_bytes()
        self.assertEqual({p[0] for row in png_pixels(first) for p in row[:10]}, {255})
        self.assertEqual({p[0] for row in png_pixels(first) for p in row[10:]}, {0})
        self.assertEqual(png_pixels(self.server.request("/api/mask?place=plate")[2]), png_pixels(first))
        self.assertEqual(self.save_mask(self.mask(lambda x, y: y < 15))[1]["mask"], "masks/mask-2.png")
        self.assertEqual((self.plate / "masks/mask.png").read_bytes(), first, "nothing is replaced")
        run = subprocess.run([PATINATE, "ingest", "plate", "-o", "made"], cwd=self.served, capture_output=True, text=True, timeout=120)
        self.assertEqual(run.returncode, 0, run.stderr)
        rows = png_pixels((self.served / "made/mask.png").read_bytes())
        self.assertEqual([row[0][0] for row in rows], [255] * 15 + [0] * 15)
        self.assertIsNone(self.set(mask=None)["mask"])
        self.assertEqual(self.server.request("/api/mask?place=plate")[0], 404)

    def test_a_project_that_was_changed_meanwhile_is_not_overwritten(self):
        state = self.get()["state"]
        self.write(', "sample": {"coating": "epoxy"}')
        self.refused(409, "nothing was saved", "/api/project?place=plate", {"state": state, "members": {"texel_size_mm": 1}})
        self.refused(409, "nothing was saved", f"/api/mask?place=plate&state={state}", self.mask(lambda x, y: x < 10))
        self.refused(409, "", "/api/project?place=plate", {"state": "", "members": {}})

    def test_what_cannot_be_changes_nothing(self):
        state = self.get()["state"]
        for members in ({"roi": [0, 0, 41, 30]}, {"roi": [0, 0, 0, 5]}, {"roi": [0, 0, 5]}, {"roi": [0.5, 0, 5, 5]}, {"roi": [-1, 0, 5, 5]}, {"roi": "all"}, {"roi": [1e9, 0, 1, 1]}, {"texel_size_mm": 0}, {"texel_size_mm": -1},
                        {"texel_size_mm": "1"}, {"texel_size_mm": 1e300}, {"chart": "off"}, {"chart": {}}, {"chart": {"corners": [[1, 2]]}}, {"chart": {"corners": [[1, 1], [2, 2], [3, 3], [4, 4]]}},
                        {"chart": {"corners": [[2, 15], [20, 15], [20, 3], [2, 3]]}}, {"chart": {"corners": [[2, 3], [20, 3], [20, 15], [2, 15]], "table": "../../outside/a.png"}}, {"chart": {"photos": "*.png"}},
                        {"mask": "../../outside/a.png"}, {"mask": "masks/mask.png"}, {"name": "x"}, {"frames": {"pattern": "/etc/*"}}, [], "x", None):
            with self.subTest(members=members):
                self.refused(400, "", "/api/project?place=plate", {"state": state, "members": members})
        for body in (b"", b"[]", b"{", b"{}", json.dumps({"state": state}).encode(), json.dumps({"state": state, "members": {}, "more": 1}).encode()):
            self.refused(400, "", "/api/project?place=plate", body)
        self.refused(404, "", "/api/project?place=none", {"state": state, "members": {}})

    def test_only_masks_as_large_as_the_photographs_come(self):
        state = self.get()["state"]
        for body, about in ((self.mask(lambda x, y: x < 10, 41), "41 x 30"), (self.mask(lambda x, y: False), "inside"), (b"", "mask"), (b"<script>", "mask"), (PHOTO, "mask"), (self.mask(lambda x, y: x < 10)[:60], "mask")):
            self.refused(400, about, f"/api/mask?place=plate&state={state}", body)
        self.refused(404, "", f"/api/mask?place=none&state={state}", PHOTO)

    def test_masks_lie_beside_the_project_and_nowhere_else(self):
        (self.plate / "masks").symlink_to(self.outside)
        self.refused(400, "", f"/api/mask?place=plate&state={self.get()['state']}", self.mask(lambda x, y: x < 10))
        (self.plate / "masks").unlink()
        (self.plate / "masks").mkdir()
        (self.plate / "masks/mask.png").symlink_to(self.outside / "none.png")
        self.assertEqual(self.save_mask(self.mask(lambda x, y: x < 10))[1]["mask"], "masks/mask-2.png")
        self.assertFalse((self.outside / "none.png").exists())

    def test_a_refused_mask_leaves_folders_as_they_were(self):
        shutil.copytree(self.plate, self.served / "result/plate")
        (self.served / "result/history.json").write_text('{"format": "patinate.history"}')
        self.refused(400, "finished result", f"/api/mask?place=result/plate&state={self.get('result/plate')['state']}", self.mask(lambda x, y: x < 10))
        (self.plate / "masks").mkdir()
        self.refused(400, "inside", f"/api/mask?place=plate&state={self.get()['state']}", self.mask(lambda x, y: False))

    def test_a_project_reads_nothing_outside(self):
        self.write(', "mask": "../../outside/a.png"')
        for path in ("/api/mask?place=plate", "/api/project?place=plate"):
            status, _, data = self.server.request(path)
            self.assertEqual(status, 400, data)

    def test_a_project_of_another_name_has_a_mask_of_its_own(self):
        (self.plate / "capture.json").rename(self.plate / "steel.json")
        state = self.get("plate/steel.json")["state"]
        status, info = self.post(f"/api/mask?place=plate/steel.json&state={state}", self.mask(lambda x, y: x < 10))
        self.assertEqual((status, info["mask"]), (200, "masks/steel_mask.png"), info)

    def test_photographs_of_a_history_are_beside_its_frames_with_the_part_that_they_show(self):
        self.set(roi=[4, 6, 20, 10])
        subprocess.run([PATINATE, "ingest", "plate", "-o", "made", "--quiet"], cwd=self.served, check=True, timeout=120)
        beside = [step["beside"] for step in self.server.get_json("/api/place?place=made")["steps"]]
        self.assertEqual([(b["photo"]["place"], b["photo"]["path"], b["photo"]["width"], b["frame"]["path"], b["frame"]["width"], b["roi"]) for b in beside],
                         [("plate", f"{i}.png", 40, f"frames/{i:04d}.exr", 20, [4, 6, 20, 10]) for i in range(3)])
        self.set(roi=None)
        self.assertIsNone(self.server.get_json("/api/place?place=made")["steps"][0]["beside"]["roi"], "the project is not that of the history any more")


if __name__ == "__main__":
    unittest.main()
