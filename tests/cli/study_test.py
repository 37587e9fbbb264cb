#!/usr/bin/env python3
"""Studies: many cells from one file, here and through Snakemake, with the same bytes; what fails is shown and the rest goes on.
Usage: study_test.py PATINATE [unittest arguments]. Tests of Snakemake are skipped, saying so, where it is not installed."""
import csv
import io
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest

from command_case import CANNOT, INPUT, USAGE, CommandCase, tree_of, use
from small_scene import PLATE, PLATE_SCENE

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
SNAKEMAKE = shutil.which("snakemake")

TRANSFERS = {"histories": ["history"], "meshes": ["urn/mesh.obj", "flat.obj"], "controls": ["facing"], "options": {"resolution": 64},
             "outputs": [{"command": "render", "file": "strip.png", "options": {"num_times": 2, "width": 60}}]}
SIMULATIONS = {"scenes": ["ledge/scene.json"], "options": {"resolution": 64, "iterations": 4},
               "vary": [{"pointer": "/appearance/dirt/strength", "low": 0.5, "high": 2, "scale": "log", "count": 2}]}
FITS = {"scenes": ["plate.json"], "histories": ["rusted"], "objective": {"color_distribution": 1, "covered": 0.5},
        "vary": [{"pointer": "/rules/0/rate", "low": 0.1, "high": 20, "scale": "log"}, {"pointer": "/appearance/patina/strength", "low": 0.1, "high": 3}],
        "options": {"evaluations": 13, "appearance_evaluations": 3, "scan": 1, "seeds": 1}, "seeds": [1, 2]}
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
TWO_TILES = "v 0 0 0\nv 1 0 0\nv 2 0 0.5\nv 2 1 0.5\nv 1 1 0\nv 0 1 0\nvt 0.05 0.05\nvt 0.95 0.05\nvt 0.95 0.95\nvt 0.05 0.95\nvt 1.05 0.05\nvt 1.95 0.05\nvt 1.95 0.95\nvt 1.05 0.95\nf 1/1 2/2 5/3 6/4\nf 2/5 3/6 4/7 5/8\n"


def setUpModule():
    use(PROGRAM)
    shared = CommandCase.shared
    (shared / "plate.obj").write_text(PLATE)
    scene = {**PLATE_SCENE, "run": {"iterations": 8, "history_every": 4}}
    (shared / "plate.json").write_text(json.dumps(scene))
    (shared / "truth.json").write_text(json.dumps({**scene, "rules": [{"name": "patina", "rate": 2.0}, scene["rules"][1]]}))
    for arguments in (["synth", "ledge", "--cells", "4", "-o", "ledge"], ["simulate", "truth.json", "-o", "rusted"]):
        subprocess.run([CommandCase.patinate, *arguments], cwd=shared, check=True, capture_output=True)


class StudyCase(CommandCase):
    def setUp(self):
        super().setUp()
        if not self.has_module:
            self.skipTest("this build has no Python module")
        for name in ("history", "urn", "ledge", "rusted", "plate.obj", "plate.json"):
            (self.folder / name).symlink_to(self.shared / name)
        (self.folder / "flat.obj").write_text(SQUARE)

    def study(self, file="study.json", **parts):
        (self.folder / file).write_text(json.dumps({"format": "patinate.study", "version": 1, **parts}))
        return file

    def cells(self, folder="out"):
        parts = json.loads((self.folder / folder / "cells.json").read_text())["parts"]
        return {cell["name"]: cell for part in parts for cell in part["cells"]}

    def report(self, folder="out"):
        return {cell["cell"]: cell for cell in json.loads((self.folder / folder / "report.json").read_text())["cells"]}

    def results(self, folder):
        """What a study has made and says about it, without how it was run."""
        return {name: content for name, content in tree_of(self.folder / folder).items() if name.split("/")[0] in ("cells", "cells.json", "report.html", "report.json", "transfer.csv", "simulate.csv", "fit.csv", "done")}


