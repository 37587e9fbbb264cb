"""A page for each group of public headers: Doxygen reads them, Breathe shows what they declare, header by header."""
import subprocess
import xml.etree.ElementTree as ElementTree

COMPONENTS = {"libcommon": "Libraries", "capture": "Capture", "transfer": "Transfer", "simulation": "Simulation", "analysis": "Analysis", "datasets_synthetic": "Synthetic data"}
DOXYFILE = """PROJECT_NAME = patinate
OUTPUT_DIRECTORY = .
RECURSIVE = YES
INPUT = {roots}
STRIP_FROM_PATH = {roots}
INPUT_FILTER = "sed -E -f {filter}"
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
EXTRACT_ALL = YES
QUIET = YES
WARNINGS = NO
WARN_IF_DOC_ERROR = NO
WARN_IF_INCOMPLETE_DOC = NO
"""
DIRECTIVES = {"function": "doxygenfunction", "enum": "doxygenenum", "typedef": "doxygentypedef", "variable": "doxygenvariable"}


def plain(element):
    return "".join(element.itertext()).strip() if element is not None else ""


def directive(name, argument, *options):
    return f"```{{{name}}} {argument}\n" + "".join(f"{option}\n" for option in options) + "```\n\n"


def free_members(folder):
    """{header: [memberdef]}: what headers declare in namespaces, in the order of their lines."""
    found = {}
    for namespace in folder.glob("namespace*.xml"):
        for member in ElementTree.parse(namespace).getroot().iterfind("compounddef/sectiondef/memberdef"):
            place = member.find("location")
            found.setdefault(place.get("file"), []).append((int(place.get("line")), member))
    return {header: [m for _, m in sorted(members, key=lambda pair: pair[0])] for header, members in found.items()}


def declared(header_xml, members):
    """Directives for what a header declares. `describe()` of options and operators are no part of what a reader looks for."""
    compound = ElementTree.parse(header_xml).getroot().find("compounddef")
    text = plain(compound.find("briefdescription")) + "\n\n" + plain(compound.find("detaileddescription")) + "\n\n"
    for inner in compound.iterfind("innerclass"):
        name = inner.text
        if "detail" not in name.split("::") and "<" not in name and not is_nested(header_xml.parent, inner):
            text += directive("doxygenclass" if inner.get("refid").startswith("class") else "doxygenstruct", name, ":members:", ":undoc-members:")
    for member in members:
        kind, name = member.get("kind"), plain(member.find("qualifiedname")) or plain(member.find("name"))
        if kind in DIRECTIVES and "detail" not in name.split("::") and name.split("::")[-1] != "describe" and "operator" not in name:
            arguments = plain(member.find("argsstring")) if kind == "function" else ""
            text += directive(DIRECTIVES[kind], name + arguments)
    return text


def is_nested(folder, inner):
    """Whether a class stands inside another, which shows it."""
    outer = "::".join(inner.text.split("::")[:-1])
    return any((folder / f"{kind}{outer.replace('_', '__').replace('::', '_1_1')}.xml").exists() for kind in ("class", "struct"))


def make(root, folder):
    """({path: page}, {}); runs Doxygen in FOLDER."""
    roots = sorted({r for c in COMPONENTS for r in [root / c / "include", *root.glob(f"{c}/*/include")] if r.is_dir()})
    (folder / "Doxyfile").write_text(DOXYFILE.format(roots=" ".join(map(str, roots)), filter=root / "tools/docs/doxygen.sed"))
    subprocess.run(["doxygen", "-q", "Doxyfile"], cwd=folder, check=True)
    xml = {plain(c.find("name")): folder / "xml" / f"{c.get('refid')}.xml" for c in ElementTree.parse(folder / "xml/index.xml").getroot().iterfind("compound[@kind='file']")}
    members, pages, links = free_members(folder / "xml"), {}, []
    for component, title in COMPONENTS.items():
        headers = sorted(str(h.relative_to(r)) for r in roots if r.is_relative_to(root / component) for h in r.rglob("*.h"))
        groups = sorted({h.split("/")[1] for h in headers})
        for group in groups:
            name = f"{title}: {group}" if len(groups) > 1 else title
            parts = [f"## {h}\n\n`#include \"{h}\"`\n\n" + declared(xml[h.split("/")[-1]], members.get(h, [])) for h in headers if h.split("/")[1] == group]
            pages[f"cxx/{group}.md"] = f"# {name}\n\n" + "".join(parts)
            links.append(f"- [{name}]({group}.md)\n")
    about = "What programs may include; other headers change from commit to commit. [Examples](../examples/index.md) begin with one call."
    pages["cxx/index.md"] = f"# C++\n\n{about}\n\n" + "".join(links)
    return pages, {}
