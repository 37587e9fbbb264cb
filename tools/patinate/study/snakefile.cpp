#include "tools/patinate/study/snakefile.h"

#include <filesystem>
#include <string>

#include "libcommon/core/files.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// What a step asks of a machine when nothing else is said.
struct StepNeeds {
  int threads = 1;
  int memory_mb = 2000;
  int minutes = 60;
};

StepNeeds needs_of(const StudyStep& step) {
  if (step.verb == "transfer" || step.verb == "simulate") return {.threads = 2, .memory_mb = 4000, .minutes = 240};
  return {};
}

std::string head_text(const StudyFolder& study) {
  return "# The study `" + study.name + R"(`, made by `patinate study export`. Yours to read and to change.
#
#   snakemake --profile profiles/local    on the cores of this machine
#   snakemake --profile profiles/slurm    every step a job of Slurm
#
# What is done is not done again, here or elsewhere; a step that fails leaves out only what needs it.
# `--config patinate=/path/to/patinate` names the program, and `threads`, `mem_mb` and `runtime` (minutes) below are
# what a step asks for: change them, or set them in a profile (`set-resources`).
import json

PATINATE = config.get("patinate", "patinate")
PARTS = json.load(open("cells.json"))["parts"]
# COMMANDS[STEP][CELL] is what makes it.
COMMANDS = {step["name"]: {cell["name"]: cell["commands"][step["name"]] for cell in part["cells"]}
            for part in PARTS for step in part["steps"]}


wildcard_constraints:
    cell="[A-Za-z0-9._-]+",


localrules:
    all,


rule all:
    input:
        [f"done/{step}/{cell}" for step in COMMANDS for cell in COMMANDS[step]],


# One page on everything, also on what failed.
onsuccess:
    shell("{PATINATE} study report . --quiet")


onerror:
    shell("{PATINATE} study report . --quiet")
)";
}

std::string rule_text(const StudyStep& step, const StudyStep& first) {
  const StepNeeds needs = needs_of(step);
  std::string text = "\n\nrule " + step.name + ":\n";
  if (step.name != first.name) text += "    input:\n        \"done/" + first.name + "/{cell}\",\n";
  text += "    output:\n        touch(\"done/" + step.name + "/{cell}\"),\n";
  text += "    log:\n        \"logs/" + step.name + "/{cell}.txt\",\n";
  text += "    params:\n        command=lambda wildcards: COMMANDS[\"" + step.name + "\"][wildcards.cell],\n";
  text += "    threads: " + std::to_string(needs.threads) + "\n";
  text += "    resources:\n        mem_mb=" + std::to_string(needs.memory_mb) +
          ",\n        runtime=" + std::to_string(needs.minutes) + ",\n";
  return text +
         "    shell:\n        \"{PATINATE} run {params.command} --force --quiet --threads {threads} 2> {log}\"\n";
}

constexpr const char* kLocalProfile = R"(# This machine. Without `cores: all` give --cores N.
cores: all
keep-going: true
rerun-incomplete: true
printshellcmds: false
)";

constexpr const char* kSlurmProfile =
    R"(# Slurm. Partition, account and the like: `default-resources`, or in `cluster` below.
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
)";

constexpr const char* kSlurmStatus = R"(#!/bin/sh
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
)";

void write_profile(const fs::path& folder, const char* config) {
  fs::create_directories(folder);
  write_atomically(folder / "config.yaml", config);
}

}  // namespace

void write_snakefile(const StudyFolder& study) {
  std::string text = head_text(study);
  for (const PlacedPart& part : study.parts) {
    for (const StudyStep& step : part.steps) text += rule_text(step, part.steps.front());
  }
  write_atomically(study.path / "Snakefile", text);
  write_profile(study.path / "profiles" / "local", kLocalProfile);
  write_profile(study.path / "profiles" / "slurm", kSlurmProfile);
  const fs::path status = study.path / "profiles" / "slurm" / "status.sh";
  write_atomically(status, kSlurmStatus);
  fs::permissions(status, fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                  fs::perm_options::add);
}

}  // namespace patinate::cli
