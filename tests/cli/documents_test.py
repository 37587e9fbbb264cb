#!/usr/bin/env python3
"""What is made from the commands' declarations: completion, man page, docs/commands.md. Usage: documents_test.py PATINATE

documents_test.py PATINATE --update writes the generated part of docs/commands.md, and the schemas of described documents, again.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
COMMANDS = pathlib.Path(__file__).resolve().parents[2] / "docs/commands.md"
SCHEMAS = COMMANDS.parent / "schema"
MARK = "<!-- From here on made by `patinate help --markdown`: tests/cli/documents_test.py PATINATE --update -->\n"


def output_of(*arguments):
    return subprocess.run([PATINATE, *arguments], capture_output=True, text=True, check=True).stdout


def commands():
    """{name: what it does} of every command, "fit field" as one, in the order of the manual."""
    return dict(re.findall(r"^## ([a-z-]+(?: [a-z-]+)?)\n(.*)\.$", output_of("help", "--markdown"), re.MULTILINE))


def described_schemas():
    """Kinds of files whose schema is made of their description."""
    refused = subprocess.run([PATINATE, "help", "--schema", "none"], capture_output=True, text=True)
    return re.search(r"expected ([a-z_, ]+)", refused.stderr).group(1).strip().split(", ")


def table():
    """The table with which docs/commands.md begins."""
    return "| command | |\n| --- | --- |\n" + "".join(f"| [{name}](#{name.replace(' ', '-')}) | {brief[0].lower() + brief[1:]} |\n" for name, brief in commands().items())


class Documents(unittest.TestCase):
    def test_commands_page_is_current(self):
        written = COMMANDS.read_text().split(MARK)[1]
        self.assertEqual(written, output_of("help", "--markdown"), "run tests/cli/documents_test.py PATINATE --update")

    def test_schemas_of_described_documents_are_current(self):
        names = described_schemas()
        self.assertIn("history", names)
        for name in names:
            with self.subTest(schema=name):
                self.assertEqual((SCHEMAS / f"{name}.schema.json").read_text(), output_of("help", "--schema", name), "run tests/cli/documents_test.py PATINATE --update")

    def test_the_page_begins_with_every_command(self):
        self.assertIn("\n" + table() + "\n", COMMANDS.read_text().split("\n## ")[0], "run tests/cli/documents_test.py PATINATE --update")

    def test_about_twenty_commands_and_the_ten_of_the_main_path_first(self):
        first_words = list(dict.fromkeys(name.split()[0] for name in commands()))
        # Twenty-three when commands were grouped; laboratories ask for `grade` by name.
        self.assertLessEqual(len(first_words), 24)
        page = output_of("--help")
        self.assertEqual(re.findall(r"^  ([a-z]+) .*\.$", page, re.MULTILINE),
                         ["init", "ingest", "control", "transfer", "texture", "render", "export", "simulate", "fit", "studio"])
        for name in commands():
            self.assertRegex(page, r"\b" + name.split()[0])
            self.assertRegex(page, r"\b" + name.split()[-1])

    def test_help_of_a_command_with_many_options_begins_with_the_usual_ones(self):
        kinds = ("crackle", "drying", "dust", "edges", "fence", "ledge", "mold", "panel", "plate", "sculpture")
        for name in [*(c for c in commands() if c != "synth"), *(f"synth {kind}" for kind in kinds)]:
            with self.subTest(command=name):
                everything, first = (output_of(*name.split(), option) for option in ("--help-all", "--help"))
                option = re.compile(r"^  (--?[a-z][-a-z]*)", re.MULTILINE)
                own = option.findall(everything.split("\nEvery command:")[0])
                if len(own) <= 12:
                    self.assertEqual(option.findall(first), option.findall(everything))
                    continue
                shown = option.findall(first)
                self.assertTrue(3 <= len(shown) <= 9 and set(shown) < set(own), shown)
                self.assertEqual(own[:len(shown)], shown)  # The same order in both.
                self.assertLess(first.index("\n  patinate "), first.index("\nOptions:"))
                self.assertIn(f"{len(own) - len(shown)} more options", " ".join(first.split()))

    def test_transfer_has_six_usual_options(self):
        self.assertEqual(len(re.findall(r"^  --?[a-z]", output_of("transfer", "--help"), re.MULTILINE)), 6)

    def test_man_page_has_no_warnings_and_every_command(self):
        page = output_of("help", "--man")
        for verb in commands():
            self.assertIn(".SS " + verb.replace("-", "\\-") + "\n", page)
        if not shutil.which("man"):
            self.skipTest("no man")
        shown = subprocess.run(["man", "--warnings", "-l", "-"], input=page, capture_output=True, text=True, env={**os.environ, "MANWIDTH": "100"})
        self.assertEqual((shown.returncode, shown.stderr), (0, ""))
        self.assertIn("--threads N", shown.stdout)


class Completion(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patinate_completion_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "aged").mkdir()
        (self.folder / "a map.exr").touch()

    def script(self, shell):
        path = self.folder / f"complete.{shell}"
        path.write_text(output_of("help", "completion", shell))
        return path

    def bash(self, *words):
        call = f'source {self.script("bash")}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _patinate; printf "%s\\n" "${{COMPREPLY[@]}}"'
        result = subprocess.run(["bash", "-c", call, "bash", *words], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.stderr, "")
        return [line for line in result.stdout.split("\n") if line]

    def test_bash_offers_commands_options_choices_and_files(self):
        self.assertEqual(self.bash("patinate", "tra"), ["transfer"])
        self.assertIn("--version", self.bash("patinate", "-"))
        self.assertEqual(self.bash("patinate", "transfer", "--metho"), ["--method"])
        self.assertEqual(self.bash("patinate", "transfer", "--method", ""), ["fast", "reference"])
        self.assertEqual(self.bash("patinate", "transfer", "--method", "=", "r"), ["reference"])
        self.assertEqual(self.bash("patinate", "synth", ""), ["crackle", "drying", "dust", "edges", "fence", "ledge", "mold", "panel", "plate", "sculpture"])
        self.assertEqual(self.bash("patinate", "texture", "ag"), ["aged"])
        self.assertEqual(self.bash("patinate", "texture", "aged", "-o", "a "), ["a map.exr"])
        self.assertEqual(self.bash("patinate", "texture", "aged", "--time", ""), [])
        self.assertEqual(self.bash("patinate", "help", "completion", "f"), ["fish"])
        self.assertEqual(self.bash("patinate", "hist"), ["history"])
        self.assertEqual(self.bash("patinate", "history", "tr"), ["trim"])
        self.assertEqual(sorted(self.bash("patinate", "fit", "")), ["a map.exr", "aged", "complete.bash", "field", "rank"])
        self.assertEqual(self.bash("patinate", "fit", "field", "--swee"), ["--sweeps"])
        self.assertEqual(self.bash("patinate", "history", "compare", "a", "b", "--clock", "s"), ["span"])

    @unittest.skipUnless(shutil.which("fish"), "no fish")
    def test_fish_offers_commands_options_choices_and_files(self):
        script = self.script("fish")

        def offers(line):
            result = subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C '{line}'"], cwd=self.folder, capture_output=True, text=True,
                                    env={**os.environ, "HOME": str(self.folder)})
            self.assertEqual(result.stderr, "")
            return [offer.split("\t")[0] for offer in result.stdout.splitlines()]
        self.assertEqual(offers("patinate tr"), ["transfer"])
        self.assertIn("--method", offers("patinate transfer --m"))
        self.assertEqual(offers("patinate transfer --method "), ["fast", "reference"])
        self.assertEqual(offers("patinate synth "), ["crackle", "drying", "dust", "edges", "fence", "ledge", "mold", "panel", "plate", "sculpture"])
        self.assertEqual(offers("patinate lookup ag"), ["aged/"])
        self.assertEqual(offers("patinate history tr"), ["trim"])
        self.assertIn("--places", offers("patinate fit field --pl"))

    @unittest.skipUnless(shutil.which("zsh"), "no zsh")
    def test_zsh_offers_commands_options_choices_and_files(self):
        # A shell in a pseudo-terminal, as a user has it; what it lists after a tab is read until the word comes, or half a minute is over.
        script = self.script("zsh")
        driver = self.folder / "driver.zsh"
        driver.write_text(f"""
