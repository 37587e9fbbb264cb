#!/usr/bin/env python3
"""Include rules of the house, checked over every source file. Usage: include_test.py REPOSITORY

tools, python -> app -> capture | transfer | simulation | analysis | datasets_synthetic -> libcommon -> libraries; the five in the middle
never include each other, and neither do folders. Neither of tools and python takes anything of the other. Public headers (below include/) include no internal ones. Headers of ours name no heavy
third-party header, so that whoever includes them does not pay for it.
"""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
MIDDLE = {"capture", "transfer", "simulation", "analysis", "datasets_synthetic"}
TOP = {"app", "tools", "python"}
MAY_INCLUDE = {"libcommon": {"libcommon"}, **{top: MIDDLE | {"libcommon", "app", top} for top in TOP}}
MAY_INCLUDE.update({m: {m, "libcommon"} for m in MIDDLE})
HEAVY = re.compile(r"(boost|opencv2|embree3|OpenMesh|OpenImageIO|OpenEXR|libav\w+|libswscale|pcl|flann|ceres|CLI)/|tiny_gltf|tiny_obj_loader|xxhash|nlohmann/json\.hpp")
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^">]+)[">]', re.MULTILINE)


# As compilers are told to look: the repository's root, and the public headers of every component.
INCLUDE_ROOTS = [ROOT, *(ROOT / component / "include" for component in sorted(MIDDLE | {"libcommon"}))]


def sources(folder, *suffixes):
    return [p for p in sorted((ROOT / folder).rglob("*")) if p.suffix in suffixes and "node_modules" not in p.parts]


def included(path):
    """(as written, file) of what a source of ours includes and we have written."""
    for name in INCLUDE.findall(path.read_text()):
        for root in INCLUDE_ROOTS:
            if "/" in name and (root / name).is_file():
                yield name, root / name


def component_of(path):
    return path.relative_to(ROOT).parts[0]


def is_public(path):
    return path.relative_to(ROOT).parts[1] == "include"


def rooms():
    """The folder of every source; a public header's is that of its .cpp, or, where it has none, what all public headers of its component make."""
    room = {}
    for component in MAY_INCLUDE:
        by_stem = {p.stem: p.parent for p in sources(component, ".cpp")}
        for path in sources(component, ".h", ".cpp", ".inc", ".inl"):
            folder = path.parent
            if component not in TOP and is_public(path):
                below = path.relative_to(ROOT / component / "include" / "patinate").parts
                folder = ROOT / component / below[0] if component == "libcommon" else by_stem.get(path.stem, path.parent)
            room[path] = str(folder.relative_to(ROOT))
    return room


def component_rooms():
    """The same, but public headers of a component lie in its own folder, as one finds them: what else lies there may not include what includes them."""
    room = {path: str(path.parent.relative_to(ROOT)) for path in rooms()}
    for path in room:
        if component_of(path) in MIDDLE and is_public(path):
            room[path] = component_of(path)
    return room


def edges_of(room):
    """Folder -> folders that its files include."""
    edges = {}
    for path, folder in room.items():
        for _, target in included(path):
            if target in room and room[target] != folder:
                edges.setdefault(folder, set()).add(room[target])
    return edges


def cycle_in(edges):
    """A list of nodes that leads back to its first one; [] when there is none."""
    state, path = {}, []

    def visit(node):
        state[node] = "open"
        path.append(node)
        for other in sorted(edges.get(node, ())):
            if state.get(other) == "open":
                return path[path.index(other):] + [other]
            if other not in state and (found := visit(other)):
                return found
        state[node] = "done"
        path.pop()
        return []

    for node in sorted(edges):
        if node not in state and (found := visit(node)):
            return found
    return []


