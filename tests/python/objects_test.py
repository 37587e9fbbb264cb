#!/usr/bin/python3
"""Objects as Python programmers expect them: copied, pickled, shown in notebooks, described to editors."""
import copy
import importlib.util
import inspect
import os
import pathlib
import pickle
import struct
import unittest

import numpy as np
import patinate

from python_case import SCENE, PythonCase, main


def png_size(data):
    return struct.unpack(">II", data[16:24])


class Objects(PythonCase):
    @classmethod
    def setUpClass(cls):
        cls.history = patinate.read_history(cls.work / "history")
        cls.mesh = patinate.read_mesh(cls.work / "urn/mesh.obj")
        cls.surface = patinate.Surface(cls.mesh, resolution=48)
        cls.aged = patinate.read_transfer(cls.work / "aged")

    def test_what_never_changes_is_its_own_copy(self):
        for thing in (self.history, self.mesh, self.surface, self.aged, self.surface.control("facing")):
            self.assertIs(copy.copy(thing), thing)
            self.assertIs(copy.deepcopy([thing])[0], thing)

    def test_pickles_hold_the_same_values(self):
        mesh = pickle.loads(pickle.dumps(self.aged.mesh))
        for name in ("positions", "triangles", "uvs", "uv_triangles", "normals", "normal_triangles"):
            np.testing.assert_array_equal(getattr(mesh, name), getattr(self.aged.mesh, name), name)
        self.assertEqual(mesh.surfaces, self.aged.mesh.surfaces)
        control = self.surface.control("0.5*facing + 0.5*height")
        again = pickle.loads(pickle.dumps(control))
        np.testing.assert_array_equal(again.values, control.values)
        self.assertEqual((again.low, again.high, again.unit, again.notes), (control.low, control.high, control.unit, control.notes))

    def test_surfaces_are_pickled_with_their_texels(self):
        tiles = patinate.mesh_from_arrays([[0, 0, 0], [1, 0, 0], [2, 0, 0.5], [2, 1, 0.5], [1, 1, 0], [0, 1, 0]], [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]],
                                          uvs=[[0.05, 0.05], [0.95, 0.05], [0.95, 0.95], [0.05, 0.95], [1.05, 0.05], [1.95, 0.05], [1.95, 0.95], [1.05, 0.95]],
                                          uv_triangles=[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
        for surface in (self.surface, patinate.Surface(self.mesh, resolution=40, atlas="unwrap", mm_per_unit=10), patinate.Surface(tiles, resolution=32), self.aged.surface):
            again = pickle.loads(pickle.dumps(surface))
            self.assertEqual(again, surface)
            for name in ("positions", "normals", "coverage"):
                np.testing.assert_array_equal(getattr(again, name)(), getattr(surface, name)(), name)
            self.assertEqual((repr(again), again.texel_size_mm, again.notes), (repr(surface), surface.texel_size_mm, surface.notes))
        made = [patinate.transfer(self.history, surface, "facing").coordinates for surface in (self.surface, pickle.loads(pickle.dumps(self.surface)))]
        np.testing.assert_array_equal(*made)

    def test_equal_values_are_equal_objects(self):
        mesh = patinate.read_mesh(self.work / "urn/mesh.obj")
        pairs = ((mesh, self.mesh, self.aged.mesh), (patinate.Surface(mesh, resolution=48), self.surface, patinate.Surface(mesh, resolution=32)),
                 (self.surface.control("facing"), self.surface.control("facing"), self.surface.control("height")))
        for one, other, different in pairs:
            self.assertIsNot(one, other)
            self.assertEqual(one, other)
            self.assertEqual(hash(one), hash(other))
            self.assertNotEqual(one, different)
            self.assertNotEqual(one, 7)
            self.assertEqual(len({one, other, different}), 2)

    def test_a_pickled_folder_is_found_from_anywhere(self):
        here = pathlib.Path.cwd()
        try:
            os.chdir(self.work)
            kept = pickle.dumps((patinate.read_history("history"), patinate.read_transfer("aged")))
            os.chdir("/")
            history, aged = pickle.loads(kept)
        finally:
            os.chdir(here)
        np.testing.assert_array_equal(history.frame(-1), self.history.frame(-1))
        np.testing.assert_array_equal(aged.coordinates, self.aged.coordinates)

    def test_what_is_in_memory_only_is_not_pickled(self):
        made = patinate.history_from_arrays([self.history.frame(0)], [0.0])
        self.assertIsNone(made.folder)
        self.assertIn("save()", self.line_of(patinate.InvalidInput, lambda: pickle.dumps(made)))
        aged = patinate.transfer(self.history, self.surface, "facing")
        self.assertIsNone(aged.folder)
        self.assertIn("save()", self.line_of(patinate.InvalidInput, lambda: pickle.dumps(aged)))

    def test_an_aged_mesh_is_of_one_kind_wherever_it_comes_from(self):
        made = patinate.transfer(self.history, self.mesh, "facing", resolution=64)
        for name in dir(patinate.AgedMesh):
            if not name.startswith("_") and not callable(getattr(patinate.AgedMesh, name)):
                self.assertEqual(type(getattr(made, name)) in (type(None), str), type(getattr(self.aged, name)) in (type(None), str), name)
        self.assertEqual(made.controls, self.aged.controls)
        self.assertEqual(made.tiles, self.aged.tiles)
        np.testing.assert_array_equal(made.surface.coverage(), self.aged.surface.coverage())
        np.testing.assert_array_equal(made.surface.positions(), self.aged.surface.positions())
        self.assertIn("copy that folder", self.line_of(patinate.InvalidInput, lambda: self.aged.save(self.work / "copied")))

    def test_material_of_an_aged_mesh_is_the_same_in_memory_and_from_its_folder(self):
        metal = patinate.appearance(self.work / "history", self.work / "metal", metalness=1, roughness=0.35)
        made = patinate.transfer(metal, self.mesh, "facing", resolution=64)
        made.save(self.work / "metal_urn")
        read = patinate.read_transfer(self.work / "metal_urn")
        self.assertIn("metalness", metal.material_maps)
        for name in metal.material_maps:
            np.testing.assert_array_equal(made.material_map(name, 1), read.material_map(name, 1), name)
        view = {"time": 1, "width": 64, "height": 64, "samples": 1}
        shown = patinate.render(made, **view)
        np.testing.assert_array_equal(shown, patinate.render(self.work / "metal_urn", **view))
        self.assertFalse(np.array_equal(shown, patinate.render(made, maps="color", **view)))

    def test_a_report_is_a_dict_an_object_and_a_table(self):
        report = patinate.compare(self.history, self.aged, num_resamples=5)
        self.assertEqual(report.colors.figures.color_distribution, report["colors"]["figures"]["color_distribution"])
        self.assertIn("colors", dir(report))
        self.assertIn("there is no color; there are", self.line_of(AttributeError, lambda: report.color))
        self.assertEqual(pickle.loads(pickle.dumps(report.colors.figures)), report.colors.figures)
        rows = report.rows()
        row, = (row for row in rows if row["name"] == "color_distribution")
        self.assertEqual((row["part"], row["value"]), ("colors", report.colors.figures.color_distribution.value))
        self.assertEqual(len(rows), sum(len(section.figures) for section in report.values()))
        curve = next(iter(report.colors.curves.values()))
        self.assertEqual(len(curve.rows()), len(curve.x))
        self.assertIn("color_distribution", report._repr_html_())
        self.assertLess(len(repr(report.look)), 10000)  # Shapes of pictures, not their pixels.
        self.assertRegex(repr(self.surface), "Surface `.*`: 48 x 48 texels")

    def test_grades_are_a_row_a_time(self):
        graded = patinate.grade(self.history, edge_mm=0)
        times = {row["time"] for row in graded.rows()}
        self.assertEqual(times, set(graded[next(iter(graded))].times))
        self.assertEqual({key for row in graded.rows() for key in row}, {"part", "time", "name", "value", "low", "high", "grade"})

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "pandas is not installed")
    def test_tables_are_data_frames(self):
        figures = patinate.evaluate(self.aged, samples=100, audits=10)
        table = figures.to_dataframe()
        self.assertEqual(list(table["name"]), list(figures.figures))
        self.assertEqual(table.set_index("name").value["control_error_mean"], figures.figures.control_error_mean.value)

    def test_notebooks_show_histories_and_aged_meshes(self):
        width, height = png_size(self.history._repr_png_())
        self.assertGreater(width, 3 * height)
        width, height = png_size(self.aged._repr_png_())
        self.assertGreater(width, 2.5 * height)

    def test_signatures_begin_with_what_must_be_given(self):
        self.assertEqual(next(iter(inspect.signature(patinate.Surface).parameters)), "mesh")
        self.assertEqual(next(iter(inspect.signature(patinate.Simulation).parameters)), "scene")
        self.assertEqual(list(inspect.signature(patinate.AgedMesh.save).parameters)[:2], ["self", "folder"])
        self.assertEqual(list(inspect.signature(self.aged.save).parameters)[:1], ["folder"])
        self.assertEqual(list(inspect.signature(patinate.transfer).parameters)[:3], ["history", "destination", "controls"])


