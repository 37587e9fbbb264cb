"""Asks which controls explain where a surface aged, and uses the best mix of them.

    16_explain_a_pattern.py HISTORY MESH FOLDER
"""
import sys

import numpy as np
import patinate

_, history, mesh_file, folder = sys.argv
surface = patinate.Surface(patinate.read_mesh(mesh_file), resolution=128, mm_per_unit=1)
noise = np.random.default_rng(1).normal(0, 0.1, (surface.height, surface.width))
seen = (surface.control("facing").values + noise).astype(np.float32)    # your own: how much each texel has aged

why = patinate.explain(surface, seen, ["facing", "accessibility", "height"], mask=surface.coverage())
for name, found in why.candidates.items():
    print(f"{name:14} {found.correlation:+.2f} ({found.low:+.2f} to {found.high:+.2f})")
aged = patinate.transfer(history, surface, f"thickness={why.mix.expression}")
aged.save(folder)
