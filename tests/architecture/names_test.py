#!/usr/bin/env python3
"""No name with external linkage is defined in two files. Usage: names_test.py REPOSITORY

The linker keeps one of two inline functions of the same name, and of the destructors of two types of the same name, whichever it meets
first, and says nothing. `cmake --preset odr` (tools/nightly) asks the compiler about layouts, too; this asks in a second, over all files.
"""
import collections
import pathlib
import sys
import unittest

from definitions import external_definitions, local_definitions

ROOT = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
FOLDERS = ["libcommon", "capture", "transfer", "simulation", "analysis", "datasets_synthetic", "app", "tools", "tests"]
PROGRAMS_OWN = {"main", "LLVMFuzzerTestOneInput"}


def twice_defined(texts):
    """{(kind, name): [file:line, ...]} of what stands in more than one of {file: text}."""
    places = collections.defaultdict(dict)
    for file, text in texts.items():
        for kind, name, line in external_definitions(text):
            if name.split("(")[0] not in PROGRAMS_OWN:
                places[kind, name].setdefault(file, f"{file}:{line}")
    return {key: sorted(files.values()) for key, files in places.items() if len(files) > 1}, len(places)


class Names(unittest.TestCase):
    def test_no_name_is_defined_in_two_files(self):
        texts = {str(path.relative_to(ROOT)): path.read_text() for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*"))
                 if path.suffix in {".h", ".cpp"} and "node_modules" not in path.parts}
        twice, num_names = twice_defined(texts)
        self.assertGreater(num_names, 2500)  # the check has looked at something
        for (kind, name), files in sorted(twice.items()):
            with self.subTest(kind=kind, name=name, files=files):
                self.fail(f"{kind} {name} is defined in {' and '.join(files)}: name them apart, or put what one file needs in an unnamed namespace")


OVERLOADED = {"describe"}  # One for each options struct of a command: the struct chooses.


def met_in_a_folder(texts):
    """{(folder, name): [file:line, ...]} of local names that stand in more than one .cpp of a folder, of {file: text}."""
    places = collections.defaultdict(list)
    for file, text in texts.items():
        for name, line in local_definitions(text).items():
            if name not in OVERLOADED:
                places[str(pathlib.PurePath(file).parent), name].append(f"{file}:{line}")
    return {key: files for key, files in places.items() if len(files) > 1}


class LocalNames(unittest.TestCase):
    """Several sources of a folder are compiled as one (PATINATE_UNITY): what each calls its own must have a name of its own."""

    def test_no_local_name_stands_twice_in_a_folder(self):
        texts = {str(path.relative_to(ROOT)): path.read_text() for folder in FOLDERS + ["python"] for path in sorted((ROOT / folder).rglob("*.cpp"))
                 if not {"node_modules", "benchmarks"} & set(path.parts)}  # Benchmarks are compiled source by source.
        for (folder, name), files in sorted(met_in_a_folder(texts).items()):
            with self.subTest(name=name, files=files):
                self.fail(f"{name} is local to {' and '.join(files)}: give a shared helper one home in {folder}, and others names that say what they are")

    def test_what_is_local(self):
        for text in ("namespace {\nint half(int x) {\n  return x;\n}\n}", "namespace {\nconstexpr int kHalf = 1;\n}", "static int half(int x) { return x; }", "constexpr double kHalf = 0.5;",
                     "namespace {\nstruct Half {\n  int a = 0;\n};\n}", "namespace {\nusing Half = int;\n}", "namespace {\nconstexpr int kQuarter = 1, kHalf = 2;\n}", "namespace {\ntemplate <class T>\nT half(T x) {\n  return x;\n}\n}"):
            with self.subTest(text=text):
                self.assertIn("half", {name.lower().removeprefix("k") for _, name in met_in_a_folder({"x/a.cpp": text, "x/b.cpp": text})})
                self.assertEqual(met_in_a_folder({"x/a.cpp": text, "y/b.cpp": text}), {})
        for text in ("int half(int x) { return x; }", "namespace {\nTEST(Half, IsHalf) {\n  const int x = 1;\n}\n}", "void f() {\n  constexpr int kHalf = 1;\n}", "namespace fs = std::filesystem;"):
            with self.subTest(text=text):
                self.assertEqual(met_in_a_folder({"x/a.cpp": text, "x/b.cpp": text}), {})


class WhatIsFound(unittest.TestCase):
    """The four pairs that met in one binary (issue 18), as they were written, and what else may be written twice."""

    def found(self, first, second):
        wrap = "#include <vector>\nnamespace patinate {{\n{}\n}}  // namespace patinate\n".format
        return [name for _, name in twice_defined({"a.h": wrap(first), "b.h": wrap(second)})[0]]

    def test_types(self):
        pairs = {
            "SurfaceFrames": ("struct SurfaceFrames {\n  std::string name;\n};", "class SurfaceFrames {\n public:\n  SurfaceFrames(const SceneMesh& m);\n};"),
            "Registration": ("struct Registration {\n  int a = 0;\n};", "/// Other.\nstruct Registration {\n  std::vector<PlacedScan> scans;\n};"),
            "Alignment": ("struct Alignment {\n  double gate = 0.0;\n};", "struct Alignment {\n  int num_matches = 0;\n};"),
            "TileRule": ("enum class TileRule { Square, Udim };", "struct TileRule {\n  RuleTerm terms[kMax];\n};"),
        }
        for name, (first, second) in pairs.items():
            with self.subTest(name=name):
                self.assertIn(f"patinate::{name}", self.found(first, second))

    def test_inline_functions_members_and_variables(self):
        for text in ("inline int half(int x) { return x / 2; }", "template <class T>\nT half(const std::vector<T>& x) {\n  return x[0];\n}", "int Rest::half(int x) const {\n  return x;\n}",
                     "inline constexpr std::array<int, 2> kHalf{1, 2};", "struct alignas(64) Half final : Base {\n};", "Half::Half(int a, const B& b) : a_{a}, b_(b) {}",
                     "bool operator==(const Half& a, const Half& b) { return true; }"):
            with self.subTest(text=text):
                self.assertEqual(len(self.found(text, text)), 1)
        self.assertEqual(self.found("inline int half(int x) { return x / 2; }", "inline int half(int value) { return value >> 1; }"), ["patinate::half(int)"])

    def test_what_cannot_meet_is_left_alone(self):
        for text in ("struct Half;", "int half(int x, const Options& options = {}, double y = 1.0);", "namespace {\nstruct Half {\n  int half() { return 1; }\n};\n}", "static int half(int x) { return x / 2; }",
                     "constexpr int kHalf = 1;", "namespace detail_of_one {\nnamespace {\nint half(int x) { return x; }\n}\n}", '// struct Half {};\n/* struct Half {}; */'):
            with self.subTest(text=text):
                self.assertEqual(self.found(text, text), [])
        self.assertEqual(self.found("inline int half(int x) { return x; }", "inline double half(double x) { return x; }"), [])  # overloads
        self.assertEqual(self.found("struct A {\n  struct State {\n  };\n};", "struct B {\n  struct State {\n  };\n};"), [])
        self.assertEqual(self.found("void f() {\n  struct Half {\n  };\n}", "void g() {\n  struct Half {\n  };\n}"), [])


if __name__ == "__main__":
    unittest.main()
