#include "capture/unlighting/unlight_job.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/unlighting/leave_one_out.h"
#include "capture/unlighting/response_check.h"
#include "capture/unlighting/unlight_report.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

const char* lobe_name(const SpecularForm& form) {
  return form.is_rendered ? "ggx" : std::isinf(form.tail) ? "beckmann" : form.tail == 2.0 ? "ggx" : "student";
}

constexpr std::int64_t kUnlightVersion = 2;
constexpr const char* kFactsFile = ".job/work/unlight.json";

UnlitDocument facts_of(const UnlightStep& step, const UnlightResult& result,
                       const std::vector<LeaveOneOutError>& predicted) {
  UnlitDocument d{
      .name = step.name,
      .width = result.albedo.width(),
      .height = result.albedo.height(),
      .channels = result.albedo.channels(),
      .maps = {{"albedo", "albedo.exr"}, {"stddev", "stddev.exr"}, {"normal", "normal.exr"}, {"mask", "mask.png"}},
      .materials = {},
      .num_surface = result.num_surface,
      .num_determined = result.num_determined,
      .residual = result.residual,
      .noise_scale = result.noise_scale,
      .is_absolute = step.are_strengths_known(),
      .is_converged = result.is_converged,
      .ambient = result.ambient,
      .interreflection = result.interreflection,
      .lobe = {},
      .lobe_form = {},
      .lights = {},
      .notes = result.notes,
      .key = ""};
  if (!result.specular.empty()) {
    const SpecularForm& form = result.form;
    d.maps.push_back({"specular", "specular.exr"});
    d.lobe = lobe_name(form);
    d.lobe_form = UnlitLobe{.tail = std::isinf(form.tail) ? std::nullopt : std::optional(form.tail),
                            .slant = form.slant,
                            .is_about_mirror = form.is_about_mirror,
                            .tint = form.tint};
  }
  if (!result.reflectance.empty()) {
    d.maps.push_back({"reflectance", "reflectance.exr"});
    d.maps.push_back({"metalness", "metalness.exr"});
    d.materials = result.materials;
  }
  for (std::size_t k = 0; k < result.lights.size(); ++k)
    d.lights.push_back({step.lights[k].name, result.lights[k], predicted[k]});
  return d;
}

void add_step_notes(const UnlightStep& step, const UnlightOptions& options, const UnlightScene& scene,
                    UnlightResult& result, const RunControl& control) {
  if (!step.are_strengths_known()) {
    result.notes.emplace_back(options.estimate_strengths
                                  ? "the lights' file gives no strengths: albedo has a scale of its own"
                                  : "the lights' file gives no strengths: they are taken as equal (--strengths finds "
                                    "them), and albedo has a scale of its own");
  }
  if (!step.has_codes) return;
  const ResponseCheck check = check_response(scene.input, scene.ambient, step.response, control);
  if (!check.is_doubtful) return;
  const bool is_linear = step.response.kind == Response::Kind::Linear;
  // Files without a statement are sRGB.
  const std::string declared = step.response.kind == Response::Kind::File ? "srgb" : step.response.text();
  result.notes.push_back("`response` is " + declared + ", but decoded as " + (is_linear ? "srgb" : "linear") +
                         " the photographs agree much better with the lamps (" + percent_text(check.otherwise, 2) +
                         " off, against " + percent_text(check.as_declared, 2) + "); check it");
}

