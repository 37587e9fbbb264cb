"""Simulates dirty rain on a tilted plate whose scene and mesh are Python objects, and keeps the course as a history.

    08_scene_without_files.py HISTORY
"""
import sys

import patinate

plate = patinate.mesh_from_arrays([[-50, 0, 0], [50, 0, 0], [50, 86, -50], [-50, 86, -50]], [[0, 1, 2], [0, 2, 3]], uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
scene = {
    "format": "patinate.scene", "version": 2, "unit": "mm", "atlas": {"resolution": 64},
    "materials": ["water", "stone", "dirt"],
    "objects": [{"name": "plate", "mesh": "plate", "preset": "stone"}],
    "emitters": [{"name": "rain", "shape": "sky", "speed": 300, "gammatons": 2000, "carries": {"water": 0.5, "dirt": 0.5}}],
    "exchange": {"rates": {"water": 0.3, "dirt": 0.3}},
    "rules": ["evaporation"],
    "time": {"unit": "h", "per_iteration": 0.2}}
simulation = patinate.Simulation(scene, meshes={"plate": plate})
colors, times = [simulation.compose()["color"]], [simulation.time]
for _ in range(4):
    simulation.step(count=50)
    colors.append(simulation.compose()["color"])
    times.append(simulation.time)
history = patinate.history_from_arrays(colors, times, name="rain", origin="simulated", time_unit=simulation.time_unit, mask=simulation.coverage())
history.save(sys.argv[1])
print(history, {name: round(account["on_surfaces"], 1) for name, account in simulation.ledger().items()})
