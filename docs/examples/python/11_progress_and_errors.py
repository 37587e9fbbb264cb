"""Follows a long call, ends it, and catches what can go wrong.

    11_progress_and_errors.py HISTORY MESH
"""
import sys

import patinate

_, history_folder, mesh_file = sys.argv
history, mesh = patinate.read_history(history_folder), patinate.read_mesh(mesh_file)


class Enough(Exception):
    pass


def stop_half_way(fraction):
    print(f"\r{fraction:4.0%}", end="")
    if fraction > 0.5:
        raise Enough


try:
    patinate.transfer(history, mesh, "facing", resolution=512, on_progress=stop_half_way)    # True shows a bar where tqdm is installed
except Enough:
    print("\nended by its own function; nothing half-made is left")

try:
    patinate.transfer(history, mesh, "facing", resolution=1)
except patinate.InvalidInput as error:                            # also a ValueError
    print(error)
try:
    patinate.read_history("nowhere")
except OSError as error:                                          # patinate.IoError
    print(error)
try:
    patinate.transfer(history, mesh, "facng")
except patinate.ParseError as error:
    print(error)
