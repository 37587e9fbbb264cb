"""Makes a history of a folder of photographs. What was guessed is printed, so that capture.json can be mended and the script run again.

    03_photographs_to_history.py PHOTOGRAPHS HISTORY
"""
import sys

import patinate

_, photographs, folder = sys.argv
draft = patinate.init(photographs)
for line in draft.found + draft.check:
    print(line)
history = patinate.ingest(draft.project, folder)
print(history)
for warning in history.warnings:
    print("warning:", warning)
