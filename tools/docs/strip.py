#!/usr/bin/python3
"""strip.py OUT.jpg WIDTH IMAGE=LABEL...: pictures of one size side by side with labels, each WIDTH pixels wide, as `patinate render` lays its strips out. Needs the Python module and oiiotool."""
import pathlib
import subprocess
import sys
import tempfile

import patinate

output, width, *given = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder:
    pictures, labels = [], []
    for i, word in enumerate(given):
        image, label = word.rsplit("=", 1)
        scaled = pathlib.Path(folder, f"{i}.png")
        subprocess.run(["oiiotool", image, "--ch", "R,G,B", "--resize", f"{width}x0", "-d", "uint8", "-o", scaled], check=True)
        pictures.append(patinate.read_color(scaled))
        labels.append(label)
    strip = pathlib.Path(folder, "strip.png")
    patinate.write_color(strip, patinate.contact_strip(pictures, labels=labels))
    subprocess.run(["oiiotool", strip, "--compression", "jpeg:88", "-o", output], check=True)