class Scenes(PythonCase):
    def test_a_scene_needs_no_files(self):
        mesh = patinate.read_mesh(self.work / "plate.obj")
        scene = {**SCENE, "objects": [{**SCENE["objects"][0], "mesh": "plate"}]}
        built = patinate.Simulation(scene, meshes={"plate": mesh})
        read = patinate.Simulation(self.work / "scene.json")
        for simulation in (built, read):
            simulation.step(count=10)
        self.assertEqual(built.snapshot(), read.snapshot())
        self.line_of(patinate.IoError, lambda: patinate.Simulation(scene, meshes={"plates": mesh}))
        self.line_of(TypeError, lambda: patinate.Simulation(scene, meshes={"plate": self.work / "plate.obj"}))

    def test_what_is_simulated_is_what_the_command_makes(self):
        self.run_patinate("simulate", "scene.json", "-o", "by_command", "--iterations", "20", "--seed", "3", "--controls", "last_hit")
        history = patinate.simulate(self.work / "scene.json", self.work / "by_python", iterations=20, seed=3, controls=["last_hit"])
        self.assertEqual(list(history.times), list(patinate.read_history(self.work / "by_command").times))
        self.same_files("by_python", "by_command")
        self.assertIn("did you mean", self.line_of(patinate.InvalidInput, lambda: patinate.simulate(self.work / "scene.json", self.work / "x", controls=["last_hits"])))
        self.assertIn("seed", self.line_of(patinate.InvalidInput, lambda: patinate.simulate(self.work / "scene.json", self.work / "x", seed=-3)))
        self.assertFalse((self.work / "x").exists())


if __name__ == "__main__":
    main()
