#!/usr/bin/python3
"""Comparisons, factorizations and fits in Python."""
import json
import sys
import time
import types
import unittest.mock

import numpy as np
import patinate

from python_case import PLATE, PLATE_SCENE, PythonCase, main


def ramp_history(rate, offset, size=12, num_frames=12):
    """color = base + gain s(rate t - offset), with s a smooth step over [0, 10]; rate and offset H x W."""
    times = np.linspace(0, 10, num_frames)
    frames = []
    for t in times:
        clock = np.clip((rate * t - offset) / 10, 0, 1)
        step = clock * clock * (3 - 2 * clock)
        frames.append((0.2 + step[..., None] * np.array([0.5, 0.3, 0.1])).astype(np.float32))
    return patinate.history_from_arrays(np.stack(frames), times)


class Grade(PythonCase):
    def test_a_square_of_rust_has_its_area_and_grades(self):
        # Gray paint of 100 x 80; in the second photograph 20 x 20 of it, 5 %, are rust.
        frames = np.full((2, 80, 100, 3), 0.5, np.float32)
        frames[1, 30:50, 40:60] = (0.2, 0.075, 0.03)
        history = patinate.history_from_arrays(frames, [0.0, 100.0])
        sample = patinate.grade(history, edge_mm=0)["sample"]
        value, low, high = sample["figures"]["rusted_percent"][1]
        self.assertAlmostEqual(value, 5.0, delta=0.05)
        self.assertTrue(low < 5.0 < high)
        self.assertEqual((sample["grades"]["ri"], sample["grades"]["d610"]), (["0", "4"], ["10", "4"]))
        self.assertEqual(list(sample["spots"]), [0, 1])
        left = np.zeros((80, 100), bool)
        left[:, :50] = True
        halves = patinate.grade(history, regions={"left": left, "right": ~left})
        self.assertAlmostEqual(halves["left"]["figures"]["rusted_percent"][1, 0], 5.0, delta=0.2)
        with self.assertRaisesRegex(patinate.InvalidInput, "lies over region left"):
            patinate.grade(history, regions={"left": left, "more": left})
        with self.assertRaisesRegex(patinate.InvalidInput, "scribe"):
            patinate.grade(history, scribe=(1, 2, 3))

    def test_a_blister_is_graded_where_heights_are_known_and_goes_on(self):
        # A cap of 0.2 mm whose area grows by 1 % of the panel each 100 h, from the first photograph on.
        y, x = np.mgrid[:100, :100]
        hours = np.arange(0, 800, 100.0)
        heights = [0.2 * np.clip(1 - ((x - 50) ** 2 + (y - 50) ** 2) * np.pi / (100 * max(t / 100, 1e-9)), 0, None) for t in hours]
        frames = np.full((len(hours), 100, 100, 3), 0.5, np.float32)
        history = patinate.history_from_arrays(frames, hours, time_unit="h", texel_size_mm=0.1, frame_extras=[{"height": h.astype(np.float32)} for h in heights])
        sample = patinate.grade(history, edge_mm=0, forecast=1000)["sample"]
        value, low, high = sample["figures"]["blistered_percent"][-1]
        self.assertTrue(low <= 7.0 <= high, (low, value, high))
        self.assertEqual(sample["grades"]["flaking"][-1], "0")
        self.assertAlmostEqual(sample["forecasts"]["blistered_percent"][-1, 0], 10.0, delta=1.0)
        self.assertEqual(sample["forecast_times"][-1], 1000.0)
        # Without heights nothing is said of blisters.
        flat = patinate.history_from_arrays(frames[:2], [0.0, 100.0], texel_size_mm=0.1)
        self.assertNotIn("blistered_percent", patinate.grade(flat, edge_mm=0)["sample"]["figures"])


class Compare(PythonCase):
    def test_figures_are_the_commands(self):
        self.run_patinate("ingest", "capture", "--deflicker", "-o", "deflickered")
        self.run_patinate("history", "compare", "history", "deflickered", "--num-resamples", "5", "-o", "report")
        report = self.json_of("report", "report.json")
        expected = {f["name"]: f.get("value") for f in report["figures"]}
        made = patinate.compare(patinate.read_history(self.work / "history"), self.work / "deflickered", num_resamples=5)
        self.assertEqual({name: f.get("value") for s in made.values() for name, f in s["figures"].items()}, expected)

    def test_a_history_differs_from_itself_by_nothing(self):
        history = patinate.read_history(self.work / "history")
        made = patinate.compare(history, history, num_resamples=0)
        for name, figure in made["places"]["figures"].items():
            if "delta_e" in name or "ciede" in name:
                self.assertEqual(figure["value"], 0, name)
        self.assertTrue(all(c["x"].ndim == 1 for s in made.values() for c in s["curves"].values()))


