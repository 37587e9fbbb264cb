"""Steps of a study as processes, on this machine."""
import concurrent.futures
import contextlib
import os
import subprocess
import threading

from patinate import _native

from .folder import ERROR_MARK, make_folder, shell_word

INTERRUPTED = 130  # Exit code of a command that was asked to stop.


class Processes:
    """Those that run, so that all can be asked to end."""

    def __init__(self):
        self.lock = threading.Lock()
        self.running = set()
        self.is_stopped = False

    def run(self, command, folder, log):
        """Gives a command to a shell in `folder`, with what it says on stderr in a file there and nothing on stdout, and
        waits. Gives the exit code."""
        with open(log, "wb") as messages, self.lock:
            if self.is_stopped:
                return INTERRUPTED
            # The process is the command's, for signals.
            process = subprocess.Popen(["/bin/sh", "-c", "exec " + command], cwd=folder, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=messages)
            self.running.add(process)
        code = process.wait()
        with self.lock:
            self.running.discard(process)
        return code if code >= 0 else 128 - code

    def stop(self):
        with self.lock:
            self.is_stopped = True
            for process in self.running:
                process.terminate()


def _run_cell(study, part, cell, program, num_threads, processes):
    """Runs the steps of one cell, until one fails. Gives its line, None if none does."""
    for step, command in zip(part.steps, cell.commands):
        done, log = study.done_file(step, cell), study.log_file(step, cell)
        with contextlib.suppress(FileNotFoundError):
            os.remove(done)
        code = processes.run(f"{shell_word(program)} cluster run {command} --force --quiet --threads {num_threads}",
                             study.path, log)
        if processes.is_stopped or code == INTERRUPTED:
            raise KeyboardInterrupt
        if code == 0:
            _native._write(done, "")
            continue
        message = study.failure(step, cell)
        if message is None:
            # Ended without a word, as by the kernel when memory is out.
            message = f"ended with exit code {code} and said nothing; was there enough memory?"
            with open(log, "a", encoding="utf-8") as file:
                file.write(f"{ERROR_MARK}{message}\n")
        return f"{cell.name}: {step.name}: {message}"
    return None


def run_study(study, program, num_jobs, num_threads, report):
    """Runs every step of every cell, `num_jobs` cells at a time. Steps that are done say so themselves, since only they
    know all that they depend on. After a step that fails the cell's others are left out, and the other cells go on.
    Gives the lines of the steps that failed. `report` takes fractions."""
    cells = study.cells()
    num_jobs = max(1, min(num_jobs, len(cells)))
    threads = max(1, num_threads // num_jobs)
    processes = Processes()
    with concurrent.futures.ThreadPoolExecutor(num_jobs) as pool:
        try:
            running = [pool.submit(_run_cell, study, part, cell, program, threads, processes) for part, cell in cells]
            for number, future in enumerate(concurrent.futures.as_completed(running), 1):
                future.result()
                report(number / len(cells))
        except BaseException:
            processes.stop()
            pool.shutdown(cancel_futures=True)
            raise
    return sorted(filter(None, (future.result() for future in running)))


def _write_plan(study, step, cell, command, program, processes):
    """Gives what is wrong, None if nothing."""
    plan, fresh = (f"plans/{step.name}/{name}" for name in (f"{cell.name}.json", f".{cell.name}.tmp"))
    code = processes.run(f"{shell_word(program)} cluster plan {command} --force --quiet --json > {shell_word(fresh)}",
                         study.path, study.log_file(step, cell))
    if code == INTERRUPTED:
        raise KeyboardInterrupt

    def forget(path):
        with contextlib.suppress(FileNotFoundError):
            os.remove(path)

    if code != 0:
        forget(study.inside(fresh))
        forget(study.done_file(step, cell))
        return study.failure(step, cell) or f"ended with exit code {code}"
    before = _native._load_json(study.inside(plan)).get("key", "") if os.path.isfile(study.inside(plan)) else ""
    if _native._load_json(study.inside(fresh)).get("key", "") != before:
        subprocess.run(["rm", "-rf", "--", study.inside("items", step.name, cell.name)], check=True)
        forget(study.done_file(step, cell))
    os.replace(study.inside(fresh), study.inside(plan))
    return None


def write_plans(study, program):
    """Plans of the steps that go in items. Gives what is wrong, a line each."""
    processes, problems = Processes(), []
    for part in study.parts:
        for number, step in enumerate(part.steps):
            if not step.in_items:
                continue
            make_folder(study.inside("plans", step.name))
            for cell in part.cells:
                problem = _write_plan(study, step, cell, cell.commands[number], program, processes)
                if problem:
                    problems.append(f"{cell.name}: {step.name}: {problem}")
    return problems
