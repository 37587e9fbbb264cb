#!/usr/bin/python3
"""The notebooks of docs/notebooks run from top to bottom, print what they keep, each in less than a minute on two processors. Exit code 77: skipped, where nbclient, matplotlib or
the kernel is missing (Debian's python3-nbclient, python3-matplotlib, python3-ipykernel)."""
import importlib.machinery
import importlib.util
import os
import pathlib
import resource
import sys

from python_case import PythonCase, main

NOTEBOOKS = sorted((pathlib.Path(__file__).parents[2] / "docs/notebooks").glob("*.ipynb"))
SECONDS = 60  # Of computing, so that it says the same on a machine that does other things too.
NEEDED = ("nbclient", "nbformat", "matplotlib", "ipykernel")


def texts_of(notebook):
    """What its cells print, without warnings."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", []) if output.get("name") != "stderr"]
    return ["".join(output.get("text") or output.get("data", {}).get("text/plain", "")) for output in outputs if "image/png" not in output.get("data", {})]


def pictures_of(notebook):
    return sum("image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", []))


class Notebooks(PythonCase):
    def test_each_runs_and_prints_what_it_keeps(self):
        import nbformat
        self.assertEqual(len(NOTEBOOKS), 4)
        folder = self.work / "notebooks"  # One for all, as a user has them.
        folder.mkdir()
        for path in NOTEBOOKS:
            with self.subTest(notebook=path.name):
                used = resource.getrusage(resource.RUSAGE_CHILDREN)
                made, kept = tool.executed(path, folder), nbformat.read(path, as_version=4)
                now = resource.getrusage(resource.RUSAGE_CHILDREN)
                self.assertEqual(texts_of(made), texts_of(kept), "tools/docs/notebooks keeps them anew")
                self.assertGreaterEqual(pictures_of(kept), 2)
                self.assertEqual(pictures_of(made), pictures_of(kept))
                self.assertIn("Exercises", kept.cells[-1].source)
                # Of two processors at most: computing is divided among them.
                self.assertLess((now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime) / 2, SECONDS)


if __name__ == "__main__":
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        print("notebooks: skipped: not installed: " + ", ".join(missing))
        sys.exit(77)
    loader = importlib.machinery.SourceFileLoader("notebooks", str(pathlib.Path(__file__).parents[2] / "tools/docs/notebooks"))
    tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("notebooks", loader))
    loader.exec_module(tool)
    main()
