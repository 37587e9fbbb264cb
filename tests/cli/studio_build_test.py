#!/usr/bin/env python3
"""patinate studio builds scenes: meshes come into the folder and nowhere else, and edits are steps. Usage: studio_build_test.py PATINATE [unittest arguments]"""
import http.client
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from studio_client import Client, Server, wait_until

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
CUBE = b"v 0 0 0\nv 90 0 0\nv 90 90 0\nv 0 90 0\nv 0 0 90\nv 90 0 90\nv 90 90 90\nv 0 90 90\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
STL = b"solid a\n" + b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" + b"endsolid a\n"
PRESETS = ("rain_and_dirt", "rust", "moss", "patina", "peeling_paint")


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_build_"))
        cls.served, cls.outside = cls.folder / "served", cls.folder / "outside"
        cls.served.mkdir()
        cls.outside.mkdir()
        cls.server = Server(PATINATE, cls.served)

    @classmethod
    def tearDownClass(cls):
        cls.server.close()
        shutil.rmtree(cls.folder, ignore_errors=True)

    def files(self):
        return sorted(str(p.relative_to(self.folder)) for p in self.folder.rglob("*") if p.is_file() and ".studio" not in p.parts)

    def upload(self, name, body=CUBE, **more):
        status, _, data = self.server.request("/api/mesh?name=" + name, "POST", body, **more)
        return status, json.loads(data) if data.startswith(b"{") else data

    def begin(self, mesh, **changes):
        options = {"preset": "rust", "unit": "mm", "up": "y", "resolution": 64, **changes}
        status, _, data = self.server.request(f"/api/begin?place={mesh}", "POST", json.dumps(options))
        return status, json.loads(data)


