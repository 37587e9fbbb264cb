"""Finds the rate of a rule with which a simulation comes closest to a history.

    14_fit_a_scene.py SCENE HISTORY
"""
import sys

import patinate

_, scene, history = sys.argv
found = patinate.fit(scene, history, {"/rules/0/rate": (0.05, 20, "log")}, evaluations=20, figures={"mean_color": 1})
print(f"rate {found['values']['/rules/0/rate']:.3g}, objective {found.objective:.3g}")
for values, objective in found.evaluations[:3]:
    print(f"  tried {values['/rules/0/rate']:.3g}: {objective:.3g}")
