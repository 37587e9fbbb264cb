"""Ages a mesh that exists as arrays only with a history that exists as arrays only: nothing is read.

    05_transfer_of_arrays.py PICTURE.png
"""
import sys

import numpy as np
import patinate

rng = np.random.default_rng(1)
x = np.linspace(0, 1, 128, dtype=np.float32)[None, :].repeat(96, axis=0)
grain = rng.random((96, 128), np.float32)
stages = [np.stack([0.5 - 0.3 * t * (x + 0.2 * grain)] * 3, axis=2) for t in (0.0, 0.5, 1.0)]
history = patinate.history_from_arrays(stages, [0, 5, 10], name="stain", time_unit="d", controls={"wetness": x})

angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, 60, 13))
positions = np.stack([20 * np.cos(angle), height, 20 * np.sin(angle)], axis=2).reshape(-1, 3)       # a tube
corner = (np.arange(12)[:, None] * 49 + np.arange(48)).reshape(-1, 1)
triangles = np.concatenate([corner + [0, 49, 1], corner + [1, 49, 50]])
mesh = patinate.mesh_from_arrays(positions, triangles)

aged = patinate.transfer(history, mesh, {"wetness": "height"}, resolution=256, mm_per_unit=1, texel_size=0.5)
patinate.write_color(sys.argv[1], patinate.render(aged, num_times=3, width=240, height=240))
print(aged.coordinates.shape, f"control error {aged.energy['control_error_mean']:.3f}")
