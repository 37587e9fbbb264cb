#!/usr/bin/python3
"""The keyword `device` in Python: the same values on each, and what is said of one that is not there."""
import json

import numpy as np
import patinate

from python_case import PythonCase, main


class Devices(PythonCase):
    def setUp(self):
        devices = json.loads(self.run_patinate("help", "devices", "--json"))["devices"]
        if not devices:
            self.skipTest("there is no OpenCL device (Debian: pocl-opencl-icd)")
        self.device = devices[0]["name"]

    def same_on_each(self, work):
        """`work(device)` gives arrays, or a dict of them."""
        here, there = work("cpu"), work(self.device)
        if isinstance(here, dict):
            self.assertEqual(list(here), list(there))
            for name in here:
                np.testing.assert_array_equal(here[name], there[name], name)
        else:
            np.testing.assert_array_equal(here, there)
        return there

    def test_a_transfer(self):
        history, mesh = patinate.read_history(self.work / "history"), patinate.read_mesh(self.work / "urn/mesh.obj")
        self.same_on_each(lambda device: patinate.transfer(history, mesh, "facing", resolution=64, device=device).coordinates)

    def test_a_simulation(self):
        def frames(device):
            simulation = patinate.Simulation(self.work / "scene.json", device=device)
            simulation.step(count=4)
            return simulation.compose()
        self.same_on_each(frames)

    def test_models_and_another_look(self):
        self.run_patinate("simulate", "scene.json", "-o", "plate")
        for where, device in (("here", "cpu"), ("there", self.device)):
            folder = self.work / where
            folder.mkdir()
            patinate.export(self.work / "aged", folder / "aged.glb", device=device)
            patinate.render(self.work / "aged", folder / "aged.png", time=1.0, width=48, device=device)
            patinate.recompose(self.work / "plate", folder / "pale", changes={"patina.strength": 0.2}, device=device)
        self.same_files("here", "there")

    def test_one_that_is_not_there_is_an_error(self):
        history, mesh = patinate.read_history(self.work / "history"), patinate.read_mesh(self.work / "urn/mesh.obj")
        for work in (lambda: patinate.transfer(history, mesh, "facing", device="vega 99"),
                     lambda: patinate.Simulation(self.work / "scene.json", device="vega 99"), lambda: patinate.export(self.work / "aged", self.work / "no.glb", device="vega 99")):
            self.assertIn("found `vega 99`", self.line_of(patinate.InvalidInput, work))


if __name__ == "__main__":
    main()
