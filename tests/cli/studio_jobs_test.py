#!/usr/bin/env python3
"""patinate studio runs commands as jobs: which ones, with which files, and that nothing outside the served folder is read or written. Usage: studio_jobs_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from studio_client import Server

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
ENDED = ("done", "failed", "canceled")
TRANSFER = {"HISTORY": "history", "MESH": "urn/mesh.obj", "control": ["facing"], "resolution": "64"}


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_jobs_"))
        cls.made = cls.folder / "made"
        cls.made.mkdir()
        for arguments in (["synth", "crackle", "--width", "64", "--height", "64", "--num-frames", "3", "-o", "capture"], ["ingest", "capture", "-o", "history"],
                          ["synth", "sculpture", "--resolution", "24", "-o", "urn"]):
            subprocess.run([PATINATE, *arguments, "--quiet"], cwd=cls.made, check=True, timeout=300)
        shutil.copytree(cls.made / "capture/frames", cls.made / "photos")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def setUp(self):
        self.base = self.folder / self.id().split(".")[-1]
        self.served, self.outside = self.base / "served", self.base / "outside"
        shutil.copytree(self.made, self.served)
        shutil.copytree(self.made, self.outside)
        (self.served / "out").symlink_to(self.outside)
        self.open()

    def open(self, *options):
        self.server = Server(PATINATE, self.served, *options)
        self.addCleanup(self.server.close)

    def ask(self, command="transfer", arguments=None, output=None, **more):
        body = {"command": command, "arguments": TRANSFER if arguments is None else arguments, **more}
        if output is not None:
            body["output"] = output
        status, _, data = self.server.request("/api/jobs", "POST", json.dumps(body))
        return status, json.loads(data)

    def start(self, *arguments, **more):
        status, answer = self.ask(*arguments, **more)
        self.assertEqual(status, 200, answer)
        return answer["id"]

    def job(self, number):
        return next(job for job in self.server.get_json("/api/jobs")["jobs"] if job["id"] == number)

    def until(self, number, states=ENDED, seconds=120):
        end = time.time() + seconds
        while time.time() < end:
            job = self.job(number)
            if job["state"] in states:
                return job
            time.sleep(0.05)
        self.fail(f"not {states} within {seconds} s: {job}")

    def refused(self, *arguments, **more):
        status, answer = self.ask(*arguments, **more)
        self.assertEqual(status, 400, (arguments, more, answer))
        return answer

    def files(self, folder):
        return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


class Attacks(Case):
    def setUp(self):
        super().setUp()
        self.before = self.files(self.outside)

    def tearDown(self):
        self.assertEqual(self.files(self.outside), self.before, "nothing outside was changed")

    def test_only_who_knows_the_token_may_ask(self):
        for path, method in (("/api/jobs", "POST"), ("/api/jobs/cancel", "POST"), ("/api/jobs", "GET"), ("/api/commands", "GET"), ("/api/jobs/file?id=1", "GET")):
            self.assertEqual(self.server.request(path, method, "{}", token=False)[0], 403, path)
            self.assertEqual(self.server.request(path, method, "{}", headers={"Origin": "http://elsewhere.example"})[0], 403, path)

    def test_there_is_a_fixed_list_of_commands(self):
        names = [command["name"] for command in self.server.get_json("/api/commands")["commands"]]
        self.assertEqual(names, ["init", "ingest", "transfer", "render", "export", "history compare", "evaluate", "grade", "simulate", "fit"])
        for name in ("synth", "studio", "study", "cluster run", "cluster plan", "help", "info", "--help", "", "../transfer", "transfer ", "compare", "sh", "transfer; rm -rf ."):
            self.refused(command=name)

    def test_options_of_the_machine_and_of_other_places_are_refused(self):
        for command in self.server.get_json("/api/commands")["commands"]:
            keys = {argument["key"] for argument in command["arguments"]}
            self.assertFalse(keys & {"config", "force", "json", "quiet", "verbose", "dry_run", "threads", "output", "device"}, command["name"])
        for key in ("config", "force", "json", "dry_run", "threads", "output", "device", "--force", "-o", "help", ""):
            self.refused(arguments={**TRANSFER, key: "x"})
            self.refused(arguments={**TRANSFER, key: True})

    def test_inputs_lie_in_the_folder(self):
        (self.served / "link.obj").symlink_to(self.outside / "urn/mesh.obj")
        for name in (str(self.outside / "urn/mesh.obj"), "../outside/urn/mesh.obj", "out/urn/mesh.obj", "link.obj", "urn/../../outside/urn/mesh.obj", "/etc/passwd", "~/x.obj", "none.obj",
                     "--force", "-o", "--config=x", "library:mesh", "urn/mesh.obj\u0000.png", "urn/mesh.obj\n", "x" * 5000):
            self.assertEqual(self.refused(arguments={**TRANSFER, "MESH": name})["argument"], "MESH", name)
            self.assertEqual(self.refused(arguments={**TRANSFER, "source_mask": name})["argument"], "source_mask", name)
        for name in ("library:../../outside/history", "library:none", "library:", "library:/etc", "out/history", "../outside/history"):
            self.refused(arguments={**TRANSFER, "HISTORY": name})

    def test_outputs_are_new_and_lie_in_the_folder(self):
        (self.served / "dangling").symlink_to(self.outside / "none")
        for name in ("../x", "/tmp/x", "out/x", "out", "dangling", "history", "history/x", "urn/mesh.obj", "none/x", "x/", "", ".", "..", ".hidden", "a b", "a%04d", "a<UDIM>", "x\n", "x" * 300,
                     "x\u0000y", "$(touch x)"):
            self.assertEqual(self.refused(output=name)["argument"], "output", name)
        self.refused(command="render", arguments={"SUBJECT": "history"}, output="a%04d.png")
        self.assertEqual(sorted(p.name for p in self.served.iterdir()), ["capture", "dangling", "history", "out", "photos", "urn"])

    def test_what_is_resumed_has_no_links(self):
        (self.served / "aged.partial").symlink_to(self.outside)
        self.assertIn("link", self.refused(output="aged")["error"])
        (self.served / "aged.partial").unlink()
        (self.served / "aged.partial/.job").mkdir(parents=True)
        (self.served / "aged.partial/.job/done").symlink_to(self.outside)
        self.assertIn("link", self.refused(output="aged")["error"])

    def test_texts_that_name_files_lead_nowhere_else(self):
        shutil.copy(self.made / "capture/backlight.png", self.served / "map.png")
        (self.served / "link.png").symlink_to(self.outside / "capture/backlight.png")
        for control in (str(self.outside / "capture/backlight.png"), "../outside/capture/backlight.png", "link.png", "out/capture/backlight.png", "0.5*facing + link.png"):
            job = self.until(self.start(arguments={**TRANSFER, "control": [control]}, output="aged"))
            self.assertEqual(job["state"], "failed", job)
            self.assertIn("lies outside", " ".join(job["messages"]))
            self.assertFalse((self.served / "aged").exists())
        job = self.until(self.start("ingest", {"CAPTURE": "capture", "flat_field": "out/capture/backlight.png"}, "h"))
        self.assertIn("lies outside", " ".join(job["messages"]))

    def test_values_are_never_options(self):
        for value in ("--force", "-o", "--config=/etc/passwd", "--", "-"):
            status, answer = self.ask(arguments={**TRANSFER, "control": [value], "flow": value}, output="aged")
            if status == 200:
                self.assertEqual(self.until(answer["id"])["state"], "failed")
        status, answer = self.ask(arguments={**TRANSFER, "node": "--force"}, check=True)
        self.assertIn("--node=--force", answer["line"])

    def test_files_that_name_files_lead_nowhere_else(self):
        project = json.loads((self.served / "capture/capture.json").read_text())
        project["frames"] = json.loads(json.dumps(project["frames"]).replace("frames/", "../out/capture/frames/"))
        (self.served / "capture/other.json").write_text(json.dumps(project))
        job = self.until(self.start("ingest", {"CAPTURE": "capture/other.json"}, "h"))
        self.assertEqual(job["state"], "failed")
        self.assertIn("lies outside", " ".join(job["messages"]))
        manifest = json.loads((self.served / "history/history.json").read_text())
        manifest["frames"][0]["file"] = str(self.outside / "history" / manifest["frames"][0]["file"])
        (self.served / "history/history.json").write_text(json.dumps(manifest))
        self.assertEqual(self.until(self.start(output="aged"))["state"], "failed")

    def test_names_of_files_elsewhere_are_not_told(self):
        (self.served / "photos/sub").symlink_to(self.outside / "capture/frames")
        job = self.until(self.start("init", {"FOLDER": "photos"}))
        self.assertEqual(job["state"], "done", job)
        self.assertNotIn("sub", " ".join(job["messages"]))
        project = json.loads((self.served / "capture/capture.json").read_text())
        project["frames"]["pattern"] = "../out/capture/frames/*.png"
        (self.served / "capture/other.json").write_text(json.dumps(project))
        job = self.until(self.start("ingest", {"CAPTURE": "capture/other.json"}, "h"))
        self.assertNotIn("0000", " ".join(job["messages"]))

    def test_nothing_is_made_in_a_folder_that_is_only_read(self):
        self.server.close()
        self.open("--allow-folder", str(self.outside))
        self.until(self.start(output="aged"))
        aged = json.loads((self.served / "aged/transfer.json").read_text())
        aged["history"]["path"] = "../out/history"
        (self.served / "aged/transfer.json").write_text(json.dumps(aged))
        job = self.until(self.start("evaluate", {"MAP": ["aged"]}, "evaluated"))
        self.assertEqual(job["state"], "done", job)
        self.assertFalse((self.outside / "history/.cache").exists())

    def test_links_for_what_is_kept_lead_nowhere_else(self):
        (self.served / "history/.cache").symlink_to(self.outside / "capture")
        self.assertEqual(self.until(self.start(output="aged"))["state"], "done")

    def test_bad_requests_start_nothing(self):
        for body in ("", "[]", "null", "{", "{}", '{"command": "transfer"}', '{"command": "transfer", "arguments": []}', '{"command": "transfer", "arguments": {"HISTORY": 5}}',
                     '{"command": "transfer", "arguments": {"control": "facing"}}', json.dumps({"command": "transfer", "arguments": {**TRANSFER, "control": ["facing"] * 1000}}),
                     '{"command": "transfer", "arguments": {}, "shell": "x"}', "[" * 100000):
            self.assertEqual(self.server.request("/api/jobs", "POST", body)[0], 400, body[:60])
        self.assertEqual(self.server.request("/api/jobs/cancel", "POST", '{"id": 7}')[0], 404)
        for body in ("", "{}", '{"id": "1"}', '{"id": 1, "signal": 9}'):
            self.assertIn(self.server.request("/api/jobs/cancel", "POST", body)[0], (400, 404))
        self.assertEqual(self.server.request("/api/jobs/file?id=1")[0], 404)
        self.assertEqual(self.server.get_json("/api/jobs")["jobs"], [])

    def test_options_of_the_environment_do_not_count(self):
        self.server.close()
        os.environ.update(PATINATE_RESOLUTION="16", PATINATE_OUTPUT=str(self.outside / "x"), PATINATE_FORCE="true")
        self.addCleanup(lambda: [os.environ.pop(name) for name in ("PATINATE_RESOLUTION", "PATINATE_OUTPUT", "PATINATE_FORCE")])
        self.open()
        arguments = {key: value for key, value in TRANSFER.items() if key != "resolution"}
        job = self.until(self.start(arguments={**arguments, "quality": "draft"}, output="aged"))
        self.assertEqual(job["state"], "done", job)
        self.assertGreater(json.loads((self.served / "aged/transfer.json").read_text())["width"], 16)


class Running(Case):
    def test_a_job_makes_what_its_command_makes(self):
        status, checked = self.ask(check=True)
        self.assertEqual((status, checked["output"]), (200, "history_urn_aged"))
        self.assertEqual(self.server.get_json("/api/jobs")["jobs"], [], "it was only looked at")
        job = self.until(self.start())
        self.assertEqual((job["state"], job["place"], job["exit_code"]), ("done", "history_urn_aged", 0))
        self.assertEqual(job["line"], checked["line"])
        self.assertIn("history_urn_aged", [place["place"] for place in self.server.get_json("/api/places")["places"]])
        words = [word if word != job["output"] else "again" for word in shlex.split(job["line"])]
        subprocess.run([PATINATE, *words[1:], "--quiet"], cwd=self.served, check=True, timeout=300)
        one, other = (self.files(self.served / name) for name in (job["output"], "again"))
        self.assertEqual({k: v for k, v in one.items() if k != "run.json"}, {k: v for k, v in other.items() if k != "run.json"})
        self.assertEqual(self.ask(check=True)[1]["output"], "history_urn_aged-2", "a name that is free")

    def test_what_is_wrong_is_said_at_its_argument(self):
        history = (self.served / "history").stat().st_mtime
        for key, value, words in (("resolution", "x", "integer"), ("resolution", "7", "[16, 16384]"), ("quality", "goood", "did you mean"), ("coherence", "2", "[0, 1]"), ("control", [], "missing"),
                                  ("HISTORY", "", "missing"), ("MESH", "urn/mush.obj", "there is no"), ("seed", "-1", ">= 0")):
            answer = self.refused(arguments={**TRANSFER, key: value}, check=True)
            self.assertEqual(answer["argument"], key, answer)
            self.assertIn(words, answer["error"])
        self.assertEqual(self.refused(output="history", check=True)["argument"], "output")
        self.assertEqual((self.served / "history").stat().st_mtime, history)

    def test_a_name_that_is_not_utf_8_is_said_to_be_so(self):
        shutil.copytree(self.served / "photos", self.served / os.fsdecode(b"day\xff"))
        name = next(name for name in self.server.get_json("/api/commands")["photographs"] if name.startswith("day"))
        answer = self.refused("init", {"FOLDER": name}, check=True)
        self.assertEqual((answer["argument"], "not UTF-8" in answer["error"]), ("FOLDER", True), answer)

    def test_from_photographs_to_a_picture_of_an_aged_mesh(self):
        for name in ("0000.png", "0001.png"):
            shutil.copy(self.served / "photos" / name, self.served)
        self.assertEqual(self.server.get_json("/api/commands")["photographs"], ["photos", "."])
        job = self.until(self.start("init", {"FOLDER": "photos"}))
        self.assertEqual((job["state"], job["output"], job["place"]), ("done", "photos/capture.json", "photos"), job)
        self.assertTrue(any(line.startswith("found: ") for line in job["messages"]), job["messages"])
        self.assertTrue(any(line.startswith("check: ") for line in job["messages"]), job["messages"])
        job = self.until(self.start("ingest", {"CAPTURE": "photos"}))
        self.assertEqual((job["state"], job["place"]), ("done", "photos_history"), job)
        job = self.until(self.start(arguments={**TRANSFER, "HISTORY": "photos_history", "control": ["progress=facing"]}, output="aged"))
        self.assertEqual(job["state"], "done", job)
        job = self.until(self.start("render", {"SUBJECT": "aged", "width": "64", "height": "64"}))
        self.assertEqual((job["state"], job["output"], job["place"], job["is_file"]), ("done", "aged.png", None, True), job)
        status, headers, data = self.server.request(f"/api/jobs/file?id={job['id']}")
        self.assertEqual((status, headers["content-type"], data[1:4]), (200, "image/png", b"PNG"))
        job = self.until(self.start("evaluate", {"MAP": ["aged"]}))
        self.assertEqual((job["state"], job["output"]), ("done", "aged_evaluated"), job)
        self.assertEqual(self.server.get_json("/api/place?place=aged_evaluated")["page"], "evaluation.html")
        steps = self.server.get_json("/api/place?place=photos_history")["steps"]
        self.assertEqual([(p.get("place"), p["path"]) for p in steps[0]["pictures"][:2]], [("photos", "0000.png"), (None, "frames/0000.exr")])

    def test_a_history_of_the_library_is_read_but_not_listed(self):
        self.server.close()
        shutil.copytree(self.made / "history", self.base / "library/cracks")
        os.environ["PATINATE_LIBRARY"] = str(self.base / "library")
        self.addCleanup(os.environ.pop, "PATINATE_LIBRARY")
        self.open()
        self.assertIn({"name": "library:cracks", "controls": ["thickness"]}, self.server.get_json("/api/commands")["library"])
        job = self.until(self.start(arguments={**TRANSFER, "HISTORY": "library:cracks"}))
        self.assertEqual((job["state"], job["place"], job["line"].split()[2]), ("done", "cracks_urn_aged", "library:cracks"), job)
        self.assertEqual(self.server.request("/api/texture?place=cracks_urn_aged&time=0")[0], 200)
        self.assertNotIn("cracks", [place["name"] for place in self.server.get_json("/api/places")["places"]])

    def test_a_job_is_canceled_and_resumed(self):
        slow = {**TRANSFER, "resolution": "1024", "quality": "best"}
        number = self.start(arguments=slow, output="aged")
        self.until(number, ["running"])
        time.sleep(1.0)
        self.assertEqual(self.refused(arguments=slow, output="aged")["argument"], "output", "two would make one output")
        begun = time.time()
        self.assertEqual(self.server.request("/api/jobs/cancel", "POST", json.dumps({"id": number}))[0], 200)
        job = self.until(number)
        self.assertLess(time.time() - begun, 5.0)
        self.assertEqual((job["state"], job["exit_code"], job["place"]), ("canceled", 130, None))
        self.assertIn("interrupted", job["messages"][-1])
        self.assertFalse((self.served / "aged").exists())
        job = self.until(self.start(arguments={**slow, "resolution": "64"}, output="aged"))
        self.assertEqual(job["state"], "done", "its output may be made again")

    def test_more_jobs_than_run_at_a_time_wait(self):
        slow = {**TRANSFER, "resolution": "1024", "quality": "best"}
        numbers = [self.start(arguments=slow, output=f"aged{i}") for i in range(3)]
        for number in numbers[:2]:
            self.until(number, ["running"])
        self.assertEqual(self.job(numbers[2])["state"], "waiting")
        for number in reversed(numbers):
            self.server.request("/api/jobs/cancel", "POST", json.dumps({"id": number}))
        self.assertEqual([self.until(number)["state"] for number in numbers], ["canceled"] * 3)
        self.assertIsNone(self.job(numbers[2])["exit_code"], "it has never run")

    def test_what_is_there_when_its_turn_comes_is_not_called_its_result(self):
        slow = {**TRANSFER, "resolution": "1024", "quality": "best"}
        before = [self.start(arguments=slow, output=f"aged{i}") for i in range(2)]
        number = self.start(output="aged")
        (self.served / "aged").mkdir()
        for each in before:
            self.server.request("/api/jobs/cancel", "POST", json.dumps({"id": each}))
        job = self.until(number)
        self.assertEqual((job["state"], job["messages"]), ("failed", ["aged: exists by now; give another name"]))

    def test_one_that_is_canceled_at_once_has_not_crashed(self):
        number = self.start()
        self.until(number, ["running"])
        self.server.request("/api/jobs/cancel", "POST", json.dumps({"id": number}))
        self.assertNotIn("crashed", " ".join(self.until(number)["messages"]))

    def test_processes_of_the_studio_have_none_of_its_connections(self):
        decoder, said = self.base / "decoder", self.base / "said"
        decoder.write_text(f"#!/bin/sh\nls -l /proc/$$/fd > {said}\n")
        decoder.chmod(0o755)
        self.server.close()
        os.environ["PATINATE_DECODER"] = str(decoder)
        self.addCleanup(os.environ.pop, "PATINATE_DECODER")
        self.open()
        (self.served / "capture/frames/raw.cr2").write_bytes(b"II*\0" + bytes(100))
        self.assertEqual(self.server.request("/api/preview?place=capture&path=frames/raw.cr2")[0], 400)
        self.until(self.start(arguments={**TRANSFER, "resolution": "1024", "quality": "best"}, output="aged"), ["running"])
        time.sleep(0.5)
        job = self.children()[0]
        opened = [os.readlink(f"/proc/{job}/fd/{fd}") for fd in os.listdir(f"/proc/{job}/fd")]
        self.assertEqual([name for name in opened if name.startswith("socket")], [])
        # Its own two.
        self.assertEqual(said.read_text().count("socket"), 2, said.read_text())

    def children(self):
        found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(self.server.process.pid)], capture_output=True, text=True, check=False).stdout.split()
        return [int(pid) for pid in found]

    def test_jobs_end_with_the_studio_however_it_ends(self):
        for end in (signal.SIGTERM, signal.SIGKILL):
            self.until(self.start(arguments={**TRANSFER, "resolution": "1024", "quality": "best"}, output="aged"), ["running"])
            time.sleep(0.5)
            children = self.children()
            self.assertEqual(len(children), 1)
            self.server.process.send_signal(end)
            self.server.process.communicate(timeout=30)
            limit = time.time() + 10
            while pathlib.Path(f"/proc/{children[0]}").exists() and time.time() < limit:
                time.sleep(0.05)
            self.assertFalse(pathlib.Path(f"/proc/{children[0]}").exists(), end)
            self.open()


if __name__ == "__main__":
    unittest.main()
