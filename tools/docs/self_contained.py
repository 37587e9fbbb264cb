"""Debian's furo wants a server: its style imports /javascript/..., its script is a module. Both are joined into one file each, so that pages opened as files have them."""
import pathlib
import re

NORMALIZE = pathlib.Path("/usr/share/javascript/normalize.css/normalize.css")


def join_files(app, failure):
    if failure:
        return
    static = pathlib.Path(app.outdir) / "_static"
    style, script = static / "styles/furo.css", static / "scripts/furo.js"
    style.write_text(re.sub(r"@import url\(/javascript/[^)]*\);", lambda _: NORMALIZE.read_text(), style.read_text()))
    name = re.match(r'import Gumshoe from "\./([\w.-]+)";\n', script.read_text())
    if name:
        scroll = (static / "scripts" / name.group(1)).read_text()
        script.write_text(scroll + script.read_text()[name.end():])
