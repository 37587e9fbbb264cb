"""Takes the textures of a transfer as one array, and follows what they say over time.

    06_textures_over_time.py TRANSFER TABLE.csv
"""
import sys

import numpy as np
import patinate

_, folder, table = sys.argv
aged = patinate.read_transfer(folder)
times = np.linspace(aged.history.times[0], aged.history.times[-1], 8)
textures = aged.texture(times)                                    # T x H x W x 3, linear
luminance = textures[:, aged.coverage] @ [0.2126, 0.7152, 0.0722]
dark = (luminance < 0.5 * np.median(luminance[0])).mean(axis=1)
np.savetxt(table, np.column_stack([times, luminance.mean(axis=1), dark]), delimiter=",", header=f"time_{aged.history.time_unit},luminance,dark_share", comments="")
print(f"{textures.shape}: {dark[-1]:.1%} of the texels end at less than half of the first luminance")
