"""The page of the Python module: what it defines, said by its own docstrings."""
import sys


def make(root, _folder):
    package = root / "build/release/python"
    if not any(package.glob("patinate/_native*.so")):
        print("docs: build/release has no Python module: its page is left out", file=sys.stderr)
        return {"python_reference.md": "# Python reference\n\nLeft out: the module was not built.\n"}, {}
    text = "# Python reference\n\n[Python](python.md) is the guide; this is what `help()` says.\n\n"
    return {"python_reference.md": text + "```{eval-rst}\n.. automodule:: patinate\n   :members:\n   :imported-members:\n   :undoc-members:\n```\n"}, {}
