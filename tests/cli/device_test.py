#!/usr/bin/env python3
"""`patinate help devices` and `--device`: the same bytes everywhere, and what is said where there is nothing. Usage: device_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import signal
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
    def transfer_command(self, out, *more, resolution=64):
        return ("transfer", self.shared / "history", self.shared / "urn" / "mesh.obj", "--control", "thickness=facing", "--resolution", resolution, *more, "-o", out)

    def transfer(self, out, *more, resolution=64, **environment):
        return self.run_patinate(*self.transfer_command(out, *more, resolution=resolution), **environment)

    def meshes(self):
        (self.folder / "plate.obj").write_text("v 0 0 0\nv 9 0 0\nv 9 9 1\nv 0 9 0\nvt .02 .02\nvt .98 .02\nvt .98 .98\nvt .02 .98\nf 1/1 2/2 3/3 4/4\n")
        meshes = {"plate": "plate.obj", "urn": self.shared / "urn" / "mesh.obj"}
        if DATA:
            meshes["spot"] = pathlib.Path(DATA) / "meshes/spot/spot_triangulated.obj"
        return meshes

    def an_opencl_device(self):
        devices = json.loads(self.succeeds("help", "devices", "--json"))["devices"]
        if not devices:
            self.skipTest("there is no OpenCL device (Debian: pocl-opencl-icd)")
        return devices[0]

    def kill_when(self, has_begun, *arguments):
        """SIGKILL as soon as something is there, or so many seconds after."""
        process = subprocess.Popen([self.patinate, *map(str, arguments)], cwd=self.folder, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        while process.poll() is None and not has_begun():
            time.sleep(0.001)
        process.kill()
        self.assertEqual(process.wait(), -signal.SIGKILL, "it was done before it could be killed")

    def kill_at_its_first_checkpoint(self, out, *arguments):
        self.kill_when(lambda: list((self.folder / f"{out}.partial").rglob("checkpoint.bin")), *arguments)
        self.assertFalse((self.folder / out).exists())

    def assert_same_files(self, one, other):
        self.assertEqual(one.keys(), other.keys())
        for file in one:
            self.assertEqual(one[file], other[file], file)

    def both_ways(self, device):
        """Where a run begins, where it ends, and a name for its output."""
        return ((device["name"], "cpu", "from_device"), ("cpu", device["name"], "from_cpu"))

    def test_each_says_whether_it_gives_the_cpus_bytes(self):
        device = self.an_opencl_device()
        self.assertEqual(device["checks"], dict.fromkeys(("arithmetic", "transfer", "rays", "iterations"), "passed"))
        self.assertIn(device["name"], self.succeeds("help", "devices"))

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

    def test_models_and_pictures_of_simulations_are_the_same_on_each(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "ledge", "-o", "ledge")
        self.succeeds("simulate", self.folder / "ledge/scene.json", "--iterations", "20", "--history-every", "10", "--resolution", "128", "-o", "aged_ledge")
        asked = [("export", "aged_ledge", "ledge.usdz", "--num-times", "2"), ("render", "aged_ledge", "ledge.png", "--width", "64")]
        for where, name in (("there", device["name"]), ("here", "cpu")):
            (self.folder / where).mkdir()
            for command, subject, file, *options in asked:
                result = self.run_patinate(command, subject, *options, "--device", name, "--verbose", "-o", self.folder / where / file)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual("s in kernels" in result.stderr, where == "there", result.stderr)
                self.assertNotIn("continues on the CPU", result.stderr)
        self.assert_same_files(tree_of(self.folder / "here"), tree_of(self.folder / "there"))

    def test_what_is_up_to_date_opens_no_device(self):
        self.assertEqual(self.transfer("aged").returncode, 0)
        self.succeeds("export", "aged", "-o", "aged.glb")
        device = self.an_opencl_device()
        result = self.run_patinate("export", "aged", "--device", device["name"], "--verbose", "-o", "aged.glb")
        self.assertIn("up to date", result.stderr)
        self.assertNotIn("device: ", result.stderr)

    def test_a_simulation_that_was_killed_goes_on_elsewhere(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "ledge", "-o", "ledge")
        scene = self.folder / "ledge" / "scene.json"
        options = ("--iterations", "400", "--resolution", "128", "--history-every", "10")
        self.succeeds("simulate", scene, *options, "--device", "cpu", "-o", "whole")
        for begun, ended, out in self.both_ways(device):
            self.kill_at_its_first_checkpoint(out, "simulate", scene, *options, "--device", begun, "-o", out)
            self.succeeds("simulate", scene, *options, "--device", ended, "-o", out)
            self.assert_same_files(tree_of(self.folder / "whole"), tree_of(self.folder / out))

    def test_a_transfer_that_was_killed_goes_on_elsewhere(self):
        device = self.an_opencl_device()

        def has_run_for(seconds, out):
            """The synthesis begins with its folder."""
            while not (self.folder / f"{out}.partial").exists():
                yield False
            begin = time.monotonic()
            while time.monotonic() < begin + seconds:
                yield False
            yield True
        seconds = {}
        for where in (device["name"], "cpu"):
            self.assertEqual(self.transfer(f"whole_{where}", "--device", where, resolution=160).returncode, 0)
            seconds[where] = json.loads((self.folder / f"whole_{where}" / "run.json").read_text())["seconds"]
        whole = tree_of(self.folder / "whole_cpu")
        self.assert_same_files(whole, tree_of(self.folder / f"whole_{device['name']}"))
        for begun, ended, out in self.both_ways(device):
            for share in (0.1, 0.4):
                looks = has_run_for(share * seconds[begun], out)
                self.kill_when(lambda: next(looks), *self.transfer_command(out, "--device", begun, resolution=160))
                self.assertFalse((self.folder / out).exists(), "neither whole nor absent")
            result = self.transfer(out, "--device", ended, resolution=160)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assert_same_files(whole, tree_of(self.folder / out))

    def test_a_simulation_is_the_same_on_each(self):
        device = self.an_opencl_device()
        self.succeeds("synth", "ledge", "-o", "ledge")
        scene = self.folder / "ledge" / "scene.json"
        for out, name in (("there", device["name"]), ("here", "cpu")):
            self.succeeds("simulate", scene, "--iterations", "40", "--resolution", "128", "--device", name, "-o", out)
            self.succeeds("simulate", "restyle", out, "--device", name, "-o", out + "_again")
        for folder in ("", "_again"):
            self.assert_same_files(tree_of(self.folder / f"here{folder}"), tree_of(self.folder / f"there{folder}"))

    def test_a_finished_transfer_is_not_redone_for_another_device(self):
        device = self.an_opencl_device()
        self.assertEqual(self.transfer("aged", "--device", "cpu").returncode, 0)
        result = self.transfer("aged", "--device", device["name"])
        self.assertIn("up to date", result.stderr)

    def test_without_opencl_auto_is_the_cpu_in_silence(self):
        result = self.transfer("aged", env=WITHOUT)
        self.assertEqual((result.returncode, "evice" in result.stderr), (0, False), result.stderr)
        listed = self.run_patinate("help", "devices", env=WITHOUT)
        self.assertEqual(listed.returncode, 0)
        self.assertIn("No OpenCL devices", listed.stdout)

    def test_one_that_is_not_there_is_an_error_before_work_starts(self):
        for name in ("vega 99", "gpu"):
            result = self.transfer("aged", "--device", name, env=WITHOUT)
            self.assertEqual(result.returncode, INPUT)
            for command, file in (("export", "aged.glb"), ("render", "aged.png")):
                self.assertEqual(self.run_patinate(command, self.shared / "aged", "--device", name, "-o", file, env=WITHOUT).stderr, result.stderr)
            self.assertEqual(result.stderr, f"patinate: error: --device: found `{name}`; OpenCL has no devices here; or auto, cpu\n")

    def test_the_reference_has_none(self):
        result = self.transfer("aged", "--method", "reference", "--device", "gpu")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn("--method reference runs on the CPU", result.stderr)


if __name__ == "__main__":
    unittest.main()
