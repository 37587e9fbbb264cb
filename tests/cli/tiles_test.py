#!/usr/bin/env python3
"""Transfers onto an atlas of several tiles. Usage: tiles_test.py PATINATE [unittest arguments]"""
import json
import math
import subprocess
import sys
import unittest

from command_case import CommandCase, use

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


class Tiles(CommandCase):
    def command(self, resolution, *more, mesh="waves.obj"):
        return ["transfer", self.shared / "painted", self.shared / mesh, "--control", "thickness=0.7*facing + 0.3*height", "--structure", "0", "--unit", "mm", "--texel-size", SIDE / (4 * resolution),
                "--resolution", resolution, *more]

    def files(self, name):
        """All but what names the run."""
        return {p.name: p.read_bytes() for p in (self.folder / name).iterdir() if p.name not in ("run.json", "job.json")}

    def test_the_atlas_is_one_surface_whose_lines_and_turns_go_on_over_tiles(self):
        command = [word for word in self.command(64) if word not in ("--structure", "0")]
        self.succeeds(*command, "-o", "aged")
        manifest = json.loads((self.folder / "aged/transfer.json").read_text())
        self.assertEqual(len(manifest["tiles"]), 16)
        self.assertEqual(manifest["structure"]["kind"], "dark_lines")
        self.assertTrue(manifest["subpixel"])
        # Every texel that is covered has a place, and evaluation counts what the transfer counted in another way.
        self.succeeds("evaluate", "aged", "--samples", "500", "--audits", "0", "-o", "judged")
        figures = {f["name"]: f["value"] for f in json.loads((self.folder / "judged/evaluation.json").read_text())["maps"][0]["figures"]}
        self.assertAlmostEqual(figures["control_error_mean"], manifest["energy"]["control_error_mean"], 3)

    def test_threads_change_nothing_and_what_was_said_for_large_atlases_is_accepted(self):
        self.succeeds(*self.command(64), "--threads", "1", "-o", "one")
        said = self.run_patinate(*self.command(64), "--by-tile", "--threads", "3", "-o", "three")
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("--by-tile: is not needed any more", said.stderr)
        self.assertEqual(self.files("one"), self.files("three"))


if __name__ == "__main__":
    unittest.main()
