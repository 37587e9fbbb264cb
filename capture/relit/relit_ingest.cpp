#include "capture/relit/relit_ingest.h"

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/project/sample_facts.h"
#include "capture/relit/relit_work.h"
#include "capture/unlighting/unlight_job.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/controls/accessibility.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 6;
constexpr std::int64_t kRelitPageVersion = 1;  ///< Version of the page.
constexpr double kStepWeight = 4.0;            ///< For progress: light is taken out more slowly than a scan is placed.
constexpr std::array<std::string_view, 2> kRelitPosesNames{"joint", "each"};
constexpr const char* kAccessibility = "accessibility";

fs::path report_file(const char* name, std::size_t index, const char* extension) {
  return fs::path("report") / (name + ("_" + zero_padded(index, 4)) + extension);
}

std::string transform_text(const std::optional<RigidTransform>& transform) {
  if (!transform) return "none";
  std::string text;
  const Eigen::Matrix4d matrix = transform->matrix();
  for (Eigen::Index r = 0; r < 3; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c) text += number_text(matrix(r, c)) + " ";
  }
  return text;
}

std::string vector_text(const Vec3& v) {
  return number_text(v.x()) + " " + number_text(v.y()) + " " + number_text(v.z());
}

std::string rig_text(const RelitProject& project) {
  std::string text = project.camera_mm.text();
  for (const Light& light : project.lights) {
    text += light.kind == Light::Kind::Near ? "\nnear " + vector_text(light.position)
                                            : "\ndirectional " + vector_text(light.direction);
    text += " " + vector_text(light.intensity);
  }
  if (project.patch) {
    text += "\npatch " + vector_text(project.patch->albedo);
    for (const Vec2& corner : project.patch->polygon)
      text += " " + number_text(corner.x()) + " " + number_text(corner.y());
  }
  return text;
}

/// Content of a step's files, and what the project says about it.
std::string step_key(const RelitProject& project, const RelitStep& step) {
  ContentHash hash;
  hash.add(number_text(project.mm_per_unit)).add(project.response.text());
  const auto add_file = [&](const char* role, const std::optional<fs::path>& file) {
    hash.add(role);
    if (file) hash.add_file(*file);
  };
  add_file("scan", step.scan);
  for (const fs::path& photo : step.photos) add_file("photo", photo);
  add_file("ambient", step.ambient);
  if (step.ready) {
    add_file("albedo", step.ready->albedo);
    add_file("position", step.ready->position);
    add_file("normal", step.ready->normal);
  }
  hash.add(transform_text(step.reference_from_scan)).add(transform_text(step.initial));
  hash.add(std::int64_t{step.is_from_registration});
  return hash.hex();
}

/// Key of what the frame of a step depends on, but for the step itself.
std::string common_key(const RelitWork& work) {
  ContentHash hash;
  hash.add("relit").add(kStageVersion).add(rig_text(work.project)).add(work.step_keys[work.project.reference]);
  hash.add(std::int64_t{work.options.accept_failed});
  if (work.options.heights) hash.add("heights");
  for (const auto& [name, value] : option_values(work.options.registration)) hash.add(name).add(value);
  for (const auto& [name, value] : key_values(work.options.unlight)) hash.add(name).add(value);
  return hash.hex();
}

/// Key of what all jointly solved poses depend on; "" where there are none.
std::string key_of_joint(const RelitWork& work, const std::vector<std::size_t>& steps, const std::string& common) {
  if (steps.empty()) return "";
  ContentHash hash;
  hash.add("joint poses").add(common);
  for (const std::size_t i : steps) hash.add(work.step_keys[i]);
  return hash.hex();
}

