"""Test cases that run the binary as a user does: exit codes, and what a command says and leaves behind."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from small_scene import make_small_scene

# Exit codes: could not do it, command line, input, interrupted.
CANNOT, USAGE, INPUT, INTERRUPTED = 1, 2, 3, 130

# For what is too long for every commit: tools/nightly sets the variable.
nightly = unittest.skipUnless(os.environ.get("PATINATE_NIGHTLY"), "runs nightly")


def four_per_commit(commands):
    """Of {name: command line}: all of them nightly, and per commit those whose jobs differ most."""
    return commands if os.environ.get("PATINATE_NIGHTLY") else {name: commands[name] for name in ("ingest", "transfer", "simulate", "glb")}


def tree_of(folder):
    """Relative path -> bytes of every file but run.json, which differs from run to run, and what a transfer keeps of its history's analysis."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "run.json" and ".cache" not in p.parts}


class CommandCase(unittest.TestCase):
    """Runs the program in a folder of its own; `shared` holds `capture`, `urn`, `history` and `aged`. Both are known after `use`."""
    patinate = shared = None
    is_sanitized = False
    has_module = False  # The Python module of the same build, without which there are no studies.

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_cli_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def take(self, name):
        """A copy of something that `use` has made, to be damaged."""
        shutil.copytree(self.shared / name, self.folder / name)
        return self.folder / name

    def run_patinate(self, *arguments, **more):
        return subprocess.run([self.patinate, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120, **more)

    def succeeds(self, *arguments):
        result = self.run_patinate(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def fails(self, code, about, *arguments):
        """Exactly one line, with `about` in it; nothing new in the folder, but finished frames in out.partial, and what is kept of an analysis."""
        def tree():
            return sorted(p for p in self.folder.rglob("*") if not {"out.partial", ".cache"} & set(p.parts))
        before = tree()
        result = self.run_patinate(*arguments)
        lines = [line for line in result.stderr.splitlines() if line]
        if self.is_sanitized:
            lines = [line for line in lines if not line.startswith("libpng error: ")]
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("patinate: error: "), lines[0])
        self.assertIn(about, lines[0])
        self.assertEqual(result.stdout, "")
        self.assertEqual(tree(), before)
        return lines[0]

    def edit_json(self, path, change):
        content = json.loads(path.read_text())
        change(content)
        path.write_text(json.dumps(content))


def use(patinate):
    """For setUpModule: tests of the module run this program, on a small scene that it makes and that goes with the module."""
    CommandCase.patinate = str(pathlib.Path(patinate).resolve())
    # Sanitizers report on stderr, so under them the libraries are not silenced there (tools/patinate/command_line/message_stream.h).
    CommandCase.is_sanitized = b"__asan_init" in pathlib.Path(patinate).read_bytes()
    CommandCase.has_module = any(pathlib.Path(CommandCase.patinate).parent.parent.glob("python/patinate/_native.*"))
    CommandCase.shared = pathlib.Path(tempfile.mkdtemp(prefix="patinate_cli_"))
    unittest.addModuleCleanup(shutil.rmtree, CommandCase.shared)
    make_small_scene(CommandCase.patinate, CommandCase.shared)
