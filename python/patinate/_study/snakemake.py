"""A study for Snakemake, and through it for Slurm."""
import os
import stat

from patinate import _native

from .folder import make_folder

# What rules of steps need that go in items.
ITEM_FUNCTIONS = r"""
# Steps whose plan (`plans/STEP/CELL.json`) is run item by item, in waves: a fit's generations, a transfer's passes. A
# wave begins when the one before is done. `--config items=8` runs eight items of a wave a job.
ITEMS = int(config.get("items", 1))


@functools.lru_cache(maxsize=None)
def waves(step, cell):
    plan = json.load(open(f"plans/{step}/{cell}.json"))
    return [[item["number"] for item in wave] for _, wave in itertools.groupby(plan["items"], key=lambda item: item["waits_for"])]


def items_of(step, cell, wave):
    numbers = waves(step, cell)[int(wave)]
    portions = [numbers[i:i + ITEMS] for i in range(0, len(numbers), ITEMS)]
    return [f"items/{step}/{cell}/{portion[0]}-{portion[-1]}" for portion in portions]


def wave_before(step, cell, items):
    first = int(items.split("-")[0])
    wave = next(i for i, numbers in enumerate(waves(step, cell)) if first in numbers)
    return [f"items/{step}/{cell}/wave{wave - 1}"] if wave > 0 else []


def last_wave(step, cell):
    return [f"items/{step}/{cell}/wave{len(waves(step, cell)) - 1}"] if waves(step, cell) else []

"""

HEAD = r"""# The study `@NAME`, made by `patinate study export`. Yours to read and to change.
#
#   snakemake --profile profiles/local    on the cores of this machine
#   snakemake --profile profiles/slurm    every step a job of Slurm
#
# What is done is not done again, here or elsewhere; a step that fails leaves out only what needs it.
# `--config patinate=/path/to/patinate` names the program, and `threads`, `mem_mb` and `runtime` (minutes) below are
# what a step asks for: change them, or set them in a profile (`set-resources`).
@IMPORTSimport json
import os

PATINATE = config.get("patinate", "patinate")
PARTS = json.load(open("cells.json"))["parts"]
# COMMANDS[STEP][CELL] is what makes it.
COMMANDS = {step["name"]: {cell["name"]: cell["commands"][step["name"]] for cell in part["cells"]}
            for part in PARTS for step in part["steps"]}
# A result that was removed is made again.
for part in PARTS:
    for step in part["steps"]:
        for cell in part["cells"]:
            done, made = f"done/{step['name']}/{cell['name']}", f"cells/{cell['name']}/{step['makes']}"
            if os.path.exists(done) and not os.path.exists(made):
                os.remove(done)


wildcard_constraints:
    cell="[A-Za-z0-9._-]+",

@FUNCTIONS
localrules:
    all,@WAVES


rule all:
    input:
        [f"done/{step}/{cell}" for step in COMMANDS for cell in COMMANDS[step]],


# One page on everything, also on what failed.
onsuccess:
    shell("{PATINATE} study report . --quiet")


onerror:
    shell("{PATINATE} study report . --quiet")
"""

# An item or some of a wave, the end of a wave, and the join. What failed is what the cell says.
ITEM_RULES = r"""

rule @STEP_items:
    input:
        lambda wildcards: wave_before("@STEP", wildcards.cell, wildcards.portion),
    output:
        touch("items/@STEP/{cell}/{portion,[0-9]+-[0-9]+}"),
    log:
        "logs/@STEP/items/{cell}/{portion}.txt",
    threads: 1
    resources:
        mem_mb=2000,
        runtime=60,
    shell:
        "{PATINATE} cluster run plans/@STEP/{wildcards.cell}.json --items {wildcards.portion} --quiet --threads {threads} 2> {log} || {{ cp {log} logs/@STEP/{wildcards.cell}.txt; exit 1; }}"


rule @STEP_wave:
    input:
        lambda wildcards: items_of("@STEP", wildcards.cell, wildcards.wave),
    output:
        touch("items/@STEP/{cell}/wave{wave,[0-9]+}"),


rule @STEP:
    input:
        lambda wildcards: last_wave("@STEP", wildcards.cell),
    output:
        touch("done/@STEP/{cell}"),
    log:
        "logs/@STEP/{cell}.txt",
@NEEDS    shell:
        "{PATINATE} cluster join plans/@STEP/{wildcards.cell}.json --quiet --threads {threads} 2> {log}"
"""

RULE = r"""

rule @STEP:
@INPUT    output:
        touch("done/@STEP/{cell}"),
    log:
        "logs/@STEP/{cell}.txt",
    params:
        command=lambda wildcards: COMMANDS["@STEP"][wildcards.cell],
@NEEDS    shell:
        "{PATINATE} cluster run {params.command} --force --quiet --threads {threads} 2> {log}"
"""

