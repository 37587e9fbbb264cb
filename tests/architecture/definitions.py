"""Definitions with external linkage in C++ text, found without a compiler: enough of a parser for the way this house writes."""
import functools
import re

# Comments, literals and preprocessor lines hide braces; attributes and alignas stand before names.
_HIDDEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^\s()\\]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE)
_TOKEN = re.compile(r"[A-Za-z_]\w*|::|->|\.\.\.|[^\s\w]|\d[\w.']*")
_TYPE_WORDS = {"struct", "class", "union", "enum"}
_NO_FUNCTION = {"if", "for", "while", "switch", "catch", "return", "alignas", "decltype", "noexcept", "requires", "throw", "defined", "static_assert", "sizeof"}


def _skip(tokens, i, opening, closing):
    """The index behind what closes the bracket at i."""
    depth = 0
    while i < len(tokens):
        depth += (tokens[i] == opening) - (tokens[i] == closing)
        i += 1
        if depth == 0:
            return i
    return i


def _without_template(head):
    while head[:1] == ["template"]:
        head = head[_skip(head, 1, "<", ">"):] if head[1:2] == ["<"] else head[1:]
    return head


def _without_attributes(head):
    out, i = [], 0
    while i < len(head):
        if head[i:i + 2] == ["[", "["]:
            i = _skip(head, i, "[", "]")
        elif head[i] == "alignas":
            i = _skip(head, i + 1, "(", ")")
        else:
            out.append(head[i])
            i += 1
    return out


def _type_name(head):
    """The name in `struct A final : B`, `enum class A : int`; None when this is no type's definition."""
    i = 0
    while i < len(head) and head[i] in {"inline", "static", "constexpr", "const", "typedef", "extern"}:
        i += 1
    if i == len(head) or head[i] not in _TYPE_WORDS:
        return None
    while i < len(head) and head[i] in _TYPE_WORDS:
        i += 1
    name, depth = [], 0
    for token in head[i:]:
        depth += (token == "<") - (token == ">")
        if depth == 0 and token in {":", "final", "(", "="}:
            return None if token in {"(", "="} else "".join(name)
        name.append(token)
    return "".join(name)


def _function_name(head):
    """`name(types)` of a function's head, its parameters' names omitted; None when this is no function."""
    if "(" not in head or ("=" in head[:head.index("(")] and "operator" not in head):
        return None
    opening = head.index("(")
    name = []
    i = opening - 1
    if "operator" in head[:opening + 1]:
        i = head.index("operator")
        if head[i + 1:i + 3] == ["(", ")"]:
            opening = i + 3
        name = head[i:opening]
        i -= 1
    elif i < 1 and not (i == 0 and head[0] == head[0].upper()):  # TEST(...) has no type before its name
        return None
    else:
        name = [head[i]]
        i -= 1
        if not re.match(r"[A-Za-z_]", name[0]) or name[0] in _NO_FUNCTION:
            return None
    while i >= 1 and head[i] == "::":
        j = i - 1
        if head[j] == ">":
            depth = 0
            while j >= 0:
                depth += (head[j] == ">") - (head[j] == "<")
                j -= 1
                if depth == 0:
                    break
        name = head[j:i + 1] + name
        i = j - 1
    end = _skip(head, opening, "(", ")")
    parameters, depth, part = [], 0, []
    for token in head[opening + 1:end - 1] + [","]:
        depth += (token in "<({[") - (token in ">)}]")
        if token == "," and depth == 0:
            parameters.append(_parameter_type(part))
            part = []
        else:
            part.append(token)
    return "".join(name) + "(" + ", ".join(p for p in parameters if p) + ")" + ("const" if head[end:end + 1] == ["const"] else "")


def _parameter_type(tokens):
    if "=" in tokens:
        tokens = tokens[:tokens.index("=")]
    if len(tokens) > 1 and re.match(r"[A-Za-z_]", tokens[-1]) and tokens[-2] != "::" and (len(tokens) > 2 or tokens[0] != "const"):
        tokens = tokens[:-1]
    return re.sub(r"\bfs ::", "std :: filesystem ::", " ".join(tokens))


def _opens_an_initializer(head):
    """Whether a brace behind this begins a value: inside parentheses (a default argument), or of a member that a constructor sets."""
    if head.count("(") > head.count(")"):
        return True
    plain = _without_template(head)
    if "(" not in plain or not re.match(r"[A-Za-z_>]", head[-1]):
        return False
    rest = plain[_skip(plain, plain.index("("), "(", ")"):]
    return ":" in rest and head[-1] not in {"const", "noexcept", "override", "final"}


def _inline_variable(head):
    """The name in `inline constexpr int kName = 3`; None for anything else."""
    if "inline" not in head or "using" in head or "namespace" in head:
        return None
    ends = [i for i, token in enumerate(head) if token in {"=", "["}] + [len(head)]
    declared = head[:ends[0]]
    return declared[-1] if len(declared) > 2 and "(" not in declared and re.match(r"[A-Za-z_]\w*$", declared[-1]) else None


