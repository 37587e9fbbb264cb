#!/usr/bin/env python3
"""USD that export writes, against the rules of the specifications. Usage: usd_test.py PATINATE [unittest arguments]"""
import json
import pathlib
import re
import struct
import sys
import unittest
import zipfile
import zlib

from command_case import INPUT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PATINATE)


def prims(text):
    """Path -> (type, lines of its own) of every prim: what "#usda 1.0" [USDA crate-less text] nests in braces."""
    found, path, metadata = {}, [], 0
    for line in text.splitlines()[1:]:
        stripped = line.strip()
        opened = re.match(r'def (\w+) "([A-Za-z_]\w*)"', stripped)
        if opened:
            path.append(opened[2])
            key = "/" + "/".join(path)
            assert key not in found, f"{key} is there twice"
            found[key] = (opened[1], [])
        elif stripped == "}" and path and not stripped.startswith("asset"):
            if found["/" + "/".join(path)][1][-1:] and found["/" + "/".join(path)][1][-1].endswith("<open>"):
                found["/" + "/".join(path)][1][-1] = found["/" + "/".join(path)][1][-1][:-6]
            else:
                path.pop()
        elif path and stripped not in ("{", "(", ")", ""):
            lines = found["/" + "/".join(path)][1]
            if lines and lines[-1].endswith("<open>"):
                lines[-1] = lines[-1][:-6] + " " + stripped + "<open>"
            else:
                lines.append(stripped + ("<open>" if stripped.endswith("= {") else ""))
    assert not path, "a prim is not closed"
    return found


def value(lines, name):
    for line in lines:
        if re.match(rf"(uniform )?[\w\[\]]+ {re.escape(name)} = ", line):
            return line.split(" = ", 1)[1]
    raise KeyError(name)


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", text)]


def png_size(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", data[16:24])


class Usd(CommandCase):
    def check_stage(self, text, read):
        """What readers rely on. @param read  Bytes of an asset."""
        self.assertTrue(text.startswith("#usda 1.0\n"))
        found = prims(text)
        root = re.search(r'defaultPrim = "(\w+)"', text)[1]
        self.assertEqual(found[f"/{root}"][0], "Xform")
        self.assertIn('upAxis = "Y"', text)
        # Whatever is named is there: prims, and their outputs.
        for target in re.findall(r"<(/[^>]+)>", text):
            prim, _, output = target.partition(".")
            self.assertIn(prim, found)
            if output:
                self.assertTrue(any(re.search(rf"\b{re.escape(output)}\b", line) for line in found[prim][1]), target)
        assets = re.findall(r"@([^@]+)@", text)
        self.assertTrue(assets)
        for asset in assets:
            self.assertEqual(len(set(png_size(read(asset)))), 1)
        num_faces = 0
        for path, (kind, lines) in found.items():
            if kind != "Mesh":
                continue
            counts, corners = numbers(value(lines, "faceVertexCounts")), numbers(value(lines, "faceVertexIndices"))
            points = numbers(value(lines, "points"))
            uvs, uv_corners = numbers(value(lines, "primvars:st")), numbers(value(lines, "primvars:st:indices"))
            self.assertEqual(sum(counts), len(corners))
            self.assertEqual(sorted(set(corners)), list(range(len(points) // 3)))  # In range, and none unused.
            self.assertEqual(len(uv_corners), len(corners))
            self.assertLess(max(uv_corners), len(uvs) // 2)
            self.assertTrue(all(-1e-6 <= u <= 1 + 1e-6 for u in uvs))
            extent = numbers(value(lines, "extent"))
            for axis in range(3):
                self.assertEqual((extent[axis], extent[3 + axis]), (min(points[axis::3]), max(points[axis::3])))
            num_faces += len(counts)
        return found, num_faces

    def test_a_stage_holds_the_mesh_and_a_texture_at_each_real_time(self):
        self.succeeds("export", self.shared / "aged", "--times", "0,7.5,15", "-o", "urn.usda")
        text = (self.folder / "urn.usda").read_text()
        found, num_faces = self.check_stage(text, lambda asset: (self.folder / asset).read_bytes())
        mesh = (self.shared / "aged/mesh.obj").read_text()
        self.assertEqual(num_faces, sum(line.startswith("f ") for line in mesh.splitlines()))
        samples = value(found["/urn/Materials/material/color"][1], "inputs:file.timeSamples")
        self.assertEqual([float(t) for t in re.findall(r"([\d.]+): @", samples)], [0, 7.5, 15])
        self.assertIn("startTimeCode = 0\n", text)
        self.assertIn("endTimeCode = 15\n", text)
        # The texture at a time is what lookup writes.
        self.succeeds("texture", self.shared / "aged", "--time", "7.5", "-o", "then.png")
        pixels = [self.pixels(self.folder / name) for name in ("then.png", re.findall(r"7\.5: @([^@]+)@", samples)[0])]
        self.assertEqual(*pixels)

    def pixels(self, path):
        """Filtered rows of a PNG whose writer filters equal rows equally."""
        data, at, packed = path.read_bytes(), 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
            at += 12 + size
        return zlib.decompress(packed)

    def test_a_package_is_one_file_whose_parts_lie_at_multiples_of_64(self):
        self.succeeds("export", self.shared / "aged", "--num-times", "2", "-o", "urn.usdz")
        with zipfile.ZipFile(self.folder / "urn.usdz") as package:
            self.assertIsNone(package.testzip())
            data = (self.folder / "urn.usdz").read_bytes()
            names = package.namelist()
            self.assertEqual(names[0], "urn.usda")
            for entry in package.infolist():
                self.assertEqual(entry.compress_type, zipfile.ZIP_STORED)
                name_size, extra_size = struct.unpack("<HH", data[entry.header_offset + 26:entry.header_offset + 30])
                self.assertEqual((entry.header_offset + 30 + name_size + extra_size) % 64, 0, entry.filename)
            self.check_stage(package.read("urn.usda").decode(), package.read)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["urn.usdz"])

    def test_equal_input_gives_equal_bytes_and_nothing_is_done_twice(self):
        for name in ("a.usdz", "again/a.usdz"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            self.succeeds("export", self.shared / "aged", "--num-times", "2", "-o", name)
        self.assertEqual((self.folder / "a.usdz").read_bytes(), (self.folder / "again/a.usdz").read_bytes())
        self.assertEqual(json.loads(self.succeeds("export", self.shared / "aged", "--num-times", "2", "-o", "a.usdz", "--json"))["status"], "up to date")
        self.fails(1, "a.usdz", "export", self.shared / "aged", "--num-times", "3", "-o", "a.usdz")

    def test_other_suffixes_are_refused_with_what_there_is(self):
        self.assertIn(".usdz", self.fails(USAGE, "x.usdc", "export", self.shared / "aged", "-o", "x.usdc"))
        self.fails(USAGE, "has no mesh", "export", self.shared / "history", "-o", "x.usda")
        self.fails(INPUT, "nowhere", "export", "nowhere", "-o", "x.usda")


if __name__ == "__main__":
    unittest.main()
