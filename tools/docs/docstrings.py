"""The module's docstrings, which are plain text, as reStructuredText: `name: type` above an indented line becomes a definition."""
import inspect
import re


def escaped(text):
    """Plain text; `code` stays code."""
    parts = re.split(r"`([^`]+)`", text)
    return "".join(f"``{p}``" if i % 2 else re.sub(r"([\\*|`]|_(?=\W|$))", r"\\\1", p) for i, p in enumerate(parts))


def paragraphs(text):
    """Blocks of lines between empty ones."""
    return re.split(r"\n\s*\n", text.strip("\n"))


def block(text):
    if text.startswith("    "):
        return "::\n\n" + text
    lines, out = text.splitlines(), []
    for i, line in enumerate(lines):
        if line.startswith("    "):
            out.append("    " + escaped(line.strip()))
        elif i + 1 < len(lines) and lines[i + 1].startswith("    "):
            out += ["", f"``{line}``"]
        else:
            out += [""] * (i > 0 and lines[i - 1].startswith("    ")) + [escaped(line)]
    return "\n".join(out)


def as_restructured_text(_app, _what, _name, _object, _options, lines):
    lines[:] = "\n\n".join(map(block, paragraphs("\n".join(lines)))).splitlines() + [""]


MOST_BY_NAME = 6


def names_of(parameters):
    """What is given in order, then after * what is given by name, as dots where that is much."""
    in_order = [p.name for p in parameters if p.kind is not p.KEYWORD_ONLY and p.name != "self"]
    by_name = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    return in_order + (["*"] + (by_name if len(by_name) <= MOST_BY_NAME else ["..."]) if by_name else [])


def signature(_app, what, _name, thing, _options, text, _returned):
    """The names of the arguments; what they are stands below."""
    if what not in ("function", "method", "class"):
        return None
    try:
        names = names_of(inspect.signature(thing).parameters.values())
    except (TypeError, ValueError):
        return None if text else ("", "")
    return "(" + ", ".join(names) + ")", ""
