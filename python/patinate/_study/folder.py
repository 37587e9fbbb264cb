"""The folder of a study: `cells.json`, and for each cell `cells/NAME` with what its steps make, `done/STEP/NAME` when a
step is done, and `logs/STEP/NAME.txt` with what it said. Whoever runs a step, `patinate study run` or Snakemake, leaves
the same."""
import os
import re

from patinate import CannotComplete, IoError, _native

from .cells import Cell, Part, Step

CELLS = "cells.json"
ERROR_MARK = "patinate: error: "
MOST_OF_LOG = 1 << 24


def shell_word(word):
    """A word as a shell takes it."""
    return word if re.fullmatch(r"[A-Za-z0-9._/=:,+@%-]+", word) else "'" + word.replace("'", "'\\''") + "'"


def make_folder(path):
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as error:
        raise CannotComplete(f"{path}: cannot be made; {error.strerror}") from None


class StudyFolder:
    """A study in its folder."""

    def __init__(self, path, name, parts):
        self.path, self.name, self.parts = path, name, parts

    def cells(self):
        return [(part, cell) for part in self.parts for cell in part.cells]

    def inside(self, *names):
        return os.path.join(self.path, *names)

    def done_file(self, step, cell):
        return self.inside("done", step.name, cell.name)

    def is_done(self, step, cell):
        """It was run to its end, and what it made is still there."""
        return is_done(self.path, step, cell)

    def log_file(self, step, cell):
        return self.inside("logs", step.name, cell.name + ".txt")

    def failure(self, step, cell):
        """The one line of a step that has failed; None of one that is done, or has not been run to its end."""
        log = self.log_file(step, cell)
        if self.is_done(step, cell) or not os.path.isfile(log):
            return None
        with open(log, encoding="utf-8", errors="replace") as file:
            text = file.read(MOST_OF_LOG)
        return text.rpartition(ERROR_MARK)[2].split("\n")[0] if ERROR_MARK in text else None


def made_path(step, cell):
    """Relative to the study's folder."""
    return f"cells/{cell.name}/{step.file}"


def is_done(folder, step, cell):
    return all(os.path.exists(os.path.join(folder, path)) for path in (f"done/{step.name}/{cell.name}", made_path(step, cell)))


def _is_free(folder):
    """Nothing is there, a study, or what was left where one was begun."""
    if not os.path.exists(folder) or os.path.exists(os.path.join(folder, CELLS)):
        return True
    return os.path.isdir(folder) and all(
        name in ("cells", "done", "logs") or _native._is_temporary(name) for name in os.listdir(folder))


def _part_json(part):
    steps = [{"name": s.name, "command": s.verb, "makes": s.file, **({"in_items": True} if s.in_items else {})}
             for s in part.steps]
    cells = [{"name": cell.name, "factors": cell.factors,
              "commands": {step.name: command for step, command in zip(part.steps, cell.commands)}}
             for cell in part.cells]
    return {"name": part.name, "steps": steps, "cells": cells}


def place_study(name, parts, folder):
    """Makes or updates a study's folder: cells.json, folders and scenes. What cells have made stays; what is no cell any
    more stays too, and is in no report."""
    if not _is_free(folder):
        raise CannotComplete(
            f"{folder}: exists and is no study's folder, so it is left untouched; give another")
    study = StudyFolder(folder, name, parts)
    for part, cell in study.cells():
        cell.commands = [" ".join([step.verb, *map(shell_word, words), "-o", shell_word(made_path(step, cell))])
                         for step, words in zip(part.steps, cell.words)]
    # First, so that a folder that was begun is known to be a study's.
    make_folder(folder)
    _native._save_json(study.inside(CELLS), {"format": "patinate.cells", "version": 1, "name": name,
                                             "parts": [_part_json(part) for part in parts]})
    for part in parts:
        for cell in part.cells:
            place = study.inside("cells", cell.name)
            make_folder(place)
            if cell.values:
                ranges = [{"name": pointer, "low": value, "high": value, "place": cell.scene}
                          for pointer, value in cell.values.items()]
                _native._write_scene(cell.scene, ranges, list(cell.values.values()), place)
        for step in part.steps:
            make_folder(study.inside("done", step.name))
            make_folder(study.inside("logs", step.name))
    return study


def read_study_folder(folder):
    path = os.path.join(folder, CELLS)
    if not os.path.exists(path):
        raise IoError(f"{folder}: is no study's folder; `patinate study run` or `study export` makes one")
    root = _native._load_json(path)
    try:
        if root["format"] != "patinate.cells" or root["version"] != 1:
            raise IoError(f"{path}: is of another version")
        parts = []
        for part in root["parts"]:
            steps = [Step(s["name"], s["command"], s["makes"], s.get("in_items", False)) for s in part["steps"]]
            cells = [Cell(c["name"], c["factors"], commands=[c["commands"][step.name] for step in steps])
                     for c in part["cells"]]
            parts.append(Part(part["name"], steps, cells))
        return StudyFolder(folder, root["name"], parts)
    except (KeyError, TypeError, AttributeError):
        raise IoError(f"{path}: does not hold what it should; is it of another version, or changed by hand?") from None
