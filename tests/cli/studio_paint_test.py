#!/usr/bin/env python3
"""patinate studio paints transfers: what comes back, what is kept beside the transfer, and that nothing else is touched. Usage: studio_paint_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from studio_client import Server

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SIDE = 64


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_paint_"))
        cls.made = cls.folder / "made"
        cls.made.mkdir()
        for arguments in (["synth", "crackle", "--width", "64", "--height", "64", "--num-frames", "2", "-o", "capture"], ["ingest", "capture", "-o", "history"],
                          ["synth", "sculpture", "--resolution", "24", "-o", "urn"],
                          ["transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", str(SIDE), "-o", "aged"]):
            subprocess.run([PATINATE, *arguments, "--quiet"], cwd=cls.made, check=True, timeout=300)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def setUp(self):
        self.served = self.folder / self.id().split(".")[-1]
        shutil.copytree(self.made, self.served)
        vertices = [[float(v) for v in line.split()[1:4]] for line in (self.served / "aged/mesh.obj").read_text().splitlines() if line.startswith("v ")]
        self.point = max(vertices, key=lambda v: v[0])
        self.radius = 0.2 * max(v[1] for v in vertices)
        self.open()

    def open(self, folder=None):
        self.server = Server(PATINATE, folder or self.served)
        self.addCleanup(self.server.close)

    def ask(self, what, place="aged", **more):
        status, _, data = self.server.request(f"/api/paint?place={place}", "POST", json.dumps({"do": what, "time": 0, **more}), timeout=300)
        if status != 200:
            return status, json.loads(data)["error"]
        size = struct.unpack("<I", data[:4])[0]
        header = json.loads(data[4:4 + size])
        payload = data[4 + size:]
        numbers = struct.unpack(f"<{header['count']}I", payload[:4 * header["count"]])
        texels = payload[4 * header["count"]:]
        self.assertEqual(len(texels), 256 * header["count"])
        return header, {number: texels[256 * i:256 * (i + 1)] for i, number in enumerate(numbers)}

    def stroke(self, gesture=1, **changes):
        edit = {"kind": "stroke", "control": "thickness", "value": 1, "flow": 0.8, "radius_mm": self.radius, "points_mm": [self.point], **changes}
        return self.ask("stroke", gesture=gesture, edit=edit)

    def texture(self, place="aged"):
        status, _, data = self.server.request(f"/api/texture?place={place}&time=0")
        self.assertEqual(status, 200)
        return bytearray(data)

    def put(self, texture, tiles):
        columns = SIDE // 8
        for number, texels in tiles.items():
            for row in range(8):
                begin = 4 * ((number // columns * 8 + row) * SIDE + number % columns * 8)
                texture[begin:begin + 32] = texels[32 * row:32 * row + 32]
        return texture

    def files(self):
        return {str(p.relative_to(self.folder)): p.read_bytes() for p in self.folder.rglob("*") if p.is_file() and not {".studio", ".cache"} & set(p.parts)}


class Painting(Case):
    def test_what_comes_back_is_what_the_command_makes(self):
        before, texture = self.texture(), self.texture()
        header, tiles = self.ask("look")
        self.assertEqual((tiles, header["done"]), ({}, []))
        header, tiles = self.stroke()
        self.assertTrue(tiles)
        self.put(texture, tiles)
        self.assertNotEqual(texture, before)
        self.put(texture, self.stroke(gesture=1, value=0.5)[1])  # The same gesture: one step.
        header, tiles = self.ask("refine")
        self.put(texture, tiles)
        self.assertEqual(header["done"], ["Paint thickness 1", "Refine borders"])
        self.assertEqual(header["file"], "aged.edits.json")
        self.assertEqual(len(json.loads((self.served / "aged.edits.json").read_text())["edits"]), 3)
        words = shlex.split(header["command"])
        self.assertEqual(words[0:2] + words[-4:], ["patinate", "transfer", "--edits", "aged.edits.json", "-o", "OUT"])
        subprocess.run([PATINATE, *words[1:], "--quiet"], cwd=self.served, check=True, timeout=300)
        self.assertEqual(self.texture("OUT"), texture)

    def test_undo_gives_the_texture_back_and_redo_takes_it_again(self):
        before = self.texture()
        after = self.put(bytearray(before), self.stroke()[1])
        header, tiles = self.ask("undo")
        self.assertEqual((header["done"], header["undone"]), ([], ["Paint thickness 1"]))
        self.assertEqual(self.put(bytearray(after), tiles), before)
        self.assertEqual(json.loads((self.served / "aged.edits.json").read_text())["edits"], [])
        self.assertEqual(self.put(bytearray(before), self.ask("redo")[1]), after)
        self.assertEqual(self.put(bytearray(before), self.ask("look")[1]), after, "of another time")
        self.assertEqual(self.ask("redo")[1], {}, "there is nothing to redo")

    def test_what_was_painted_is_there_again_after_a_restart(self):
        after = self.put(self.texture(), self.stroke()[1])
        self.server.close()
        self.open()
        header, tiles = self.ask("look")
        self.assertEqual(header["done"], ["Paint thickness 1"])
        self.assertEqual(self.put(self.texture(), tiles), after)


class Attacks(Case):
    def test_nothing_but_the_file_of_edits_is_written(self):
        before = self.files()
        self.stroke()
        after = self.files()
        self.assertEqual({name for name in after if after[name] != before.get(name)}, {str((self.served / "aged.edits.json").relative_to(self.folder))})

    def test_links_lead_nowhere_else(self):
        for target, name in ((self.folder / "outside.json", "aged.edits.json"), (self.folder / "none" / "x.json", "aged.edits.json")):
            (self.folder / "outside.json").write_text("mine")
            (self.served / name).symlink_to(target)
            self.assertEqual(self.stroke()[0], 400)
            self.assertEqual((self.folder / "outside.json").read_text(), "mine")
            (self.served / name).unlink()
        (self.served / "aged.edits.json").mkdir()
        self.assertEqual(self.stroke()[0], 400)

    def test_a_link_that_comes_later_is_not_followed_either(self):
        self.stroke()
        (self.folder / "outside.json").write_text("mine")
        (self.served / "aged.edits.json").unlink()
        (self.served / "aged.edits.json").symlink_to(self.folder / "outside.json")
        self.assertEqual(self.stroke(gesture=2)[0], 400)
        self.assertEqual((self.folder / "outside.json").read_text(), "mine")

    def test_a_file_that_is_no_list_of_edits_is_named_and_kept(self):
        for text in ("mine", "{}", '{"format": "patinate.scene", "version": 1}'):
            (self.served / "aged.edits.json").write_text(text)
            status, error = self.stroke()
            self.assertEqual(status, 400)
            self.assertIn("aged.edits.json", error)
            self.assertEqual((self.served / "aged.edits.json").read_text(), text)

    def test_a_transfer_that_is_served_alone_has_no_place_for_edits(self):
        self.server.close()
        self.open(self.served / "aged")
        status, error = self.ask("look", place=".")
        self.assertEqual(status, 400)
        self.assertIn("serve the folder above", error)

    def test_only_transfers_are_painted(self):
        for place in ("history", "urn/mesh.obj", "..", "../made/aged", "nothing", "%2Ftmp"):
            status, _ = self.ask("look", place=place)
            self.assertIn(status, (400, 404), place)
        self.assertEqual(self.server.request("/api/paint?place=aged", "POST", "{}", token=False)[0], 403)
        self.assertEqual(self.server.request("/api/paint?place=aged", "POST", "{}", headers={"Origin": "http://elsewhere.example"})[0], 403)

    def test_bad_requests_change_nothing(self):
        self.stroke()
        before = self.files()
        for changes in ({"value": 2}, {"value": None}, {"flow": 0}, {"radius_mm": -1}, {"radius_mm": 1e400}, {"points_mm": []}, {"points_mm": [[1, 2]]}, {"points_mm": [[0, 0, 0]] * 10001},
                        {"points_mm": [[1e30, 0, 0]]}, {"control": "other"}, {"kind": "refine"}, {"file": "x"}):
            status, error = self.stroke(gesture=2, **changes)
            self.assertEqual(status, 400, (changes, error))
        for body in ("", "[]", "{", "null", '{"do": "look"}', '{"do": "erase", "time": 0}', '{"do": "look", "time": 0, "path": "x"}', '{"do": "stroke", "time": 0}', '{"do": "stroke", "time": 0, "gesture": 0, "edit": {}}',
                     "[" * 100000):
            self.assertEqual(self.server.request("/api/paint?place=aged", "POST", body)[0], 400, body[:40])
        self.assertEqual(self.files(), before)
        self.assertEqual(self.ask("undo")[0]["done"], [])


if __name__ == "__main__":
    unittest.main()
