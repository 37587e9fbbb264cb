#include "datasets_synthetic/object_io.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/geometry/mesh_io.h"
#include "libcommon/image/image_io.h"
#include "libcommon/job/job_inputs.h"

namespace patinate {

namespace fs = std::filesystem;

JobPlan plan_sculpture(const SculptureOptions& options, const fs::path& output) {
  check_ranges(options);
  JobInputs inputs("synth sculpture", 1);
  inputs.add_options(option_values(options));
  Json values;
  for (const auto& [name, value] : option_values(options)) values[name] = value;
  JobPlan plan = inputs.plan(output, "sculpture.json");
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj"}, .run = [options](const auto& folder, const RunControl&) {
                          write_obj(folder / "mesh.obj", sculpture(options));
                        }});
  plan.join = [values, key = plan.key](const fs::path& folder, const RunControl&) {
    save_json(folder / "sculpture.json",
              Json{{"mesh", "mesh.obj"}, {"unit", "mm"}, {"options", values}, {"key", key}});
  };
  return plan;
}

JobPlan plan_ledge(const LedgeOptions& options, const fs::path& output) {
  check_ranges(options);
  JobInputs inputs("synth ledge", 2);
  inputs.add_options(option_values(options));
  JobPlan plan = inputs.plan(output, "ledge.json");
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj", "scene.json"}, .run = [options](const auto& folder, const RunControl&) {
                          write_obj(folder / "mesh.obj", ledge(options));
                          write_atomically(folder / "scene.json", ledge_scene(options, "mesh.obj"));
                        }});
  plan.join = [key = plan.key](const fs::path& folder, const RunControl&) {
    save_json(folder / "ledge.json", Json{{"mesh", "mesh.obj"}, {"scene", "scene.json"}, {"unit", "mm"}, {"key", key}});
  };
  return plan;
}

JobPlan plan_fence(const FenceOptions& options, const fs::path& output) {
  check_ranges(options);
  JobInputs inputs("synth fence", 1);
  inputs.add_options(option_values(options));
  JobPlan plan = inputs.plan(output, "fence.json");
  plan.items.push_back({.name = "mesh", .outputs = {"mesh.obj", "grain.png", "scene.json"}, .run = [options](const auto& folder, const RunControl& control) {
                          write_obj(folder / "mesh.obj", fence(options));
                          write_srgb8(folder / "grain.png", fence_grain(options, control));
                          write_atomically(folder / "scene.json", fence_scene(options, "mesh.obj", "grain.png"));
                        }});
  plan.join = [key = plan.key](const fs::path& folder, const RunControl&) {
    save_json(folder / "fence.json", Json{{"mesh", "mesh.obj"}, {"scene", "scene.json"}, {"unit", "mm"}, {"key", key}});
  };
  return plan;
}

}  // namespace patinate
