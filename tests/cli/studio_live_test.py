#!/usr/bin/env python3
"""A running scene in patinate studio, as a browser hears and drives it. Usage: studio_live_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import struct
import sys
import time
import unittest

from command_case import nightly
from studio_client import Client, Server, WebSocket
from studio_live_case import LiveCase
from studio_pictures import png_pixels, xxh64

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


class Live(LiveCase):
    patinate, copies = PATINATE, ("looked", "returned", "refused")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "ledge/broken.json").write_text(json.dumps({**cls.written, "objects": [{"name": "wall", "mesh": "missing.obj"}]}))
        cls.run_in("simulate", "ledge/scene.json", "-o", "ran")

    def test_hello_says_what_the_scene_is(self):
        scene = self.client().scene
        self.assertEqual((scene["width"], scene["height"], scene["materials"], scene["time_unit"]), (100, 100, ["water", "dirt", "organic", "moss"], "d"))
        self.assertEqual([e["name"] for e in scene["emitters"]], ["rain", "dust", "brush"])
        self.assertEqual((scene["emitters"][0]["shape"], scene["emitters"][2]["shape"], scene["emitters"][2]["on"]), ("sky", "surface", False))
        self.assertEqual(scene["objects"][0]["name"], "wall")
        self.assertEqual(scene["appearance"]["dirt"]["strength"], self.written["appearance"]["dirt"]["strength"])
        self.assertEqual(scene["exchange"]["ratio"], 0.4)
        self.assertIsNone(scene["slider"])
        self.assertEqual([o["name"] for o in scene["overlays"]], ["water", "dirt", "organic", "moss", "dirt.deposited", "hits"])
        self.assertLess(scene["relief_mm"][0], scene["relief_mm"][1])
        self.assertIn("evaporation", [r["name"] for r in scene["rules"]])

    def test_the_picture_is_the_servers_to_the_byte_and_that_of_simulate(self):
        client = self.client()
        client.step(30)
        said = client.settle()
        self.assertEqual(said["iteration"], 30)
        client.do("export", path="shown", what=["textures", "glb", "controls"])
        for file in ("color.png", "normal.png", "specular.png", "height.exr"):  # after 30 iterations, as `simulate` wrote them
            self.assertEqual((self.folder / "shown" / file).read_bytes(), (self.folder / "ran" / file).read_bytes(), file)
        self.assertTrue((self.folder / "shown/model.glb").stat().st_size > 1000)
        self.assertTrue((self.folder / "shown/controls/hits.exr").exists())
        c = client.status["counters"]
        self.assertEqual(c["emitted"], c["absorbed"] + c["left"] + c["rested"] + c["alive"])
        self.assertTrue(all(row["residual"] == 0 for row in client.status["ledger"].values()))
        self.assertEqual(client.status["ledger"], json.loads((self.folder / "ran/simulation.json").read_text())["ledger"])  # after 30 iterations, too
        width, channels, color = png_pixels((self.folder / "ran/color.png").read_bytes())
        picture = client.planes["surface"]
        self.assertTrue(all(picture[4 * i:4 * i + 3] == color[3 * i:3 * i + 3] for i in range(100 * 100)))
        self.assertEqual(xxh64(bytes(picture)), said["surface"])
        self.assertEqual(xxh64(bytes(client.planes["relief"])), said["relief"])

    @nightly
    def test_a_device_shows_the_same_picture(self):
        devices = json.loads(self.run_in("devices", "--json").stdout)["devices"]
        if not devices:
            self.skipTest("there is no OpenCL device (Debian: pocl-opencl-icd)")
        (self.folder / "ledge/on_device.json").write_text(json.dumps(self.written))
        server = Server(self.patinate, self.folder, "--device", devices[0]["name"], "--verbose")
        self.addCleanup(server.close)
        client = Client(server, "ledge/on_device.json")
        self.addCleanup(client.close)
        client.step(30)
        client.settle()
        client.do("export", path="shown_by_device", what=["textures"])
        for file in ("color.png", "normal.png", "specular.png", "height.exr"):
            self.assertEqual((self.folder / "shown_by_device" / file).read_bytes(), (self.folder / "ran" / file).read_bytes(), file)

    def test_what_it_has_done_is_what_simulate_says(self):
        self.run_in("simulate", "ledge/scene.json", "--controls", "hits", "-o", "counted_hits")
        said = json.loads((self.folder / "counted_hits/simulation.json").read_text())["outcome"]
        client = self.client()
        client.do("outcome")
        self.assertEqual([o["change_mean"] for o in client.outcome["objects"].values()], [0])
        client.step(30)
        client.do("outcome")
        self.assertEqual((client.outcome["iteration"], client.outcome["objects"], client.outcome["advice"]), (30, said["objects"], said["advice"]))
        # Asking composes, and nothing of that is lost to those who watch: between two iterations, too.
        client.do("step", iterations=3)
        client.do("outcome")
        client.until(lambda: client.status["iteration"] == 33)
        self.assertEqual(xxh64(bytes(client.planes["surface"])), client.settle()["surface"])
        finished = self.client_without_reset("counted_hits")
        finished.do("outcome")
        self.assertEqual(finished.outcome["objects"], said["objects"])

    def test_at_most_two_updates_wait_for_an_answer(self):
        client = self.client()
        client.settle()
        client.acknowledges = False
        client.updates.clear()
        client.do("run")
        client.until(lambda: client.status["iteration"] > 60)
        self.assertLessEqual(len(client.updates), 2)
        client.do("pause")
        while client.listen(0.3):
            pass
        self.assertLessEqual(len(client.updates), 2)
        client.acknowledges = True
        client.socket.send({"op": "ack", "update": client.updates[-1]["update"]})
        client.settle()  # one update brings all that was missed
        other = self.client_without_reset()
        other.settle()
        self.assertEqual(client.surface(), other.surface())

    def test_a_slow_client_skips_what_a_quick_one_sees(self):
        quick, slow = self.client(), self.client_without_reset()
        slow.acknowledges = False
        quick.do("run")
        quick.until(lambda: quick.status["iteration"] >= 80)
        quick.do("pause")
        quick.until(lambda: quick.status["clients"] == 2)
        self.assertGreater(len(quick.updates), 4)
        while slow.listen(0.3):
            pass
        self.assertLessEqual(len(slow.updates), 2)
        slow.acknowledges = True
        slow.socket.send({"op": "ack", "update": slow.updates[-1]["update"]})
        slow.settle()
        quick.settle()
        self.assertEqual(slow.surface(), quick.surface())
        self.assertEqual(bytes(slow.planes["relief"]), bytes(quick.planes["relief"]))

    def test_what_one_changes_the_other_hears(self):
        one, two = self.client(), self.client_without_reset()
        one.do("event", event={"op": "ratio", "ratio": 0.125})
        one.do("event", event={"op": "behavior", "behavior": {"slider": 0.5}})
        two.until(lambda: two.scene["exchange"]["ratio"] == 0.125 and two.scene["slider"] == 0.5)
        emitter = dict(one.scene["emitters"][1], on=False)
        one.do("event", event={"op": "emitter", "emitter": emitter})
        two.until(lambda: not two.scene["emitters"][1]["on"])
        two.do("event", event={"op": "move", "target": "wall", "position": [5, 6, 7]})
        one.until(lambda: one.scene["objects"][0]["translate"] == [5, 6, 7])
        glb = self.server.request("/api/mesh?place=ledge/scene.json")[2]
        gltf = json.loads(glb[20:20 + struct.unpack("<I", glb[12:16])[0]])
        self.assertEqual([n["name"] for n in gltf["nodes"]], ["wall"])
        rules = one.scene["rules"]
        self.assertIn("growth", [r["name"] for r in one.scene["more_rules"]])
        one.do("event", event={"op": "rule", "target": "growth", "products": {"moss": 0.25}})
        two.until(lambda: two.scene["rules"][len(rules):] == [{"name": "growth", "driver": "min(water, dirt)", "rate": 0.1, "products": {"moss": 0.25}, "reactants": {}}])
        self.assertNotIn("growth", [r["name"] for r in two.scene["more_rules"]])
        two.do("reset")
        one.until(lambda: one.scene["objects"][0]["translate"] == [0, 0, 0] and one.scene["slider"] is None and one.scene["rules"] == rules)

    def test_the_way_back_to_the_start_can_be_undone(self):
        client = self.client("ledge/returned.json")
        self.assertFalse(client.status["can_undo"])  # at the start, with nothing done, there is nothing to bring back
        client.step(7)
        client.do("event", event={"op": "ratio", "ratio": 0.9})
        before = client.surface()
        client.do("reset")
        client.until(lambda: client.status["iteration"] == 0)
        client.settle()
        self.assertNotEqual(client.surface(), before)
        self.assertEqual(client.scene["exchange"]["ratio"], 0.4)
        client.do("undo")
        client.until(lambda: client.status["iteration"] == 7)
        client.settle()
        self.assertEqual(client.surface(), before)
        self.assertEqual(client.scene["exchange"]["ratio"], 0.9)
        client.do("save", path="returned_from.json")  # and so are the events
        self.assertEqual([e["ratio"] for e in json.loads((self.folder / "returned_from.json").read_text())["events"]], [0.9, 0.6])
        client.do("undo")  # the ratio, where the scene is
        client.until(lambda: client.scene["exchange"]["ratio"] == 0.6)
        self.assertEqual(client.status["iteration"], 7)
        self.assertEqual(client.ask("undo")["type"], "error")

    def test_a_finished_simulation_runs_again(self):
        client = self.client("ran")
        client.step(30)
        client.do("save", path="again.json")
        self.run_in("simulate", "again.json", "-o", "again")
        self.assertEqual(self.atlas_hash("again"), self.atlas_hash("ran"))  # the brush that waits in it changes nothing

    def test_a_finished_simulation_opens_where_it_ended_and_goes_on(self):
        shutil.copytree(self.folder / "ran", self.folder / "opened")
        client = self.client_without_reset("opened")
        client.settle()
        self.assertEqual(client.status["iteration"], 30)
        self.assertIn("ended, after 30 iterations", client.scene["notes"][0])
        whole = self.client("ran")
        whole.step(30)
        self.assertEqual(client.surface(), whole.surface())
        before = client.surface()
        client.do("appearance", appearance={"dirt": {"strength": 0.3}})
        client.settle()
        self.assertNotEqual(client.surface(), before)
        self.assertEqual(client.status["iteration"], 30)
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        brush = client.scene["emitters"][-1]["name"]
        self.paint(client, middle, [middle[0] + 20, *middle[1:]], emitter=brush)
        client.step(4)
        self.paint(client, middle, [middle[0], middle[1] + 20, middle[2]], emitter=brush)  # the last thing that happens
        client.do("save", path="gone_on.json")
        client.do("export", path="gone_on_look", what=["textures", "controls"])
        self.run_in("simulate", "gone_on.json", "-o", "gone_on")
        for file in ("color.png", "controls/dirt.deposited.exr"):
            self.assertEqual((self.folder / "gone_on" / file).read_bytes(), (self.folder / "gone_on_look" / file).read_bytes(), file)
        client.do("undo", steps=2)  # both strokes; the four iterations are done again without them
        client.until(lambda: client.status["iteration"] == 34 and not client.status["running"])
        client.do("reset")
        client.until(lambda: client.status["iteration"] == 0)

    def test_a_finished_simulation_without_its_state_shows_its_end_and_says_so(self):
        shutil.copytree(self.folder / "ran", self.folder / "stateless")
        (self.folder / "stateless/state.bin").unlink()
        client = self.client_without_reset("stateless")
        client.settle()
        self.assertEqual(client.status["iteration"], 30)
        self.assertIn("no state.bin", client.scene["notes"][0])
        whole = self.client("ran")
        whole.step(30)
        self.assertEqual(client.surface(), whole.surface())
        client.do("appearance", appearance={"dirt": {"strength": 0.3}})
        client.settle()
        self.assertNotEqual(client.surface(), whole.surface())
        for request in ({"op": "run"}, {"op": "step"}, {"op": "event", "event": {"op": "ratio", "ratio": 0.5}}):
            self.assertIn("Back to the start", client.ask(**request)["message"])
        client.do("reset")
        client.until(lambda: client.status["iteration"] == 0)
        client.step(3)

    def test_a_finished_simulation_holds_its_scene_wherever_it_is(self):
        """Its scene has gone, and the folder has moved: it opens where it ended, and what it continues to is what it would have been."""
        shutil.copytree(self.folder / "ledge", self.folder / "gone")
        self.run_in("simulate", "gone/scene.json", "-o", "stays", "--iterations", "12")
        self.run_in("simulate", "gone/scene.json", "-o", "longer", "--iterations", "17")
        (self.folder / "elsewhere").mkdir()
        (self.folder / "stays").rename(self.folder / "elsewhere/moved")
        shutil.rmtree(self.folder / "gone")
        client = self.client_without_reset("elsewhere/moved")
        client.settle()
        self.assertEqual(client.status["iteration"], 12)
        self.assertIn("ended, after 12 iterations", client.scene["notes"][0])
        client.step(5)
        client.do("export", path="moved_look", what=["textures"])
        self.assertEqual((self.folder / "moved_look/color.png").read_bytes(), (self.folder / "longer/color.png").read_bytes())
        client.do("save", path="moved_on.json")
        self.run_in("simulate", "moved_on.json", "-o", "moved_on")
        self.assertEqual(self.atlas_hash("moved_on"), self.atlas_hash("longer"))
        self.assertNotIn("live_problem", self.server.get_json("/api/place?place=elsewhere/moved"))
        # Its own copy is looked at, too.
        mesh = self.folder / "elsewhere/moved/scene/mesh.obj"
        mesh.write_text(mesh.read_text() + "# other\n")
        shutil.copytree(self.folder / "elsewhere/moved", self.folder / "elsewhere/damaged")
        damaged = self.client_without_reset("elsewhere/damaged")
        damaged.settle()
        self.assertEqual(damaged.status["iteration"], 0)
        self.assertIn("Changed since this simulation was made: scene/mesh.obj.", damaged.scene["notes"][0])

    def test_a_finished_simulation_of_an_earlier_version_whose_scene_changed_says_so(self):
        shutil.copytree(self.folder / "ledge", self.folder / "edited")
        self.run_in("simulate", "edited/scene.json", "-o", "older", "--iterations", "4", "--seed", "7")
        self.assertEqual(json.loads((self.folder / "older/simulation.json").read_text())["seed"], 7)
        client = self.client("older")  # the seed that was used, not the file's
        client.step(4)
        client.do("save", path="seeded.json")
        client.close()
        self.run_in("simulate", "seeded.json", "-o", "seeded")
        self.assertEqual(self.atlas_hash("seeded"), self.atlas_hash("older"))
        scene = json.loads((self.folder / "edited/scene.json").read_text())
        (self.folder / "edited/scene.json").write_text(json.dumps({**scene, "exchange": {**scene["exchange"], "ratio": 0.1}}))
        shutil.copytree(self.folder / "older", self.folder / "older_again")
        manifest = json.loads((self.folder / "older_again/simulation.json").read_text())  # as it was before folders held their scenes
        del manifest["scene_files"]
        (self.folder / "older_again/simulation.json").write_text(json.dumps({**manifest, "scene": "../edited/scene.json"}))
        shutil.rmtree(self.folder / "older_again/scene")
        client = self.client_without_reset("older_again")
        client.settle()
        self.assertEqual(client.status["iteration"], 0)
        self.assertIn("Changed since this simulation was made: scene.json.", client.scene["notes"][0])

    def test_appearance_recomposes_and_does_not_simulate(self):
        client = self.client("ledge/looked.json")
        client.step(20)
        before, iteration = client.surface(), client.status["iteration"]
        client.do("appearance", appearance={"dirt": {"strength": 0}, "water": {"strength": 0}})
        client.settle()
        self.assertNotEqual(client.surface(), before)
        self.assertEqual(client.status["iteration"], iteration)
        client.do("appearance", appearance={"dirt": {"strength": client.start["dirt"]["strength"]}, "water": {"strength": client.start["water"]["strength"]}})
        client.settle()
        self.assertEqual(client.surface(), before)

    def test_water_is_a_film_while_somebody_watches_what_texels_are_made_of(self):
        client = self.client("ledge/looked.json")
        client.step(20)
        painted = client.surface()
        client.do("export", path="as_color", what=["textures"])
        client.do("watch", planes=["surface", "relief", "material"])
        client.settle()
        self.assertNotEqual(client.surface(), painted)
        self.assertEqual(client.scene["look"], {"metal": False, "film": "water", "plants": "moss"})
        texels = bytes(client.planes["material"])
        self.assertEqual(len(texels), 4 * 100 * 100)
        self.assertEqual(max(texels[0::4]), 0)  # no metal
        self.assertGreater(max(texels[1::4]), 0)  # wet
        self.assertGreater(max(texels[3::4]), 0)  # below the ledge less light comes
        client.do("export", path="as_film", what=["textures"])
        for file in ("color.png", "specular.png", "normal.png"):
            self.assertEqual((self.folder / "as_color" / file).read_bytes(), (self.folder / "as_film" / file).read_bytes(), file)
        client.do("watch", planes=["surface", "relief"])
        client.settle()
        self.assertEqual(client.surface(), painted)

    def test_plants_have_places_and_meshes_can_be_cut_to_texels(self):
        rows = self.server.request("/api/plants?place=ledge/scene.json")[2]
        self.assertEqual(len(rows) % (17 * 4), 0)
        self.assertGreater(len(rows), 0)
        whole, fine = (self.server.request(f"/api/mesh?place=ledge/scene.json{more}")[2] for more in ("", "&texels=100"))
        self.assertGreater(len(fine), 2 * len(whole))

    def test_overlays_and_gammatons_come_when_asked_for(self):
        client = self.client()
        client.do("watch", planes=["surface"], overlay="dirt", gammatons=50)
        client.step(15)
        self.assertEqual(len(client.planes["overlay"]), 100 * 100)
        self.assertGreater(max(client.planes["overlay"]), 0)
        self.assertEqual(len(client.gammatons), 150)
        client.do("watch", overlay="hits")
        client.settle()
        hits = lambda: [o for o in client.scene["overlays"] if o["name"] == "hits"][0]
        before = hits()["range"]
        client.step(60)
        client.do("export", path="counted", what=["controls"])
        client.until(lambda: hits()["range"] != before)
        # A byte stands for a root: the largest of them, and the range, are those of the counts, and no power of ten above.
        shown = lambda: hits()["high"] * (max(client.planes["overlay"]) / 255) ** 2
        client.until(lambda: abs(shown() - hits()["most"]) <= 0.02 * shown())  # the range follows a little later
        client.settle()
        most = shown()
        self.assertAlmostEqual(most, hits()["most"], delta=0.02 * most)
        self.assertLess(hits()["high"], 4 * most)
        self.assertTrue(0 == hits()["range"][0] < hits()["range"][1] <= hits()["most"], hits())
        client.do("watch", overlay=None, gammatons=0, planes=["surface", "relief"])

    def test_wrong_requests_get_a_sentence_and_change_nothing(self):
        client = self.client("ledge/refused.json")  # which no other test has done anything to, so that there is nothing to undo
        client.settle()
        for request in ({"op": "fly"}, {}, {"op": "event"}, {"op": "event", "event": {"op": "ratio", "ratio": 7}}, {"op": "event", "event": {"op": "move", "target": "nobody", "position": [0, 0, 0]}},
                        {"op": "event", "event": {"iteration": 3, "op": "ratio", "ratio": 0.5}}, {"op": "event", "event": [1]}, {"op": "event", "event": {"op": "rule", "target": "nothing", "rate": 1}}, {"op": "event", "event": {"op": "rule", "target": "evaporation", "driver": "gold"}}, {"op": "step", "iterations": -1}, {"op": "step", "iterations": "x"},
                        {"op": "stroke", "phase": "move"}, {"op": "stroke", "phase": "begin", "emitter": "rain", "position": [0, 0, 0]}, {"op": "undo"}, {"op": "redo"}, {"op": "resume"}, {"op": "appearance", "appearance": {"gold": {}}},
                        {"op": "appearance", "appearance": {"dirt": {"color": "/etc/passwd"}}}, {"op": "appearance", "appearance": {"dirt": {"strength": -1}}}, {"op": "appearance", "appearance": 3},
                        {"op": "watch", "overlay": "gold"}, {"op": "watch", "planes": ["x"]}, {"op": "watch", "gammatons": 1e12}, {"op": "ack", "update": 1 << 60}, {"op": "save"}, {"op": "save", "path": 3},
                        {"op": "export", "path": "x", "what": ["everything"]}, {"op": "export", "path": "../x", "what": []}):
            client.socket.send({**request, "id": 99})
            client.until(lambda: 99 in client.answers)
            self.assertEqual(client.answers.pop(99)["type"], "error", request)
        for garbage in (b"", b"{", b"[]", b"null", b"[" * 5000, b'{"op":"x","id":' + b"[" * 200_000 + b"]" * 200_000 + b"}"):
            client.socket.send(garbage)
        self.assertEqual(client.scene["exchange"]["ratio"], 0.4)
        client.step(1)
        self.assertEqual((client.status["can_undo"], client.status["can_redo"]), (False, False))

    def test_what_cannot_run_says_why(self):
        for place, words in (("ledge/broken.json", "missing.obj"), ("ledge/mesh.obj", "only scenes"), ("nothing", "no place"), ("../x", "no place")):
            socket = WebSocket(self.server, f"/api/live?place={place}")
            message = socket.receive()
            while message and message["type"] == "progress":
                message = socket.receive()
            self.assertEqual(message["type"], "error")
            self.assertIn(words, message["message"])
            self.assertIsNone(socket.receive(5))
            socket.close()

    def test_broken_frames_close_one_connection_only(self):
        for frame in ((3, b"x"), (1, b"\xff\xfe"), (1, b"a" * 2_000_000), (2, b"\x00" * 10), (15, b"")):
            socket = WebSocket(self.server, "/api/live?place=ledge/scene.json")
            try:
                socket.send_frame(*frame)
                socket.socket.sendall(b"\x00\x01\x02\xff" * 50)
                while socket.receive(1):
                    pass
            except OSError:
                pass
            socket.close()
        self.client().step(1)

    def test_pauses_when_nobody_is_left_and_waits_for_them(self):
        client = self.client()
        client.do("run")
        client.until(lambda: client.status and client.status["iteration"] > 5)
        client.leave()
        again = self.client_without_reset()
        again.settle()
        first = again.hashes[-1]["iteration"]
        time.sleep(0.1)  # many iterations, were it running
        self.assertEqual(again.settle()["iteration"], first)
        self.assertGreater(first, 5)


if __name__ == "__main__":
    unittest.main()