void run_item(const UnlightStep& step, const UnlightOptions& options, const fs::path& folder,
              const RunControl& control) {
  const UnlightScene scene = load_unlight_scene(step, control.part(0.0, 0.2));
  UnlightResult result = unlight(scene.input, options, control.part(0.2, 0.8));
  const std::vector<LeaveOneOutError> predicted = leave_one_out(scene.input, options, result, control.part(0.8, 0.9));
  add_step_notes(step, options, scene, result, control.part(0.9, 0.95));
  const std::vector<std::string> color =
      result.albedo.channels() == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  write_exr(folder / "albedo.exr", result.albedo, color, ExrDepth::Float);
  write_exr(folder / "stddev.exr", result.stddev, color, ExrDepth::Float);
  write_exr(folder / "normal.exr", result.normal, {"X", "Y", "Z"}, ExrDepth::Float);
  if (!result.specular.empty())
    write_exr(folder / "specular.exr", result.specular, {"strength", "roughness"}, ExrDepth::Float);
  if (!result.reflectance.empty()) {
    write_exr(folder / "reflectance.exr", result.reflectance, {"R", "G", "B"}, ExrDepth::Float);
    write_exr(folder / "metalness.exr", result.metalness, {"Y"}, ExrDepth::Float);
  }
  write_codes(folder / "mask.png", result.mask);
  const Eigen::Matrix3d camera_from_world =
      step.camera_mm ? step.camera_mm->parameters().rotation : Eigen::Matrix3d(Vec3(1, -1, -1).asDiagonal());
  write_unlight_report(folder, step.name, scene.input, result, predicted, camera_from_world);
  fs::create_directories((folder / kFactsFile).parent_path());
  save_json(folder / kFactsFile, unlit_json(facts_of(step, result, predicted)));
  control.report(1.0);
}

JobInputs inputs_of(const UnlightStep& step, const UnlightOptions& options) {
  JobInputs inputs = JobInputs::counted_without_names("unlight");
  inputs.add_value("version of unlight", std::to_string(kUnlightVersion));
  const auto add_file = [&](const char* what, const fs::path& file) {
    inputs.add_value(what + file.filename().string(), hash_file(file));
  };
  for (const fs::path& photo : step.photos) add_file("", photo);
  if (step.ambient) add_file("ambient ", *step.ambient);
  if (step.mask) add_file("mask ", *step.mask);
  if (step.scan) add_file("scan ", *step.scan);
  inputs.add_value("name", step.name)
      .add_value("response", step.response.text())
      .add_value("unit", number_text(step.mm_per_unit) + " mm")
      .add_value("lights", ContentHash().add(json_of(step.lights).dump()).hex())
      .add_value("camera", step.camera_mm ? ContentHash().add(step.camera_mm->text()).hex() : "none")
      .add_options(key_values(options));
  return inputs;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> key_values(const UnlightOptions& options) {
  auto values = option_values(options);
  if (!options.interreflection) std::erase_if(values, [](const auto& v) { return v.first == "interreflection"; });
  return values;
}

JobPlan plan_unlight(const UnlightStep& step, const UnlightOptions& options, const fs::path& output) {
  check_ranges(options);
  JobPlan plan = inputs_of(step, options).plan(output, kUnlitManifestFile);
  plan.parallel_items = false;
  JobItem item{.name = "unlight",
               .outputs = {"albedo.exr", "stddev.exr", "normal.exr", "mask.png", "albedo.png", "normal.png",
                           "stddev.png", kUnlitPageFile, kFactsFile},
               .run = {}};
  if (options.specular != SpecularMode::None) item.outputs.insert(item.outputs.end(), {"specular.exr", "specular.png"});
  if (options.specular == SpecularMode::Material)
    item.outputs.insert(item.outputs.end(), {"reflectance.exr", "metalness.exr"});
  for (std::size_t k = 0; k < step.photos.size(); ++k) item.outputs.emplace_back(samples_file(k));
  item.run = [step, options](const fs::path& folder, const RunControl& control) {
    run_item(step, options, folder, control);
  };
  plan.items.push_back(std::move(item));
  plan.join = [key = plan.key](const fs::path& folder, const RunControl&) {
    Json json = load_json(folder / kFactsFile);
    json["key"] = key;
    save_json(folder / kUnlitManifestFile, json);
  };
  return plan;
}

}  // namespace patinate::capture
