#!/usr/bin/env python3
"""`patinate history trim`: a history of some of another one's frames. Usage: trim_test.py PATINATE [unittest arguments]"""
import json
import sys
import unittest

from command_case import INPUT, USAGE, CommandCase, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PATINATE)


class Trim(CommandCase):
    def setUp(self):
        super().setUp()
        (self.folder / "whole").symlink_to(self.shared / "history")
        self.times = self.times_of("whole")

    def times_of(self, history):
        return [frame["time"] for frame in json.loads((self.folder / history / "history.json").read_text())["frames"]]

    def test_frames_that_stay_are_those_of_the_whole_with_their_times(self):
        command = ["history", "trim", "whole", "--from", self.times[1], "--every", "2", "-o", "part"]
        self.succeeds(*command)
        self.assertEqual(self.times_of("part"), self.times[1::2])
        for new, old in enumerate(range(1, len(self.times), 2)):
            self.assertEqual((self.folder / f"part/frames/{new:04}.exr").read_bytes(), (self.folder / f"whole/frames/{old:04}.exr").read_bytes())
        self.succeeds("validate", "part")
        part, whole = (json.loads((self.folder / name / "history.json").read_text()) for name in ("part", "whole"))
        for member in ("name", "controls", "mask", "texel_size_mm"):
            self.assertEqual(part.get(member), whole.get(member), member)
        self.assertIn("up to date", self.run_patinate(*command).stderr)

    def test_what_was_seen_until_a_time_is_what_the_whole_shows_until_then(self):
        self.succeeds("history", "trim", "whole", "--until", self.times[-2], "-o", "seen")
        report = json.loads(self.succeeds("history", "compare", "seen", "whole", "--num-resamples", "0", "-o", "report", "--json"))
        figures = {figure["name"]: figure["value"] for figure in report["figures"]}
        self.assertEqual(figures["ciede2000_p95"], 0)

    def test_bad_input_is_one_line(self):
        self.fails(INPUT, "no frame is left", "history", "trim", "whole", "--from", "1e9", "-o", "out")
        self.fails(USAGE, "every", "history", "trim", "whole", "--every", "0", "-o", "out")
        self.fails(INPUT, "urn", "history", "trim", self.shared / "urn", "-o", "out")


if __name__ == "__main__":
    unittest.main()
