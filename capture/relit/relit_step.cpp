#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/relit/material_frame.h"
#include "capture/relit/relit_work.h"
#include "capture/unlighting/unlight_report.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/map_legend.h"
#include "patinate/core/error.h"
#include "patinate/image/image.h"
#include "patinate/image/image_io.h"

// One step: photographs to a frame.

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr int kWidth = 480, kSampleWidth = 240;  ///< px of the report's pictures.
constexpr double kFullShare = 0.10;              ///< Relative deviation that the last color stands for.
constexpr float kPlain = 0.18f;                  // Where there is no surface.

ImageF at_most(const ImageF& image, int width) {
  if (image.width() <= width) return image;
  const int height =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(image.height()) * width / image.width())));
  return downscale_area(image, width, height);
}

void put_color(ImageF& image, int x, int y, const std::array<float, 3>& color) {
  std::copy(color.begin(), color.end(), image.pixel(x, y).begin());
}

/// The color, made smaller.
ImageF report_albedo(const ImageF& color) { return at_most(color, kWidth); }

/// Picture of every sample's state, one picture a light side by side, in sample_state_color().
/// @param samples  H x W x L of SampleState; empty for ready-made albedo. @param mask  Of what is determined.
ImageF report_samples(const ImageU8& samples, const ImageU8& mask) {
  std::vector<ImageF> pictures;
  std::vector<std::string> labels;
  for (int light = 0; light < std::max(1, samples.channels()); ++light) {
    ImageF picture(mask.width(), mask.height(), 3);
    for (int y = 0; y < mask.height(); ++y) {
      for (int x = 0; x < mask.width(); ++x) {
        const SampleState ready = mask.at(x, y) != 0 ? SampleState::Clean : SampleState::Outside;
        put_color(picture, x, y,
                  sample_state_color(samples.empty() ? ready : static_cast<SampleState>(samples.at(x, y, light))));
      }
    }
    pictures.push_back(at_most(picture, kSampleWidth));
    labels.push_back("light " + std::to_string(light));
  }
  return contact_strip(pictures, labels, {.columns = 4, .gap_px = 4});
}

/// Standard deviation over albedo: black 0, white 10 % or more; red where nothing is determined.
/// @param surface  Where there is surface.
ImageF report_stddev(const ImageF& albedo, const ImageF& stddev, const ImageU8& surface) {
  ImageF picture(albedo.width(), albedo.height(), 3, kPlain);
  for (int y = 0; y < albedo.height(); ++y) {
    for (int x = 0; x < albedo.width(); ++x) {
      float value = 0.0f, deviation = 0.0f;
      for (int c = 0; c < 3; ++c) {
        value += albedo.at(x, y, c);
        if (!stddev.empty()) deviation += stddev.at(x, y, c);
      }
      if (value > 0.0f) {
        put_color(picture, x, y,
                  ramp_color(ColorRamp::Sequential, static_cast<double>(deviation / value) / kFullShare));
      } else if (surface.at(x, y) != 0) {
        put_color(picture, x, y, {0.55f, 0.04f, 0.03f});
      }
    }
  }
  return with_legend(at_most(picture, kWidth), {.ramp = ColorRamp::Sequential,
                                                .high = 100.0 * kFullShare,
                                                .unit = "%",
                                                .more = "gray: no surface; red: not determined"});
}

constexpr float kBlackPhoto = 1e-4f;  ///< Linear value that every photograph of a lit surface passes somewhere.
constexpr double kMinOverlap = 0.1;   ///< Share of the reference's pixels that a step must show.
constexpr double kLargestOffset =
    3.0;  ///< In a scan's texel size: a scan farther off is not of this object, or not registered.
constexpr double kLargeResidual =
    0.1;  ///< Share of the photographs' values; noise and small errors of normals stay below.
constexpr float kMaxHalf = 65504.0f;  ///< Largest finite half float.

struct StepFrame {
  UnlightResult result;  ///< In the reference view; normals in the reference's frame.
  ImageF height;         ///< Height of the scan over the reference's, mm; empty without RelitOptions::heights.
  PlacedPhoto first;     ///< Under the first light, for the report.
  StepPlaces places;     ///< Where its texels lie in the photographs.
  RelitFrame facts;
};

double share_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

std::int64_t count(const ImageU8& mask) {
  return std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; });
}

double median_texel_size(const ScanView& view) {
  std::vector<float> sizes;
  std::copy_if(view.texel_size_mm.values().begin(), view.texel_size_mm.values().end(), std::back_inserter(sizes),
               [](float v) { return v > 0.0f; });
  return static_cast<double>(median(std::move(sizes)));
}

