#include "datasets_synthetic/object_io.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "datasets_synthetic/project_io.h"
#include "libcommon/core/files.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

using MakeFiles = std::function<void(const fs::path& folder, const RunControl& control)>;

/// One item that makes all files, and `KIND.json` with `about` and the key.
template <class Options>
JobPlan plan_object(const std::string& kind, std::int64_t version, const Options& options, const fs::path& output,
                    std::vector<fs::path> files, MakeFiles make, Json about) {
  check_ranges(options);
  JobInputs inputs("synth " + kind, version);
  inputs.add_options(option_values(options));
  about["mesh"] = "mesh.obj";
  about["unit"] = "mm";
  JobPlan plan = plan_project(inputs, output, {{kind + ".json", [about](const RunControl&) { return about; }}});
  plan.items.push_back({.name = "mesh", .outputs = std::move(files), .run = std::move(make)});
  return plan;
}

}  // namespace

JobPlan plan_sculpture(const SculptureOptions& options, const fs::path& output) {
  Json values;
  for (const auto& [name, value] : option_values(options)) values[name] = value;
  return plan_object(
      "sculpture", 1, options, output, {"mesh.obj"},
      [options](const fs::path& folder, const RunControl&) { write_obj(folder / "mesh.obj", sculpture(options)); },
      {{"options", values}});
}

JobPlan plan_ledge(const LedgeOptions& options, const fs::path& output) {
  return plan_object("ledge", 3, options, output, {"mesh.obj", "scene.json"},
                     [options](const fs::path& folder, const RunControl&) {
                       write_obj(folder / "mesh.obj", ledge(options));
                       write_atomically(folder / "scene.json", ledge_scene(options, "mesh.obj"));
                     },
                     {{"scene", "scene.json"}});
}

JobPlan plan_fence(const FenceOptions& options, const fs::path& output) {
  return plan_object("fence", 2, options, output, {"mesh.obj", "grain.png", "scene.json"},
                     [options](const fs::path& folder, const RunControl& control) {
                       write_obj(folder / "mesh.obj", fence(options));
                       write_srgb8(folder / "grain.png", fence_grain(options, control));
                       write_atomically(folder / "scene.json", fence_scene(options, "mesh.obj", "grain.png"));
                     },
                     {{"scene", "scene.json"}});
}

}  // namespace patinate::datasets
