"""The notebooks as pages with their pictures: executed where the Python module is built, and kept until notebook or module changes."""
import importlib.util
import os
import pathlib
import re
import shutil
import sys

NEEDED = ("nbclient", "nbconvert", "nbformat", "ipykernel", "matplotlib")


def reason_not_to_run(root):
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        return "not installed: " + ", ".join(missing)
    return "" if any((root / "build/release/python/patinate").glob("_native*.so")) else "build/release has no Python module"


def executed(path, root, kept):
    """The notebook with what its cells print and show; from `kept` if that is younger than notebook and module."""
    import nbclient
    import nbformat
    module = max(p.stat().st_mtime for p in (root / "build/release/python/patinate").glob("_native*.so"))
    if kept.exists() and kept.stat().st_mtime > max(module, path.stat().st_mtime):
        return nbformat.read(kept, as_version=4)
    print(f"docs: running {path.name}")
    folder = kept.with_suffix("")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    notebook = nbformat.read(path, as_version=4)
    os.environ["PYTHONPATH"] = str(root / "build/release/python")
    os.environ.update(JUPYTER_PLATFORM_DIRS="1", PYDEVD_DISABLE_FILE_VALIDATION="1")
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
    nbformat.write(notebook, kept)
    return notebook


def page_of(notebook, name):
    """(Markdown, {file: bytes})"""
    from nbconvert import MarkdownExporter
    text, resources = MarkdownExporter().from_notebook_node(notebook, {"unique_key": name, "output_files_dir": f"{name}_files"})
    return re.sub(r"\x1b\[[0-9;]*m", "", text), resources["outputs"]


def make(root, folder):
    notebooks = sorted((root / "docs/notebooks").glob("*.ipynb"))
    reason = reason_not_to_run(root)
    if reason:
        print(f"docs: notebooks are shown without what they print: {reason}", file=sys.stderr)
    pages, files, links = {}, {}, []
    for path in notebooks:
        if reason:
            import json
            cells = json.loads(path.read_text())["cells"]
            text = "\n\n".join("".join(c["source"]) if c["cell_type"] == "markdown" else "```python\n" + "".join(c["source"]) + "\n```" for c in cells)
        else:
            text, pictures = page_of(executed(path, root, folder / "notebooks" / path.name), path.stem)
            files.update({f"notebooks/{name}": content for name, content in pictures.items()})
        pages[f"notebooks/{path.stem}.md"] = text
        links.append(f"- [{re.search(r'^# (.+)$', text, re.MULTILINE).group(1)}]({path.stem}.md)\n")
    about = "The files lie in docs/notebooks. Each runs in less than a minute on synthetic data, and says which line to exchange for yours."
    pages["notebooks/index.md"] = f"# Notebooks\n\n{about}\n\n" + "".join(links)
    return pages, files