/// @throws IoError when it is a mirror image; CannotComplete when the scan does not lie on the reference.
void check_fit(const RelitWork& work, std::size_t index, const ScanView& reference, const ScanView& view,
               const StepPlaces& places, RelitFrame& facts) {
  const auto is_from_behind = [](const ScanView& v) { return 2 * v.num_from_behind > v.num_seen; };
  if (view.num_seen > 0 && is_from_behind(view) != is_from_behind(reference)) {
    const RelitStep& step = work.project.steps[index];
    throw IoError((step.ready ? step.ready->position : *step.scan).string(),
                  "its triangles face the other way than the reference scan's: it is mirrored (an axis was flipped on "
                  "the way), or wound the other way");
  }
  const double overlap = share_of(places.num_on_scan, reference.num_seen);
  facts.overlap = overlap;
  facts.offset_mm = places.offset_mm;
  if (overlap < kMinOverlap) {
    throw CannotComplete(work.step_name(index) + ": its scan shows only " + fixed_percent_text(overlap) +
                         " of what the reference shows; the scans do not overlap, or its pose is wrong");
  }
  const double limit = kLargestOffset * median_texel_size(reference);
  if (places.offset_mm > limit) {
    throw CannotComplete(work.step_name(index) + ": its scan lies " + short_number_text(places.offset_mm) +
                         " mm off the reference's (median; at most " + short_number_text(limit) +
                         " mm are a fit): its pose is wrong, or it is another or a mirrored object");
  }
}

void check_exposure(const fs::path& file, const PlacedPhoto& placed, const ImageU8& seen) {
  const std::int64_t num_valid = count(placed.valid), num_seen = count(seen);
  if (num_seen > 0 && num_valid == 0)
    throw IoError(file.string(),
                  "is saturated everywhere on the object; leave the step out (\"exclude\": true) or repeat it darker");
  const auto values = placed.values.values();
  if (num_seen > 0 && std::all_of(values.begin(), values.end(), [](float v) { return v < kBlackPhoto; })) {
    throw IoError(file.string(),
                  "is black everywhere on the object; leave the step out (\"exclude\": true) or check its light");
  }
}

/// The reference's view as this step's scanner has it.
void move_view(const ScanView& view, const RigidTransform& step_from_reference, UnlightInput& input) {
  input.position_mm = view.position_mm;
  input.normal = view.normal;
  for (int y = 0; y < view.seen.height(); ++y) {
    for (int x = 0; x < view.seen.width(); ++x) {
      if (view.seen.at(x, y) == 0) continue;
      set_pixel_vector(input.position_mm, x, y, step_from_reference.apply(pixel_vector(view.position_mm, x, y)));
      set_pixel_vector(input.normal, x, y, step_from_reference.rotation * pixel_vector(view.normal, x, y));
    }
  }
}

/// Photographs in the reference view, at the patch's strength.
void place_photos(const RelitWork& work, const RelitStep& step, const RelitReference& reference,
                  const StepPlaces& places, UnlightInput& input, StepFrame& frame, const RunControl& control) {
  const RelitProject& project = work.project;
  const ImageF ambient = read_step_ambient(project, step);
  for (std::size_t i = 0; i < step.photos.size(); ++i) {
    control.throw_if_stopped();
    StepPhoto photo = read_step_photo(project, step.photos[i]);
    Vec3 gain = Vec3::Ones();
    if (!reference.patch_target.empty())
      gain = reference.patch_target[i].cwiseQuotient(patch_mean(project, photo, ambient, step.photos[i]));
    PlacedPhoto placed = place_photo(photo.values, places, photo.saturation);
    check_exposure(step.photos[i], placed, places.seen);
    const PlacedPhoto dark = place_photo(ambient, places, std::numeric_limits<float>::infinity());
    subtract_ambient(placed.values, dark.values);
    for (std::int64_t k = 0; k < 3 * placed.valid.num_pixels(); ++k) {
      float& value = placed.values.data()[k];
      value = placed.valid.data()[k / 3] != 0 ? value * static_cast<float>(gain[k % 3]) : 0.0f;
    }
    frame.facts.gains.push_back(gain);
    if (i == 0) frame.first = placed;
    input.photos.push_back(std::move(placed.values));
    input.valid.push_back(std::move(placed.valid));
    control.report(static_cast<double>(i + 1) / static_cast<double>(step.photos.size()));
  }
}

