#!/usr/bin/env python3
"""What commands leave behind: whole outputs or none, also where they are stopped. Usage: outputs_test.py PATINATE [unittest arguments]"""
import shutil
import signal
import subprocess
import sys
import time
import unittest

from command_case import CANNOT, INTERRUPTED, USAGE, CommandCase, tree_of, use

PATINATE = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "build/release/bin/patinate"


def setUpModule():
    use(PATINATE)


class Outputs(CommandCase):
    def test_the_same_command_again_is_up_to_date_and_changes_nothing(self):
        arguments = ["texture", self.shared / "aged", "--time", "3", "-o", "x.png"]
        self.succeeds(*arguments)
        before = (self.folder / "x.png").stat().st_mtime_ns
        self.assertIn("up to date", self.run_patinate(*arguments).stderr)
        self.assertEqual((self.folder / "x.png").stat().st_mtime_ns, before)

    def test_a_different_output_is_untouched_without_force(self):
        first = ["texture", self.shared / "aged", "--time", "3", "-o", "x.png"]
        other = ["texture", self.shared / "aged", "--time", "4", "-o", "x.png"]
        self.succeeds(*first)
        whole = (self.folder / "x.png").read_bytes()
        self.fails(CANNOT, "--force", *other)
        self.assertEqual((self.folder / "x.png").read_bytes(), whole)
        self.succeeds(*other, "--force")
        self.succeeds(*first, "--force")
        self.assertEqual((self.folder / "x.png").read_bytes(), whole)

    def test_a_folder_of_somebody_else_survives_force(self):
        (self.folder / "photos").mkdir()
        (self.folder / "photos/a.txt").write_text("precious")
        self.fails(CANNOT, "photos", "ingest", self.shared / "capture", "-o", "photos", "--force")

    def test_nothing_is_made_inside_a_finished_result(self):
        shutil.copytree(self.shared / "history", self.folder / "history")
        self.fails(USAGE, "a finished result", "export", "history", "-o", "history/frames/more")
        self.fails(USAGE, "a finished result", "texture", self.shared / "aged", "--time", "1", "-o", "history/x.png")
        self.fails(USAGE, "a finished result", "ingest", self.shared / "capture", "-o", "history/again", "--force")
        self.succeeds("ingest", self.shared / "capture", "-o", "made/")
        self.succeeds("ingest", self.shared / "capture", "-o", "made/")  # the result itself is another matter: up to date

    def test_places_that_cannot_be_written(self):
        (self.folder / "file").write_text("x")
        self.fails(CANNOT, "file/out", "ingest", self.shared / "capture", "-o", "file/out")
        self.fails(CANNOT, "nowhere", "ingest", self.shared / "capture", "-o", "nowhere/out")
        self.fails(CANNOT, "nowhere", "texture", self.shared / "aged", "--time", "1", "-o", "nowhere/x.png")
        self.fails(CANNOT, "file", "texture", self.shared / "aged", "--time", "1", "-o", "file/x.png")
        self.fails(CANNOT, "/proc/out", "ingest", self.shared / "capture", "-o", "/proc/out")

    def test_a_file_size_limit_is_a_full_disk(self):
        def limit():
            import resource
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
        result = self.run_patinate("ingest", self.shared / "capture", "-o", "out", preexec_fn=limit)
        self.assertEqual(result.returncode, CANNOT, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertFalse((self.folder / "out").exists())
        self.succeeds("ingest", self.shared / "capture", "-o", "out")
        self.assertEqual(tree_of(self.folder / "out"), tree_of(self.shared / "history"))

    def test_threads_do_not_change_bytes(self):
        for threads in (1, 3):
            self.succeeds("ingest", self.shared / "capture", "--threads", threads, "-o", f"out{threads}")
            self.assertEqual(tree_of(self.folder / f"out{threads}"), tree_of(self.shared / "history"))

    def test_unknown_extensions(self):
        self.fails(USAGE, "x.docx", "render", self.shared / "aged", "-o", "x.docx")
        for name in ("x.gltf", "x.FBX", "x.ply", "x.png", "x.exr"):
            self.fails(USAGE, name, "export", self.shared / "aged", "-o", name)

    def test_folders_may_have_dots_in_their_names(self):
        self.succeeds("export", self.shared / "history", "--times", "0", "-o", "seq.v2")
        self.assertTrue((self.folder / "seq.v2/sequence.json").exists())

    def test_times_that_differ_late_have_labels_that_differ(self):
        capture = self.take("capture")
        frames = {"pattern": "frames/*.png", "start": 1600000000, "interval": 60}
        self.edit_json(capture / "capture.json", lambda c: c.update(frames=frames, time_unit="s"))
        self.succeeds("ingest", "capture", "-o", "history")
        self.take("urn")
        self.succeeds("transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "32", "-o", "aged")
        self.succeeds("export", "aged", "--times", "1600000000,1600000060", "-o", "x.glb")
        content = (self.folder / "x.glb").read_bytes()
        self.assertTrue(b'"1600000000 s"' in content and b'"1600000060 s"' in content)


class Interruptions(CommandCase):
    # Long enough to be stopped in the middle: about 2 s on one core.
    SYNTH = ["synth", "crackle", "--width", "256", "--height", "192", "--num-frames", "40", "--threads", "1", "-o", "out"]

    def stopped(self, stop_signal):
        """Starts the command and sends the signal when a few frames are finished."""
        process = subprocess.Popen([self.patinate, *self.SYNTH], cwd=self.folder, stderr=subprocess.PIPE, text=True)
        done = self.folder / "out.partial/.job/done"
        for _ in range(2000):
            if done.exists() and len(list(done.iterdir())) >= 3:
                break
            time.sleep(0.01)
        process.send_signal(stop_signal)
        _, errors = process.communicate(timeout=60)
        self.assertFalse((self.folder / "out").exists(), "the command ended before it was stopped")
        return process.returncode, errors

    def whole(self):
        self.succeeds(*self.SYNTH[:-1], "whole")
        return tree_of(self.folder / "whole")

    def test_ctrl_c_is_one_line_and_130_and_the_command_goes_on_later(self):
        code, errors = self.stopped(signal.SIGINT)
        self.assertEqual(code, INTERRUPTED)
        self.assertEqual([line for line in errors.splitlines() if "%" not in line],
                         ["patinate: error: interrupted; nothing half-written is left, and the same command finishes the work"])
        self.succeeds(*self.SYNTH)
        self.assertEqual(tree_of(self.folder / "out"), self.whole())
        self.assertFalse((self.folder / "out.partial").exists())

    def test_a_terminal_that_is_gone_is_an_interruption(self):
        code, errors = self.stopped(signal.SIGHUP)
        self.assertEqual((code, errors.count("interrupted")), (INTERRUPTED, 1), errors)
        self.assertEqual([str(p) for p in self.folder.rglob(".*.tmp*")], [])
        self.succeeds(*self.SYNTH)
        self.assertEqual(tree_of(self.folder / "out"), self.whole())

    def test_signals_that_are_ignored_from_the_start_stay_ignored(self):
        """As by nohup, and for what a script runs in the background."""
        def ignore():
            signal.signal(signal.SIGHUP, signal.SIG_IGN)
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        process = subprocess.Popen([self.patinate, *self.SYNTH], cwd=self.folder, stderr=subprocess.PIPE, text=True, preexec_fn=ignore)
        for _ in range(2000):
            if (self.folder / "out.partial/.job/done").exists():
                break
            time.sleep(0.01)
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, errors)
        self.assertTrue((self.folder / "out").exists())

    def test_stopped_at_any_moment_it_leaves_no_temporary_file(self):
        for delay in (0.05, 0.1, 0.2, 0.4, 0.7):
            process = subprocess.Popen([self.patinate, *self.SYNTH], cwd=self.folder, stderr=subprocess.PIPE, text=True)
            time.sleep(delay)
            process.send_signal(signal.SIGTERM)
            _, errors = process.communicate(timeout=60)
            if process.returncode == -signal.SIGTERM:
                continue  # before it listened
            self.assertEqual([str(p) for p in self.folder.rglob(".*.tmp*")], [])
            if process.returncode == 0:  # on a quick machine it was done before
                self.assertTrue((self.folder / "out").is_dir())
                break
            self.assertEqual((process.returncode, errors.count("interrupted")), (INTERRUPTED, 1), errors)

    def test_killed_several_times_it_ends_with_the_same_bytes(self):
        num_finished = []
        for _ in range(3):
            code, _ = self.stopped(signal.SIGKILL)
            self.assertEqual(code, -signal.SIGKILL)
            num_finished.append(len(list((self.folder / "out.partial/.job/done").glob("[!.]*"))))
        self.succeeds(*self.SYNTH)
        self.assertEqual(tree_of(self.folder / "out"), self.whole())


if __name__ == "__main__":
    unittest.main()
