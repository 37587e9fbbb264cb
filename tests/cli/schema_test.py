#!/usr/bin/env python3
"""The JSON Schemas of docs/schema accept what patinate writes and reject what its readers reject, as far as a schema can.
Usage: schema_test.py PATINATE. Needs python3-jsonschema (tools/setup --tests)."""
import copy
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import jsonschema
except ImportError:
    print("schema_test: skipped, python3-jsonschema is not installed")
    sys.exit(77)

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "docs/schema"
FILES = {"capture": "capture/capture.json", "relit": "mold/capture.json", "plate": "plate/capture.json", "history": "history/history.json", "library": "library/history.json", "transfer": "aged/transfer.json",
         "appearance": "stated.json", "sequence": "textures/sequence.json", "card": "history/card.json", "run": "aged/run.json",
         "unlight": "stereo/step.json", "unlit": "unlit/unlight.json", "calibrate": "rig.json", "calibration": "lights.json", "registration": "registered/registration.json", "relief": "receding/relief.json",
         "compare": "compared/report.json", "evaluation": "evaluated/evaluation.json", "replicates": "replicates/report.json", "explanation": "explained/explanation.json", "factorization": "factors/factorization.json", "scene": "ledge/scene.json", "simulation": "dirty/simulation.json", "fit": "fitted/report.json", "field": "fielded/report.json", "ranking": "ranked/report.json", "parameters": "ranges.json", "plan": "plan.json", "study": "study.json"}
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_schema_"))


STUDY = {"format": "patinate.study", "version": 1, "name": "all of it",
         "transfer": {"histories": ["history"], "meshes": ["urn/*.obj", {"path": "urn/mesh.obj", "name": "urn", "options": {"unit": "cm"}}], "controls": ["facing", ["facing"], {"control": "facing", "name": "up"}],
                      "options": {"resolution": [32, 64], "subpixel": False}, "seeds": [1, 2],
                      "outputs": [{"command": "render", "file": "strip.png", "options": {"num_times": 3}}, {"command": "compare", "with": "history", "name": "same"}]},
         "simulate": {"scenes": ["ledge/scene.json"], "vary": [{"pointer": "/appearance/dirt/strength", "low": 0.1, "high": 5, "scale": "log"}, {"pointer": "/tracing/lobe_exponent_float", "values": [20, 200]}],
                      "design": "latin_hypercube", "samples": 4, "design_seed": 3},
         "fit": {"scenes": ["ledge/scene.json"], "histories": ["history", "aged"], "vary": [{"pointer": "/appearance/dirt/strength", "low": 0.1, "high": 5, "scale": "log"}], "objective": {"mean_color": 1, "covered": 0.5},
                 "options": {"evaluations": 20, "population": [4, 6]}, "seeds": [1, 2]}}


# A light seen in one mirror sphere, and what the schema and the reader both refuse in it.
RIG = {"format": "patinate.calibrate", "version": 1, "kind": "spheres", "unit": "mm", "spheres": [{"radius": 20, "circle": [30, 20, 9]}],
       "camera": {"width": 64, "height": 48, "matrix": [[100, 0, 31.5], [0, 100, 23.5], [0, 0, 1]], "rotation": [0, 0, 0], "translation": [0, 0, 0]},
       "lights": [{"name": "a", "highlights": [[32, 19]]}]}


# Everything that may be said of a material, and what schema and reader refuse of it.
STATED = {"format": "patinate.appearance", "version": 1, "metalness": {"control": "thickness", "values": [[0, 1], [2, 0]]}, "roughness": [[0, 0.3], [30, 0.8]],
          "specular": 0.05, "tint": "#f0ae8c"}
BY_COLOR = {"format": "patinate.appearance", "version": 1, "materials": [{"color": [0.8, 0.5, 0.3], "metalness": 1, "roughness": 0.3, "tint": "#f0ae8c"}, {"color": "#2e5f60", "metalness": 0, "roughness": 0.9}]}


