#!/usr/bin/python3
"""check_links.py FOLDER: every link and picture within the web pages of FOLDER leads to a file, and to an anchor, that is there."""
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.anchors, self.targets = set(), []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.targets.append(value)


def dead_links(folder):
    pages = {p.resolve(): Page(p) for p in folder.rglob("*.html")}
    for path, page in sorted(pages.items()):
        for target in dict.fromkeys(page.targets):
            url = urllib.parse.urlsplit(target)
            if url.scheme or url.netloc:
                continue
            to = (path.parent / urllib.parse.unquote(url.path)).resolve() if url.path else path
            anchor = urllib.parse.unquote(url.fragment)
            if not to.exists():
                yield f"{path.relative_to(folder.resolve())}: {target}: no such file"
            elif anchor and to in pages and anchor not in pages[to].anchors:
                yield f"{path.relative_to(folder.resolve())}: {target}: no such place in the page"


def main():
    dead = list(dead_links(pathlib.Path(sys.argv[1])))
    for line in dead:
        print(f"docs: {line}", file=sys.stderr)
    raise SystemExit(bool(dead))


if __name__ == "__main__":
    main()
