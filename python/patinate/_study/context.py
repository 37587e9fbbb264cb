"""Where a study lies, what is wrong with it, and what commands say of their options."""
import contextlib
import json
import os
import subprocess

import patinate
from patinate import _native

# What looks at what a cell has made, and makes a folder: the word of a study file, and the command.
FOLDERS = {"evaluate": "evaluate", "compare": "history compare", "factorize": "history factorize"}


class Program:
    """What commands say of their options, asked of the program itself."""

    def __init__(self, program):
        self.process = subprocess.Popen([program, "study", "check"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)
        self.declared = {}

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()

    def _ask(self, **question):
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        if "error" in answer:
            raise patinate.InputError(answer["error"])
        return answer

    def arguments(self, verb):
        if verb not in self.declared:
            self.declared[verb] = self._ask(verb=verb)["arguments"]
        return self.declared[verb]

    def problem(self, verb, words, output=None):
        """What the command says of these options, beside each other if it is known what -o is given; or None."""
        is_folder = output is not None and verb in FOLDERS.values()
        return self._ask(verb=verb, words=words, output=output, is_folder=is_folder).get("problem")


class Context:
    """Collects what is wrong with a study that lies in `file` and is made in `folder`."""

    def __init__(self, file, folder, program):
        self.file, self.given = file, folder
        self.folder = os.path.realpath(folder)
        self.program = program
        self.problems = []

    @contextlib.contextmanager
    def attempt(self):
        try:
            yield
        except patinate.InputError as error:
            self.problems.append(str(error))

    def problem(self, reader, text):
        self.problems.append(f"{self.file}: {reader.pointer}: {text}")

    def word_of(self, path):
        """A path as commands name it that are given in the study's folder."""
        whole = os.path.abspath(path)
        named = os.path.relpath(whole, os.path.abspath(self.given))
        seen = os.path.normpath(os.path.join(self.folder, named))
        if not (os.path.exists(seen) and os.path.exists(whole) and os.path.samefile(seen, whole)):
            named = os.path.relpath(os.path.realpath(whole), self.folder)  # A link lies between them.
        return named + "/" * (path.endswith("/") and not named.endswith("/"))

    def check_place(self, reader, path):
        try:
            _native._require_exists(path)
        except patinate.InputError as error:
            return self.problem(reader, str(error))
        if os.path.commonpath([self.folder, os.path.realpath(path)]) == self.folder:
            self.problem(reader, f"{path} lies in the study's own folder, so that the study would wait for itself")


def slug(text):
    """A text as a part of a file's name."""
    out = ""
    for c in text:
        if c in "._" or (c.isascii() and c.isalnum()):
            out += c
        elif out and out[-1] != "_":
            out += "_"
    return out.rstrip("_.").lstrip(".") or "x"
