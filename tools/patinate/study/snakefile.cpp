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

std::string wave_rule(const StudyStep& step) { return step.name + "_wave"; }

std::string wave_rules(const StudyFolder& study) {
  std::string text;
  for (const PlacedPart& part : study.parts) {
    for (const StudyStep& step : part.steps) {
      if (step.in_items) text += "\n    " + wave_rule(step) + ",";
    }
  }
  return text;
}
bool has_items(const StudyFolder& study) { return !wave_rules(study).empty(); }

/// What rules of steps need that go in items.
constexpr const char* kItemFunctions = R"(
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

)";

std::string head_text(const StudyFolder& study) {
  return "# The study `" + study.name + R"(`, made by `patinate study export`. Yours to read and to change.
#
#   snakemake --profile profiles/local    on the cores of this machine
#   snakemake --profile profiles/slurm    every step a job of Slurm
#
# What is done is not done again, here or elsewhere; a step that fails leaves out only what needs it.
# `--config patinate=/path/to/patinate` names the program, and `threads`, `mem_mb` and `runtime` (minutes) below are
# what a step asks for: change them, or set them in a profile (`set-resources`).
)" + std::string(has_items(study) ? "import functools\nimport itertools\n" : "") +
         R"(import json

PATINATE = config.get("patinate", "patinate")
PARTS = json.load(open("cells.json"))["parts"]
# COMMANDS[STEP][CELL] is what makes it.
COMMANDS = {step["name"]: {cell["name"]: cell["commands"][step["name"]] for cell in part["cells"]}
            for part in PARTS for step in part["steps"]}


wildcard_constraints:
    cell="[A-Za-z0-9._-]+",

)" + (has_items(study) ? kItemFunctions : "") +
         R"(
localrules:
    all,)" +
         wave_rules(study) + R"(


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

std::string needs_text(const StepNeeds& needs) {
  return "    threads: " + std::to_string(needs.threads) +
         "\n    resources:\n        mem_mb=" + std::to_string(needs.memory_mb) +
         ",\n        runtime=" + std::to_string(needs.minutes) + ",\n";
}

/// An item or some of a wave, the end of a wave, and the join.
std::string item_rules_text(const StudyStep& step) {
  const std::string of = "\"" + step.name + "\", wildcards.cell";
  const std::string made = "items/" + step.name + "/{cell}/", plan = "plans/" + step.name + "/{wildcards.cell}.json";
  std::string text = "\n\nrule " + step.name + "_items:\n    input:\n        lambda wildcards: wave_before(" + of +
                     ", wildcards.portion),\n    output:\n        touch(\"" + made +
                     "{portion,[0-9]+-[0-9]+}\"),\n    log:\n        \"logs/" + step.name +
                     "/items/{cell}/{portion}.txt\",\n";
  text += needs_text({});
  // What failed is what the cell says.
  text += "    shell:\n        \"{PATINATE} run " + plan +
          " --items {wildcards.portion} --quiet --threads {threads} 2> {log} || {{ cp {log} logs/" + step.name +
          "/{wildcards.cell}.txt; exit 1; }}\"\n";
  text += "\n\nrule " + wave_rule(step) + ":\n    input:\n        lambda wildcards: items_of(" + of +
          ", wildcards.wave),\n    output:\n        touch(\"" + made + "wave{wave,[0-9]+}\"),\n";
  text += "\n\nrule " + step.name + ":\n    input:\n        lambda wildcards: last_wave(" + of +
          "),\n    output:\n        touch(\"done/" + step.name + "/{cell}\"),\n    log:\n        \"logs/" + step.name +
          "/{cell}.txt\",\n";
  return text + needs_text(needs_of(step)) + "    shell:\n        \"{PATINATE} join " + plan +
         " --quiet --threads {threads} 2> {log}\"\n";
}

std::string rule_text(const StudyStep& step, const StudyStep& first) {
  std::string text = "\n\nrule " + step.name + ":\n";
  if (step.name != first.name) text += "    input:\n        \"done/" + first.name + "/{cell}\",\n";
  text += "    output:\n        touch(\"done/" + step.name + "/{cell}\"),\n";
  text += "    log:\n        \"logs/" + step.name + "/{cell}.txt\",\n";
  text += "    params:\n        command=lambda wildcards: COMMANDS[\"" + step.name + "\"][wildcards.cell],\n";
  return text + needs_text(needs_of(step)) +
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
    for (const StudyStep& step : part.steps)
      text += step.in_items ? item_rules_text(step) : rule_text(step, part.steps.front());
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
