#!/usr/bin/python3
"""Ctrl-C, and other threads, while a long call works."""
import copy
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import patinate

from python_case import SCENE, PythonCase, main

PATIENCE = 0.05  # s from Ctrl-C to the exception.


def noise_history(size):
    rng = np.random.default_rng(1)
    return patinate.history_from_arrays(rng.random((2, size, size, 3), np.float32), [0, 1], controls={"x": rng.random((size, size), np.float32)})


class Interrupt(PythonCase):
    def seconds_to_end(self, work):
        """From Ctrl-C, half a second into the work, to its exception."""
        sent = []

        def interrupt():
            time.sleep(0.5)
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)
        helper = threading.Thread(target=interrupt)
        helper.start()
        with self.assertRaises(KeyboardInterrupt):
            work()
        ended = time.monotonic()
        helper.join()
        return ended - sent[0]

    def check(self, work):
        # On a machine that does other things too, the best of three says what the program does.
        self.assertLess(min(self.seconds_to_end(work) for _ in range(3)), PATIENCE)

    def test_a_transfer_ends_at_once(self):
        mesh = patinate.read_mesh(self.work / "urn/mesh.obj")
        self.check(lambda: patinate.transfer(noise_history(256), mesh, "facing", resolution=1024))

    def test_a_picture_and_a_movie_end_at_once_and_leave_nothing(self):
        self.check(lambda: patinate.render(self.work / "aged", self.work / "large.png", width=2048, height=2048, samples=16, occlusion_samples=4096))
        self.check(lambda: patinate.render(self.work / "aged", self.work / "long.gif", num_times=10000, width=64, height=64, samples=1))
        self.assertFalse([p for name in ("large.png", "long.gif") for p in self.work.glob(f"{name}*")])

    def test_an_export_of_thousands_of_images_ends_at_once(self):
        for output in ("many", "many_%05d.png"):
            self.check(lambda: patinate.export(self.work / "aged", self.work / output, num_times=10000))
        self.assertFalse((self.work / "many").exists())

    def check_lost_or_whole(self, simulation, start):
        """A state that was lost is refused by all but restore(); one that was not goes on."""
        try:
            done = simulation.iteration
        except patinate.InvalidInput as e:
            self.assertIn("restore() a snapshot", str(e))
            for work in (simulation.step, simulation.snapshot, simulation.compose):
                self.assertIn("restore() a snapshot", self.line_of(patinate.InvalidInput, work))
        else:
            simulation.step()
            self.assertEqual(simulation.iteration, done + 1)
        simulation.restore(start)
        self.assertEqual(simulation.snapshot(), start)
        simulation.step()
        self.assertEqual(simulation.iteration, 1)

    def test_a_simulation_ends_after_its_iteration_and_goes_on(self):
        simulation = patinate.Simulation(self.work / "scene.json", resolution=1024)
        start = simulation.snapshot()

        def work():
            simulation.restore(start)
            simulation.step(count=1000000)
        self.check(work)
        done = simulation.iteration
        simulation.step()
        self.assertEqual(simulation.iteration, done + 1)

    def test_a_stroke_that_was_interrupted_is_lost(self):
        scene = copy.deepcopy(SCENE)
        scene["emitters"].append({"name": "brush", "shape": "disk", "position": [0, 60, 20], "direction": [0, -0.3, -1], "size": 10, "speed": 300, "gammatons": 1000, "on": False})
        simulation = patinate.Simulation(scene, folder=self.work)
        start = simulation.snapshot()
        stroke = {"op": "paint", "target": "brush", "points": [[0, 60, 20, 1000000]]}

        def work():
            simulation.restore(start)
            simulation.apply(stroke)
        self.check(work)
        self.assertIn("restore() a snapshot", self.line_of(patinate.InvalidInput, lambda: simulation.iteration))
        self.check_lost_or_whole(simulation, start)

    def test_a_fit_whose_function_is_python_ends_at_once(self):
        self.check(lambda: patinate.fit(self.work / "scene.json", lambda history: time.sleep(0.02) or 1.0, {"/rules/1/rate": (0.1, 1)}, evaluations=1000000, tolerance=1e-300, starts=100))

    def write_large_mesh(self):
        """Takes a second to read, in which nothing looks whether it is to stop."""
        n = 500
        y, x = np.mgrid[:n, :n]
        first = (y * n + x + 1)[:-1, :-1].ravel()
        triangles = np.concatenate([np.stack([first, first + 1, first + n], 1), np.stack([first + 1, first + n + 1, first + n], 1)])
        path = self.work / "large.obj"
        with open(path, "w") as file:
            np.savetxt(file, np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), "v %d %d %d")
            np.savetxt(file, triangles, "f %d %d %d")
        return path, len(triangles)

    def test_what_does_not_look_is_left_behind_and_the_next_call_waits_for_it(self):
        path, num_triangles = self.write_large_mesh()
        self.check(lambda: [patinate.read_mesh(path) for _ in range(100)])
        self.assertEqual(len(patinate.read_mesh(path).triangles), num_triangles)
        copy_of_it = self.work / "copy.obj"
        mesh = patinate.read_mesh(path)
        self.check(lambda: [mesh.save(copy_of_it) for _ in range(100)])
        self.assertEqual(len(patinate.read_mesh(copy_of_it).triangles), num_triangles)  # Whole, whichever of them ended last.

    def test_a_program_that_leaves_work_behind_ends_as_python_does(self):
        path, _ = self.write_large_mesh()
        work = f"import patinate, signal, threading; threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start(); [patinate.read_mesh({str(path)!r}) for _ in range(100)]"
        ended = subprocess.run([sys.executable, "-c", work], capture_output=True, text=True, timeout=100, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
        self.assertEqual(ended.returncode, -signal.SIGINT, ended.stderr)
        self.assertTrue(ended.stderr.endswith("KeyboardInterrupt\n"), ended.stderr)

    def test_others_run_meanwhile(self):
        mesh = patinate.read_mesh(self.work / "urn/mesh.obj")
        worker = threading.Thread(target=lambda: patinate.transfer(noise_history(128), mesh, "facing", resolution=512))
        worker.start()
        turns = 0
        while worker.is_alive():
            turns += 1
            time.sleep(0.001)
        self.assertGreater(turns, 20)  # With the lock held there would be none.


if __name__ == "__main__":
    main()