class Factorize(PythonCase):
    def test_rates_come_back(self):
        y, x = np.mgrid[0:12, 0:12]
        rate = 0.8 + 0.4 * x / 11
        made = patinate.factorize(ramp_history(rate, np.zeros((12, 12))))[0]
        # Only ratios mean something: the clock's own scale is the median rate's.
        found = made["rate"] / np.median(made["rate"])
        np.testing.assert_allclose(found, rate / np.median(rate), atol=0.02)  # 3 % of a rate: the spline's knots.
        self.assertTrue((made["status"] == 3).all())
        self.assertEqual(made["curve"].shape, (257, 3))


RATE = {"/rules/1/rate": (0.1, 1)}


class Fit(PythonCase):
    def test_a_ranking_is_the_commands(self):
        (self.work / "rank").mkdir()
        (self.work / "rank/plate.obj").write_text(PLATE)
        for name, rate in (("slow", 0.5), ("fast", 5.0)):
            (self.work / f"rank/{name}.json").write_text(json.dumps({**PLATE_SCENE, "rules": [{"name": "patina", "rate": rate}, PLATE_SCENE["rules"][1]], "run": {"iterations": 30, "history_every": 5}}))
        self.run_patinate("simulate", "rank/slow.json", "-o", "rank/captured")
        for name in ("slow", "fast"):
            self.run_patinate("fit", f"rank/{name}.json", "rank/captured", "--vary", "/appearance/patina/strength=0.1:3", "--until", "4", "--evaluations", "13", "--scan", "0", "--seeds", "2", "-o", f"rank/fit_{name}")
        fits = [str(self.work / f"rank/fit_{name}") for name in ("slow", "fast")]
        self.run_patinate("fit", "rank", *fits, "-o", "rank/ranked")
        expected = self.json_of("rank/ranked", "report.json")
        self.assertEqual(patinate.rank(fits), {name: expected[name] for name in ("unit", "models", "cases", "last_frame", "verdict")})
        self.line_of(patinate.InvalidInput, lambda: patinate.rank(fits[:1]))

    def test_progress_ends_at_one_also_when_it_converges_early(self):
        seen = []
        patinate.fit(self.work / "scene.json", lambda _: 1.0, RATE, evaluations=23, on_progress=seen.append)  # A rest that makes no generation.
        self.assertEqual(seen, sorted(seen))
        self.assertEqual(seen[-1], 1.0)

    def test_a_bar_is_closed_however_the_work_ends(self):
        bars = []

        class Tqdm:
            def __init__(self, **_):
                self.n, self.is_closed = 0, False
                bars.append(self)

            def update(self, by):
                self.n += by

            def close(self):
                self.is_closed = True

        def refuse(_):
            if bars:
                raise ZeroDivisionError("not today")
            time.sleep(0.02)  # Longer than between two looks at the progress.
            return 1.0
        auto = types.ModuleType("tqdm.auto")
        auto.tqdm = Tqdm
        with unittest.mock.patch.dict(sys.modules, {"tqdm": types.ModuleType("tqdm"), "tqdm.auto": auto}):
            patinate.fit(self.work / "scene.json", lambda _: 1.0, RATE, evaluations=20, on_progress=True)
            self.assertEqual([bar.is_closed for bar in bars], [True])
            self.assertAlmostEqual(bars[0].n, 100)
            bars.clear()
            with self.assertRaises(ZeroDivisionError):
                patinate.fit(self.work / "scene.json", refuse, RATE, evaluations=1000, on_progress=True)
            self.assertEqual([bar.is_closed for bar in bars], [True])

    def test_a_scene_and_a_history_in_memory_are_fitted_as_their_files(self):
        scene = json.loads((self.work / "scene.json").read_text())
        history = patinate.simulate(self.work / "scene.json", self.work / "to_fit", iterations=10)
        plate = patinate.read_mesh(self.work / "plate.obj")
        in_memory = scene | {"objects": [scene["objects"][0] | {"mesh": "a plate"}]}
        def found(given, objective, **more):
            return patinate.fit(given, objective, RATE, evaluations=10, figures={"mean_color": 1}, **more)
        expected = found(self.work / "scene.json", history)
        self.assertEqual(found(in_memory, self.work / "to_fit", meshes={"a plate": plate}), expected)
        self.assertEqual(found(scene, [history], folder=self.work), expected)
        self.assertIn("/rules/9/rate", self.line_of(patinate.InputError, lambda: patinate.fit(scene, history, {"/rules/9/rate": (0.1, 1)}, folder=self.work)))

    def test_values_of_another_type_are_type_errors(self):
        scene = self.work / "scene.json"
        for vary in ({"/rules/1/rate": ("low", 1)}, {"/rules/1/rate": (0, None)}, {"/rules/1/rate": (0, 1, 2)}, {7: (0, 1)}):
            self.line_of(TypeError, lambda: patinate.fit(scene, lambda _: 0.0, vary))
        self.assertIn("str", self.line_of(TypeError, lambda: patinate.fit(scene, lambda _: "much", RATE, evaluations=20)))
        for figures in (7, {7: 1.0}, {"ciede2000": "all"}):
            self.line_of(TypeError, lambda: patinate.fit(self.work / "scene.json", lambda _: 0.0, {"/rules/1/rate": (0.1, 1)}, figures=figures))

    def test_what_the_function_raises_comes_through(self):
        def refuse(_):
            raise ZeroDivisionError("not today")
        with self.assertRaises(ZeroDivisionError):
            patinate.fit(self.work / "scene.json", refuse, RATE, evaluations=20)

    def test_a_rule_of_a_scene_is_found_by_a_function_and_by_a_history(self):
        self.run_patinate("simulate", "scene.json", "-o", "truth")
        truth = patinate.read_history(self.work / "truth")
        scene = self.json_of("scene.json")
        scene["rules"][0] = {"name": "patina", "rate": 0.2}
        (self.work / "start.json").write_text(json.dumps(scene))
        last = truth.frame(-1)
        vary = {"/rules/0/rate": (0.05, 20, "log")}
        by_function = patinate.fit(self.work / "start.json", lambda h: float(np.abs(h.frame(-1) - last).mean()), vary, evaluations=40)
        by_history = patinate.fit(self.work / "start.json", truth, vary, evaluations=40, figures={"ciede2000": 1})
        for made in (by_function, by_history):
            self.assertEqual(made["evaluations"][0][0]["/rules/0/rate"], 0.2)
            self.assertLess(made["objective"], 0.2 * made["evaluations"][0][1])
        self.assertAlmostEqual(np.log(by_function["values"]["/rules/0/rate"] / by_history["values"]["/rules/0/rate"]), 0, delta=0.1)

    def test_several_histories_are_fitted_at_once_as_the_command_does(self):
        scene = self.json_of("scene.json")
        for k, rate in enumerate((1.0, 4.0)):
            (self.work / f"true{k}.json").write_text(json.dumps({**scene, "seed": 20 + k, "rules": [{"name": "patina", "rate": rate}, *scene["rules"][1:]]}))
            self.run_patinate("simulate", f"true{k}.json", "-o", f"true{k}")
        histories = [patinate.read_history(self.work / f"true{k}") for k in (0, 1)]
        own = {"/rules/0/rate": (0.05, 20, "log")}
        found = patinate.fit(self.work / "scene.json", histories, {}, own=own, evaluations=60, figures={"mean_color": 1}, seed=3)
        first, last = found["values"]["/rules/0/rate"]
        self.assertLess(first, last)
        self.run_patinate("fit", "scene.json", "true0", "true1", "--own", "/rules/0/rate=0.05:20:log", "--objective", "mean_color", "--evaluations", "60", "--scan", "0", "--seeds", "1", "-o", "joint")
        self.assertAlmostEqual(self.json_of("joint/report.json")["objective"]["before"], found["evaluations"][0][1], places=9)
        with self.assertRaisesRegex(patinate.InvalidInput, "own: is each history's own"):
            patinate.fit(self.work / "scene.json", histories[:1], {}, own=own)
        for objective in (7, [histories[0], 7], []):
            self.line_of(TypeError, lambda: patinate.fit(self.work / "scene.json", objective, own))


if __name__ == "__main__":
    main()
