#!/usr/bin/env python3
"""Transfers by tile: the bytes of the transfer in one piece, whoever does which item. Usage: tiles_test.py PATINATE [unittest arguments]"""
import json
import math
import subprocess
import sys
import unittest

from command_case import INPUT, USAGE, CommandCase, use

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
SIDE = 100.0  # mm


def waves(tiles, charts):
    """A waved square of charts that are turned or mirrored, `charts` x `charts` in each of `tiles` x `tiles` UDIM tiles; an edge of a chart leads to another turned one."""
    n = tiles * charts * 4  # Cells along a side, four along a chart.
    lines = [f"v {SIDE * x / n:.9g} {SIDE * y / n:.9g} {4 * math.sin(9 * x / n) + 3 * math.cos(13 * y / n):.9g}" for y in range(n + 1) for x in range(n + 1)]
    uvs, faces = [], []
    for j in range(n):
        for i in range(n):
            a, b = i // 4, j // 4
            corners = []
            for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                u, v = 0.04 + 0.92 * (x / 4 - a), 0.04 + 0.92 * (y / 4 - b)
                for _ in range((a + 2 * b) % 4):
                    u, v = 1 - v, u
                if (a * b) % 3 == 1:
                    u = 1 - u
                uvs.append(f"vt {(a + u) / charts:.9g} {(b + v) / charts:.9g}")
                corners.append(f"{y * (n + 1) + x + 1}/{len(uvs)}")
            faces.append("f " + " ".join(corners))
    return "\n".join(lines + uvs + faces) + "\n"


def setUpModule():
    use(PROGRAM)
    shared = CommandCase.shared
    for arguments in (["synth", "crackle", "--width", "128", "--height", "96", "--num-frames", "3", "-o", "paint"], ["ingest", "paint", "-o", "painted"]):
        subprocess.run([CommandCase.patinate, *arguments], cwd=shared, check=True, capture_output=True)
    (shared / "waves.obj").write_text(waves(4, 2))
    (shared / "square.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")