def _local_names(head):
    """The names that a declaration at namespace scope brings: of a type, a function, an alias, or of variables."""
    name = _local_name(head)
    if name:
        yield name
    plain = _without_attributes(_without_template(head))
    if not name or _type_name(plain) is not None or _function_name(plain) or plain[0] == "using":
        return
    depth = 0
    for before, token, after in zip(plain, plain[1:], plain[2:] + [";"]):
        depth += (before in "<([") - (before in ">)]")
        if depth == 0 and before == "," and after in {"=", ",", ";", "["}:
            yield token


def _local_name(head):
    """The first of them; None when there is none."""
    plain = _without_attributes(_without_template(_without_attributes(head)))
    if not plain or plain[0] in {"friend", "static_assert"} or plain[:2] == ["using", "namespace"]:
        return None
    if plain[0] == "using":
        return plain[1] if plain[2:3] == ["="] else None
    if plain[0] == "namespace":
        return None
    if _type_name(plain) is not None:
        return _type_name(plain).split("<")[0]
    function = _function_name(plain)
    if function:
        name = function.split("(")[0]
        return None if "::" in name or name.startswith("operator") or re.match(r"[A-Z][A-Z0-9_]+$", name) else name  # TEST(...)
    declared = plain[:min([i for i, token in enumerate(plain) if token in {"=", "[", "(", "{"}] + [len(plain)])]
    return declared[-1] if len(declared) > 1 and re.match(r"[A-Za-z_]\w*$", declared[-1]) else None


def local_definitions(text):
    """{name: line of its first} of all that this file alone knows: what stands in its unnamed namespaces, `static` functions and variables, constants."""
    return {name: line for kind, name, line in reversed(_definitions(text)) if kind == "local"}


def external_definitions(text):
    """Yields (kind, qualified name, line) of all that has a body here and that another file could define, too: types, functions, inline variables.

    What stands in unnamed namespaces or in functions, and `static` functions, no other file can meet.
    """
    return (found for found in _definitions(text) if found[0] != "local")


@functools.lru_cache(maxsize=None)
def _definitions(text):
    return list(_found_definitions(text))


def _found_definitions(text):
    code = _HIDDEN.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)
    tokens = [(m.group(), m.start()) for m in _TOKEN.finditer(code)]
    words = [token for token, _ in tokens]
    scopes = []  # A name; "" where a scope gives none; None where nothing is external any more.
    rooms = []  # For each of them "named", "unnamed" (namespaces) or "body" (of a type, function or value).
    head = []
    i = 0
    while i < len(tokens):
        token, at = tokens[i]
        i += 1
        if token not in "{};:":
            head.append(token)
            continue
        prefix = "".join(s + "::" for s in scopes if s)
        is_external = None not in scopes
        plain = _without_attributes(_without_template(_without_attributes(head))) if is_external and token in "{;" else head
        is_value = head and _type_name(plain) is None and (_opens_an_initializer(plain) or _inline_variable(plain))
        if token in "{;" and head and "body" not in rooms and not (token == "{" and is_value):
            words_before = head[:head.index("(")] if "(" in head else head
            is_local = "unnamed" in rooms or "static" in words_before or ("inline" not in words_before and {"const", "constexpr"} & set(words_before) and "(" not in words_before[-1:] and _function_name(_without_template(head)) is None and "=" in head)
            for name in _local_names(head) if is_local else ():
                yield "local", name, code.count("\n", 0, at) + 1
        if token in {";", "}"} or (token == ":" and head[-1:] in (["public"], ["private"], ["protected"])):
            if token == ";" and is_external and _inline_variable(plain):
                yield "variable", prefix + _inline_variable(plain), code.count("\n", 0, at) + 1
            if token == "}" and scopes:
                scopes.pop()
                rooms.pop()
            head = []
        elif token != "{":
            head.append(token)
        elif is_value:
            i = _skip(words, i - 1, "{", "}")
            head += ["=", "0"]
        else:
            kind, name, scope = None, None, None
            if "namespace" in plain[:2]:
                scope = "".join(plain[plain.index("namespace") + 1:]) or None
            elif plain[:1] == ["extern"] and len(plain) == 1:  # extern "C", the string blanked
                scope = ""
            elif _type_name(plain) is not None:
                kind, name = "type", _type_name(plain)
                scope = name if "enum" not in plain else None
            elif plain:
                kind, name = "function", _function_name(plain)
                if name and "static" in plain[:plain.index("(")]:  # of a class: met with the class
                    name = None
            if is_external and name:
                yield kind, prefix + name, code.count("\n", 0, at) + 1
            scopes.append(scope)
            rooms.append(("named" if scope is not None else "unnamed") if "namespace" in plain[:2] or kind is None and scope == "" else "body")
            head = []
