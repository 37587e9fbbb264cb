#!/usr/bin/python3
"""Pictures, movies and models in Python."""
import subprocess
import warnings

import numpy as np
import patinate

from python_case import PythonCase, main

SMALL = ["--width", "96", "--height", "80", "--samples", "1", "--occlusion-samples", "4"]
KEYWORDS = {"width": 96, "height": 80, "samples": 1, "occlusion_samples": 4}


class Output(PythonCase):
    @classmethod
    def setUpClass(cls):
        cls().run_patinate("simulate", "scene.json", "-o", "simulated")

    def both(self, function, command, subject, name, options, keywords):
        """The bytes of the command and of Python are the same, and each is up to date to the other."""
        for folder in ("by_command", "by_python"):
            (self.work / folder).mkdir(exist_ok=True)
        self.run_patinate(command, subject, *options, "-o", f"by_command/{name}")
        function(self.work / subject, self.work / "by_python" / name, **keywords)
        self.same_files("by_command", "by_python")
        before = {p: p.stat().st_mtime_ns for p in (self.work / "by_python").rglob("*") if p.is_file()}
        self.run_patinate(command, subject, *options, "-o", f"by_python/{name}")
        function(self.work / subject, self.work / "by_python" / name, **keywords)
        self.assertEqual(before, {p: p.stat().st_mtime_ns for p in before})

    def test_what_was_made_or_opened_here_is_exported_as_its_folder(self):
        history = patinate.read_history(self.work / "history")
        aged = patinate.transfer(history, patinate.read_mesh(self.work / "urn/mesh.obj"), "facing", resolution=64)
        models = []
        for name, subject in (("folder", self.work / "aged"), ("object", aged), ("transfer", patinate.read_transfer(self.work / "aged"))):
            (self.work / name).mkdir()  # The model's name is in the model.
            patinate.export(subject, self.work / name / "aged.glb", num_times=2)
            models.append((self.work / name / "aged.glb").read_bytes())
        self.assertEqual(models, [models[0]] * 3)
        patinate.export(history, self.work / "frames", num_times=2)
        self.assertTrue((self.work / "frames/sequence.json").is_file())

    def test_pictures_and_movies_are_the_commands(self):
        last = str(patinate.read_history(self.work / "history").times[-1])
        patinate.write_color(self.work / "plate.png", np.full((8, 8, 3), 0.3, np.float32))
        patinate.write_color(self.work / "sky.exr", np.linspace(0, 2, 16 * 32 * 3, dtype=np.float32).reshape(16, 32, 3))
        for subject, name, options, keywords in (
                ("aged", "strip.png", ["--num-times", "3"], {"num_times": 3}),
                ("aged", "one.exr", ["--time", last, "--environment", "sky.exr"], {"time": float(last), "environment": self.work / "sky.exr"}),
                ("aged", "views.jpg", ["--time", last, "--views", "front,30:20"], {"time": float(last), "views": ["front", "30:20"]}),
                ("aged", "turn.gif", ["--num-times", "3", "--turn", "90", "--fps", "5"], {"num_times": 3, "turn": 90, "fps": 5}),
                ("aged", "at_%02d.png", ["--times", "0," + last], {"times": [0, float(last)]}),
                ("simulated", "end.png", ["--maps", "color"], {"maps": "color"}),
                ("history", "history.png", ["--num-times", "2"], {"num_times": 2}),
                ("plate.obj", "plate.png", ["--texture", "plate.png", "--target", "0,0,0"], {"texture": self.work / "plate.png", "target": (0, 0, 0)})):
            with self.subTest(name=name):
                self.both(patinate.render, "render", subject, name, [*SMALL, *options], {**KEYWORDS, **keywords})

    def test_models_sequences_and_movies_are_the_commands(self):
        for subject, name, options, keywords in (
                ("aged", "aged.glb", ["--num-times", "2"], {"num_times": 2}),
                ("aged", "aged.usda", ["--num-times", "2"], {"num_times": 2}),
                ("aged", "aged.usdz", [], {}),
                ("aged", "aged.obj", [], {}),
                ("aged", "standing.glb", ["--up", "z"], {"up": "z"}),
                ("aged", "images", ["--format", "exr", "--times", "0,1"], {"format": "exr", "times": [0, 1]}),
                ("aged", "aged.gif", ["--num-times", "2"], {"num_times": 2}),
                ("simulated", "end.glb", [], {}),
                ("history", "frames", [], {}),
                ("history", "frame_%d.png", ["--num-times", "2"], {"num_times": 2})):
            with self.subTest(name=name):
                self.both(patinate.export, "export", subject, name, options, keywords)

    def test_an_array_is_the_picture_that_is_written(self):
        last = float(patinate.read_history(self.work / "history").times[-1])
        self.run_patinate("render", "aged", *SMALL, "--num-times", "3", "-o", "written.exr")
        transfer = patinate.read_transfer(self.work / "aged")
        written = patinate.read_color(self.work / "written.exr")
        for subject in (self.work / "aged", transfer):
            np.testing.assert_array_equal(patinate.render(subject, num_times=3, **KEYWORDS).astype(np.float16), written.astype(np.float16))
        # In memory as in its folder: texels show the same, but for what lies beside the charts.
        mesh, history = patinate.read_mesh(self.work / "urn/mesh.obj"), patinate.read_history(self.work / "history")
        aged = patinate.transfer(history, mesh, "facing", resolution=64)
        ours, theirs = (patinate.render(subject, time=last, maps="color", **KEYWORDS) for subject in (aged, transfer))
        self.assertEqual(ours.shape, (80, 96, 3))
        self.assertGreater((np.abs(ours - theirs).max(axis=2) < 1e-6).mean(), 0.99)

    def test_what_does_not_go_together_is_one_line(self):
        for wrong in (lambda: patinate.render(self.work / "aged", self.work / "x.docx"), lambda: patinate.render(self.work / "history", self.work / "x.mp4"),
                      lambda: patinate.render(self.work / "aged", self.work / "x.png", time=1, num_times=2), lambda: patinate.render(self.work / "aged", ""),
                      lambda: patinate.render(self.work / "aged", self.work / "x.png", views="sideways"), lambda: patinate.render(self.work / "aged", self.work / "x.png", width=4),
                      lambda: patinate.render(self.work / "plate.obj"), lambda: patinate.export(self.work / "history", self.work / "x.glb"),
                      lambda: patinate.export(self.work / "aged", self.work / "x.fbx"), lambda: patinate.export(self.work / "aged", self.work / "x.obj", num_times=2)):
            self.line_of(patinate.InvalidInput, wrong)
        self.line_of(patinate.IoError, lambda: patinate.render(self.work / "nothing", self.work / "x.png"))
        self.line_of(patinate.InvalidInput, lambda: patinate.render(self.work / "aged", self.work / "x.png", times="soon"))
        self.assertIn("subject: found int", self.line_of(TypeError, lambda: patinate.render(7)))
        self.assertFalse(list(self.work.glob("x.*")))
        patinate.export(self.work / "aged", self.work / "kept.obj")
        self.line_of(patinate.CannotComplete, lambda: patinate.export(self.work / "aged", self.work / "kept.obj", time=0))
        patinate.export(self.work / "aged", self.work / "kept.obj", time=0, force=True)

    def test_what_is_open_or_in_memory_becomes_the_files_of_its_folder(self):
        history, aged = patinate.read_history(self.work / "history"), patinate.read_transfer(self.work / "aged")
        made = patinate.transfer(self.work / "history", patinate.read_mesh(self.work / "urn/mesh.obj"), "facing", resolution=64)
        view = {"time": 0, "width": 48, "height": 48, "samples": 1}
        for name, subject, folder in (("history", history, "history"), ("opened", aged, "aged"), ("made", made, "aged")):
            with self.subTest(subject=name):
                patinate.render(subject, self.work / f"{name}.png", **view)
                patinate.render(self.work / folder, self.work / f"{name}_of_folder.png", **view)
                np.testing.assert_array_equal(patinate.read_color(self.work / f"{name}.png"), patinate.read_color(self.work / f"{name}_of_folder.png"))
        self.assertTrue(self.line_of(patinate.InvalidInput, lambda: patinate.export(self.work / "aged", self.work / "x.fbx")).startswith("output: "))

    def test_what_never_was_a_folder_becomes_the_files_that_its_folders_give(self):
        history, mesh = patinate.read_history(self.work / "history"), patinate.read_mesh(self.work / "urn/mesh.obj")
        in_memory = patinate.history_from_arrays(list(history), history.times, name="mine", texel_size_mm=history.texel_size_mm,
                                                 controls={"thickness": history.control("thickness")})
        in_memory.save(self.work / "mine")
        options = {"resolution": 64, "mm_per_unit": 1}
        patinate.transfer(self.work / "mine", mesh, "thickness=facing", **options).save(self.work / "mine_aged")
        aged = patinate.transfer(in_memory, mesh, "thickness=facing", **options)
        self.assertIsNone(aged.folder)
        view = {"time": 0, "width": 48, "height": 48, "samples": 1}
        for name, subject, folder in (("of_memory", aged, "mine_aged"), ("of_history", in_memory, "mine")):
            for place in (name, f"{name}_by_folder"):
                (self.work / place).mkdir()  # The model's name is in the model.
            for place, given in ((name, subject), (f"{name}_by_folder", self.work / folder)):
                patinate.render(given, self.work / place / "aged.png", **view)
                patinate.export(given, self.work / place / "frames", num_times=2)
                if folder == "mine_aged":
                    for model in ("aged.glb", "aged.usda", "aged.obj"):
                        patinate.export(given, self.work / place / model, time=0)
            self.same_files(name, f"{name}_by_folder")
        np.testing.assert_array_equal(patinate.render(in_memory, time=0), patinate.render(self.work / "mine", time=0))

    def test_a_mesh_without_a_unit_keeps_the_size_of_its_transfer_and_a_note_says_so(self):
        # The transfer scales the mesh until a texel shows a pixel of the history: `aged` has no unit, and its mesh.obj is in mm.
        transfer = self.json_of("aged", "transfer.json")
        self.assertIsNone(transfer["mesh"]["unit"])
        positions = patinate.read_mesh(self.work / "aged/mesh.obj").positions
        size = np.linalg.norm(positions.max(axis=0) - positions.min(axis=0))
        result = subprocess.run([self.patinate, "export", "aged", "-o", "sized.glb"], cwd=self.work, capture_output=True, text=True, timeout=300)
        with self.assertWarns(UserWarning) as caught:
            patinate.export(self.work / "aged", self.work / "sized_here.glb", force=True)
        for said in (result.stderr, str(caught.warning)):
            self.assertEqual(said.count("states no length unit"), 1, said)
            for figure in (transfer["mesh"]["mm_per_mesh_unit"], size):
                self.assertIn(f"{float(f'{figure:.1e}'):.6g} mm", said)  # Two digits.
        in_glb = patinate.read_mesh(self.work / "sized.glb").positions  # In meters, as glTF is.
        self.assertAlmostEqual(np.linalg.norm(in_glb.max(axis=0) - in_glb.min(axis=0)) / (0.001 * size), 1, places=5)
        patinate.export(self.work / "aged", self.work / "sized.usda", time=0)
        self.assertIn("metersPerUnit = 0.001\n", (self.work / "sized.usda").read_text())
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # An OBJ is in the unit of the file; a mesh whose unit is known needs no note.
            patinate.export(self.work / "aged", self.work / "sized.obj")
            known = patinate.transfer(self.work / "history", patinate.read_mesh(self.work / "urn/mesh.obj"), "facing", resolution=64, mm_per_unit=10)
            patinate.export(known, self.work / "known.glb")


if __name__ == "__main__":
    main()