LOCAL_PROFILE = """# This machine. Without `cores: all` give --cores N.
cores: all
keep-going: true
rerun-incomplete: true
printshellcmds: false
"""

SLURM_PROFILE = """# Slurm. Partition, account and the like: `default-resources`, or in `cluster` below.
cluster: "sbatch --parsable --job-name=patinate-{rule} --cpus-per-task={threads} --mem={resources.mem_mb} --time={resources.runtime} --output=/dev/null"
cluster-status: "profiles/slurm/status.sh"
cluster-cancel: scancel
# Jobs that Slurm holds at a time, those that wait among them: one and a half times the cores or more, since an ended
# job is noticed some seconds later.
jobs: 100
keep-going: true
rerun-incomplete: true
# A step whose node was lost is run again; what it had finished is not.
restart-times: 2
# Seconds that a shared file system may take to show what another machine has made.
latency-wait: 60
max-jobs-per-second: 20
max-status-checks-per-second: 20
default-resources:
  - mem_mb=2000
  - runtime=60
"""

# Snakemake 8 and later read this file of the profile; the plug-in is snakemake-executor-plugin-cluster-generic.
SLURM_PROFILE_8 = SLURM_PROFILE.replace("\ncluster: ", "\nexecutor: cluster-generic\ncluster-generic-submit-cmd: ").replace(
    "\ncluster-status: ", "\ncluster-generic-status-cmd: ").replace("\ncluster-cancel: ", "\ncluster-generic-cancel-cmd: ").replace(
    "or in `cluster` below", "or in the command below").replace("\nmax-jobs-per-second: 20", "\nmax-jobs-per-timespan: 20/1s")

SLURM_STATUS = r"""#!/bin/sh
# What has become of a job, in Snakemake's words. `squeue` knows what waits and runs, `scontrol` what has just ended, and
# `sacct` the rest, where there is accounting. Nobody knowing counts as failed: the step is then run again, and finds
# what was finished.
state=$(squeue --noheader --states=all --format=%T --jobs="$1" 2>/dev/null | head -n 1)
[ -n "$state" ] || state=$(scontrol show job "$1" --oneliner 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p')
[ -n "$state" ] || state=$(sacct --noheader --allocations --parsable2 --format=State --jobs="$1" 2>/dev/null | head -n 1)
case "$state" in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED | RESIZING | SIGNALING | STAGE_OUT) echo running ;;
  *)
    # The controller may be away for a moment: only a controller that answers is believed.
    if [ -z "$state" ] && ! scontrol ping >/dev/null 2>&1; then echo running; else echo failed; fi ;;
esac
"""


def _needs(step):
    """What a step asks of a machine when nothing else is said."""
    threads, memory, minutes = (2, 4000, 240) if step.verb in ("transfer", "simulate") else (1, 2000, 60)
    return f"    threads: {threads}\n    resources:\n        mem_mb={memory},\n        runtime={minutes},\n"


def _filled(text, **values):
    for name, value in values.items():
        text = text.replace("@" + name, value)
    return text


def _rules(step, first):
    if step.in_items:
        return _filled(ITEM_RULES, STEP=step.name, NEEDS=_needs(step))
    waits = "" if step is first else f'    input:\n        "done/{first.name}/{{cell}}",\n'
    return _filled(RULE, STEP=step.name, INPUT=waits, NEEDS=_needs(step))


def write_snakefile(study):
    """Writes into a study's folder: `Snakefile`, and `profiles/local` and `profiles/slurm`."""
    in_items = [step for part in study.parts for step in part.steps if step.in_items]
    text = _filled(HEAD, IMPORTS="import functools\nimport itertools\n" * bool(in_items),
                   FUNCTIONS=ITEM_FUNCTIONS * bool(in_items),
                   WAVES="".join(f"\n    {step.name}_wave," for step in in_items), NAME=study.name)
    text += "".join(_rules(step, part.steps[0]) for part in study.parts for step in part.steps)
    _native._write(study.inside("Snakefile"), text)
    for name, file, profile in (("local", "config.yaml", LOCAL_PROFILE), ("slurm", "config.yaml", SLURM_PROFILE), ("slurm", "config.v8+.yaml", SLURM_PROFILE_8)):
        make_folder(study.inside("profiles", name))
        _native._write(study.inside("profiles", name, file), profile)
    status = study.inside("profiles", "slurm", "status.sh")
    _native._write(status, SLURM_STATUS)
    os.chmod(status, os.stat(status).st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