class Includes(unittest.TestCase):
    def test_components_include_only_downwards(self):
        num_includes = 0
        for component, allowed in MAY_INCLUDE.items():
            for path in sources(component, ".h", ".cpp"):
                for name, target in included(path):
                    num_includes += 1
                    with self.subTest(file=str(path.relative_to(ROOT)), includes=name):
                        self.assertIn(component_of(target), allowed)
        self.assertGreater(num_includes, 1000)  # The check has looked at something.

    def test_only_python_knows_pythons_library(self):
        users = {component for component in MAY_INCLUDE for path in sources(component, ".h", ".cpp")
                 if any(name.startswith("pybind11/") or name == "Python.h" for name in INCLUDE.findall(path.read_text()))}
        self.assertEqual(users, {"python"})

    def test_what_ctrl_c_leaves_behind_owns_what_it_uses(self):
        """Work on another thread may outlive the call that began it: its lambda captures nothing by reference."""
        begun = re.compile(r"\b(?:result_of|run_interruptibly|s\.alone|s\.change)\([^;]*?\[([^\]]*)\]\s*\(")
        captures = [(path, capture) for path in sources("python", ".cpp") for capture in begun.findall(path.read_text())]
        self.assertGreater(len(captures), 30)
        for path, capture in captures:
            with self.subTest(file=str(path.relative_to(ROOT)), capture=capture):
                self.assertNotRegex(capture, "&")

    def test_folders_do_not_include_each_other(self):
        for room in (rooms(), component_rooms()):
            edges = edges_of(room)
            self.assertGreater(len(edges), 20)
            self.assertEqual(cycle_in(edges), [])

    def test_a_cycle_is_found(self):
        self.assertEqual(cycle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}}), ["b", "c", "b"])
        self.assertEqual(cycle_in({"a": {"b", "c"}, "b": {"c"}}), [])

    def test_public_headers_include_public_headers(self):
        num_headers = 0
        for component in MIDDLE | {"libcommon"}:
            for path in sources(f"{component}/include", ".h"):
                num_headers += 1
                for name, target in included(path):
                    with self.subTest(file=str(path.relative_to(ROOT)), includes=name):
                        self.assertTrue(is_public(target))
                        self.assertTrue(name.startswith("patinate/"))
        self.assertGreater(num_headers, 50)

    def test_what_only_modules_may_link_is_named_by_them_alone(self):
        """Each of these libraries brings dozens of others, and would cost every start tenths of a second."""
        owners = {r"OpenImageIO/|libav\w+/|libsw\w+/": "libcommon/media/", r"pcl/": "capture/registration/pcl_"}
        for pattern, owner in owners.items():
            places = {str(path.relative_to(ROOT)) for component in MAY_INCLUDE for path in sources(component, ".h", ".cpp")
                      if any(re.match(pattern, name) for name in INCLUDE.findall(path.read_text()))}
            with self.subTest(owner=owner):
                self.assertTrue(places)
                self.assertEqual({p for p in places if not p.startswith(owner)}, set())

    def test_headers_name_no_heavy_library(self):
        for component in MAY_INCLUDE:
            for path in sources(component, ".h"):
                for name in INCLUDE.findall(path.read_text()):
                    with self.subTest(file=str(path.relative_to(ROOT)), includes=name):
                        self.assertIsNone(HEAVY.search(name))

    def test_every_header_is_compiled_alone(self):
        """A header that no library lists is not verified."""
        listed = "\n".join(p.read_text() for m in MIDDLE | {"libcommon"} for p in sources(m, ".txt"))
        for component in MIDDLE | {"libcommon"}:
            for path in sources(component, ".h"):
                with self.subTest(file=str(path.relative_to(ROOT))):
                    self.assertIn(str(path.relative_to(ROOT / component)), listed)

    def test_files_stay_readable(self):
        for component in MAY_INCLUDE:
            for path in sources(component, ".h", ".cpp"):
                with self.subTest(file=str(path.relative_to(ROOT))):
                    self.assertLessEqual(len(path.read_text().splitlines()), 420)


class Documents(unittest.TestCase):
    def test_commands_in_the_readme_exist(self):
        verbs = set(re.findall(r'Verb\{\.name = "(\w+)', (ROOT / "tools/patinate/commands/verbs.cpp").read_text()))
        self.assertGreater(len(verbs), 5)
        for document in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
            for verb in re.findall(r"^ {4,}patinate ([a-z]+)", document.read_text(), re.MULTILINE):
                with self.subTest(document=document.name, verb=verb):
                    self.assertIn(verb, verbs)

    def test_links_in_documents_lead_somewhere(self):
        for document in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]:
            for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", document.read_text()):
                if "://" not in target:
                    with self.subTest(document=document.name, target=target):
                        self.assertTrue((document.parent / target).exists())


    def test_links_to_headings_lead_to_one(self):
        def slug(heading):
            plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
            return re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")

        for document in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]:
            for path, anchor in re.findall(r"\]\(([^)#:]*\.md)?#([^)]+)\)", document.read_text()):
                page = document.parent / path if path else document
                headings = {slug(h) for h in re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)}
                with self.subTest(document=document.name, target=f"{path}#{anchor}"):
                    self.assertIn(anchor, headings)

    def test_every_page_is_reached_from_the_index(self):
        """By links, from page to page; decisions and notebooks by their folders."""
        docs = (ROOT / "docs").resolve()
        reached, to_do = set(), [docs / "index.md"]
        while to_do:
            page = to_do.pop()
            if page in reached or not page.is_relative_to(docs) or page.suffix != ".md":
                continue
            reached.add(page)
            to_do += [(page.parent / t).resolve() for t in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text()) if "://" not in t]
        for page in sorted(docs.rglob("*.md")):
            if not page.is_relative_to(docs / "decisions"):
                with self.subTest(page=str(page.relative_to(docs))):
                    self.assertIn(page, reached)


class AlgorithmPages(unittest.TestCase):
    """Each says what it computes, when it fails, and which tests prove it; those tests exist."""

    def test_each_has_its_parts_and_its_tests_exist(self):
        tests = set()
        for path in sources("tests", ".cpp"):
            tests |= {".".join(t) for t in re.findall(r"^TEST(?:_F|_P)?\((\w+), (\w+)\)", path.read_text(), re.MULTILINE)}
        pages = sorted((ROOT / "docs/algorithms").glob("*.md"))
        self.assertGreater(len(pages), 5)
        for page in pages:
            text = page.read_text()
            for heading in ("Formula", "When it fails", "Proved by"):
                with self.subTest(page=page.name, heading=heading):
                    self.assertRegex(text, rf"(?m)^## {heading}")
            proofs = re.findall(r"`([A-Z]\w+\.[A-Z]\w+)`", text.split("## Proved by")[-1])
            with self.subTest(page=page.name):
                self.assertTrue(proofs)
            for proof in proofs:
                with self.subTest(page=page.name, test=proof):
                    self.assertIn(proof, tests)


if __name__ == "__main__":
    unittest.main()
