#!/usr/bin/env python3
"""patinate studio at its doors: files that name files outside, and connections that never say who they are. Usage: studio_doors_test.py PATINATE [unittest arguments]"""
import http.client
import json
import pathlib
import select
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from small_scene import make_small_scene
from studio_client import Server, WebSocket, wait_until

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


class NamedOutside(unittest.TestCase):
    """served/ holds what names files beside it: outside/history, outside/urn, outside/ledge."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_doors_"))
        cls.outside, cls.served = cls.folder / "outside", cls.folder / "served"
        cls.outside.mkdir()
        cls.served.mkdir()
        make_small_scene(PATINATE, cls.outside)
        cls.run_in(cls.outside, "synth", "ledge", "--cells", "4", "-o", "ledge", check=True)
        scene = json.loads((cls.outside / "ledge/scene.json").read_text())
        scene["atlas"] = {"resolution": 64}
        scene["run"] = {"iterations": 2, "history_every": 1}
        for emitter in scene["emitters"]:
            emitter["gammatons"] = 50
        (cls.outside / "ledge/scene.json").write_text(json.dumps(scene))
        history = json.loads((cls.outside / "history/history.json").read_text())

        def history_with(name, change):
            shutil.copytree(cls.outside / "history", cls.served / name, symlinks=True)
            changed = json.loads(json.dumps(history))
            change(changed)
            (cls.served / name / "history.json").write_text(json.dumps(changed))
        history_with("whole", lambda h: None)
        history_with("frames", lambda h: h["frames"][0].update(file="../../outside/history/" + h["frames"][0]["file"]))
        history_with("absolute", lambda h: h["frames"][0].update(file=str(cls.outside / "history" / h["frames"][0]["file"])))
        history_with("masks", lambda h: h["frames"][0].update(mask="../../outside/history/mask.png") if (cls.outside / "history/mask.png").exists() else h["frames"][1].update(file="../../outside/history/" + h["frames"][1]["file"]))
        history_with("controls", lambda h: h["controls"][0].update(file="../../outside/history/" + h["controls"][0]["file"]))
        history_with("linked", lambda h: None)
        frame = cls.served / "linked" / history["frames"][0]["file"]
        frame.unlink()
        frame.symlink_to(cls.outside / "history" / history["frames"][0]["file"])
        history_with("linked_inside", lambda h: None)
        frame = cls.served / "linked_inside" / history["frames"][0]["file"]
        frame.unlink()
        frame.symlink_to(cls.served / "whole" / history["frames"][0]["file"])
        shutil.copytree(cls.outside / "aged", cls.served / "aged")
        manifest = json.loads((cls.served / "aged/transfer.json").read_text())
        manifest["history"]["path"] = "../../outside/history"
        (cls.served / "aged/transfer.json").write_text(json.dumps(manifest))
        (cls.served / "scenes").mkdir()
        (cls.served / "scenes/mesh.json").write_text(json.dumps({**scene, "objects": [{**scene["objects"][0], "mesh": "../../outside/ledge/mesh.obj"}]}))
        shutil.copy(cls.outside / "ledge/mesh.obj", cls.served / "scenes/mesh.obj")
        (cls.served / "scenes/picture.json").write_text(json.dumps({**scene, "appearance": {**scene.get("appearance", {}), "dirt": {"color": "../../outside/capture/" + cls.picture_of_capture()}}}))
        (cls.served / "scenes/rule.json").write_text(json.dumps({**scene, "rules": ["../../outside/rule.json"]}))
        (cls.outside / "rule.json").write_text(json.dumps({"format": "patinate.rule", "version": 2, "name": "mine", "driver": "water", "reactants": {"water": 1}}))
        (cls.outside / "triangle.bin").write_bytes(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0))
        gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "../outside/triangle.bin"}]}
        (cls.served / "triangle.gltf").write_text(json.dumps(gltf))
        cls.server = Server(PATINATE, cls.served)

    @classmethod
    def picture_of_capture(cls):
        return next(str(p.relative_to(cls.outside / "capture")) for p in sorted((cls.outside / "capture").rglob("*.png")))

    @classmethod
    def tearDownClass(cls):
        cls.server.close()
        shutil.rmtree(cls.folder)

    @classmethod
    def run_in(cls, folder, *arguments, check=False):
        result = subprocess.run([PATINATE, *arguments], cwd=folder, capture_output=True, text=True, timeout=300)
        if check and result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")
        return result

    def refused(self, target):
        status, _, data = self.server.request(target)
        self.assertEqual(status, 400, target)
        self.assertIn("lies outside of", json.loads(data)["error"], target)

    def live_error(self, place, server=None):
        websocket = WebSocket(server or self.server, f"/api/live?place={place}")
        message = websocket.receive()
        while message and not isinstance(message, tuple) and message["type"] == "progress":
            message = websocket.receive()
        websocket.close()
        return message

    def test_frames_masks_and_controls_outside_are_not_shown(self):
        for place in ("frames", "absolute", "masks", "controls", "linked"):
            for request in ("place?", "texture?time=0&", "curve?x=20&y=20&", "map?name=control:thickness&"):
                self.refused(f"/api/{request}place={place}")
        listed = {p["place"]: p for p in self.server.get_json("/api/places")["places"]}
        self.assertIn("whole", listed)

    def test_links_that_stay_inside_are_followed(self):
        for place in ("whole", "linked_inside"):
            self.assertEqual(self.server.request(f"/api/texture?place={place}&time=0")[0], 200, place)

    def test_a_transfer_of_a_history_outside_is_not_shown_unless_its_folder_is_allowed(self):
        for request in ("place?", "texture?time=0&", "map?name=coordinates&", "mesh?"):
            self.refused(f"/api/{request}place=aged")
        server = Server(PATINATE, self.served, "--allow-folder", str(self.outside / "history"))
        self.assertEqual(server.request("/api/texture?place=aged&time=0")[0], 200)
        self.assertIsNone(server.get_json("/api/place?place=aged")["source"])  # read, and yet no place of its own
        self.assertEqual(server.request("/api/place?place=../outside/history")[0], 404)
        self.assertEqual(server.request("/api/texture?place=frames&time=0")[0], 200)
        self.assertEqual(server.request("/api/mesh?place=triangle.gltf")[0], 400)  # that folder, and no other
        server.close()
        wrong = subprocess.run([PATINATE, "studio", str(self.served), "--allow-folder", "nowhere"], capture_output=True, text=True, timeout=60)
        self.assertEqual((wrong.returncode, len(wrong.stderr.splitlines())), (3, 1), wrong.stderr)

    def test_meshes_pictures_and_rules_of_scenes_outside_are_not_read(self):
        for name in ("mesh", "picture", "rule"):
            self.refused(f"/api/mesh?place=scenes/{name}.json")
            said = self.live_error(f"scenes/{name}.json")
            self.assertEqual((said["type"], said["fatal"]), ("error", True), said)
            self.assertIn("lies outside of", said["message"])

    def test_buffers_of_a_gltf_outside_are_not_read(self):
        self.refused("/api/mesh?place=triangle.gltf")

    def test_commands_read_everything(self):
        """What a user types is the user's; only what is shown to others is bounded."""
        for place in ("frames", "linked", "controls"):
            result = self.run_in(self.served, "export", place, "-o", f"../exported_{place}", "--format", "png", "--times", "0")
            self.assertEqual(result.returncode, 0, result.stderr)
        result = self.run_in(self.folder, "studio", "served", "--save", "page.html", "--place", "aged", "--size", "16")
        if "without the studio's pages" not in result.stderr:
            self.assertEqual(result.returncode, 0, result.stderr)

    # A scene that cannot be opened.

    def test_why_a_scene_cannot_run_is_one_line_with_a_status(self):
        broken = json.loads((self.served / "scenes/rule.json").read_text())
        (self.served / "scenes/broken.json").write_text(json.dumps({**broken, "rules": [], "objects": [{"name": "wall", "mesh": "missing.obj"}]}))
        self.assertEqual(self.server.get_json("/api/live?place=scenes/broken.json"), {"state": "none"})
        websocket = WebSocket(self.server, "/api/live?place=scenes/broken.json")
        messages = []
        while (message := websocket.receive(20)) is not None:
            messages.append(message)
        self.assertTrue(messages[-1]["fatal"])
        self.assertIn("missing.obj", messages[-1]["message"])
        self.assertEqual(websocket.close_code, 4400)
        self.assertTrue(messages[-1]["message"].startswith(websocket.close_reason))
        for request in ("live", "mesh"):
            status, _, data = self.server.request(f"/api/{request}?place=scenes/broken.json")
            error = json.loads(data)["error"]
            self.assertEqual((status, len(error.splitlines())), (400, 1))
            self.assertIn("missing.obj", error)
        self.assertEqual(self.server.request("/api/live?place=whole")[0], 400)
        self.assertEqual(self.server.request("/api/live?place=nothing")[0], 404)


