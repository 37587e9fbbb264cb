#!/usr/bin/env python3
"""A running scene in patinate studio, as a browser hears and drives it. Usage: studio_live_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from studio_client import Client, Server, WebSocket
from studio_pictures import png_pixels, xxh64

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_live_"))
        cls.run_in("synth", "ledge", "--cells", "6", "-o", "ledge")
        scene = json.loads((cls.folder / "ledge/scene.json").read_text())
        scene["atlas"]["resolution"] = 100
        scene["run"] = {"iterations": 30, "history_every": 10, "controls": ["dirt.deposited"]}
        scene["appearance"]["moss"] = {"height": 0.5}
        for emitter in scene["emitters"]:
            emitter["gammatons"] = 150
        scene["events"] = [{"iteration": 5, "op": "ratio", "ratio": 0.6}]
        (cls.folder / "ledge/scene.json").write_text(json.dumps(scene))
        for name in ("painted", "looked", "returned", "only_painted", "refused"):
            (cls.folder / f"ledge/{name}.json").write_text(json.dumps(scene))
        (cls.folder / "ledge/broken.json").write_text(json.dumps({**scene, "objects": [{"name": "wall", "mesh": "missing.obj"}]}))
        cls.run_in("simulate", "ledge/scene.json", "-o", "ran")
        cls.server = Server(PATINATE, cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.server.close()
        shutil.rmtree(cls.folder)

    @classmethod
    def run_in(cls, *arguments):
        result = subprocess.run([PATINATE, *arguments], cwd=cls.folder, capture_output=True, text=True, timeout=300)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}")
        return result

    def client(self, place="ledge/scene.json", **more):
        client = Client(self.server, place, **more)
        self.addCleanup(client.close)
        client.do("reset")
        client.until(lambda: client.status and client.status["iteration"] == 0 and not client.status["running"])
        return client

    def atlas_hash(self, folder):
        return json.loads((self.folder / folder / "simulation.json").read_text())["atlas_hash"]

    def test_hello_says_what_the_scene_is(self):
        scene = self.client().scene
        self.assertEqual((scene["width"], scene["height"], scene["materials"], scene["time_unit"]), (100, 100, ["water", "dirt", "organic", "moss"], "d"))
        self.assertEqual([e["name"] for e in scene["emitters"]], ["rain", "dust", "brush"])
        self.assertEqual((scene["emitters"][0]["shape"], scene["emitters"][2]["shape"], scene["emitters"][2]["on"]), ("sky", "surface", False))
        self.assertEqual(scene["objects"][0]["name"], "wall")
        self.assertEqual(scene["appearance"]["dirt"]["strength"], 1.6)
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

    def client_without_reset(self, place="ledge/scene.json"):
        client = Client(self.server, place)
        self.addCleanup(client.close)
        return client

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

    def test_undo_goes_back_to_before_the_stroke(self):
        client = self.client()
        client.step(10)
        before = client.surface()
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        self.paint(client, middle, [middle[0] + 3, *middle[1:]])
        client.step(2)
        after = client.surface()
        self.assertNotEqual(after, before)
        client.until(lambda: client.status["can_undo"] and not client.status["can_redo"])
        client.do("undo")
        client.until(lambda: client.status["iteration"] == 10 and client.status["can_redo"])
        client.settle()
        self.assertEqual(client.surface(), before)
        self.assertFalse(client.scene["emitters"][2]["on"])
        client.do("save", path="undone.json")  # nothing of the stroke is left in it
        self.assertEqual(json.loads((self.folder / "undone.json").read_text())["events"], [{"iteration": 5, "op": "ratio", "ratio": 0.6}])
        client.do("redo")  # with all that it has led to
        client.until(lambda: client.status["iteration"] == 12 and not client.status["can_redo"])
        client.settle()
        self.assertEqual(client.surface(), after)
        client.do("save", path="redone.json")
        self.assertEqual([e["op"] for e in json.loads((self.folder / "redone.json").read_text())["events"]], ["paint", "ratio"])
        client.do("undo")
        client.do("event", event={"op": "ratio", "ratio": 0.7})  # something else was done: what was undone is gone
        self.assertIn("nothing to redo", client.ask("redo")["message"])

    def paint(self, client, *way, emitter="brush"):
        """A stroke along the points of a way, told in two messages."""
        client.do("stroke", emitter=emitter, position=way[0], phase="begin")
        client.do("stroke", emitter=emitter, positions=list(way[1:]), phase="end")
        client.until(lambda: client.status and not client.status["painting"] and client.status["can_undo"])
        client.settle()

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
        self.assertEqual(client.ask("undo")["type"], "error")

    def test_while_a_brush_paints_nothing_else_lives(self):
        client = self.client()
        client.step(12)
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        water = client.status["ledger"]["water"]
        client.do("run")
        client.do("stroke", emitter="brush", position=middle, phase="begin")
        client.until(lambda: client.status["painting"])
        at = client.status["iteration"]
        for _ in range(3):
            client.do("stroke", emitter="brush", positions=[[middle[0] + 5, *middle[1:]], middle], phase="move")
            time.sleep(0.3)
            client.settle()
        self.assertEqual((client.status["iteration"], client.status["painting"]), (at, True))
        client.do("stroke", emitter="brush", phase="end")
        client.until(lambda: not client.status["painting"] and client.status["iteration"] > at + 5)  # it was running, and continues
        client.do("pause")
        self.assertGreater(client.status["ledger"]["water"]["emitted"], water["emitted"])

    def test_a_stroke_has_no_gaps_however_rarely_its_places_come(self):
        client = self.client()
        (x0, y0, z), (x1, y1, _) = client.scene["bounds_mm"]
        brush = dict(client.scene["emitters"][2], size=(x1 - x0) / 20, spread_deg=0)
        client.do("event", event={"op": "emitter", "emitter": brush})
        ends = [[x0 + share * (x1 - x0), (y0 + y1) / 2, z] for share in (0.2, 0.8)]
        self.paint(client, *ends)
        client.do("save", path="dense.json")
        events = json.loads((self.folder / "dense.json").read_text())["events"]  # More than one where the recording was kept meanwhile.
        points = [point for event in events if event["op"] == "paint" for point in event["points"]]
        unit = (points[-1][0] - points[0][0]) / (ends[1][0] - ends[0][0])
        steps = [(b[0] - a[0]) / unit for a, b in zip(points, points[1:])]
        self.assertLessEqual(max(steps), brush["size"] / 4 + 1e-3)  # a quarter of its width from step to step
        self.assertGreater(len(points), 40)

    def test_a_stroke_ends_with_the_hand_that_draws_it(self):
        one, two = self.client(), self.client_without_reset()
        middle = [(a + b) / 2 for a, b in zip(*one.scene["bounds_mm"])]
        two.do("stroke", emitter="brush", position=middle, phase="begin")
        one.until(lambda: one.status["painting"])
        self.assertIn("no stroke", one.ask("stroke", emitter="brush", position=middle, phase="move")["message"])
        two.close()
        one.until(lambda: not one.status["painting"])
        one.step(3)

    def test_a_saved_scene_gives_the_same_bytes(self):
        client = self.client("ledge/painted.json")
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        client.step(3)
        client.do("event", event={"op": "behavior", "behavior": {"slider": 0.7}})
        client.step(2)
        client.do("event", event={"op": "ratio", "ratio": 0.1})  # before the file's own event of iteration 5, which then wins
        client.step(4)
        client.do("event", event={"op": "rate", "target": "dirt", "rate": 0.3})
        client.do("event", event={"op": "rule", "target": "evaporation", "rate": 0.4})
        client.do("event", event={"op": "rule", "target": "evaporation", "rate": 0.5})  # of those with the same members in one iteration the last
        client.do("event", event={"op": "rule", "target": "growing", "driver": "exposure * dirt", "products": {"moss": 0.5}, "rate": 2})
        client.do("run")  # the weather stands still meanwhile
        client.do("stroke", emitter="brush", position=middle, phase="begin")
        for i in range(5):
            client.do("stroke", emitter="brush", position=[middle[0] + 10 * i / 3, middle[1], middle[2]], phase="move")
            time.sleep(0.1)  # it paints on where it stays
        client.do("event", event={"op": "emitter", "emitter": dict(client.scene["emitters"][2], size=40)})  # in the middle of the stroke
        client.do("stroke", emitter="brush", positions=[[middle[0] + 7, *middle[1:]], middle], phase="move", jump=True)
        client.do("stroke", emitter="brush", phase="end")
        client.until(lambda: not client.status["painting"])
        client.do("pause")
        client.do("event", event={"op": "move", "target": "wall", "position": [0.1, 0.2, 0.3]})
        client.do("event", event={"op": "rule", "target": "growing", "driver": "slope * dirt"})  # its map is of the wall where it stood
        client.do("appearance", appearance={"dirt": {"strength": 0.7, "color": [0.3, 0.1, 0.1]}, "moss": {"height": 0.25}})
        client.do("run")
        client.until(lambda: client.status["iteration"] > 40)
        client.do("pause")
        client.settle()
        (self.folder / "saved").mkdir(exist_ok=True)
        client.do("save", path="saved/painted.json")
        client.do("export", path="painted_look", what=["textures"])
        saved = json.loads((self.folder / "saved/painted.json").read_text())
        self.assertEqual(saved["objects"][0]["mesh"], "../ledge/mesh.obj")
        self.assertEqual([e["target"] for e in saved["events"] if e["op"] == "paint"], ["brush", "brush"])  # before and after its size changed
        self.assertEqual([e["rate"] for e in saved["events"] if e["op"] == "rule" and e["target"] == "evaporation"], [0.5])
        self.run_in("simulate", "saved/painted.json", "-o", "painted")
        for file in ("color.png", "normal.png", "specular.png", "height.exr"):
            self.assertEqual((self.folder / "painted" / file).read_bytes(), (self.folder / "painted_look" / file).read_bytes(), file)
        client.do("export", path="painted_all", what=["history"])
        client.until(lambda: client.notices)
        self.assertEqual(self.atlas_hash("painted_all/simulation"), self.atlas_hash("painted"))
        for path in ("saved/painted.json", "../painted.json", "/tmp/painted.json", "painted.txt", "missing/painted.json"):
            self.assertEqual(client.ask("save", path=path)["type"], "error", path)

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
        client.do("undo")
        client.do("undo")
        client.until(lambda: client.status["iteration"] == 30)
        client.do("reset")
        client.until(lambda: client.status["iteration"] == 0)

    def test_a_scene_that_was_only_painted_is_simulated_to_its_strokes(self):
        client = self.client("ledge/only_painted.json")
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        self.paint(client, middle, [middle[0] + 30, *middle[1:]])
        self.assertEqual(client.status["iteration"], 0)
        client.do("save", path="at_the_start.json")
        client.do("export", path="at_the_start_look", what=["textures"])
        self.assertEqual(json.loads((self.folder / "at_the_start.json").read_text())["run"]["iterations"], 0)
        self.run_in("simulate", "at_the_start.json", "-o", "at_the_start")
        for file in ("color.png", "height.exr"):
            self.assertEqual((self.folder / "at_the_start" / file).read_bytes(), (self.folder / "at_the_start_look" / file).read_bytes(), file)

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
        client.do("appearance", appearance={"dirt": {"strength": 1.6}, "water": {"strength": client.start["water"]["strength"]}})
        client.settle()
        self.assertEqual(client.surface(), before)

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
        client.step(60)
        client.do("export", path="counted", what=["controls"])
        client.until(lambda: hits()["range"][1] > 1)
        time.sleep(0.7)  # the range follows a little later
        client.settle()
        while client.listen(0.3):
            pass
        # A byte stands for a root: the largest of them, and the range, are those of the counts, and no power of ten above.
        most = hits()["high"] * (max(client.planes["overlay"]) / 255) ** 2
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
        client.close()
        time.sleep(0.5)
        again = self.client_without_reset()
        again.settle()
        first = again.hashes[-1]["iteration"]
        time.sleep(0.3)
        self.assertEqual(again.settle()["iteration"], first)
        self.assertGreater(first, 5)


if __name__ == "__main__":
    unittest.main()
