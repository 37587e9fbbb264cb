#!/usr/bin/env python3
"""Equal work gives equal bytes: another number of threads, another name of the output, other spellings of the paths.
Usage: same_bytes_test.py PATINATE [unittest arguments]

run.json is the file for what differs from run to run. Per commit four commands; job_plans_test.cpp asks all of them in one process.
"""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from command_case import four_per_commit

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_same_"))
MOLD = ["synth", "mold", "--width", "64", "--height", "48", "--steps", "2", "--lights", "4", "--scan-spacing", "3"]


def run(arguments, cwd=WORK):
    result = subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)
    if result.returncode != 0:
        raise AssertionError(f"{arguments}: {result.stderr}")


def setUpModule():
    (WORK / "elsewhere").mkdir()
    for arguments in (["synth", "crackle", "--width", "64", "--height", "48", "--num-frames", "8", "-o", "capture"], ["synth", "sculpture", "--resolution", "24", "-o", "urn"],
                      ["synth", "ledge", "-o", "ledge"], [*MOLD, "-o", "mold"], ["ingest", "capture", "-o", "history"],
                      ["transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "64", "-o", "aged"],
                      ["control", "urn/mesh.obj", "--kind", "facing", "--resolution", "64", "-o", "facing.exr"],
                      ["simulate", "ledge/scene.json", "--resolution", "64", "--iterations", "20", "--history-every", "10", "-o", "rain"]):
        run(arguments)
    # Another tool's map: every pixel of 64 x 48 where it is.
    (WORK / "same.nnf").write_bytes(b"".join(struct.pack("<ii", x, y) for y in range(48) for x in range(64)))


def tearDownModule():
    shutil.rmtree(WORK)


def tree_of(path):
    if path.is_file():
        return {"": path.read_bytes()}
    return {str(p.relative_to(path)): p.read_bytes() for p in sorted(path.rglob("*")) if p.is_file() and p.name != "run.json"}


# Words that are paths begin with "@".
COMMANDS = {
    "ingest": ["ingest", "@capture", "--progress"],
    "relit": ["ingest", "@mold"],
    "transfer": ["transfer", "@history", "@urn/mesh.obj", "--control", "thickness=facing", "--resolution", "64"],
    "combine": ["history", "combine", "@history", "@history"],
    "trim": ["history", "trim", "@history", "--every", "2"],
    "appearance": ["history", "material", "@history", "--metalness", "1"],
    "evaluate": ["evaluate", "@aged", "--audits", "20"],
    "evaluate_foreign": ["evaluate", "@same.nnf", "--history", "@history", "--control", "@history/controls/thickness.exr", "--audits", "20"],
    "compare": ["history", "compare", "@history", "@aged", "--through", "@aged", "--num-resamples", "5"],
    "factorize": ["history", "factorize", "@history", "--num-intervals", "16", "--num-training", "48"],
    "simulate": ["simulate", "@ledge/scene.json", "--resolution", "64", "--iterations", "20"],
    "recompose": ["simulate", "restyle", "@rain"],
    "glb": ["export", "@aged", ".glb"],
    "export_gif": ["export", "@aged", "--num-times", "3", ".gif"],
    "export_sequence": ["export", "@aged", "--num-times", "3"],
    "lookup": ["texture", "@aged", "--time", "20", ".png"],
    "render": ["render", "@aged", "--time", "20", "--width", "64", ".png"],
    "control": ["control", "@urn/mesh.obj", "--kind", "facing", "--resolution", "64", ".exr"],
    "accessibility": ["control", "accessibility", "@mold/step00/scan.ply"],
    "thickness": ["thickness", "@capture/backlight.png", ".exr"],
    "register": ["register", "@mold/step00/scan.ply", "@mold/step01/scan.ply"],
}


class SameBytes(unittest.TestCase):
    def check(self, name):
        words = COMMANDS[name]
        suffix = words[-1] if words[-1].startswith(".") else ""
        words = words[:-1] if suffix else words
        plain = [w.replace("@", "") for w in words]
        spelled = [w.replace("@", str(WORK) + "/elsewhere/../") for w in words]
        # Folders go by two names; files stand in two folders, since the node of a GLB bears the file's name.
        outputs = [WORK / "one" / (name + suffix), WORK / "another" / (name + suffix if suffix else name + "_again")]
        for output in outputs:
            output.parent.mkdir(exist_ok=True)
        run([*plain, "--threads", 1, "-o", outputs[0]])
        run([*spelled, "--threads", 3, "--quiet", "-o", pathlib.Path("..") / outputs[1].relative_to(WORK)], WORK / "elsewhere")
        one, another = tree_of(outputs[0]), tree_of(outputs[1])
        self.assertEqual(sorted(one), sorted(another))
        self.assertEqual([file for file in one if one[file] != another[file]], [])


for command in four_per_commit(COMMANDS):
    setattr(SameBytes, f"test_{command}", lambda self, name=command: self.check(name))

if __name__ == "__main__":
    unittest.main()