class Strangers(unittest.TestCase):
    """Connections from this machine that show no token."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_strangers_"))
        self.server = Server(PATINATE, self.folder)
        self.sockets = []

    def tearDown(self):
        for s in self.sockets:
            s.close()
        self.server.close()
        shutil.rmtree(self.folder)

    def strangers(self, count, sent=b""):
        for _ in range(count):
            self.sockets.append(socket.create_connection(("127.0.0.1", self.server.port), timeout=20))
            if sent:
                self.sockets[-1].sendall(sent)
        if count > 100:  # all have come in once the last one that has to go is gone
            gone = select.poll()
            gone.register(self.sockets[-101], select.POLLRDHUP)
            self.assertTrue(gone.poll(60_000), "as many sit there as came")

    def seconds_of_a_request(self):
        begin = time.monotonic()
        self.assertEqual(self.server.request("/api/places", timeout=20)[0], 200)
        return time.monotonic() - begin

    def test_however_many_sit_there_who_has_the_token_is_heard(self):
        for sent in (b"", b"GET / HTTP/1.1\r\nHost: loc", b"POST /api/quit HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\nx"):
            self.strangers(250, sent)
            for _ in range(5):
                self.assertLess(self.seconds_of_a_request(), 2.0, sent)
            self.assertEqual(WebSocket(self.server, "/api/live?place=nothing").status, 101)

    def test_they_have_five_seconds_even_byte_by_byte(self):
        self.strangers(1)
        begin = time.monotonic()
        dripping = self.sockets[-1]
        dripping.settimeout(0.2)
        for byte in b"GET /" + b"a" * 100:
            try:
                dripping.sendall(bytes([byte]))
                if dripping.recv(1) == b"":
                    break
            except socket.timeout:
                continue
            except OSError:
                break
        self.assertLess(time.monotonic() - begin, 9.0)
        self.assertGreater(time.monotonic() - begin, 3.0)

    def test_a_refused_one_stays_a_stranger(self):
        self.strangers(150, b"GET /api/places HTTP/1.1\r\nHost: localhost\r\n\r\n")
        self.assertLess(self.seconds_of_a_request(), 2.0)
        self.assertRegex(self.sockets[-1].recv(100), rb"^HTTP/1.1 403")

    def test_a_known_one_is_not_turned_away_by_strangers(self):
        known = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
        for _ in range(3):
            known.request("GET", "/api/places", headers={"Authorization": "Bearer " + self.server.token})
            answer = known.getresponse()
            answer.read()
            self.assertEqual(answer.status, 200)
            own = known.sock
            self.strangers(150)
            self.assertIs(known.sock, own)  # the same connection all along

    def test_too_many_known_ones_are_told(self):
        request = f"GET /api/places HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {self.server.token}\r\n\r\n".encode()
        answers = []
        for _ in range(101):
            self.sockets.append(socket.create_connection(("127.0.0.1", self.server.port), timeout=20))
            self.sockets[-1].sendall(request)
            answers.append(self.sockets[-1].recv(12)[-3:])
        self.assertEqual(answers, [b"200"] * 100 + [b"503"])
        for s in self.sockets:
            s.close()
        wait_until(lambda: self.server.request("/api/places")[0] == 200, "place for another one")
        self.assertLess(self.seconds_of_a_request(), 2.0)


if __name__ == "__main__":
    unittest.main()
