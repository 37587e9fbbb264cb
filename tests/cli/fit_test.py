#!/usr/bin/env python3
"""A scene fitted to a history, as a user would. Usage: fit_test.py PATINATE [unittest arguments]"""
import hashlib
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from small_scene import PLATE, PLATE_SCENE
from studio_client import kill_when_there_is

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_fit_"))

SCENE = {**PLATE_SCENE, "run": {"iterations": 30, "history_every": 5, "controls": ["hits"]}}
TRUTH = {"/rules/0/rate": 2.0, "/appearance/patina/strength": 1.2}
VARY = ["--vary", "/rules/0/rate=0.1:20:log", "--vary", "/appearance/patina/strength=0.1:3"]
SHORT = ["--evaluations", "13", "--appearance-evaluations", "7", "--scan", "2", "--seeds", "1"]


def patinate(*arguments, **more):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True, timeout=600, **more)


def tree_hash(folder):
    """Of every file but run.json, which tells of the run."""
    digest = hashlib.sha256()
    for path in sorted(p for p in (WORK / folder).rglob("*") if p.is_file() and p.name != "run.json"):
        digest.update(str(path.relative_to(WORK / folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def changed(**parts):
    scene = json.loads(json.dumps(SCENE))
    scene.update(parts)
    return scene


def setUpModule():
    (WORK / "scenes").mkdir()
    (WORK / "scenes/plate.obj").write_text(PLATE)
    (WORK / "scenes/start.json").write_text(json.dumps(SCENE))
    truth = changed(rules=[{"name": "patina", "rate": TRUTH["/rules/0/rate"]}, SCENE["rules"][1]])
    truth["appearance"]["patina"]["strength"] = TRUTH["/appearance/patina/strength"]
    (WORK / "scenes/truth.json").write_text(json.dumps(truth))
    result = patinate("simulate", "scenes/truth.json", "-o", "captured")
    assert result.returncode == 0, result.stderr


def tearDownModule():
    shutil.rmtree(WORK)


class Rank(unittest.TestCase):
    """Which of two rule sets foretells frames that neither search saw."""

    @classmethod
    def setUpClass(cls):
        # The capture was made by `start` with other numbers; on `idle` nothing ages, whatever its rate.
        idle = changed(rules=[{"name": "nothing", "driver": "0*water", "rate": 1, "products": {"patina": 1}, "reactants": {}}, SCENE["rules"][1]])
        (WORK / "scenes/idle.json").write_text(json.dumps(idle))
        for model in ("start", "idle"):
            for until in cls.times():
                result = patinate("fit", f"scenes/{model}.json", "captured", *VARY, *SHORT[:-1], 3, "--until", until, "-o", f"{model}_{until}")
                assert result.returncode == 0, result.stderr

    @classmethod
    def times(cls):
        times = [f["time"] for f in json.loads((WORK / "captured/history/history.json").read_text())["frames"]]
        return times[len(times) // 2], times[-2]

    def test_the_model_that_ages_is_nearer_than_the_one_that_does_not(self):
        first, second = self.times()
        result = patinate("fit", "rank", f"idle_{first}", f"start_{first}", "-o", "ranked", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual([m["model"] for m in report["models"]], ["start", "idle"])
        self.assertGreater(report["models"][1]["behind"]["low"], 0)
        self.assertIn("of the models start is the nearest", result.stderr)
        held_out = json.loads((WORK / f"start_{first}/report.json").read_text())["held_out"]
        self.assertAlmostEqual(report["models"][0]["held_out"]["value"], sum(held_out["other_seeds"]) / 3, places=6)
        self.assertAlmostEqual(report["last_frame"], held_out["last_frame"], places=6)
        for file in ("report.html", "report.json", "ranking.csv"):
            self.assertTrue((WORK / "ranked" / file).is_file(), file)
        page = (WORK / "ranked/report.html").read_text()
        self.assertEqual(page.count("src=\"data:image/png"), 3)  # Captured, and by each of the two.
        for said in (">captured, 6 h<", ">start, 6 h: ", ">idle, 6 h: "):
            self.assertIn(said, page)
        numbers = page[page.index("The numbers of the models"):page.index("Case by case")]
        for name in json.loads((WORK / f"start_{first}/report.json").read_text())["parameters"]:
            self.assertIn(name["name"], numbers)
        self.assertIn("<td>rule patina: rate</td><td>per h</td><td>start</td>", numbers.replace("\n", ""))
        varied = report["models"][0]["fits"][0]["varied"]
        self.assertEqual([(v["number"], v["unit"]) for v in varied], [("/rules/0/rate", "per h"), ("/appearance/patina/strength", "per layer")])
        self.assertEqual([v["best"] for v in varied], [p["best"] for p in json.loads((WORK / f"start_{first}/report.json").read_text())["parameters"]])
        self.assertIn(f"truth until {first:g} h</th>", page)
        rows = (WORK / "ranked/ranking.csv").read_text().splitlines()
        self.assertEqual([row.split(",")[0] for row in rows], ["model", "start", "idle"])
        self.assertIn("up to date", patinate("fit", "rank", f"idle_{first}", f"start_{first}", "-o", "ranked").stderr)

    def test_folds_over_time_are_ranked_by_their_means(self):
        first, second = self.times()
        result = patinate("fit", "rank", *(f"{m}_{t}" for m in ("start", "idle") for t in (first, second)), "-o", "folds", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual([c["until"] for c in report["cases"]], [first, second])
        self.assertEqual(len(report["models"][0]["fits"]), 2)

    def test_what_cannot_be_ranked_is_named(self):
        first, second = self.times()
        for arguments, said in (((f"start_{first}",), "two fits"), ((f"start_{first}", f"idle_{second}"), "has no fit to"), ((f"start_{first}", "captured"), "is no fit"), ((f"start_{first}", f"start_{first}"), "are both of")):
            result = patinate("fit", "rank", *arguments, "-o", "wrong")
            self.assertNotEqual(result.returncode, 0)
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
            self.assertIn(said, result.stderr)
            self.assertFalse((WORK / "wrong").exists())


class Fit(unittest.TestCase):
    def test_finds_known_parameters_again_and_says_which_one_does_nothing(self):
        # No metal is ever added to the plate, so its strength does nothing.
        scene = changed()
        scene["appearance"]["metal"] = {"strength": 1.0}
        (WORK / "scenes/three.json").write_text(json.dumps(scene))
        result = patinate("fit", "scenes/three.json", "captured", *VARY, "--vary", "/appearance/metal/strength=0.1:4", "--evaluations", 61, "--appearance-evaluations", 25, "-o", "three", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        found = {p["pointer"]: p for p in json.loads(result.stdout)["parameters"]}
        for pointer, value in TRUTH.items():
            self.assertAlmostEqual(found[pointer]["best"] / value, 1, delta=0.05, msg=pointer)
            self.assertEqual(found[pointer]["determination"], "determined", pointer)
            self.assertTrue(found[pointer]["interval"][0] <= value <= found[pointer]["interval"][1], found[pointer])
        self.assertEqual(found["/appearance/metal/strength"]["determination"], "without_effect")
        self.assertEqual([p["name"] for p in found.values()], ["rule patina: rate", "appearance of patina: strength", "appearance of metal: strength"])
        self.assertRegex(result.stderr, "rule patina: rate: 0.1 -> [0-9.]+ per h; determined")
        self.assertIn("no figure changes", result.stderr)
        self.assertLess(json.loads(result.stdout)["objective"]["after"], 0.1 * json.loads(result.stdout)["objective"]["before"])

    def test_the_page_says_where_the_model_lacks_colors_and_by_which_control(self):
        self.assertEqual(patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "paged").returncode, 0)
        page = (WORK / "paged/report.html").read_text()
        for said in ("Where the model lacks colors", "misfit, before", "misfit, after", "Rate of change by hits"):
            self.assertIn(said, page)
        self.assertTrue(list((WORK / "paged/curves").glob("*hits*.svg")))
        # Only a scene that begins with another color is off before anything has aged, whatever its rates are.
        begins = "initial surface, which the varied parameters do not change"
        self.assertNotIn(begins, page)
        gray = changed()
        gray["presets"] = {"gray": {"composition": {"metal": 1.0}, "color": [0.2, 0.2, 0.2]}}
        gray["objects"][0]["preset"] = "gray"
        (WORK / "scenes/gray.json").write_text(json.dumps(gray))
        self.assertEqual(patinate("fit", "scenes/gray.json", "captured", *VARY, *SHORT, "-o", "gray").returncode, 0)
        self.assertIn(begins, (WORK / "gray/report.html").read_text())

    def test_the_best_scene_runs_from_its_folder_and_gives_the_history_after(self):
        self.assertEqual(patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "run").returncode, 0)
        result = patinate("simulate", "run/scene.json", "-o", "again")
        self.assertEqual(result.returncode, 0, result.stderr)
        for k in (0, 3, 6):
            self.assertEqual((WORK / f"again/history/frames/{k:04d}.exr").read_bytes(), (WORK / f"run/after/frames/{k:04d}.exr").read_bytes())
        self.assertEqual(patinate("validate", "run").returncode, 0)
        self.assertRegex(patinate("info", "run").stdout, "/rules/0/rate: *0.1 -> ")
        page = (WORK / "run/report.html").read_text()
        self.assertFalse("http:" in page)
        self.assertIn("<svg", page)
        self.assertIn("<td>rule patina: rate</td><td>per h</td>", page.replace("\n", ""))
        self.assertIn("<td>appearance of patina: strength</td><td>/appearance/patina/strength</td>", page.replace("\n", ""))
        rows = (WORK / "run/evaluations.csv").read_text().splitlines()
        self.assertEqual(rows[0], "evaluation,appearance,/rules/0/rate [per h],/appearance/patina/strength [per layer],objective,color_distribution [Delta E 1976],problem")
        self.assertGreater(len(rows), 80)
        self.assertIn("up to date", patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "run").stderr)

    def test_same_bytes_for_any_number_of_threads_and_after_kills(self):
        for threads in (1, 2):
            self.assertEqual(patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", f"out{threads}", "--threads", threads).returncode, 0)
        for finished in ("initial", "evaluation-00004", "scan-0-0"):
            process = subprocess.Popen([PATINATE, "fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "out3"], cwd=WORK, stderr=subprocess.DEVNULL)
            kill_when_there_is(WORK / "out3.partial/.job/done" / finished, process)
        self.assertEqual(patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "out3").returncode, 0)
        self.assertEqual(tree_hash("out2"), tree_hash("out1"))
        self.assertEqual(tree_hash("out3"), tree_hash("out1"))

    def test_generations_handed_to_workers_give_the_same_bytes_whoever_is_killed(self):
        command = ["fit", "scenes/start.json", "captured", *VARY, *SHORT]
        self.assertEqual(patinate(*command, "-o", "alone").returncode, 0)
        for workers in (1, 3):
            with self.subTest(workers=workers):
                name = f"workers{workers}"
                plan = patinate("cluster", "plan", *command, "-o", name, "--json")
                self.assertEqual(plan.returncode, 0, plan.stderr)
                (WORK / f"{name}.json").write_text(plan.stdout)
                self.head(name, workers, generations=2)  # A worker is killed, and after two generations the head.
                self.assertNotEqual(patinate("cluster", "join", f"{name}.json").returncode, 0)
                finished = {p: p.stat().st_ino for p in (WORK / f"{name}.items").glob("*-*/.job/item")}
                self.assertGreater(len(finished), 3)
                self.head(name, workers)
                self.assertEqual({p: p.stat().st_ino for p in finished}, finished)  # Nothing was done again.
                joined = patinate("cluster", "join", f"{name}.json")
                self.assertEqual(joined.returncode, 0, joined.stderr)
                self.assertEqual(tree_hash(name), tree_hash("alone"))

    def head(self, name, workers, generations=None):
        """Hands out what is left, generation by generation: items that wait for the same ones. With `generations` it dies after so many, having killed a worker."""
        plan = json.loads(patinate("cluster", "plan", *json.loads((WORK / f"{name}.json").read_text())["command"], "--json").stdout)
        waves = {}
        for item in plan["items"]:
            if not item["is_finished"]:
                waves.setdefault(item["waits_for"], []).append(item["number"])
        for wave in list(waves.values())[:generations]:
            portions = [wave[k::workers] for k in range(workers)]
            running = [subprocess.Popen([PATINATE, "cluster", "run", f"{name}.json", "--items", ",".join(map(str, portion))], cwd=WORK, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                       for portion in portions if portion]
            if generations:
                time.sleep(0.1)
                running[0].send_signal(signal.SIGKILL)
                running[0].wait()
                running[0] = subprocess.Popen([PATINATE, "cluster", "run", f"{name}.json", "--items", ",".join(map(str, portions[0]))], cwd=WORK, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.assertEqual([worker.wait(timeout=300) for worker in running], [0] * len(running))

    def test_a_search_that_its_budget_ended_says_so_in_verdict_console_and_exit_status(self):
        result = patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "--require-converged", "-o", "ended", "--json")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("not converged", [line for line in result.stderr.splitlines() if "error" in line][0])
        report = json.loads((WORK / "ended/report.json").read_text())
        self.assertFalse(report["evaluations"]["converged"])
        for p in report["parameters"]:
            self.assertIn("(not converged)", p["verdict"])
        self.assertIn("Not converged", (WORK / "ended/report.html").read_text())
        result = patinate("fit", "scenes/start.json", "captured", *VARY, *SHORT, "-o", "ended")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("not converged: 13 evaluations", result.stderr)
        result = patinate("fit", "scenes/start.json", "captured", *VARY, "--require-converged", "--evaluations", 181, "-o", "whole")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("not converged", result.stderr)

    def test_ranges_and_figures_come_from_a_file_too(self):
        (WORK / "parameters.json").write_text(json.dumps({
            "format": "patinate.parameters", "version": 1, "vary": [{"pointer": "/appearance/patina/strength", "low": 0.1, "high": 3}],
            "objective": {"mean_color": 1, "rate_by_control": 0.5}}))
        result = patinate("fit", "scenes/truth.json", "captured", "--parameters", "parameters.json", "--scan", 2, "--seeds", 0, "-o", "from_file", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertAlmostEqual(report["parameters"][0]["best"], 1.2, delta=0.02)
        self.assertEqual(report["evaluations"]["agings"], 1)
        self.assertEqual([t["figure"] for t in report["objective"]["terms"]], ["mean_color", "rate_by_control"])

    def test_several_histories_share_numbers_and_have_others_of_their_own(self):
        for name, seed, water in (("open", 7, 0.8), ("shaded", 8, 0.3)):
            scene = json.loads((WORK / "scenes/truth.json").read_text())
            scene["seed"] = seed
            scene["emitters"][0]["carries"]["water"] = water
            (WORK / f"scenes/{name}.json").write_text(json.dumps(scene))
            self.assertEqual(patinate("simulate", f"scenes/{name}.json", "-o", name).returncode, 0)
        rate, water = "/rules/0/rate=0.1:20:log", "/emitters/0/carries/water=0.1:3:log"
        command = ["fit", "scenes/start.json", "open", "shaded", "--vary", rate, "--own", water, "--evaluations", 15, "--scan", 2, "--seeds", 3]
        result = patinate(*command, "-o", "both", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, "open: .* before, .* after")
        self.assertIn("emitter rain: carries water (shaded): 0.8 -> ", result.stderr)
        report = json.loads((WORK / "both/report.json").read_text())
        self.assertEqual([(p["pointer"], p.get("capture")) for p in report["parameters"]], [("/rules/0/rate", None), ("/emitters/0/carries/water", "open"), ("/emitters/0/carries/water", "shaded")])
        self.assertAlmostEqual(report["objective"]["after"], sum(c["after"] for c in report["captures"]) / 2)
        self.assertIn(" simulations of each capture and ", (WORK / "both/report.html").read_text())
        self.assertEqual(patinate("validate", "both").returncode, 0)
        self.assertRegex(patinate("info", "both").stdout, r"carries/water \(shaded\): *0.8 -> ")
        # Each scene runs from there and gives its history, chance included.
        self.assertEqual(patinate("simulate", "both/scene_2.json", "-o", "shaded_again").returncode, 0)
        self.assertEqual((WORK / "shaded_again/history/frames/0006.exr").read_bytes(), (WORK / "both/after_2/frames/0006.exr").read_bytes())
        # The same from a file; and with a scene for one of them, which begins with its own water.
        (WORK / "own.json").write_text(json.dumps({"format": "patinate.parameters", "version": 1, "vary": [
            {"pointer": "/rules/0/rate", "low": 0.1, "high": 20, "scale": "log"}, {"pointer": "/emitters/0/carries/water", "low": 0.1, "high": 3, "scale": "log", "own": True}]}))
        plan = patinate("cluster", "plan", "fit", "scenes/start.json", "open", "shaded", "--parameters", "own.json", *command[8:], "-o", "both", "--json")
        self.assertEqual(json.loads(plan.stdout)["key"], report["key"], plan.stderr)
        result = patinate(*command, "--scene-of", "shaded=scenes/shaded.json", "--until", 4, "-o", "treated", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([p["initial"] for p in json.loads(result.stdout)["parameters"]], [0.1, 0.8, 0.3])
        self.assertIn("frames after 4 h (held out): ", result.stderr)
        self.assertRegex(result.stderr, "shaded, held out: .* before, .* after; holding the last fitted frame: ")
        # Fits of several are ranked among themselves: their case is all of their histories.
        self.assertEqual(patinate(*command, "--until", 4, "-o", "other").returncode, 0)
        result = patinate("fit", "rank", "treated", "other", "-o", "no_ranking")
        self.assertIn("are both of start and open and shaded until 4 h", result.stderr)
        # By scenes of two names they are, with pictures of each history: captured, and by each of the two.
        shutil.copy(WORK / "scenes/start.json", WORK / "scenes/second.json")
        self.assertEqual(patinate(command[0], "scenes/second.json", *command[2:], "--until", 4, "-o", "second").returncode, 0)
        result = patinate("fit", "rank", "treated", "second", "-o", "joint_ranking")
        self.assertEqual(result.returncode, 0, result.stderr)
        page = (WORK / "joint_ranking/report.html").read_text()
        self.assertEqual(page.count("src=\"data:image/png"), 2 * (1 + 2))
        for said in (">open, captured, 6 h<", ">shaded, captured, 6 h<", ">second, 6 h: "):
            self.assertIn(said, page)

    def test_the_page_says_where_a_range_ends_what_was_found(self):
        # The capture was made with a rate of 2, beyond the range; strengths within theirs.
        result = patinate("fit", "scenes/start.json", "captured", "--vary", "/rules/0/rate=0.1:0.5", "--evaluations", 61, "--seeds", 1, "--scan", 2, "-o", "narrow")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertGreater(json.loads((WORK / "narrow/report.json").read_text())["parameters"][0]["best"], 0.1 + 0.99 * (0.5 - 0.1))
        self.assertIn("The best value of rule patina: rate lies at the end of its range", (WORK / "narrow/report.html").read_text())

    def test_bad_input_is_one_line(self):
        (WORK / "bad.json").write_text(json.dumps({"format": "patinate.parameters", "version": 1, "vary": [{"pointer": "/rules/0/rate", "low": 2, "high": 1}]}))
        start, alpha = "scenes/start.json", "/rules/0/rate=0.1:20:log"
        for arguments, code, words in (
                ((start, "captured"), 2, "--vary"),
                ((start, "captured", "--vary", "/rules/0/alfa=0.1:1"), 2, "/rules/0/alfa: is not in scenes/start.json"),
                ((start, "captured", "--vary", "/emitters/0/carries/watr=0.1:1"), 2, "did you mean `/emitters/0/carries/water`"),
                ((start, "captured", "--vary", "/emitters/0/name=0.1:1"), 2, "expected a number"),
                ((start, "captured", "--vary", "/seed=1:10"), 2, "cannot be varied"),
                ((start, "captured", "--vary", alpha, "--vary", alpha), 2, "is given twice"),
                ((start, "captured", "--vary", "/rules/0/rate=1:0.5"), 2, "upside down"),
                ((start, "captured", "--vary", "/rules/0/rate=0.1:none"), 2, "two numbers"),
                ((start, "captured", "--vary", "/behavior/slider=0:2"), 3, "/behavior/slider: found 2"),
                ((start, "captured", "--vary", "/exchange/rates/water=-1:0.5"), 3, "/exchange/rates/water: found -1"),
                ((start, "captured", "--vary", "/rules/0/rate=0.5:1"), 3, "starts at 0.1"),
                ((start, "captured", "--vary", alpha, "--evaluations", 5), 2, "expected at least 13"),
                ((start, "captured", "--vary", alpha, "--objective", "color"), 2, "expected one of color_distribution"),
                ((start, "captured", "--vary", alpha, "--objective", "covered", "--objective", "covered=2"), 2, "is given twice"),
                ((start, "captured", "--own", alpha), 2, "--own: /rules/0/rate is to be each history's own, and there is one"),
                ((start, "captured", "captured", "--vary", alpha), 2, "is given twice"),
                ((start, "captured", "--vary", alpha, "--scene-of", "captures=scenes/start.json"), 2, "did you mean `captured`"),
                ((start, "captured", "--own", "/rules/0/rate=1"), 2, "--own: found"),
                ((start, "captured", "--parameters", "bad.json"), 3, "/vary/0: the range 2 to 1 is upside down"),
                ((start, "scenes/plate.obj", "--vary", alpha), 3, "is no history or transfer"),
                ((start, "nowhere", "--vary", alpha), 3, "nowhere")):
            result = patinate("fit", *arguments, "-o", "bad")
            with self.subTest(arguments=arguments):
                self.assertEqual(result.returncode, code, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertEqual(len([line for line in result.stderr.splitlines() if "error" in line]), 1, result.stderr)
                self.assertFalse((WORK / "bad").exists())


if __name__ == "__main__":
    unittest.main()
