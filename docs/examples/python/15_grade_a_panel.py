"""Grades the rust on two photographs of a panel: the rusted area with its interval, and the grades of two standards.

    15_grade_a_panel.py TABLE.csv
"""
import csv
import sys

import numpy as np
import patinate

photographs = np.full((2, 80, 100, 3), 0.5, np.float32)           # gray paint, linear color
photographs[1, 30:50, 40:60] = (0.2, 0.075, 0.03)                 # a twentieth of it is rust after 100 h
panel = patinate.history_from_arrays(photographs, [0.0, 100.0], time_unit="h")
graded = patinate.grade(panel, edge_mm=0)
with open(sys.argv[1], "w", newline="") as file:
    writer = csv.DictWriter(file, graded.rows()[0])
    writer.writeheader()
    writer.writerows(graded.rows())
percent, low, high = graded.sample.figures.rusted_percent[1]
print(f"{percent:.1f} % rusted ({low:.1f} to {high:.1f}), Ri {graded.sample.grades.ri[1]}, ASTM D610 grade {graded.sample.grades.d610[1]}")
