"""`patinate study`, whose command line the program has read."""
import json
import signal
import sys
import time

from patinate import Error, InputError, _native

from .context import Program
from .folder import is_done, place_study, read_study_folder
from .report import write_study_report
from .snakemake import write_snakefile
from .steps import INTERRUPTED, run_study, write_plans
from .study import read_study

CANNOT, INPUT = 1, 3
MOST_LINES = 20


class Run:
    """One run of the command."""

    def __init__(self, given):
        self.given = given
        self.is_terminal = sys.stderr.isatty()
        self.is_shown = False

    def _clear(self):
        if self.is_shown and self.is_terminal:
            sys.stderr.write("\r\033[K")
        self.is_shown = False

    def note(self, text):
        self._clear()
        if not self.given["quiet"]:
            sys.stderr.write(_native._printable(text) + "\n")

    def problems(self, lines):
        self._clear()
        shown = lines[:MOST_LINES]
        if len(lines) > MOST_LINES:
            shown.append(f"and {len(lines) - MOST_LINES} more problems")
        for line in shown:
            sys.stderr.write(f"patinate: error: {_native._printable(line.replace(chr(10), ' '))}\n")

    def result(self, value):
        if self.given["json"]:
            print(json.dumps(value, indent=2, ensure_ascii=False))

    def progress(self, label):
        """Takes fractions and shows them, as other commands do."""
        begin = last = time.monotonic()

        def show(fraction):
            nonlocal last
            now = time.monotonic()
            if self.given["quiet"] or now - last < (0.1 if self.is_terminal else 10):
                return
            last, self.is_shown = now, True
            left = int((now - begin) * (1 / fraction - 1)) if fraction > 0 else 0
            told = f"{int(100 * fraction)} %, {left // 60}:{left % 60:02} left"
            bar = "#" * int(30 * fraction)
            sys.stderr.write(f"\r{label} [{bar:30}] {told}\033[K" if self.is_terminal else f"{label}: {told}\n")
            sys.stderr.flush()
        return show

    def read(self):
        """The study's name and parts; None when something is wrong with it, which is then said."""
        program = Program(self.given["program"])
        try:
            name, parts, problems = read_study(self.given["study"], self.given["output"], program)
        finally:
            program.close()
        self.problems(problems)
        return None if problems else (name, parts)

    def steps_left(self, parts):
        """What is left, as far as the folder tells."""
        folder = self.given["output"]
        steps = [(cell, step) for part in parts for cell in part.cells for step in part.steps]
        left = [(cell.name, step.name) for cell, step in steps if not is_done(folder, step, cell)]
        if self.given["json"]:
            return self.result({"steps": len(steps), "left": [{"cell": cell, "step": step} for cell, step in left]})
        print(f"{folder}: {len(left)} of {len(steps)} steps are left")
        for cell, step in left[:MOST_LINES]:
            print(f"  {cell}: {step}")
        if len(left) > MOST_LINES:
            print(f"  and {len(left) - MOST_LINES} more")

    def report(self, study):
        counts = write_study_report(study, self.progress("report"))
        page = study.inside("report.html")
        told = ", ".join(f"{number} {status}" for status, number in counts.items())
        self.note(f"{page}: {told}".replace(" done", " cells done", 1))
        self.result({"output": study.path, "report": page, "done": counts["done"], "failed": counts["failed"],
                     "not_run": counts["not run"]})

    def run(self):
        given = self.given
        if given["kind"] == "report":
            self.report(read_study_folder(given["study"]))
            return 0
        read = self.read()
        if read is None:
            return INPUT
        if given["dry_run"]:
            self.steps_left(read[1])
            return 0
        study = place_study(*read, given["output"])
        if given["kind"] == "export":
            return self.export(study)
        failures = run_study(study, given["program"], given["jobs"] or given["threads"], given["threads"],
                             self.progress("study"))
        self.report(study)
        self.problems(failures)
        return CANNOT if failures else 0

    def export(self, study):
        problems = write_plans(study, self.given["program"])
        if problems:
            self.problems(problems)
            return INPUT
        write_snakefile(study)
        num_cells = len(study.cells())
        self.note(f"{study.path}: {num_cells} cells; cd {study.path} && snakemake --profile profiles/local")
        self.result({"output": study.path, "cells": num_cells})
        return 0


def main(given):
    """Gives the exit code. `given`: what the command line says, as JSON."""
    run = Run(json.loads(given))
    def stop(*_):
        raise KeyboardInterrupt
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    try:
        return run.run()
    except KeyboardInterrupt:
        run.problems(["interrupted; nothing half-written is left, and the same command finishes the work"])
        return INTERRUPTED
    except Error as error:
        run.problems([str(error)])
        return INPUT if isinstance(error, InputError) else CANNOT
    except OSError as error:
        run.problems([f"{error.filename or 'the file system'}: {error.strerror}"])
        return CANNOT
