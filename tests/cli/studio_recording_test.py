#!/usr/bin/env python3
"""What is done in patinate studio outlives it: recordings on the disk, and going through them again. Usage: studio_recording_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from studio_client import Client, Server, wait_until

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
# From one writing of a recording to the next the program lets 0.4 s pass: what it has not written after this it does not write.
NOT_WRITTEN = 0.6


class Recordings(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_recordings_"))
        self.run_in("synth", "ledge", "--cells", "5", "-o", "ledge")
        scene = json.loads((self.folder / "ledge/scene.json").read_text())
        scene["atlas"]["resolution"] = 80
        scene["run"] = {"iterations": 12, "history_every": 6}
        for emitter in scene["emitters"]:
            emitter["gammatons"] = 100
        scene["events"] = [{"iteration": 5, "op": "ratio", "ratio": 0.6}]
        self.scene = scene
        (self.folder / "ledge/scene.json").write_text(json.dumps(scene))
        self.servers, self.clients = [], []

    def tearDown(self):
        for client in self.clients:
            client.close()
        for server in self.servers:
            server.close()
        shutil.rmtree(self.folder)

    def run_in(self, *arguments):
        result = subprocess.run([PATINATE, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=300)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}")

    def server(self, folder="."):
        self.servers.append(Server(PATINATE, (self.folder / folder).resolve()))
        return self.servers[-1]

    def open(self, server, place="ledge/scene.json"):
        self.clients.append(Client(server, place))
        self.clients[-1].until(lambda: self.clients[-1].status)
        return self.clients[-1]

    def recordings(self):
        return sorted(p.name for p in (self.folder / ".studio").glob("[!.]*.json"))  # those that are being written begin with a dot

    def kept(self):
        """The recording of the scene that is open, or None."""
        name = next((n for n in self.recordings() if not n.endswith(".previous.json")), None)
        try:
            return json.loads((self.folder / ".studio" / name).read_text()) if name else None
        except FileNotFoundError:  # it has just been put aside
            return None

    def wait_until_kept(self, client):
        """What is on the disk ends where a client is: in the scene file that `save` gives it. @returns the recording."""
        (self.folder / "now").mkdir(exist_ok=True)  # as deep as .studio, so that meshes have the same path
        client.do("save", path="now/saved.json")
        saved = json.loads((self.folder / "now/saved.json").read_text())
        shutil.rmtree(self.folder / "now")
        return wait_until(lambda: (kept := self.kept()) and kept["scene"] == saved and kept, "recording of all that was done")

    def paint(self, client):
        """Something of everything that is recorded. @returns the picture at its end."""
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        brush = client.scene["emitters"][-1]["name"]
        client.step(4)
        client.do("event", event={"op": "behavior", "behavior": {"slider": 0.6}})
        client.do("stroke", emitter=brush, position=middle, phase="begin")
        client.do("stroke", position=[middle[0] + 30, middle[1], middle[2]], phase="move")
        client.do("stroke", position=[middle[0] + 30, middle[1] + 20, middle[2]], phase="end")
        client.until(lambda: not client.status.get("painting"))
        client.step(3)
        client.do("appearance", appearance={"dirt": {"strength": 0.7, "color": [0.3, 0.1, 0.1]}})
        client.do("event", event={"op": "rate", "target": "dirt", "rate": 0.3})
        client.do("stroke", emitter=brush, position=middle, phase="begin")
        client.do("stroke", position=[middle[0], middle[1] + 25, middle[2]], phase="end")
        client.until(lambda: not client.status.get("painting"))
        client.settle()
        return client.surface(), client.status["iteration"]

    def resume(self, client, iterations):
        client.do("resume")
        client.until(lambda: not client.status["running"] and client.status["iteration"] == iterations and client.notices)
        client.settle()
        return client.surface()

    def test_a_killed_studio_goes_through_it_again_to_the_same_picture(self):
        server = self.server()
        client = self.open(server)
        self.assertIsNone(client.scene["recording"])
        picture, iterations = self.paint(client)
        self.wait_until_kept(client)
        server.process.send_signal(signal.SIGKILL)
        server.process.wait()
        again = self.open(self.server())
        self.assertEqual(again.scene["recording"]["iterations"], iterations)
        self.assertGreaterEqual(again.scene["recording"]["events"], 4)
        again.settle()
        self.assertNotEqual(again.surface(), picture)  # it is offered, not done
        self.assertEqual(self.resume(again, iterations), picture)
        self.assertEqual((again.scene["slider"], again.scene["appearance"]["dirt"]["strength"]), (0.6, 0.7))
        self.assertIsNone(again.scene["recording"])
        self.assertEqual(again.ask("resume")["type"], "error")
        again.do("save", path="resumed.json")
        again.do("export", path="resumed_look", what=["textures"])
        self.run_in("simulate", "resumed.json", "-o", "resumed")
        self.assertEqual((self.folder / "resumed/color.png").read_bytes(), (self.folder / "resumed_look/color.png").read_bytes())

    def test_it_is_on_the_disk_within_a_second_while_it_runs(self):
        server = self.server()
        client = self.open(server)
        client.do("run")
        client.do("event", event={"op": "ratio", "ratio": 0.25})
        begin = time.monotonic()
        while not self.recordings() and time.monotonic() - begin < 5:
            client.listen(0.05)
        self.assertLess(time.monotonic() - begin, 1.0)
        kept = json.loads((self.folder / ".studio" / self.recordings()[0]).read_text())
        self.assertEqual([e["ratio"] for e in kept["events"]], [0.25])

    def test_it_goes_on_after_it_was_resumed(self):
        server = self.server()
        client = self.open(server)
        picture, iterations = self.paint(client)
        self.wait_until_kept(client)
        server.process.send_signal(signal.SIGKILL)
        server.process.wait()
        server = self.server()
        client = self.open(server)
        self.resume(client, iterations)
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        client.step(3)
        client.settle()
        more = client.surface()
        self.assertNotEqual(more, picture)
        self.wait_until_kept(client)
        server.process.send_signal(signal.SIGKILL)
        server.process.wait()
        self.assertEqual(self.resume(self.open(self.server()), iterations + 3), more)

    def test_what_is_not_resumed_is_put_aside_when_something_new_begins(self):
        server = self.server()
        self.paint(self.open(server))
        self.assertEqual(server.close(), 130)  # an orderly end keeps it too
        old = (self.folder / ".studio" / self.recordings()[0]).read_text()
        client = self.open(self.server())
        self.assertIsNotNone(client.scene["recording"])
        time.sleep(NOT_WRITTEN)
        self.assertEqual((self.folder / ".studio" / self.recordings()[0]).read_text(), old)  # looking at it changes nothing
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        wait_until(lambda: len(self.recordings()) == 2, "second recording")
        previous = [name for name in self.recordings() if name.endswith(".previous.json")]
        self.assertEqual((self.folder / ".studio" / previous[0]).read_text(), old)
        client.do("reset")
        wait_until(lambda: self.recordings() == previous, "end of the second recording")
        self.assertEqual((self.folder / ".studio" / previous[0]).read_text(), old)  # and not what was gone back from
        self.assertIsNotNone(client.scene["recording"])

    def test_what_was_undone_is_not_kept_and_what_was_redone_is(self):
        client = self.open(self.server())
        self.paint(client)
        for op, strokes in (("undo", 1), ("redo", 2)):
            client.do(op)
            client.settle()
            kept = self.wait_until_kept(client)
            self.assertEqual([e["op"] for e in kept["events"]].count("paint"), strokes)
            self.assertEqual(kept["iterations"], client.status["iteration"])

    def test_what_is_done_meanwhile_ends_it_and_it_can_be_resumed_from_the_start(self):
        server = self.server()
        first = self.open(server)
        first.step(300)
        first.do("event", event={"op": "ratio", "ratio": 0.3})
        first.settle()
        picture = first.surface()
        server.close()
        client = self.open(self.server())
        client.socket.send({"op": "resume", "id": "a"})
        client.socket.send({"op": "event", "id": "b", "event": {"op": "ratio", "ratio": 0.9}})  # long before its iteration 300
        client.until(lambda: "b" in client.answers)
        self.assertEqual((client.answers["a"]["type"], client.answers["b"]["type"]), ("done", "done"))
        client.until(lambda: client.scene["recording"] and not client.status["running"])
        self.assertEqual(client.notices, [])
        self.assertLess(client.status["iteration"], 300)
        self.assertEqual(self.resume(client, 300), picture)

    def test_what_is_refused_meanwhile_does_not_end_it(self):
        server = self.server()
        first = self.open(server)
        first.step(300)
        first.do("event", event={"op": "ratio", "ratio": 0.3})
        first.settle()
        picture = first.surface()
        server.close()
        client = self.open(self.server())
        middle = [(a + b) / 2 for a, b in zip(*client.scene["bounds_mm"])]
        refused = ({"op": "event", "event": {"op": "ratio", "ratio": 7}}, {"op": "stroke", "phase": "begin", "emitter": "rain", "position": middle}, {"op": "redo"}, {"op": "resume"})
        for i, request in enumerate(({"op": "resume"}, *refused)):  # long before its iteration 300
            client.socket.send({**request, "id": f"r{i}"})
        client.until(lambda: client.notices and client.status["iteration"] == 300)
        self.assertEqual([client.answers[f"r{i}"]["type"] for i in range(5)], ["done"] + 4 * ["error"])
        client.settle()
        self.assertEqual(client.surface(), picture)

    def test_what_was_done_a_moment_before_ctrl_c_is_kept(self):
        for end in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            server = self.server()
            client = self.open(server)
            client.do("run")
            for ratio in (0.1, 0.2, 0.3):  # the last ones follow the first sooner than anything is written again
                client.do("event", event={"op": "ratio", "ratio": ratio})
                client.do("event", event={"op": "behavior", "behavior": {"slider": ratio}})
            server.process.send_signal(end)
            self.assertEqual(server.process.wait(timeout=30), 130)
            kept = self.kept()
            self.assertEqual([e["ratio"] for e in kept["events"] if e["op"] == "ratio"][-1], 0.3)
            self.assertEqual(kept["events"][-1]["behavior"], {"slider": 0.3})

    def test_two_programs_that_serve_one_folder_keep_both(self):
        clients = [self.open(self.server()), self.open(self.server())]
        for ratio, client in zip((0.1, 0.2), clients):
            client.do("event", event={"op": "ratio", "ratio": ratio})
            wait_until(lambda: (kept := self.kept()) and kept["events"][0]["ratio"] == ratio, f"recording of ratio {ratio}")
        kept = {name.endswith(".previous.json"): json.loads((self.folder / ".studio" / name).read_text())["events"][0]["ratio"] for name in self.recordings()}
        self.assertEqual(kept, {True: 0.1, False: 0.2})

    def test_a_finished_result_that_is_served_itself_stays_as_it_was_made(self):
        self.run_in("simulate", "ledge/scene.json", "-o", "ran")
        server = self.server("ran")
        self.assertIsNone(server.said["recordings"])
        client = self.open(server, ".")
        self.assertTrue(any("not kept on the disk" in n for n in client.scene["notes"]), client.scene["notes"])
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        time.sleep(NOT_WRITTEN)
        self.assertFalse((self.folder / "ran/.studio").exists())

    def test_a_link_out_of_the_folder_is_not_followed(self):
        outside = pathlib.Path(tempfile.mkdtemp(prefix="patinate_outside_"))
        self.addCleanup(shutil.rmtree, outside)
        (self.folder / ".studio").symlink_to(outside)
        client = self.open(self.server())
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        client.until(lambda: client.notices, 10)
        self.assertIn("is a link", client.notices[0])
        self.assertEqual(list(outside.iterdir()), [])

    def test_a_scene_that_has_changed_since_leaves_a_scene_file_of_what_was_painted(self):
        server = self.server()
        client = self.open(server)
        _, iterations = self.paint(client)
        client.do("export", path="before_look", what=["textures"])
        server.close()
        changed = json.loads(json.dumps(self.scene))
        changed["exchange"]["ratio"] = 0.2
        (self.folder / "ledge/scene.json").write_text(json.dumps(changed))
        client = self.open(self.server())
        self.assertIsNone(client.scene["recording"])
        note = next(n for n in client.scene["notes"] if "has changed since it was painted" in n)
        name = note.split("scene file ")[1].rstrip(".")
        kept = json.loads((self.folder / name).read_text())
        self.assertEqual((kept["exchange"]["ratio"], kept["run"]["iterations"]), (self.scene["exchange"]["ratio"], iterations))
        self.run_in("simulate", name, "-o", "before")
        self.assertEqual((self.folder / "before/color.png").read_bytes(), (self.folder / "before_look/color.png").read_bytes())

    def test_a_finished_simulation_is_gone_on_with_from_its_end(self):
        self.run_in("simulate", "ledge/scene.json", "-o", "ran")
        server = self.server()
        client = self.open(server, "ran")
        picture, iterations = self.paint(client)
        self.assertEqual(iterations, 12 + 7)
        self.wait_until_kept(client)
        server.process.send_signal(signal.SIGKILL)
        server.process.wait()
        again = self.open(self.server(), "ran")
        again.settle()
        self.assertEqual(again.status["iteration"], 12)
        self.assertEqual(self.resume(again, iterations), picture)

    def test_a_recording_that_is_no_recording_is_named_and_left_alone(self):
        server = self.server()
        self.paint(self.open(server))
        server.close()
        file = self.folder / ".studio" / self.recordings()[0]
        file.write_text(file.read_text()[:200])
        client = self.open(self.server())
        self.assertIsNone(client.scene["recording"])
        self.assertTrue(any("cannot be read" in n for n in client.scene["notes"]), client.scene["notes"])
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        wait_until(lambda: len(self.recordings()) == 2, "second recording")

    def test_what_cannot_be_kept_is_said(self):
        (self.folder / ".studio").write_text("a file in the way")
        client = self.open(self.server())
        client.do("event", event={"op": "ratio", "ratio": 0.1})
        client.do("event", event={"op": "ratio", "ratio": 0.2})
        client.until(lambda: client.notices, 10)
        self.assertIn("cannot be kept", client.notices[0])

    def test_recordings_are_no_places(self):
        server = self.server()
        self.assertEqual(server.said["recordings"], str(self.folder.resolve() / ".studio"))
        client = self.open(server)
        self.paint(client)
        self.wait_until_kept(client)
        self.assertEqual([p["place"] for p in server.get_json("/api/places")["places"]], ["ledge/mesh.obj", "ledge/scene.json"])


if __name__ == "__main__":
    unittest.main()