/// Ready-made albedo: resampled, nothing solved.
void place_ready(const RelitWork& work, const RelitStep& step, const RelitReference& reference,
                 const StepPlaces& places, StepFrame& frame) {
  ImageF albedo = read_color(step.ready->albedo, work.project.response);
  if (!reference.patch_target.empty())
    throw IoError(work.project.file.string(), "/reference_patch: cannot be used with ready-made albedo; leave it out");
  frame.first = place_photo(albedo, places, std::numeric_limits<float>::infinity());
  frame.result.albedo = frame.first.values;
  frame.result.mask = frame.first.valid;
  frame.result.normal = reference.view.normal;
  frame.result.num_surface = reference.view.num_seen;
  frame.result.num_determined = count(frame.result.mask);
}

RelitSolution solution_facts(const UnlightResult& result) {
  RelitSolution solution{.residual = result.residual, .noise_scale = result.noise_scale, .notes = result.notes};
  for (const LightReport& report : result.lights) {
    RelitLight light{.residual = report.residual};
    for (std::size_t state = 1; state < kNumSampleStates; ++state)
      light.shares[state] = share_of(report.samples[state], result.num_surface);
    solution.lights.push_back(light);
  }
  if (result.residual > kLargeResidual) {
    solution.notes.push_back("the used samples differ by " + fixed_percent_text(result.residual, 0) +
                             " from the prediction by shape and lights: check pose, lights, camera and `response`");
  }
  return solution;
}

StepFrame solve_step(const RelitWork& work, std::size_t index, const RelitPose& pose, const RelitReference& reference,
                     const RunControl& control) {
  const RelitProject& project = work.project;
  const RelitStep& step = project.steps[index];
  const RigidTransform step_from_reference = pose.reference_from_scan.inverse();
  StepFrame frame;
  UnlightInput input;
  input.view_direction = -project.camera_mm.parameters().rotation.row(2).transpose();
  StepPlaces places{ImageF(project.width(), project.height(), 2), ImageU8(project.width(), project.height(), 1, 255)};
  Mesh mesh;
  if (project.has_shape()) {
    mesh = read_step_mesh(project, step);
    const ScanView view = view_scan(mesh, RayScene(mesh), project.camera_mm, control.part(0.0, 0.03));
    places = find_places(reference.view, view, project.camera_mm, step_from_reference, control.part(0.03, 0.05));
    check_fit(work, index, reference.view, view, places, frame.facts);
    move_view(reference.view, step_from_reference, input);
    input.mask = places.seen;
    input.blockers = &mesh;
    input.camera_center = project.camera_mm.center();
  } else {
    for (int y = 0; y < project.height(); ++y) {
      for (int x = 0; x < project.width(); ++x) {
        places.place_px.at(x, y, 0) = static_cast<float>(x);
        places.place_px.at(x, y, 1) = static_cast<float>(y);
      }
    }
  }
  if (step.ready) {
    place_ready(work, step, reference, places, frame);
  } else {
    input.lights = project.lights;
    place_photos(work, step, reference, places, input, frame, control.part(0.05, 0.1));
    try {
      frame.result = unlight(input, work.options.unlight, control.part(0.1, 0.97));
    } catch (const InvalidInput& e) {
      throw IoError(project.file.string(), work.step_name(index) + ": " + e.what());
    }
    for (int y = 0; y < project.height(); ++y) {
      for (int x = 0; x < project.width(); ++x)
        set_pixel_vector(frame.result.normal, x, y,
                         pose.reference_from_scan.rotation * pixel_vector(frame.result.normal, x, y));
    }
    frame.facts.solution = solution_facts(frame.result);
    const bool has_strengths = std::all_of(project.lights.begin(), project.lights.end(),
                                           [](const Light& light) { return light.is_intensity_known; });
    if (!has_strengths && index == project.reference)
      frame.facts.solution->notes.push_back(
          "the lights have no `intensity`: they are taken as equally strong, and albedo has a scale of its own unless "
          "`reference_patch` gives it");
  }
  const std::int64_t num_surface = project.has_shape() ? reference.view.num_seen : frame.result.num_surface;
  frame.facts.seen_share = share_of(count(places.seen), num_surface);
  frame.places = std::move(places);
  frame.facts.determined_share = share_of(frame.result.num_determined, num_surface);
  if (frame.result.num_determined == 0)
    throw CannotComplete(work.step_name(index) +
                         ": no texel has enough light that is neither shadow, highlight nor saturated" +
                         (project.lights.size() == 1 ? "; one lamp leaves nothing to compare: a plate under one is a "
                                                       "capture of kind `fixed` with `lights`"
                                                     : ""));
  return frame;
}