def setUpModule():
    (WORK / "stated.json").write_text(json.dumps(STATED))
    (WORK / "rig.json").write_text(json.dumps(RIG))
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "-o", "capture"],
                      ["synth", "mold", "--width", "64", "--height", "48", "--steps", "2", "--lights", "3", "--scan-spacing", "3", "--transforms", "-o", "mold"],
                      ["synth", "plate", "--size", "48", "--num-frames", "3", "--moving", "-o", "plate"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["synth", "ledge", "--cells", "4", "-o", "ledge"],
                      ["simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "4", "-o", "dirty"], ["ingest", "capture", "-o", "history"], ["history", "combine", "history", "history", "-o", "library"],
                      ["transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "aged"],
                      ["export", "aged", "--num-times", "2", "-o", "textures"], ["history", "compare", "history", "aged", "--num-resamples", "10", "-o", "compared"], *(command for seed, name in enumerate(("again", "other", "other_again"), 5) for command in
                        (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "--seed", str(seed), "-o", f"{name}_capture"], ["ingest", f"{name}_capture", "-o", name])),
                      ["history", "compare", "history", "again", "--against", "other", "other_again", "-o", "replicates"], ["evaluate", "aged", "--samples", "500", "-o", "evaluated"], ["history", "factorize", "history", "--times", "24", "-o", "factors"],
                      ["control", "explain", "aged", "urn/mesh.obj", "--resolution", "64", "--channel", "luminance", "--num-samples", "1000", "--shuffles", "199", "-o", "explained"], ["calibrate", "spheres", "rig.json", "-o", "lights.json"]):
        subprocess.run([PATINATE, *arguments], cwd=WORK, capture_output=True, check=True)
    (WORK / "history/card.json").write_text(json.dumps({"format": "patinate.card", "version": 1, "title": "Paint", "about": "It cracks.", "license": "MIT", "attribution": "Nobody", "source": "here"}))
    (WORK / "study.json").write_text(json.dumps(STUDY))
    (WORK / "plan.json").write_bytes(subprocess.run([PATINATE, "cluster", "plan", "ingest", "capture", "-o", "planned", "--json"], cwd=WORK, capture_output=True, check=True).stdout)
    (WORK / "ranges.json").write_text(json.dumps({"format": "patinate.parameters", "version": 1, "vary": [{"pointer": "/appearance/dirt/strength", "low": 0.1, "high": 5, "scale": "log"}],
                                                  "objective": {"mean_color": 1}}))
    subprocess.run([PATINATE, "simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "4", "-o", "fitted_to"], cwd=WORK, capture_output=True, check=True)
    scene = json.loads((WORK / "ledge/scene.json").read_text())
    scene["atlas"], scene["run"] = {"resolution": 64}, {"iterations": 4}
    (WORK / "ledge/short.json").write_text(json.dumps(scene))
    subprocess.run([PATINATE, "fit", "ledge/short.json", "fitted_to", "--parameters", "ranges.json", "--evaluations", "13", "--scan", "2", "--seeds", "1", "-o", "fitted"], cwd=WORK, capture_output=True, check=True)
    (WORK / "ledge/other.json").write_text(json.dumps(scene))
    subprocess.run([PATINATE, "fit", "field", "ledge/short.json", "fitted_to", "--vary", "/rules/0/rate=0.001:10:log", "--places", "equal", "--levels", "3", "--waves", "2", "-o", "fielded"], cwd=WORK, capture_output=True, check=True)
    subprocess.run([PATINATE, "simulate", "ledge/short.json", "--history-every", "1", "-o", "foretold"], cwd=WORK, capture_output=True, check=True)
    for name in ("short", "other"):
        subprocess.run([PATINATE, "fit", f"ledge/{name}.json", "foretold", "--parameters", "ranges.json", "--evaluations", "13", "--scan", "0", "--seeds", "2", "--until", "0.1", "-o", f"until_{name}"], cwd=WORK, capture_output=True, check=True)
    subprocess.run([PATINATE, "fit", "rank", "until_short", "until_other", "-o", "ranked"], cwd=WORK, capture_output=True, check=True)
    # Three photographs of the plate, as if lamps stood around it.
    (WORK / "stereo").mkdir()
    (WORK / "stereo/step.json").write_text(json.dumps({
        "format": "patinate.unlight", "version": 1, "photos": [f"../capture/frames/{i:04d}.png" for i in range(3)],
        "lights": [{"direction": d, "intensity": [3, 3, 3]} for d in ([0.6, 0, 0.8], [-0.6, 0, 0.8], [0, 0.6, 0.8])]}))
    subprocess.run([PATINATE, "unlight", "stereo/step.json", "-o", "unlit"], cwd=WORK, capture_output=True, check=True)
    shutil.copy(WORK / "urn/mesh.obj", WORK / "urn/again.obj")
    subprocess.run([PATINATE, "register", "urn/mesh.obj", "urn/again.obj", "--accept-failed", "-o", "registered"], cwd=WORK, capture_output=True, check=True)
    for name in ("before", "after"):
        points = [f"{x / 5} {y / 5} {math.sin(x / 9) + math.cos(y / 7) + (x * 7 + y * 3 + len(name)) % 11 / 100}" for y in range(60) for x in range(60)]
        (WORK / f"{name}.ply").write_text("\n".join(["ply", "format ascii 1.0", f"element vertex {len(points)}", *[f"property float {a}" for a in "xyz"], "end_header", *points]) + "\n")
    for arguments in (["register", "before.ply", "after.ply", "--unit", "mm", "-o", "plates"], ["height-change", "plates", "-o", "receding"]):
        subprocess.run([PATINATE, *arguments], cwd=WORK, capture_output=True, check=True)


def tearDownModule():
    shutil.rmtree(WORK)


def validator(name):
    schema = json.loads((SCHEMAS / f"{ {'relit': 'capture', 'plate': 'capture', 'library': 'history'}.get(name, name)}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def written(name):
    return json.loads((WORK / FILES[name]).read_text())


def put(*keys_and_value):
    *keys, last, value = keys_and_value

    def change(content):
        for key in keys:
            content = content[key]
        content[last] = value
    return change


def drop(*keys):
    def change(content):
        for key in keys[:-1]:
            content = content[key]
        del content[keys[-1]]
    return change


COMMON = [put("format", "patinate.other"), put("version", 99), put("surplus", 1), drop("format")]
BROKEN = {
    "history": COMMON + [put("width", 0), put("width", 70000), put("width", "48"), put("height", 1.5), put("origin", "found"), put("time_unit", "weeks"),
                         put("texel_size_mm", 0), put("texel_size_mm", -1), put("frames", []), put("frames", {}), put("frames", 0, "time", "now"),
                         put("frames", 0, "fiel", "x"), drop("frames", 0, "file"), put("controls", 0, "range", [1]), drop("controls", 0, "name"),
                         put("maps", {"color": "x"}), put("key", 5), drop("name"), put("mask", 3)],
    "card": COMMON + [drop("title"), drop("license"), drop("attribution"), put("title", 3), put("about", ["a"]), put("source", 5)],
    "library": [put("library", 0, "width", 0), put("library", 0, "x", -1), drop("library", 0, "key"), put("library", 0, "surplus", 1), put("library", "two")],
    "capture": COMMON + [put("kind", "moving"), put("response", "rgb"), put("response", {"gamma": 0}), put("response", {"gama": 2}), put("frames", []),
                         put("frames", {"pattern": "frames/*.png", "interval": 0}), put("frames", {"pattern": "frames/*.png", "start": 1}),
                         put("frames", "frames/*.png"), put("frames", [{"time": 1}]), put("frames", "interval", "7"), put("transmission", "align", "sometimes"),
                         drop("transmission", "photo"), put("roi", [0, 0, 10]), put("scale", 0), put("scale", 2), put("exclude", [-1]), put("exclude", [0.5]),
                         put("texel_size_mm", 0), put("appearance", {}), put("appearance", {"metalness": 2}), put("controls", [{"name": "../x", "file": "backlight.png"}]), put("time_unit", "y"), drop("name"), drop("kind"),
                         put("unit", "inch"), put("scan", {"mesh": "a.ply", "camera": "b.yml"}), put("scan", {"mesh": "a.ply"})],
    "plate": [drop("unit"), drop("plate"), drop("lights"), drop("texel_size_mm"), put("plate", {}), put("plate", "camera", [1, 2]), put("plate", "camera", [[0, 0, 9], [1, 2]]),
              put("plate", "surplus", 1), put("lights", []), put("lights", 0, "intensity", [1, 0, 1]), drop("lights", 0, "position"), put("scan", {"mesh": "a.ply", "camera": "b.yml"})],
    "relit": COMMON + [put("unit", "inch"), drop("unit"), drop("lights"), drop("steps"), put("steps", []), put("lights", []), put("lights", 0, "intensity", [1, 0, 1]),
                       drop("lights", 0, "position"), put("camera", "matrix", [[1, 0, 0]]), drop("camera", "translation"), put("reference_patch", "polygon", [[1, 1], [2, 2]]),
                       put("reference_patch", "albedo", [1, 1]), put("reference", -1), drop("steps", 0, "time"), put("steps", 0, "photos", []), put("steps", 1, "transform", [[1, 0, 0, 0]]),
                       put("steps", 0, "albedo", "a.exr"), put("steps", 0, "surplus", 1), put("frames", []), put("kind", "fixed")],
    "transfer": COMMON + [put("width", 0), put("subpixel", 1), put("mesh", "mm_per_mesh_unit", 0), drop("history", "key"), drop("coordinates"),
                          put("energy", {}), drop("energy", "used_share"), put("controls", 5), drop("key"), put("mesh", "color", "red"), put("history", 1)],
    "factorization": COMMON + [put("width", 0), put("curves", []), put("curves", 0, "noise", [0, 1, 1]), put("curves", 0, "coefficients", 0, ["a"]), put("frames", 0, "time", "now"),
                               put("frames", 0, "rmse", -1), put("maps", {}), drop("maps", "rate"), drop("history"), drop("key"), put("curves", 0, "correlation", 2)],
}


class Schemas(unittest.TestCase):
    def test_the_scenes_of_the_manual_are_scenes(self):
        check = validator("scene")
        files = [f for f in sorted((SCHEMAS.parent / "examples/scenes").rglob("*.json")) if '"patinate.scene"' in f.read_text()]
        self.assertGreater(len(files), 10)
        for file in files:
            with self.subTest(scene=file.name):
                document = json.loads(re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.MULTILINE))
                self.assertEqual([(list(e.path), e.message) for e in check.iter_errors(document)], [])

    def test_info_and_validate_know_what_is_written(self):
        for name in ("history", "library", "transfer", "unlit", "calibration", "registration", "compare", "evaluation", "replicates", "explanation", "factorization", "simulation", "fit"):
            path = WORK / FILES[name]
            for command in ("info", "validate"):
                for given in {path, path.parent if path.parent != WORK else path}:
                    with self.subTest(name=name, command=command, given=given.name):
                        said = subprocess.run([PATINATE, command, given], capture_output=True, text=True)
                        self.assertEqual((said.returncode, said.stderr), (0, ""))

    def test_what_is_written_is_accepted(self):
        for name in FILES:
            with self.subTest(schema=name):
                validator(name).validate(written(name))

    def test_what_readers_reject_is_rejected(self):
        for name, changes in BROKEN.items():
            check, file = validator(name), WORK / FILES[name]
            whole = file.read_text()
            for number, change in enumerate(changes):
                content = copy.deepcopy(written(name))
                change(content)
                with self.subTest(schema=name, change=number):
                    self.assertFalse(check.is_valid(content), "the schema accepts it")
                    file.write_text(json.dumps(content))
                    result = subprocess.run([PATINATE, "validate", file.parent], cwd=WORK, capture_output=True, text=True)
                    file.write_text(whole)
                    self.assertEqual(result.returncode, 3, f"patinate accepts it {result.stdout}")

    def test_what_studies_and_plans_reject_is_rejected(self):
        broken = {"study": COMMON + [drop("transfer", "histories"), put("transfer", "meshes", []), put("transfer", "controls", [5]), put("transfer", "options", "resolution", []), put("transfer", "options", 3),
                                     put("transfer", "seeds", [-1]), put("transfer", "seeds", []), put("transfer", "outputs", 0, "command", "ingest"), put("transfer", "outputs", 0, "surplus", 1),
                                     put("transfer", "outputs", 1, "name", "a b"), drop("simulate", "scenes"), put("simulate", "design", "random"), put("simulate", "samples", 0),
                                     put("simulate", "vary", 0, "values", [1]), put("simulate", "vary", 1, "values", []), put("simulate", "vary", 0, "pointer", "appearance"), drop("simulate", "vary", 0, "low"),
                                     drop("fit", "vary"), put("fit", "vary", []), drop("fit", "histories"), put("fit", "objective", "charm", 1), put("fit", "objective", "covered", 0), put("fit", "vary", 0, "count", 3),
                                     put("fit", "vary", 0, "scale", "cubic"), put("fit", "outputs", [])],
                  "plan": [put("format", "patinate.other"), put("version", 99), drop("format"), drop("program"), drop("key"), put("command", []), put("command", "ingest"), put("inputs", 3), drop("inputs")]}
        for name, command in (("study", ["study", "run", "broken.json", "-o", "studied"]), ("plan", ["cluster", "run", "broken.json"])):
            check = validator(name)
            for number, change in enumerate(broken[name]):
                content = copy.deepcopy(written(name))
                change(content)
                with self.subTest(schema=name, change=number):
                    self.assertFalse(check.is_valid(content), "the schema accepts it")
                    (WORK / "broken.json").write_text(json.dumps(content))
                    self.assertEqual(subprocess.run([PATINATE, *command], cwd=WORK, capture_output=True).returncode, 3)

    def test_what_appearance_rejects_is_rejected(self):
        check = validator("appearance")
        check.validate(BY_COLOR)
        changes = [(STATED, change) for change in COMMON + [put("metalness", 2), put("metalness", "values", []), put("metalness", "values", [[0, 2]]), put("metalness", {"mask": 3}), put("roughness", []),
                                                            put("roughness", [[0]]), put("tint", "copper"), put("tint", [1, 2, 3]), put("materials", BY_COLOR["materials"])]]
        changes += [(BY_COLOR, change) for change in [put("materials", []), put("materials", 0, "metalness", -1), drop("materials", 0, "roughness"), put("materials", 0, "gloss", 1), drop("materials"), put("metalness", 1)]]
        for number, (whole, change) in enumerate(changes):
            content = copy.deepcopy(whole)
            change(content)
            (WORK / "bad_appearance.json").write_text(json.dumps(content))
            with self.subTest(change=number):
                self.assertFalse(check.is_valid(content), "the schema accepts it")
                self.assertEqual(subprocess.run([PATINATE, "history", "material", "history", "bad_appearance.json", "-o", "bad"], cwd=WORK, capture_output=True).returncode, 3)
        self.assertEqual(subprocess.run([PATINATE, "history", "material", "history", "stated.json", "-o", "good"], cwd=WORK, capture_output=True).returncode, 0)

    def test_what_calibrate_rejects_is_rejected(self):
        check = validator("calibrate")
        for number, change in enumerate(COMMON + [put("unit", "inch"), put("spheres", []), put("lights", []), put("spheres", 0, "radius", 0), drop("spheres", 0, "radius"),
                                                  put("lights", 0, "highlights", [[1]]), put("camera", "width", 0), drop("camera", "matrix"), drop("lights")]):
            content = copy.deepcopy(RIG)
            change(content)
            (WORK / "bad_rig.json").write_text(json.dumps(content))
            with self.subTest(change=number):
                self.assertFalse(check.is_valid(content), "the schema accepts it")
                self.assertEqual(subprocess.run([PATINATE, "calibrate", "spheres", "bad_rig.json", "-o", "bad.json"], cwd=WORK, capture_output=True).returncode, 3)

    def test_built_in_rules_are_accepted_and_broken_ones_are_not(self):
        check = validator("rule")
        files = sorted((SCHEMAS.parents[1] / "simulation/rules/assets").glob("*.json"))
        self.assertGreater(len(files), 8)
        for file in files:
            whole = json.loads(file.read_text())
            check.validate(whole)
            for number, change in enumerate(COMMON + [put("rate", -1), put("products", {"rust": -1}), put("reactants", {"water": "all"}), put("driver", 3), drop("driver"), drop("name")]):
                content = copy.deepcopy(whole)
                change(content)
                with self.subTest(file=file.name, change=number):
                    self.assertFalse(check.is_valid(content))
    def test_what_simulate_rejects_is_rejected(self):
        check, scene = validator("scene"), json.loads((WORK / "ledge/scene.json").read_text())
        for number, change in enumerate(COMMON + [put("unit", "inch"), drop("unit"), put("materials", []), put("materials", ["a"] * 2), drop("objects"), put("objects", []), put("emitters", []),
                                                  put("emitters", 0, "shape", "cone"), put("emitters", 0, "speed", 0), put("emitters", 0, "spread_deg", 181), put("emitters", 0, "gammatons", 0),
                                                  put("emitters", 0, "carries", "water", -1), put("exchange", "ratio", 2), put("exchange", "splat", 2), put("atlas", "resolution", 8), put("atlas", "uvs", "own"),
                                                  put("behavior", {"slider": 1.5}), put("tracing", "reach", 0), put("time", "unit", "y"), put("run", "iterations", -1), put("objects", 0, "scale", 0),
                                                  put("events", [{"iteration": 1, "op": "dance"}]), put("events", [{"iteration": 1, "op": "rule", "target": "evaporation", "rate": -1}]), put("appearance", {"dirt": {"strenth": 1}}), put("gravity", [0, 1]),
                                                  put("weather", []), put("weather", [{"rain": 1}]), put("weather", [{"time": 0, "rane": 1}]), put("weather", [{"time": 0, "rain": -1}]), put("maps", {"a": {"kind": "noize"}}), put("maps", {"a": {"kind": "noise", "wavelength_mm": 0}}),
                                                  put("objects", 0, "initial", {"dirt": 5}), put("emitters", 0, "follows", "fog"), put("tracing", "bounce_normal", "own"), put("events", [{"op": "switch", "target": "rain", "on": True}])]):
            content = copy.deepcopy(scene)
            change(content)
            (WORK / "ledge/bad.json").write_text(json.dumps(content))
            with self.subTest(change=number):
                self.assertFalse(check.is_valid(content), "the schema accepts it")
                self.assertEqual(subprocess.run([PATINATE, "simulate", "ledge/bad.json", "-o", "bad"], cwd=WORK, capture_output=True).returncode, 3)

    def test_every_property_is_described_or_speaks_for_itself(self):
        for path in SCHEMAS.glob("*.schema.json"):
            schema = json.loads(path.read_text())
            for name, value in schema["properties"].items():
                self.assertTrue(value.get("description") or "const" in value or value.get("type") in ("integer", "number", "object", "array"), f"{path.name} {name}")

    @unittest.skipUnless(os.environ.get("PATINATE_DATA"), "PATINATE_DATA names no folder of real data")
    def test_drafts_of_real_projects_are_accepted(self):
        for file in sorted(pathlib.Path(os.environ["PATINATE_DATA"]).rglob("capture.json")):
            with self.subTest(file=str(file)):
                validator("capture").validate(json.loads(file.read_text()))


if __name__ == "__main__":
    unittest.main()
