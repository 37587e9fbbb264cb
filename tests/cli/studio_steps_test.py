#!/usr/bin/env python3
"""The list of steps of a running scene in patinate studio: what undo and redo bring back, and that no iteration is lost. Usage: studio_steps_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import sys
import unittest

from studio_live_case import LiveCase

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SETTINGS = ("exchange", "emitters", "objects", "behavior", "slider", "appearance", "rules")


class Steps(LiveCase):
    patinate, copies = PATINATE, ("settings", "between", "plain", "merged", "erased", "probed")

    def labels(self, client):
        steps = client.scene["steps"]
        return [s["label"] for s in steps["done"]], [s["label"] for s in steps["undone"]]

    def settings(self, client):
        return json.loads(json.dumps({key: client.scene[key] for key in SETTINGS}))

    def is_at_rest(self, client, iteration):
        client.status = None  # What was said before knows nothing of what was asked for.
        client.until(lambda: client.status and client.status["iteration"] == iteration and not client.status["running"])
        client.settle()

    def assert_simulate_repeats(self, client, name):
        client.do("save", path=f"{name}.json")
        client.do("export", path=f"{name}_look", what=["textures"])
        self.run_in("simulate", f"{name}.json", "-o", name)
        self.assertEqual((self.folder / name / "color.png").read_bytes(), (self.folder / f"{name}_look" / "color.png").read_bytes())

    def test_settings_moves_and_looks_are_undone_where_the_scene_is(self):
        client = self.client("ledge/settings.json")
        client.step(10)
        start = self.settings(client)
        rule = start["rules"][0]["name"]
        emitter = start["emitters"][0]
        for event in ({"op": "ratio", "ratio": 0.9}, {"op": "rate", "target": "water", "rate": 0.125}, {"op": "move", "target": "wall", "position": [5, 6, 7]},
                      {"op": "behavior", "behavior": {"slider": 0.3, "absorb": 0.2}}, {"op": "emitter", "emitter": {k: v for k, v in emitter.items() if k != "position" or emitter["shape"] != "sky"} | {"spread_deg": 12}},
                      {"op": "rule", "target": rule, "rate": 0.75}):
            client.do("event", event=event)
        client.do("appearance", appearance={"water": {"strength": 2.5}})
        client.step(5)
        done, undone = self.labels(client)
        self.assertEqual(done, ["Ratio 0.9", "Exchange of water: 0.125", "Move wall", "How it flows", f"{emitter['name']}: spread 12 deg", f"{rule}: rate 0.75", "Look of water: strength 2.5"])
        self.assertEqual(undone, [])
        changed = self.settings(client)
        client.do("undo")
        client.step(2)
        self.assertEqual(client.scene["appearance"], start["appearance"])
        self.assertEqual(client.scene["rules"], changed["rules"])
        client.do("undo", steps=6)
        client.settle()
        self.assertEqual(self.settings(client), start)
        self.assertEqual(client.status["iteration"], 17)
        self.assertEqual(self.labels(client), ([], done))
        client.do("redo", steps=7)
        client.settle()
        self.assertEqual(self.settings(client), changed)
        client.step(3)
        self.assertEqual(client.status["iteration"], 20)
        self.assert_simulate_repeats(client, "set")

    def test_a_stroke_goes_without_the_settings_after_it(self):
        plain, client = self.client("ledge/plain.json"), self.client("ledge/between.json")
        for one in (plain, client):
            one.step(6)
            if one is client:
                middle = [(a + b) / 2 for a, b in zip(*one.scene["bounds_mm"])]
                self.paint(one, middle, [middle[0] + 30, *middle[1:]])
            one.step(4)
            one.do("event", event={"op": "ratio", "ratio": 0.9})
            one.step(5)
        never_painted, painted = plain.surface(), client.surface()
        self.assertEqual(self.labels(client), (["Stroke with brush", "Ratio 0.9"], []))
        client.do("undo", steps=2)  # The ratio was 0.9 for five iterations, and they have happened.
        self.is_at_rest(client, 15)
        self.assertEqual(client.surface(), never_painted)
        client.do("redo")
        self.is_at_rest(client, 15)
        self.assertEqual(client.surface(), painted)
        client.do("undo")
        self.is_at_rest(client, 15)
        client.step(5)
        client.do("redo")  # and the iterations since are done with it
        self.is_at_rest(client, 20)
        self.assert_simulate_repeats(client, "between")

    def test_a_slider_that_is_dragged_is_one_step_and_a_name_makes_one_of_several(self):
        client = self.client("ledge/merged.json")
        client.step(2)
        start = self.settings(client)
        for ratio in (0.5, 0.55, 0.6, 0.65):
            client.do("event", event={"op": "ratio", "ratio": ratio}, gesture=7)
        client.do("event", event={"op": "behavior", "behavior": {"slider": 0.3, "absorb": 0.2}}, label="Splashes", gesture=8)
        client.do("event", event={"op": "ratio", "ratio": 0.1}, label="Splashes", gesture=8)
        client.settle()
        self.assertEqual(self.labels(client)[0], ["Ratio 0.65", "Splashes"])
        client.do("undo")
        client.settle()
        self.assertEqual(client.scene["exchange"]["ratio"], 0.65)
        client.do("undo")
        client.settle()
        self.assertEqual(self.settings(client), start)
        self.assertIn("nothing to undo", client.ask("undo")["message"])
        self.assertIn("/steps", client.ask("redo", steps=0)["message"])

    def test_an_eraser_takes_one_material_away_and_leaves_every_setting(self):
        client = self.client("ledge/erased.json")
        client.step(3)
        low, high = client.scene["bounds_mm"]
        way = [[low[0] + (high[0] - low[0]) * t / 20, (low[1] + high[1]) / 2, high[2]] for t in range(21)]
        brush = next(e for e in client.scene["emitters"] if e["shape"] == "surface")
        client.do("event", event={"op": "emitter", "emitter": brush | {"carries": {"water": 2, "dirt": 2}}})
        self.paint(client, *way)
        client.step(1)
        before, painted = self.settings(client), client.status["ledger"]
        client.do("stroke", emitter="brush", position=way[0], phase="begin", erase=["dirt"])
        client.do("stroke", emitter="brush", positions=way[1:], phase="end")
        client.until(lambda: not client.status["painting"])
        client.step(1)
        erased = client.status["ledger"]
        self.assertLess(erased["dirt"]["on_surfaces"], 0.5 * painted["dirt"]["on_surfaces"])  # In one go over a brush as wide: most of it.
        self.assertGreater(erased["water"]["on_surfaces"], 0.5 * painted["water"]["on_surfaces"])  # One iteration dries less.
        self.assertTrue(all(row["residual"] == 0 for row in erased.values()))
        self.assertEqual(self.settings(client), before)
        self.assertEqual(self.labels(client)[0][-1], "Erase with brush")
        self.assert_simulate_repeats(client, "erased")
        client.do("undo")
        self.is_at_rest(client, 5)
        self.assertGreater(client.status["ledger"]["dirt"]["on_surfaces"], 0.9 * painted["dirt"]["on_surfaces"])
        self.assertIn("expected a material", client.ask("stroke", emitter="brush", position=way[0], phase="begin", erase=["gold"])["message"])

    def test_an_exported_model_knows_metal_and_its_files_are_told(self):
        scene = json.loads(json.dumps(self.written))
        for thing in scene["objects"]:
            thing["preset"] = "copper"
        (self.folder / "ledge/metal.json").write_text(json.dumps(scene))
        client = self.client("ledge/metal.json")
        told = []
        take = client.socket.receive
        client.socket.receive = lambda timeout=60: told.append(take(timeout)) or told[-1]
        client.do("export", path="metal_look", what=["textures", "glb"])
        files = next(m for m in told if isinstance(m, dict) and m["type"] == "exported")
        self.assertEqual({f["path"]: f["bytes"] for f in files["files"]}, {str(p.relative_to(self.folder / "metal_look")): p.stat().st_size for p in (self.folder / "metal_look").rglob("*") if p.is_file()})
        glb = (self.folder / "metal_look/model.glb").read_bytes()
        surface = json.loads(glb[20:20 + int.from_bytes(glb[12:16], "little")])["materials"][0]["pbrMetallicRoughness"]
        self.assertEqual(surface["metallicFactor"], 1)
        self.assertIn("metallicRoughnessTexture", surface)
        status, headers, data = self.server.request(f"/api/file?place={files['place']}&path=model.glb")
        self.assertEqual((status, data), (200, glb))

    def test_a_probe_says_what_a_texel_is(self):
        client = self.client("ledge/probed.json")
        client.step(4)
        found = []
        take = client.socket.receive
        client.socket.receive = lambda timeout=60: found.append(take(timeout)) or found[-1]
        client.do("probe", x=30, y=40)
        probe = next(m for m in found if isinstance(m, dict) and m["type"] == "probe")
        width = client.scene["width"]
        at = 4 * (40 * width + 30)
        self.assertEqual(probe["srgb"], list(client.planes["surface"][at:at + 3]))
        self.assertEqual((probe["iteration"], set(probe["amounts"])), (4, set(client.scene["materials"])))
        self.assertIn("/x", client.ask("probe", x=width, y=0)["message"])


if __name__ == "__main__":
    unittest.main()
