#!/usr/bin/env python3
"""Cracks on curved shapes, judged on the surface across seams: a smooth closed shape, one with sharp edges, one with thin parts.
Usage: cracks_test.py PATINATE [unittest arguments]"""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = str(pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate").resolve())
WORK = pathlib.Path(tempfile.mkdtemp(prefix="patinate_cracks_"))


def patinate(*arguments):
    result = subprocess.run([PATINATE, *map(str, arguments)], cwd=WORK, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout


def write_grid(name, columns, rows, point, is_closed):
    """An OBJ of a grid whose columns, and rows where `is_closed`, meet again. point(u, v) -> (x, y, z), u and v in [0, 1)."""
    num_rows = rows if is_closed else rows + 1
    lines = ["v %.9g %.9g %.9g" % point(i / columns, j / rows) for j in range(num_rows) for i in range(columns)]
    for j in range(rows):
        for i in range(columns):
            a, b = j * columns + i + 1, j * columns + (i + 1) % columns + 1
            below = (j + 1) % num_rows - j
            lines.append("f %d %d %d %d" % (a, b, b + below * columns, a + below * columns))
    (WORK / name).write_text("\n".join(lines) + "\n")


def pebble(u, v):
    """An uneven egg: smooth and closed, curved differently everywhere. Its poles are small holes."""
    angle, height = 2 * math.pi * u, math.pi * (0.02 + 0.96 * v)
    radius = math.sin(height) * (1 + 0.15 * math.cos(3 * angle) * math.sin(height))
    return radius * math.cos(angle), 1.3 * math.cos(height), 0.8 * radius * math.sin(angle)


def ring(u, v):
    """A thin tube bent to a ring."""
    angle, around = 2 * math.pi * u, 2 * math.pi * v
    radius = 1 + 0.18 * math.cos(around)
    return radius * math.cos(angle), radius * math.sin(angle), 0.18 * math.sin(around)


def write_box(name):
    """Six planes of different sizes that meet at right angles."""
    corners = [(x, y, z) for x in (0, 1.4) for y in (0, 1) for z in (0, 0.6)]
    faces = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    (WORK / name).write_text("".join("v %g %g %g\n" % c for c in corners) + "".join("f %d %d %d %d\n" % f for f in faces))


def setUpModule():
    write_grid("pebble.obj", 96, 64, pebble, False)
    write_grid("ring.obj", 128, 32, ring, True)
    write_box("box.obj")
    patinate("synth", "crackle", "--seed", 4, "--width", 768, "--height", 768, "--num-frames", 4, "-o", "photos")
    patinate("ingest", "photos", "-o", "cracks")


def tearDownModule():
    shutil.rmtree(WORK)


def lines_on(mesh, *options):
    """{figure: it over the source's} of a transfer, in windows across seams."""
    name = "-".join((mesh, *options)).replace(".obj", "")
    patinate("transfer", "cracks", mesh, "--control", "thickness=height", "--resolution", 512, "--atlas", "unwrap", *options, "-o", name)
    patinate("evaluate", name, "-o", name + "_report", "--audits", 0)
    figures = json.loads((WORK / (name + "_report") / "evaluation.json").read_text())["maps"][0]["figures"]
    return {f["name"]: f["value"] / f["split"] for f in figures if f["name"].endswith("_surface") and f.get("split")}


class CracksOnShapes(unittest.TestCase):
    """Pieces with fractions and a turn of their own against pieces that follow the direction field."""

    def check(self, mesh):
        turning, following = lines_on(mesh), lines_on(mesh, "--turning", "never")
        print(mesh, {n: (round(turning[n], 2), round(following[n], 2)) for n in turning})
        # As many cracks as the source has where its layer is as thick: within a tenth, to which the paper's own search is held as well.
        self.assertAlmostEqual(turning["line_share_surface"], 1, delta=0.1)
        # Whole pixels had 3.5 times the source's dead ends: half of what they lose is back at least.
        self.assertLessEqual(turning["dead_ends_surface"], (1 + 3.5) / 2)
        # A turn can only be taken where it costs less.
        self.assertLess(turning["dead_ends_surface"], following["dead_ends_surface"])
        self.assertGreater(turning["closed_share_surface"], following["closed_share_surface"])

    def test_a_smooth_closed_shape(self):
        self.check("pebble.obj")

    def test_sharp_edges(self):
        self.check("box.obj")

    def test_thin_parts(self):
        self.check("ring.obj")


if __name__ == "__main__":
    unittest.main()
