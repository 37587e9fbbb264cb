"""Options of a study's commands, by the names that the commands have for them."""
import os

from patinate import _native

from .cells import Level
from .context import slug

# Options with which `simulate` makes something else, or several.
NOT_OF_STUDIES = ("estimate", "replicates")
# What a study says by members of its own.
MEMBERS = ("control", "vary", "objective", "parameters")


class Options:
    """Reads what a study says to one command."""

    def __init__(self, context, verb):
        self.context, self.verb = context, verb
        self.arguments = context.program.arguments(verb)

    def words(self, key, value):
        """The words that give one value to an option; what is wrong with it is a problem."""
        context, wanted = self.context, key.replace("-", "_")
        choosable = {a["key"]: a for a in self.arguments
                     if a["is_option"] and a["key"] not in MEMBERS and a["key"] not in NOT_OF_STUDIES}
        if wanted not in choosable:
            if wanted in NOT_OF_STUDIES:
                context.problem(value, f"`{key}` is not for studies; each of `seeds` is a cell")
            else:
                hint = _native._did_you_mean(wanted, list(choosable))
                context.problem(value, f"`{self.verb}` has no option `{key}`{hint}")
            return []
        option = choosable[wanted]
        name = option["name"]
        if option["is_flag"]:
            if value.boolean():
                return [name]
            return ["--no-" + name[2:]] if option["has_no_form"] else []
        text = value.text()
        path = os.path.join(os.path.dirname(context.file), text)  # As elsewhere in the study.
        if option["is_path"]:
            context.check_place(value, path)
            return [name, context.word_of(path)]
        problem = context.program.problem(self.verb, [name, text])
        if problem:
            context.problem(value, problem)
        return [name, context.word_of(path) if option["is_text"] and os.path.exists(path) else text]

    def all_words(self, options):
        """The same of a whole object."""
        words = []
        for key, value in options.members():
            with self.context.attempt():
                words += self.words(key, value)
        return words

    def check_together(self, reader, words, output="made"):
        """What the command says of options beside each other. `output`: what it makes."""
        words = list(words)
        for option in self.arguments:
            for i in range(len(words) - 1):
                if option["is_path"] and words[i] == option["name"]:
                    words[i + 1] = "."  # A place that is there, seen from here.
        problem = self.context.program.problem(self.verb, words, output)
        if problem:
            self.context.problem(reader, problem)

    def factors(self, part):
        """Of the member `options` of a part, of which those with a list of values are varied, and of its `seeds`."""
        factors = []
        if part.has("options"):
            with self.context.attempt():
                factors += self._option_factors(part.member("options"))
        if part.has("seeds"):
            with self.context.attempt():
                factors.append(self._seeds(part.member("seeds")))
        return factors

    def _option_factors(self, options):
        factors = []
        num_before = len(self.context.problems)
        for key, value in options.members():
            with self.context.attempt():
                factors.append(self._factor_of(key, value))
        if len(self.context.problems) == num_before:
            self._check_levels(options, factors)
        return factors

    def _factor_of(self, key, value):
        if not value.is_array():
            return [Level("", {}, self.words(key, value))]
        factor = []
        for v in value.elements():
            with self.context.attempt():
                factor.append(Level(slug(key + v.text()), {key: v.text()}, self.words(key, v)))
        if not value.elements():
            self.context.problem(value, "expected at least one value")
        return factor

    def _seeds(self, seeds):
        factor = []
        for seed in seeds.elements():
            with self.context.attempt():
                text = str(seed.integer(0, 9e15))
                factor.append(Level("seed" + text, {"seed": text}, ["--seed", text]))
        if not seeds.elements():
            self.context.problem(seeds, "expected at least one")
        return factor

    def _check_levels(self, reader, factors):
        """The first of all values, and each other value beside the first of the others: what is wrong with more than
        that two together is left to the cell."""
        num_before = len(self.context.problems)
        first = [factor[0] for factor in factors if factor]
        self.check_together(reader, [word for level in first for word in level.words])
        if len(self.context.problems) > num_before:
            return  # It would be said again of each.
        for f, factor in enumerate(factors):
            for level in factor[1:]:
                beside = [*first[:f], level, *first[f + 1:]]
                self.check_together(reader, [word for one in beside for word in one.words])
