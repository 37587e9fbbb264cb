#!/usr/bin/env python3
"""patinate studio as a browser sees it: who may ask, places, histories and transfers. Usage: studio_test.py PATINATE [unittest arguments]"""
import base64
import json
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import unittest

from small_scene import make_small_scene
from studio_client import Server, WebSocket
from studio_pictures import png_pixels, xxh64

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())


def png_rgb(data):
    width, channels, pixels = png_pixels(data)
    assert channels == 3
    return width, len(pixels) // (3 * width), pixels


def rgb_of(rgba):
    return b"".join(rgba[i:i + 3] for i in range(0, len(rgba), 4))


class Studio(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.outside = pathlib.Path(tempfile.mkdtemp(prefix="patinate_studio_"))
        cls.folder = cls.outside / "served"
        cls.folder.mkdir()
        make_small_scene(PATINATE, cls.folder)
        (cls.folder / "stated.json").write_text(json.dumps({"format": "patinate.appearance", "version": 1, "materials": [
            {"color": "#f0e8d8", "metalness": 0, "roughness": 0.9, "specular": 0.06}, {"color": "#302010", "metalness": 1, "roughness": 0.25, "tint": "#f0ae8c"}]}))
        for arguments in (["texture", "aged", "--time", "11", "-o", "aged_11.png"], ["texture", "aged", "--time", "7.5", "-o", "aged_frame.png"],
                          ["export", "history", "-o", "frames", "--format", "png", "--times", "7.5"],
                          ["history", "material", "history", "stated.json", "-o", "metal"], ["transfer", "metal", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "metal_urn"],
                          *(["lookup", "metal_urn", "--time", "11", "--map", name, "-o", f"metal_{name}.png"] for name in ("base", "orm")), ["synth", "ledge", "--cells", "4", "-o", "ledge"]):
            result = cls.run_in(*arguments)
            if result.returncode != 0:
                raise RuntimeError(f"{arguments}: {result.stderr}")
        (cls.outside / "secret.json").write_text('{"secret": 1}')
        (cls.folder / "link.json").symlink_to(cls.outside / "secret.json")
        (cls.folder / "history/link.json").symlink_to(cls.outside / "secret.json")
        shutil.copytree(cls.folder / "history", cls.folder / "broken")
        (cls.folder / "broken/history.json").write_text("{")
        cls.server = Server(PATINATE, cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.server.close()
        shutil.rmtree(cls.outside)

    @classmethod
    def run_in(cls, *arguments):
        return subprocess.run([PATINATE, *arguments], cwd=cls.folder, capture_output=True, text=True, timeout=300)

    def status(self, target, **more):
        return self.server.request(target, **more)[0]

    # Who may ask.

    def test_the_printed_address_opens_it_and_gives_a_cookie(self):
        status, headers, _ = self.server.request(f"/?token={self.server.token}", token=False)
        self.assertEqual((status, headers["location"]), (303, "/"))
        self.assertRegex(headers["set-cookie"], rf"^patinate-{self.server.port}={self.server.token}; HttpOnly; SameSite=Strict; Path=/$")
        cookie = {"Cookie": headers["set-cookie"].split(";")[0]}
        self.assertEqual(self.status("/", token=False, headers=cookie), 200)
        self.assertEqual(self.status("/api/places", token=False, headers=cookie), 200)
        self.assertIn(f"ssh -L {self.server.port}:127.0.0.1:{self.server.port}", self.server.said["tunnel"])

    def test_refuses_who_has_no_token_or_a_wrong_one(self):
        for target in ("/", "/studio.js", "/api/places", "/api/texture?place=history&time=0", "/api/nothing", "/?token=" + "0" * 32):
            self.assertEqual(self.status(target, token=False), 403, target)
        self.assertEqual(self.status("/api/places", headers={"Authorization": "Bearer " + "0" * 32}), 403)
        self.assertEqual(self.status("/api/quit", method="POST", token=False), 403)
        self.assertEqual(WebSocket(self.server, "/api/live?place=ledge/scene.json", token=False).status, 403)

    def test_refuses_foreign_names_and_pages(self):
        self.assertEqual(self.status("/api/places", headers={"Host": "evil.example"}), 403)
        self.assertEqual(self.status(f"/?token={self.server.token}", token=False, headers={"Host": f"evil.example:{self.server.port}"}), 403)
        self.assertEqual(self.status("/api/places", headers={"Host": "localhost:1", "Origin": "http://localhost:1"}), 200)
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.server.port}", "http://127.0.0.1:1"):
            self.assertEqual(self.status("/api/places", headers={"Origin": origin}), 403, origin)
            self.assertEqual(WebSocket(self.server, "/api/live?place=ledge/scene.json", headers={"Origin": origin}).status, 403, origin)

    def test_an_allowed_host_is_allowed(self):
        server = Server(PATINATE, self.folder / "history", "--allow-host", "lab.example")
        self.assertEqual(server.request("/api/places", headers={"Host": "lab.example:80"})[0], 200)
        self.assertEqual(server.request("/api/places", headers={"Host": "lab.example.evil"})[0], 403)
        server.close()

    def test_nothing_outside_the_folder_is_found(self):
        for place in ("..", "../served/history", "/etc", str(self.outside), "history/../..", "link.json", "%2e%2e", "history%2f..%2f..", "%00", "missing", ""):
            status = self.status(f"/api/place?place={place}")
            self.assertIn(status, (400, 404), place)
        for path in ("../../secret.json", "..%2f..%2fsecret.json", "link.json", "/etc/passwd", "history.json%00.png", "....//secret.json", "%252e%252e/secret.json", ""):
            for route in ("file", "preview"):
                status, _, data = self.server.request(f"/api/{route}?place=history&path={path}")
                self.assertIn(status, (400, 404), path)
                self.assertNotIn(b"secret\": 1", data)

    # It stays up.

    def test_garbage_does_not_end_it(self):
        head = f"Host: localhost\r\nAuthorization: Bearer {self.server.token}\r\n"
        for sent in (b"\x00\xff\x16\x03\x01garbage\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"A" * 100_000, f"GET /{'a' * 50_000} HTTP/1.1\r\n{head}\r\n".encode(),
                     f"POST /api/quit HTTP/1.1\r\n{head}Content-Length: 99999999999\r\n\r\n".encode(), f"POST / HTTP/1.1\r\n{head}Content-Length: -1\r\n\r\n".encode(),
                     f"POST / HTTP/1.1\r\n{head}Content-Length: 18446744073709551616\r\n\r\n".encode(), f"GET / HTTP/1.1\r\n{head}{'X: y' * 9000}\r\n\r\n".encode(),
                     f"POST / HTTP/1.1\r\n{head}Transfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFFF\r\n".encode(),
                     f"GET /api/live HTTP/1.1\r\n{head}Upgrade: websocket\r\nConnection: Upgrade\r\n\r\n".encode(), b""):
            with socket.create_connection(("127.0.0.1", self.server.port), timeout=10) as s:
                try:
                    s.sendall(sent)
                    s.shutdown(socket.SHUT_WR)
                    answer = s.recv(4096)
                except OSError:
                    answer = b""
            if answer:
                self.assertRegex(answer, rb"^HTTP/1.1 4(00|04|05|13|31|26|03)", sent[:60])
        self.assertEqual(self.status("/api/places"), 200)

    def test_wrong_requests_get_a_sentence(self):
        for target, status in (("/api/nothing", 404), ("/api/texture?place=history", 400), ("/api/texture?place=history&time=x", 400), ("/api/texture?place=history&time=nan", 400),
                               ("/api/texture?place=history&time=1&size=0", 400), ("/api/texture?place=history&time=1&tile=3", 400), ("/api/texture?place=history&time=1&map=gold", 400), ("/api/texture?place=history&time=1&map=orm", 400),
                               ("/api/texture?place=history&time=1&map=reflectance", 400), ("/api/texture?place=ledge/mesh.obj&time=1", 400),
                               ("/api/map?place=history&name=control:nothing", 400), ("/api/curve?place=history&x=999&y=0", 400), ("/api/mesh?place=history", 400),
                               ("/api/place?place=broken", 400), ("/api/texture?place=broken&time=0", 400), ("/api/preview?place=history&path=history.json", 400)):
            code, _, data = self.server.request(target)
            self.assertEqual(code, status, target)
            self.assertGreater(len(json.loads(data)["error"]), 10)
        self.assertEqual(self.status("/api/places", method="POST", body=b"{}"), 404)
        self.assertEqual(self.status("/api/texture?place=history&time=0", method="DELETE"), 405)

    def test_many_ask_at_once(self):
        """Slow readers and those that go away leave the others alone."""
        idle = [socket.create_connection(("127.0.0.1", self.server.port)) for _ in range(20)]
        for i in range(10):
            with socket.create_connection(("127.0.0.1", self.server.port)) as s:
                s.sendall(f"GET /api/texture?place=aged&time={i} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {self.server.token}\r\n\r\n".encode())
        self.assertEqual(self.status("/api/texture?place=aged&time=3"), 200)
        for s in idle:
            s.close()

    # What it shows.

    def test_lists_what_lies_in_the_folder(self):
        said = self.server.get_json("/api/places")
        self.assertEqual(said["folder"], str(self.folder))
        kinds = {p["place"]: p["kind"] for p in said["places"]}
        self.assertEqual(kinds, {"aged": "transfer", "broken": "history", "capture": "ingest", "history": "history", "ledge/mesh.obj": "mesh", "ledge/scene.json": "scene", "metal": "history", "metal_urn": "transfer",
                                 "urn/mesh.obj": "mesh"})
        by_name = {p["place"]: p for p in said["places"]}
        self.assertEqual(by_name["history"]["detail"], "4 frames, 48 x 40, 0-22.5 s")
        self.assertIn("problem", by_name["broken"])
        self.assertRegex(by_name["aged"]["modified"], r"^20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ$")

    def test_a_place_may_be_the_folder_itself(self):
        server = Server(PATINATE, self.folder / "history")
        self.assertEqual([p["place"] for p in server.get_json("/api/places")["places"]], ["."])
        self.assertEqual(server.get_json("/api/place?place=.")["kind"], "history")
        server.close()

    def test_says_what_a_place_is(self):
        history = self.server.get_json("/api/place?place=history")
        self.assertEqual((history["width"], history["height"], history["unit"], history["times"]), (48, 40, "s", [0, 7.5, 15, 22.5]))
        self.assertEqual([c["name"] for c in history["controls"]], ["thickness"])
        aged = self.server.get_json("/api/place?place=aged")
        self.assertEqual((aged["width"], aged["height"], aged["mesh"], aged["source"]), (64, 64, True, "history"))
        capture = self.server.get_json("/api/place?place=capture")
        self.assertEqual(len([s for s in capture["steps"] if s["name"].endswith(" s")]), 4)
        picture = capture["steps"][-1]["pictures"][0]["path"]
        status, headers, data = self.server.request(f"/api/preview?place=capture&path={picture}&width=32")
        self.assertEqual((status, headers["content-type"], data[:2]), (200, "image/jpeg", b"\xff\xd8"))

    def test_a_texture_is_what_lookup_writes(self):
        for time_, file in ((11, "aged_11.png"), (7.5, "aged_frame.png")):
            width, height, expected = png_rgb((self.folder / file).read_bytes())
            _, headers, raw = self.server.request(f"/api/texture?place=aged&time={time_}")
            self.assertEqual((int(headers["x-width"]), int(headers["x-height"])), (width, height))
            self.assertTrue(rgb_of(raw) == expected, f"texels differ at time {time_}")
            _, png_headers, png = self.server.request(f"/api/texture?place=aged&time={time_}&format=png")
            self.assertTrue(png_rgb(png)[2] == expected)
            self.assertEqual(png_headers["x-hash"], headers["x-hash"])
            self.assertEqual(headers["x-hash"], xxh64(raw))

    def test_a_material_is_what_lookup_writes(self):
        place = json.loads(self.server.request("/api/place?place=metal_urn")[2])
        self.assertEqual(place["material"], ["base", "orm", "reflectance"])
        self.assertEqual(json.loads(self.server.request("/api/place?place=aged")[2])["material"], [])
        for name in ("base", "orm"):
            expected = png_rgb((self.folder / f"metal_{name}.png").read_bytes())[2]
            raw = self.server.request(f"/api/texture?place=metal_urn&time=11&map={name}")[2]
            self.assertTrue(rgb_of(raw) == expected, name)
        status, _, session = self.server.request("/api/session", method="POST", body=json.dumps({"place": "metal_urn", "times": [11], "size": 64}).encode())
        self.assertEqual((status, session.count(b"map=orm")), (200, 1))

    def test_a_history_at_a_frames_time_is_that_frame(self):
        _, _, expected = png_rgb(next((self.folder / "frames").glob("*.png")).read_bytes())
        for between in ("blend", "hold", "nearest"):
            self.assertTrue(rgb_of(self.server.request(f"/api/texture?place=history&time=7.5&between={between}")[2]) == expected, between)
        held = self.server.request("/api/texture?place=history&time=14&between=hold")[2]
        self.assertTrue(rgb_of(held) == expected)

    def test_textures_get_smaller(self):
        _, headers, raw = self.server.request("/api/texture?place=history&time=3&size=24")
        self.assertEqual((headers["x-width"], headers["x-height"], len(raw)), ("24", "20", 24 * 20 * 4))

    def test_curves_follow_the_coordinates_into_the_history(self):
        _, headers, data = self.server.request("/api/map?place=aged&name=coordinates")
        self.assertEqual(headers["x-channels"], "2")
        coordinates = struct.unpack(f"<{64 * 64 * 2}f", data)
        inside = next(i for i in range(64 * 64) if coordinates[2 * i] >= 0)
        outside = next(i for i in range(64 * 64) if coordinates[2 * i] < 0)
        curve = self.server.get_json(f"/api/curve?place=aged&x={inside % 64}&y={inside // 64}")
        x, y = int(coordinates[2 * inside] + 0.5), int(coordinates[2 * inside + 1] + 0.5)  # The nearest pixel; colors are those of the place itself.
        self.assertEqual(curve["source"], {"place": "history", "x": x, "y": y})
        self.assertEqual(curve["times"], self.server.get_json(f"/api/curve?place=history&x={x}&y={y}")["times"])
        raw = self.server.request("/api/texture?place=aged&time=7.5")[2]
        self.assertEqual(list(raw[4 * inside:4 * inside + 3]), curve["srgb"][1])
        self.assertIsNone(self.server.get_json(f"/api/curve?place=aged&x={outside % 64}&y={outside // 64}")["source"])

    def test_maps_come_as_floats(self):
        _, headers, data = self.server.request("/api/map?place=aged&name=control:thickness")
        values = struct.unpack(f"<{64 * 64}f", data)
        self.assertEqual((headers["x-width"], headers["x-channels"]), ("64", "1"))
        self.assertTrue(0 <= min(values) and max(values) <= 1)
        self.assertLess(float(headers["x-low"]), float(headers["x-high"]))
        self.assertEqual(len(self.server.request("/api/map?place=history&name=mask:1")[2]), 48 * 40 * 4)

    def test_meshes_are_glb_files(self):
        for place in ("aged", "ledge/scene.json", "urn/mesh.obj"):
            status, headers, glb = self.server.request(f"/api/mesh?place={place}")
            self.assertEqual((status, headers["content-type"], glb[:4], struct.unpack("<I", glb[8:12])[0]), (200, "model/gltf-binary", b"glTF", len(glb)), place)
            size = struct.unpack("<I", glb[12:16])[0]
            gltf = json.loads(glb[20:20 + size])
            self.assertNotIn("images", gltf)
            self.assertIn("TEXCOORD_0", gltf["meshes"][0]["primitives"][0]["attributes"])

    def test_pages_of_the_folder_run_as_strangers(self):
        status, headers, data = self.server.request("/api/file?place=history&path=history.json")
        self.assertEqual((status, json.loads(data)["format"]), (200, "patinate.history"))
        self.assertIn("sandbox", headers["content-security-policy"])
        self.assertEqual(self.status("/api/file?place=urn/mesh.obj&path=mesh.obj"), 200)

    # Without a server.

    def session_of(self, page):
        text = page.split("window.PATINATE_SESSION=", 1)[1].split(";\n</script>", 1)[0]
        self.assertNotIn("<", text)  # nothing in it ends or begins an element of the page
        return json.loads(text)

    def test_a_session_is_one_page_with_the_servers_answers(self):
        if b"studio.js" not in self.server.request("/")[2]:
            self.skipTest("built without the client")
        body = json.dumps({"place": "aged", "times": [0, 11], "size": 32, "view": {"time": 11, "note": "</script><script>alert(1)"}})
        status, headers, page = self.server.request("/api/session", method="POST", body=body)
        self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"))
        page = page.decode()
        self.assertNotIn("src=\"/", page)
        self.assertNotIn("href=\"/", page)
        session = self.session_of(page)
        self.assertEqual((session["place"], session["view"]["time"]), ("aged", 11))
        for time_ in (0, 11):
            url = f"/api/texture?place=aged&time={time_}&size=32&format=png"
            _, asked, png = self.server.request(url)
            self.assertEqual(base64.b64decode(session["responses"][url]["base64"]), png)
            self.assertEqual(session["responses"][url]["headers"]["X-Hash"], asked["x-hash"])
        self.assertEqual(base64.b64decode(session["responses"]["/api/mesh?place=aged"]["base64"]), self.server.request("/api/mesh?place=aged")[2])
        self.assertEqual(json.loads(base64.b64decode(session["responses"]["/api/place?place=aged"]["base64"]))["kind"], "transfer")
        self.assertIn("/api/map?place=aged&name=control:thickness&size=16", session["responses"])
        coordinates = session["responses"]["/api/map?place=aged&name=coordinates"]
        self.assertEqual((coordinates["headers"]["X-Width"], len(base64.b64decode(coordinates["base64"]))), ("16", 16 * 16 * 8))

    def test_a_session_is_saved_without_serving(self):
        if b"studio.js" not in self.server.request("/")[2]:
            self.skipTest("built without the client")
        file = self.outside / "aged.html"
        result = self.run_in("studio", ".", "--save", str(file), "--place", "history", "--size", "24")
        self.assertEqual(result.returncode, 0, result.stderr)
        session = self.session_of(file.read_text())
        self.assertEqual(len([u for u in session["responses"] if u.startswith("/api/texture")]), 4)  # the history's frames
        self.assertEqual(self.run_in("studio", ".", "--save", str(file), "--place", "history").returncode, 1)  # it exists
        self.assertEqual(self.run_in("studio", "history", "--save", str(file), "--times", "3", "--force").returncode, 0)  # the folder itself
        late = self.run_in("studio", "history", "--save", str(file), "--times", "-30000000,3,100000", "--force")
        self.assertEqual(late.returncode, 0, late.stderr)
        addresses = [u for u in self.session_of(file.read_text())["responses"] if u.startswith("/api/texture")]
        self.assertEqual([re.search("time=([^&]*)", u)[1] for u in addresses], ["-30000000", "3", "100000"])  # as a browser writes them
        for wrong in (["--place", "nothing"], ["--place", "ledge/mesh.obj"], ["--place", "../secret.json"]):
            self.assertEqual(self.run_in("studio", ".", "--save", str(self.outside / "x.html"), *wrong).returncode, 3, wrong)
        said = self.run_in("studio", ".", "--save", str(self.outside / "x.html"), "--place", "histry").stderr
        self.assertIn("did you mean `history`?", said)
        self.assertIn("ledge/scene.json", said)  # What there is.
        self.assertEqual(self.run_in("studio", ".", "--save", "x.txt", "--place", "history").returncode, 2)
        self.assertFalse((self.outside / "x.html").exists())

    def test_wrong_sessions_get_a_sentence(self):
        for body, status in (("{", 400), ("[]", 400), ("{}", 400), ('{"place": 3}', 400), ('{"place": "nothing"}', 404), ('{"place": "history", "size": 0}', 400),
                             ('{"place": "history", "times": ["x"]}', 400), ('{"place": "ledge/mesh.obj"}', 400), ('{"place": "history", "more": 1}', 400), ("[" * 100_000, 400)):
            self.assertEqual(self.status("/api/session", method="POST", body=body), status, body[:60])

    # It ends.

    def test_ends_when_asked(self):
        server = Server(PATINATE, self.folder / "history")
        self.assertEqual(server.request("/api/quit", method="POST", body=b"")[0], 200)
        self.assertEqual(server.process.wait(timeout=20), 0)
        server.close()
        server = Server(PATINATE, self.folder / "history")
        server.process.send_signal(signal.SIGINT)
        self.assertEqual(server.process.wait(timeout=20), 130)
        server.close()

    def test_starts_again_on_its_port_after_a_kill(self):
        server = Server(PATINATE, self.folder / "history")
        server.request("/api/places")
        server.process.kill()
        server.close()
        again = Server(PATINATE, self.folder / "history", "--port", str(server.port))
        self.assertEqual(again.request("/api/places")[0], 200)
        self.assertNotEqual(again.token, server.token)
        other = subprocess.run([PATINATE, "studio", str(self.folder), "--port", str(server.port)], capture_output=True, text=True, timeout=60)
        self.assertEqual(other.returncode, 1)
        self.assertRegex(other.stderr, r"^patinate: error: port \d+: .*--port")
        again.close()

    def test_a_wrong_folder_is_an_error(self):
        result = subprocess.run([PATINATE, "studio", str(self.folder / "nothing")], capture_output=True, text=True, timeout=60)
        self.assertEqual((result.returncode, len(result.stderr.strip().splitlines())), (3, 1))


if __name__ == "__main__":
    unittest.main()
