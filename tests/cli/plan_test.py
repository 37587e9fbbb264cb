#!/usr/bin/env python3
"""A command's work as a plan: items run anywhere, in any portions, and joined, give the bytes of the command. Usage: plan_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import unittest

from command_case import CANNOT, INPUT, USAGE, CommandCase, four_per_commit, tree_of, use

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PROGRAM)
    for arguments in (["synth", "ledge", "--cells", "4", "-o", "ledge"], ["synth", "mold", "--width", "64", "--height", "48", "--steps", "2", "--lights", "3", "--scan-spacing", "3", "-o", "mold"],
                      ["simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "4", "-o", "dirty"]):
        subprocess.run([CommandCase.patinate, *arguments], cwd=CommandCase.shared, check=True, capture_output=True)


class PlanCase(CommandCase):
    def plan(self, *command, file="plan.json"):
        text = self.succeeds("cluster", "plan", *command, "--json")
        (self.folder / file).write_text(text)
        return json.loads(text)

    def tree(self):
        made = tree_of(self.folder)
        return {name: made[name] for name in made if not name.startswith("plan")}


class SameBytes(PlanCase):
    """Every command that can be planned, or a use of it that is quick. Per commit, processes of their own run four of them: tests/tools/patinate/job_plans_test.cpp
    asks all of them in one process."""
    COMMANDS = {
        "ingest": ["ingest", "capture", "--progress", "-o", "out"],
        "relit": ["ingest", "mold", "-o", "out"],
        "synth": ["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "out"],
        "transfer": ["transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "out"],
        "textures": ["export", "aged", "--num-times", "4", "-o", "out"],
        "glb": ["export", "aged", "--num-times", "3", "-o", "out.glb"],
        "lookup": ["texture", "aged", "--num-times", "4", "-o", "out_%02d.png"],
        "texture": ["texture", "aged", "--time", "3", "-o", "out.exr"],
        "render": ["render", "aged", "--num-times", "3", "--width", "60", "-o", "out_%02d.png"],
        "strip": ["render", "aged", "--num-times", "3", "--width", "60", "-o", "out.png"],
        "movie": ["export", "aged", "--num-times", "3", "-o", "out.gif"],
        "compare": ["history", "compare", "history", "history", "--num-resamples", "10", "-o", "out"],
        "evaluate": ["evaluate", "aged", "--samples", "500", "-o", "out"],
        "turntable": ["render", "aged", "--turntable", "3", "--time", "4", "--width", "60", "-o", "out.gif"],
        "control": ["control", "urn/mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "out.exr"],
        "kinds": ["control", "urn/mesh.obj", "--kind", "facing", "--kind", "height", "--resolution", "64", "-o", "out_<KIND>.exr"],
        "factorize": ["history", "factorize", "history", "--num-intervals", "8", "--num-training", "24", "-o", "out"],
        "simulate": ["simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "6", "--history-every", "2", "-o", "out"],
        "recompose": ["simulate", "restyle", "dirty", "--set", "dirt.strength=3", "-o", "out"],
        "combine": ["history", "combine", "history", "history", "-o", "out"],
        "trim": ["history", "trim", "history", "--every", "2", "-o", "out"],
        "appearance": ["history", "material", "history", "--metalness", "1", "-o", "out"],
    }

    def setUp(self):
        super().setUp()
        self.here, self.spread = self.folder / "here", self.folder / "spread"
        for folder in (self.here, self.spread):
            folder.mkdir()
            for name in ("capture", "urn", "history", "aged", "ledge", "mold", "dirty"):
                (folder / name).symlink_to(self.shared / name)

    def made(self, folder):
        return {name: content for name, content in tree_of(folder).items() if name.startswith("out")}

    def run_in(self, folder, *arguments):
        result = subprocess.run([self.patinate, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
        return result.stdout

    def test_items_one_by_one_and_joined_give_the_bytes_of_the_command(self):
        for name, command in four_per_commit(self.COMMANDS).items():
            with self.subTest(command=name):
                self.run_in(self.here, *command)
                plan = json.loads(self.run_in(self.spread, "cluster", "plan", *command, "--json"))
                (self.spread / "plan.json").write_text(json.dumps(plan))
                self.assertEqual(self.made(self.spread), {})  # A plan makes nothing.
                for item in plan["items"]:
                    self.assertLess(max([int(n) for part in item["waits_for"].split(", ") if part for n in part.split("-")], default=-1), item["number"])
                    self.run_in(self.spread, "cluster", "run", "plan.json", "--items", item["number"], "--threads", 1 + item["number"] % 2)
                self.run_in(self.spread, "cluster", "join", "plan.json")
                self.assertEqual(self.made(self.spread), self.made(self.here))
                self.assertEqual(json.loads(self.run_in(self.spread, "cluster", "run", "plan.json", "--dry-run", "--json"))["is_up_to_date"], True)
            for folder in (self.here, self.spread):
                for made in folder.glob("out*"):
                    shutil.rmtree(made) if made.is_dir() else made.unlink()

    def test_a_command_run_whole_gives_the_same_bytes_and_says_when_it_is_up_to_date(self):
        for name in four_per_commit(self.COMMANDS):
            with self.subTest(command=name):
                self.run_in(self.here, *self.COMMANDS[name])
                self.run_in(self.spread, "cluster", "run", *self.COMMANDS[name])
                self.assertEqual(self.made(self.spread), self.made(self.here))
                again = json.loads(self.run_in(self.spread, "cluster", "run", *self.COMMANDS[name], "--json"))
                self.assertEqual(again["status"], "up to date")
            for folder in (self.here, self.spread):
                for made in folder.glob("out*"):
                    shutil.rmtree(made) if made.is_dir() else made.unlink()

    def test_a_dry_run_makes_nothing(self):
        for name, command in four_per_commit(self.COMMANDS).items():
            for before in (["run"], ["plan"]):
                with self.subTest(command=name, before=before):
                    self.run_in(self.spread, *before, *command, "--dry-run")
                    self.assertEqual(self.made(self.spread), {})

    def test_two_processes_at_once_both_end_well(self):
        command = self.COMMANDS["ingest"]
        self.run_in(self.here, *command)
        both = [subprocess.Popen([self.patinate, "cluster", "run", *command], cwd=self.spread, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) for _ in range(2)]
        for process in both:
            errors = process.communicate(timeout=120)[1]
            self.assertEqual(process.returncode, 0, errors)
        self.assertEqual(self.made(self.spread), self.made(self.here))

    def test_killed_it_is_finished_by_another(self):
        command = self.COMMANDS["simulate"]
        self.run_in(self.here, *command)
        for delay in (0.05, 0.2, 0.4):
            process = subprocess.Popen([self.patinate, "cluster", "run", *command], cwd=self.spread, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            try:
                process.wait(timeout=delay)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
        self.run_in(self.spread, "cluster", "run", *command)
        self.assertEqual(self.made(self.spread), self.made(self.here))
        self.assertEqual([p.name for p in self.spread.glob(".out*")], [])


class Plans(PlanCase):
    INGEST = ["ingest", "capture", "--progress", "-o", "out"]

    def setUp(self):
        super().setUp()
        self.take("capture")

    def test_a_plan_says_what_its_items_make_and_wait_for(self):
        plan = self.plan(*self.INGEST)
        frames = [item for item in plan["items"] if item["name"].startswith("frame-")]
        self.assertEqual([frame["outputs"][0] for frame in frames], [f"frames/000{i}.exr" for i in range(4)])
        self.assertEqual(len({item["key"] for item in frames}), 4)
        self.assertEqual(len({item["name"] for item in plan["items"]}), len(plan["items"]))
        self.assertEqual(plan["command"], self.INGEST)
        self.assertIn("frames/0001.png", [given["name"] for given in plan["inputs"]])

    def test_a_movie_is_a_picture_an_item_and_a_join(self):
        command = ["export", self.shared / "aged", "--num-times", "5", "-o", "out.gif"]
        plan = self.plan(*command)
        self.assertEqual(len(plan["items"]), 5)
        self.assertIsNotNone(plan["join"])
        self.succeeds("cluster", "run", "plan.json", "--items", "3")
        self.fails(CANNOT, "4 of 5 items are not finished: 0-2, 4", "cluster", "join", "plan.json")
        again = json.loads(self.succeeds("cluster", "run", "plan.json", "--json"))
        self.assertEqual((again["run"], again["finished_before"]), (4, 1))
        self.assertGreater(again["seconds"], 0)
        self.assertGreater(again["megabytes"], 10)  # Of any process of the program.
        self.succeeds("cluster", "join", "plan.json")
        self.assertEqual([path.name for path in self.folder.glob("out.gif*")], ["out.gif"])
        before = (self.folder / "out.gif").read_bytes()
        self.succeeds("export", self.shared / "aged", "--num-times", "5", "-o", "other.gif")
        self.assertEqual((self.folder / "other.gif").read_bytes(), before)
        self.assertEqual(self.plan(*command)["is_up_to_date"], True)
        self.fails(CANNOT, "--force", "cluster", "plan", "export", self.shared / "aged", "--num-times", "4", "-o", "out.gif")

    def test_a_damaged_picture_of_a_movie_is_named_and_made_again(self):
        self.plan("export", self.shared / "aged", "--num-times", "3", "-o", "out.gif")
        self.succeeds("cluster", "run", "plan.json")
        picture = self.folder / "out.gif.items" / "00001.png"
        picture.write_bytes(picture.read_bytes()[:100])
        self.fails(CANNOT, "1 of 3 items are not finished: 1", "cluster", "join", "plan.json")
        self.succeeds("cluster", "run", "plan.json", "--items", "1")
        self.succeeds("cluster", "join", "plan.json")

    def test_several_kinds_of_control_are_an_item_each_and_need_a_name(self):
        mesh = self.shared / "urn/mesh.obj"
        both = ["control", mesh, "--kind", "facing", "--kind", "height", "--resolution", "64"]
        self.assertEqual([item["outputs"] for item in self.plan(*both, "-o", "urn_<KIND>.exr")["items"]], [["urn_facing.exr"], ["urn_height.exr"]])
        self.fails(USAGE, "for 2 kinds; expected a name with <KIND> in it", *both, "-o", "urn.exr")
        self.fails(USAGE, "`facing` is given twice", *both, "--kind", "facing", "-o", "urn_<KIND>.exr")
        self.fails(USAGE, "`!facing` has no name for <KIND>", "control", mesh, "--kind", "height", "--kind", "!facing", "-o", "urn_<KIND>.exr")
        self.succeeds(*both, "-o", "urn_<KIND>.exr")
        for kind in ("facing", "height"):
            self.succeeds("control", mesh, "--kind", kind, "--resolution", "64", "-o", f"alone_{kind}.exr")
            self.assertEqual((self.folder / f"alone_{kind}.exr").read_bytes(), (self.folder / f"urn_{kind}.exr").read_bytes())

    def test_a_dry_run_says_what_is_left_and_touches_nothing(self):
        self.plan(*self.INGEST)
        self.succeeds("cluster", "run", "plan.json", "--items", "0,2")
        before = self.tree()
        left = json.loads(self.succeeds("cluster", "run", "plan.json", "--dry-run", "--json"))
        self.assertEqual([item["number"] for item in left["items"] if item["is_finished"]], [0, 2])
        self.assertIn("2 finished; left: 1, 3", self.succeeds("cluster", "run", "plan.json", "--dry-run"))
        self.assertEqual(self.tree(), before)

    def test_a_finished_item_is_not_run_again(self):
        self.plan(*self.INGEST)
        self.succeeds("cluster", "run", "plan.json", "--items", "0-1")
        again = json.loads(self.succeeds("cluster", "run", "plan.json", "--items", "0-2", "--json"))
        self.assertEqual((again["run"], again["finished_before"]), (1, 2))

    def test_items_out_of_range_are_refused(self):
        num_items = len(self.plan(*self.INGEST)["items"])
        for items in (str(num_items), "0-99", "x", "3-1"):
            self.fails(USAGE, f"[0, {num_items - 1}]", "cluster", "run", "plan.json", "--items", items)
        self.plan("transfer", self.shared / "history", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "out")
        refused = self.run_patinate("cluster", "run", "plan.json", "--items", "0", "--quiet")
        self.assertEqual(refused.returncode, USAGE)
        self.assertEqual(refused.stderr, "patinate: error: --items: the plan has no items; `patinate cluster join` does all of its work\n")

    def test_a_join_names_the_items_that_are_missing(self):
        num_items = len(self.plan(*self.INGEST)["items"])
        self.fails(CANNOT, f"items are not finished: 0-{num_items - 1};", "cluster", "join", "plan.json")
        self.succeeds("cluster", "run", "plan.json", "--items", "1")
        self.fails(CANNOT, f"items are not finished: 0, 2-{num_items - 1};", "cluster", "join", "plan.json")
        self.plan("texture", self.shared / "aged", "--num-times", "3", "-o", "tex_%d.png")
        self.fails(CANNOT, "3 of 3 items are not finished: 0-2", "cluster", "join", "plan.json")

    def test_an_item_names_those_that_it_waits_for(self):
        plan = self.plan(*self.INGEST)
        last = plan["items"][-1]
        self.assertTrue(last["waits_for"])
        self.fails(CANNOT, f"item {last['number']} ({last['name']}) waits for items {last['waits_for']}", "cluster", "run", "plan.json", "--items", last["number"])

    def test_a_plan_for_changed_inputs_is_refused(self):
        self.plan(*self.INGEST)
        shutil.copy(self.folder / "capture/frames/0001.png", self.folder / "capture/frames/0002.png")
        for command in ("run", "join"):
            self.fails(INPUT, "plan.json: was made for other input (frames/0002.png has changed); make the plan again", command, "plan.json")
        self.fails(INPUT, "make the plan again", "cluster", "run", "plan.json", "--dry-run")

    def test_a_plan_of_another_version_is_refused(self):
        self.plan(*self.INGEST)
        self.edit_json(self.folder / "plan.json", lambda plan: plan.update(program="patinate 0.0.7"))
        self.fails(INPUT, "was made by patinate 0.0.7", "cluster", "run", "plan.json")

    def test_a_damaged_plan_is_one_line(self):
        self.plan(*self.INGEST)
        whole = (self.folder / "plan.json").read_text()
        for content in ("", "{}", whole[:len(whole) // 2], "[1]", whole.replace('"ingest"', "7", 1), whole.replace('"inputs"', '"imputs"', 1)):
            (self.folder / "plan.json").write_text(content)
            self.fails(INPUT, "plan.json", "cluster", "run", "plan.json")
        (self.folder / "plan.json").write_text(whole.replace('"ingest"', '"studio"', 1))
        self.fails(USAGE, "cannot be planned", "cluster", "run", "plan.json")

    def test_what_cannot_be_planned_is_refused(self):
        for verb in ("info", "validate", "studio", "init", "plan", "run"):
            self.fails(USAGE, f"{verb}: cannot be planned", "cluster", "plan", verb, "capture")
        self.fails(USAGE, "no such command; did you mean `ingest`?", "cluster", "plan", "ingst", "capture")

    def test_an_output_of_other_input_stays_unless_forced(self):
        self.succeeds(*self.INGEST)
        other = [*self.INGEST, "--spatial-sigma", "7"]
        self.plan(*other)
        self.fails(CANNOT, "give --force", "cluster", "run", "plan.json")
        self.plan(*other, "--force")
        self.succeeds("cluster", "run", "plan.json")
        self.succeeds("cluster", "join", "plan.json")
        self.succeeds("ingest", "capture", "--progress", "--spatial-sigma", "7", "-o", "fresh")
        self.assertEqual(tree_of(self.folder / "out"), tree_of(self.folder / "fresh"))


if __name__ == "__main__":
    unittest.main()
