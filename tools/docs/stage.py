#!/usr/bin/python3
"""stage.py FOLDER: puts the manual's sources together in FOLDER/source: the pages of docs/ with links that hold there, and pages made of schemas,
headers, notebooks, examples and what else is linked to in the repository."""
import pathlib
import posixpath
import subprocess
import sys

import header_pages
import markdown
import notebook_pages
import python_pages
import schema_pages

ROOT = pathlib.Path(__file__).resolve().parents[2]
LANGUAGES = {".cpp": "cpp", ".h": "cpp", ".inl": "c", ".py": "python", ".sh": "bash", ".json": "json", ".mjs": "javascript", ".ipynb": "json", ".txt": "cmake"}
PICTURES = {".jpg", ".png", ".svg"}
FOLDERS = {"docs/algorithms": "how_it_works.md", "docs/schema": "schema/index.md", "docs/notebooks": "notebooks/index.md",
           "docs/decisions": "decisions/index.md", "docs/examples": "examples/index.md"}


class Manual:
    """Pages by their path below `source`; what they link to in the repository comes along."""

    def __init__(self):
        self.pages = {}      # path -> text
        self.files = {}      # path -> bytes or a file to copy
        self.wanted = []     # files and folders of the repository that pages link to
        self.listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()

    def place_of(self, path):
        """Where a file or folder of the repository stands in the manual."""
        if path in FOLDERS:
            return FOLDERS[path]
        if path.startswith("docs/schema/"):
            return path[5:].replace(".schema.json", ".md")
        if path.startswith("docs/notebooks/"):
            return path[5:].replace(".ipynb", ".md")
        if path.startswith("docs/") and (path.endswith(".md") or pathlib.Path(path).suffix in PICTURES):
            return path[5:]
        if pathlib.Path(path).suffix in PICTURES:
            return f"repository/{path}"
        self.wanted.append(path)
        return f"repository/{path}/index.md" if (ROOT / path).is_dir() else f"repository/{path.removesuffix('.md')}.md"

    def add(self, place, text, origin=None):
        """A page; `origin` is its path in the repository, from which its links start, if they are to be changed."""
        if origin:
            def replaced(path, anchor):
                target = posixpath.normpath(posixpath.join(posixpath.dirname(origin), path))
                if not (ROOT / target).exists():
                    raise SystemExit(f"docs: {origin}: {path} does not exist")
                return posixpath.relpath(self.place_of(target), posixpath.dirname(place) or ".") + anchor
            text = markdown.with_links(text, replaced)
        self.pages[place] = text

    def add_linked(self):
        """Files and folders that pages link to, shown as they are."""
        done = set()
        while self.wanted:
            path = self.wanted.pop()
            if path in done:
                continue
            done.add(path)
            if (ROOT / path).is_dir():
                self.add(f"repository/{path}/index.md", self.folder_page(path), f"{path}/index.md")
                self.pages[f"repository/{path}/index.md"] = "---\norphan: true\n---\n" + self.pages[f"repository/{path}/index.md"]
            elif path.endswith(".md"):
                self.add(f"repository/{path}", "---\norphan: true\n---\n" + (ROOT / path).read_text(), path)
            else:
                self.pages[f"repository/{path}.md"] = "---\norphan: true\n---\n" + self.file_page(path)

    def folder_page(self, path):
        names = sorted({f[len(path) + 1:].split("/")[0] for f in self.listed if f.startswith(f"{path}/")})
        shown = [n for n in names if (ROOT / path / n).is_dir() or pathlib.Path(n).suffix in LANGUAGES]
        return f"# {path}\n\n" + "".join(f"- [{n}]({n})\n" if n in shown else f"- {n}\n" for n in names)

    def file_page(self, path):
        self.files[f"repository/{path}"] = ROOT / path
        language = LANGUAGES.get(pathlib.Path(path).suffix, "none")
        return f"# {path}\n\n```{{literalinclude}} {posixpath.basename(path)}\n:language: {language}\n:force:\n```\n"

    def add_toctrees(self):
        """The tree of pages, from the lists of links of the index and of each page that lists others."""
        placed, to_do = {"index.md"}, ["index.md"]
        while to_do:
            page = to_do.pop(0)
            for heading, paths in markdown.lists_of_links(self.pages[page]):
                children = [posixpath.normpath(posixpath.join(posixpath.dirname(page), p)) for p in paths]
                children = [c for c in children if c not in placed and c in self.pages and not c.startswith("repository/")]
                placed.update(children)
                to_do += children
                if children:
                    caption = f":caption: {heading}\n" if page == "index.md" and heading else ""
                    self.pages[page] += f"\n```{{toctree}}\n:hidden:\n{caption}\n" + "".join(f"/{c.removesuffix('.md')}\n" for c in children) + "```\n"

    def write(self, source):
        """Only what has changed is written, so that Sphinx reads only that again."""
        files = {**{p: t.encode() for p, t in self.pages.items()}, **self.files}
        for old in [p for p in source.rglob("*") if p.is_file() and str(p.relative_to(source)) not in files]:
            old.unlink()
        for path, content in files.items():
            content = content if isinstance(content, bytes) else content.read_bytes()
            to = source / path
            if not to.exists() or to.read_bytes() != content:
                to.parent.mkdir(parents=True, exist_ok=True)
                to.write_bytes(content)


def list_page(title, text, links):
    return f"# {title}\n\n{text}\n\n" + "".join(f"- [{name}]({path})\n" for name, path in links)


def main():
    folder = pathlib.Path(sys.argv[1])
    manual = Manual()
    for page in sorted((ROOT / "docs").rglob("*.md")):
        origin = str(page.relative_to(ROOT))
        manual.add(origin[5:], page.read_text(), origin)
    for picture in (p for p in (ROOT / "docs").rglob("*") if p.suffix in PICTURES):
        manual.files[str(picture.relative_to(ROOT / "docs"))] = picture

    decisions = sorted(p for p in manual.pages if p.startswith("decisions/"))
    manual.add("decisions/index.md", list_page("Decisions", "Why things are as they are.", [(markdown.title(manual.pages[p]), posixpath.basename(p)) for p in decisions]))
    examples = sorted((ROOT / "docs/examples").glob("*.cpp"))
    text = "Programs from one call to full control; [CMakeLists.txt](CMakeLists.txt) builds them against an installed patinate."
    manual.add("examples/index.md", list_page("C++ examples", text, [(e.name, e.name) for e in examples]), "docs/examples/index.md")
    for schema_page, page_text in schema_pages.make(ROOT / "docs/schema").items():
        manual.add(f"schema/{schema_page}", page_text)
    for make in (header_pages.make, python_pages.make, notebook_pages.make):
        pages, files = make(ROOT, folder)
        for path, page_text in pages.items():
            manual.add(path, page_text)
        manual.files.update(files)
    made = "- [Python reference](python_reference.md): what `help()` says\n- [C++ reference](cxx/index.md): the public headers\n"
    manual.pages["index.md"] = manual.pages["index.md"].replace("## Reference\n\n", "## Reference\n\n" + made)
    manual.add_linked()
    manual.add_toctrees()
    manual.write(folder / "source")


if __name__ == "__main__":
    main()
