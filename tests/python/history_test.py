#!/usr/bin/python3
"""Histories, images, meshes and surfaces in Python."""
import json
import os
import shutil

import numpy as np
import patinate

from python_case import PythonCase, half, main


def gray_history(num_frames=3, **more):
    times = np.arange(num_frames, dtype=float)
    colors = np.stack([np.full((5, 7, 3), 0.25 * t, np.float32) for t in range(num_frames)])
    return patinate.history_from_arrays(colors, times, **more)


class History(PythonCase):
    def test_frames_are_what_the_files_hold(self):
        history = patinate.read_history(self.work / "history")
        manifest = self.json_of("history", "history.json")
        self.assertEqual(len(history), len(manifest["frames"]))
        np.testing.assert_array_equal(history.times, [f["time"] for f in manifest["frames"]])
        for i, frame in enumerate(manifest["frames"]):
            np.testing.assert_array_equal(history.frame(i), patinate.read_color(self.work / "history" / frame["file"]))

    def test_histories_of_a_library_go_by_name(self):
        (self.work / "shelf").mkdir()
        (self.work / "shelf/mine").symlink_to(self.work / "history")
        os.environ["PATINATE_LIBRARY"] = str(self.work / "shelf")
        try:
            self.assertIn("mine", patinate.library())
            np.testing.assert_array_equal(patinate.read_history("library:mine").frame(0), patinate.read_history(self.work / "history").frame(0))
            self.assertIn("mine", self.line_of(patinate.IoError, lambda: patinate.read_history("library:mime")))
        finally:
            del os.environ["PATINATE_LIBRARY"]

    def test_what_is_most_like_is_the_commands(self):
        (self.work / "likes").mkdir()
        (self.work / "likes/mine").symlink_to(self.work / "history")
        gray_history(num_frames=2).save(self.work / "likes/gray")
        photo = self.work / "photo.png"
        patinate.write_color(photo, patinate.read_history(self.work / "history").frame(0))
        os.environ["PATINATE_LIBRARY"] = str(self.work / "likes")
        try:
            for like in (photo, self.work / "history", self.work / "aged"):
                said = json.loads(self.run_patinate("history", "library", "--like", like, "--json"))
                found = patinate.library(like=like)
                self.assertEqual([(name, entry["likeness"]) for name, entry in found.items()],
                                 [(entry["name"], {key: value for key, value in entry.items() if key != "name"}) for entry in said["like"]])
                facts = {entry["name"]: entry for entry in said["histories"]}
                for name, entry in found.items():
                    self.assertEqual({key: value for key, value in entry.items() if key != "likeness"}, facts[name])
            history = patinate.read_history(self.work / "history")
            self.assertEqual(list(patinate.library(like=history).items()), list(patinate.library(like=self.work / "history").items()))
            self.assertEqual(patinate.library(like=history)["mine"]["likeness"]["total"], 0)
            self.assertEqual(list(patinate.library(like=patinate.read_color(photo)).items()), list(patinate.library(like=photo).items()))
            self.line_of(TypeError, lambda: patinate.library(like=7))
            self.line_of(patinate.IoError, lambda: patinate.library(like=self.work / "nothing"))
        finally:
            del os.environ["PATINATE_LIBRARY"]

    def test_what_is_stated_of_a_material_is_the_commands(self):
        statement = self.work / "stated.json"
        statement.write_text(json.dumps({"format": "patinate.appearance", "version": 1, "materials": [
            {"color": "#f0e8d8", "metalness": 0, "roughness": 0.9}, {"color": "#302010", "metalness": 1, "roughness": 0.25, "tint": "#f0ae8c"}]}))
        for name, arguments, keywords in (("by_color", [str(statement)], {"statement": statement}), ("plain", ["--metalness", "1", "--roughness", "0.35"], {"metalness": 1, "roughness": 0.35})):
            self.run_patinate("history", "material", "history", *arguments, "-o", f"{name}_by_command")
            history = patinate.appearance(self.work / "history", self.work / f"{name}_by_python", **keywords)
            self.assertEqual(len(history), len(patinate.read_history(self.work / "history")))
            self.same_files(f"{name}_by_command", f"{name}_by_python")
        self.line_of(patinate.InvalidInput, lambda: patinate.appearance(self.work / "history", self.work / "x"))
        self.line_of(patinate.InvalidInput, lambda: patinate.appearance(self.work / "history", self.work / "x", statement=statement, metalness=1))
        self.line_of(patinate.InvalidInput, lambda: patinate.appearance(self.work / "history", self.work / "x", metalness=2))
        self.assertFalse((self.work / "x").exists())

    def test_combined_histories_are_the_commands(self):
        self.run_patinate("history", "combine", "history", "history", "--clock", "span", "-o", "combined_by_command")
        library = patinate.combine([self.work / "history", self.work / "history"], self.work / "combined_by_python", clock="span")
        self.assertEqual(len(library), len(patinate.read_history(self.work / "history")))
        self.same_files("combined_by_command", "combined_by_python")
        self.line_of(patinate.InvalidInput, lambda: patinate.combine([self.work / "history"] * 2, self.work / "x", controls={"age": ["thickness"]}))
        self.assertFalse((self.work / "x").exists())

    def test_one_history_inside_another_is_the_commands(self):
        where = "smoothstep(0.4, 0.6, thickness)"
        self.run_patinate("history", "combine", "history", "history", "--where", where, "-o", "layers_by_command")
        patinate.combine([self.work / "history"] * 2, self.work / "layers_by_python", where=where)
        self.same_files("layers_by_command", "layers_by_python")
        self.line_of(patinate.ParseError, lambda: patinate.combine([self.work / "history"] * 2, self.work / "x", where="thicknes"))
        self.line_of(patinate.InvalidInput, lambda: patinate.combine([self.work / "history"] * 3, self.work / "x", where="thickness"))

    def test_a_trimmed_history_is_the_commands(self):
        self.run_patinate("history", "trim", "history", "--every", "2", "-o", "trimmed_by_command")
        shorter = patinate.trim(self.work / "history", self.work / "trimmed_by_python", every=2)
        self.assertLess(len(shorter), len(patinate.read_history(self.work / "history")))
        self.same_files("trimmed_by_command", "trimmed_by_python")
        self.line_of(patinate.InvalidInput, lambda: patinate.trim(self.work / "history", self.work / "x", every=0))

    def test_histories_are_taken_where_their_paths_are(self):
        opened = patinate.read_history(self.work / "history")
        in_memory = patinate.history_from_arrays(list(opened), opened.times, name=opened.name, time_unit=opened.time_unit, texel_size_mm=opened.texel_size_mm, controls={"thickness": opened.control("thickness")})
        in_memory.save(self.work / "taken")
        works = {"trim": lambda h, to: patinate.trim(h, to, every=2), "appearance": lambda h, to: patinate.appearance(h, to, metalness=1), "combine": lambda h, to: patinate.combine([h, self.work / "history"], to)}
        for name, work in works.items():
            for kind, subject, folder in (("opened", opened, "history"), ("memory", in_memory, "taken")):
                with self.subTest(name=name, kind=kind):
                    work(subject, self.work / f"{name}_{kind}")
                    work(self.work / folder, self.work / f"{name}_{kind}_by_path")
                    self.same_files(f"{name}_{kind}", f"{name}_{kind}_by_path")
        self.assertEqual(patinate.survey(opened), patinate.survey(self.work / "history"))
        self.assertIn("in memory only", self.line_of(patinate.InvalidInput, lambda: patinate.survey(in_memory)))
        for work in (*works.values(), lambda h, _: patinate.survey(h)):
            self.line_of(TypeError, lambda: work(7, self.work / "x"))

    def test_a_sample_half_way_is_the_mean_of_two_frames(self):
        history = gray_history()
        np.testing.assert_allclose(history.sample(0.5), np.full((5, 7, 3), 0.125), atol=1e-7)
        np.testing.assert_array_equal(history.sample(0.5, between="hold"), history.frame(0))
        np.testing.assert_array_equal(history.frame(-1), history.frame(2))

    def test_one_of_arrays_reads_back_from_its_folder_as_halves(self):
        rng = np.random.default_rng(1)
        colors = rng.random((2, 6, 4, 3), np.float32)
        control = rng.random((6, 4), np.float32)
        mask = np.ones((6, 4), bool)
        mask[0, 0] = False
        frame_mask = np.full((6, 4), 255, np.uint8)
        frame_mask[5, 3] = 0
        made = patinate.history_from_arrays(colors, [1, 3.5], name="x", time_unit="d", texel_size_mm=0.5, mask=mask,
                                            controls={"wet": (control, -2.0, 4.0, "1/mm")}, frame_masks=[None, frame_mask],
                                            maps={"height": np.full((6, 4), 2.0, np.float32)},
                                            frame_extras=[None, {"specular": np.full((6, 4, 2), 0.5, np.float32)}])
        made.save(self.work / "saved")
        read = patinate.read_history(self.work / "saved")
        np.testing.assert_array_equal(read.frame(1), half(colors[1]))
        np.testing.assert_array_equal(read.control("wet"), control)
        self.assertEqual(read.controls, {"wet": (-2.0, 4.0, "1/mm")})
        np.testing.assert_array_equal(read.mask() != 0, mask)
        np.testing.assert_array_equal(read.frame_mask(1) != 0, mask & (frame_mask != 0))
        np.testing.assert_array_equal(read.map("height"), np.full((6, 4), 2.0))
        np.testing.assert_array_equal(read.material_map("roughness", 3.5), np.full((6, 4), 0.5))
        self.assertEqual((read.name, read.time_unit, read.texel_size_mm, read.times.tolist()), ("x", "d", 0.5, [1, 3.5]))
        self.line_of(patinate.CannotComplete, lambda: made.save(self.work / "saved"))

    def test_values_of_another_type_and_paths_that_cannot_be_are_said(self):
        control = np.zeros((5, 7), np.float32)
        for wrong in (("low", 1.0, ""), (0.0, 1.0, 7)):
            self.line_of(TypeError, lambda: gray_history(controls={"wet": (control, *wrong)}))
        self.line_of(TypeError, lambda: gray_history(controls={7: control}))
        self.line_of(TypeError, lambda: patinate.read_channels("light.exr", [7]))
        for read in (patinate.read_history, patinate.read_mesh, patinate.read_transfer, patinate.survey):
            self.line_of(patinate.Error, lambda: read("x" * 5000))  # No file system has such a name.

    def test_a_file_may_have_a_name_that_is_no_utf8(self):
        name = os.fsdecode(b"urn_\xff.obj")
        shutil.copy(self.work / "urn/mesh.obj", self.work / name)
        expected = patinate.read_mesh(self.work / "urn/mesh.obj")
        for path in (self.work / name, str(self.work / name), os.fsencode(self.work / name)):
            np.testing.assert_array_equal(patinate.read_mesh(path).positions, expected.positions)
        self.assertIn("no_", self.line_of(patinate.IoError, lambda: patinate.read_mesh(self.work / os.fsdecode(b"no_\xff.obj"))))

    def test_any_layout_of_an_array_gives_the_same_values(self):
        colors = np.random.default_rng(2).random((2, 8, 6, 3))  # Doubles.
        expected = patinate.history_from_arrays(colors, [0, 1]).frame(1)
        turned = np.asfortranarray(colors)
        np.testing.assert_array_equal(patinate.history_from_arrays(turned, [0, 1]).frame(1), expected)
        np.testing.assert_array_equal(patinate.history_from_arrays(colors[:, ::-1][:, ::-1], [0, 1]).frame(1), expected)

    def test_what_must_not_change_cannot_be_written(self):
        mesh = patinate.read_mesh(self.work / "urn/mesh.obj")
        for view in (mesh.positions, mesh.triangles, gray_history().times, patinate.read_transfer(self.work / "aged").coordinates):
            with self.assertRaises(ValueError):
                view[0] = 1
        positions = mesh.positions
        copied = positions.copy()
        del mesh, view  # The view keeps what it is of alive.
        np.testing.assert_array_equal(positions, copied)

    def test_errors_are_one_line_that_names_what_is_wrong(self):
        self.assertIn("history.json", self.line_of(patinate.IoError, lambda: patinate.read_history(self.work / "urn")))
        self.assertTrue(issubclass(patinate.IoError, OSError))
        self.assertIn("frame 1", self.line_of(patinate.InvalidInput, lambda: patinate.history_from_arrays(np.zeros((2, 4, 4, 3), np.float32), [1, 1])))
        codes = np.zeros((2, 4, 4, 3), np.uint8)
        self.assertIn("linear_from_srgb", self.line_of(ValueError, lambda: patinate.history_from_arrays(codes, [0, 1])))
        self.assertIn("did you mean `texel_size_mm`?", self.line_of(TypeError, lambda: gray_history(texel_size_m=1)))
        self.assertIn("controls[x]", self.line_of(patinate.InvalidInput, lambda: gray_history(controls={"x": np.zeros(3, np.float32)})))
        self.assertIn("7", self.line_of(patinate.InvalidInput, lambda: gray_history().frame(7)))

    def test_all_codes_survive_linear_color(self):
        codes = np.arange(256, dtype=np.uint8).reshape(16, 16)
        np.testing.assert_array_equal(patinate.srgb_from_linear(patinate.linear_from_srgb(codes)), codes)


