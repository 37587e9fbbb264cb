"""What a function finds as one object: a dict whose entries are attributes, and whose figures are a table."""


class Report(dict):
    """Results by name, as a dict and as attributes: report["figures"] is report.figures. Its figures are a table."""

    def __init__(self, entries=()):
        super().__init__()
        for name, value in dict(entries).items():
            self[name] = Report(value) if isinstance(value, dict) else value

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no {name}; there are {', '.join(map(str, self))}") from None

    def __dir__(self):
        return [*super().__dir__(), *(name for name in self if isinstance(name, str) and name.isidentifier())]

    def rows(self):
        """Makes a table of the figures: one dict a figure (and time), with its part of the report, its name and its values.

        A curve, whose entries all hold equally many numbers, gives one dict a number."""
        rows = list(_rows(self, ()))
        names = list(dict.fromkeys(name for row in rows for name in row))
        return [{name: row.get(name) for name in names} for row in rows]

    def to_dataframe(self):
        """Makes a pandas.DataFrame of rows(). Raises ImportError where pandas is not installed."""
        import pandas
        return pandas.DataFrame(self.rows())

    def __repr__(self):
        return "Report(" + ", ".join(f"{name}={_short(value)}" for name, value in self.items()) + ")"

    def _repr_html_(self):
        from html import escape
        rows = self.rows()
        if not rows:
            return f"<pre>{escape(repr(dict(self)))}</pre>"

        def cells(values, tag):
            return "<tr>" + "".join(f"<{tag}>{escape(_text(value))}</{tag}>" for value in values) + "</tr>"
        return "<table>" + cells(rows[0], "th") + "".join(cells(row.values(), "td") for row in rows) + "</table>"


def _text(value):
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _short(value):
    shape = getattr(value, "shape", ())
    return f"<{' x '.join(map(str, shape))}>" if shape else repr(value)


def _is_plain(value):
    return value is None or isinstance(value, (str, bool, int, float))


def _columns(report):
    """The columns of a curve: its x and its columns, or else all entries, if they are lists of equal length. Otherwise {}."""
    entries = dict(report.get("columns", report))
    if "columns" in report and "x" in report:
        entries = {report.get("x_name") or "x": report["x"], **entries}
    if not all(_is_list(values) for values in entries.values()) or len({len(values) for values in entries.values()}) != 1:
        return {}
    return {name: list(values) for name, values in entries.items()}


def _is_list(values):
    return isinstance(values, (list, tuple)) or getattr(values, "ndim", 0) == 1


def _at_times(report, part):
    """Figures whose values have a row a time, and grades beside them (grade())."""
    times = list(report["times"])
    for name, values in report["figures"].items():
        for time, (value, low, high) in zip(times, values):
            yield {**part, "time": float(time), "name": name, "value": float(value), "low": float(low), "high": float(high)}
    for scale, grades in report.get("grades", {}).items():
        for time, grade in zip(times, grades):
            yield {**part, "time": float(time), "name": scale, "grade": grade}


def _rows(report, path):
    part = {"part": "/".join(path)} if path else {}
    columns = _columns(report)
    if columns:
        for values in zip(*columns.values()):
            yield {**part, **{name: _plain(value) for name, value in zip(columns, values)}}
        return
    if "times" in report and "figures" in report:
        yield from _at_times(report, part)
        return
    own = {name: value for name, value in report.items() if _is_plain(value)}
    if len(own) > 1 and path and "figures" not in report:
        yield {**({"part": "/".join(path[:-1])} if len(path) > 1 else {}), "name": path[-1], **own}
    for name, value in report.items():
        if isinstance(value, Report) and name != "curves":
            yield from _rows(value, path if name == "figures" else (*path, str(name)))


def _plain(value):
    return value.item() if hasattr(value, "item") else value