void write_frame(const RelitWork& work, std::size_t index, const fs::path& folder, StepFrame& frame) {
  const int i = static_cast<int>(index);
  ImageF tint;
  if (!frame.result.reflectance.empty()) {
    MaterialFrame material = material_frame(frame.result);
    frame.result.albedo = std::move(material.color);
    frame.result.specular = std::move(material.specular);
    tint = std::move(material.tint);
  }
  for (float& v : frame.result.albedo.values()) v = std::clamp(v, 0.0f, kMaxHalf);
  if (!frame.result.stddev.empty())
    add_sampling_deviation(frame.result.albedo, frame.result.mask, frame.places, frame.result.stddev);
  HistoryWriter(folder, work.manifest()).write_frame(i, work.project.steps[index].time, frame.result.albedo);
  for (const std::string& extra : relit_frame_extras(work)) {
    ImageF values = extra == "stddev"      ? frame.result.stddev
                    : extra == "specular"  ? frame.result.specular
                    : extra == "metalness" ? frame.result.metalness
                    : extra == "tint"      ? tint
                    : extra == "height"    ? frame.height
                                           : frame.result.normal;
    if (values.empty())
      values =
          ImageF(work.project.width(), work.project.height(), static_cast<int>(frame_extra_channels(extra).size()));
    for (std::int64_t k = 0; k < values.num_pixels(); ++k) {
      if (frame.result.mask.data()[k] == 0) std::fill_n(values.data() + values.channels() * k, values.channels(), 0.0f);
    }
    HistoryWriter::write_frame_extra(folder, i, extra, values);
  }
  fs::create_directories((folder / relit_validity_file(index)).parent_path());
  write_codes(folder / relit_validity_file(index), frame.result.mask);
}

}  // namespace

std::vector<std::string> relit_frame_extras(const RelitWork& work) {
  const auto is_ready = [](const RelitStep& step) { return step.ready.has_value(); };
  std::vector<std::string> extras;
  if (!std::all_of(work.project.steps.begin(), work.project.steps.end(), is_ready)) {
    extras = {"stddev", "normal"};
    if (work.options.unlight.specular != SpecularMode::None) extras.insert(extras.begin() + 1, "specular");
    if (work.options.unlight.specular == SpecularMode::Material) extras.insert(extras.end(), {"metalness", "tint"});
  }
  if (work.options.heights && work.project.has_shape()) extras.emplace_back("height");
  return extras;
}

std::vector<fs::path> relit_frame_outputs(const RelitWork& work, std::size_t index) {
  std::vector<fs::path> files{HistoryWriter::frame_file(static_cast<int>(index)), relit_validity_file(index)};
  for (const std::string& extra : relit_frame_extras(work))
    files.push_back(HistoryWriter::frame_extra_file(static_cast<int>(index), extra));
  for (const char* what : {"albedo", "light", "samples", "stddev"}) files.push_back(relit_picture_file(what, index));
  return files;
}

void run_relit_step(const RelitWork& work, std::size_t index, const fs::path& folder, const RunControl& control) {
  RelitStepFacts facts{.step = work.project.steps[index].number,
                       .time = work.project.steps[index].time,
                       .pose = read_relit_pose(index, folder)};
  if (facts.pose.is_accepted) {
    StepFrame frame = solve_step(work, index, facts.pose, work.reference(folder), control);
    facts.frame = frame.facts;
    if (work.options.heights)
      frame.height = relit_height(work, index, facts.pose, work.reference(folder).view, control.part(0.97, 1.0));
    write_frame(work, index, folder, frame);
    fs::create_directories((folder / relit_picture_file("albedo", index)).parent_path());
    const ImageU8& surface = work.reference(folder).view.seen;
    write_srgb8(folder / relit_picture_file("albedo", index), report_albedo(frame.result.albedo));
    write_srgb8(folder / relit_picture_file("light", index), report_albedo(frame.first.values));
    write_srgb8(folder / relit_picture_file("samples", index), report_samples(frame.result.samples, frame.result.mask));
    write_srgb8(folder / relit_picture_file("stddev", index),
                report_stddev(frame.result.albedo, frame.result.stddev, surface));
  }
  save_json(folder / relit_facts_file(index), to_json(facts));
  control.report(1.0);
}

}  // namespace patinate::capture
