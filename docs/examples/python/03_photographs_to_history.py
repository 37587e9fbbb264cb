"""Makes a history of a folder of photographs. What was guessed is printed: mend capture.json, and run the script again.

    03_photographs_to_history.py PHOTOGRAPHS HISTORY
"""
import pathlib
import sys

import patinate

_, photographs, folder = sys.argv
if not pathlib.Path(photographs, "capture.json").exists():
    draft = patinate.init(photographs)
    for line in draft.found + draft.check:
        print(line)
history = patinate.ingest(photographs, folder, force=True)        # replaces the history if capture.json was changed
print(history)
for warning in history.warnings:
    print("warning:", warning)
