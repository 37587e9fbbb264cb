#!/usr/bin/env python3
"""The parts that tools/docs puts the manual together by, on small pages. Plain Python: Sphinx is not needed."""
import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/docs"))
import check_links  # noqa: E402
import docstrings  # noqa: E402
import markdown  # noqa: E402
import schema_pages  # noqa: E402


class Markdown(unittest.TestCase):
    def test_links_change_outside_code_only(self):
        text = "[a](b.md#c) `[a](b.md)`\n\n    [a](b.md)\n\n```\n[a](b.md)\n```\n[e](http://x) ![p](b.md) [s](#here)\n"
        seen = []
        changed = markdown.with_links(text, lambda path, anchor: seen.append((path, anchor)) or f"Z{anchor}")
        self.assertEqual(seen, [("b.md", "#c"), ("b.md", "")])
        self.assertEqual(changed, text.replace("[a](b.md#c)", "[a](Z#c)").replace("![p](b.md)", "![p](Z)"))

    def test_lists_of_links_lie_below_their_headings(self):
        text = "# T\n\n- [x](x.md): first\n\n## One\n\nno [y](y.md) list\n- [z](z.md)\n- [z](z.md#part)\n- [w](http://w)\n"
        self.assertEqual(markdown.lists_of_links(text), [("", ["x.md"]), ("One", ["z.md"])])


class Tables(unittest.TestCase):
    # A table beside the manual's list of pages is about 90 characters wide. Its widest column has about two thirds of that, so that a cell of this many is two lines.
    MOST = 120
    GENERATED = "<!-- From here on made by"  # Of docs/commands.md: an option's help is a sentence, in the terminal too.

    def cells(self, page):
        """(line number, cell as it is shown) of every table that is written by hand."""
        is_code = False
        for number, line in enumerate(page.read_text().split(self.GENERATED)[0].splitlines(), 1):
            if line.lstrip().startswith("```"):
                is_code = not is_code
            if not is_code and line.startswith("|"):
                self.assertRegex(line, r"\|$", f"{page}:{number}: a row ends with its line")
                for cell in re.split(r"(?<!\\)\|", line.strip("|")):
                    yield number, re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", cell.strip())

    def test_a_cell_holds_a_value_not_a_paragraph(self):
        pages = [p for p in sorted((ROOT / "docs").rglob("*.md")) if "decisions" not in p.parts]  # Records stay as they were written.
        self.assertGreater(len(pages), 50)
        long = [f"{page.relative_to(ROOT)}:{number}: {len(cell)}: {cell}" for page in [*pages, ROOT / "README.md", ROOT / "CONTRIBUTING.md"] for number, cell in self.cells(page) if len(cell) > self.MOST]
        self.assertEqual(long, [], "shorten these, and say the rest below the table")


class Schemas(unittest.TestCase):
    SCHEMA = {
        "title": "thing", "type": "object", "required": ["a"], "$defs": {"part": {"type": "object", "properties": {"n": {"const": 2}}}},
        "properties": {
            "a": {"type": "number", "exclusiveMinimum": 0, "maximum": 1, "description": "Low | high."},
            "b": {"type": "array", "items": {"$ref": "#/$defs/part"}},
            "c": {"type": "object", "properties": {"d": {"enum": ["x", "y"], "default": "x"}}}}}

    def test_table_has_ranges_references_and_inner_members(self):
        page = schema_pages.page(self.SCHEMA, "thing")
        self.assertIn("| `a` * | number (0, 1] | Low \\| high. |", page)
        self.assertIn("| `b` | list of [part](#part) |", page)
        self.assertIn('| `c.d` | `"x"`, `"y"` | Default: `"x"`. |'.replace("|  ", "| "), page.replace("|  Default", "| Default"))
        self.assertIn("## part", page)

    def test_every_member_of_every_schema_is_in_its_page(self):
        import json
        for path in sorted((ROOT / "docs/schema").glob("*.schema.json")):
            schema = json.loads(path.read_text())
            page = schema_pages.page(schema, path.name)
            for name in schema.get("properties", {}):
                with self.subTest(schema=path.name, member=name):
                    self.assertIn(f"| `{name}`", page)


class Docstrings(unittest.TestCase):
    def test_arguments_become_definitions_and_marks_are_kept(self):
        lines = ["What a_ does: a*b.", "", "By name:", "size: int = 1", "    Texels", "seed: int", "    Of `all`", "", "Returns x"]
        docstrings.as_restructured_text(None, "function", "f", None, None, lines)
        self.assertEqual("\n".join(lines), "What a\\_ does: a\\*b.\n\nBy name:\n\n``size: int = 1``\n    Texels\n\n``seed: int``\n    Of ``all``\n\nReturns x\n")


    def test_many_arguments_by_name_are_dots(self):
        import inspect
        few = inspect.signature(lambda self, a, *, b=1: None).parameters.values()
        many = inspect.signature(lambda a, *, b=1, c=1, d=1, e=1, f=1, g=1, h=1: None).parameters.values()
        self.assertEqual(docstrings.names_of(few), ["a", "*", "b"])
        self.assertEqual(docstrings.names_of(many), ["a", "*", "..."])


class Links(unittest.TestCase):
    def test_dead_ones_are_named(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "a.html").write_text('<p id="here"><a href="b.html#there">b</a><a href="#here">h</a><a href="c.html">c</a><a href="https://x/y">x</a>')
            (folder / "b.html").write_text('<a href="a.html#here">a</a>')
            self.assertEqual(list(check_links.dead_links(folder)), ["a.html: b.html#there: no such place in the page", "a.html: c.html: no such file"])


if __name__ == "__main__":
    unittest.main()
