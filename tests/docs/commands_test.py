#!/usr/bin/env python3
"""What the manual tells a reader to type. Usage: commands_test.py PATINATE

The ```sh blocks of every page run in order, a fresh folder a page: all pages nightly, two per commit. Command lines in all other blocks name commands and options that exist.
"""
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/docs"))
import blocks  # noqa: E402

PATINATE = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate").resolve()
PER_COMMIT = {"photographs.md", "scans_and_lamps.md"}  # A newcomer's first ones.
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def options_by_command():
    """{command: its options}, from what the program says of itself; below None those of every command."""
    said = subprocess.run([PATINATE, "help", "--markdown"], capture_output=True, text=True, check=True).stdout
    found = {}
    for part in re.split(r"^## ", said, flags=re.MULTILINE)[1:]:
        name = part.splitlines()[0].strip()
        found[None if name.startswith("Options of every") else name] = set(re.findall(r"(?:^\| `|\(also )(-[-\w]+)", part, re.MULTILINE))
    return found


def command_lines(text):
    """The words behind `patinate` of the lines in blocks that begin with it."""
    for line in re.findall(r"^(?: {4}|(?:\$ )?)patinate (.+)$", text, re.MULTILINE):
        if not re.match(r"[a-z]+ ", line + " "):
            continue
        try:
            words = shlex.split(line.replace("(", "\\(").replace(")", "\\)"), comments=True)
        except ValueError:  # A quotation that goes on in the next line.
            words = line.split()
        for end in ("|", ">", "&&", ";", "->"):
            words = words[:words.index(end)] if end in words else words
        yield words


class Commands(unittest.TestCase):
    def test_blocks_run_as_they_stand(self):
        run = [page for page in PAGES if any(reason is None for _, _, reason in blocks.sh_blocks(page.read_text()))]
        self.assertGreaterEqual(len(run), 4)
        self.assertLessEqual(PER_COMMIT, {page.name for page in run})
        for page in run if os.environ.get("PATINATE_NIGHTLY") else [page for page in run if page.name in PER_COMMIT]:
            with self.subTest(page=page.name), tempfile.TemporaryDirectory(prefix="patinate_manual_") as folder:
                blocks.run_page(PATINATE, page, folder)

    def test_options_in_all_blocks_exist(self):
        known = options_by_command()
        self.assertIn("--threads", known[None])
        seen = 0
        for page in PAGES:
            for words in command_lines(page.read_text()):
                command = " ".join(words[:2]) if " ".join(words[:2]) in known else words[0]
                if command not in known or command in ("cluster plan", "cluster run"):  # A command with another one's options.
                    continue
                for word in words:
                    option = re.match(r"--[a-z][-a-z0-9]*", word)
                    if option:
                        seen += 1
                        with self.subTest(page=page.name, command=command, option=option.group()):
                            self.assertTrue(option.group() in known[command] | known[None] | {"--help", "--help-all", "--version"} or inverse(option.group()) in known[command])
        self.assertGreater(seen, 50)


def inverse(option):
    return option.replace("--no-", "--", 1) if option.startswith("--no-") else option


class Blocks(unittest.TestCase):
    def test_of_a_page_are_found_with_their_lines_and_reasons(self):
        text = "# A\n\n```sh\ntrue\n```\n\n<!-- not run: needs a browser -->\n```sh\nfalse\n```\n\n```python\npass\n```\n"
        self.assertEqual(blocks.sh_blocks(text), [(4, "true\n", None), (9, "false\n", "needs a browser")])

    def test_a_failing_one_is_named_by_its_line(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text("```sh\ntrue\n```\n\n```sh\nls no_such_file\ntrue\n```\n")
            with self.assertRaisesRegex(blocks.Failed, r"page\.md:6: exit code 2"):
                blocks.run_page(PATINATE, page, folder)


if __name__ == "__main__":
    unittest.main()
