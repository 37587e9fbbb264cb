#include "capture/project/relit_project.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/project/capture_text.h"
#include "capture/project/given_registration.h"
#include "capture/project/sample_facts.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxSteps = 100'000;
constexpr std::size_t kMaxLights = 10'000;

/// The given size, as every image of a step. @throws IoError
void check_size(const fs::path& file, int width, int height) {
  const ImageInfo info = probe_image(file);
  if (info.width == width && info.height == height) return;
  throw IoError(file.string(), "is " + size_text(info.width, info.height) + " pixels; expected " +
                                   size_text(width, height) + ", as the camera takes");
}

RigidTransform read_rigid_transform(const JsonReader& json, double mm_per_unit) {
  Eigen::Matrix4d matrix;
  const std::vector<JsonReader> rows = json.elements(4);
  if (rows.size() != 4) json.fail("four rows of four numbers");
  for (Eigen::Index r = 0; r < 4; ++r) {
    const std::vector<double> row = rows[r].numbers(4);
    for (Eigen::Index c = 0; c < 4; ++c) matrix(r, c) = row[c];
  }
  matrix.topRightCorner<3, 1>() *= mm_per_unit;
  try {
    return rigid_transform(matrix);
  } catch (const InvalidInput& e) {
    json.fail(std::string("a rotation and a translation, reference from scan (") + e.what() + ")");
  }
}

RelitStep::Ready read_ready(JsonReader& json) {
  RelitStep::Ready ready;
  ready.albedo = json.member("albedo").path();
  ready.position = json.member("position").path();
  ready.normal = json.member("normal").path();
  for (const char* other : {"scan", "photos", "ambient"}) {
    if (json.has(other))
      json.fail(std::string("either `albedo`, `position` and `normal`, or photographs; not `") + other + "` too");
  }
  return ready;
}

/// Photographs whose names lights have, in the order of the lights.
void order_photos(std::vector<fs::path>& photos, const std::vector<Light>& lights, const JsonReader& json) {
  std::vector<Light> ordered = lights;
  if (are_lights_named_otherwise(ordered, photos, json)) return;
  const std::vector<fs::path> given = photos;
  for (std::size_t k = 0; k < given.size(); ++k) {
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (!lights[i].name.empty() && lights[i].name == ordered[k].name) photos[i] = given[k];
    }
  }
}

RelitStep read_step(JsonReader json, int number, double mm_per_unit, const std::vector<Light>& lights) {
  RelitStep step{.number = number};
  step.time = json.member("time").number();
  if (json.has("albedo")) {
    step.ready = read_ready(json);
  } else {
    if (json.has("scan")) step.scan = json.member("scan").path();
    const JsonReader photos = json.member("photos");
    for (const JsonReader& photo : photos.elements(kMaxLights)) step.photos.push_back(photo.path());
    if (step.photos.size() != lights.size()) {
      photos.fail(std::to_string(lights.size()) + " photographs, one a light in the lights' order; these are " +
                  std::to_string(step.photos.size()));
    }
    order_photos(step.photos, lights, photos);
    if (json.has("ambient")) step.ambient = json.member("ambient").path();
  }
  if (json.has("transform")) step.reference_from_scan = read_rigid_transform(json.member("transform"), mm_per_unit);
  if (json.has("initial")) step.initial = read_rigid_transform(json.member("initial"), mm_per_unit);
  json.finish();
  return step;
}

ReferencePatch read_patch(JsonReader json, const Camera& camera) {
  ReferencePatch patch;
  const JsonReader polygon = json.member("polygon");
  for (const JsonReader& corner : polygon.elements(1000)) {
    const std::vector<double> at = corner.numbers(2);
    const CameraParameters& p = camera.parameters();
    if (!(at[0] >= -0.5 && at[1] >= -0.5 && at[0] <= p.width - 0.5 && at[1] <= p.height - 0.5)) {
      corner.fail("a pixel of the photographs, " + size_text(p.width, p.height));
    }
    patch.polygon.emplace_back(at[0], at[1]);
  }
  if (patch.polygon.size() < 3) polygon.fail("three or more corners, [x, y] in pixels");
  const std::vector<double> albedo = json.member("albedo").numbers(3, above(0));
  patch.albedo = Vec3(albedo[0], albedo[1], albedo[2]);
  json.finish();
  return patch;
}

/// Where a project without shape and camera stands: the photographs' size, looking along -z, x right, y up.
Camera stand_in_camera(int width, int height) {
  CameraParameters p;
  p.width = width;
  p.height = height;
  p.fx = p.fy = std::max(width, height);
  p.cx = 0.5 * (width - 1);
  p.cy = 0.5 * (height - 1);
  p.rotation.diagonal() = Vec3(1.0, -1.0, -1.0);
  p.translation = Vec3(0.0, 0.0, 1000.0);
  return Camera(p);
}