class Uploads(Case):
    def test_a_mesh_comes_into_the_folder_byte_for_byte(self):
        for name, body in (("cube.obj", CUBE), ("part.stl", STL)):
            self.assertEqual(self.upload(name, body), (200, {"place": name}))
            self.assertEqual((self.served / name).read_bytes(), body)

    def test_names_lead_nowhere_else(self):
        before = self.files()
        for name in ("..%2Fx.obj", "%2Ftmp%2Fx.obj", "a%2Fx.obj", "..%5Cx.obj", ".x.obj", "x.obj%00.png", "%2e%2e%2fx.obj", "..", ".", "", "x%20y.obj", "-rf%20.obj", "x.obj%2F", "%C3%A4.obj", "a" * 200 + ".obj", "x.obj%0A"):
            status, answer = self.upload(name)
            self.assertEqual(status, 400, (name, answer))
        self.assertEqual(self.files(), before)

    def test_only_meshes_come(self):
        before = self.files()
        for name, body in (("x.html", b"<script>"), ("x.json", b"{}"), ("x.py", CUBE), ("x.gltf", b"{}"), ("x.obj", b"no mesh"), ("x.obj", b""), ("x.ply", CUBE), ("x.glb", b"glTF" + bytes(8)), ("x.stl", b"solid\n"), ("x", CUBE), ("x.obj.sh", CUBE)):
            status, answer = self.upload(name, body)
            self.assertEqual(status, 400, (name, answer))
            self.assertNotIn(str(self.folder), json.dumps(answer))
        self.assertEqual(self.files(), before)

    def test_nothing_that_is_there_is_replaced(self):
        (self.served / "taken.obj").write_bytes(b"mine")
        (self.outside / "target.obj").write_bytes(b"mine")
        (self.served / "link.obj").symlink_to(self.outside / "target.obj")
        (self.served / "dangling.obj").symlink_to(self.outside / "none.obj")
        (self.served / "folder.obj").mkdir()
        for name in ("taken", "link", "dangling", "folder"):
            self.assertEqual(self.upload(name + ".obj"), (200, {"place": name + "-2.obj"}))
        self.assertEqual((self.served / "taken.obj").read_bytes(), b"mine")
        self.assertEqual((self.outside / "target.obj").read_bytes(), b"mine")
        self.assertFalse((self.outside / "none.obj").exists())

    def test_a_finished_result_that_is_served_stays_as_it_is(self):
        subprocess.run([PATINATE, "synth", "ledge", "-o", "made", "--cells", "4", "--quiet"], cwd=self.outside, check=True)
        scene = json.loads((self.outside / "made/scene.json").read_text())
        scene["run"]["iterations"], scene["atlas"] = 1, {"resolution": 64}
        (self.outside / "made/scene.json").write_text(json.dumps(scene))
        subprocess.run([PATINATE, "simulate", "made/scene.json", "-o", "done", "--quiet"], cwd=self.outside, check=True)
        server = Server(PATINATE, self.outside / "done")
        try:
            status, _, data = server.request("/api/mesh?name=x.obj", "POST", CUBE)
            self.assertEqual(status, 400, data)
            self.assertFalse((self.outside / "done/x.obj").exists())
        finally:
            server.close()

    def test_strangers_and_large_bodies_are_refused_before_they_are_read(self):
        self.assertEqual(self.server.request("/api/mesh?name=s.obj", "POST", CUBE, token=False)[0], 403)
        self.assertEqual(self.server.request("/api/mesh?name=s.obj", "POST", CUBE, headers={"Origin": "http://elsewhere.example"})[0], 403)
        before = self.server.memory_mb()
        for target, length in (("/api/mesh?name=s.obj", 129 << 20), ("/api/mesh?name=s.obj", 1 << 62), ("/api/begin?place=x", 2 << 20), ("/api/landmarks", 2 << 20), ("/api/meshes", 2 << 20)):
            connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
            connection.putrequest("POST", target)
            connection.putheader("Authorization", "Bearer " + self.server.token)
            connection.putheader("Content-Length", str(length))
            connection.endheaders()
            self.assertEqual(connection.getresponse().status, 413, (target, length))
            connection.close()
        self.assertLess(self.server.memory_mb() - before, 32)
        self.assertFalse((self.served / "s.obj").exists())

    def test_two_uploads_at_a_time(self):
        held = []
        for _ in range(2):
            connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
            connection.putrequest("POST", "/api/mesh?name=slow.obj")
            connection.putheader("Authorization", "Bearer " + self.server.token)
            connection.putheader("Content-Length", "1000000")
            connection.endheaders(b"v 0 0 0\n")
            held.append(connection)
        wait_until(lambda: self.upload("third.obj")[0] == 503, "refusal")
        self.assertEqual(self.server.request("/api/places")[0], 200)  # all else goes on
        for connection in held:
            connection.close()
        wait_until(lambda: self.upload("fourth.obj")[0] == 200, "upload")
        self.assertFalse((self.served / "slow.obj").exists())


class Begin(Case):
    def test_every_preset_is_a_scene_that_runs_and_does_something(self):
        self.upload("cube.obj")
        for preset in PRESETS:
            status, answer = self.begin("cube.obj", preset=preset, resolution=192)  # chips of paint are a few millimeters wide
            self.assertEqual((status, answer), (200, {"place": f"cube_{preset}.json"}))
            subprocess.run([PATINATE, "simulate", f"cube_{preset}.json", "-o", preset, "--quiet"], cwd=self.served, check=True)
            outcome = json.loads((self.served / preset / "simulation.json").read_text())["outcome"]
            self.assertGreater(outcome["objects"]["cube"]["change_mean"], 1, preset)  # 1 is just noticeable

    def test_up_and_unit_are_those_of_the_file(self):
        self.upload("up.stl", STL)
        text = (self.served / self.begin("up.stl", up="z", unit="cm")[1]["place"]).read_text()
        self.assertIn('"unit": "cm", "gravity": [0, 0, -981]', text)
        self.assertIn("// Rust", text)  # for people

    def test_a_scene_is_never_written_over_another(self):
        self.upload("again.obj")
        self.assertEqual(self.begin("again.obj")[1]["place"], "again_rust.json")
        (self.served / "again_rust.json").write_text("mine")
        self.assertEqual(self.begin("again.obj")[1]["place"], "again_rust-2.json")
        self.assertEqual((self.served / "again_rust.json").read_text(), "mine")

    def test_what_is_asked_wrongly_is_refused(self):
        self.upload("b.obj")
        before = self.files()
        for changes in ({"preset": "../x"}, {"preset": 1}, {"unit": "mile"}, {"up": "x"}, {"resolution": 100000}, {"resolution": 0}, {"more": 1}):
            status, answer = self.begin("b.obj", **changes)
            self.assertEqual(status, 400, (changes, answer))
        self.assertEqual(self.begin("..%2Fx.obj")[0], 404)
        self.assertEqual(self.begin("nothing.obj")[0], 404)
        self.assertEqual(self.server.request("/api/begin?place=b.obj", "POST", "{")[0], 400)
        self.assertEqual(self.files(), before)