JobInputs inputs_of(const RelitWork& work) {
  const RelitProject& project = work.project;
  JobInputs inputs = JobInputs::counted_without_names("ingest relit");
  inputs.add_value("version of ingest", std::to_string(kStageVersion))
      .add_value("version of report.html", std::to_string(kRelitPageVersion))
      .add_value("name", project.name)
      .add_value("time_unit", time_unit_text(project.time_unit))
      .add_value("response", project.response.text())
      .add_value("unit", number_text(project.mm_per_unit) + " mm")
      .add_value("camera, lights and patch", ContentHash().add(rig_text(project)).hex())
      .add_value("reference", std::to_string(project.reference));
  for (std::size_t i = 0; i < project.steps.size(); ++i) {
    inputs.add_value(work.step_name(i), work.step_keys[i]);
    inputs.add_value("time of " + work.step_name(i), number_text(project.steps[i].time));
  }
  if (!project.sample.empty()) inputs.add_value("sample", sample_text(project.sample));
  inputs.add_options(option_values(work.options.registration));
  inputs.add_options(key_values(work.options.unlight));
  inputs.add_options(option_values(work.options.scan));
  inputs.add_options(option_values(work.options.fill));
  inputs.add_options(option_values(work.options.progress));
  inputs.add_value("--poses", std::string(kRelitPosesNames[static_cast<std::size_t>(work.options.poses)]));
  if (work.options.heights) inputs.add_value("--heights", "true");
  inputs.add_value("--accept-failed", work.options.accept_failed ? "true" : "false");
  return inputs;
}

/// Masks and fills the frames that are in the history, and names everything. @returns the mask.
ImageU8 write_frames(HistoryWriter& writer, const RelitWork& work, const fs::path& folder,
                     const std::vector<std::size_t>& kept, const RunControl& control) {
  std::vector<double> times;
  for (std::size_t i : kept) times.push_back(work.project.steps[i].time);
  const ImageU8& surface = work.reference(folder).view.seen;
  const auto read_validity = [&](int k) {
    ImageU8 validity = read_mask(folder / relit_validity_file(kept[k]));
    for (std::uint8_t& v : validity.values())
      v = static_cast<std::uint8_t>(v != 0 ? Validity::Valid : Validity::OutOfView);
    return validity;
  };
  const auto read_frame = [&](int k) {
    return read_color(folder / HistoryWriter::frame_file(static_cast<int>(kept[k])));
  };
  const FillPlan plan = plan_fill(times, read_validity, work.options.fill, control.part(0.0, 0.3));
  ImageU8 inside = plan.inside;
  std::int64_t num_inside = 0;
  for (std::int64_t p = 0; p < inside.num_pixels(); ++p) {
    if (surface.data()[p] == 0) inside.data()[p] = 0;
    num_inside += inside.data()[p] != 0;
  }
  if (num_inside == 0) {
    throw IoError(work.project.file.string(),
                  "no texel is determined in every step: each is hidden, in shadow or saturated in some; leave steps "
                  "out (\"exclude\": true)");
  }
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const int index = static_cast<int>(kept[k]);
    writer.add_written_frame(index, times[k]);
    // The mask of the history says what is no surface; a frame's own only what it does not show of that.
    ImageU8 mask = read_validity(static_cast<int>(k));
    bool is_whole = true;
    for (std::int64_t p = 0; p < mask.num_pixels(); ++p) {
      mask.data()[p] = mask.data()[p] != 0 || inside.data()[p] == 0 ? 255 : 0;
      is_whole = is_whole && mask.data()[p] != 0;
    }
    if (!is_whole) {
      fs::create_directories((folder / HistoryWriter::frame_mask_file(index)).parent_path());
      write_codes(folder / HistoryWriter::frame_mask_file(index), mask);
      writer.add_written_frame_mask(index);
    }
    for (const std::string& extra : relit_frame_extras(work)) writer.add_written_frame_extra(index, extra);
    if (plan.needs_fill[k] == 0) continue;
    const ImageF filled = fill_frame(static_cast<int>(k), times, plan, read_validity, read_frame);
    fs::create_directories((folder / HistoryWriter::filled_frame_file(index)).parent_path());
    write_exr(folder / HistoryWriter::filled_frame_file(index), filled, {"R", "G", "B"}, ExrDepth::Half);
    writer.add_filled_frame(index);
    control.report(0.3 + 0.7 * static_cast<double>(k + 1) / static_cast<double>(kept.size()));
  }
  return inside;
}

