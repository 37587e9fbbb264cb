"""Saves a transfer, and makes a picture and a model of it. The commands below make the same bytes of the same folder:

    10_save_render_export.py HISTORY MESH FOLDER
    patinate transfer HISTORY MESH --unit mm --control facing --resolution 128 -o FOLDER
    patinate render FOLDER --num-times 3 --width 160 --height 160 --samples 4 -o FOLDER.png
    patinate export FOLDER --num-times 3 -o FOLDER.glb
"""
import sys

import patinate

_, history_folder, mesh_file, folder = sys.argv
aged = patinate.transfer(patinate.read_history(history_folder), patinate.read_mesh(mesh_file), "facing", resolution=128, mm_per_unit=1)
aged.save(folder)
patinate.render(folder, f"{folder}.png", num_times=3, width=160, height=160, samples=4)
patinate.export(folder, f"{folder}.glb", num_times=3)
