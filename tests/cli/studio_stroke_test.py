#!/usr/bin/env python3
"""Painting in a running scene of patinate studio: strokes, what undoes them, and what is saved of them. Usage: studio_stroke_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import sys
import time
import unittest

from studio_live_case import LiveCase

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


class Strokes(LiveCase):
    patinate, copies = PATINATE, ("painted", "only_painted", "plain")

    def test_undo_takes_the_stroke_away_and_no_iteration(self):
        plain = self.client("ledge/plain.json")
        plain.step(12)
        never_painted = plain.surface()
        client = self.client()
        client.step(10)
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        self.paint(client, middle, [middle[0] + 3, *middle[1:]])
        client.step(2)
        after = client.surface()
        self.assertNotEqual(after, never_painted)
        client.until(lambda: client.status["can_undo"] and not client.status["can_redo"])
        client.do("undo")
        client.until(lambda: client.status["iteration"] == 12 and client.status["can_redo"] and not client.status["running"])
        client.settle()
        self.assertEqual(client.surface(), never_painted)
        self.assertFalse(client.scene["emitters"][2]["on"])
        client.do("save", path="undone.json")  # nothing of the stroke is left in it
        self.assertEqual(json.loads((self.folder / "undone.json").read_text())["events"], [{"iteration": 5, "op": "ratio", "ratio": 0.6}])
        client.do("redo")  # with all that it has led to
        client.until(lambda: client.status["iteration"] == 12 and not client.status["can_redo"] and not client.status["running"])
        client.settle()
        self.assertEqual(client.surface(), after)
        client.do("save", path="redone.json")
        self.assertEqual([e["op"] for e in json.loads((self.folder / "redone.json").read_text())["events"]], ["paint", "ratio"])
        client.do("undo")
        client.do("event", event={"op": "ratio", "ratio": 0.7})  # something else was done: what was undone is gone
        self.assertIn("nothing to redo", client.ask("redo")["message"])

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
            emitted = client.status["counters"]["emitted"]
            client.until(lambda: client.status["counters"]["emitted"] > emitted)
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

    def test_a_place_beyond_all_scenes_is_refused_and_the_run_goes_on(self):
        one, two = self.client(), self.client_without_reset()
        middle = [(a + b) / 2 for a, b in zip(*one.scene["bounds_mm"])]
        brush = dict(one.scene["emitters"][2])
        for far in (1e308, -1e308, 1e200, 1e10):
            with self.subTest(far=far):
                self.assertIn("1e9 mm", one.ask("stroke", emitter="brush", position=[far, 0, 0], phase="begin")["message"])
                one.do("stroke", emitter="brush", position=middle, phase="begin")
                self.assertIn("1e9 mm", one.ask("stroke", emitter="brush", positions=[middle, [0, far, 0]], phase="move")["message"])
                one.do("stroke", emitter="brush", phase="end")
                self.assertEqual(one.ask("event", event={"op": "move", "target": "brush", "position": [far, 0, 0]})["type"], "error")
                self.assertEqual(one.ask("event", event={"op": "emitter", "emitter": {**brush, "position": [0, 0, far]}})["type"], "error")
                if far > 0:
                    self.assertEqual(one.ask("event", event={"op": "emitter", "emitter": {**brush, "size": far}})["type"], "error")
        two.step(3)

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


if __name__ == "__main__":
    unittest.main()