void write_controls(HistoryWriter& writer, const RelitWork& work, const fs::path& folder, const ImageU8& mask,
                    const RunControl& control) {
  if (!work.project.has_shape()) {
    std::vector<double> times;
    for (const HistoryFrame& f : writer.manifest().frames) times.push_back(f.time);
    if (times.size() < 2) return;
    const auto read_frame = [&](int i) { return read_color(folder / writer.manifest().frames[i].file); };
    // Light and shape are off alike for neighboring pixels.
    FrameDeviations deviations{.read = {}, .is_shared = true};
    const auto& frames = writer.manifest().frames;
    const auto file_of = [&](int i) -> const HistoryImage* {
      for (const HistoryImage& extra : frames[i].extras) {
        if (extra.name == "stddev") return &extra;
      }
      return nullptr;
    };
    const int num_frames = static_cast<int>(frames.size());
    bool has_all = true;
    for (int i = 0; i < num_frames; ++i) has_all = has_all && file_of(i);
    if (has_all)
      deviations.read = [&](int i) { return read_channels(folder / file_of(i)->file, frame_extra_channels("stddev")); };
    const ProgressMap map = progress_from_history(times, read_frame, mask, work.options.progress, control, deviations);
    writer.write_control("progress", map.values, map.low, map.high, "relative");
    if (!map.deviation.empty()) writer.write_control_deviation(map.deviation);
    return;
  }
  const AccessibilityOptions shares;
  const ImageF curvature = read_gray(folder / relit_curvature_file());
  const Percentiles found = percentiles(curvature, mask, shares.low_percent / 100.0, shares.high_percent / 100.0);
  const double width = load_json(folder / relit_reference_file()).at("width_mm").get<double>();
  const ValueRange range =
      widened_accessibility_range({static_cast<double>(found.low), static_cast<double>(found.high)}, width);
  writer.write_control(kAccessibility, curvature, range.low, range.high, "1/mm");
  for (const char* name : {"position", "normal", "height", "texel_size"}) writer.add_written_map(name);
  writer.set_texel_size_mm(
      static_cast<double>(percentiles(read_gray(folder / HistoryWriter::map_file("texel_size")), mask, 0.5, 0.5).low));
}

/// Warnings about steps whose pose was found by a surface of which most has changed, or that fit in another one too.
std::vector<HistoryWarning> pose_warnings(const std::vector<RelitStepFacts>& facts) {
  std::vector<HistoryWarning> warnings;
  for (const RelitStepFacts& f : facts) {
    if (!f.frame || !f.pose.registration) continue;
    const RelitRegistration& found = *f.pose.registration;
    const std::string name = "step " + std::to_string(f.step);
    if (found.ambiguous_deg > 0.0) {
      warnings.push_back({.about = WarningSubject::Motion,
                          .text = name + ": its scan fits nearly as well turned by " +
                                  short_number_text(std::round(found.ambiguous_deg)) + " degrees",
                          .cure = "give it an `initial` pose, or mark the object with something that stays",
                          .share = 1.0,
                          .photos = {name}});
    }
    if (f.pose.status != RelitPose::kMisled) continue;
    warnings.push_back(
        {.about = WarningSubject::Motion,
         .text = name + ": only " + fixed_percent_text(found.staying) +
                 " of its surface lies where the reference's does, so that nothing tells which part has "
                 "stayed; its pose may be off by " +
                 short_number_text(rounded(found.stddev_mm, 2)) + " mm",
         .cure = "give it a `transform` (of a mount, or by targets), or scan something that stays as well",
         .share = 1.0 - found.staying,
         .photos = {name}});
  }
  return warnings;
}

void join(const RelitWork& work, const fs::path& folder, const RunControl& control) {
  HistoryWriter writer(folder, work.manifest());
  std::vector<RelitStepFacts> facts;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < work.project.steps.size(); ++i) {
    facts.push_back(relit_step_facts(load_json(folder / relit_facts_file(i))));
    if (facts.back().frame) kept.push_back(i);
  }
  const ImageU8 mask = write_frames(writer, work, folder, kept, control.part(0.0, 0.7));
  writer.write_mask(mask);
  write_controls(writer, work, folder, mask, control.part(0.7, 0.9));
  for (HistoryWarning& warning : pose_warnings(facts)) writer.add_warning(std::move(warning));
  write_relit_report(writer.manifest(), work, folder, facts, mask, control.part(0.9, 1.0));
  writer.finish();
  control.report(1.0);
}

}  // namespace

fs::path relit_reference_file() { return "report/reference.json"; }
fs::path relit_curvature_file() { return "report/curvature.exr"; }
fs::path relit_pose_file(std::size_t index) { return report_file("pose", index, ".json"); }
fs::path relit_validity_file(std::size_t index) { return report_file("validity", index, ".png"); }
fs::path relit_facts_file(std::size_t index) { return report_file("facts", index, ".json"); }
fs::path relit_picture_file(const std::string& what, std::size_t index) {
  return report_file(what.c_str(), index, ".png");
}

