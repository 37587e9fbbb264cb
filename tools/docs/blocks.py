#!/usr/bin/python3
"""blocks.py PATINATE PAGE.md FOLDER: runs the ```sh blocks of a page in order, in FOLDER, as a reader would type them. A block below a line
`<!-- not run: REASON -->` is left out."""
import os
import pathlib
import re
import subprocess
import sys

BLOCK = re.compile(r"^(?:<!-- not run: (?P<reason>[^\n]+) -->\n)?```sh\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)


class Failed(Exception):
    pass


def sh_blocks(text):
    """[(line, code, why it is not run, or None)]"""
    return [(text.count("\n", 0, m.start("code")) + 1, m["code"], m["reason"]) for m in BLOCK.finditer(text)]


def run_page(patinate, page, folder):
    """Each block in a shell of its own that ends at the first error; `patinate` is on the PATH."""
    environment = {**os.environ, "PATH": f"{pathlib.Path(patinate).resolve().parent}{os.pathsep}{os.environ['PATH']}"}
    for line, code, reason in sh_blocks(page.read_text()):
        if reason is None:
            result = subprocess.run(["bash", "-euo", "pipefail", "-c", code], cwd=folder, env=environment, capture_output=True, text=True)
            if result.returncode:
                raise Failed(f"{page}:{line}: exit code {result.returncode}\n{code}\n{result.stdout}{result.stderr}")


if __name__ == "__main__":
    run_page(sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3])
