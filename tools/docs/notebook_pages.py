"""The notebooks as pages, with what `tools/docs/notebooks` has kept in them."""
import base64
import json
import re


def page_of(path):
    """(Markdown, {file: bytes})"""
    blocks, pictures = [], {}
    for cell in json.loads(path.read_text())["cells"]:
        text = "".join(cell["source"])
        blocks.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{path.stem}_{len(pictures)}.png"
                pictures[name] = base64.b64decode(data["image/png"])
                blocks.append(f"![what the cell above shows]({name})")
            else:
                blocks.append("```text\n" + "".join(output.get("text") or data.get("text/plain", "")).rstrip() + "\n```")
    return "\n\n".join(blocks), pictures


def make(root, folder):
    pages, files, links = {}, {}, []
    for path in sorted((root / "docs/notebooks").glob("*.ipynb")):
        text, pictures = page_of(path)
        files.update({f"notebooks/{name}": content for name, content in pictures.items()})
        pages[f"notebooks/{path.stem}.md"] = text
        links.append(f"- [{re.search(r'^# (.+)$', text, re.MULTILINE).group(1)}]({path.stem}.md)\n")
    about = "The files lie in docs/notebooks. Each runs in less than a minute on synthetic data, says which line to exchange for yours, and ends with two exercises."
    pages["notebooks/index.md"] = f"# Notebooks\n\n{about}\n\n" + "".join(links)
    return pages, files
