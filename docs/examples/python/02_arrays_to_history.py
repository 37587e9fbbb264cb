"""Makes a history of arrays, here a plate on which a dark spot grows, and keeps it for every other function and command.

    02_arrays_to_history.py FOLDER
"""
import sys

import numpy as np
import patinate

times = np.array([0.0, 1.0, 2.0, 4.0])                            # days, at any distance from each other
y, x = np.mgrid[0:96, 0:128]
distance = np.hypot(x - 64, y - 48).astype(np.float32)
spots = np.clip(10 * times[:, None, None] - distance, 0, 1)       # T x H x W
colors = 0.6 - 0.5 * spots[..., None] * np.array([0.6, 0.8, 1])   # T x H x W x 3, linear

history = patinate.history_from_arrays(colors, times, name="spot", time_unit="d", texel_size_mm=0.1, controls={"closeness": (1 - distance.clip(0, 40) / 40, 0, 4, "mm")})
history.save(sys.argv[1])
print(patinate.read_history(sys.argv[1]))