zmodload zsh/zpty
zpty -b shell zsh -f -i
ask() {{
  zpty -w -n shell "$1"; local out text='' i
  for i in {{1..300}}; do while zpty -r -t shell out; do text+=$out; done; [[ $text == *$2* ]] && break; sleep 0.1; done
  print -r -- "$text"
}}
ask $'PS1= ; unsetopt zle_bracketed_paste; autoload -U compinit && compinit -u -D && source {script} && print REA""DY\\n' READY >/dev/null
for line offer in "$@"; do ask "$line"$'\\t' $offer; zpty -w -n shell $'\\C-u'; print -r -- '-----'; done
""")
        lines = {"patinate tr": "transfer", "patinate transfer --method r": "reference", "patinate synth s": "sculpture",
                 "patinate lookup ag": "aged", "patinate history tr": "trim", "patinate history compare --clock s": "span"}
        arguments = [word for pair in lines.items() for word in pair]
        result = subprocess.run(["zsh", "-f", str(driver), *arguments], cwd=self.folder, capture_output=True, text=True, timeout=300,
                                env={**os.environ, "HOME": str(self.folder), "TERM": "dumb", "COLUMNS": "200"})
        self.assertEqual(result.stderr, "")
        for line, offer, answer in zip(lines, lines.values(), result.stdout.split("-----")):
            self.assertIn(offer, answer, line)


if __name__ == "__main__":
    if "--update" in sys.argv:
        text = re.sub(r"\| command \| \|\n\| --- \| --- \|\n(\| .*\n)*", lambda _: table(), COMMANDS.read_text().split(MARK)[0], count=1)
        COMMANDS.write_text(text + MARK + output_of("help", "--markdown"))
        for name in described_schemas():
            (SCHEMAS / f"{name}.schema.json").write_text(output_of("help", "--schema", name))
    else:
        unittest.main()