class Cells(StudyCase):
    def plan_of(self, **parts):
        self.study(**parts)
        self.succeeds("study", "export", "study.json", "--snakemake", "out")
        return self.cells()

    def test_every_combination_is_a_cell_once(self):
        transfers = {**TRANSFERS, "controls": ["facing", {"control": ["accessibility"], "name": "deep"}], "options": {"resolution": [32, 64], "neighborhood": 2}, "seeds": [1, 2, 3]}
        cells = self.plan_of(transfer=transfers)
        self.assertEqual(len(cells), 2 * 2 * 2 * 3)
        self.assertEqual(len({json.dumps(cell["factors"]) for cell in cells.values()}), len(cells))
        one = cells["history-mesh-deep-resolution32-seed2"]
        self.assertEqual(one["factors"], {"history": "history", "mesh": "mesh", "control": "accessibility", "resolution": "32", "seed": "2"})
        self.assertEqual(one["commands"]["transfer"], "transfer ../history ../urn/mesh.obj --control accessibility --resolution 32 --neighborhood 2 --seed 2 -o cells/history-mesh-deep-resolution32-seed2/transfer")

    def test_a_pattern_stands_for_all_files_that_match(self):
        (self.folder / "meshes").mkdir()
        for name in ("b10", "b2", "b1"):
            (self.folder / f"meshes/{name}.obj").write_text(SQUARE)
        cells = self.plan_of(transfer={**TRANSFERS, "meshes": ["meshes/*.obj"]})
        self.assertEqual([cell["factors"]["mesh"] for cell in cells.values()], ["b1", "b2", "b10"])

    def test_a_map_beside_the_study_is_a_control(self):
        self.succeeds("control", "urn/mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "up.exr")
        cells = self.plan_of(transfer={**TRANSFERS, "meshes": ["urn/mesh.obj"], "controls": ["thickness=up.exr:2"]})
        self.assertIn("--control thickness=../up.exr:2", cells["history-mesh-thickness_up.exr_2"]["commands"]["transfer"])
        self.succeeds("study", "run", "study.json", "-o", "out")

    def test_a_latin_hypercube_has_each_slice_of_each_number_once(self):
        vary = [{"pointer": "/appearance/dirt/strength", "low": 0, "high": 10}, {"pointer": "/tracing/lobe_exponent_float", "low": 10, "high": 1000, "scale": "log"}]
        cells = self.plan_of(simulate={**SIMULATIONS, "vary": vary, "design": "latin_hypercube", "samples": 10})
        self.assertEqual(len(cells), 10)
        strengths = sorted(float(cell["factors"]["/appearance/dirt/strength"]) for cell in cells.values())
        self.assertEqual([int(s) for s in strengths], list(range(10)))
        scene = json.loads((self.folder / "out/cells/scene-sample0003/scene.json").read_text())
        self.assertEqual(str(scene["appearance"]["dirt"]["strength"]), cells["scene-sample0003"]["factors"]["/appearance/dirt/strength"])

    def test_lists_go_side_by_side(self):
        vary = [{"pointer": "/appearance/dirt/strength", "values": [1, 2, 3]}, {"pointer": "/tracing/lobe_exponent_float", "values": [10, 20, 30]}]
        cells = self.plan_of(simulate={**SIMULATIONS, "vary": vary, "design": "list"})
        self.assertEqual([list(cell["factors"].values())[1:] for cell in cells.values()], [["1", "10"], ["2", "20"], ["3", "30"]])

    def test_a_grid_of_whole_numbers_has_no_number_twice(self):
        vary = [{"pointer": "/emitters/0/gammatons", "low": 100, "high": 102, "count": 9}]
        cells = self.plan_of(simulate={**SIMULATIONS, "vary": vary})
        self.assertEqual([cell["factors"]["/emitters/0/gammatons"] for cell in cells.values()], ["100", "101", "102"])


class Run(StudyCase):
    def test_cells_give_the_bytes_of_their_commands_given_by_hand(self):
        self.study(transfer=TRANSFERS, simulate=SIMULATIONS)
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.assertEqual({cell["status"] for cell in self.report().values()}, {"done"})
        shutil.copytree(self.folder / "out/cells", self.folder / "by_hand/cells", ignore=lambda folder, names: [n for n in names if n != "scene.json" and n not in self.cells()])
        for cell in self.report().values():
            for command in cell["commands"].values():
                subprocess.run([self.patinate, *command.split()[1:]], cwd=self.folder / "by_hand", check=True, capture_output=True)
        self.assertEqual(tree_of(self.folder / "by_hand/cells"), tree_of(self.folder / "out/cells"))

    def test_a_second_run_makes_nothing_again_and_the_number_of_jobs_changes_no_byte(self):
        self.study(transfer=TRANSFERS)
        self.succeeds("study", "run", "study.json", "-o", "out")
        places = {p: p.stat().st_ino for p in (self.folder / "out/cells").rglob("*")}
        first = self.results("out")
        self.succeeds("study", "run", "study.json", "-o", "out", "--jobs", "1")
        self.assertEqual({p: p.stat().st_ino for p in (self.folder / "out/cells").rglob("*")}, places)
        self.succeeds("study", "run", "study.json", "-o", "other", "--jobs", "3")
        self.assertEqual(self.results("out"), first)
        self.assertEqual(self.results("other"), first)

    def test_a_cell_that_fails_is_shown_and_the_rest_goes_on(self):
        (self.folder / "broken.obj").write_text("v 0 0 0\n")
        self.study(transfer={**TRANSFERS, "meshes": ["broken.obj", "flat.obj"]})
        result = self.run_patinate("study", "run", "study.json", "-o", "out", "--quiet")
        self.assertEqual(result.returncode, CANNOT)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("history-broken-facing: transfer: ../broken.obj", result.stderr)
        report = self.report()
        self.assertEqual({name: cell["status"] for name, cell in report.items()}, {"history-broken-facing": "failed", "history-flat-facing": "done"})
        self.assertIn(report["history-broken-facing"]["message"], result.stderr)
        self.assertIn("../broken.obj", (self.folder / "out/report.html").read_text())
        # Mended, only what was missing is made.
        place = (self.folder / "out/cells/history-flat-facing/transfer").stat().st_ino
        shutil.copy(self.folder / "flat.obj", self.folder / "broken.obj")
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.assertEqual({cell["status"] for cell in self.report().values()}, {"done"})
        self.assertEqual((self.folder / "out/cells/history-flat-facing/transfer").stat().st_ino, place)

    def test_the_tables_hold_what_the_manifests_say(self):
        transfers = {**TRANSFERS, "outputs": [{"command": "evaluate", "options": {"samples": 500}}]}
        self.study(transfer=transfers, simulate=SIMULATIONS)
        self.succeeds("study", "run", "study.json", "-o", "out")
        rows = list(csv.DictReader(io.StringIO((self.folder / "out/transfer.csv").read_text())))
        self.assertEqual(len(rows), 2)
        for row in rows:
            manifest = json.loads((self.folder / f"out/cells/{row['cell']}/transfer/transfer.json").read_text())
            self.assertEqual(float(row["transfer: energy"]), manifest["energy"]["energy"])
            evaluation = json.loads((self.folder / f"out/cells/{row['cell']}/evaluate/evaluation.json").read_text())
            for figure in evaluation["maps"][0]["figures"]:
                if figure["value"] is not None:
                    self.assertEqual(float(row[f"transfer_evaluate: {figure['name']}"]), figure["value"])
        for row in csv.DictReader(io.StringIO((self.folder / "out/simulate.csv").read_text())):
            ledger = json.loads((self.folder / f"out/cells/{row['cell']}/simulation/simulation.json").read_text())["ledger"]
            self.assertEqual(float(row["simulate: water emitted"]), ledger["water"]["emitted"])

    def test_a_fit_is_the_bytes_of_its_command_and_the_table_holds_what_it_found(self):
        self.study(fit=FITS)
        self.succeeds("study", "run", "study.json", "-o", "out")
        rows = list(csv.DictReader(io.StringIO((self.folder / "out/fit.csv").read_text())))
        self.assertEqual([row["cell"] for row in rows], ["plate-rusted-seed1", "plate-rusted-seed2"])
        for row in rows:
            made = self.folder / "out/cells" / row["cell"] / "fit"
            report = json.loads((made / "report.json").read_text())
            self.assertEqual(float(row["fit: objective after"]), report["objective"]["after"])
            self.assertEqual(float(row["fit: /rules/0/rate"]), report["parameters"][0]["best"])
            self.assertEqual([float(row[f"fit: /rules/0/rate {end}"]) for end in ("at least", "at most")], report["parameters"][0]["interval"])
        command = self.cells()["plate-rusted-seed2"]["commands"]["fit"].split()
        subprocess.run([self.patinate, *command[:-1], "by_hand"], cwd=self.folder / "out", check=True, capture_output=True)
        alone, made = tree_of(self.folder / "out/by_hand"), tree_of(self.folder / "out/cells/plate-rusted-seed2/fit")
        self.assertEqual([name for name in made if made[name] != alone.get(name) and name not in ("job.json", "scene.json")], [])  # Whose paths are relative to it.

    def test_a_dry_run_says_what_is_left(self):
        self.study(transfer=TRANSFERS)
        before = sorted(self.folder.rglob("*"))
        self.assertIn("4 of 4 steps are left", self.succeeds("study", "run", "study.json", "-o", "out", "--dry-run"))
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.assertEqual(json.loads(self.succeeds("study", "run", "study.json", "-o", "out", "--dry-run", "--json"))["left"], [])
        # A result that was removed is left to do for all that tell, and is made again.
        made = next(p for p in (self.folder / "out/cells").glob("*/*") if p.name != "scene.json")
        shutil.rmtree(made) if made.is_dir() else made.unlink()
        self.assertEqual(len(json.loads(self.succeeds("study", "run", "study.json", "-o", "out", "--dry-run", "--json"))["left"]), 1)
        self.assertEqual(json.loads(self.succeeds("study", "report", "out", "--json"))["not_run"], 1)
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.assertTrue(made.exists())


class BadStudies(StudyCase):
    def problems(self, expected, **parts):
        """Every line of what is said names one of `expected`, and nothing is made."""
        self.study(**parts)
        before = sorted(self.folder.rglob("*"))
        result = self.run_patinate("study", "run", "study.json", "-o", "out")
        self.assertEqual(result.returncode, INPUT, result.stderr)
        lines = result.stderr.splitlines()
        for line, words in zip(lines, expected):
            self.assertTrue(line.startswith("patinate: error: study.json"), line)
            self.assertIn(words, line)
        self.assertEqual(len(lines), len(expected), result.stderr)
        self.assertEqual(sorted(self.folder.rglob("*")), before)

    def test_all_that_is_missing_is_said_at_once(self):
        self.problems(["/transfer/histories/0: ", "/transfer/meshes/1: ", "/transfer/controls/0: control `faicng`: position 1", "/transfer/options/resolutoin: `transfer` has no option `resolutoin`; did you mean `resolution`?", "/transfer/outputs/0: `file` is missing"],
                      transfer={**TRANSFERS, "histories": ["hstory"], "meshes": ["flat.obj", "nowhere.obj"], "controls": ["faicng"], "options": {"resolutoin": 3}, "outputs": [{"command": "render"}]})

    def test_every_wrong_line_of_a_file_is_said_in_one_run(self):
        def output(**members):
            return {"command": "render", "file": "a.png", **members}
        # Wrong types, members that are missing, unknown or in excess, in every part at once.
        self.problems(["study.json: /name: ", "/transfer/meshes/0/name: ", "/transfer/meshes/0/options/resolutoin: ", "/transfer/meshes/1: ", "/transfer/controls/0/0: ", "/transfer/controls/0/1: ", "/transfer/options/neighborhood/0: ",
                       "/transfer/options/neighborhood/2: ", "/transfer/seeds/1: ", "/transfer/outputs/0/name: ", "/transfer/outputs/0: `file` is missing", "/transfer/outputs/0/options/width: ", "/transfer/outputs/1/command: ",
                       "/transfer/ouputs: unknown key; did you mean `outputs`?; also unknown: `sceds`; did you mean `seeds`?"],
                      name=7,
                      transfer={**TRANSFERS, "meshes": [{"path": "flat.obj", "name": 3, "options": {"resolutoin": 3}}, 5], "controls": [[1, 2]], "options": {"neighborhood": [{}, 2, 99]}, "seeds": [1, "x"],
                                "outputs": [{"command": "render", "name": "a b", "options": {"width": -1}}, output(command="rendr")], "ouputs": [], "sceds": []})
        self.problems(["/transfer/histories/0: ", "/simulate/design: ", "/simulate/samples: ", "/simulate/vary/0/low: ", "/appearance/dirt/strenth is not in", "/rules/9/rate is not in",
                       "/fit/objective/covered: ", "/fit/objective/coverd: ", "/rules/0/rat is not in", "/rules/0/raet is not in"],
                      transfer={**TRANSFERS, "histories": ["hstory"]},
                      simulate={**SIMULATIONS, "design": "grd", "samples": 0,
                                "vary": [{"pointer": "/tracing/lobe_exponent_float", "low": "a", "high": 2, "count": 2}, {"pointer": "/appearance/dirt/strenth", "low": 1, "high": 2, "count": 2}, {"pointer": "/rules/9/rate", "low": 1, "high": 2, "count": 2}]},
                      fit={**FITS, "objective": {"covered": -1, "coverd": 1}, "vary": [{"pointer": "/rules/0/rat", "low": 1, "high": 2}, {"pointer": "/rules/0/raet", "low": 1, "high": 2}]})

    def test_a_control_that_a_history_lacks_is_said_before_anything_runs(self):
        self.problems(["/transfer/controls/0: ", "/transfer/controls/2/control: "],
                      transfer={**TRANSFERS, "controls": ["thikness=facing", "thickness=facing", {"control": ["thickness=facing", "wetness=height"], "name": "two"}]})
        result = self.run_patinate("study", "run", "study.json", "-o", "out")
        self.assertIn("thikness", result.stderr)
        self.assertIn("did you mean `thickness`?", result.stderr)

    def test_two_cells_in_one_place_are_refused(self):
        self.problems(["flat.obj is there twice: say it once, or give one another `name`"], transfer={**TRANSFERS, "meshes": ["flat.obj", "./flat.obj"]})
        self.problems(["flat.obj and urn/mesh.obj would both be `flat`"], transfer={**TRANSFERS, "meshes": ["flat.obj", {"path": "urn/mesh.obj", "name": "flat"}]})

    def test_a_value_that_is_there_twice_is_one_line_however_many_cells_have_it(self):
        self.problems(["/transfer: `seed1` is there twice"], transfer={**TRANSFERS, "controls": ["facing", "height"], "seeds": [1, 2, 1]})

    def test_wrong_values_of_options_are_said_before_anything_runs(self):
        self.problems(["/transfer/options/neighborhood/1: --neighborhood: found `99`; expected an integer [0, 5]", "/transfer/options/quality: --quality: found `goood`; expected one of draft, good, best; did you mean `good`?",
                       "/transfer/outputs/0/options/width: --width: found `-1`"],
                      transfer={**TRANSFERS, "options": {"neighborhood": [2, 99], "quality": "goood"}, "outputs": [{"command": "render", "file": "a.png", "options": {"width": -1}}]})

    def test_options_that_do_not_go_together_are_said_before_anything_runs(self):
        self.problems(["/transfer/options: --device: --method reference runs on the CPU", "/transfer/outputs/0: -o: found `a.bmp`; expected a name that ends in .png", "/transfer/outputs/1: --num-times: found `0`; expected an integer [1, 10000]",
                       "/transfer/outputs/2: -o: found `b.png` for 3 times; expected a name with a number in it", "/transfer/outputs/3: -o: found `c.bmp`; expected MODEL.glb", "/transfer/outputs/4: -o: found `judged.csv`, the name of a file",
                       "/transfer/outputs/5: --num-blocks: found 1", "/transfer/outputs/6: --views: found `font`"],
                      transfer={**TRANSFERS, "options": {"method": "reference", "device": "opencl"},
                                "outputs": [{"command": "render", "file": "a.bmp"}, {"command": "render", "file": "a.png", "name": "b", "options": {"num_times": 0}}, {"command": "lookup", "file": "b.png", "options": {"num_times": 3}},
                                            {"command": "export", "file": "c.bmp"}, {"command": "evaluate", "file": "judged.csv"}, {"command": "compare", "with": "history", "options": {"num_blocks": 1}},
                                            {"command": "render", "name": "c", "file": "d.png", "options": {"views": "font", "time": 1}}]})
        self.problems(["/simulate/options: --resolution: found `7`; expected 0 or [16, 16384]"], simulate={**SIMULATIONS, "options": {"resolution": [64, 7]}})
        self.problems(["/simulate/options/replicates: `replicates` is not for studies; each of `seeds` is a cell"], simulate={**SIMULATIONS, "options": {"replicates": 3}})

    def test_what_a_fit_cannot_vary_is_said_before_anything_runs(self):
        self.problems(["/fit/histories/0: ", "/fit/objective/coverd: objective: found `coverd`", "/fit/options/evaluatoins: `fit` has no option `evaluatoins`; did you mean `evaluations`?"],
                      fit={**FITS, "histories": ["rust"], "objective": {"coverd": 1}, "options": {"evaluatoins": 3}})
        self.problems(["/fit/vary/0: /rules/0/rat is not in plate.json"], fit={**FITS, "vary": [{"pointer": "/rules/0/rat", "low": 1, "high": 2}]})
        self.problems(["/fit: --evaluations: found 5; expected at least 13"], fit={**FITS, "options": {"evaluations": [5, 13]}})
        self.problems(["/fit/vary: plate.json: /appearance/patina/strength: starts at 0.5, outside 1 to 2"], fit={**FITS, "vary": [{"pointer": "/appearance/patina/strength", "low": 1, "high": 2}]})

    def test_a_pattern_in_a_folder_that_is_not_there_says_where_it_stands(self):
        self.problems(["/transfer/meshes/0: `meshes/*.obj`: there is no folder "], transfer={**TRANSFERS, "meshes": ["meshes/*.obj", "flat.obj"]})

    def test_two_steps_of_one_name_or_file_are_refused(self):
        render = TRANSFERS["outputs"][0]
        self.problems(["two steps are called `render`", "two steps make `strip.png`"], transfer={**TRANSFERS, "outputs": [render, render]})

    def test_a_study_that_needs_what_it_makes_is_refused(self):
        self.study(transfer=TRANSFERS)
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.study(transfer={**TRANSFERS, "histories": ["out/cells/history-flat-facing/transfer"]})
        result = self.run_patinate("study", "run", "study.json", "-o", "out")
        self.assertEqual(result.returncode, INPUT)
        self.assertIn("would wait for itself", result.stderr)

    def test_numbers_that_no_scene_has_are_refused(self):
        self.problems(["/appearance/dirt/strenth is not in ledge/scene.json"], simulate={**SIMULATIONS, "vary": [{"pointer": "/appearance/dirt/strenth", "low": 1, "high": 2, "count": 2}]})
        self.problems(["a grid needs a `count`, or `values`"], simulate={**SIMULATIONS, "vary": [{"pointer": "/appearance/dirt/strength", "low": 1, "high": 2}]})
        self.problems(["a Latin hypercube needs `samples`"], simulate={**SIMULATIONS, "design": "latin_hypercube"})
        self.problems(["a list needs `values` everywhere"], simulate={**SIMULATIONS, "design": "list"})

    def test_empty_and_foreign_files_are_one_line(self):
        self.problems(["holds neither `transfer` nor `simulate` nor `fit`"])
        for content in ("", "[]", "{}", '{"format": "patinate.scene"}'):
            (self.folder / "study.json").write_text(content)
            self.fails(INPUT, "study.json", "study", "run", "study.json", "-o", "out")

    def test_a_folder_of_other_things_is_left_alone(self):
        self.study(transfer=TRANSFERS)
        (self.folder / "photos").mkdir()
        (self.folder / "photos/a.jpg").write_text("precious")
        self.fails(CANNOT, "is no study's folder", "study", "run", "study.json", "-o", "photos")
        self.fails(INPUT, "is no study's folder", "study", "report", "photos")
        self.fails(USAGE, "--snakemake", "study", "export", "study.json")


    def test_slurm_profiles_of_both_snakemakes_say_the_same(self):
        self.study(transfer=TRANSFERS)
        self.succeeds("study", "export", "study.json", "--snakemake", "out")
        old, new = ({line.split(":", 1)[0]: line.split(":", 1)[1] for line in (self.folder / "out/profiles/slurm" / name).read_text().splitlines() if re.match(r"[a-z-]+:", line)}
                    for name in ("config.yaml", "config.v8+.yaml"))
        self.assertEqual(new.pop("executor").strip(), "cluster-generic")
        self.assertEqual((old.pop("max-jobs-per-second"), new.pop("max-jobs-per-timespan")), (" 20", " 20/1s"))
        for before, now in (("cluster", "submit-cmd"), ("cluster-status", "status-cmd"), ("cluster-cancel", "cancel-cmd")):
            self.assertEqual(old.pop(before), new.pop(f"cluster-generic-{now}"))
        self.assertEqual(old, new)


@unittest.skipUnless(SNAKEMAKE, "snakemake is not installed (Debian's snakemake)")
class Snakemake(StudyCase):
    def environment(self):
        return {**os.environ, "PATH": f"{pathlib.Path(self.patinate).parent}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(self.folder / "cache"), "HOME": str(self.folder)}

    def snakemake(self, *arguments):
        return subprocess.run([SNAKEMAKE, "--profile", "profiles/local", *arguments], cwd=self.folder / "out", env=self.environment(), capture_output=True, text=True, timeout=600)

    def test_it_makes_the_bytes_of_the_local_run_and_does_nothing_twice(self):
        self.study(transfer=TRANSFERS, simulate=SIMULATIONS)
        self.succeeds("study", "export", "study.json", "--snakemake", "out")
        result = self.snakemake()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.succeeds("study", "run", "study.json", "-o", "here")
        self.assertEqual(self.results("out"), self.results("here"))
        self.assertIn("Nothing to be done", self.snakemake().stderr)
        made = next(p for p in (self.folder / "out/cells").glob("*/*") if p.name != "scene.json")
        shutil.rmtree(made) if made.is_dir() else made.unlink()
        self.assertEqual(self.snakemake().returncode, 0)
        self.assertTrue(made.exists())
        # Nor when both take turns.
        self.succeeds("study", "run", "study.json", "-o", "out")
        self.assertEqual(self.results("out"), self.results("here"))

    def test_fits_go_generation_by_generation_and_resume_after_the_head_dies_with_the_same_bytes(self):
        self.study(fit=FITS)
        self.succeeds("study", "run", "study.json", "-o", "here")
        for cores, portion in ((1, 3), (3, 1)):
            with self.subTest(cores=cores):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                self.succeeds("study", "export", "study.json", "--snakemake", "out")
                wanted = ("--cores", str(cores), "--config", f"items={portion}")
                self.kill_after_first_generation(*wanted)
                finished = [p for p in (self.folder / "out/cells").glob("*/fit.items/*/evaluations/*.json") if ".tmp" not in str(p)]
                kept = {p.parts[-5] + p.name: p.stat().st_ino for p in finished}
                self.assertGreater(len(kept), 3)
                self.assertEqual(self.snakemake("--unlock").returncode, 0)
                result = self.snakemake(*wanted)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(self.results("out"), self.results("here"))
                made = {p.parts[-4] + p.name: p.stat().st_ino for p in (self.folder / "out/cells").glob("*/fit/evaluations/*.json")}
                self.assertEqual({name: made[name] for name in kept}, kept)  # What was finished was not made again.
                self.assertIn("Nothing to be done", self.snakemake(*wanted).stderr)

    def kill_after_first_generation(self, *arguments):
        """Snakemake is killed, and so are the steps that it has begun."""
        process = subprocess.Popen([SNAKEMAKE, "--profile", "profiles/local", *arguments], cwd=self.folder / "out", env=self.environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        end = time.monotonic() + 300
        while not list((self.folder / "out/items/fit").glob("*/wave1")) and time.monotonic() < end and process.poll() is None:
            time.sleep(0.02)
        self.assertIsNone(process.poll(), "ended before it was killed")
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def test_a_fit_that_cannot_be_planned_is_said_by_the_export(self):
        (self.folder / "broken").mkdir()
        (self.folder / "broken/history.json").write_text("{")
        self.study(fit={**FITS, "histories": ["rusted", "broken"]})
        result = self.run_patinate("study", "export", "study.json", "--snakemake", "out")
        self.assertEqual(result.returncode, INPUT)
        lines = result.stderr.splitlines()
        self.assertEqual([line.split(": ")[2:4] for line in lines], [[f"plate-broken-seed{seed}", "fit"] for seed in (1, 2)], result.stderr)
        self.assertIn("broken/history.json", lines[0])

    def test_what_fails_is_on_the_page_and_the_rest_goes_on(self):
        (self.folder / "broken.obj").write_text("v 0 0 0\n")
        self.study(transfer={**TRANSFERS, "meshes": ["broken.obj", "flat.obj"]})
        self.succeeds("study", "export", "study.json", "--snakemake", "out")
        self.assertNotEqual(self.snakemake().returncode, 0)
        self.run_patinate("study", "run", "study.json", "-o", "here")
        self.assertEqual(self.report("out"), self.report("here"))
        self.assertEqual({cell["status"] for cell in self.report("out").values()}, {"failed", "done"})


if __name__ == "__main__":
    unittest.main()
