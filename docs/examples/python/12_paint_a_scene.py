"""Paints on a simulation by hand, as in the studio: strokes of a brush cost no time. Then the scene ages on, and is saved.

    12_paint_a_scene.py FOLDER
"""
import sys

import numpy as np
import patinate

plate = patinate.mesh_from_arrays([[-50, 0, 0], [50, 0, 0], [50, 86, -50], [-50, 86, -50]], [[0, 1, 2], [0, 2, 3]], uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
scene = {
    "format": "patinate.scene", "version": 2, "unit": "mm", "atlas": {"resolution": 64},
    "materials": ["water", "stone", "dirt"],
    "objects": [{"name": "plate", "mesh": "plate", "preset": "stone"}],
    "emitters": [{"name": "brush", "shape": "disk", "position": [0, 60, 20], "direction": [0, -0.3, -1], "size": 10, "speed": 300, "gammatons": 500, "carries": {"water": 0.2, "dirt": 1}, "on": False}],
    "exchange": {"rates": {"water": 0.3, "dirt": 0.3}},
    "rules": ["evaporation"],
    "time": {"unit": "h", "per_iteration": 0.2}}
simulation = patinate.Simulation(scene, meshes={"plate": plate})
for x in np.linspace(-30, 30, 13):                                # a line from left to right
    simulation.paint("brush", [x, 60, 20])
print(f"{simulation.iteration} iterations; dirt on {np.mean(simulation.amounts('dirt')[simulation.coverage()] > 0.01):.0%} of the plate")
simulation.step(count=20)                                         # what is wet runs down
simulation.save(sys.argv[1])
