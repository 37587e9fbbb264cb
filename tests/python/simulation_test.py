#!/usr/bin/python3
"""Simulations in Python."""
import copy
import threading

import numpy as np
import patinate

from python_case import SCENE, PythonCase, half, main


class Simulation(PythonCase):
    def setUp(self):
        self.simulation = patinate.Simulation(self.work / "scene.json")

    def test_frames_maps_and_amounts_are_the_commands(self):
        if not (self.work / "simulated").exists():
            self.run_patinate("simulate", "scene.json", "-o", "simulated")
        history = patinate.read_history(self.work / "simulated")
        for i in range(len(history)):
            if i > 0:
                self.simulation.step(count=10)
            np.testing.assert_array_equal(half(self.simulation.compose()["color"]), history.frame(i))
            self.assertAlmostEqual(self.simulation.time, history.times[i])
        hits, unit = self.simulation.parameter_map("hits")
        low, high, expected_unit = history.controls["hits"]
        covered = self.simulation.coverage() != 0
        np.testing.assert_allclose(history.control("hits")[covered] * (high - low) + low, np.clip(hits, low, high)[covered], atol=1e-4)
        self.assertEqual(unit, expected_unit)

    def test_what_is_recomposed_is_the_commands(self):
        if not (self.work / "simulated").exists():
            self.run_patinate("simulate", "scene.json", "-o", "simulated")
        self.run_patinate("simulate", "restyle", "simulated", "-o", "by_command", "--set", "patina.strength=0.25")
        history = patinate.recompose(self.work / "simulated", self.work / "by_python", changes={"patina.strength": 0.25})
        self.assertEqual((self.work / "by_python/simulation.json").read_bytes(), (self.work / "by_command/simulation.json").read_bytes())
        np.testing.assert_array_equal(history.frame(-1), patinate.read_history(self.work / "by_command").frame(-1))
        self.assertIn("did you mean", self.line_of(patinate.InvalidInput, lambda: patinate.recompose(self.work / "simulated", self.work / "x", changes={"patina.strenth": 1})))
        self.line_of(TypeError, lambda: patinate.recompose(self.work / "simulated", self.work / "x", changes={"patina.strength": "much"}))
        self.assertFalse((self.work / "x").exists())

    def test_mass_balances_exactly(self):
        self.simulation.step(count=20)
        for material, account in self.simulation.ledger().items():
            self.assertEqual(account["imbalance"], 0.0, material)
        self.assertGreater(self.simulation.ledger()["water"]["emitted"], 0)

    def test_a_snapshot_leads_to_the_same_state(self):
        self.simulation.step(count=5)
        kept = self.simulation.snapshot()
        self.simulation.step(count=5)
        end = self.simulation.snapshot()
        self.simulation.restore(kept)
        self.assertEqual(self.simulation.iteration, 5)
        self.simulation.compose()  # Looking changes nothing.
        self.simulation.step(count=5, num_threads=1)
        self.assertEqual(self.simulation.snapshot(), end)
        self.line_of(patinate.InvalidInput, lambda: self.simulation.restore(kept[:40]))

    def test_an_event_now_is_an_event_of_the_scene(self):
        scene = copy.deepcopy(SCENE)
        event = {"op": "switch", "target": "rain", "on": False}
        scene["events"] = [{"iteration": 3, **event}]
        planned = patinate.Simulation(scene, folder=self.work)
        planned.step(count=6)
        self.simulation.step(count=3)
        self.simulation.apply(event)
        self.simulation.step(count=3)
        np.testing.assert_array_equal(self.simulation.amounts("patina"), planned.amounts("patina"))
        self.assertEqual(self.simulation.ledger(), planned.ledger())
        self.line_of(patinate.InvalidInput, lambda: self.simulation.apply({"op": "switch", "target": "snow", "on": False}))
        # What is refused before it changes anything loses nothing.
        self.assertEqual(self.simulation.iteration, 6)
        self.line_of(patinate.InvalidInput, lambda: self.simulation.paint("rain", [0, 0, 0]))
        self.assertEqual(self.simulation.ledger(), planned.ledger())

    def test_a_stroke_paints_as_its_event_does_and_takes_no_time(self):
        scene = copy.deepcopy(SCENE)
        scene["emitters"].append({"name": "brush", "shape": "disk", "position": [0, 60, 20], "direction": [0, -0.3, -1], "size": 10, "speed": 300,
                                  "gammatons": 100, "carries": {"water": 1}, "on": False})
        by_event, by_call = (patinate.Simulation(scene, folder=self.work) for _ in range(2))
        by_event.apply({"op": "paint", "target": "brush", "points": [[0, 60, 20, 3]]})
        for position in ([0, 60, 20], (0.0, 60.0, 20.0), np.array([0, 60, 20])):
            by_call.paint("brush", position)
        self.assertEqual(by_call.snapshot(), by_event.snapshot())
        self.assertEqual(by_call.iteration, 0)
        self.assertGreater(by_call.amounts("water").sum(), 0)
        for wrong in ([0, 0], [0, 0, float("nan")], "here"):
            self.line_of(patinate.InvalidInput, lambda: by_call.paint("brush", wrong))
        self.assertEqual(by_call.snapshot(), by_event.snapshot())

    def test_amounts_read_back(self):
        amounts = np.zeros((32, 32), np.float32)
        amounts[10, 12] = 0.5
        self.simulation.set_amounts("patina", amounts)
        self.assertEqual(self.simulation.amounts("patina")[10, 12], 0.5)
        self.assertIn("water, metal, patina", self.line_of(patinate.InvalidInput, lambda: self.simulation.amounts("gold")))
        self.line_of(TypeError, lambda: patinate.Simulation(self.work / "scene.json", parameter_maps=[7]))

    def test_another_thread_runs_while_it_works_and_may_not_touch_it(self):
        big = patinate.Simulation(self.work / "scene.json", resolution=512)
        refused = []
        worker = threading.Thread(target=lambda: big.step(count=400))
        worker.start()
        while worker.is_alive():
            try:
                big.iteration
            except patinate.InvalidInput as e:
                refused.append(str(e))
        self.assertTrue(refused and all("another thread" in text for text in refused))
        self.assertEqual(big.iteration, 400)

    def test_a_seed_below_the_scenes_is_refused(self):
        self.assertIn("seed: -7", self.line_of(patinate.InvalidInput, lambda: patinate.Simulation(self.work / "scene.json", seed=-7)))
        patinate.Simulation(self.work / "scene.json", seed=-1)

    def test_what_is_no_json_is_said_and_ctrl_c_is_not_taken_for_it(self):
        circle = {}
        circle["self"] = circle
        for wrong in (10**400, float("nan"), {1, 2}, circle, "\ud800"):
            self.assertIn("is no JSON", self.line_of(patinate.InvalidInput, lambda: patinate.Simulation({**SCENE, "seed": wrong}, folder=self.work)))

        class Interrupted(dict):
            def items(self):
                raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.simulation.apply(Interrupted(op="switch"))

    def test_a_scene_that_is_wrong_names_the_pointer(self):
        scene = copy.deepcopy(SCENE)
        scene["behavior"]["slider"] = 7
        self.assertIn("/behavior/slider", self.line_of(patinate.InputError, lambda: patinate.Simulation(scene, folder=self.work)))

    def test_what_was_only_stepped_is_saved_as_the_command_makes_it(self):
        simulation = patinate.Simulation(self.work / "scene.json")
        simulation.step(count=12)
        simulation.save(self.work / "saved")
        self.run_patinate("simulate", "scene.json", "--iterations", "12", "--history-every", "12", "-o", "commanded")
        self.same_files("saved", "commanded")
        self.assertEqual(simulation.iteration, 12)

    def test_what_was_done_by_hand_is_saved_and_goes_on(self):
        scene = self.json_of("scene.json")
        plate = patinate.read_mesh(self.work / "plate.obj")
        simulation = patinate.Simulation(scene | {"objects": [scene["objects"][0] | {"mesh": "a plate"}]}, meshes={"a plate": plate})
        simulation.step(count=3)
        simulation.set_amounts("patina", np.where(simulation.coverage(), 0.7, 0).astype(np.float32))
        color = simulation.compose()["color"]
        simulation.save(self.work / "by_hand")
        kept = patinate.read_history(self.work / "by_hand/history")
        self.assertEqual(len(kept), 2)
        np.testing.assert_array_equal(kept.frame(-1), half(color))
        self.assertIn("force=True", self.line_of(patinate.CannotComplete, lambda: (simulation.step(), simulation.save(self.work / "by_hand"))))
        simulation.save(self.work / "by_hand", force=True)
        self.run_patinate("simulate", "restyle", "by_hand", "--set", "patina.strength=0.9", "-o", "stronger")
        self.assertEqual(patinate.render(self.work / "by_hand", time=kept.times[-1], width=32, height=32, samples=1).shape, (32, 32, 3))
        patinate.Simulation(scene, folder=self.work).save(self.work / "at_once")
        self.assertEqual(len(patinate.read_history(self.work / "at_once/history")), 1)

    def test_what_was_saved_goes_on_as_if_it_had_not_been_interrupted(self):
        whole = patinate.Simulation(self.work / "scene.json")
        whole.step(count=10)
        whole.save(self.work / "half")
        again = patinate.Simulation(self.work / "half")
        self.assertEqual((again.iteration, again.num_iterations, again.time), (10, whole.num_iterations, whole.time))
        for simulation in (whole, again):
            simulation.step(count=7)
        self.assertEqual(again.snapshot(), whole.snapshot())
        np.testing.assert_array_equal(again.parameter_map("hits")[0], whole.parameter_map("hits")[0])
        for name, simulation in (("again", again), ("whole", whole)):
            simulation.save(self.work / name)
        self.same_files("again", "whole")
        again.save(self.work / "half", force=True)  # Also in place of what it came from.
        self.same_files("half", "whole")
        # So does what the command made.
        self.run_patinate("simulate", "scene.json", "--iterations", "10", "-o", "by_program")
        goes_on = patinate.Simulation(self.work / "by_program/simulation.json")
        goes_on.step(count=7)
        self.assertEqual(goes_on.snapshot(), whole.snapshot())

    def test_what_was_saved_keeps_maps_meshes_and_what_was_done_by_hand(self):
        scene = self.json_of("scene.json")
        plate = patinate.read_mesh(self.work / "plate.obj")
        scene["run"].pop("controls")
        made = patinate.Simulation(scene | {"objects": [scene["objects"][0] | {"mesh": "a plate"}]}, meshes={"a plate": plate}, parameter_maps=["last_hit", "water.deposited"], resolution=48, seed=9)
        made.step(count=3)
        made.set_amounts("patina", np.where(made.coverage(), 0.25, 0).astype(np.float32))
        made.save(self.work / "kept")
        again = patinate.Simulation(self.work / "kept")
        np.testing.assert_array_equal(again.amounts("patina"), made.amounts("patina"))
        for simulation in (made, again):
            simulation.step(count=4)
        self.assertEqual(again.snapshot(), made.snapshot())
        np.testing.assert_array_equal(again.parameter_map("water.deposited")[0], made.parameter_map("water.deposited")[0])
        self.assertEqual(again.coverage().shape, (48, 48))
        again.save(self.work / "kept_again")

    def test_what_cannot_go_on_says_why(self):
        self.simulation.step(count=2)
        self.simulation.save(self.work / "whole_folder")
        self.assertIn("leave the keywords out", self.line_of(patinate.InvalidInput, lambda: patinate.Simulation(self.work / "whole_folder", seed=3)))
        patinate.recompose(self.work / "whole_folder", self.work / "recomposed", changes={"patina.strength": 0.25})
        self.assertIn("holds no state.bin", self.line_of(patinate.IoError, lambda: patinate.Simulation(self.work / "recomposed")))
        scene, = (self.work / "whole_folder/scene").glob("*.json")
        scene.write_text(scene.read_text() + " ")
        self.assertIn("has changed", self.line_of(patinate.IoError, lambda: patinate.Simulation(self.work / "whole_folder")))

    def test_a_scene_that_is_no_file_is_run_to_its_end(self):
        scene = self.json_of("scene.json")
        plate = patinate.read_mesh(self.work / "plate.obj")
        in_memory = scene | {"objects": [scene["objects"][0] | {"mesh": "a plate"}]}
        history = patinate.simulate(in_memory, self.work / "of_dict", meshes={"a plate": plate}, iterations=10)
        by_folder = patinate.simulate(scene, self.work / "of_folder", folder=self.work, iterations=10)
        by_file = patinate.simulate(self.work / "scene.json", self.work / "of_file", iterations=10)
        for other in (by_folder, by_file):
            np.testing.assert_array_equal(history.frame(-1), other.frame(-1))
        before = (self.work / "of_dict/state.bin").stat().st_ino
        patinate.simulate(in_memory, self.work / "of_dict", meshes={"a plate": plate}, iterations=10)  # Up to date.
        self.assertEqual((self.work / "of_dict/state.bin").stat().st_ino, before)
        wrong = copy.deepcopy(scene)
        wrong["behavior"]["slider"] = 7
        line = self.line_of(patinate.InputError, lambda: patinate.simulate(wrong, self.work / "x", folder=self.work))
        self.assertIn("/behavior/slider", line)
        self.assertNotIn("patinate_scene", line)
        self.assertFalse((self.work / "x").exists())

    def test_meshes_in_place_of_a_files_own_are_saved(self):
        plate = patinate.read_mesh(self.work / "plate.obj")
        half_as_large = patinate.mesh_from_arrays(plate.positions / 2, plate.triangles, uvs=plate.uvs, uv_triangles=plate.uv_triangles)
        simulation = patinate.Simulation(self.work / "scene.json", meshes={"plate.obj": half_as_large})
        simulation.save(self.work / "half_as_large")
        again = patinate.Simulation(self.work / "half_as_large")
        np.testing.assert_array_equal(again.mesh.positions, simulation.mesh.positions)
        for one in (again, simulation):
            one.step()
        self.assertEqual(again.snapshot(), simulation.snapshot())


if __name__ == "__main__":
    main()
