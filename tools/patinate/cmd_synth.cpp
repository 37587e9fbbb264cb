#include <nlohmann/json.hpp>

#include "datasets_synthetic/crackle_io.h"
#include "datasets_synthetic/fence.h"
#include "datasets_synthetic/ledge.h"
#include "datasets_synthetic/mould_io.h"
#include "datasets_synthetic/sculpture.h"
#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_io.h"
#include "libcommon/image/image_io.h"
#include "libcommon/job/job_inputs.h"
#include "tools/patinate/commands.h"

namespace patinate {

namespace {

const std::vector<std::string> kKinds{"crackle", "fence", "ledge", "mould", "sculpture"};

JobPlan plan_sculpture(const SculptureOptions& options, const std::filesystem::path& output) {
  check_ranges(options);
  JobInputs inputs("synth sculpture", 1);
  inputs.add_options(option_values(options));
  Json values;
  for (const auto& [name, value] : option_values(options)) values[name] = value;
  JobPlan plan;
  plan.output = output;
  plan.manifest = "sculpture.json";
  plan.key = inputs.key();
  plan.depends_on = inputs.list();
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj"}, .run = [options](const auto& folder, const RunControl&) {
                          write_obj(folder / "mesh.obj", sculpture(options));
                        }});
  plan.join = [values, key = plan.key](const std::filesystem::path& folder, const RunControl&) {
    save_json(folder / "sculpture.json",
              Json{{"mesh", "mesh.obj"}, {"unit", "mm"}, {"options", values}, {"key", key}});
  };
  return plan;
}

JobPlan plan_ledge(const LedgeOptions& options, const std::filesystem::path& output) {
  check_ranges(options);
  JobInputs inputs("synth ledge", 2);
  inputs.add_options(option_values(options));
  JobPlan plan;
  plan.output = output;
  plan.manifest = "ledge.json";
  plan.key = inputs.key();
  plan.depends_on = inputs.list();
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj", "scene.json"}, .run = [options](const auto& folder, const RunControl&) {
                          write_obj(folder / "mesh.obj", ledge(options));
                          write_atomically(folder / "scene.json", ledge_scene(options, "mesh.obj"));
                        }});
  plan.join = [key = plan.key](const std::filesystem::path& folder, const RunControl&) {
    save_json(folder / "ledge.json", Json{{"mesh", "mesh.obj"}, {"scene", "scene.json"}, {"unit", "mm"}, {"key", key}});
  };
  return plan;
}

JobPlan plan_fence(const FenceOptions& options, const std::filesystem::path& output) {
  check_ranges(options);
  JobInputs inputs("synth fence", 1);
  inputs.add_options(option_values(options));
  JobPlan plan;
  plan.output = output;
  plan.manifest = "fence.json";
  plan.key = inputs.key();
  plan.depends_on = inputs.list();
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj", "grain.png", "scene.json"}, .run = [options](const auto& folder, const RunControl& control) {
                          write_obj(folder / "mesh.obj", fence(options));
                          write_srgb8(folder / "grain.png", fence_grain(options, control));
                          write_atomically(folder / "scene.json", fence_scene(options, "mesh.obj", "grain.png"));
                        }});
  plan.join = [key = plan.key](const std::filesystem::path& folder, const RunControl&) {
    save_json(folder / "fence.json", Json{{"mesh", "mesh.obj"}, {"scene", "scene.json"}, {"unit", "mm"}, {"key", key}});
  };
  return plan;
}

}  // namespace

int cmd_synth(CommandRun& run) {
  std::string kind;
  std::filesystem::path output;
  CrackleOptions crackle_options;
  FenceOptions fence_options;
  LedgeOptions ledge_options;
  MouldOptions mould_options;
  SculptureOptions sculpture_options;
  run.line.positional("KIND", "crackle (a capture project with its truth), mould (one of scans and lights, with its truth), ledge or fence (scenes to simulate) or sculpture (a mesh to age)", kind);
  run.line.choices(kKinds);
  run.line.output("FOLDER", "Folder to make", output);
  // Each kind has options of its own, so the kind decides what --help lists and what is accepted.
  const std::string asked = run.first_positional();
  if (asked == "crackle") run.line.options(crackle_options);
  if (asked == "fence") run.line.options(fence_options);
  if (asked == "ledge") run.line.options(ledge_options);
  if (asked == "mould") run.line.options(mould_options);
  if (asked == "sculpture") run.line.options(sculpture_options);
  run.line.example("synth crackle -o crackle");
  run.line.example("synth mould -o mould --exact");
  run.line.example("synth ledge -o ledge");
  run.line.example("synth ledge -o washed --weather soot");
  run.line.example("synth fence -o fence");
  run.line.example("synth crackle --help");
  if (!run.parse()) return 0;
  const JobPlan plan = kind == "crackle" ? plan_crackle(crackle_options, output)
                       : kind == "fence" ? plan_fence(fence_options, output)
                       : kind == "ledge" ? plan_ledge(ledge_options, output)
                       : kind == "mould" ? plan_mould(mould_options, output)
                                         : plan_sculpture(sculpture_options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "synth " + kind);
  if (status) run.report_output(*status, output);
  return 0;
}

}  // namespace patinate
