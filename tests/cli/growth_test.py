#!/usr/bin/env python3
"""tools/growth: exponents of known laws, and one series as a user measures it.
Usage: growth_test.py PATINATE [unittest arguments]"""
import importlib.machinery
import importlib.util
import pathlib
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PATINATE = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate").resolve()
TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "growth"


def loaded():
    loader = importlib.machinery.SourceFileLoader("growth", str(TOOL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("growth", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    module.PATINATE = PATINATE
    return module


class Growth(unittest.TestCase):
    def test_exponents_are_those_of_the_law(self):
        growth = loaded()
        for law in (0.5, 1.0, 1.5):
            points = [{"size": n, "work": n, "seconds": 0.1 + 1e-3 * n**law, "peak_mb": 10} for n in (10, 100, 1000, 10000)]
            self.assertAlmostEqual(growth.exponent(points, 0.1), law, places=9)
        results = {"steep": {"command": "it", "points": points, "exponent": 1.5}, "even": {"command": "it", "points": points, "exponent": 1.0}}
        self.assertEqual(growth.table(results).count("more than its work"), 1)
        xml.etree.ElementTree.fromstring(growth.plot(results))

    def test_a_series_is_measured(self):
        with tempfile.TemporaryDirectory() as folder:
            growth, folder = loaded(), pathlib.Path(folder)
            seconds, peak = growth.run(folder, "synth", "crackle", "--width", 32, "--height", 32, "--num-frames", 4, "-o", "photos")
            self.assertGreater(peak, 1)
            self.assertGreater(seconds, 0)
            with self.assertRaises(SystemExit):
                growth.run(folder, "ingest", "none", "-o", "out")


if __name__ == "__main__":
    unittest.main()
