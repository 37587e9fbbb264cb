"""Ages a mesh as a history aged, keeps the transfer, and writes how the mesh looks at the end: the twin of 01_one_call.cpp.

    01_one_call.py HISTORY MESH CONTROL FOLDER TEXTURE.png           e.g. copper bust.glb accessibility aged bust.png
"""
import sys

import patinate

_, history_folder, mesh_file, control, folder, texture = sys.argv
history = patinate.read_history(history_folder)
surface = patinate.Surface(patinate.read_mesh(mesh_file), resolution=512, texel_size=history.texel_size_mm)
aged = patinate.transfer(history, surface, control, seed=7)
aged.save(folder)
patinate.write_color(texture, aged.texture(history.times[-1]))
print(f"{folder}: control error {aged.energy['control_error_mean']:.3f}")
