#!/usr/bin/env python3
"""Meshes as laboratories have them, through the commands. Usage: mesh_test.py PATINATE"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_mesh_"))


def setUpModule():
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "capture"],
                      ["ingest", "capture", "-o", "history"]):
        subprocess.run([PATINATE, *arguments], cwd=SHARED, check=True, capture_output=True)


def tearDownModule():
    shutil.rmtree(SHARED)


def strip(tiles, material=None, offset=1.0, cells=4):
    """A strip of squares along x, each cut into cells; square i has its UVs moved by i * offset, and a material of its own if asked."""
    points, uvs, faces = [], [], []
    n = cells * tiles
    for j in range(cells + 1):
        points += [f"v {i / cells} {j / cells} {0.2 * (i / cells) ** 2}" for i in range(n + 1)]
    for tile in range(tiles):
        if material:
            faces.append(f"usemtl {material}{tile}")
        for j in range(cells):
            for i in range(cells):
                corner = []
                for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    uvs.append(f"vt {(i + di) / cells + tile * offset} {(j + dj) / cells}")
                    corner.append(f"{(j + dj) * (n + 1) + tile * cells + i + di + 1}/{len(uvs)}")
                faces.append("f " + " ".join(corner))
    return "\n".join(points + uvs + faces) + "\n"


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_mesh_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_patinate(self, *arguments):
        return subprocess.run([PATINATE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120)

    def succeeds(self, *arguments):
        result = self.run_patinate(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def transfer(self, text, *more):
        (self.folder / "mesh.obj").write_text(text)
        return self.succeeds("transfer", SHARED / "history", "mesh.obj", "--control", "facing", "--resolution", "32", *more, "-o", "aged").stderr

    def files(self, pattern):
        return sorted(p.name for p in self.folder.glob(pattern))


class Tiles(Case):
    def test_udim_goes_through_every_command(self):
        notes = self.transfer(strip(3))
        self.assertIn("3 UDIM tiles (1001, 1002, 1003)", notes)
        self.assertEqual(self.files("aged/coordinates*"), [f"coordinates.{t}.exr" for t in (1001, 1002, 1003)])
        self.succeeds("texture", "aged", "--time", "5", "-o", "tex.png")
        self.succeeds("texture", "aged", "--time", "5", "-o", "<UDIM>_t.png")
        self.assertEqual(self.files("*.png"), ["1001_t.png", "1002_t.png", "1003_t.png", "tex.1001.png", "tex.1002.png", "tex.1003.png"])
        self.succeeds("control", "mesh.obj", "--kind", "facing", "--resolution", "32", "-o", "map.exr")
        self.assertEqual(self.files("map*"), ["map.1001.exr", "map.1002.exr", "map.1003.exr"])
        self.succeeds("control", "mesh.obj", "--kind", "!map.exr", "--resolution", "32", "-o", "inverse.exr")
        self.succeeds("export", "aged", "--num-times", "2", "-o", "aged.glb")
        self.succeeds("export", "aged", "--num-times", "2", "-o", "images")
        self.assertEqual(len(self.files("images/*.png")), 6)
        self.succeeds("render", "aged", "--num-times", "1", "--width", "64", "--height", "64", "--samples", "1", "-o", "strip.jpg")
        self.succeeds("render", "mesh.obj", "--texture", "tex.<UDIM>.png", "--width", "64", "--height", "64", "--samples", "1", "-o", "one.jpg")
        self.succeeds("validate", "aged")
        info = json.loads(self.succeeds("info", "aged", "--json").stdout)
        self.assertEqual(info["tiles"], ["1001", "1002", "1003"])

    def test_an_output_of_one_tile_in_the_way_stops_all(self):
        self.transfer(strip(2))
        (self.folder / "tex.1002.png").write_text("mine")
        self.assertEqual(self.run_patinate("texture", "aged", "--time", "5", "-o", "tex.png").returncode, 1)
        self.assertFalse((self.folder / "tex.1001.png").exists())
        self.succeeds("texture", "aged", "--time", "5", "-o", "tex.png", "--force")
        self.assertIn("up to date", self.succeeds("texture", "aged", "--time", "5", "-o", "tex.png").stderr)

    def test_materials_that_share_the_square_get_a_tile_each(self):
        notes = self.transfer(strip(2, material="paint ", offset=0.0))
        self.assertIn("2 materials (paint_0, paint_1)", notes)
        self.succeeds("texture", "aged", "--time", "5", "-o", "tex.png")
        self.assertEqual(self.files("*.png"), ["tex.paint_0.png", "tex.paint_1.png"])

    def test_one_material_can_be_chosen(self):
        self.transfer(strip(2, material="paint", offset=0.0), "--material", "paint1")
        self.assertEqual(self.files("aged/coordinates*"), ["coordinates.exr"])


class Unwrapped(Case):
    BENT = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\n"

    def test_a_mesh_without_uvs_gets_them_and_the_map_a_mesh_beside_it(self):
        notes = self.transfer(self.BENT + "f 1 2 3 4\nf 2 5 6 3\n")
        self.assertIn("unwrapped, as it has no UVs", notes)
        command = ("control", "mesh.obj", "--kind", "facing", "--resolution", "32", "-o", "map.exr")
        self.succeeds(*command)
        self.assertIn("vt ", (self.folder / "map.obj").read_text())
        self.assertIn("up to date", self.succeeds(*command).stderr)
        (self.folder / "map.obj").write_text("mine")
        self.assertEqual(self.run_patinate(*command).returncode, 1)

    def test_repeated_uvs_are_unwrapped_or_refused_by_choice(self):
        text = self.BENT + "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf 1/1 2/2 3/3 4/4\n"
        self.assertIn("unwrapped, as its UVs leave [0, 1]", self.transfer(text))
        result = self.run_patinate("transfer", SHARED / "history", "mesh.obj", "--control", "facing", "--atlas", "uv", "-o", "other")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1)

    def test_half_missing_uvs_are_counted(self):
        notes = self.transfer(self.BENT + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\nf 2 5 6 3\n")
        self.assertIn("2 of its 4 triangles have corners without UVs", notes)


class BadTriangles(Case):
    def test_are_counted_and_nothing_is_nan(self):
        text = Unwrapped.BENT + "v 0.5 0 0\nf 1 2 3 4\nf 2 3 6 5\nf 1 2 3\nf 1 7 2\nf 2 3 4\n"
        notes = self.transfer(text)
        self.assertIn("without area excluded", notes)
        self.assertIn("turned", notes)
        for file in (self.folder / "aged").glob("*.exr"):
            self.assertIn("OK", self.succeeds("validate", file).stdout)

    def test_huge_and_far_coordinates_work(self):
        for scale, offset in ((1e12, 0.0), (1.0, 1e7), (1e-9, 0.0)):
            points = [[float(x) * scale + offset for x in line.split()[1:]] for line in Unwrapped.BENT.splitlines()]
            self.transfer("".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points) + "f 1 2 3 4\nf 2 5 6 3\n", "--force")

    def test_without_any_area_is_refused(self):
        (self.folder / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
        result = self.run_patinate("control", "flat.obj", "--kind", "facing", "-o", "x.exr")
        self.assertEqual(result.returncode, 3)
        self.assertIn("no triangle has an area", result.stderr)


if __name__ == "__main__":
    unittest.main()
