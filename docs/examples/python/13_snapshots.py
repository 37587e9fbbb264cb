"""Tries two ways to go on from a snapshot of a simulation, then saves it, opens it again, and goes on.

    13_snapshots.py SCENE EMITTER FOLDER
"""
import sys

import numpy as np
import patinate

_, scene, emitter, folder = sys.argv
simulation = patinate.Simulation(scene)
simulation.step(count=10)
kept = simulation.snapshot()                                      # bytes

simulation.step(count=10)
rained = simulation.compose()["color"]
simulation.restore(kept)                                          # back to iteration 10
simulation.apply({"op": "switch", "target": emitter, "on": False})
simulation.step(count=10)
dry = simulation.compose()["color"]
print(f"the colors differ by {np.abs(rained - dry).mean():.4f} on average")

simulation.restore(kept)
simulation.save(folder)
later = patinate.Simulation(folder)                               # goes on as if it had not been interrupted
later.step(count=10)
simulation.step(count=10)
print("the same state:", later.snapshot() == simulation.snapshot())
