"""Every combination of what a study varies, as its cells."""
import collections
import dataclasses
import itertools
import math

from patinate import _native

MOST_CELLS = 1_000_000
LONGEST_NAME = 120


@dataclasses.dataclass
class Level:
    """One level of what a study varies."""
    name: str                                    # Its part of a cell's name; "" = none.
    shown: dict                                  # For tables: factor -> text.
    words: list = dataclasses.field(default_factory=list)  # Of the command.
    file: str = ""                               # An input.
    values: dict = dataclasses.field(default_factory=dict)  # Numbers of a scene: JSON pointer -> value.


@dataclasses.dataclass
class Step:
    """A command of every cell of a part: the one that makes its subject, or one that looks at that."""
    name: str              # Unique in the study, of letters, digits, `_`: "transfer", "transfer_strip".
    verb: str
    file: str              # What it makes, in the cell's folder.
    in_items: bool = False  # Snakemake runs its plan's items, each as a job: a fit.


@dataclasses.dataclass
class Cell:
    """One combination of what a study varies."""
    name: str      # Unique, a file name.
    factors: dict
    words: list = dataclasses.field(default_factory=list)  # Of each step, behind the verb, without -o; paths relative to the study's folder.
    scene: str = ""  # Where it has `values`, it is written to the cell's folder before the first step.
    values: dict = dataclasses.field(default_factory=dict)
    commands: list = dataclasses.field(default_factory=list)  # Of each step, as a shell takes it, to be given in the study's folder.


@dataclasses.dataclass
class Part:
    """All cells that share their steps: transfers, simulations or fits."""
    name: str
    steps: list
    cells: list = dataclasses.field(default_factory=list)


def twins_in(factor):
    """Levels that would give the same cells, a line each."""
    named = collections.defaultdict(list)
    for level in factor:
        if level.name:
            named[level.name].append(level)
    for name, levels in sorted(named.items()):
        if len(levels) < 2:
            continue
        first, second = levels[:2]
        if not first.file or first.words[0] == second.words[0]:
            yield (first.file or f"`{name}`") + " is there twice: say it once, or give one another `name`"
        else:
            yield f"{first.file} and {second.file} would both be `{name}` in the names of cells: give one a `name`"


def make_cell(levels, step_words, part):
    cell = Cell("-".join(level.name for level in levels if level.name)[:LONGEST_NAME], {})
    made = []
    for level in levels:
        cell.factors.update(level.shown)
        made += level.words
        cell.values.update(level.values)
    if cell.values:
        cell.scene = levels[0].file
        made[0] = f"cells/{cell.name}/scene.json"
    cell.words = [made] + [[f"cells/{cell.name}/{part.steps[0].file}", *words] for words in step_words]
    return cell


def make_cells(factors, step_words, part):
    """Adds every combination of levels to `part`; the first factor holds the inputs. `step_words`: of every step but the
    first, what stands behind its subject. Gives what is wrong, a line each."""
    problems = [problem for factor in factors for problem in twins_in(factor)]
    count = math.prod(len(factor) for factor in factors)
    if count > MOST_CELLS:
        return problems + [f"makes {_native._number_text(float(count))} cells; at most {MOST_CELLS}"]
    is_told = bool(problems)  # Once each, not once a cell.
    uses = collections.Counter()
    for levels in itertools.product(*factors):
        cell = make_cell(levels, step_words, part)
        uses[cell.name] += 1
        if uses[cell.name] == 2 and not is_told:
            problems.append(f"two cells would be made in `cells/{cell.name}`: say it once, or give them a `name`")
        part.cells.append(cell)
    return problems