/// The first photograph of a project, so that a missing camera's size is known.
fs::path first_photo(const JsonReader& steps) {
  for (JsonReader& step : steps.elements(kMaxSteps)) {
    if (step.has("photos")) {
      for (const JsonReader& photo : step.member("photos").elements(kMaxLights)) return photo.path();
    }
  }
  steps.fail("a step with photographs, or a `camera`");
}

bool is_excluded(JsonReader& json) { return json.has("exclude") && json.member("exclude").boolean(); }

void check_files(const RelitProject& project) {
  const auto check_image = [&](const fs::path& file) { check_size(file, project.width(), project.height()); };
  for (const RelitStep& step : project.steps) {
    std::error_code error;
    if (step.scan && !fs::is_regular_file(*step.scan, error))
      throw IoError(step.scan->string(), "is not there; step " + std::to_string(step.number) + " names it as its scan");
    for (const fs::path& photo : step.photos) check_image(photo);
    if (step.ambient) check_image(*step.ambient);
    if (!step.ready) continue;
    for (const fs::path& map : {step.ready->albedo, step.ready->position, step.ready->normal}) check_image(map);
  }
}

/// Checks steps, lights and camera against each other. @throws IoError
void check_steps(const RelitProject& project, const JsonReader& steps) {
  const bool are_all_directional = std::all_of(project.lights.begin(), project.lights.end(),
                                               [](const Light& l) { return l.kind == Light::Kind::Directional; });
  const auto fail_at = [&](std::size_t i, const std::string& problem) {
    throw IoError(steps.file(), steps.pointer() + "/" + std::to_string(project.steps[i].number) + ": " + problem);
  };
  std::vector<double> times;
  for (const RelitStep& step : project.steps) times.push_back(step.time);
  if (const auto problem = find_time_problem(times)) fail_at(problem->index, problem->text);
  for (std::size_t i = 0; i < project.steps.size(); ++i) {
    const RelitStep& step = project.steps[i];
    const auto fail = [&](const std::string& problem) { fail_at(i, problem); };
    if (!step.has_shape() && !are_all_directional)
      fail("has no `scan`; only when all lights are directional can it be omitted");
    if (step.has_shape() && !project.is_camera_given) fail("has a shape, but the project no `camera`");
    if (step.has_shape() && !project.has_shape())
      fail("has a shape, but the reference step has none; choose another `reference`");
    if (!step.has_shape() && project.has_shape())
      fail("has no `scan`, but the reference step has one; give every step one, or none");
  }
}

}  // namespace

bool is_relit_capture(const fs::path& file) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.capture", 1);
  return kCaptureKinds[json.member("kind").choice(kCaptureKinds)] == "relit";
}

RelitProject read_relit_project(const fs::path& file) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.capture", 1);
  const JsonReader kind = json.member("kind");
  if (kCaptureKinds[kind.choice(kCaptureKinds)] != "relit") kind.fail("\"relit\"");
  const double mm = kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)];
  const JsonReader steps = json.member("steps");
  const bool is_camera_given = json.has("camera");
  const auto camera_of_photos = [&] {
    const ImageInfo info = probe_image(first_photo(steps));
    return stand_in_camera(info.width, info.height);
  };
  RelitProject project{.file = file,
                       .name = json.member("name").string(),
                       .mm_per_unit = mm,
                       .camera_mm = is_camera_given ? read_camera(json.member("camera"), mm) : camera_of_photos(),
                       .is_camera_given = is_camera_given};
  project.sample = read_sample(json);
  constexpr std::array<std::string_view, 4> kTimeUnits{"s", "min", "h", "d"};
  if (json.has("time_unit")) project.time_unit = static_cast<TimeUnit>(json.member("time_unit").choice(kTimeUnits));
  if (json.has("response")) project.response = read_response(json.member("response"));
  project.lights = read_lights(json.member("lights"), mm, &project.camera_mm);
  expect_strengths_of_all_or_none(project.lights, json.member("lights"));
  if (json.has("reference_patch")) project.patch = read_patch(json.member("reference_patch"), project.camera_mm);
  std::vector<JsonReader> entries = steps.elements(kMaxSteps);
  std::int64_t reference = 0;
  if (json.has("reference"))
    reference = json.member("reference").integer(between(0, static_cast<double>(entries.size()) - 1.0));
  bool is_reference_there = false;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool is_out = is_excluded(entries[i]);
    const int number = static_cast<int>(i);
    if (is_out) {  // Whatever else it says.
      if (number == reference) entries[i].fail("a reference step that is not excluded; choose another `reference`");
      continue;
    }
    if (number == reference) {
      project.reference = project.steps.size();
      is_reference_there = true;
    }
    project.steps.push_back(read_step(entries[i], number, mm, project.lights));
  }
  if (!is_reference_there) steps.fail("one or more steps");
  const std::optional<fs::path> registration =
      json.has("registration") ? std::optional(json.member("registration").path()) : std::nullopt;
  json.finish();
  check_steps(project, steps);
  check_files(project);
  if (registration) apply_registration(*registration, project);
  return project;
}

}  // namespace patinate::capture
