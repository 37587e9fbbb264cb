#!/usr/bin/env python3
"""What a command may replace and what it may believe: no input, nothing of others, no damaged output, no input that changes. Usage: overwrite_test.py PATINATE [unittest arguments]"""
import glob
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest

from command_case import CANNOT, INPUT, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"

TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MINE = b"written by a person\n"


def setUpModule():
    use(PATINATE)


class Inputs(CommandCase):
    """A control of a mesh without UVs also writes the mesh with the UVs that were made, under the name of the map."""

    def refuses(self, mesh, *arguments):
        before = mesh.read_bytes()
        for force in ([], ["--force"]):
            with self.subTest(arguments=arguments, force=force):
                self.assertIn("would be replaced", self.fails(USAGE, mesh.name, "control", *arguments, "--resolution", "64", *force))
                self.assertEqual(mesh.read_bytes(), before)

    def test_what_is_written_beside_an_output_never_replaces_an_input(self):
        mesh = self.folder / "bust.obj"
        mesh.write_text(TETRAHEDRON)
        self.refuses(mesh, "bust.obj", "--kind", "facing", "-o", "bust.exr")
        (self.folder / "sub").mkdir()
        self.refuses(mesh, "./sub/../bust.obj", "--kind", "facing", "-o", "bust.exr")
        (self.folder / "link.obj").symlink_to("bust.obj")
        self.refuses(mesh, "link.obj", "--kind", "facing", "-o", "bust.exr")

    def test_of_several_maps_neither(self):
        mesh = self.folder / "bust_height.obj"
        mesh.write_text(TETRAHEDRON)
        self.refuses(mesh, "bust_height.obj", "--kind", "facing", "--kind", "height", "-o", "bust_<KIND>.exr")

    def test_a_hard_link_is_the_same_file(self):
        mesh = self.folder / "bust.obj"
        mesh.write_text(TETRAHEDRON)
        os.link(mesh, self.folder / "map.obj")
        result = self.run_patinate("control", "bust.obj", "--kind", "facing", "-o", "map.exr", "--resolution", "64", "--force")
        self.assertEqual(result.returncode, USAGE, result.stderr)
        self.assertEqual(mesh.read_text(), TETRAHEDRON)

    def test_a_file_that_an_option_writes_is_an_output_as_well(self):
        self.take("history")
        (self.folder / "a.csv").write_bytes(MINE)
        self.fails(CANNOT, "a.csv", "info", "history", "--curves", "a.csv")
        self.fails(USAGE, "a finished result", "info", "history", "--curves", "history/frames/a.csv", "--force")


class FilesOfOthers(CommandCase):
    def keeps(self, name, *command):
        """The command refuses while a file of that name is there, writes nothing, and replaces it with --force."""
        with self.subTest(command=command, file=name):
            (self.folder / name).write_bytes(MINE)
            self.fails(CANNOT, name, *command)
            self.assertEqual((self.folder / name).read_bytes(), MINE)
            self.succeeds(*command, "--force")
            self.assertNotEqual((self.folder / name).read_bytes(), MINE)

    def test_every_file_of_a_model_is_looked_at_before_anything_is_written(self):
        export = ["export", self.shared / "aged", "-o"]
        for model, beside in {"b.obj": ["b.mtl", "b.obj.mtlx"], "c.usda": ["c.mtlx"]}.items():
            for name in beside:
                self.keeps(name, *export, model)
                for file in list(self.folder.iterdir()):
                    shutil.rmtree(file) if file.is_dir() else file.unlink()

    def test_a_texture_of_others_stays(self):
        (self.folder / "c.textures").mkdir()
        (self.folder / "c.textures/color.0000.png").write_bytes(MINE)
        self.fails(CANNOT, "c.textures", "export", self.shared / "aged", "-o", "c.usda")

    def test_the_hints_of_a_draft(self):
        shutil.copytree(self.shared / "capture/frames", self.folder / "photos")
        self.keeps("photos/capture.hints.txt", "init", "photos")
        self.assertIn("up to date", self.run_patinate("init", "photos").stderr)

    def test_a_model_that_was_interrupted_between_its_files_goes_on(self):
        self.succeeds("export", self.shared / "aged", "-o", "a.usda")
        whole = tree_of(self.folder)
        for name in ("a.usda", "a.mtlx"):
            (self.folder / name).unlink()
            self.succeeds("export", self.shared / "aged", "-o", "a.usda")
            self.assertEqual(tree_of(self.folder), whole)

    def test_a_stage_and_a_glb_of_one_name_stand_side_by_side(self):
        for first, second in (("a.usda", "a.glb"), ("a.glb", "a.usda"), ("a.obj", "a.glb")):
            with self.subTest(first=first):
                self.succeeds("export", self.shared / "aged", "-o", first)
                self.succeeds("export", self.shared / "aged", "-o", second)
                self.succeeds("export", self.shared / "aged", "-o", second, "--force")
                self.assertIn("up to date", self.run_patinate("export", self.shared / "aged", "-o", first).stderr)


