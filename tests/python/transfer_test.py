#!/usr/bin/python3
"""Transfers, lookups and evaluations in Python."""
import json
import subprocess

import numpy as np
import patinate

from python_case import PythonCase, half, main


class Transfer(PythonCase):
    @classmethod
    def setUpClass(cls):
        cls.history = patinate.read_history(cls.work / "history")
        cls.mesh = patinate.read_mesh(cls.work / "urn/mesh.obj")
        cls.aged = patinate.transfer(cls.history, cls.mesh, "facing", resolution=64)

    def test_coordinates_and_figures_are_the_commands(self):
        folder = patinate.read_transfer(self.work / "aged")
        np.testing.assert_array_equal(self.aged.coordinates, folder.coordinates)
        self.assertEqual(self.aged.energy, folder.energy)
        np.testing.assert_array_equal(self.aged.coverage, folder.coverage)

    def test_what_is_saved_is_what_the_command_writes(self):
        (self.work / "saved").mkdir()
        self.aged.save(self.work / "saved/aged")
        for file in sorted(p.relative_to(self.work / "aged") for p in (self.work / "aged").rglob("*") if p.is_file() and p.name not in ("run.json", "transfer.json")):
            self.assertEqual((self.work / "saved/aged" / file).read_bytes(), (self.work / "aged" / file).read_bytes(), file)
        written, command = (json.loads((self.work / folder / "transfer.json").read_text()) for folder in ("saved/aged", "aged"))
        self.assertEqual(written["history"].pop("path"), "../../" + command["history"].pop("path").removeprefix("../"))
        self.assertEqual(written, command)
        self.aged.save(self.work / "saved/aged")  # It is there.
        other = patinate.transfer(self.history, self.mesh, "facing", resolution=64, seed=2)
        self.assertIn("force=True", self.line_of(patinate.CannotComplete, lambda: other.save(self.work / "saved/aged")))
        other.save(self.work / "saved/aged", force=True)
        np.testing.assert_array_equal(patinate.read_transfer(self.work / "saved/aged").coordinates, other.coordinates)

    def test_a_transfer_of_units_subpixels_and_a_surface_is_saved_as_the_command_writes_it(self):
        self.run_patinate("transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "48", "--unit", "cm", "--texel-size", "3", "--flow", "uv", "--seed", "5", "-o", "in_cm")
        surface = patinate.Surface(self.mesh, resolution=48, mm_per_unit=10, texel_size=3)
        patinate.transfer(self.history, surface, "facing", flow="uv", seed=5).save(self.work / "in_cm_saved")
        for file in ("transfer.json", "coordinates.exr", "control.exr", "mesh.obj", "job.json"):
            self.assertEqual((self.work / "in_cm_saved" / file).read_bytes(), (self.work / "in_cm" / file).read_bytes(), file)

    def test_a_transfer_of_a_history_in_memory_says_how_it_can_be_saved(self):
        frames = [self.history.frame(i) for i in range(len(self.history))]
        history = patinate.history_from_arrays(frames, self.history.times, controls={"thickness": self.history.control("thickness")})
        aged = patinate.transfer(history, self.mesh, "facing", resolution=32)
        self.assertIn("save it", self.line_of(patinate.InvalidInput, lambda: aged.save(self.work / "from_memory")))

    def test_several_times_are_one_array(self):
        times = [0.0, 10.0, 22.5]
        for aged in (self.aged, patinate.read_transfer(self.work / "aged")):
            textures = aged.texture(times)
            self.assertEqual(textures.shape, (3, 64, 64, 3))
            for time, texture in zip(times, textures):
                np.testing.assert_array_equal(texture, aged.texture(time))
            self.assertEqual(aged.texture([]).size, 0)
            self.assertIn("64 x 64 texels", repr(aged))

    def test_a_history_is_a_sequence_of_frames(self):
        for index, frame in enumerate(self.history):
            np.testing.assert_array_equal(frame, self.history.frame(index))
        self.assertEqual(index, len(self.history) - 1)
        np.testing.assert_array_equal(self.history[-1], self.history.frame(-1))
        self.assertRaises(IndexError, lambda: self.history[len(self.history)])

    def test_masks_are_bool(self):
        for mask in (self.aged.coverage, self.history.mask(), self.history.frame_mask(0), patinate.read_transfer(self.work / "aged").coverage, patinate.Surface(self.mesh, resolution=32).coverage()):
            self.assertEqual(mask.dtype, bool)
        self.assertEqual(self.aged.texture(0)[self.aged.coverage].shape, (self.aged.coverage.sum(), 3))

    def test_a_texture_is_what_lookup_writes(self):
        time = float(self.history.times.mean())
        self.run_patinate("texture", "aged", "--time", time, "-o", "mean.exr")
        written = patinate.read_color(self.work / "mean.exr")
        folder = patinate.read_transfer(self.work / "aged")
        np.testing.assert_array_equal(half(folder.texture(time)), written)
        covered = self.aged.coverage != 0
        np.testing.assert_array_equal(half(self.aged.texture(time))[covered], written[covered])

    def test_a_texel_that_covers_many_pixels_shows_their_mean_as_the_folder_does(self):
        self.run_patinate("transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "24", "--unit", "m", "--texel-size", "1", "-o", "coarse")
        aged = patinate.transfer(self.history, self.mesh, "facing", resolution=24, mm_per_unit=1000, texel_size=1)
        folder = patinate.read_transfer(self.work / "coarse")
        np.testing.assert_array_equal(aged.coordinates, folder.coordinates)
        covered = aged.coverage != 0
        at = aged.coordinates[covered].astype(int)
        texture = aged.texture(self.history.times[-1])[covered]
        np.testing.assert_array_equal(texture, folder.texture(self.history.times[-1])[covered])
        self.assertFalse(np.array_equal(texture, self.history.frame(-1)[at[:, 1], at[:, 0]]))

    def test_notes_are_what_the_command_says(self):
        said = subprocess.run([self.patinate, "transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "noted"], cwd=self.work, capture_output=True, text=True, timeout=300)
        self.assertEqual(said.returncode, 0, said.stderr)
        lines = [line.replace("--unit", "mm_per_unit").replace("--", "") for line in said.stderr.splitlines()]
        self.assertTrue(self.aged.notes)
        for note in self.aged.notes:
            self.assertIn(note, lines)
        self.assertIn("states no length unit", self.aged.notes[0])
        read = patinate.read_transfer(self.work / "noted").notes
        self.assertLessEqual(set(read), set(self.aged.notes))  # A folder does not hold what was said of its controls.
        self.assertIn(self.aged.notes[0], read)
        known = patinate.transfer(self.history, self.mesh, "facing", resolution=64, mm_per_unit=10)
        self.assertFalse([note for note in known.notes if "length unit" in note])
        flat = np.where(self.aged.coverage, 0.5, 0).astype(np.float32)
        even = patinate.transfer(self.history, patinate.Surface(self.mesh, resolution=64), {"thickness": flat})
        self.assertTrue([note for note in even.notes if "this control has no effect" in note], even.notes)

    def test_material_maps_at_several_times_have_the_times_first(self):
        metal = patinate.appearance(self.history, self.work / "metal_for_maps", metalness=1, roughness=0.35)
        aged = patinate.transfer(metal, self.mesh, "facing", resolution=32)
        maps = aged.material_map("roughness", [0, 10])
        self.assertEqual(maps.shape, (2, 32, 32))
        np.testing.assert_array_equal(maps[1], aged.material_map("roughness", 10))
        self.assertEqual(aged.material_map("tint" if "tint" in metal.material_maps else "metalness", [0]).shape[0], 1)
        self.line_of(patinate.InvalidInput, lambda: aged.material_map("roughness", [[0.0, 1.0]]))
        self.line_of(TypeError, lambda: aged.material_map("roughness", "soon"))

    def test_textures_of_tiles_lie_over_the_sheet_or_are_given_one_by_one(self):
        (self.work / "tiles.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0.5\nv 2 1 0.5\nv 1 1 0\nv 0 1 0\nvt 0.05 0.05\nvt 0.95 0.05\nvt 0.95 0.95\nvt 0.05 0.95\nvt 1.05 0.05\nvt 1.95 0.05\nvt 1.95 0.95\nvt 1.05 0.95\n"
                                             "f 1/1 2/2 5/3 6/4\nf 2/5 3/6 4/7 5/8\n")
        aged = patinate.transfer(self.history, patinate.read_mesh(self.work / "tiles.obj"), "facing", resolution=32)
        self.assertEqual(aged.tiles, ["1001", "1002"])
        last = self.history.times[-1]
        sheet = aged.texture(last)
        self.assertEqual(sheet.shape[:2], aged.coverage.shape)
        tiles = [aged.texture(last, tile=name) for name in aged.tiles]
        self.assertEqual([tile.shape for tile in tiles], [(32, 32, 3)] * 2)
        self.assertEqual(aged.texture([0, last], tile="1002").shape, (2, 32, 32, 3))
        parts = [sheet[y:y + 32, x:x + 32] for y in range(sheet.shape[0] - 31) for x in range(sheet.shape[1] - 31)]  # Margins lie around tiles.
        self.assertTrue(all(any(np.array_equal(part, tile) for part in parts) for tile in tiles))
        self.assertIn("`1001`, `1002`", self.line_of(patinate.InvalidInput, lambda: aged.texture(0, tile="1003")))

    def test_a_time_map_gives_each_texel_its_own_time(self):
        times = np.linspace(self.history.times[0], self.history.times[-1], 64 * 64, dtype=np.float32).reshape(64, 64)
        texture = self.aged.texture(times)
        for y, x in ((20, 30), (40, 12), (33, 33)):
            if self.aged.coverage[y, x]:
                expected = self.aged.texture(float(times[y, x]))[y, x]
                np.testing.assert_allclose(texture[y, x], expected, atol=1e-6)
        np.testing.assert_array_equal(patinate.gather_at_times(self.history, self.aged.coordinates, times)[self.aged.coverage != 0],
                                      texture[self.aged.coverage != 0])

    def test_coordinates_beside_the_history_are_refused(self):
        times = np.zeros((64, 64), np.float32)
        for wrong in (self.history.frame(0).shape[1], 1e9, -5, np.nan):
            coordinates = np.array(self.aged.coordinates)
            coordinates[7, 9] = wrong, 0
            self.assertRegex(self.line_of(patinate.InvalidInput, lambda: patinate.gather_at_times(self.history, coordinates, times)), r"(9, 7)|NaN|finite")

    def test_a_held_time_changes_at_a_frames_very_time(self):
        last = self.history.times[-1]
        before = np.nextafter(last, 0)  # The last frame's time when it is rounded to a float.
        covered = self.aged.coverage != 0
        self.assertFalse(np.array_equal(self.aged.texture(self.history.times[-2])[covered], self.aged.texture(last)[covered]))
        for transfer in (self.aged, patinate.read_transfer(self.work / "aged")):
            np.testing.assert_array_equal(transfer.texture(last, between="hold")[covered], transfer.texture(last)[covered])
            np.testing.assert_array_equal(transfer.texture(before, between="hold")[covered], transfer.texture(self.history.times[-2])[covered])

    def test_times_may_be_nested_lists_of_any_numbers(self):
        last = self.history.times[-1]
        for times in ([[float(last)] * 64] * 64, [[int(np.ceil(last))] * 64] * 64):
            np.testing.assert_array_equal(self.aged.texture(times)[self.aged.coverage != 0], self.aged.texture(last)[self.aged.coverage != 0])
        self.line_of(patinate.InvalidInput, lambda: self.aged.texture([[1.0, 2.0]]))
        for wrong in ("soon", None):
            self.line_of(TypeError, lambda: self.aged.texture(wrong))

    def test_a_map_of_ones_own_guides_as_its_expression_does(self):
        surface = patinate.Surface(self.mesh, resolution=64)
        control = surface.control("facing")
        name = list(self.history.controls)[0]
        by_map = patinate.transfer(self.history, surface, {name: control})
        by_text = patinate.transfer(self.history, surface, {name: "facing"})
        np.testing.assert_array_equal(by_map.coordinates, by_text.coordinates)
        by_array = patinate.transfer(self.history, surface, {name: np.array(control.values)})
        self.assertEqual(by_array.coordinates.shape, (64, 64, 2))

    def test_the_number_of_threads_changes_nothing(self):
        one = patinate.transfer(self.history, self.mesh, "facing", resolution=64, num_threads=1)
        np.testing.assert_array_equal(one.coordinates, self.aged.coordinates)

    def test_progress_rises_and_ends_at_one(self):
        seen = []
        patinate.transfer(self.history, self.mesh, "facing", resolution=64, on_progress=seen.append)
        self.assertEqual(seen, sorted(seen))
        self.assertEqual(seen[-1], 1.0)

    def test_what_progress_raises_ends_the_work(self):
        def refuse(_):
            raise KeyError("enough")
        with self.assertRaises(KeyError):
            patinate.transfer(self.history, self.mesh, "facing", resolution=64, on_progress=refuse)

    def test_an_evaluation_has_the_figures_of_the_command(self):
        self.run_patinate("evaluate", "aged", "--samples", "500", "--audits", "50", "-o", "evaluation")
        expected = {f["name"]: f.get("value") for f in self.json_of("evaluation", "evaluation.json")["maps"][0]["figures"]}
        figures = patinate.evaluate(self.work / "aged", samples=500, audits=50)["figures"]
        self.assertEqual(patinate.evaluate(patinate.read_transfer(self.work / "aged"), samples=500, audits=50)["figures"], figures)
        self.assertEqual({name: f["value"] for name, f in figures.items()}, expected)
        # Directions in memory are rounded as a folder keeps them; what is left is rounding.
        for name, figure in patinate.evaluate(self.aged, samples=500, audits=50)["figures"].items():
            if expected[name] is None:
                self.assertIsNone(figure["value"], name)
            else:
                self.assertAlmostEqual(figure["value"], expected[name], delta=0.01 * abs(expected[name]), msg=name)

    def test_errors_say_what_there_is(self):
        self.assertIn("facing", self.line_of(patinate.ParseError, lambda: patinate.transfer(self.history, self.mesh, "facin", resolution=16)))
        self.line_of(patinate.InvalidInput, lambda: patinate.transfer(self.history, self.mesh, "nothing=facing", resolution=16))
        self.assertIn("[16, 16384]", self.line_of(patinate.InvalidInput, lambda: patinate.transfer(self.history, self.mesh, "facing", resolution=4)))
        self.assertIn("the surface has", self.line_of(patinate.InvalidInput, lambda: patinate.transfer(
            self.history, self.mesh, {list(self.history.controls)[0]: np.zeros((8, 8), np.float32)}, resolution=16)))
        self.line_of(TypeError, lambda: patinate.transfer(self.history, 7, "facing"))
        for controls in ([7], {7: "facing"}):
            self.line_of(TypeError, lambda: patinate.transfer(self.history, self.mesh, controls))


if __name__ == "__main__":
    main()
