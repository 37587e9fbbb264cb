"""Ages a mesh by a control of one's own: rain that comes from one side, and splashes near the ground.

    07_own_control.py HISTORY MESH FOLDER
"""
import sys

import numpy as np
import patinate

_, history_folder, mesh_file, folder = sys.argv
history = patinate.read_history(history_folder)
surface = patinate.Surface(patinate.read_mesh(mesh_file), resolution=256, texel_size=history.texel_size_mm)
position, normal, covered = surface.positions(), surface.normals(), surface.coverage()

wind = np.array([0.8, -0.6, 0.0])                                 # y is up
rain = np.clip(-normal @ wind, 0, 1)
height = position[..., 1] - position[..., 1][covered].min()
splash = np.exp(-height / 20)                                     # mm
wet = np.where(covered, np.clip(rain + splash, 0, 1), 0).astype(np.float32)

aged = patinate.transfer(history, surface, {next(iter(history.controls)): wet})
aged.save(folder)
print(aged, f"control error {aged.energy['control_error_mean']:.3f}")
