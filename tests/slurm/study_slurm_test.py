#!/usr/bin/env python3
"""A study of 24 transfers and 8 simulations through Snakemake and a Slurm of one node: undisturbed, with workers killed and the controller restarted, and in a
shared folder that fills up in between (as root).
Usage: study_slurm_test.py PATINATE [unittest arguments]. Skipped, saying so, where Snakemake or Slurm is not installed."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from loopback import Slurm, missing

PATINATE = os.path.abspath(sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate")
if not shutil.which("snakemake"):
    print("study_slurm_test: skipped, snakemake is not installed (Debian's snakemake)")
    sys.exit(77)
if missing():
    print(f"study_slurm_test: skipped, {missing()}")
    sys.exit(77)

FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="patinate_slurm_"))
STUDY = {"format": "patinate.study", "version": 1,
         "transfer": {"histories": ["history", "other"], "meshes": ["urn/mesh.obj", "flat.obj", "tall.obj"], "controls": ["facing", "height"], "options": {"resolution": 64}, "seeds": [1, 2]},
         "simulate": {"scenes": ["ledge/scene.json"], "options": {"resolution": 64, "iterations": 6}, "seeds": [1, 2],
                      "vary": [{"pointer": "/appearance/dirt/strength", "low": 0.5, "high": 2, "scale": "log", "count": 2}, {"pointer": "/emitters/0/gammatons", "values": [500, 900]}]}}
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 {h} 0.2\nv 0 {h} 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
NUM_STEPS = 24 + 8


def run(*arguments):
    result = subprocess.run([PATINATE, *arguments], cwd=FOLDER, capture_output=True, text=True)
    if result.returncode != 0:
        raise RuntimeError(f"{arguments}: {result.stderr}")


def setUpModule():
    os.chmod(FOLDER, 0o755)
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "-o", "capture"], ["ingest", "capture", "-o", "history"],
                      ["synth", "crackle", "--width", "40", "--height", "48", "--num-frames", "3", "--seed", "5", "-o", "capture2"], ["ingest", "capture2", "-o", "other"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["synth", "ledge", "--cells", "4", "-o", "ledge"]):
        run(*arguments)
    for name, height in (("flat", 1), ("tall", 3)):
        (FOLDER / f"{name}.obj").write_text(SQUARE.format(h=height))
    (FOLDER / "study.json").write_text(json.dumps(STUDY))
    run("study", "run", "study.json", "-o", "here")


def tearDownModule():
    shutil.rmtree(FOLDER)


def results(folder):
    return {str(p.relative_to(FOLDER / folder)): p.read_bytes() for p in sorted((FOLDER / folder).rglob("*"))
            if p.is_file() and p.name != "run.json" and p.relative_to(FOLDER / folder).parts[0] in ("cells", "cells.json", "report.html", "report.json", "transfer.csv", "simulate.csv", "done")}


class Study(unittest.TestCase):
    def through_slurm(self, name, disturb=None, expected=0):
        """The study in a folder; `disturb(slurm, folder)` is called while it runs. @returns what Snakemake said."""
        if not (FOLDER / name / "Snakefile").exists():
            run("study", "export", "study.json", "--snakemake", name)
        with Slurm(FOLDER / f"slurm_{name}") as slurm:
            environment = {**slurm.environment, "PATH": f"{pathlib.Path(PATINATE).parent}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(FOLDER / "cache"), "HOME": str(FOLDER)}
            with open(FOLDER / f"{name}.log", "w+") as log:
                process = subprocess.Popen(["snakemake", "--profile", "profiles/slurm", "--latency-wait", "10"], cwd=FOLDER / name, env=environment, stdout=log, stderr=log)
                if disturb:
                    disturb(slurm, FOLDER / name)
                code = process.wait(timeout=900)
                log.seek(0)
                said = log.read()
            self.assertEqual(code, expected, said[-3000:] + slurm.said())
        shutil.rmtree(slurm.folder)
        return said

    def assert_as_here(self, name):
        made, here = results(name), results("here")
        self.assertEqual(sorted(made), sorted(here))
        self.assertEqual([file for file in here if made[file] != here[file]], [])

    def test_it_makes_the_bytes_of_the_local_run(self):
        self.through_slurm("undisturbed")
        self.assertEqual(len(list((FOLDER / "undisturbed/done").rglob("*-*"))), NUM_STEPS)
        self.assert_as_here("undisturbed")

    def test_workers_killed_and_a_controller_restarted_change_no_byte_and_what_is_done_stays(self):
        kept = {}

        def disturb(slurm, folder):
            def num_done():
                return len(list((folder / "done").rglob("*-*")))
            slurm.wait_until(lambda: num_done() >= 3, "three steps done", 300)
            kept.update({p: p.stat().st_ino for p in (folder / "cells").glob("*/transfer/transfer.json")})
            # A worker: what a job's shell has started.
            victims = [int(pid) for pid in slurm.ask("pgrep", "-f", f"{PATINATE}|patinate cluster run").split() if is_below(int(pid), slurm.processes["slurmd"].pid)]
            for victim in victims[:2]:
                try:
                    os.kill(victim, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            slurm.wait_until(lambda: num_done() >= 8, "eight steps done", 300)
            slurm.restart_controller()

        self.through_slurm("disturbed", disturb)
        self.assert_as_here("disturbed")
        self.assertTrue(kept)
        self.assertEqual({p: p.stat().st_ino for p in kept}, kept)
        self.assertEqual([p for p in (FOLDER / "disturbed/cells").rglob(".*") if ".tmp" in p.name and p.is_dir()], [])


    def test_where_the_shared_folder_fills_up_in_between_a_later_run_makes_the_rest(self):
        place = FOLDER / "small"  # The study's own folder: relative paths are as in the others.
        place.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", place], capture_output=True, text=True)
        if mounted.returncode != 0:
            self.skipTest(f"a small file system needs root: {mounted.stderr.strip()}")
        try:
            filler, kept = place / "filler", {}

            def fill_up(slurm, folder):
                slurm.wait_until(lambda: len(list((folder / "done").rglob("*-*"))) >= 3, "three steps done", 300)
                with open(filler, "wb", buffering=0) as f:
                    try:
                        while True:
                            f.write(bytes(2**16))
                    except OSError:
                        pass
                kept.update({p: p.stat().st_ino for p in (folder / "cells").glob("*/transfer/transfer.json")})

            self.through_slurm("small", fill_up, expected=1)
            self.assertLess(len(list((place / "done").rglob("*-*"))), NUM_STEPS)
            filler.unlink()
            self.through_slurm("small")
            self.assert_as_here("small")
            self.assertTrue(kept)
            self.assertEqual({p: p.stat().st_ino for p in kept}, kept)
        finally:
            subprocess.run(["umount", place], check=True)


def is_below(pid, ancestor):
    """The process is a child of `ancestor`, or of its children."""
    while pid > 1:
        if pid == ancestor:
            return True
        try:
            pid = int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, ValueError):
            return False
    return False


if __name__ == "__main__":
    unittest.main()