class Surface(PythonCase):
    def test_a_control_is_what_the_command_writes(self):
        self.run_patinate("control", "urn/mesh.obj", "--kind", "0.7*facing + 0.3*!accessibility", "--resolution", "64", "--unit", "mm", "-o", "mixed.exr")
        surface = patinate.Surface(patinate.read_mesh(self.work / "urn/mesh.obj"), resolution=64, mm_per_unit=1)
        control = surface.control("0.7*facing + 0.3*!accessibility")
        control.save(self.work / "ours.exr")
        covered = surface.coverage() != 0
        np.testing.assert_array_equal(control.values[covered], patinate.read_channels(self.work / "mixed.exr", ["Y"])[covered])
        np.testing.assert_array_equal(control.values, patinate.read_channels(self.work / "ours.exr", ["Y"]))

    def test_texels_of_a_plate_lie_where_its_uvs_say(self):
        positions = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])
        mesh = patinate.mesh_from_arrays(positions, [[0, 1, 2], [0, 2, 3]], uvs=positions[:, :2] / 10)
        surface = patinate.Surface(mesh, resolution=20, mm_per_unit=1)
        found = surface.positions()
        x, y = np.meshgrid(np.arange(20), np.arange(20))
        np.testing.assert_allclose(found[..., 0], (x + 0.5) / 2, atol=1e-5)
        np.testing.assert_allclose(found[..., 1], (20 - y - 0.5) / 2, atol=1e-5)
        np.testing.assert_allclose(surface.normals(), np.broadcast_to([0.0, 0, 1], (20, 20, 3)), atol=1e-6)
        self.assertAlmostEqual(surface.texel_size_mm, 0.5)

    def test_a_mesh_reads_back_from_its_file(self):
        mesh = patinate.read_mesh(self.work / "urn/mesh.obj").unwrap(resolution=64)
        mesh.save(self.work / "unwrapped.obj")
        read = patinate.read_mesh(self.work / "unwrapped.obj")
        np.testing.assert_array_equal(read.positions, mesh.positions)
        np.testing.assert_array_equal(read.uvs[read.uv_triangles], mesh.uvs[mesh.uv_triangles])

    def test_wrong_meshes_are_refused_by_row(self):
        self.assertIn("row 0 has the index 5", self.line_of(patinate.InvalidInput, lambda: patinate.mesh_from_arrays(np.zeros((3, 3)), [[0, 1, 5]])))
        self.assertIn("did you mean `facing`?", self.line_of(patinate.ParseError, lambda: patinate.Surface(
            patinate.read_mesh(self.work / "urn/mesh.obj"), resolution=16).control("facin")))


if __name__ == "__main__":
    main()
