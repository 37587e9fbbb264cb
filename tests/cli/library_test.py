#!/usr/bin/env python3
"""Histories to start from: built by tools/library/build, listed, found, and used offline. Usage: library_test.py PATINATE [unittest arguments]
Photographs of others take part where PATINATE_DATA names the folder that holds them."""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from command_case import CANNOT, INPUT, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
BUILD = pathlib.Path(__file__).resolve().parents[2] / "tools/library/build"
LIBRARY = pathlib.Path(tempfile.mkdtemp(prefix="patinate_library_"))
OURS = {"copper", "crackle", "frost", "moss", "rust"}  # And seven others, in the same way.
SIZE = 64  # Pixels, of those 1024 that users have.


def setUpModule():
    unittest.addModuleCleanup(shutil.rmtree, LIBRARY)
    use(PATINATE)
    subprocess.run([BUILD, LIBRARY / "library", "--patinate", PATINATE, "--size", str(SIZE), "--only", *OURS, "banana"], check=True, capture_output=True)


class Library(CommandCase):
    def setUp(self):
        super().setUp()
        os.environ["PATINATE_LIBRARY"] = str(LIBRARY / "library")
        self.addCleanup(os.environ.pop, "PATINATE_LIBRARY")

    def listed(self, *arguments):
        return json.loads(self.succeeds("history", "library", "--json", *arguments))

    def test_each_history_says_license_attribution_source_and_how_to_use_it(self):
        histories = {h["name"]: h for h in self.listed()["histories"]}
        self.assertLessEqual(OURS, set(histories))
        for name, history in histories.items():
            for member in ("title", "about", "license", "attribution", "source"):
                self.assertTrue(history[member], f"{name} has no {member}")
            self.assertEqual(max(history["width"], history["height"]), SIZE if name in OURS else 256)
            self.assertTrue(history["controls"], f"{name} has no control, so that no transfer can use it")
            self.assertGreater(history["duration"], 0)
            self.succeeds("validate", f"library:{name}")
            if name in OURS:
                frames = json.loads((LIBRARY / "library" / name / "history.json").read_text())["frames"]
                self.assertTrue(all("specular" in frame for frame in frames), name)
                self.assertEqual("metalness" in frames[0], name == "copper", name)
        text = self.succeeds("history", "library")
        for name in histories:
            self.assertRegex(text, rf"(?m)^{name} +\d")

    def test_it_takes_few_megabytes_and_names_no_place_of_who_built_it(self):
        files = [f for f in (LIBRARY / "library").rglob("*") if f.is_file() and ".cache" not in f.parts]  # Transfers keep what they found of a history.
        places = [str(place).encode() + b"/" for place in (tempfile.gettempdir(), pathlib.Path.home(), pathlib.Path(__file__).resolve().parents[2])]
        self.assertLess(sum(f.stat().st_size for f in files), 12e6)
        for file in files:
            for place in places:
                self.assertNotIn(place, file.read_bytes(), file)

    def test_built_twice_it_has_the_same_bytes(self):
        subprocess.run([BUILD, self.folder / "again", "--patinate", PATINATE, "--size", str(SIZE), "--only", "crackle", "rust"], check=True, capture_output=True, env={k: v for k, v in os.environ.items() if k != "PATINATE_DATA"})
        for file in (self.folder / "again").rglob("*"):
            if file.is_file():
                self.assertEqual(file.read_bytes(), (LIBRARY / "library" / file.relative_to(self.folder / "again")).read_bytes(), file)

    def test_a_transfer_of_it_says_whom_it_owes_and_so_does_what_is_made_of_that(self):
        made = self.run_patinate("transfer", "library:rust", self.shared / "urn/mesh.obj", "--control", "accessibility", "--resolution", "64", "-o", "aged")
        self.assertEqual(made.returncode, 0, made.stderr)
        credit = "The patinate authors (MIT)"
        self.assertIn(f"credit: {credit}\n", made.stderr)
        self.assertEqual(json.loads((self.folder / "aged/run.json").read_text())["credits"], [credit])
        self.succeeds("export", "aged", "--num-times", "2", "-o", "aged.glb")
        glb = (self.folder / "aged.glb").read_bytes()
        size = struct.unpack("<I", glb[12:16])[0]
        self.assertEqual(json.loads(glb[20:20 + size])["asset"]["copyright"], credit)
        self.succeeds("export", "aged", "-o", "aged.usda")
        self.assertIn(f'string credits = "{credit}"', (self.folder / "aged.usda").read_text())
        self.succeeds("export", "aged", "-o", "aged.obj")
        self.assertIn(f"# {credit}\n", (self.folder / "aged.mtl").read_text())

    def test_doubts_about_its_photographs_are_named_in_one_line(self):
        # They were seen by who chose it, and ask for things that cannot be done to a library; info lists them.
        shutil.copytree(self.shared / "history", self.folder / "mine/doubtful")
        self.edit_json(self.folder / "mine/doubtful/history.json", lambda h: h.update(warnings=[{"about": "series", "text": "a jump", "share": 0.5}, {"about": "light", "text": "another", "share": 0.1}]))
        os.environ["PATINATE_LIBRARY"] = str(self.folder / "mine")
        made = self.run_patinate("transfer", "library:doubtful", self.shared / "urn/mesh.obj", "--control", "facing", "--resolution", "32", "-o", "aged")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertNotIn("a jump", made.stderr)
        self.assertIn("library:doubtful has 2 warnings about its photographs; `patinate info library:doubtful` lists them\n", made.stderr)
        self.assertIn("a jump", self.succeeds("info", "library:doubtful"))

    def test_a_transfer_that_is_moved_finds_it_again(self):
        self.succeeds("transfer", "library:rust", self.shared / "urn/mesh.obj", "--control", "accessibility", "--resolution", "32", "-o", "aged")
        (self.folder / "deep/er").mkdir(parents=True)
        (self.folder / "aged").rename(self.folder / "deep/er/aged")
        self.succeeds("texture", "deep/er/aged", "--time", "1", "-o", "then.png")

    def test_it_stands_for_a_history_everywhere(self):
        self.assertEqual(json.loads(self.succeeds("info", "library:crackle", "--json"))["kind"], "history")
        self.succeeds("history", "combine", "library:rust", "library:moss", "--clock", "span", "-o", "both")
        self.assertEqual(json.loads((self.folder / "both/run.json").read_text())["credits"], ["The patinate authors (MIT)"])
        self.succeeds("render", "library:moss", "--num-times", "2", "-o", "moss.png")
        (self.folder / "study.json").write_text(json.dumps({"format": "patinate.study", "version": 1, "transfer": {"histories": ["library:moss"], "meshes": [str(self.shared / "urn/mesh.obj")], "controls": ["facing"], "options": {"resolution": [32]}}}))
        self.succeeds("study", "run", "study.json", "-o", "studied")

    def test_an_unknown_name_lists_what_there_is(self):
        line = self.fails(INPUT, "library:russt", "info", "library:russt")
        for name in OURS:
            self.assertIn(name, line)
        self.assertIn("did you mean `rust`?", line)
        # Without its prefix.
        for name in ("rust", "rsut"):
            self.fails(INPUT, f"{name}: does not exist; did you mean `library:rust`?", "info", name)

    def test_without_a_library_it_says_what_makes_one(self):
        if (pathlib.Path(self.patinate).parent / "../share/patinate/library").exists():
            self.skipTest("there is one beside the program")
        os.environ["PATINATE_LIBRARY"] = str(self.folder / "nothing")
        self.assertIn("tools/library/build", self.fails(CANNOT, "no library", "history", "library"))

    def test_ones_own_folders_come_first(self):
        shutil.copytree(self.shared / "history", self.folder / "mine/rust")
        shutil.copytree(self.shared / "history", self.folder / "mine/own")
        os.environ["PATINATE_LIBRARY"] = f"{self.folder / 'mine'}:{LIBRARY / 'library'}"
        histories = {h["name"]: h for h in self.listed()["histories"]}
        self.assertLessEqual(OURS | {"own"}, set(histories))
        self.assertEqual(histories["rust"]["folder"], str(self.folder / "mine/rust"))
        self.assertNotIn("license", histories["own"])

    def test_the_page_shows_every_history(self):
        self.assertIn("library.html", self.succeeds("history", "library", "--thumbnails", "library.html"))
        page = (self.folder / "library.html").read_text()
        names = [h["name"] for h in self.listed()["histories"]]
        for name in names:
            self.assertIn(f"library:{name}", page)
        self.assertEqual(page.count("data:image/jpeg;base64,"), len(names))

    def test_each_history_is_most_like_itself_and_a_photograph_finds_its_moment(self):
        for history in self.listed()["histories"]:
            name = history["name"]
            ranking = self.listed("--like", f"library:{name}")["like"]
            self.assertEqual((ranking[0]["name"], ranking[0]["total"]), (name, 0))
            self.assertEqual([r["total"] for r in ranking], sorted(r["total"] for r in ranking))
            self.succeeds("export", f"library:{name}", "--time", history["duration"], "-o", name)
            photo = next((self.folder / name).glob("*.png"))
            found = self.listed("--like", photo)["like"][0]
            self.assertEqual(found["name"], name)
            self.assertIsNone(found["rates_spans"])
            # Codes of 8 bit are what differs, and what the history's mask leaves out.
            self.assertLess(found["colors_delta_e"], 1.5, name)


if __name__ == "__main__":
    unittest.main()
