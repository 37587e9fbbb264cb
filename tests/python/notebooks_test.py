#!/usr/bin/python3
"""The notebooks of docs/notebooks run from top to bottom, each in less than a minute on two processors. Exit code 77: skipped, where nbclient, matplotlib or
the kernel is missing (Debian's python3-nbclient, python3-matplotlib, python3-ipykernel)."""
import importlib.util
import os
import pathlib
import resource
import sys

from python_case import PythonCase, main

NOTEBOOKS = sorted((pathlib.Path(__file__).parents[2] / "docs/notebooks").glob("*.ipynb"))
SECONDS = 60  # Of computing, so that it says the same on a machine that does other things too.
NEEDED = ("nbclient", "nbformat", "matplotlib", "ipykernel")


class Notebooks(PythonCase):
    def test_each_runs_and_shows_pictures(self):
        import nbclient
        import nbformat
        self.assertEqual(len(NOTEBOOKS), 4)
        folder = self.work / "notebooks"  # One for all, as a user has them.
        folder.mkdir()
        for path in NOTEBOOKS:
            with self.subTest(notebook=path.name):
                notebook = nbformat.read(path, as_version=4)
                self.assertTrue(all(not cell.get("outputs") for cell in notebook.cells), "kept without outputs: no commit changes with a machine")
                used = resource.getrusage(resource.RUSAGE_CHILDREN)
                nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
                now = resource.getrusage(resource.RUSAGE_CHILDREN)
                pictures = sum("image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", []))
                self.assertGreaterEqual(pictures, 2)
                # Of two processors at most: computing is divided among them.
                self.assertLess((now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime) / 2, SECONDS)


if __name__ == "__main__":
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        print("notebooks: skipped: not installed: " + ", ".join(missing))
        sys.exit(77)
    os.environ["JUPYTER_PLATFORM_DIRS"] = "1"
    main()
