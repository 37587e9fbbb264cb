#!/usr/bin/env python3
"""patinate simulate and recompose, as a user types them. Usage: simulate_test.py PATINATE [unittest arguments]"""
import hashlib
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

from command_case import nightly
from studio_client import kill_when_there_is

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


def tree_hash(folder):
    """Of every file but run.json and job.json, which tell of the run, and what a transfer keeps."""
    digest = hashlib.sha256()
    for path in sorted(p for p in pathlib.Path(folder).rglob("*") if p.is_file() and p.name not in ("run.json", "job.json") and ".cache" not in p.parts):
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


class Simulate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_simulate_"))
        cls.run_in(["synth", "ledge", "--cells", "8", "-o", "ledge"], check=True)
        cls.scene = json.loads((cls.folder / "ledge/scene.json").read_text())
        cls.scene["atlas"] = {"resolution": 128}
        cls.scene["run"] = {"iterations": 40, "history_every": 10, "controls": ["hits", "dirt.deposited"]}
        for emitter in cls.scene["emitters"]:
            emitter["gammatons"] = 200
        cls.write("ledge/small.json", cls.scene)
        cls.run_in(["simulate", "ledge/small.json", "-o", "small"], check=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @classmethod
    def run_in(cls, arguments, check=False):
        result = subprocess.run([PATINATE, *arguments], cwd=cls.folder, capture_output=True, text=True, timeout=300)
        if check and result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}")
        return result

    @classmethod
    def write(cls, name, scene):
        (cls.folder / name).write_text(json.dumps(scene))
        return name

    def pixels(self, name):
        """What a PNG's IDAT chunks hold."""
        data = (self.folder / name).read_bytes()
        packed, at = b"", 8
        while at < len(data):
            length = struct.unpack(">I", data[at:at + 4])[0]
            if data[at + 4:at + 8] == b"IDAT":
                packed += data[at + 8:at + 8 + length]
            at += 12 + length
        return zlib.decompress(packed)

    def test_drops_that_would_leave_the_surface_are_told_before_the_run(self):
        for pull, is_told in ((0.9, True), (1.1, False)):
            name = self.write("ledge/pull.json", dict(self.scene, tracing={"reach": 5, "epsilon": 1, "pull": pull}))
            told = self.run_in(["simulate", name, "-o", "pull", "--dry-run"], check=True).stderr
            self.assertEqual("sink by `pull`, 0.9, and hover by `epsilon`, 1:" in told, is_told, told)

    def test_what_a_scene_says_without_effect_is_told_before_the_run(self):
        late = {"iteration": 41, "op": "switch", "target": self.scene["emitters"][0]["name"], "on": False}
        rates = {material: rate for material, rate in self.scene["exchange"]["rates"].items() if material != "water"}
        carries = [dict(emitter, carries={"water": 0.5}) for emitter in self.scene["emitters"][:1]]
        name = self.write("ledge/idle.json", dict(self.scene, events=[dict(late, iteration=40), late], emitters=carries, exchange={"rates": rates}))
        told = self.run_in(["simulate", name, "-o", "idle", "--dry-run"], check=True).stderr
        self.assertIn("1 event comes after the run's end, the first at iteration 41 of 40", told)
        self.assertIn(f"emitter '{carries[0]['name']}' carries water, which drops never give away", told)
        told = self.run_in(["simulate", "ledge/small.json", "-o", "other", "--dry-run"], check=True).stderr
        self.assertNotIn("after the run's end", told)
        self.assertNotIn("never give away", told)

    def test_maps_of_several_objects_are_there_for_each_and_refused_for_another_mesh(self):
        one = self.scene["objects"][0]
        self.write("ledge/two.json", dict(self.scene, objects=[dict(one, name="left"), dict(one, name="right", translate=[500, 0, 0])]))
        self.run_in(["simulate", "ledge/two.json", "-o", "two"], check=True)
        controls = json.loads((self.folder / "two/simulation.json").read_text())["controls"]
        self.assertEqual(controls[0]["objects"], {"left": "controls/left/hits.exr", "right": "controls/right/hits.exr"})
        mesh = (self.folder / "ledge" / one["mesh"]).resolve()
        refused = self.run_in(["control", str(mesh), "--kind", "two/controls/hits.exr", "-o", "out.exr"])
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("two/controls/left/hits.exr", refused.stderr)
        facts = json.loads(self.run_in(["info", "two/controls/left/hits.exr", "--json"], check=True).stdout)
        self.assertEqual(facts["unit"], "1/mm2")
        side = str(facts["size"][0])
        self.run_in(["control", str(mesh), "--kind", "two/controls/left/hits.exr", "--resolution", side, "-o", "own.exr"], check=True)
        self.assertNotIn("objects", json.loads((self.folder / "small/simulation.json").read_text())["controls"][0])

    def test_makes_the_files_of_the_contract(self):
        made = {str(p.relative_to(self.folder / "small")) for p in (self.folder / "small").rglob("*") if p.is_file()}
        for name in ["simulation.json", "atlas.exr", "color.png", "normal.png", "height.exr", "specular.png", "model.glb", "controls/hits.exr",
                     "controls/dirt.deposited.exr", "history/history.json", "run.json"]:
            self.assertIn(name, made)
        self.assertEqual(len([n for n in made if n.startswith("history/frames/")]), 5)  # before the first iteration, and after 10, 20, 30, 40
        history = json.loads((self.folder / "small/history/history.json").read_text())
        self.assertEqual(history["origin"], "simulated")
        self.assertEqual([c["name"] for c in history["controls"]], ["hits", "dirt.deposited"])
        self.assertEqual(self.run_in(["validate", "small/history"]).returncode, 0)

    def test_gammatons_and_mass_balance_exactly(self):
        manifest = json.loads((self.folder / "small/simulation.json").read_text())
        c = manifest["counters"]
        self.assertEqual(c["emitted"], c["absorbed"] + c["left"] + c["rested"] + c["alive"])
        self.assertGreater(c["contacts"], 500)
        for material, row in manifest["ledger"].items():
            gone = row["on_surfaces"] + row["carried"] + row["absorbed"] + row["rested"] + row["left"] + row["used"]
            self.assertAlmostEqual(row["emitted"] + row["made"], gone, places=6, msg=material)  # text has 15 digits; inside they are integers
        self.assertGreater(manifest["ledger"]["dirt"]["on_surfaces"], 0)

    def test_says_up_to_date_and_gives_the_ledger_as_json(self):
        result = self.run_in(["simulate", "ledge/small.json", "-o", "small", "--json"], check=True)
        said = json.loads(result.stdout)
        self.assertEqual(said["status"], "up to date")
        self.assertIn("dirt", said["ledger"])

    def test_same_bytes_for_any_number_of_threads_and_frames_in_between(self):
        for threads in ("1", "2", "5"):
            self.run_in(["simulate", "ledge/small.json", "-o", f"threads{threads}", "--threads", threads], check=True)
            self.assertEqual(tree_hash(self.folder / f"threads{threads}"), tree_hash(self.folder / "small"))
        often = self.run_in(["simulate", "ledge/small.json", "-o", "often", "--history-every", "1", "--json"], check=True)
        self.assertEqual(json.loads(often.stdout)["atlas_hash"], json.loads((self.folder / "small/simulation.json").read_text())["atlas_hash"])

    def test_same_bytes_for_any_instruction_set(self):
        for name in ("baseline", "avx2", "avx512"):
            with self.subTest(instruction_set=name):
                result = subprocess.run([PATINATE, "simulate", "ledge/small.json", "-o", name], cwd=self.folder, capture_output=True, text=True, timeout=300,
                                        env={**os.environ, "PATINATE_ISA": name})
                if result.returncode != 0 and name != "baseline" and "PATINATE_ISA" in result.stderr:
                    self.skipTest(f"this machine lacks {name}")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(tree_hash(self.folder / name), tree_hash(self.folder / "small"))

    def test_a_killed_run_goes_on_and_ends_in_the_same_bytes(self):
        scene = dict(self.scene, run={"iterations": 400, "history_every": 20}, atlas={"resolution": 256})
        self.write("ledge/long.json", scene)
        self.run_in(["simulate", "ledge/long.json", "-o", "whole"], check=True)
        for file in (".job/key", *(f"history/frames/{frame:04}.exr" for frame in (1, 4, 8, 13))):
            process = subprocess.Popen([PATINATE, "simulate", "ledge/long.json", "-o", "pieces"], cwd=self.folder, stderr=subprocess.DEVNULL)
            kill_when_there_is(self.folder / "pieces.partial" / file, process)
        self.run_in(["simulate", "ledge/long.json", "-o", "pieces"], check=True)
        self.assertEqual(tree_hash(self.folder / "pieces"), tree_hash(self.folder / "whole"))

    def test_recompose_changes_the_look_and_nothing_else(self):
        self.run_in(["simulate", "restyle", "small", "-o", "same"], check=True)
        for name in ("color.png", "specular.png", "normal.png", "height.exr"):
            self.assertEqual((self.folder / "same" / name).read_bytes(), (self.folder / "small" / name).read_bytes(), name)
        for path in (self.folder / "small/history").rglob("*.exr"):
            if path.parent.name != "controls":
                name = path.relative_to(self.folder / "small")
                self.assertEqual((self.folder / "same" / name).read_bytes(), path.read_bytes(), name)
        self.run_in(["validate", "same/history"], check=True)
        self.run_in(["simulate", "restyle", "small", "-o", "clean", "--set", "dirt.strength=0", "--set", "water.strength=0"], check=True)
        self.assertNotEqual((self.folder / "clean/color.png").read_bytes(), (self.folder / "small/color.png").read_bytes())
        wrong = self.run_in(["simulate", "restyle", "small", "-o", "x", "--set", "dirt.strenth=1"])
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("did you mean `strength`", wrong.stderr)

    def test_what_is_recomposed_is_a_simulation_of_another_look(self):
        self.run_in(["simulate", "restyle", "small", "-o", "same_look"], check=True)
        kinds = {k: json.loads(self.run_in(["info", k, "--json"], check=True).stdout)["kind"] for k in ("small", "same_look")}
        self.assertEqual(kinds["small"], kinds["same_look"])
        for folder in ("small", "same_look"):
            self.run_in(["render", folder, "-o", f"{folder}.png", "--width", "48", "--height", "48"], check=True)
        self.assertEqual(*(hashlib.sha256(self.pixels(f"{folder}.png")).hexdigest() for folder in ("small", "same_look")))
        before, after = (json.loads((self.folder / f / "simulation.json").read_text()) for f in ("small", "same_look"))
        self.assertEqual({k: v for k, v in before.items() if k not in ("key", "scene_files")}, {k: v for k, v in after.items() if k not in ("key", "scene_files")})
        self.run_in(["simulate", "restyle", "small", "-o", "pale", "--set", "dirt.strength=0"], check=True)
        self.run_in(["export", "pale", "-o", "pale.glb", "--num-times", "2"], check=True)
        pale = json.loads((self.folder / "pale/simulation.json").read_text())
        for name, object in pale["outcome"]["objects"].items():
            self.assertEqual(object["materials"]["dirt"]["shows_share"], 0)
            self.assertEqual(object["materials"]["dirt"]["mean"], before["outcome"]["objects"][name]["materials"]["dirt"]["mean"])
            self.assertEqual(object["never_met_share"], before["outcome"]["objects"][name]["never_met_share"])
        # Looks add up, and its scene is the one that shows this look.
        self.run_in(["simulate", "restyle", "pale", "-o", "both", "--set", "water.strength=0"], check=True)
        self.run_in(["simulate", "restyle", "small", "-o", "at_once", "--set", "dirt.strength=0", "--set", "water.strength=0"], check=True)
        self.assertEqual((self.folder / "both/color.png").read_bytes(), (self.folder / "at_once/color.png").read_bytes())
        self.run_in(["simulate", "pale/" + pale["scene"], "-o", "simulated_pale"], check=True)
        for name in ("color.png", "normal.png", "atlas.exr"):
            self.assertEqual((self.folder / "simulated_pale" / name).read_bytes(), (self.folder / "pale" / name).read_bytes(), name)

    def test_frames_carry_gloss_relief_and_amounts_to_everything_that_shows_them(self):
        frames = json.loads((self.folder / "small/history/history.json").read_text())["frames"]
        for frame in frames:
            self.assertEqual(set(frame), {"time", "file", "specular", "normal", "height", "amounts"})
            for name in ("specular", "normal", "height", "amounts"):
                self.assertTrue((self.folder / "small/history" / frame[name]).is_file())
        self.run_in(["export", "small", "-o", "ages.glb", "--num-times", "2"], check=True)
        data = (self.folder / "ages.glb").read_bytes()
        gltf = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
        for material in gltf["materials"]:
            self.assertIn("normalTexture", material)
            self.assertIn("metallicRoughnessTexture", material["pbrMetallicRoughness"])
        self.run_in(["transfer", "small/history", "ledge/mesh.obj", "--control", "hits=accessibility", "--resolution", "64", "-o", "on_wall"], check=True)
        self.run_in(["texture", "on_wall", "--map", "height", "--times", "0", "-o", "height.exr"], check=True)
        facts = json.loads(self.run_in(["info", "small/history", "--json"], check=True).stdout)
        self.assertEqual(facts["frame_maps"], "specular, normal, height")

    def test_replicates_are_the_simulations_of_their_seeds(self):
        arguments = ["simulate", "ledge/small.json", "--resolution", "64", "--iterations", "6"]
        report = json.loads(self.run_in([*arguments, "--seed", "5", "--replicates", "2", "-o", "several", "--json"], check=True).stdout)
        self.assertEqual([r["folder"] for r in report["replicates"]], ["seed_5", "seed_6"])
        self.assertEqual(len({r["atlas_hash"] for r in report["replicates"]}), 2)
        alone = json.loads(self.run_in([*arguments, "--seed", "6", "-o", "alone", "--json"], check=True).stdout)
        self.assertEqual(alone["atlas_hash"], report["replicates"][1]["atlas_hash"])
        self.assertEqual((self.folder / "alone/atlas.exr").read_bytes(), (self.folder / "several/seed_6/atlas.exr").read_bytes())
        # Those that there are stay when more are asked for.
        before = (self.folder / "several/seed_5/run.json").read_bytes()
        more = json.loads(self.run_in([*arguments, "--seed", "5", "--replicates", "3", "-o", "several", "--json"], check=True).stdout)
        self.assertEqual(len(more["replicates"]), 3)
        self.assertEqual((self.folder / "several/seed_5/run.json").read_bytes(), before)
        refused = self.run_in([*arguments, "--replicates", "2", "-o", "alone"])
        self.assertEqual(refused.returncode, 1)
        self.assertIn("a folder of their own", refused.stderr)

    def test_estimate_of_a_small_scene_is_the_run_itself_and_makes_nothing(self):
        before = sorted(p.name for p in self.folder.iterdir())
        told = json.loads(self.run_in(["simulate", "ledge/small.json", "--estimate", "--json"], check=True).stdout)
        self.assertEqual(before, sorted(p.name for p in self.folder.iterdir()))
        made = json.loads((self.folder / "small/simulation.json").read_text())["outcome"]
        self.assertEqual(told["objects"], made["objects"])
        for arguments in (["--estimate", "-o", "x"], []):
            self.assertEqual(self.run_in(["simulate", "ledge/small.json", *arguments]).returncode, 2)

    @nightly
    def test_the_chest_of_the_examples_ages_and_its_patina_runs_onto_the_wood(self):
        scene = pathlib.Path(__file__).resolve().parents[2] / "docs/examples/scenes/chest/chest.json"
        told = json.loads(self.run_in(["simulate", str(scene), "--estimate", "--json"], check=True).stdout)
        self.assertEqual(told["advice"], [])
        for planks in ("planks", "other_planks"):
            self.assertGreater(told["objects"][planks]["materials"]["verdigris"]["shows_share"], 0)

    @nightly
    def test_the_gate_of_the_examples_flakes_and_its_iron_bleeds_onto_the_wood(self):
        scene = pathlib.Path(__file__).resolve().parents[2] / "docs/examples/scenes/gate/gate.json"
        told = json.loads(self.run_in(["simulate", str(scene), "--estimate", "--json"], check=True).stdout)
        planks = told["objects"]["planks"]["materials"]
        self.assertGreater(planks["stain"]["shows_share"], 0)
        self.assertGreater(planks["bare"]["shows_share"], 0.1)
        self.assertLess(planks["bare"]["shows_share"], 0.9)

    def scene_of_many_files(self, folder):
        """A scene whose mesh, picture and rule lie in folders beside it. Its JSON is the same wherever `folder` is."""
        (self.folder / folder / "in").mkdir(parents=True)
        (self.folder / folder / "shapes").mkdir()
        shutil.copy(self.folder / "ledge/mesh.obj", self.folder / folder / "shapes/wall.obj")
        shutil.copy(self.folder / "small/color.png", self.folder / folder / "shapes/wall.png")
        (self.folder / folder / "mine.json").write_text(json.dumps({"format": "patinate.rule", "version": 2, "name": "mine", "driver": "water", "products": {"dirt": 0.5}}))
        scene = dict(self.scene, objects=[dict(self.scene["objects"][0], mesh="../shapes/wall.obj", maps={"color": "../shapes/wall.png"})], run={"iterations": 6, "controls": ["hits"]})
        scene["appearance"] = {**scene.get("appearance", {}), "dirt": {"color": "../shapes/wall.png"}}
        scene["rules"] = [*scene.get("rules", []), "../mine.json"]
        return self.write(f"{folder}/in/many.json", scene)

    def test_its_folder_holds_the_scene_and_opens_anywhere(self):
        self.run_in(["simulate", self.scene_of_many_files("many"), "-o", "kept"], check=True)
        self.run_in(["simulate", self.scene_of_many_files("deeper/down/many"), "-o", "deeper/kept"], check=True)
        self.assertEqual(tree_hash(self.folder / "kept"), tree_hash(self.folder / "deeper/kept"))  # nothing of where it was made is in it
        held = {str(p.relative_to(self.folder / "kept/scene")) for p in (self.folder / "kept/scene").rglob("*")}
        self.assertEqual(held, {"many.json", "wall.obj", "wall.png", "mine.json"})
        self.run_in(["simulate", "restyle", "kept", "-o", "look"], check=True)
        (self.folder / "far/away").mkdir(parents=True)
        (self.folder / "kept").rename(self.folder / "far/away/moved")
        shutil.rmtree(self.folder / "many")
        self.run_in(["simulate", "restyle", "far/away/moved", "-o", "look_again"], check=True)
        for name in ("color.png", "normal.png"):
            self.assertEqual((self.folder / "look_again" / name).read_bytes(), (self.folder / "look" / name).read_bytes())
        self.run_in(["render", "far/away/moved", "-o", "moved.png", "--width", "32", "--height", "32"], check=True)
        again = json.loads(self.run_in(["simulate", "far/away/moved/scene/many.json", "-o", "simulated_again", "--json"], check=True).stdout)
        self.assertEqual(again["atlas_hash"], json.loads((self.folder / "far/away/moved/simulation.json").read_text())["atlas_hash"])

    def test_a_killed_run_keeps_the_scene_that_it_began_with(self):
        """What the folder holds is what was simulated; a scene that changes before the run continues is another."""
        scene = json.loads(json.dumps(self.scene))
        scene["run"] = {"iterations": 5000, "history_every": 100}
        (self.folder / "changing").mkdir()
        shutil.copy(self.folder / "ledge/mesh.obj", self.folder / "changing/mesh.obj")
        self.write("changing/scene.json", scene)
        process = subprocess.Popen([PATINATE, "simulate", "changing/scene.json", "-o", "changed"], cwd=self.folder, stderr=subprocess.DEVNULL)
        kill_when_there_is(self.folder / "changed.partial/history/frames/0001.exr", process)
        self.write("changing/scene.json", dict(scene, run={"iterations": 20, "history_every": 10}))
        self.run_in(["simulate", "changing/scene.json", "-o", "changed"], check=True)
        self.assertEqual(json.loads((self.folder / "changed/scene/scene.json").read_text())["run"]["iterations"], 20)

    def test_rules_and_buffers_of_meshes_are_part_of_what_it_was_made_from(self):
        name = self.scene_of_many_files("parts")
        self.run_in(["simulate", name, "-o", "parted"], check=True)
        rule = self.folder / "parts/mine.json"
        rule.write_text(rule.read_text().replace("0.5", "0.25"))
        changed = self.run_in(["simulate", name, "-o", "parted"])
        self.assertEqual(changed.returncode, 1, changed.stderr)
        self.assertIn("mine.json", changed.stderr)
        positions = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
        indices = struct.pack("<12H", 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
        (self.folder / "solid/data").mkdir(parents=True)
        (self.folder / "solid/data/a b.bin").write_bytes(positions + indices)
        gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                              {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
                "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}], "buffers": [{"byteLength": 72, "uri": "data/a%20b.bin"}]}
        (self.folder / "solid/solid.gltf").write_text(json.dumps(gltf))
        scene = dict(self.scene, objects=[dict(self.scene["objects"][0], mesh="solid.gltf")], events=[], run={"iterations": 2})
        self.write("solid/scene.json", scene)
        self.run_in(["simulate", "solid/scene.json", "-o", "solid_run"], check=True)
        held = {str(p.relative_to(self.folder / "solid_run/scene")) for p in (self.folder / "solid_run/scene").rglob("*") if p.is_file()}
        self.assertEqual(held, {"scene.json", "solid/solid.gltf", "solid/data/a b.bin"})
        self.run_in(["simulate", "restyle", "solid_run", "-o", "solid_look"], check=True)
        (self.folder / "solid/data/a b.bin").write_bytes(struct.pack("<12f", 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1) + indices)
        changed = self.run_in(["simulate", "solid/scene.json", "-o", "solid_run"])
        self.assertEqual(changed.returncode, 1, changed.stderr)
        self.assertIn("a b.bin", changed.stderr)

    def test_a_parameter_map_drives_a_transfer(self):
        self.run_in(["synth", "crackle", "--width", "64", "--height", "64", "--num-frames", "3", "-o", "crackle"], check=True)
        self.run_in(["ingest", "crackle", "-o", "paint"], check=True)
        self.run_in(["transfer", "paint", "ledge/mesh.obj", "--unit", "mm", "--resolution", "128", "--control", "small/controls/hits.exr", "-o", "wet_paint"], check=True)

    def test_a_simulation_is_a_history_for_transfer(self):
        self.run_in(["transfer", "small", "ledge/mesh.obj", "--unit", "mm", "--resolution", "64", "--control", "hits=facing", "-o", "again"], check=True)

    def test_open_and_inside_out_meshes_are_named(self):
        lines = (self.folder / "ledge/mesh.obj").read_text().splitlines()
        faces = [line for line in lines if line.startswith("f ")]
        rest = [line for line in lines if not line.startswith("f ")]
        turned = [" ".join([f.split()[0], *reversed(f.split()[1:])]) for f in faces]
        for name, kept, said in (("open", faces[:-10], "object 'wall' is open"), ("turned", turned, "object 'wall' is inside out")):
            (self.folder / f"ledge/{name}.obj").write_text("\n".join(rest + kept) + "\n")
            scene = dict(self.scene, objects=[dict(self.scene["objects"][0], mesh=f"{name}.obj")], run={"iterations": 2})
            self.write(f"ledge/{name}.json", scene)
            self.assertIn(said, self.run_in(["simulate", f"ledge/{name}.json", "-o", name], check=True).stderr)

    def test_a_stroke_is_the_moves_that_it_stands_for(self):
        brush = {"name": "brush", "shape": "surface", "position": [0, 500, 0], "size": [60, 60], "distance": 20, "speed": 1000, "gammatons": 100,
                 "carries": {"dirt": 2}, "on": False}
        a, b, middle = [-200, 600, 0], [100, 500, 0], [-50, 550, 0]
        stroke = [{"iteration": 3, "op": "stroke", "target": "brush", "points": [a, b], "every": 2}]
        moves = [{"iteration": 3, "op": "switch", "target": "brush", "on": True}, {"iteration": 3, "op": "move", "target": "brush", "position": a},
                 {"iteration": 4, "op": "move", "target": "brush", "position": middle}, {"iteration": 5, "op": "move", "target": "brush", "position": b},
                 {"iteration": 7, "op": "switch", "target": "brush", "on": False}]
        made = {}
        for name, events in (("stroke", stroke), ("moves", moves), ("nothing", [])):
            scene = dict(self.scene, emitters=self.scene["emitters"] + [brush], events=events, run={"iterations": 12})
            self.write(f"ledge/{name}.json", scene)
            made[name] = json.loads(self.run_in(["simulate", f"ledge/{name}.json", "-o", f"painted_{name}", "--json"], check=True).stdout)
        self.assertEqual(made["stroke"]["atlas_hash"], made["moves"]["atlas_hash"])
        self.assertNotEqual(made["stroke"]["atlas_hash"], made["nothing"]["atlas_hash"])
        point = {"iteration": 3, "op": "stroke", "target": "brush"}
        for wrong, said in (({"points": []}, "points"), ({"points": [a], "every": 0}, "/every"), ({"points": [a], "target": "wall"}, "/target"),
                            ({"points": [[1, 2]]}, "/points/0"), ({"points": [a, b], "every": 1000000}, "iterations"), ({}, "points")):
            self.refused(lambda s: (s["emitters"].append(brush), s.update(events=[{**point, **wrong}])), 3, "/events/0", said)
        self.refused(lambda s: s.update(events=[{"iteration": 1, "op": "switch", "target": "rain"}]), 3, "/events/0", "on")

    def test_rules_change_while_it_runs(self):
        def made_by(name, rules, events):
            self.write(f"ledge/{name}.json", dict(self.scene, materials=["water", "dirt", "organic"], rules=rules, events=events, run={"iterations": 24}))
            said = json.loads(self.run_in(["simulate", f"ledge/{name}.json", "-o", f"made_{name}", "--json"], check=True).stdout)
            return said["atlas_hash"], said["ledger"]["organic"]["made"]
        new = {"driver": "min(water, dirt)", "products": {"organic": 1}}
        early = {"iteration": 8, "op": "rule", "target": "growth"}
        at_once = made_by("at_once", [{"name": "growth", "rate": 0.5}], [])
        self.assertGreater(at_once[1], 0)
        old = dict(self.scene, version=1, materials=["water", "dirt", "organic"], events=[dict(early, iteration=0, alpha=0.5)], run={"iterations": 24},
                   rules=[{"name": "greening", "driver": "min(water, dirt)", "alpha": 0.5, "makes": {"organic": 1}, "uses": {}}, {"name": "growth", "alpha": 0}])
        old["events"][0]["target"] = "greening"
        self.write("ledge/old.json", old)
        said = json.loads(self.run_in(["simulate", "ledge/old.json", "-o", "made_old", "--json"], check=True).stdout)
        self.assertGreater(said["ledger"]["organic"]["made"], 0)
        # Off until iteration 0 changes it: as if it had been so.
        self.assertEqual(made_by("changed", [{"name": "growth", "rate": 3}], [dict(early, iteration=0, rate=0.5)]), at_once)
        self.assertEqual(made_by("off", [{"name": "growth", "rate": 3}], [dict(early, iteration=0, rate=0)])[1], 0)
        # A rule that comes later: a built-in one by its name, a new one in full; with rate 0 before it is the same.
        late = made_by("late", [], [dict(early, rate=0.5)])
        self.assertGreater(late[1], 0)
        self.assertLess(late[1], at_once[1])
        self.assertEqual(made_by("in_full", [], [dict(early, rate=0.5, **new)]), late)
        self.assertEqual(made_by("waited", [{"name": "growth", "rate": 0}], [dict(early, rate=0.5)]), late)
        again = [dict(early, target="greening", rate=0.2, **new), dict(early, target="greening", iteration=12, products={"organic": 0.5})]
        self.assertGreater(made_by("new", [], again)[1], 0)

        def refused(event, *words):
            self.refused(lambda s: s.update(rules=["evaporation"], events=[dict(early, **event)]), 3, "/events/0", *words)
        refused({"target": "evaporatoin"}, "/target", "evaporation")
        refused({"target": "evaporation"}, "rate", "driver")
        refused({"target": "evaporation", "rate": -1}, "/rate")
        refused({"target": "evaporation", "driver": "watr"}, "watr")
        refused({"target": "evaporation", "reactants": {"gold": 1}}, "gold")
        refused({"target": "rust"}, "`rust` is none")
        refused({"target": "mine", "rate": 1}, "/target", "driver")
        self.refused(lambda s: s.update(rules=["evaporation", "evaporation"], events=[dict(early, target="evaporation", rate=1)]), 3, "/target", "2 are called so")

    def test_paint_fades_where_the_sky_is_open(self):
        scene = dict(self.scene, materials=["water", "wood", "pigment", "bleached"], appearance={}, rules=[{"name": "fading", "rate": 0.5}], run={"iterations": 24})
        scene["objects"] = [dict(scene["objects"][0], preset="painted_wood")]
        scene["emitters"] = [dict(scene["emitters"][0], carries={"water": 0.5})]
        scene["exchange"] = {"rates": {"water": 0.3}}
        self.write("ledge/paint.json", scene)
        said = json.loads(self.run_in(["simulate", "ledge/paint.json", "-o", "faded", "--json"], check=True).stdout)
        self.assertGreater(said["ledger"]["bleached"]["made"], 0)
        self.assertAlmostEqual(said["ledger"]["bleached"]["made"], said["ledger"]["pigment"]["used"], places=6)

    def refused(self, change, code, *words):
        scene = json.loads(json.dumps(self.scene))
        change(scene)
        self.write("ledge/wrong.json", scene)
        result = self.run_in(["simulate", "ledge/wrong.json", "-o", "wrong"])
        self.assertEqual(result.returncode, code, result.stderr)
        errors = [line for line in result.stderr.splitlines() if line.startswith("patinate: error: ")]
        self.assertEqual(len(errors), 1, result.stderr)
        for word in words:
            self.assertIn(word, errors[0])
        self.assertFalse((self.folder / "wrong").exists())

    def test_a_scene_of_version_1_ages_as_before(self):
        event = {"iteration": 3, "op": "behavior", "behavior": {"slider": 0.3}}
        now = {**self.scene, "events": [event], "run": {"iterations": 6}}
        self.assertEqual((now["version"], "behavior" in now), (2, True))
        before = json.loads(json.dumps({**now, "version": 1}).replace("behavior", "behaviour"))
        for name, scene in ("now", now), ("before", before):
            self.run_in(["simulate", self.write(f"ledge/{name}.json", scene), "-o", name], check=True)
        for name in "color.png", "atlas.exr":
            self.assertEqual((self.folder / "before" / name).read_bytes(), (self.folder / "now" / name).read_bytes(), name)

    def test_bad_scenes_are_refused_in_one_line(self):
        self.refused(lambda s: s.update(emitters=[]), 3, "emitter")
        self.refused(lambda s: s.update(materials=[f"m{i}" for i in range(9)]), 3, "/materials", "1 to 8")
        self.refused(lambda s: s["rules"].append("rusty"), 3, "/rules/", "rusty")
        self.refused(lambda s: s["exchange"].update(ratio=1.5), 3, "/exchange/ratio", "[0, 1]")
        self.refused(lambda s: s["exchange"]["rates"].update(watr=0.5), 3, "/exchange/rates", "watr")
        self.refused(lambda s: s["emitters"][0].update(carries={"gold": 1}), 3, "gold")
        self.refused(lambda s: s["objects"][0].update(preset="marbel"), 3, "/objects/0/preset")
        self.refused(lambda s: s["objects"][0].update(mesh="none.obj"), 3, "none.obj")
        self.refused(lambda s: s.update(events=[{"iteration": 3, "op": "move", "target": "rian", "position": [0, 0, 0]}]), 3, "/events/0/target", "rian")
        self.refused(lambda s: s["emitters"].append({"name": "inside", "shape": "point", "position": [0, 400, -50], "carries": {"water": 1}}), 3, "inside")
        self.refused(lambda s: s.update(color=1), 3, "color")

    def test_a_mesh_with_overlapping_uvs_is_named_when_its_uvs_are_insisted_on(self):
        text = (self.folder / "ledge/mesh.obj").read_text()
        lines = ["vt 0.5 0.5" if line.startswith("vt ") else line for line in text.splitlines()]
        shrunk = [f"vt {0.2 + 0.5 * float(l.split()[1]) % 0.3:.6f} {0.2 + 0.5 * float(l.split()[2]) % 0.3:.6f}" if l.startswith("vt ") else l for l in text.splitlines()]
        (self.folder / "ledge/flat.obj").write_text("\n".join(lines) + "\n")
        (self.folder / "ledge/over.obj").write_text("\n".join(shrunk) + "\n")
        self.refused(lambda s: (s["objects"][0].update(mesh="over.obj"), s["atlas"].update(uvs="uv")), 3, "overlap")
        bare = [line for line in text.splitlines() if not line.startswith("vt ")]
        bare = [" ".join([p.split("/")[0] for p in line.split()]) if line.startswith("f ") else line for line in bare]
        (self.folder / "ledge/bare.obj").write_text("\n".join(bare) + "\n")
        self.refused(lambda s: (s["objects"][0].update(mesh="bare.obj"), s["atlas"].update(uvs="uv")), 3, "no UVs")
        scene = dict(self.scene, objects=[dict(self.scene["objects"][0], mesh="bare.obj")], run={"iterations": 3})
        self.write("ledge/bare.json", scene)
        result = self.run_in(["simulate", "ledge/bare.json", "-o", "unwrapped"], check=True)
        self.assertIn("unwrapped", result.stderr)


if __name__ == "__main__":
    unittest.main()
