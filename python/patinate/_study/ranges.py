"""The numbers of scenes that a study varies."""
from patinate import IoError, _native

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


def numbers_of(scenes, ranges):
    """What scenes say of the numbers, with whether a number is whole in any of them."""
    numbers = None
    for scene in scenes:
        read = _native._scene_numbers(scene, ranges)
        numbers = numbers or read
        for number, other in zip(numbers, read):
            number["is_whole"] |= other["is_whole"]
    return numbers or []


def _grid(ranges, numbers):
    factors = []
    for varied, number in zip(ranges, numbers):
        values = varied.values
        if not values:
            if varied.count == 0:
                raise IoError(f"{varied.place}: a grid needs a `count`, or `values`")
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
    design = part.member("design").choice(DESIGNS) if part.has("design") else "grid"
    count = part.member("samples").integer(1, 1e5) if part.has("samples") else 0
    seed = part.member("design_seed").integer(0, 9e15) if part.has("design_seed") else 1
    if not part.has("vary"):
        return []
    ranges = []
    for reader in part.member("vary").elements():
        with context.attempt():
            ranges.append(_Range(reader))
    if context.problems:
        return []  # A scene that is not there has no numbers.
    if design == "latin_hypercube" and count == 0:
        raise IoError(f"{part.file}: {part.pointer}: a Latin hypercube needs `samples`")
    numbers = numbers_of(scenes, [varied.range for varied in ranges])
    if design == "grid":
        return _grid(ranges, numbers)
    if design == "latin_hypercube":
        return [_hypercube(ranges, numbers, count, seed)]
    if not ranges or len({len(varied.values) for varied in ranges}) != 1 or not ranges[0].values:
        raise IoError(f"{part.file}: {part.pointer}/vary: a list needs `values` everywhere, equally many")
    return [_samples(ranges, zip(*(varied.values for varied in ranges)))]


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
        for name, weight in part.member("objective").members():
            try:
                _native._check_fit_term(name)
                words += ["--objective", f"{name}={_native._number_text(weight.positive())}"]
            except _native.InputError as error:
                context.problem(weight, str(error))
    if context.problems:
        return words, kinds  # A scene that is not there has no numbers.
    for scene in scenes:
        with context.attempt():
            numbers = _native._scene_numbers(scene, ranges)
            kinds = [number["is_appearance"] for number in numbers]  # The same in all: they go by the pointers.
            for number in numbers:
                if number["problem"]:
                    context.problem(vary, f"{scene}: {number['problem']}")
    return words, kinds
