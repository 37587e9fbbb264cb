"""Writes control maps of a mesh: as EXR, which transfer() and `patinate transfer` take, and as pictures to look at.

    04_control_maps.py MESH FOLDER
"""
import pathlib
import sys

import numpy as np
import patinate

_, mesh_file, folder = sys.argv
pathlib.Path(folder).mkdir(exist_ok=True)
surface = patinate.Surface(patinate.read_mesh(mesh_file), resolution=256)
for name, expression in {"facing": "facing", "hollows": "accessibility", "mixed": "0.7*facing + 0.3*!accessibility"}.items():
    control = surface.control(expression)
    control.save(f"{folder}/{name}.exr")
    patinate.write_color(f"{folder}/{name}.png", np.repeat(control.values[..., None], 3, axis=2))
    print(f"{name}: 0 stands for {control.low:.3g} and 1 for {control.high:.3g} {control.unit}; mean {control.values[surface.coverage()].mean():.2f}")
