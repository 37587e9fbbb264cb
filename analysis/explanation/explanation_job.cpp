#include "analysis/explanation/explanation_job.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/explanation/explanation_report.h"
#include "analysis/explanation/surface_places.h"
#include "libcommon/controls/control_expression.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 1;  ///< Raised when the same input gives other figures.

fs::path values_file(std::size_t i) { return fs::path(kJobWorkFolder) / ("control" + std::to_string(i) + ".exr"); }
fs::path facts_file(std::size_t i) { return fs::path(kJobWorkFolder) / ("control" + std::to_string(i) + ".json"); }

/// Leaves the map, or why there is none.
void make_item(const ExplanationTask& task, std::size_t i, const fs::path& folder, const RunControl& control) {
  fs::create_directories(folder / kJobWorkFolder);
  const ExplainingControl& wanted = task.controls[i];
  ControlMap made;
  std::string problem;
  try {
    made = wanted.make(control);
  } catch (const InvalidInput& e) {
    if (!wanted.may_fail) throw;
    problem = e.what();
    made.values = ImageF(1, 1);
  }
  write_exr(folder / values_file(i), made.values, {"Y"}, ExrDepth::Float);
  save_json(folder / facts_file(i),
            Json{{"low", made.low}, {"high", made.high}, {"unit", made.unit}, {"problem", problem}});
}

MadeControl read_item(const ExplanationTask& task, std::size_t i, const fs::path& folder) {
  const Json json = load_json(folder / facts_file(i));
  return {.name = task.controls[i].name,
          .map = {.values = read_gray(folder / values_file(i), "Y"),
                  .low = json.at("low"),
                  .high = json.at("high"),
                  .unit = json.at("unit")},
          .problem = json.at("problem")};
}

std::string message_without_subject(std::string text) {
  constexpr std::string_view kSubject = "explain: ";
  return text.starts_with(kSubject) ? text.substr(kSubject.size()) : text;
}

void check_task(const ExplanationTask& task) {
  check_ranges(task.options);
  check_shuffles(task.options, task.controls.size());
  if (task.controls.empty()) throw InvalidInput("there is no control to explain it with");
  std::set<std::string> names;
  for (const ExplainingControl& c : task.controls) {
    if (!names.insert(c.name).second) throw InvalidInput("the control `" + c.name + "` is given twice");
  }
  const SurfaceReference& reference = task.reference;
  if (reference.values.width() != task.map->width() || reference.values.height() != task.map->height())
    throw InvalidInput(reference.name + ": is " + size_text(reference.values.width(), reference.values.height()) +
                       ", the atlas " + size_text(task.map->width(), task.map->height()));
  const SurfacePlaces places = surface_places(*task.map, reference.mask, task.options.num_samples);
  if (places.texels.size() < kFewestPlaces)
    throw InvalidInput(reference.name + ": " + std::to_string(places.texels.size()) + " texels of " + task.mesh_name +
                       " are known; at least " + std::to_string(kFewestPlaces) + " are needed");
  const std::vector<double> values = places.values_of(reference.values);
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (!(*greatest > *least))
    throw InvalidInput(reference.name + ": is the same everywhere on " + task.mesh_name +
                       ": there is nothing to explain");
}

/// Checks the mix with transfer's own parser. @throws InvalidInput if that reads it differently.
void check_expression(const Explanation& found, const std::vector<MadeControl>& controls, const TexelMap& map,
                      const SurfacePlaces& places, const ExplanationInput& input) {
  if (found.mix.members.empty()) return;
  // Candidates that are expressions themselves are taken as they are parsed.
  const ControlExpression parsed(found.mix.expression, control_kind_names());
  const bool is_known = std::all_of(parsed.names().begin(), parsed.names().end(), [&](const ControlName& n) {
    return std::any_of(controls.begin(), controls.end(), [&](const MadeControl& c) { return c.name == n.text; });
  });
  if (!is_known) return;
  const ControlMap mixed = parsed.evaluate(map.coverage(), [&](const ControlName& name) {
    return std::find_if(controls.begin(), controls.end(), [&](const MadeControl& c) { return c.name == name.text; })
        ->map;
  });
  const std::vector<double> values = places.values_of(mixed.values);
  constexpr double kRounding = 1e-5;  // Rounding of a few floats of [0, 1].
  for (std::size_t i = 0; i < values.size(); ++i) {
    double expected = 0.0;
    for (const MixMember& m : found.mix.members) {
      const double v = input.candidates[m.candidate].values[i];
      expected += m.weight * (m.is_inverse ? 1.0 - v : v);
    }
    if (!(std::abs(values[i] - expected) < kRounding))
      throw InvalidInput("explain: the expression `" + found.mix.expression + "` does not give the mix");
  }
}

void join(const ExplanationTask& task, const std::string& key, const fs::path& folder, const RunControl& control) {
  std::vector<MadeControl> controls, skipped;
  for (std::size_t i = 0; i < task.controls.size(); ++i) {
    MadeControl made = read_item(task, i, folder);
    (made.problem.empty() ? controls : skipped).push_back(std::move(made));
  }
  const SurfacePlaces places = surface_places(*task.map, task.reference.mask, task.options.num_samples);
  ExplanationInput input{.positions_mm = places.positions_mm,
                         .area_mm2 = places.area_mm2,
                         .reference = places.values_of(task.reference.values),
                         .candidates = {}};
  for (const MadeControl& c : controls) input.candidates.push_back({c.name, places.values_of(c.map.values)});
  Explanation found;
  try {
    found = explain(input, task.options, task.seed, control.part(0.0, 0.6));
  } catch (const InvalidInput& e) {
    throw InvalidInput(task.reference.name + ": " + message_without_subject(e.what()));
  }
  check_expression(found, controls, *task.map, places, input);
  write_explanation(
      folder, {.task = task, .found = found, .input = input, .controls = controls, .skipped = skipped, .key = key},
      control.part(0.6, 1.0));
}

}  // namespace

JobPlan plan_explanation(ExplanationTask task, const fs::path& output) {
  check_task(task);
  JobInputs inputs("explain", kStageVersion);
  inputs.add_content("reference", task.reference.name, task.reference.key);
  inputs.add_content("mesh", task.mesh_name, task.mesh_key);
  inputs.add_value("--resolution", size_text(task.map->width(), task.map->height()));
  for (const ExplainingControl& c : task.controls) inputs.add_content("control", c.name, c.key);
  inputs.add_options(option_values(task.options));
  inputs.add_value("--seed", std::to_string(task.seed));
  JobPlan plan = inputs.plan(output, kExplanationFile);
  plan.parallel_items = false;
  const auto shared = std::make_shared<const ExplanationTask>(std::move(task));
  for (std::size_t i = 0; i < shared->controls.size(); ++i) {
    plan.items.push_back({.name = "control" + std::to_string(i),
                          .outputs = {values_file(i), facts_file(i)},
                          .run = [shared, i](const fs::path& folder,
                                             const RunControl& control) { make_item(*shared, i, folder, control); },
                          .key = shared->controls[i].key});
  }
  plan.join_weight = 2.0;
  plan.join = [shared, key = plan.key](const fs::path& folder, const RunControl& control) {
    join(*shared, key, folder, control);
  };
  return plan;
}

}  // namespace patinate::analysis
