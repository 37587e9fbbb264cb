"""A running scene in patinate studio, and who watches and drives it: what tests of it share."""
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from studio_client import Client, Server


class LiveCase(unittest.TestCase):
    """A server of `patinate`, and below its folder ledge/scene.json, which runs in a moment; `copies` are names of more scenes like it."""
    patinate, copies = None, ()

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_live_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.run_in("synth", "ledge", "--cells", "6", "-o", "ledge")
        scene = json.loads((cls.folder / "ledge/scene.json").read_text())
        scene["atlas"]["resolution"] = 100
        scene["run"] = {"iterations": 30, "history_every": 10, "controls": ["dirt.deposited"]}
        scene["appearance"]["moss"] = {"height": 0.5}
        for emitter in scene["emitters"]:
            emitter["gammatons"] = 150
        scene["events"] = [{"iteration": 5, "op": "ratio", "ratio": 0.6}]
        cls.written = scene
        for name in ("scene", *cls.copies):
            (cls.folder / f"ledge/{name}.json").write_text(json.dumps(scene))
        cls.server = Server(cls.patinate, cls.folder)
        cls.addClassCleanup(cls.server.close)

    @classmethod
    def run_in(cls, *arguments):
        result = subprocess.run([cls.patinate, *arguments], cwd=cls.folder, capture_output=True, text=True, timeout=300)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}")
        return result

    def client(self, place="ledge/scene.json", **more):
        client = Client(self.server, place, **more)
        self.addCleanup(client.close)
        client.do("reset")
        client.until(lambda: client.status and client.status["iteration"] == 0 and not client.status["running"])
        return client

    def client_without_reset(self, place="ledge/scene.json"):
        client = Client(self.server, place)
        self.addCleanup(client.close)
        return client

    def paint(self, client, *way, emitter="brush"):
        """A stroke along the points of a way, told in two messages."""
        client.do("stroke", emitter=emitter, position=way[0], phase="begin")
        client.do("stroke", emitter=emitter, positions=list(way[1:]), phase="end")
        client.until(lambda: client.status and not client.status["painting"] and client.status["can_undo"])
        client.settle()

    def atlas_hash(self, folder):
        return json.loads((self.folder / folder / "simulation.json").read_text())["atlas_hash"]