void describe(OptionVisitor& v, RelitOptions& o) {
  v.visit(
      {"accept_failed",
       "Leave steps that cannot be registered, and photographs that --align cannot align with the others, out of the "
       "history instead of stopping"},
      o.accept_failed);
  v.visit_choice(
      {"method",
       "Method that registers a step's scan to the reference's; pcl-... are PCL's, for comparison (relit captures)"},
      o.registration.method, kRegistrationMethodNames);
  v.visit({"heights",
           "Add a height to each frame: how much higher its scan stands than the reference's, as in relief (relit "
           "captures with scans)"},
          o.heights);
  v.visit_choice(
      {"poses",
       "joint: register the scans of all steps together; each: register each one to the reference (relit captures)"},
      o.poses, kRelitPosesNames);
  describe(v, o.unlight);
}

std::string RelitWork::step_name(std::size_t index) const {
  return "steps/" + std::to_string(project.steps[index].number);
}

HistoryManifest RelitWork::manifest() const {
  HistoryManifest m;
  m.name = project.name;
  m.sample = project.sample;
  m.origin = "captured";
  m.width = project.width();
  m.height = project.height();
  m.time_unit = project.time_unit;
  m.key = key;
  return m;
}

JobPlan plan_relit_ingest(const RelitProject& project, const RelitOptions& options, const fs::path& output) {
  check_ranges(options);
  check_ranges(options.scan);
  check_ranges(options.registration);
  auto work = std::make_shared<RelitWork>(project, options);
  for (const RelitStep& step : project.steps) work->step_keys.push_back(step_key(project, step));
  JobPlan plan = inputs_of(*work).plan(output, kHistoryManifestFile);
  plan.may_grow = true;
  plan.parallel_items = false;
  work->key = plan.key;
  const std::string common = common_key(*work);
  ContentHash reference_key;
  reference_key.add("reference").add(common);
  for (const auto& [name, value] : option_values(options.scan)) reference_key.add(name).add(value);
  JobItem reference{
      .name = "reference",
      .outputs = {relit_reference_file()},
      .run = [work](const fs::path& folder, const RunControl& control) { run_relit_reference(*work, folder, control); },
      .key = reference_key.hex()};
  if (project.has_shape()) {
    reference.outputs.push_back(relit_curvature_file());
    for (const char* name : {"position", "normal", "height", "texel_size"})
      reference.outputs.push_back(HistoryWriter::map_file(name));
  }
  plan.items.push_back(std::move(reference));
  const std::vector<std::size_t> joint = work->joint_steps();
  const std::string joint_key = key_of_joint(*work, joint, common);
  if (!joint.empty()) {
    JobItem poses{.name = "poses",
                  .outputs = {},
                  .run = [work](const fs::path& folder,
                                const RunControl& control) { run_relit_joint_poses(*work, folder, control); },
                  .key = joint_key,
                  .stage = 1,
                  .weight = static_cast<double>(joint.size())};
    for (const std::size_t i : joint) {
      if (i != project.reference) poses.outputs.push_back(relit_pose_file(i));
    }
    plan.items.push_back(std::move(poses));
  }
  for (std::size_t i = 0; i < project.steps.size(); ++i) {
    const fs::path name = relit_pose_file(i).stem();
    const bool is_joint = i != project.reference && std::find(joint.begin(), joint.end(), i) != joint.end();
    const std::string own = is_joint ? work->step_keys[i] + joint_key : work->step_keys[i];
    if (!is_joint) {
      plan.items.push_back({.name = name.string(),
                            .outputs = {relit_pose_file(i)},
                            .run = [work, i](const fs::path& folder,
                                             const RunControl& control) { run_relit_pose(*work, i, folder, control); },
                            .key = ContentHash().add("pose").add(common).add(own).hex(),
                            .stage = 1});
    }
    plan.items.push_back({.name = "step-" + name.string().substr(5),
                          .outputs = {relit_facts_file(i)},
                          .run = [work, i](const fs::path& folder,
                                           const RunControl& control) { run_relit_step(*work, i, folder, control); },
                          .key = ContentHash().add("step").add(common).add(own).hex(),
                          .stage = 2,
                          .weight = kStepWeight,
                          .optional_outputs = relit_frame_outputs(*work, i)});
  }
  plan.join = [work](const fs::path& folder, const RunControl& control) { join(*work, folder, control); };
  return plan;
}

}  // namespace patinate::capture
