# What Sphinx is told of the manual; tools/docs/build runs it on the pages that stage.py has put together.
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "build/release/python"), str(ROOT / "tools/docs")]

import docstrings  # noqa: E402
import self_contained  # noqa: E402

project = "patinate"
author = "the authors of patinate"
version = release = re.search(r"project\(patinate\s+VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
extensions = ["myst_parser", "sphinx.ext.autodoc", "breathe"]

myst_heading_anchors = 4
highlight_language = "none"
smartquotes = False  # --option stays what is typed.
html_theme = "furo"
html_title = f"patinate {version}"
html_static_path = ["static"]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
# A page opened as a file may not read others: results are titles then, with a server too.
html_show_search_summary = False

breathe_projects = {"patinate": str(ROOT / "build/docs/xml")}
breathe_default_project = "patinate"
breathe_show_include = False
cpp_id_attributes = ["PATINATE_API"]
autodoc_member_order = "bysource"
autodoc_typehints = "none"


def setup(app):
    app.connect("autodoc-process-docstring", docstrings.as_restructured_text)
    app.connect("autodoc-process-signature", docstrings.signature)
    app.connect("build-finished", self_contained.join_files)
