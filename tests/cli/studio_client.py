"""What the tests of the studio need of a browser: HTTP with a token, a WebSocket (RFC 6455) without extensions, and a client of a running scene."""
import base64
import hashlib
import http.client
import json
import os
import pathlib
import socket
import struct
import subprocess
import time


class Server:
    """`patinate studio` on a free port, until close()."""

    def __init__(self, patinate, folder, *options):
        self.process = subprocess.Popen([patinate, "studio", str(folder), "--json", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError(self.process.stderr.read())
            text += line
        said = json.loads(text)
        self.port, self.token, self.said = said["port"], said["token"], said

    def request(self, target, method="GET", body=None, headers=None, token=True, timeout=60):
        """Status, headers in lower case, bytes."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        headers = dict(headers or {})
        if token:
            headers.setdefault("Authorization", "Bearer " + self.token)
        connection.request(method, target, body=body, headers=headers)
        response = connection.getresponse()
        data = response.read()
        connection.close()
        return response.status, {k.lower(): v for k, v in response.getheaders()}, data

    def get_json(self, target, **more):
        status, _, data = self.request(target, **more)
        if status != 200:
            raise AssertionError(f"{target}: {status} {data[:300]}")
        return json.loads(data)

    def memory_mb(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.communicate(timeout=60)
        return self.process.returncode


class WebSocket:
    """Text messages as JSON, binary ones as bytes."""

    def __init__(self, server, target, headers=None, token=True):
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=60)
        sent = {"Host": f"127.0.0.1:{server.port}", "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode()}
        if token:
            sent["Authorization"] = "Bearer " + server.token
        sent.update(headers or {})
        self.socket.sendall((f"GET {target} HTTP/1.1\r\n" + "".join(f"{k}: {v}\r\n" for k, v in sent.items()) + "\r\n").encode())
        self.rest, self.close_code, self.close_reason = b"", None, ""
        head = b""
        while b"\r\n\r\n" not in head:
            more = self.socket.recv(4096)
            if not more:
                break
            head += more
        head, _, self.rest = head.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head else 0
        if self.status != 101:
            self.socket.close()

    def read(self, count):
        while len(self.rest) < count:
            more = self.socket.recv(1 << 16)
            if not more:
                raise ConnectionError("closed")
            self.rest += more
        data, self.rest = self.rest[:count], self.rest[count:]
        return data

    def send(self, message):
        self.send_frame(1, json.dumps(message).encode() if not isinstance(message, bytes) else message)

    def send_frame(self, opcode, data):
        mask = os.urandom(4)
        length = len(data)
        header = bytes([0x80 | opcode])
        header += bytes([0x80 | length]) if length < 126 else bytes([0x80 | 126]) + struct.pack(">H", length) if length < 65536 else bytes([0x80 | 127]) + struct.pack(">Q", length)
        self.socket.sendall(header + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))

    def receive(self, timeout=60):
        """A dict for text, (header, payload) for binary; None when it has closed or nothing came."""
        self.socket.settimeout(timeout)
        data, opcode = b"", 0
        try:
            while True:
                first, second = self.read(2)
                length = second & 127
                if length == 126:
                    length = struct.unpack(">H", self.read(2))[0]
                elif length == 127:
                    length = struct.unpack(">Q", self.read(8))[0]
                part = self.read(length)
                if first & 15 == 9:
                    self.send_frame(10, part)
                    continue
                if first & 15 == 8:
                    if len(part) >= 2:
                        self.close_code, self.close_reason = struct.unpack(">H", part[:2])[0], part[2:].decode()
                    return None
                opcode = opcode or first & 15
                data += part
                if first & 0x80:
                    break
        except (socket.timeout, ConnectionError):
            return None
        if opcode == 1:
            return json.loads(data)
        size = struct.unpack("<I", data[:4])[0]
        return json.loads(data[4:4 + size]), data[4 + size:]

    def close(self):
        self.socket.close()


class Client:
    """One that watches a running scene: keeps the picture that it is sent; acknowledges updates unless told not to."""

    def __init__(self, server, place="ledge/scene.json", acknowledges=True):
        self.socket = WebSocket(server, f"/api/live?place={place}")
        self.acknowledges, self.updates, self.answers, self.status, self.notices, self.errors, self.hashes = acknowledges, [], {}, None, [], [], []
        self.scene, self.planes, self.gammatons, self.outcome, self.next_id = {}, {}, None, None, 0
        self.until(lambda: self.scene)
        self.start = json.loads(json.dumps(self.scene["appearance"]))

    def until(self, condition, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            left = end - time.monotonic()
            if left <= 0 or not self.listen(left):
                raise AssertionError(f"nothing came; errors: {self.errors}, status: {self.status}")

    def listen(self, seconds):
        """Takes one message. False when none came."""
        message = self.socket.receive(seconds)
        if message is None:
            return False
        if isinstance(message, tuple):
            self.take(*message)
        elif message["type"] in ("hello", "scene"):
            self.scene.update(message)
        elif message["type"] == "status":
            self.status = message
        elif message["type"] == "hash":
            self.hashes.append(message)
        elif message["type"] == "outcome":
            self.outcome = message
        elif message["type"] in ("done", "error"):
            self.answers[message["id"]] = message
            if message["type"] == "error":
                self.errors.append(message["message"])
        elif message["type"] == "notice":
            self.notices.append(message["text"])
        return True

    def take(self, header, payload):
        if header["type"] == "gammatons":
            self.gammatons = struct.unpack(f"<{header['count'] * 3}f", payload)
            return
        size = {"surface": 256, "relief": 256, "material": 256, "overlay": 64}[header["plane"]]
        count, texel, columns = header["count"], size // 64, (header["width"] + 7) // 8
        assert len(payload) == count * (4 + size), header
        plane = self.planes.setdefault(header["plane"], bytearray(header["width"] * header["height"] * texel))
        for k, tile in enumerate(struct.unpack(f"<{count}I", payload[:4 * count])):
            data = payload[4 * count + k * size:4 * count + (k + 1) * size]
            for row in range(8):
                x, y = tile % columns * 8, tile // columns * 8 + row
                if y < header["height"]:
                    at, length = (y * header["width"] + x) * texel, min(8, header["width"] - x) * texel
                    plane[at:at + length] = data[row * 8 * texel:row * 8 * texel + length]
        if header["last"]:
            self.updates.append(header)
            if self.acknowledges:
                self.socket.send({"op": "ack", "update": header["update"]})

    def ask(self, op, **more):
        """Sends a request and waits for its answer."""
        self.next_id += 1
        self.socket.send({"op": op, "id": self.next_id, **more})
        self.until(lambda: self.next_id in self.answers)
        return self.answers.pop(self.next_id)

    def do(self, op, **more):
        answer = self.ask(op, **more)
        if answer["type"] != "done":
            raise AssertionError(f"{op}: {answer}")

    def step(self, iterations):
        """Runs so many iterations and waits for the picture after the last."""
        begin = self.status["iteration"] if self.status else 0
        self.do("step", iterations=iterations)
        self.until(lambda: self.status and not self.status["running"] and self.status["iteration"] >= begin + iterations)
        self.settle()

    def settle(self):
        """Waits for a hash and the update that brings the picture to it."""
        self.hashes.clear()
        self.do("hash")
        self.until(lambda: self.hashes)
        count = len(self.updates)
        self.until(lambda: len(self.updates) > count)
        return self.hashes[-1]

    def leave(self):
        """Hangs up; afterwards the scene knows."""
        self.acknowledges = False
        self.socket.socket.shutdown(socket.SHUT_WR)
        while self.listen(60):
            pass
        self.close()

    def surface(self):
        return hashlib.sha256(bytes(self.planes["surface"])).hexdigest()

    def close(self):
        self.socket.close()


def wait_until(condition, what, seconds=60):
    """@returns what the condition says once that is true."""
    end = time.monotonic() + seconds
    while not (said := condition()):
        if time.monotonic() > end:
            raise AssertionError(f"no {what} in {seconds} s")
        time.sleep(0.01)
    return said


def kill_when_there_is(path, process):
    wait_until(lambda: path.exists() or process.poll() is not None, path)
    assert process.poll() is None, f"ended before there was {path}"
    process.kill()
    process.wait()
