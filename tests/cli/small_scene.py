#!/usr/bin/env python3
"""A small capture, mesh, history and transfer, made with the binary under test, and the smallest scene.

Usage: small_scene.py PATINATE FOLDER makes them in FOLDER, once for all scripts that ctest runs: it names the folder in PATINATE_SMALL_SCENE.
"""
import os
import pathlib
import shutil
import subprocess
import sys

# Leans back by 30 degrees.
PLATE = "v -50 0 0\nv 50 0 0\nv 50 86 -50\nv -50 86 -50\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
# Drops of a texel that leave nothing where they end and draw no others: all that shows is a rule and a look. Without its "run".
PLATE_SCENE = {
    "format": "patinate.scene", "version": 2, "unit": "mm", "seed": 1, "atlas": {"resolution": 32},
    "materials": ["water", "metal", "patina"],
    "appearance": {"water": {"strength": 0.2}, "patina": {"strength": 0.5, "variation": 0.1}},
    "objects": [{"name": "plate", "mesh": "plate.obj", "preset": "copper"}],
    "emitters": [{"name": "rain", "shape": "sky", "speed": 300, "spread_deg": 5, "gammatons": 100, "carries": {"water": 0.8, "patina": 0.0}}],
    "behavior": {"slider": 0.5}, "exchange": {"rates": {"water": 0.3, "patina": 0.0}, "splat": 1, "deposit": False}, "tracing": {"wet_attraction": 0},
    "rules": ["patina", {"name": "evaporation", "rate": 0.5}],
    "time": {"unit": "h", "per_iteration": 0.2}}


def make_small_scene(program, folder):
    """`capture`, `urn`, `history` and `aged` in `folder`: copies of what PATINATE_SMALL_SCENE names, or made here; raises what went wrong."""
    made = os.environ.get("PATINATE_SMALL_SCENE")
    if made and pathlib.Path(made).is_dir():
        shutil.copytree(made, folder, dirs_exist_ok=True)
        return
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "-o", "capture"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["ingest", "capture", "-o", "history"],
                      ["transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "aged"]):
        result = subprocess.run([str(program), *arguments], cwd=folder, capture_output=True, text=True)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")


if __name__ == "__main__":
    os.environ.pop("PATINATE_SMALL_SCENE", None)
    scene = pathlib.Path(sys.argv[2])
    shutil.rmtree(scene, ignore_errors=True)
    scene.mkdir(parents=True)
    make_small_scene(pathlib.Path(sys.argv[1]).resolve(), scene)