class Tiles(CommandCase):
    def command(self, resolution, *more, mesh="waves.obj"):
        return ["transfer", self.shared / "painted", self.shared / mesh, "--control", "thickness=0.7*facing + 0.3*height", "--structure", "0", "--unit", "mm", "--texel-size", SIDE / (4 * resolution),
                "--resolution", resolution, *more]

    def files(self, name):
        """All but what names the plan or the run."""
        made = {p.name: p.read_bytes() for p in (self.folder / name).iterdir() if p.name not in ("run.json", "job.json", "transfer.json")}
        manifest = json.loads((self.folder / name / "transfer.json").read_text())
        del manifest["key"]
        return made, manifest

    def assert_equal(self, a, b):
        (made, manifest), (other, other_manifest) = self.files(a), self.files(b)
        self.assertEqual(manifest, other_manifest)
        self.assertEqual(sorted(made), sorted(other))
        self.assertEqual([name for name in made if made[name] != other[name]], [])

    def test_4_x_4_tiles_of_256_are_the_transfer_in_one_piece(self):
        self.succeeds(*self.command(256), "--coarse-passes", "2", "-o", "whole")
        self.succeeds(*self.command(256), "--coarse-passes", "2", "--by-tile", "--threads", "1", "-o", "tiled")
        self.assert_equal("whole", "tiled")

    def test_two_tiles_whose_levels_are_all_coarse_are_the_transfer_in_one_piece(self):
        square = "v {x} 0 0\nv {z} 0 4\nv {z} 9 5\nv {x} 9 0\n"
        uvs = "vt {u}.05 0.05\nvt {u}.95 0.05\nvt {u}.95 0.95\nvt {u}.05 0.95\n"
        (self.folder / "two.obj").write_text("".join(square.format(x=9 * k, z=9 * k + 9) for k in (0, 1)) + "".join(uvs.format(u=k) for k in (0, 1)) + "f 1/1 2/2 3/3 4/4\nf 5/5 6/6 7/7 8/8\n")
        command = self.command(64, mesh=self.folder / "two.obj")
        self.succeeds(*command, "-o", "whole")
        self.succeeds(*command, "--by-tile", "-o", "tiled")
        self.assert_equal("whole", "tiled")

    def test_borders_are_refined_along_lines_by_tile_too(self):
        command = [word for word in self.command(64, "--coarse-passes", "2") if word not in ("--structure", "0")]
        self.succeeds(*command, "-o", "whole")
        self.succeeds(*command, "--by-tile", "--threads", "1", "-o", "tiled")
        self.assert_equal("whole", "tiled")
        self.assertEqual(self.files("tiled")[1]["structure"]["kind"], "dark_lines")
        items = json.loads(self.succeeds("cluster", "plan", *command, "--by-tile", "-o", "spread", "--json"))["items"]
        self.assertEqual(sum("level0-refine" in item["name"] for item in items), 10 * 16)

    def test_items_in_processes_of_their_own_give_the_same(self):
        command = [*self.command(64), "--by-tile", "--coarse-passes", "2", "-o", "tiled"]
        self.succeeds(*self.command(64), "--coarse-passes", "2", "-o", "whole")
        plan = json.loads(self.succeeds("cluster", "plan", *command, "--json"))
        (self.folder / "plan.json").write_text(json.dumps(plan))
        stages = {}
        for item in plan["items"]:
            stages.setdefault(item["waits_for"], []).append(item["number"])
        for numbers in stages.values():  # The last tiles first, by one process; then the others by another.
            for portion in (numbers[len(numbers) // 2:], numbers[:len(numbers) // 2]):
                if portion:
                    self.succeeds("cluster", "run", "plan.json", "--items", ",".join(map(str, portion)))
        self.succeeds("cluster", "join", "plan.json")
        self.assert_equal("whole", "tiled")
        self.assertIn("up to date", self.run_patinate(*command).stderr)

    def test_it_is_evaluated_by_tile_with_items_in_processes_of_their_own(self):
        self.succeeds(*self.command(64), "--coarse-passes", "2", "-o", "aged")
        command = ["evaluate", "aged", "--samples", "500", "--audits", "100"]
        self.succeeds(*command, "-o", "here")
        plan = json.loads(self.succeeds("cluster", "plan", *command, "-o", "spread", "--json"))
        self.assertEqual(len(plan["items"]), 2 * 16 + 1)
        (self.folder / "plan.json").write_text(json.dumps(plan))
        for items in ("0-6", "7-15", "20-31", "16-19", "32"):
            self.succeeds("cluster", "run", "plan.json", "--items", items)
        self.succeeds("cluster", "join", "plan.json")
        for name in ("evaluation.html", "evaluation.json"):
            self.assertEqual((self.folder / "spread" / name).read_bytes(), (self.folder / "here" / name).read_bytes())
        # The transfer counted the same in another way.
        figures = {f["name"]: f["value"] for f in json.loads((self.folder / "here/evaluation.json").read_text())["maps"][0]["figures"]}
        energy = json.loads((self.folder / "aged/transfer.json").read_text())["energy"]
        self.assertAlmostEqual(figures["coherent_share"], energy["coherent_share"], 9)
        self.assertAlmostEqual(figures["control_error_mean"], energy["control_error_mean"], 3)

    def test_what_cannot_be_done_by_tile_is_said_in_a_line(self):
        painted, waves_obj = self.shared / "painted", self.shared / "waves.obj"
        known = ["--unit", "mm", "--texel-size", "0.1", "--resolution", "64", "--structure", "0", "--by-tile", "-o", "out"]
        self.fails(USAGE, "sizes have to be given: --unit, --resolution", "transfer", painted, waves_obj, "--control", "facing", "--by-tile", "-o", "out")
        self.fails(USAGE, "`accessibility` looks at the whole atlas", "transfer", painted, waves_obj, "--control", "thickness=accessibility", *known)
        self.fails(INPUT, "UVs of several tiles", "transfer", painted, self.shared / "square.obj", "--control", "thickness=facing", *known)
        self.fails(INPUT, "--method reference cannot be done by tile", "transfer", painted, waves_obj, "--control", "thickness=facing", "--method", "reference", *known)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    unittest.main()
