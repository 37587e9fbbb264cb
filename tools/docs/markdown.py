"""The parts of Markdown that the manual's pages are put together by: headings, links outside code, lists of links."""
import re

# Fenced and indented blocks, and code within a line: nothing in them is a link.
CODE = re.compile(r"^```.*?^```[ \t]*$|(?<=\n\n)(?:(?: {4}|\t)[^\n]*\n)+|`[^`\n]+`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^()\s]+)\)")
ITEM = re.compile(r"^- \[[^\]]+\]\(([^()\s#]+)(#[^()\s]+)?\)", re.MULTILINE)


def title(text):
    return re.search(r"^# (.+)$", text, re.MULTILINE).group(1)


def is_elsewhere(target):
    return "://" in target or target.startswith(("#", "mailto:"))


def with_links(text, replaced):
    """Every link to a file passes through replaced(path, anchor), which gives the new target."""
    def one(match):
        target = match.group(1)
        if is_elsewhere(target):
            return match.group(0)
        path, hash_sign, anchor = target.partition("#")
        return f"]({replaced(path, hash_sign + anchor)})"

    parts, end = [], 0
    for code in CODE.finditer(text):
        parts += [LINK.sub(one, text[end:code.start()]), code.group(0)]
        end = code.end()
    return "".join(parts) + LINK.sub(one, text[end:])


def lists_of_links(text):
    """[(heading, [path])]: what list items begin with, below which heading."""
    found = []
    for part in re.split(r"^(?=## )", CODE.sub("", text), flags=re.MULTILINE):
        heading = part[3:].splitlines()[0] if part.startswith("## ") else ""
        paths = [m.group(1) for m in ITEM.finditer(part) if not is_elsewhere(m.group(1)) and not m.group(2)]
        if paths:
            found.append((heading, list(dict.fromkeys(paths))))
    return found


def cell(text):
    """Text as it may stand in a cell of a table."""
    return re.sub(r"\s+", " ", str(text)).replace("|", "\\|").replace("<", "&lt;")