class Edits(Case):
    def opened(self, name):
        self.upload(name + ".obj")
        return Client(self.server, self.begin(name + ".obj")[1]["place"])

    def edit(self, client, label, *patch):
        state = client.ask("document")["state"]
        return client.ask("edit", label=label, state=state, patch=list(patch))

    def labels(self, client):
        return [s["label"] for s in client.scene["steps"]["done"]], [s["label"] for s in client.scene["steps"]["undone"]]

    def at(self, client, iteration):
        client.status = None
        client.until(lambda: client.status and client.status["iteration"] == iteration and not client.status["running"])

    def test_edits_begin_anew_with_what_is_set_and_undo_brings_all_back(self):
        client = self.opened("edited")
        client.step(5)
        client.do("event", event={"op": "ratio", "ratio": 0.75})
        client.do("event", event={"op": "move", "target": "edited", "position": [1, 2, 3]})
        client.do("event", event={"op": "rule", "target": "evaporation", "rate": 7})
        client.step(3)
        hashes = client.settle()
        answer = self.edit(client, "Add drip", {"op": "add", "path": "/rules/-", "value": {"name": "drip", "driver": "water", "rate": 1, "reactants": {"water": 1}}})
        self.assertEqual(answer["type"], "done", answer)
        self.at(client, 0)
        self.assertEqual(client.scene["exchange"]["ratio"], 0.75)
        self.assertEqual(client.scene["objects"][0]["translate"], [1, 2, 3])
        self.assertEqual([(r["name"], r["rate"]) for r in client.scene["rules"]][-2:], [("evaporation", 7), ("drip", 1)])
        self.assertEqual(self.edit(client, "Rename", {"op": "replace", "path": "/objects/0/name", "value": "other"})["type"], "done")
        self.assertEqual(self.labels(client), (["Ratio 0.75", "Move edited", "evaporation: rate 7", "Add drip", "Rename"], []))
        client.do("undo", steps=2)
        self.at(client, 8)
        self.assertEqual(client.settle(), hashes)
        self.assertEqual(self.labels(client)[1], ["Add drip", "Rename"])
        client.do("undo", steps=3)
        client.do("redo", steps=5)
        self.at(client, 0)
        self.assertEqual(client.scene["objects"][0]["name"], "other")

    def test_a_scene_that_cannot_be_is_refused_with_its_place(self):
        client = self.opened("checked")
        state = client.ask("document")["state"]
        for patch, pointer, text in (({"op": "replace", "path": "/emitters/0/speed", "value": -1}, "/emitters/0/speed", "found -1"),
                                     ({"op": "replace", "path": "/atlas/resolution", "value": 16384}, "/atlas/resolution", "at most 4096 here"),
                                     ({"op": "replace", "path": "/rules/0/driver", "value": "wat"}, "/rules/0", "did you mean `water`"),
                                     ({"op": "add", "path": "/objects/-", "value": {"name": "x", "mesh": "gone.obj"}}, "", "gone.obj: does not exist")):
            problem = client.ask("check", state=state, patch=[patch])["problem"]
            self.assertEqual(problem["pointer"], pointer, problem)
            self.assertIn(text, problem["text"])
            self.assertEqual(client.ask("edit", label="x", state=state, patch=[patch])["type"], "error")
        self.assertIsNone(client.ask("check", state=state, patch=[])["problem"])
        self.assertEqual(self.labels(client), ([], []))
        client.step(2)

    def test_patches_of_others_or_nonsense_change_nothing(self):
        client = self.opened("nonsense")
        state = client.ask("document")["state"]
        for request in ({"patch": {}}, {"patch": [{"op": "remove", "path": "/nothing"}]}, {"patch": [{"op": "test", "path": "/version", "value": 7}]}, {"patch": [{"path": "/x"}]}, {"patch": [1]},
                        {"patch": [{"op": "replace", "path": "", "value": []}]}, {"patch": [], "state": state + 1}, {"patch": [], "label": ""}, {"patch": [], "label": "x" * 200}, {"patch": [{"op": "add", "path": "no pointer", "value": 1}]},
                        {"patch": [{"op": "move", "from": "/rules", "path": "/rules/0"}]}):
            self.assertEqual(client.ask("edit", **{"label": "x", "state": state, **request})["type"], "error", request)
        self.assertEqual(self.labels(client), ([], []))
        client.step(2)

    def test_an_edited_scene_reads_nothing_outside(self):
        client = self.opened("inside")
        (self.outside / "secret.obj").write_bytes(CUBE)
        (self.outside / "rule.json").write_text("{}")
        (self.served / "way.obj").symlink_to(self.outside / "secret.obj")
        for value in ("../outside/secret.obj", str(self.outside / "secret.obj"), "way.obj"):
            answer = self.edit(client, "x", {"op": "replace", "path": "/objects/0/mesh", "value": value})
            self.assertEqual(answer["type"], "error", value)
            self.assertIn("outside", answer["message"])
        self.assertEqual(self.edit(client, "x", {"op": "add", "path": "/rules/-", "value": "../outside/rule.json"})["type"], "error")

    def test_the_file_stays_and_what_was_built_is_resumed_after_a_crash(self):
        client = self.opened("kept")
        before = (self.served / "kept_rust.json").read_bytes()
        self.edit(client, "Only rain", {"op": "replace", "path": "/rules", "value": ["evaporation"]})
        client.step(4)
        hashes = client.settle()
        client.do("save", path="kept_built.json")
        subprocess.run([PATINATE, "simulate", "kept_built.json", "-o", "kept_built", "--quiet"], cwd=self.served, check=True)
        wait_until(lambda: any("kept_rust" in p.name and json.loads(p.read_text())["iterations"] == 4 for p in (self.served / ".studio").glob("*.json")), "recording")
        self.assertEqual((self.served / "kept_rust.json").read_bytes(), before)
        self.server.process.kill()
        type(self).server = Server(PATINATE, self.served)
        again = Client(self.server, "kept_rust.json")
        self.assertEqual(len(again.scene["rules"]), 3)
        again.do("resume")
        self.at(again, 4)
        self.assertEqual([r["name"] for r in again.scene["rules"]], ["evaporation"])
        self.assertEqual(again.settle(), hashes)

    def test_everyone_who_watches_sees_the_scene_that_comes(self):
        client = self.opened("watched")
        other = Client(self.server, "watched_rust.json")
        self.edit(client, "Finer", {"op": "replace", "path": "/atlas/resolution", "value": 96})
        other.until(lambda: other.scene["width"] == 96)
        self.assertEqual(self.labels(other), (["Finer"], []))
        client.step(2)
        other.until(lambda: other.status and other.status["iteration"] == 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
