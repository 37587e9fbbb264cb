"""The JSON Schemas as pages: a table for each object, with what its members are."""
import json
import re

from markdown import cell


def reference(node):
    return node["$ref"].rsplit("/", 1)[-1] if "$ref" in node else None


def bounds(node):
    """'[0, 1]', '> 0' ... or nothing."""
    low, high = node.get("minimum", node.get("exclusiveMinimum")), node.get("maximum", node.get("exclusiveMaximum"))
    if low is not None and high is not None:
        return f"{'(' if 'exclusiveMinimum' in node else '['}{low:g}, {high:g}{')' if 'exclusiveMaximum' in node else ']'}"
    if low is not None:
        return f"{'>' if 'exclusiveMinimum' in node else '>='} {low:g}"
    return f"{'<' if 'exclusiveMaximum' in node else '<='} {high:g}" if high is not None else ""


def kind(node, definitions):
    """What a value may be, in a few words."""
    if not isinstance(node, dict):
        return "anything" if node else "nothing"
    name = reference(node)
    if name:
        target = definitions.get(name, {})
        return f"[{name}](#{anchor(name)})" if is_object(target) else kind(target, definitions)
    if "const" in node:
        return f"`{json.dumps(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{json.dumps(v)}`" for v in node["enum"])
    for word in ("oneOf", "anyOf"):
        if word in node and not node.get("properties"):
            return " or ".join(dict.fromkeys(kind(n, definitions) for n in node[word]))
    types = node.get("type", "object" if "properties" in node else "anything")
    types = types if isinstance(types, list) else [types]
    words = []
    for one in types:
        if one == "array" and node.get("prefixItems"):
            words.append("[" + ", ".join(kind(n, definitions) for n in node["prefixItems"]) + "]")
        elif one == "array" and isinstance(node.get("items"), dict):
            few = f"{node['minItems']} " if node.get("minItems") == node.get("maxItems") and "minItems" in node else ""
            items = re.sub(r"^(number|integer|string|object|boolean|list)\b", r"\1s", kind(node["items"], definitions))
            words.append(f"list of {few}{items}")
        elif one == "object" and isinstance(node.get("additionalProperties"), dict):
            words.append(f"by name: {kind(node['additionalProperties'], definitions)}")
        else:
            words.append(one)
    limits = bounds(node)
    return " or ".join(words) + (f" {limits}" if limits else "")


def is_object(node):
    return isinstance(node, dict) and bool(node.get("properties") or any(is_object(n) for n in node.get("oneOf", []) + node.get("anyOf", [])))


def anchor(name):
    return re.sub(r"[^\w -]", "", name.lower()).replace(" ", "-")


def table(node, definitions, prefix=""):
    """Rows of an object's members; members of objects in it follow with their path."""
    rows, required = [], set(node.get("required", []))
    for name, member in node.get("properties", {}).items():
        member = member if isinstance(member, dict) else {}
        text = member.get("description", "")
        if "default" in member:
            text += f" Default: `{json.dumps(member['default'])}`."
        path = f"{prefix}{name}"
        rows.append(f"| `{path}`{' *' if name in required else ''} | {cell(kind(member, definitions))} | {cell(text)} |")
        for inner, mark in ((member, "."), (member.get("items"), "[]."), (member.get("additionalProperties"), ".NAME.")):
            if isinstance(inner, dict) and "$ref" not in inner and prefix.count(".") < 3:
                rows += table(inner, definitions, path + mark)
    for word in ("oneOf", "anyOf", "allOf"):
        for part in node.get(word, []):
            if isinstance(part, dict) and "$ref" not in part and any("description" in m or "type" in m or "$ref" in m for m in part.get("properties", {}).values() if isinstance(m, dict)):
                rows += table(part, definitions, prefix)
    return list(dict.fromkeys(rows))


def section(rows):
    return "| member | value | meaning |\n| --- | --- | --- |\n" + "\n".join(rows) + "\n" if rows else ""


def page(schema, name):
    definitions = schema.get("$defs", {})
    parts = [f"# {name}\n", schema.get("description", schema.get("title", "")).replace("<", "&lt;") + "\n", "`*`: must be there.\n", section(table(schema, definitions))]
    for key, node in sorted(definitions.items()):
        if is_object(node):
            parts += [f"## {key}\n", cell(node.get("description", "")) + "\n", section(table(node, definitions))]
    return "\n".join(parts)


def make(folder):
    """{file name: page}, of every schema in the folder, and index.md."""
    pages, links = {}, []
    for path in sorted(folder.glob("*.schema.json")):
        name = path.name.removesuffix(".schema.json")
        schema = json.loads(path.read_text())
        pages[f"{name}.md"] = page(schema, schema.get("title", name))
        links.append(f"- [{schema.get('title', name)}]({name}.md)\n")
    about = "Every JSON file that patinate reads or writes, made of the JSON Schemas (draft 2020-12) in docs/schema, which editors and checks can use as they are."
    pages["index.md"] = f"# File formats\n\n{about}\n\n" + "".join(links)
    return pages
