#!/usr/bin/env python3
"""tools/front as a researcher runs it who has maps of other tools. Usage: front_test.py PATINATE [unittest arguments]"""
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
FRONT = pathlib.Path(__file__).resolve().parents[2] / "tools/front"
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_front_"))
SIDE = 64


def front(*arguments):
    return subprocess.run([sys.executable, str(FRONT), "--patinate", PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True)


def write_map(name, source):
    (WORK / name).write_bytes(b"".join(struct.pack("<ii", *source(x, y)) for y in range(SIDE) for x in range(SIDE)))


def setUpModule():
    for arguments in (["synth", "crackle", "--width", SIDE, "--height", SIDE, "--num-frames", 2, "-o", "photos"], ["ingest", "photos", "-o", "crackle"]):
        subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, check=True, capture_output=True)
    # The guide is the history's own control: a tool that copies every pixel to its place loses nothing.
    write_map("same_1.nnf", lambda x, y: (x, y))
    write_map("same_2.nnf", lambda x, y: (x, y))
    write_map("tiles.nnf", lambda x, y: (x % 16, y % 16))


def tearDownModule():
    shutil.rmtree(WORK)


class Front(unittest.TestCase):
    def test_our_modes_and_other_tools_stand_in_one_table(self):
        command = ["-o", "made", "--control", "thickness", "--resolution", SIDE, "--coherence", "0.5,0.9", "--methods", "fast,reference", "--seeds", "2",
                   "--source", "crackle", "crackle/controls/thickness.exr", "same_1.nnf", "same_2.nnf", "tiles.nnf"]
        result = front(*command)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = {line.split("|")[1].strip(): [cell.strip() for cell in line.split("|")[2:-1]] for line in result.stdout.splitlines() if line.startswith("| ")}
        self.assertEqual(set(rows) - {"tool and its weight", "---"}, {"fast 0.5", "fast 0.9", "reference 0.5", "reference 0.9", "same 1", "same 2", "tiles"})
        self.assertEqual(float(rows["same 1"][0]), 0.0)
        self.assertLess(float(rows["same 1"][1]), float(rows["tiles"][1]))
        self.assertEqual(rows["same 1"][-1], "-")  # A map does not say how long it took.
        self.assertGreater(float(rows["fast 0.5"][-1]), 0.0)
        self.assertTrue((WORK / "made/crackle/evaluation/evaluation.html").is_file())
        # Again: nothing is regenerated, and the table is the same.
        again = front(*command)
        self.assertEqual(again.stdout, result.stdout)

    def test_without_a_guide_one_is_made_that_other_tools_can_follow(self):
        command = ["--resolution", SIDE, "--coherence", "0.5", "--source", "crackle"]
        result = front("-o", "alone", *command)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((WORK / "alone/crackle/guide.png").is_file())
        # Given back to it beside the map of a tool: the same maps of ours.
        beside = front("-o", "beside", *command, "alone/crackle/guide.png", "tiles.nnf")
        self.assertEqual(beside.returncode, 0, beside.stderr)

        def row(printed):
            return next(line.rsplit("|", 2)[0] for line in printed.splitlines() if line.startswith("| fast 0.5"))

        self.assertEqual(row(beside.stdout), row(result.stdout))
        # The same folder at another resolution: nothing of the first is left in it.
        half = ["--resolution", SIDE // 2, "--coherence", "0.5", "--source", "crackle"]
        self.assertEqual(row(front("-o", "alone", *half).stdout), row(front("-o", "fresh", *half).stdout))

    def test_a_ramp_has_the_values_of_the_source_from_left_to_right(self):
        result = front("-o", "ramp", "--guide", "ramp", "--resolution", SIDE, "--coherence", "0.65,0.85,default", "--source", "crackle", "crackle/controls/thickness.exr")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = {line.split("|")[1].strip(): line.split("|")[2:-2] for line in result.stdout.splitlines() if line.startswith("| fast")}  # But for the speed.
        self.assertEqual(set(rows), {"fast 0.65", "fast 0.85", "fast default"})
        self.assertIn(rows["fast default"], (rows["fast 0.65"], rows["fast 0.85"]))  # The default of a source without, and with structure.

        self.assertEqual(front("-o", "ramp", "--guide", "ramp", "--resolution", SIDE, "--coherence", "0.65", "--source", "crackle").returncode, 0)

        def values(file):
            printed = subprocess.run(["oiiotool", "--dumpdata", file], cwd=WORK, check=True, capture_output=True, text=True).stdout
            return [float(v) for v in re.findall(r"Pixel \(.*\): (\S+)", printed)]

        ramp, source = values("ramp/crackle/guide_ramp.png"), sorted(values("crackle/controls/thickness.exr"))
        self.assertEqual(ramp[:SIDE], sorted(ramp[:SIDE]))
        self.assertEqual(ramp, ramp[:SIDE] * SIDE)
        for x in range(SIDE):  # Every column stands for as much of the source. Half a code by rounding, one by oiiotool, which cuts what it reads of a PGM.
            self.assertAlmostEqual(ramp[x] / 65535, source[round(x / (SIDE - 1) * (len(source) - 1))], delta=1.5 / 65535)

    def test_what_is_wrong_is_said_in_a_line(self):
        for arguments, code, said in ((["--source", "photos"], 3, "no material history"), (["--source", "nothing", "crackle/controls/thickness.exr"], 3, "nothing"),
                                      (["--source", "crackle", "crackle/controls/thickness.exr", "--coherence", "much"], 2, "much"),
                                      (["--source", "crackle", "--resolution", 0], 2, "--resolution"), (["--source", "crackle", "--control", "height"], 3, "height")):
            result = front("-o", "bad", "--resolution", SIDE, *arguments)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertTrue(re.search(said, result.stderr), result.stderr)

    @unittest.skipUnless(os.environ.get("PATINATE_DATA"), "PATINATE_DATA is not set")
    def test_the_five_sources_of_the_benchmark_are_made(self):
        result = subprocess.run([str(FRONT.parent / "front_sources"), "sources", PATINATE], cwd=WORK, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        for name, control in (("rust", "height"), ("moss", "height"), ("copper", "progress"), ("craquelure", "density"), ("crackle", "thickness")):
            history = json.loads((WORK / "sources" / name / "history.json").read_text())
            self.assertEqual([c["name"] for c in history["controls"]], [control], name)
            self.assertEqual(len(history["frames"]), 1, name)


if __name__ == "__main__":
    unittest.main()
