#!/usr/bin/env python3
"""`patinate devices` and `--device`: the same bytes everywhere, and what is said where there is nothing. Usage: device_cli_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import subprocess
import sys
import time
import unittest

from command_case import INPUT, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
DATA = os.environ.get("PATINATE_DATA")
WITHOUT = {**os.environ, "PATINATE_OPENCL": "none"}


def setUpModule():
    use(PATINATE)


class Devices(CommandCase):
    def transfer(self, out, *more, **environment):
        return self.run_patinate("transfer", self.shared / "history", self.shared / "urn" / "mesh.obj", "--control", "thickness=facing", "--resolution", "64", *more, "-o", out, **environment)

    def meshes(self):
        (self.folder / "plate.obj").write_text("v 0 0 0\nv 9 0 0\nv 9 9 1\nv 0 9 0\nvt .02 .02\nvt .98 .02\nvt .98 .98\nvt .02 .98\nf 1/1 2/2 3/3 4/4\n")
        meshes = {"plate": "plate.obj", "urn": self.shared / "urn" / "mesh.obj"}
        if DATA:
            meshes["spot"] = pathlib.Path(DATA) / "meshes/spot/spot_triangulated.obj"
        return meshes

    def an_opencl_device(self):
        devices = json.loads(self.succeeds("devices", "--json"))["devices"]
        if not devices:
            self.skipTest("there is no OpenCL device (Debian: pocl-opencl-icd)")
        return devices[0]

    def kill_at_its_first_checkpoint(self, out, *arguments):
        process = subprocess.Popen([self.patinate, *map(str, arguments)], cwd=self.folder, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        while process.poll() is None and not list((self.folder / f"{out}.partial").rglob("checkpoint.bin")):
            time.sleep(0.002)
        process.kill()
        process.wait()
        self.assertFalse((self.folder / out).exists(), "it was done before it could be killed")

    def test_each_says_whether_it_gives_the_cpus_bytes(self):
        device = self.an_opencl_device()
        self.assertEqual(device["checks"], dict.fromkeys(("arithmetic", "transfer", "exact search", "lookups", "composition", "rules", "rays", "gammatons", "exchange"), "passed"))
        self.assertIn(device["name"], self.succeeds("devices"))

    def test_a_transfer_is_the_same_on_each(self):
        device = self.an_opencl_device()
        for out, name in (("there", device["name"]), ("here", "cpu")):
            result = self.transfer(out, "--device", name)
            self.assertEqual(result.returncode, 0, result.stderr)
        for file in ("coordinates.exr", "transfer.json"):
            self.assertEqual((self.folder / "there" / file).read_bytes(), (self.folder / "here" / file).read_bytes(), file)
        self.assertIn(device["name"], (self.folder / "there" / "run.json").read_text())

    def test_a_photograph_and_thirty_frames_age_plate_urn_and_spot_alike(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "crackle", "-o", "crackle", "--width", "96", "--height", "96", "--num-frames", "30")
        self.succeeds("ingest", "crackle/capture.json", "-o", "thirty")
        self.edit_json(self.folder / "crackle/capture.json", lambda project: project["frames"].update(pattern="frames/0029.png"))
        self.succeeds("ingest", "crackle/capture.json", "-o", "photograph")
        for history in ("photograph", "thirty"):
            for name, mesh in self.meshes().items():
                for out, where in (("there", device["name"]), ("here", "cpu")):
                    self.succeeds("transfer", history, mesh, "--control", "thickness=facing", "--resolution", "96", "--device", where, "-o", f"{out}_{history}_{name}")
                here, there = self.folder / f"here_{history}_{name}", self.folder / f"there_{history}_{name}"
                self.assertEqual((here / "coordinates.exr").read_bytes(), (there / "coordinates.exr").read_bytes(), (history, name))
        for out, where in (("there", device["name"]), ("here", "cpu")):
            self.succeeds("lookup", "here_thirty_urn", "--time-map", "height", "--device", where, "-o", f"{out}.exr")
        self.assertEqual((self.folder / "here.exr").read_bytes(), (self.folder / "there.exr").read_bytes())

    def test_lookups_are_the_same_on_each(self):
        device = self.an_opencl_device()
        self.assertEqual(self.transfer("aged").returncode, 0)
        asked = {
            "times_%04d.png": ("--num-times", "3"),
            "linear.exr": ("--time", "1.25"),
            "map.png": ("--time-map", "height"),
            "map.exr": ("--time-map", "height", "--between", "nearest"),
        }
        for out, name in (("there", device["name"]), ("here", "cpu")):
            (self.folder / out).mkdir()
            for file, options in asked.items():
                self.succeeds("lookup", "aged", *options, "--device", name, "-o", self.folder / out / file)
        here, there = tree_of(self.folder / "here"), tree_of(self.folder / "there")
        self.assertEqual(here.keys(), there.keys())
        for file in here:
            self.assertEqual(here[file], there[file], file)

    def test_a_simulation_that_was_killed_goes_on_elsewhere(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "ledge", "-o", "ledge")
        scene = self.folder / "ledge" / "scene.json"
        options = ("--iterations", "400", "--resolution", "128", "--history-every", "10")
        self.succeeds("simulate", scene, *options, "--device", "cpu", "-o", "whole")
        for begun, ended in ((device["name"], "cpu"), ("cpu", device["name"])):
            out = f"from_{'cpu' if begun == 'cpu' else 'device'}"
            self.kill_at_its_first_checkpoint(out, "simulate", scene, *options, "--device", begun, "-o", out)
            self.succeeds("simulate", scene, *options, "--device", ended, "-o", out)
            whole, resumed = tree_of(self.folder / "whole"), tree_of(self.folder / out)
            self.assertEqual(whole.keys(), resumed.keys())
            for file in whole:
                self.assertEqual(whole[file], resumed[file], file)

    def test_a_simulation_is_the_same_on_each(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "ledge", "-o", "ledge")
        scene = self.folder / "ledge" / "scene.json"
        for out, name in (("there", device["name"]), ("here", "cpu")):
            self.succeeds("simulate", scene, "--iterations", "40", "--resolution", "128", "--device", name, "-o", out)
            self.succeeds("recompose", out, "--device", name, "-o", out + "_again")
        for folder in ("", "_again"):
            here, there = tree_of(self.folder / f"here{folder}"), tree_of(self.folder / f"there{folder}")
            self.assertEqual(here.keys(), there.keys())
            for file in here:
                self.assertEqual(here[file], there[file], file)

    def test_a_finished_transfer_is_not_redone_for_another_device(self):
        device = self.an_opencl_device()
        self.assertEqual(self.transfer("aged", "--device", "cpu").returncode, 0)
        result = self.transfer("aged", "--device", device["name"])
        self.assertIn("up to date", result.stderr)

    def test_without_opencl_auto_is_the_cpu_in_silence(self):
        result = self.transfer("aged", env=WITHOUT)
        self.assertEqual((result.returncode, "evice" in result.stderr), (0, False), result.stderr)
        listed = self.run_patinate("devices", env=WITHOUT)
        self.assertEqual(listed.returncode, 0)
        self.assertIn("No OpenCL devices", listed.stdout)

    def test_one_that_is_not_there_is_an_error_before_work_starts(self):
        for name in ("vega 99", "gpu"):
            result = self.transfer("aged", "--device", name, env=WITHOUT)
            self.assertEqual(result.returncode, INPUT)
            self.assertEqual(result.stderr, f"patinate: error: --device: found `{name}`; OpenCL has no devices here; or auto, cpu\n")

    def test_tiles_have_none(self):
        result = self.transfer("aged", "--by-tile", "--device", "gpu")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn("--by-tile runs on the CPU", result.stderr)

    def test_the_reference_and_its_audit_are_the_same_on_each(self):
        device = self.an_opencl_device()
        for mesh, file in self.meshes().items():
            for out, name in (("there", device["name"]), ("here", "cpu")):
                self.succeeds("transfer", self.shared / "history", file, "--control", "thickness=facing", "--resolution", "64", "--method", "reference", "--window", "40", "--device", name, "-o", f"{mesh}_{out}")
                self.succeeds("evaluate", f"{mesh}_{out}", "--audits", "300", "--device", name, "-o", f"{mesh}_audit_{out}")
                self.assertIn(name, (self.folder / f"{mesh}_audit_{out}" / "run.json").read_text())
            there, here = (self.folder / f"{mesh}_{out}" for out in ("there", "here"))
            self.assertEqual((there / "coordinates.exr").read_bytes(), (here / "coordinates.exr").read_bytes())
            there, here = (json.loads((self.folder / f"{mesh}_audit_{out}" / "evaluation.json").read_text())["maps"][0]["figures"] for out in ("there", "here"))
            self.assertEqual(there, here)


if __name__ == "__main__":
    unittest.main()
