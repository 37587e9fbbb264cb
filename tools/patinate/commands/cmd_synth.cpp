#include <algorithm>
#include <functional>
#include <memory>

#include "datasets_synthetic/crackle_io.h"
#include "datasets_synthetic/drying_io.h"
#include "datasets_synthetic/dust_io.h"
#include "datasets_synthetic/edges.h"
#include "datasets_synthetic/mold_io.h"
#include "datasets_synthetic/object_io.h"
#include "datasets_synthetic/panel_io.h"
#include "datasets_synthetic/plate_io.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

/// A data set with options of its own.
struct Kind {
  std::string name;
  std::function<void(CommandLine&)> declare;
  std::function<JobPlan(const std::filesystem::path&)> plan;
};

template <class Options>
Kind kind_asked_for(std::string name, JobPlan (*plan)(const Options&, const std::filesystem::path&)) {
  const auto options = std::make_shared<Options>();
  return {std::move(name), [options](CommandLine& line) { line.options(*options); },
          [options, plan](const std::filesystem::path& output) { return plan(*options, output); }};
}

}  // namespace

int cmd_synth(CommandRun& run) {
  const std::vector<Kind> kinds{
      kind_asked_for("crackle", datasets::plan_crackle), kind_asked_for("drying", datasets::plan_drying),
      kind_asked_for("dust", datasets::plan_dust),       kind_asked_for("edges", datasets::plan_edges),
      kind_asked_for("fence", datasets::plan_fence),     kind_asked_for("ledge", datasets::plan_ledge),
      kind_asked_for("mold", datasets::plan_mold),       kind_asked_for("panel", datasets::plan_panel),
      kind_asked_for("plate", datasets::plan_plate),     kind_asked_for("sculpture", datasets::plan_sculpture)};
  std::string name;
  std::filesystem::path output;
  run.line.positional(
      "KIND",
      "crackle, drying, dust, edges, panel or plate (capture projects with their truth), mold (one of scans "
      "and lights, with its "
      "truth), ledge or fence (scenes to simulate) or sculpture (a mesh to age)",
      name);
  std::vector<std::string> names;
  for (const Kind& kind : kinds) names.push_back(kind.name);
  run.line.choices(names);
  run.line.output("FOLDER", "Folder to make", output);
  // The kind decides what --help lists and what is accepted.
  const auto find = [&kinds](const std::string& asked) {
    return std::find_if(kinds.begin(), kinds.end(), [&asked](const Kind& kind) { return kind.name == asked; });
  };
  if (const auto asked = find(run.first_positional()); asked != kinds.end()) asked->declare(run.line);
  run.line.usual({"width", "height", "num_frames", "size", "steps", "lights", "noise"});
  run.line.example("synth crackle -o crackle");
  run.line.example("synth drying -o drying --order thickness");
  run.line.example("synth dust -o dust --follows facing");
  run.line.example("synth mold -o mold --exact");
  run.line.example("synth panel -o panel --rust 3 --scribe --stains 2");
  run.line.example("synth plate -o plate --moving");
  run.line.example("synth ledge -o ledge");
  run.line.example("synth ledge -o washed --weather soot");
  run.line.example("synth fence -o fence");
  run.line.example("synth crackle --help");
  if (!run.parse()) return 0;
  const std::optional<JobStatus> status = run.make_folder(find(name)->plan(output), "synth " + name);
  if (status) run.report_output(*status, output);
  return 0;
}

}  // namespace patinate::cli
