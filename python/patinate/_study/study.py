"""What a study's file says: transfers, simulations and fits, with every combination of what is listed."""
import os

from patinate import _native

from .cells import Level, Part, Step, make_cells
from .context import FOLDERS, Context, slug
from .options import Options
from .ranges import fit_words, varied_factors

# Commands that look at what a cell has made.
LOOKING = ("render", "texture", "lookup", "export", *FOLDERS)
VERBS = {**FOLDERS, "lookup": "texture"}  # A study keeps the words with which it was written.


class _Study:
    """Reads a study; what is wrong is collected in its context."""

    def __init__(self, context):
        self.context = context
        self.controls = []  # Of transfers: where each stands, and its texts.

    def read(self):
        context = self.context
        root = _native._read_json(context.file)
        root.expect_format("patinate.study")
        name = os.path.splitext(os.path.basename(context.file))[0]
        with context.attempt():
            name = root.member("name").string() if root.has("name") else name
        readers = [(root.member(member), read) for member, read in (("transfer", self._transfers),
                                                                    ("simulate", self._simulations),
                                                                    ("fit", self._fits)) if root.has(member)]
        parts = []
        for reader, read in readers:
            with context.attempt():
                parts.append(read(reader))
        if not readers:
            context.problems.append(f"{context.file}: holds neither `transfer` nor `simulate` nor `fit`")
        with context.attempt():
            root.finish()
        return name, parts

    def _add_input(self, reader, what, command, factor):
        """"a.obj", "scans/*.obj", or {"path": ..., "name": ..., "options": {...}}."""
        context = self.context
        options, name = [], None
        if reader.is_object():
            options, name = self._own_options(reader, command)
        text = reader.member("path") if reader.is_object() else reader
        given = text.string()
        paths = [_native._library_place(given)]
        if paths[0] == given:
            paths = [text.path()]
        parent, pattern = os.path.split(paths[0])
        if "*" in pattern:
            parent = parent or "."
            if not os.path.isdir(parent):
                return context.problem(text, f"`{given}`: there is no folder {parent}")
            paths = [os.path.join(parent, name) for name in _native._list_files(parent, pattern)]
            if not paths:
                context.problem(text, f"no file matches `{given}`")
        if reader.is_object():
            with context.attempt():
                reader.finish()
        for path in paths:
            context.check_place(text, path)
            base = os.path.basename(path.rstrip("/"))
            shown = name if name is not None else base if os.path.isdir(path) else os.path.splitext(base)[0]
            factor.append(Level(slug(shown), {what: shown}, [context.word_of(path), *options], path))

    def _own_options(self, reader, command):
        """Words of the options of one input, and its name, if any."""
        context, options, name = self.context, [], None
        with context.attempt():
            name = reader.member("name").string() if reader.has("name") else None
        if reader.has("options"):
            with context.attempt():
                num_before = len(context.problems)
                options = command.all_words(reader.member("options"))
                if len(context.problems) == num_before:
                    command.check_together(reader.member("options"), options)
        return options, name

    def _listed(self, part, member, add):
        """The levels that `add` makes of each element of a list."""
        factor = []
        elements = part.member(member)
        for element in elements.elements():
            with self.context.attempt():
                add(element, factor)
        if not elements.elements():
            self.context.problem(elements, "expected at least one")
        return factor

    def _inputs(self, part, command, *members):
        factors = []
        for member, what in members:
            factors.append([])
            with self.context.attempt():
                factors[-1] = self._listed(part, member,
                                           lambda e, factor, what=what: self._add_input(e, what, command, factor))
        return factors

    def _checked_control(self, reader, text):
        """A typo is said before anything runs; maps are files beside the study's, for commands in its folder."""
        try:
            for name in _native._control_files(text):
                path = os.path.join(os.path.dirname(self.context.file), name)
                self.context.check_place(reader, path)
                text = text.replace(name, self.context.word_of(path), 1)
        except _native.ParseError as error:
            self.context.problem(reader, str(error))
        return text

    def _check_sources(self, histories):
        """A control that one of the histories lacks."""
        for history in filter(os.path.exists, histories):
            for reader, texts in self.controls:
                problem = _native._control_problem(history, texts)
                if problem:
                    self.context.problem(reader, problem)

    def _add_control(self, reader, factor):
        """"progress=accessibility", ["...", "..."] together, or {"control": ..., "name": ...}."""
        control = reader.member("control") if reader.is_object() else reader
        readers = control.elements() if control.is_array() else [control]
        if not readers:
            control.fail("at least one control")
        num_before = len(self.context.problems)
        texts, words = [], []
        for one in readers:
            with self.context.attempt():
                texts.append(one.string())
                words += ["--control", self._checked_control(one, texts[-1])]
        shown = " + ".join(texts)
        if len(self.context.problems) == num_before:
            self.controls.append((control, texts))
        name = reader.member("name").string() if reader.is_object() and reader.has("name") else shown
        if reader.is_object():
            reader.finish()
        factor.append(Level(slug(name), {"control": shown}, words))

    def _add_output(self, reader, part, step_words):
        context = self.context
        word = reader.member("command").choice(LOOKING)
        verb = VERBS.get(word, word)
        name, file, words, options = word, None, [], []
        num_before = len(context.problems)
        with context.attempt():
            name = reader.member("name").string() if reader.has("name") else word
            if slug(name) != name or "." in name:
                reader.member("name").fail("letters, digits and `_`")
        with context.attempt():
            file = name if word in FOLDERS and not reader.has("file") else reader.member("file").string()
            if not _native._is_file_name(file):
                reader.member("file").fail("a name of " + _native._FILE_NAME)
        if word == "compare":
            with context.attempt():
                other = reader.member("with")
                context.check_place(other, other.path())
                words.append(context.word_of(other.path()))
        command = Options(context, verb)
        with context.attempt():
            options = command.all_words(reader.member("options")) if reader.has("options") else []
            if len(context.problems) == num_before:
                command.check_together(reader, options, file)
        with context.attempt():
            reader.finish()
        step = Step(f"{part.name}_{name}", verb, file)
        for other in part.steps:
            if other.name == step.name:
                context.problem(reader, f"two steps are called `{name}`; give them a `name`")
            if file is not None and other.file == file:
                context.problem(reader, f"two steps make `{file}`")
        part.steps.append(step)
        step_words.append(words + options)

    def _finish(self, reader, factors, part):
        step_words = []
        if part.name != "fit" and reader.has("outputs"):
            with self.context.attempt():
                for output in reader.member("outputs").elements():
                    with self.context.attempt():
                        self._add_output(output, part, step_words)
        with self.context.attempt():
            reader.finish()
        for problem in make_cells(factors, step_words, part):
            self.context.problem(reader, problem)
        return part

    def _transfers(self, reader):
        command = Options(self.context, "transfer")
        factors = self._inputs(reader, command, ("histories", "history"), ("meshes", "mesh"))
        with self.context.attempt():
            factors.append(self._listed(reader, "controls", self._add_control))
        self._check_sources([level.file for level in factors[0]])
        with self.context.attempt():
            factors += command.factors(reader)
        return self._finish(reader, factors, Part("transfer", [Step("transfer", "transfer", "transfer")]))

    def _simulations(self, reader):
        context = self.context
        command = Options(context, "simulate")
        factors = self._inputs(reader, command, ("scenes", "scene"))
        with context.attempt():
            scenes = [level.file for level in factors[0]]
            factors += varied_factors(context, reader, scenes)
        with context.attempt():
            factors += command.factors(reader)
        return self._finish(reader, factors, Part("simulate", [Step("simulate", "simulate", "simulation")]))

    def _fits(self, reader):
        context = self.context
        command = Options(context, "fit")
        factors = self._inputs(reader, command, ("scenes", "scene"), ("histories", "history"))
        kinds = []
        with context.attempt():
            scenes = [level.file for level in factors[0]]
            words, kinds = fit_words(context, reader, scenes)
            factors.append([Level("", {}, words)])
        with context.attempt():
            factors += command.factors(reader)
        part = self._finish(reader, factors, Part("fit", [Step("fit", "fit", "fit", True)]))
        if not context.problems:
            self._check_budgets(reader, kinds, part)
        return part

    def _check_budgets(self, reader, kinds, part):
        """`kinds`: of each number, whether it only changes the look."""
        told = set()
        for cell in part.cells:
            words = cell.words[0]
            given = {word: int(value) for word, value in zip(words, words[1:])
                     if word in ("--evaluations", "--population")}
            told.add(_native._fit_budget_problem(given.get("--evaluations", 0), given.get("--population", 0),
                                                 kinds.count(False), kinds.count(True)))
        for problem in sorted(told - {""}):
            self.context.problem(reader, problem)


def read_study(file, folder, program):
    """Reads a study's file. `folder`: the study's own, where its commands are to be given. Gives its name, its parts
    and what is wrong with it, a line each."""
    context = Context(file, folder, program)
    name, parts = _Study(context).read()
    return name, parts, context.problems
