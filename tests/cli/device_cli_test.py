#!/usr/bin/env python3
"""`patinate devices` and `--device`: the same bytes everywhere, and what is said where there is nothing. Usage: device_cli_test.py PATINATE [unittest arguments]"""
import json
import os
import sys
import unittest

from command_case import INPUT, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
WITHOUT = {**os.environ, "PATINATE_OPENCL": "none"}


def setUpModule():
    use(PATINATE)


class Devices(CommandCase):
    def transfer(self, out, *more, **environment):
        return self.run_patinate("transfer", self.shared / "history", self.shared / "urn" / "mesh.obj", "--control", "thickness=facing", "--resolution", "64", *more, "-o", out, **environment)

    def an_opencl_device(self):
        devices = json.loads(self.succeeds("devices", "--json"))["devices"]
        if not devices:
            self.skipTest("there is no OpenCL device (Debian: pocl-opencl-icd)")
        return devices[0]

    def test_each_says_whether_it_gives_the_cpus_bytes(self):
        device = self.an_opencl_device()
        self.assertEqual(device["checks"], dict.fromkeys(("arithmetic", "transfer", "composition", "rules", "rays"), "passed"))
        self.assertIn(device["name"], self.succeeds("devices"))

    def test_a_transfer_is_the_same_on_each(self):
        device = self.an_opencl_device()
        for out, name in (("there", device["name"]), ("here", "cpu")):
            result = self.transfer(out, "--device", name)
            self.assertEqual(result.returncode, 0, result.stderr)
        for file in ("coordinates.exr", "transfer.json"):
            self.assertEqual((self.folder / "there" / file).read_bytes(), (self.folder / "here" / file).read_bytes(), file)
        self.assertIn(device["name"], (self.folder / "there" / "run.json").read_text())

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

    def test_the_reference_method_has_none(self):
        result = self.transfer("aged", "--method", "reference", "--device", "gpu")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn("--method reference runs on the CPU", result.stderr)


if __name__ == "__main__":
    unittest.main()
