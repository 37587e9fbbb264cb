#!/usr/bin/python3
"""What the module says of itself: signatures, docstrings, type stubs."""
import importlib.util
import inspect
import re
import subprocess
import sys
import unittest

import patinate

from python_case import PythonCase, main

USE = """
import numpy as np
import patinate

history: patinate.History = patinate.history_from_arrays(np.zeros((2, 8, 8, 3), np.float32), [0, 1], name="x")
aged = patinate.transfer(history, patinate.read_mesh("mesh.obj"), {"x": "facing"}, resolution=64, on_progress=print)
texture = aged.texture(0.5, between="hold")
shape: tuple[int, ...] = texture.shape + aged.texture([0, 1], tile=aged.tiles[0]).shape + aged.material_map("height", [0.0, 1.0]).shape
notes: list[str] = aged.notes
simulation = patinate.Simulation("scene.json", resolution=64)
simulation.step(count=3)
again = patinate.Simulation("saved")
patinate.simulate({"materials": []}, "simulated", meshes={"plate": patinate.read_mesh("mesh.obj")})
patinate.fit({"materials": []}, "history", {"/rules/0/rate": (0, 1)}, folder="here")
patinate.trim(history, "trimmed")
patinate.combine([history, "other"], "both")
picture = patinate.render(aged, num_times=3, up="z", views=["front"])
patinate.export("aged", "aged.glb", times=[0, 1])
nearest: list[str] = list(patinate.library(like=texture))
"""


# What does a command's work in Python.
FUNCTION_OF = {"init": "init", "ingest": "ingest", "unlight": "unlight", "thickness": "thickness", "register": "register", "height-change": "relief", "control": "Surface", "control accessibility": "Surface", "control explain": "explain",
               "history combine": "combine", "history trim": "trim", "history library": "library", "history material": "appearance", "transfer": "transfer", "texture": "AgedMesh.texture", "evaluate": "evaluate", "history compare": "compare", "grade": "grade",
               "calibrate": "calibrate_camera", "render": "render", "export": "export", "history factorize": "factorize", "simulate": "simulate", "fit": "fit", "fit rank": "rank", "simulate restyle": "recompose", "synth": "synth_crackle"}
# What only a program does: pages, other machines, the program itself.
OF_THE_PROGRAM = {"fit field", "studio", "cluster plan", "cluster run", "cluster join", "study", "info", "validate", "help devices", "help completion", "help"}


class Says(PythonCase):
    def test_every_command_has_a_function_or_a_reason(self):
        commands = re.findall(r"^## ([a-z-]+(?: [a-z-]+)?)$", self.run_patinate("help", "--markdown"), re.MULTILINE)
        self.assertEqual(sorted(commands), sorted([*FUNCTION_OF, *OF_THE_PROGRAM]))
        for command, name in FUNCTION_OF.items():
            place = patinate
            for part in name.split("."):
                self.assertTrue(hasattr(place, part), f"{command}: {name}")
                place = getattr(place, part)

    def functions(self):
        for name in patinate.__all__:
            value = getattr(patinate, name)
            if inspect.isbuiltin(value):
                yield name, value
            elif inspect.isclass(value) and not issubclass(value, Exception):
                yield from ((f"{name}.{key}", member) for key, member in vars(value).items() if inspect.isroutine(member) and not key.startswith("_"))

    def test_every_function_has_a_signature_and_a_docstring_with_each_parameter(self):
        found = list(self.functions())
        self.assertGreater(len(found), 40)
        for name, function in found:
            parameters = inspect.signature(function).parameters
            self.assertTrue(function.__doc__ and function.__doc__[0].isupper(), name)
            for parameter in parameters:
                if parameter != "self":
                    self.assertIn(f"{parameter}: ", function.__doc__, name)

    def test_every_attribute_says_what_it_is(self):
        for name in patinate.__all__:
            value = getattr(patinate, name)
            if inspect.isclass(value):
                for key, member in vars(value).items():
                    if isinstance(member, property):
                        self.assertTrue(member.__doc__, f"{name}.{key}")

    def test_defaults_are_those_of_the_command_line(self):
        # Of each option what stands between its name and the next one's.
        said = {}
        for entry in re.split(r"\n  (?=--)", self.run_patinate("transfer", "--help-all"))[1:]:
            words = entry.split()
            said[words[0][2:].replace("-", "_")] = " ".join(words[1:])
        # Options of kinds of control stand in the text of the control: `ray_share(rays=N)` is share_rays.
        of_kinds = re.findall(r"^  (\w+)\((\w+)=.*?\) *((?:.*\n)(?:    .*\n)*)", self.run_patinate("control", "--help-all"), re.MULTILINE)
        num_checked = 0
        for name, parameter in inspect.signature(patinate.transfer).parameters.items():
            default = ",".join(map(str, parameter.default)) if isinstance(parameter.default, tuple) else parameter.default
            if isinstance(default, bool) or not isinstance(default, (str, int, float)) or default == "" or name == "num_threads":
                continue  # Flags, and what is found by the work; --threads is the command line's name.
            num_checked += 1
            with self.subTest(name=name):
                if name not in said:
                    said[name] = "; ".join(" ".join(text.split()) for kind, word, text in of_kinds
                                           if word in (name, "_".join(part for part in name.split("_") if part not in kind.split("_"))))
                self.assertRegex(said[name], rf"(default|, else) {re.escape(str(default))}(?![\w.])")
        self.assertGreater(num_checked, 30)

    @unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
    def test_stubs_hold_in_mypy(self):
        (self.work / "use.py").write_text(USE)
        (self.work / "misuse.py").write_text("import patinate\npatinate.read_history(7)\npatinate.transfer()\n")
        # The package as it is installed: a folder of stubs and no source would do.
        environment = {"MYPYPATH": str(self.package.parent), "PATH": "/usr/bin:/bin"}

        def mypy(*files):
            return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(self.work / "mypy"), *files], cwd=self.work, env=environment,
                                  capture_output=True, text=True)
        result = mypy("use.py", str(self.package / "__init__.pyi"))
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("Found 2 errors", mypy("misuse.py").stdout)
        self.assertTrue((self.package / "py.typed").exists())


if __name__ == "__main__":
    main()
