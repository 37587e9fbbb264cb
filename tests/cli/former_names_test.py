#!/usr/bin/env python3
"""Commands go by former names too: the same output, and on stderr one line that says the present name. Usage: former_names_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from small_scene import PLATE, PLATE_SCENE, make_small_scene

PATINATE = str(pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate").resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_former_"))
VARY = ["--vary", "/rules/0/rate=0.1:10:log"]

# Arguments of each command that had a name of its own; OUT is its output, where it has one.
COMMANDS = {
    "accessibility": ("control accessibility", ["urn/mesh.obj", "--resolution", "32", "--share-rays", "16", "-o", "OUT"]),
    "explain": ("control explain", ["aged", "urn/mesh.obj", "--resolution", "64", "--channel", "luminance", "--kind", "facing", "--num-samples", "1000", "--shuffles", "199",
                                    "--resamples", "50", "-o", "OUT"]),
    "combine": ("history combine", ["history", "history", "-o", "OUT"]),
    "trim": ("history trim", ["history", "--every", "2", "-o", "OUT"]),
    "appearance": ("history material", ["history", "--metalness", "1", "-o", "OUT"]),
    "library": ("history library", ["--json"]),
    "compare": ("history compare", ["history", "history", "--num-resamples", "5", "-o", "OUT"]),
    "factorize": ("history factorize", ["history", "--num-intervals", "8", "--num-training", "24", "-o", "OUT"]),
    "field": ("fit field", ["plate.json", "captured", *VARY, "--places", "equal", "--levels", "3", "--sweeps", "1", "--waves", "1", "-o", "OUT"]),
    "rank": ("fit rank", ["fit_1", "fit_2", "-o", "OUT"]),
    "recompose": ("simulate restyle", ["captured", "-o", "OUT"]),
    "plan": ("cluster plan", ["trim", "history", "--every", "2", "-o", "planned", "--json"]),
    "run": ("cluster run", ["plan.json"]),
    "join": ("cluster join", ["plan.json"]),
    "completion": ("help completion", ["bash"]),
    "devices": ("help devices", ["--json"]),
}

OTHERS = {"lookup": "texture", "relief": "height-change", "history appearance": "history material", "simulate recompose": "simulate restyle"}


def run(*arguments):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=SHARED, capture_output=True, text=True)


def succeeds(*arguments):
    result = run(*arguments)
    if result.returncode:
        raise AssertionError(f"{arguments}: {result.stderr}")
    return result.stdout


def setUpModule():
    unittest.addModuleCleanup(shutil.rmtree, SHARED)
    make_small_scene(PATINATE, SHARED)
    (SHARED / "plate.obj").write_text(PLATE)
    (SHARED / "plate.json").write_text(json.dumps({**PLATE_SCENE, "run": {"iterations": 8, "history_every": 2}}))
    succeeds("simulate", "plate.json", "-o", "captured")
    for model in ("1", "2"):
        shutil.copy(SHARED / "plate.json", SHARED / f"model_{model}.json")
        succeeds("fit", f"model_{model}.json", "captured", *VARY, "--evaluations", "13", "--seeds", "1", "--scan", "2", "--until", "0.8", "-o", f"fit_{model}")
    (SHARED / "plan.json").write_text(succeeds("cluster", "plan", "history", "trim", "history", "--every", "2", "-o", "planned", "--json"))


def tree_of(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "run.json" and ".cache" not in p.parts}


def without_time(text):
    return re.sub(r"\d+\.\d+ s\b|\"seconds\": [\d.]+|\"megabytes\": \d+", "", text)


class FormerNames(unittest.TestCase):
    def check(self, former):
        present, arguments = COMMANDS[former]
        made = []
        for words in (present.split(), [former]):
            for place in ("OUT", *(p.name for p in SHARED.glob("planned*"))):
                shutil.rmtree(SHARED / place, ignore_errors=True)
            if former == "join":
                succeeds("cluster", "run", "plan.json")
            result = run(*words, *arguments)
            made.append((result, tree_of(SHARED / "OUT")))
        (new, new_files), (old, old_files) = made
        # Without a library there is nothing to list: then both say so.
        self.assertEqual(old.returncode, new.returncode)
        self.assertTrue(new.returncode == 0 or former == "library", new.stderr)
        self.assertEqual(without_time(old.stdout), without_time(new.stdout))
        self.assertEqual(old_files, new_files)
        self.assertTrue(new_files or "OUT" not in arguments)
        said = [line for line in old.stderr.splitlines() if "is now" in line]
        self.assertEqual(said, [f"`patinate {former}` is now `patinate {present}`"] if old.returncode == 0 else [])
        self.assertNotIn("is now", new.stderr)

    def test_help_of_a_former_name_is_that_of_the_present_one(self):
        for former, present in {**{former: present for former, (present, _) in COMMANDS.items()}, **OTHERS}.items():
            with self.subTest(former=former):
                self.assertEqual(run(*former.split(), "--help").stdout, run(*present.split(), "--help").stdout)
                if not present.startswith("help "):  # Those are commands themselves.
                    self.assertEqual(succeeds("help", *former.split()), succeeds("help", *present.split()))

    def test_these_are_all_commands_of_two_words(self):
        present = [heading for heading in re.findall(r"^## (\w+ \w+)$", succeeds("help", "--markdown"), re.MULTILINE)]
        self.assertEqual(sorted(present), sorted(name for name, _ in COMMANDS.values()))

    def test_a_command_of_two_words_goes_by_its_former_two(self):
        for former, present in (("simulate recompose captured", "simulate restyle"), ("history appearance history --metalness 1", "history material")):
            result = run(*former.split(), "-o", f"{present.split()[1]}_by_two_words")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(f"`patinate {' '.join(former.split()[:2])}` is now `patinate {present}`", result.stderr)

    def test_quiet_leaves_the_line_out_and_an_error_is_one_line(self):
        self.assertEqual(run("recompose", "captured", "-o", "quiet", "--quiet").stderr, "")
        self.assertEqual(run("trim", "nowhere", "-o", "out").stderr.count("\n"), 1)

    def test_a_plan_names_the_present_command_and_an_older_one_is_read(self):
        plan = json.loads(succeeds("plan", "trim", "history", "--every", "2", "-o", "older", "--json"))
        self.assertEqual(plan["command"][:3], ["history", "trim", "history"])
        plan["command"][:2] = ["trim"]
        (SHARED / "older.json").write_text(json.dumps(plan))
        succeeds("cluster", "run", "older.json")
        succeeds("cluster", "join", "older.json")
        self.assertEqual(json.loads((SHARED / "older/run.json").read_text())["command"][:4], ["patinate", "history", "trim", "history"])

    def test_a_configuration_file_may_name_either(self):
        for number, section in enumerate(("[trim]", "[history.trim]", '["history trim"]')):
            (SHARED / "run.toml").write_text(f"{section}\nevery = 2\n")
            succeeds("history", "trim", "history", "--config", "run.toml", "-o", f"trimmed_{number}")
            self.assertEqual(tree_of(SHARED / "trimmed_0"), tree_of(SHARED / f"trimmed_{number}"))
            self.assertEqual(len(json.loads((SHARED / f"trimmed_{number}/history.json").read_text())["frames"]), 2)
        for wrong, about in (("[histroy]\n", "did you mean `history`"), ("[history.tirm]\n", "no such command"), ("[history]\nevery = 2\n", "[history.")):
            (SHARED / "run.toml").write_text(wrong)
            self.assertIn(about, run("history", "trim", "history", "--config", "run.toml", "-o", "out").stderr)

    def test_a_group_alone_says_what_may_stand_behind_it(self):
        self.assertIn("library, trim, combine", run("history").stderr)
        self.assertIn("did you mean `trim`", run("history", "trin").stderr)
        self.assertIn("history trim", succeeds("history", "--help"))
        self.assertEqual(succeeds("help", "history"), succeeds("history", "--help"))


for name in COMMANDS:
    setattr(FormerNames, f"test_{name}", lambda self, former=name: self.check(former))

if __name__ == "__main__":
    unittest.main()
