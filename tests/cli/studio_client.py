"""What the tests of the studio need of a browser: HTTP with a token, and a WebSocket (RFC 6455) without extensions."""
import base64
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


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.02)
    return False
