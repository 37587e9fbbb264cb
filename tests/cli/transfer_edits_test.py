#!/usr/bin/env python3
"""`patinate transfer --edits`: a list of edits is applied to a finished transfer, and repeats to the byte. Usage: transfer_edits_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import sys
import unittest

import command_case
from command_case import INPUT, USAGE, CommandCase

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
TRANSFER = ("transfer", "history", "urn/mesh.obj", "--unit", "mm", "--resolution", "64", "--control", "thickness=facing")


def setUpModule():
    command_case.use(PATINATE)


class Edits(CommandCase):
    def setUp(self):
        super().setUp()
        for name in ("history", "urn"):
            self.take(name)

    def corner(self, axis):
        """The vertex of the mesh that lies farthest along an axis, in mm."""
        vertices = [[float(v) for v in line.split()[1:4]] for line in (self.folder / "urn/mesh.obj").read_text().splitlines() if line.startswith("v ")]
        return max(vertices, key=lambda v: v[axis])

    def stroke(self, axis, **changes):
        point = self.corner(axis)
        size = max(abs(c) for c in point)
        return {"kind": "stroke", "control": "thickness", "value": 1, "flow": 0.9, "radius_mm": 0.3 * size, "points_mm": [point], **changes}

    def write(self, *edits, name="edits.json", **more):
        (self.folder / name).write_text(json.dumps({"format": "patinate.edits", "version": 1, "edits": list(edits), **more}))
        return name

    def refused(self, code, about, *arguments):
        """One error, and nothing made. Notes on the small history may stand before it."""
        result = self.run_patinate(*arguments, "-o", "out")
        lines = [line for line in result.stderr.splitlines() if line.startswith("patinate: error: ")]
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertIn(about, lines[0])
        self.assertEqual([p.name for p in self.folder.glob("out*")], [])

    def test_edits_change_what_they_reach_and_repeat_to_the_byte(self):
        self.succeeds(*TRANSFER, "-o", "plain")
        edits = self.write(self.stroke(0), {"kind": "refine"}, self.stroke(1, value=0.2))
        for threads in ("1", "2", "5"):
            self.succeeds(*TRANSFER, "--edits", edits, "--threads", threads, "-o", "edited" + threads)
        trees = [command_case.tree_of(self.folder / ("edited" + threads)) for threads in ("1", "2", "5")]
        self.assertEqual(trees[0], trees[1])
        self.assertEqual(trees[0], trees[2])
        plain = command_case.tree_of(self.folder / "plain")
        self.assertNotEqual(plain["coordinates.exr"], trees[0]["coordinates.exr"])
        self.assertEqual(plain["control.exr"], trees[0]["control.exr"], "what the transfer was given")
        self.assertEqual(json.loads(trees[0]["transfer.json"])["edits"], "edits.json")
        self.assertEqual(json.loads(trees[0]["edits.json"])["edits"][0]["points_mm"], [self.corner(0)])
        # What it wrote is read by others, and can be given again.
        self.succeeds("texture", "edited1", "--time", "1", "-o", "texture.png")
        self.succeeds("evaluate", "edited1", "--audits", "0", "-o", "report")
        self.succeeds(*TRANSFER, "--edits", "edited1/edits.json", "-o", "again")
        self.assertEqual(command_case.tree_of(self.folder / "again"), trees[0])

    def test_what_is_wrong_is_said_in_one_line_before_the_search(self):
        def refused(about, *edits, code=INPUT, more=(), **members):
            self.refused(code, about, *TRANSFER, *more, "--edits", self.write(*edits, **members))
        good = self.stroke(0)
        self.refused(INPUT, "none.json", *TRANSFER, "--edits", "none.json")
        refused("/edits/0/value", {**good, "value": 2})
        refused("/edits/0/points_mm", {**good, "points_mm": []})
        refused("/edits/0/points_mm/0", {**good, "points_mm": [[1, 2]]})
        refused("/edits/0/kind", {"kind": "erase"})
        refused("colour", good, colour=1)
        refused("edit 2: control `thicknes` is none that the transfer follows; expected thickness", good, {**good, "control": "thicknes"})
        refused("edit 1: there is nothing to refine", {"kind": "refine"})
        refused("edit 2: a stroke reaches no texel", good, {**good, "points_mm": [[1e6, 0, 0]]})
        refused("--edits: needs --method fast", good, code=USAGE, more=("--method", "reference"))


if __name__ == "__main__":
    unittest.main()
