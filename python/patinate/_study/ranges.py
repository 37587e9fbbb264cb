"""The numbers of scenes that a study varies."""
import os

from patinate import InputError, _native

from .cells import Level

DESIGNS = ("grid", "latin_hypercube", "list")


class _Range:
    """A number of a scene: from a range, or of a list."""

    def __init__(self, reader):
        self.place = f"{reader.file}: {reader.pointer}"
        self.values, self.count = [], 0
        if not reader.has("values"):
            if reader.has("count"):
                self.count = reader.member("count").integer(1, 1e5)
            self.range = _native._read_fit_range(reader)
            return
        name = reader.member("pointer").string()
        values = reader.member("values")
        self.values = [value.number() for value in values.elements()]
        if not self.values:
            values.fail("at least one value")
        reader.finish()
        self.range = {"name": name, "low": min(self.values), "high": max(self.values), "place": self.place}

    @property
    def name(self):
        return self.range["name"]

    def level(self, name, value):
        return Level(name, {self.name: _native._number_text(value)}, values={self.name: value})


def _numbers_in(context, scene, ranges):
    """What a scene says of the numbers; None if it lacks one, all of which are then said."""
    try:
        return _native._scene_numbers(scene, ranges)
    except InputError as error:
        told = []
        for one in ranges:  # The scene's reader ends at the first.
            try:
                _native._scene_numbers(scene, [one])
            except InputError as own:
                told.append(str(own))
        context.problems += [line for line in dict.fromkeys(told or [str(error)]) if line not in context.problems]
        return None


def _numbers_of(context, scenes, ranges):
    """What scenes say of the numbers, with whether a number is whole in any of them; None if one lacks a number."""
    read = [_numbers_in(context, scene, ranges) for scene in scenes if os.path.exists(scene)]
    if not read or None in read:
        return None
    for other in read[1:]:
        for number, its in zip(read[0], other):
            number["is_whole"] |= its["is_whole"]
    return read[0]


def _check_design(context, part, design, ranges, count):
    """What the design lacks is said."""
    if design == "grid":
        context.problems += [f"{varied.place}: a grid needs a `count`, or `values`"
                             for varied in ranges if not varied.values and varied.count == 0]
    elif design == "latin_hypercube" and count == 0:
        context.problem(part, "a Latin hypercube needs `samples`")
    elif design == "list" and (not ranges or len({len(varied.values) for varied in ranges}) != 1
                               or not ranges[0].values):
        context.problem(part.member("vary"), "a list needs `values` everywhere, equally many")


def _grid(ranges, numbers):
    factors = []
    for varied, number in zip(ranges, numbers):
        values = varied.values
        if not values:
            shares = [k / (varied.count - 1) for k in range(varied.count)] if varied.count > 1 else [0.5]
            values = [_native._value_at(varied.range, number["is_whole"], share) for share in shares]
            values = [v for k, v in enumerate(values) if k == 0 or v != values[k - 1]]  # Whole numbers may be fewer.
        token = varied.name.rsplit("/", 1)[-1]  # "/rules/0/rate" is "rate".
        factors.append([varied.level(token + _native._number_text(value), value) for value in values])
    return factors


def _samples(ranges, points):
    """A factor of points, each a value of every number."""
    factor = []
    for k, point in enumerate(points):
        level = Level(f"sample{k:04}", {})
        for varied, value in zip(ranges, point):
            one = varied.level("", value)
            level.shown.update(one.shown)
            level.values.update(one.values)
        factor.append(level)
    return factor


def _hypercube(ranges, numbers, count, seed):
    def value(varied, number, share):
        if varied.values:
            return varied.values[int(share * len(varied.values))]
        return _native._value_at(varied.range, number["is_whole"], share)
    return _samples(ranges, [[value(*of, share) for *of, share in zip(ranges, numbers, point)]
                             for point in _native._latin_hypercube(count, len(ranges), seed)])


def varied_factors(context, part, scenes):
    """The factors that `vary` of a part adds: one a number for a grid, else one in all. Every number is looked for in
    each scene, and both ends of its range are tried."""
    num_before = len(context.problems)
    design, count, seed, ranges = "grid", 0, 1, []
    with context.attempt():
        design = part.member("design").choice(DESIGNS) if part.has("design") else design
    with context.attempt():
        count = part.member("samples").integer(1, 1e5) if part.has("samples") else count
    with context.attempt():
        seed = part.member("design_seed").integer(0, 9e15) if part.has("design_seed") else seed
    if not part.has("vary"):
        return []
    for reader in part.member("vary").elements():
        with context.attempt():
            ranges.append(_Range(reader))
    if len(context.problems) == num_before:
        _check_design(context, part, design, ranges, count)
    numbers = _numbers_of(context, scenes, [varied.range for varied in ranges])
    if numbers is None or len(context.problems) > num_before:
        return []
    if design == "grid":
        return _grid(ranges, numbers)
    if design == "latin_hypercube":
        return [_hypercube(ranges, numbers, count, seed)]
    return [_samples(ranges, zip(*(varied.values for varied in ranges)))]


def _objective_words(context, objective):
    words = []
    for name, weight in objective.members():
        with context.attempt():
            value = _native._number_text(weight.positive())
            try:
                _native._check_fit_term(name)
                words += ["--objective", f"{name}={value}"]
            except InputError as error:
                context.problem(weight, str(error))
    return words


def fit_words(context, part, scenes):
    """The words of a part `fit`, and of each number whether it only changes the look."""
    vary = part.member("vary")
    ranges, words, kinds = [], [], []
    for reader in vary.elements():
        with context.attempt():
            ranges.append(_native._read_fit_range(reader))
            if ranges[-1]["is_own"]:
                reader.fail("a range without `own`; fits of a study have one history each")
    if not vary.elements():
        vary.fail("at least one range")
    for one in ranges:
        ends = ":".join(_native._number_text(one[end]) for end in ("low", "high"))
        words += ["--vary", f"{one['name']}={ends}{':log' if one['scale'] == 'log' else ''}"]
    if part.has("objective"):
        with context.attempt():
            words += _objective_words(context, part.member("objective"))
    for scene in filter(os.path.exists, scenes):
        numbers = _numbers_in(context, scene, ranges) or []
        kinds = kinds or [number["is_appearance"] for number in numbers]  # The same in all: they go by the pointers.
        for number in numbers:
            if number["problem"]:
                context.problem(vary, f"{scene}: {number['problem']}")
    return words, kinds
