#!/usr/bin/env python3
"""`patinate transfer`: what lies how on a surface, and input that cannot be used. Usage: transfer_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"
PATINATE = str(pathlib.Path(PATINATE).resolve())
SHARED = pathlib.Path(tempfile.mkdtemp(prefix="patinate_transfer_"))
USAGE, INPUT = 2, 3


def run(*arguments, cwd=SHARED):
    return subprocess.run([PATINATE, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120)


def setUpModule():
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "3", "-o", "capture"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["ingest", "capture", "-o", "history"]):
        result = run(*arguments)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")


def tearDownModule():
    shutil.rmtree(SHARED)


class Transfer(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_transfer_", dir=SHARED))

    def transfer(self, *more, history="../history", mesh="../urn/mesh.obj"):
        return run("transfer", history, mesh, "--resolution", "64", *more, "-o", "aged", cwd=self.folder)

    def refused(self, code, about, *more, **places):
        result = self.transfer(*more, **places)
        lines = [line for line in result.stderr.splitlines() if line.startswith("patinate: error: ")]  # Notes may stand before.
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertIn(about, lines[0])
        self.assertFalse((self.folder / "aged").exists())

    def test_a_control_that_the_history_lacks_is_said_before_the_mesh_is_read(self):
        (self.folder / "mesh.obj").write_text("v 0 0 0\n")
        self.refused(INPUT, "has no control `thicknes`", "--control", "thicknes=facing", mesh="mesh.obj")

    def test_a_history_that_is_gone_is_named_with_what_to_do(self):
        shutil.copytree(SHARED / "history", self.folder / "history")
        made = self.transfer("--control", "facing", history="history")
        self.assertEqual(made.returncode, 0, made.stderr)
        (self.folder / "history").rename(self.folder / "elsewhere")
        gone = run("texture", "aged", "--time", "1", "-o", "x.png", cwd=self.folder)
        self.assertEqual(gone.returncode, INPUT)
        self.assertIn("its history `crackle` is not at history", gone.stderr)
        self.assertIn("`path` of `history` in aged/transfer.json", gone.stderr)

    def narrow_history(self, columns):
        """The history's first columns, by its project."""
        capture = self.folder / "capture"
        shutil.copytree(SHARED / "capture", capture)
        project = json.loads((capture / "capture.json").read_text())
        project["roi"] = [0, 0, columns, 40]
        (capture / "capture.json").write_text(json.dumps(project))
        result = run("ingest", "capture", "-o", "small", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return "small"

    def test_every_flow_is_recorded_and_gives_other_coordinates(self):
        (self.folder / "curve.csv").write_text("x,y,z\n0,0,50\n0,60,50\n")
        seen = set()
        for flow in ("gravity", "curvature", "uv", "curve.csv"):
            result = self.transfer("--control", "facing", "--flow", flow, "--force")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads((self.folder / "aged/transfer.json").read_text())["flow"], flow)
            seen.add((self.folder / "aged/coordinates.exr").read_bytes())
        self.assertEqual(len(seen), 4)

    def test_texels_that_skip_pixels_are_said(self):
        """Three quarters of a plate take a quarter of the texels: 64 of them along 100 mm are 1.386 mm large there, and 0.462 beside it."""
        (self.folder / "uneven.obj").write_text(
            "v 0 0 0\nv 75 0 0\nv 100 0 0\nv 0 100 0\nv 75 100 0\nv 100 100 0\nvt 0 0\nvt 0.25 0\nvt 1 0\nvt 0 1\nvt 0.25 1\nvt 1 1\n"
            "f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n")
        uneven = ["--unit", "mm", "--control", "height", "--resolution", "125"]
        for texel_size, expected in ((1, True), (1.2, False)):
            result = run("transfer", SHARED / "history", "uneven.obj", *uneven, "--texel-size", str(texel_size), "-o", f"aged{texel_size}", cwd=self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual("75 % of the surface has texels more than 1.3 pixels of the history large" in result.stderr, expected, result.stderr)

    def test_pieces_that_cannot_turn_are_said_to_follow(self):
        result = self.transfer("--control", "facing", "--flow", "uv", "--turning", "free")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("--turning free: copied pieces follow --flow", result.stderr)
        self.assertEqual(json.loads((self.folder / "aged/transfer.json").read_text())["options"]["turning"], "never")

    def test_a_history_of_one_photograph_is_exported(self):
        capture = self.folder / "capture"
        shutil.copytree(SHARED / "capture", capture)
        for frame in sorted((capture / "frames").glob("*.png"))[:-1]:
            frame.unlink()
        result = run("ingest", "capture", "-o", "one", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.transfer("--control", "facing", history="one").returncode, 0)
        for output in ("aged.glb", "aged.png"):  # By default models and pictures show several times.
            result = run("render" if output == "aged.png" else "export", "aged", "-o", output, cwd=self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)

    def test_a_changed_curve_is_another_transfer(self):
        curve = self.folder / "curve.csv"
        curve.write_text("0,0,50\n0,60,50\n")
        self.assertEqual(self.transfer("--control", "facing", "--flow", "curve.csv").returncode, 0)
        self.assertIn("up to date", self.transfer("--control", "facing", "--flow", "curve.csv").stderr)
        curve.write_text("0,60,50\n0,0,50\n")
        self.assertNotIn("up to date", self.transfer("--control", "facing", "--flow", "curve.csv", "--force").stderr)

    def test_a_flow_that_is_none(self):
        self.refused(USAGE, "did you mean `gravity`?", "--control", "facing", "--flow", "gravty")
        (self.folder / "point.csv").write_text("1,2,3\n")
        self.refused(INPUT, "point.csv: no curve has two different points", "--control", "facing", "--flow", "point.csv")

    def test_a_control_that_says_nothing_is_noted(self):
        result = self.transfer("--control", "0.5")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("has the same value everywhere on the mesh, so this control has no effect", result.stderr)

    def test_a_source_smaller_than_the_neighborhood(self):
        self.refused(INPUT, "240 of 240 pixels are inside the mask, 0 of them with their whole neighborhood of 7 x 7, and at least 49 are needed", "--control", "facing", history=self.narrow_history(6))

    def test_few_pixels_are_counted(self):
        # 20 columns of 40: 14 x 34 have 7 x 7 pixels about them, fewer than 40 windows side by side.
        result = self.transfer("--control", "facing", history=self.narrow_history(20))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("only 800 pixels of the history can be copied, 476 of them with their whole neighborhood of 7 x 7", result.stderr)

    def test_a_mask_of_three_pixels(self):
        history = self.folder / "three"
        shutil.copytree(SHARED / "history", history)
        rows = b"".join(b"\0" + bytes(255 if y == 20 and x in (20, 21, 22) else 0 for x in range(48)) for y in range(40))
        chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        (history / "mask.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 48, 40, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
        manifest = json.loads((history / "history.json").read_text())
        manifest["mask"] = "mask.png"
        (history / "history.json").write_text(json.dumps(manifest))
        self.refused(INPUT, "3 of 1920 pixels are inside the mask, 0 of them", "--control", "facing", history="three")

    def test_an_automatic_resolution_is_announced_and_recorded(self):
        help_text = " ".join(run("transfer", "--help-all").stdout.split())
        self.assertIn("[16, 16384]; default as many as show every pixel of the history, 256 to 4096", help_text)
        self.assertIn("[16, 16384]; default 1024", " ".join(run("control", "--help-all").stdout.split()))  # There it is a number.
        known = ["--unit", "mm", "--control", "facing"]
        planned = run("transfer", "../history", "../urn/mesh.obj", *known, "--texel-size", "0.5", "--dry-run", "-o", "aged", cwd=self.folder)
        self.assertEqual(planned.returncode, 0, planned.stderr)
        self.assertRegex(planned.stderr, r"chose a resolution of (\d+) x \1 texels to show")
        result = run("transfer", "../history", "../urn/mesh.obj", *known, "--texel-size", "20", "-o", "aged", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("chose a resolution of 256 x 256 texels", result.stderr)
        self.assertEqual(json.loads((self.folder / "aged/run.json").read_text())["options"]["resolution"], {"value": 256, "from": "chosen"})
        given = self.transfer("--control", "facing", "--unit", "mm", "--force")
        self.assertNotIn("automatic", given.stderr)
        self.assertEqual(json.loads((self.folder / "aged/run.json").read_text())["options"]["resolution"], {"value": 64, "from": "command line"})

    def test_a_map_with_nan(self):
        # PFM, "Pf" gray: rows from below, little-endian by the sign.
        (self.folder / "wet.pfm").write_bytes(b"Pf\n64 64\n-1.0\n" + struct.pack("<4096f", *(float("nan") if i == 100 else i / 4096 for i in range(4096))))
        self.refused(INPUT, "holds NaN or infinite values", "--control", "wet.pfm")

    def test_a_mesh_whose_uvs_cover_nothing(self):
        (self.folder / "dot.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nvt 0 0\nvt 0.001 0\nvt 0 0.001\nf 1/1 2/2 3/3\n")
        self.refused(INPUT, "cover no texel", "--control", "facing", mesh="dot.obj")


if __name__ == "__main__":
    unittest.main()
