#!/usr/bin/python3
"""The examples of docs/examples/python, each in a process of its own as a reader would start it, and what they leave. Usage: tasks_test.py PATINATE FOLDER"""
import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import patinate

from python_case import PythonCase, main

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "docs/examples/python"


class Tasks(PythonCase):
    def python(self, *arguments):
        result = subprocess.run([sys.executable, *map(str, arguments)], cwd=self.work, capture_output=True, text=True, timeout=300)
        self.assertEqual((result.returncode, result.stderr), (0, ""), result.stdout)
        return result.stdout

    def example(self, name, *arguments):
        script, = EXAMPLES.glob(f"*_{name}.py")
        return self.python(script, *arguments)

    def test_every_example_is_here(self):
        here = pathlib.Path(__file__).read_text()
        for script in EXAMPLES.glob("*.py"):
            self.assertIn(f'self.example("{script.stem[3:]}"', here)
            self.assertIn(script.name, script.read_text())  # It says how it is called.

    def test_one_call(self):
        self.example("one_call", "history", "urn/mesh.obj", "facing", "called", "called.png")
        self.run_patinate("transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "512", "--seed", "7", "-o", "called_by_command")
        self.same_files("called", "called_by_command")

    def test_arrays_to_history(self):
        self.assertIn("4 frames", self.example("arrays_to_history", "spot"))
        self.assertEqual(self.json_of("spot", "history.json")["time_unit"], "d")
        self.run_patinate("validate", "spot")

    def test_photographs_to_history(self):
        shutil.copytree(self.work / "capture/frames", self.work / "photographs")
        self.assertIn("photographs", self.example("photographs_to_history", "photographs", "from_photographs"))
        self.run_patinate("init", "photographs", "-o", "photographs/again.json")
        self.assertEqual((self.work / "photographs/again.json").read_bytes(), (self.work / "photographs/capture.json").read_bytes())
        self.assertEqual((self.work / "photographs/again.hints.txt").read_bytes(), (self.work / "photographs/capture.hints.txt").read_bytes())
        self.run_patinate("ingest", "photographs", "-o", "by_command")
        self.same_files("from_photographs", "by_command")
        project = self.json_of("photographs", "capture.json")
        project["frames"]["interval"] = 1000
        (self.work / "photographs/capture.json").write_text(json.dumps(project))
        self.example("photographs_to_history", "photographs", "from_photographs")
        self.assertEqual(patinate.read_history(self.work / "from_photographs").times[1], 1000)

    def test_control_maps(self):
        self.example("control_maps", "urn/mesh.obj", "maps")
        self.run_patinate("transfer", "history", "urn/mesh.obj", "--control", "maps/mixed.exr", "--resolution", "256", "-o", "by_map")
        self.assertEqual(len(list((self.work / "maps").iterdir())), 6)

    def test_transfer_of_arrays(self):
        before = set(self.work.iterdir())
        self.assertIn("(256, 256, 2)", self.example("transfer_of_arrays", "tube.png"))
        self.assertEqual(set(self.work.iterdir()) - before, {self.work / "tube.png"})
        self.assertEqual(patinate.read_color(self.work / "tube.png").shape[2], 3)

    def test_textures_over_time(self):
        self.example("textures_over_time", "aged", "curve.csv")
        curve = np.genfromtxt(self.work / "curve.csv", delimiter=",", names=True)
        self.assertEqual(len(curve), 8)
        self.assertEqual(curve["dark_share"][0], (lambda values: (values < 0.5 * np.median(values)).mean())(self.luminance_of("aged")))

    def luminance_of(self, folder):
        aged = patinate.read_transfer(self.work / folder)
        return aged.texture(aged.history.times[0])[aged.coverage] @ [0.2126, 0.7152, 0.0722]

    def test_own_control(self):
        self.example("own_control", "history", "urn/mesh.obj", "rained_on")
        self.run_patinate("validate", "rained_on")

    def test_scene_without_files(self):
        self.assertIn("dirt", self.example("scene_without_files", "rain"))
        frames = patinate.read_history(self.work / "rain")
        self.assertEqual(len(frames), 5)
        self.assertFalse(np.array_equal(frames.frame(0), frames.frame(-1)))

    def test_compare_as_a_table(self):
        self.example("compare_as_a_table", "history", "aged", "figures.csv")
        with open(self.work / "figures.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertIn("color_distribution", [row["name"] for row in rows])
        self.assertTrue(all(row["value"] or row["undefined"] for row in rows))

    def test_save_render_export(self):
        self.example("save_render_export", "history", "urn/mesh.obj", "kept")
        self.run_patinate("transfer", "history", "urn/mesh.obj", "--unit", "mm", "--control", "facing", "--resolution", "128", "-o", "by_hand")
        self.same_files("kept", "by_hand")
        made = {name: (self.work / name).read_bytes() for name in ("kept.png", "kept.glb")}
        self.run_patinate("render", "kept", "--num-times", "3", "--width", "160", "--height", "160", "--samples", "4", "-o", "kept.png", "--force")
        self.run_patinate("export", "kept", "--num-times", "3", "-o", "kept.glb", "--force")
        self.assertEqual(made, {name: (self.work / name).read_bytes() for name in made})

    def test_progress_and_errors(self):
        said = self.example("progress_and_errors", "history", "urn/mesh.obj")
        self.assertIn("nothing half-made is left\nresolution: 1 is out of range", said)
        self.assertIn("nowhere", said)
        self.assertIn("did you mean `facing`?", said)

    def test_paint_a_scene(self):
        self.assertIn("0 iterations; dirt on ", self.example("paint_a_scene", "painted"))
        self.assertEqual(patinate.Simulation(self.work / "painted").iteration, 20)

    def test_snapshots(self):
        self.assertIn("the same state: True", self.example("snapshots", "scene.json", "rain", "rained"))
        self.assertEqual(self.json_of("rained", "simulation.json")["iterations"], 10)

    def test_fit_a_scene(self):
        truth = json.loads((self.work / "scene.json").read_text())
        truth["rules"][0] = {"name": "patina", "rate": 2.0}
        (self.work / "truth.json").write_text(json.dumps(truth))
        self.run_patinate("simulate", "truth.json", "-o", "truth")
        said = self.example("fit_a_scene", "truth.json", "truth")
        self.assertAlmostEqual(np.log10(float(re.match(r"rate (\S+),", said)[1]) / 2), 0, delta=0.1 * np.log10(20 / 0.05))  # A tenth of the range.

    def test_grade_a_panel(self):
        self.assertIn("5.0 % rusted", self.example("grade_a_panel", "grades.csv"))
        with open(self.work / "grades.csv", newline="") as file:
            self.assertIn("rusted_percent", [row["name"] for row in csv.DictReader(file)])

    def test_explain_a_pattern(self):
        said = self.example("explain_a_pattern", "history", "urn/mesh.obj", "explained")
        self.assertEqual(said.split()[0], "facing")
        self.run_patinate("validate", "explained")

    def test_control_c_ends_an_example(self):
        endless = "import patinate\nprint('on', flush=True)\npatinate.transfer(patinate.read_history('history'), patinate.read_mesh('urn/mesh.obj'), 'facing', resolution=4096, quality='best')"
        process = subprocess.Popen([sys.executable, "-c", endless], cwd=self.work, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        process.stdout.readline()
        time.sleep(0.5)
        os.kill(process.pid, signal.SIGINT)
        self.assertIn("KeyboardInterrupt", process.communicate(timeout=60)[1])
        self.assertNotEqual(process.returncode, 0)


if __name__ == "__main__":
    main()