class Damage(CommandCase):
    """A finished output counts when all its files are there and as long as they were."""

    def test_a_lost_file_of_a_folder_is_made_again(self):
        commands = {"ingest": ["ingest", self.shared / "capture", "-o", "out"], "export": ["export", self.shared / "aged", "--num-times", "3", "-o", "out"],
                    "transfer": ["transfer", self.shared / "history", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "out"]}
        for name, command in commands.items():
            self.succeeds(*command)
            whole = tree_of(self.folder / "out")
            for file in whole:
                if file == "job.json":
                    continue
                with self.subTest(command=name, file=file):
                    (self.folder / "out" / file).unlink()
                    self.assertIn(f"{file} is lost", self.succeeds(*command, "--dry-run"))
                    self.succeeds(*command)
                    self.assertEqual(tree_of(self.folder / "out"), whole)
            shutil.rmtree(self.folder / "out")

    def test_without_a_record_what_items_made_is_looked_for(self):
        command = ["ingest", self.shared / "capture", "-o", "out"]
        self.succeeds(*command)
        whole = tree_of(self.folder / "out")
        (self.folder / "out/job.json").unlink()
        (self.folder / "out/frames/0001.exr").unlink()
        self.succeeds(*command)
        self.assertEqual(tree_of(self.folder / "out"), whole)

    def test_a_file_of_another_size_is_named_and_force_makes_it_again(self):
        command = ["ingest", self.shared / "capture", "-o", "out"]
        self.succeeds(*command)
        whole = tree_of(self.folder / "out")
        for file, size in (("frames/0000.exr", -1), ("frames/0002.exr", 1), ("history.json", -100), ("survey.json", -10)):
            with self.subTest(file=file, size=size):
                path = self.folder / "out" / file
                os.truncate(path, path.stat().st_size + size)
                self.fails(CANNOT, file, *command)
                self.succeeds(*command, "--force")
                self.assertEqual(tree_of(self.folder / "out"), whole)

    def test_a_single_file_that_is_cut_off_is_not_up_to_date(self):
        commands = [["texture", self.shared / "aged", "--time", "1", "-o", f"a.{e}"] for e in ("png", "exr", "tif", "jpg")]
        commands += [["export", self.shared / "aged", "--num-times", "3", "-o", f"b.{e}"] for e in ("glb", "usdz", "usda", "gif", "mp4", "webm")]
        commands += [["export", self.shared / "aged", "-o", "c.obj"]]
        for command in commands:
            with self.subTest(command=command):
                file = self.folder / command[-1]
                self.succeeds(*command)
                whole = file.read_bytes()
                for size in (len(whole) - 1, len(whole) // 2):
                    os.truncate(file, size)
                    self.fails(CANNOT, "damaged", *command)
                    self.succeeds(*command, "--force")
                    self.assertEqual(file.read_bytes(), whole)

    def test_a_texture_that_was_lost_is_made_again(self):
        for model, folder in (("a.usda", "a.textures"), ("a.obj", "a.obj.textures")):
            command = ["export", self.shared / "aged", "-o", model]
            self.succeeds(*command)
            whole = tree_of(self.folder)
            next((self.folder / folder).iterdir()).unlink()
            self.assertNotIn("up to date", self.run_patinate(*command).stderr)
            self.assertEqual(tree_of(self.folder), whole)

    def test_force_makes_again_what_is_up_to_date(self):
        (self.folder / "mesh.obj").write_text(TETRAHEDRON)
        for command in (["ingest", self.shared / "capture", "-o", "h"], ["texture", self.shared / "aged", "--time", "1", "-o", "x.png"],
                        ["control", "mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "map.exr"], ["export", self.shared / "aged", "-o", "a.usda"],
                        ["texture", self.shared / "aged", "--num-times", "2", "-o", "n_%02d.png"]):
            with self.subTest(command=command):
                self.succeeds(*command)
                self.assertIn("up to date", self.run_patinate(*command).stderr)
                self.assertTrue(json.loads(self.succeeds(*command, "--force", "--dry-run", "--json"))["would"] == "replace")
                self.assertIn("done in", self.run_patinate(*command, "--force").stderr)
                self.assertIn("up to date", self.run_patinate(*command).stderr)

    def test_validate_looks_at_content(self):
        self.succeeds("ingest", self.shared / "capture", "-o", "out")
        self.succeeds("validate", "out")
        survey = self.folder / "out/survey.json"
        text = survey.read_bytes()
        survey.write_bytes(text[:-3] + b" }\n" if text.endswith(b"\n}\n") else text.replace(b"0", b"1", 1))
        self.fails(INPUT, "survey.json", "validate", "out")


class ChangingInputs(CommandCase):
    def test_a_photograph_that_is_replaced_while_it_is_read_is_named_and_nothing_is_kept(self):
        source = sorted((self.shared / "capture/frames").iterdir())
        photos = self.folder / "photos"
        photos.mkdir()
        for i in range(400):
            shutil.copy(source[i % len(source)], photos / f"{i:04d}.png")
        self.succeeds("init", "photos", "--quiet")
        for change in ("replaced", "longer", "touched"):
            with self.subTest(change=change):
                process = subprocess.Popen([self.patinate, "ingest", "photos", "-o", "out", "--threads", "1", "--quiet"], cwd=self.folder, stderr=subprocess.PIPE, text=True)
                while process.poll() is None and not (self.folder / "out.partial/.job/key").exists():
                    time.sleep(0.002)
                last = photos / "0399.png"
                if change == "replaced":
                    shutil.copy(source[0], self.folder / "new.png")
                    os.replace(self.folder / "new.png", last)
                elif change == "longer":
                    with open(last, "ab") as file:
                        file.write(b"x")
                else:
                    os.utime(last)
                stderr = process.communicate()[1]
                self.assertEqual(process.returncode, INPUT, stderr)
                self.assertEqual(len(stderr.strip().splitlines()), 1, stderr)
                self.assertIn("0399.png: was changed while it was read", stderr)
                self.assertFalse((self.folder / "out").exists())
                self.assertFalse((self.folder / "out.partial").exists())


class Studies(CommandCase):
    STUDY = {"format": "patinate.study", "version": 1, "transfer": {"histories": ["history"], "meshes": ["urn/mesh.obj"], "controls": ["facing"], "options": {"resolution": [32, 64]}}}

    def setUp(self):
        super().setUp()
        if not self.has_module:
            self.skipTest("this build has no Python module")
        for name in ("history", "urn"):
            (self.folder / name).symlink_to(self.shared / name)
        (self.folder / "study.json").write_text(json.dumps(self.STUDY))

    def test_a_study_that_ended_while_its_cells_were_made_goes_on(self):
        export = ["study", "export", "study.json", "--snakemake", "out"]

        def no_space():
            resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        result = self.run_patinate(*export, preexec_fn=no_space)
        self.assertEqual(result.returncode, CANNOT, result.stderr)
        self.succeeds(*export)
        shutil.rmtree(self.folder / "out")
        (self.folder / "out/cells/history-mesh-facing-resolution32").mkdir(parents=True)  # Killed, with the program of before.
        self.succeeds(*export)

    def test_a_folder_of_others_is_left_alone(self):
        (self.folder / "out").mkdir()
        (self.folder / "out/notes.txt").write_bytes(MINE)
        self.fails(CANNOT, "out", "study", "export", "study.json", "--snakemake", "out")


class Leftovers(CommandCase):
    def test_a_join_removes_what_killed_runs_left(self):
        command = ["cluster", "run", "ingest", self.shared / "capture", "-o", "out"]
        for delay in (0.02, 0.05, 0.1, 0.15, 0.2):
            process = subprocess.Popen([self.patinate, *map(str, command)], cwd=self.folder, stderr=subprocess.DEVNULL)
            time.sleep(delay)
            process.send_signal(signal.SIGKILL)
            process.wait()
        items = self.folder / "out.items"
        items.mkdir(exist_ok=True)
        if not any(p.name.startswith(".work.tmp") for p in items.iterdir()) and not (self.folder / "out").exists():
            process = subprocess.Popen([self.patinate, *map(str, command)], cwd=self.folder, stderr=subprocess.DEVNULL)
            while process.poll() is None and not glob.glob(str(items / ".work.tmp*")):  # The folder may go while it is read.
                time.sleep(0.001)
            process.send_signal(signal.SIGKILL)
            process.wait()
        self.succeeds(*command)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["out"])


class DamagedInputs(CommandCase):
    def test_trim_passes_no_damaged_frame_on(self):
        history = self.take("history")
        frame = history / "frames/0001.exr"
        os.truncate(frame, frame.stat().st_size // 2)
        self.fails(INPUT, "0001.exr", "history", "trim", "history", "--from", "0", "-o", "trimmed")
        self.succeeds("history", "trim", "history", "--until", "1", "-o", "trimmed")  # Without that frame.

    def test_an_edited_range_in_the_cache_of_controls_is_not_believed(self):
        environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))
        command = ["control", self.shared / "urn/mesh.obj", "--kind", "accessibility", "--resolution", "2048", "--json"]
        first = self.run_patinate(*command, "-o", "a.exr", env=environment)
        facts = list((self.folder / "cache").rglob("*.json"))
        if not facts:
            self.skipTest("nothing was kept: it is made too quickly")
        for file in facts:
            self.edit_json(file, lambda kept: kept.update(high=kept["high"] * 3))
        again = self.run_patinate(*command, "-o", "b.exr", env=environment)
        self.assertEqual(json.loads(again.stdout)["range"], json.loads(first.stdout)["range"])

    def test_pixels_too_different_to_be_combined_are_named(self):
        for name, size in (("fine", 0.01), ("coarse", 14)):
            shutil.copytree(self.shared / "history", self.folder / name)
            self.edit_json(self.folder / name / "history.json", lambda history: history.update(texel_size_mm=size))

        def little_memory():
            resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
        result = self.run_patinate("history", "combine", "fine", "coarse", "-o", "out", "--threads", "1", preexec_fn=little_memory)
        self.assertNotEqual(result.returncode, 0)
        errors = [line for line in result.stderr.splitlines() if "error" in line]
        self.assertEqual(len(errors), 1, result.stderr)
        self.assertIn("--texel-size", errors[0])


if __name__ == "__main__":
    unittest.main()
