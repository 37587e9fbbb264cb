#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate_kinds.h"
#include "capture/calibration/surface_samples.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kMaxPoses = 1000;
constexpr std::size_t kMaxLights = 1000;

Mesh read_shape(JsonReader& pose, double mm_per_unit) {
  if (pose.has("plane")) {
    JsonReader plane = pose.member("plane");
    const std::vector<double> point = plane.member("point").numbers(3), normal = plane.member("normal").numbers(3);
    const double side = plane.member("side").number(above(0));
    const JsonReader n = plane.member("normal");
    plane.finish();
    if (!(Vec3(normal[0], normal[1], normal[2]).norm() > 0)) n.fail("a direction, of a length above 0");
    return plane_mesh(mm_per_unit * Vec3(point[0], point[1], point[2]), {normal[0], normal[1], normal[2]},
                      mm_per_unit * side);
  }
  Mesh mesh = read_mesh(pose.member("mesh").path());
  scale_mesh(mesh, mm_per_unit);
  if (pose.has("transform")) {
    const JsonReader rows = pose.member("transform");
    Eigen::Matrix4d matrix;
    const std::vector<JsonReader> entries = rows.elements(4);
    if (entries.size() != 4) rows.fail("four rows of four numbers");
    for (int r = 0; r < 4; ++r) {
      const std::vector<double> row = entries[r].numbers(4);
      for (int c = 0; c < 4; ++c) matrix(r, c) = row[c];
    }
    matrix.topRightCorner<3, 1>() *= mm_per_unit;
    RigidTransform scanner_from_mesh;
    try {
      scanner_from_mesh = rigid_transform(matrix);
    } catch (const InvalidInput& e) {
      rows.fail(e.what());
    }
    for (Vec3& p : mesh.positions) p = scanner_from_mesh.apply(p);
    mesh.normals.clear(), mesh.normal_triangles.clear();
  }
  return mesh;
}

Json lambertian_report(const LambertianLightResult& result, const LambertianLightOptions& options) {
  Json report{{"sigma", result.sigma}};
  if (options.has_ambient) report["ambient"] = {result.ambient.x(), result.ambient.y(), result.ambient.z()};
  if (options.has_vignetting) report["vignetting"] = {result.vignetting.x(), result.vignetting.y()};
  for (const LambertianLight& light : result.lights) {
    report["lights"].push_back({{"status", calibration_status_text(light.status)},
                                {"samples", light.num_samples},
                                {"rms", light.rms},
                                {"distance_sd", light.distance_sd},
                                {"covariance", matrix_json(light.covariance)}});
  }
  return report;
}

}  // namespace

CalibrationOutput run_lambertian(JsonReader& json, const LambertianRunOptions& options, const RunControl& control) {
  const double mm = read_mm_per_unit(json);
  const Camera camera = read_camera(json.member("camera"), mm);
  const Response response = json.has("response") ? read_response(json.member("response")) : Response{};
  std::vector<std::string> names;
  if (json.has("lights")) {
    for (const JsonReader& name : json.member("lights").elements(kMaxLights)) names.push_back(name.string());
  }
  std::vector<std::vector<ShadedSample>> samples(names.size());
  const JsonReader poses_json = json.member("poses");
  std::vector<JsonReader> poses = poses_json.elements(kMaxPoses);
  if (poses.empty()) poses_json.fail("at least one pose of the object");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    control.throw_if_stopped();
    JsonReader& pose = poses[i];
    const Mesh mesh = read_shape(pose, mm);
    const JsonReader photos_json = pose.member("photos");
    std::vector<ImageF> photos;
    for (const JsonReader& photo : photos_json.elements(kMaxLights))
      photos.push_back(read_color(photo.path(), response));
    if (samples.empty()) samples.resize(photos.size());
    if (photos.size() != samples.size() || photos.empty())
      photos_json.fail("one photograph for each of the lights, as many in every pose");
    const ImageU8 mask = pose.has("mask") ? read_mask(pose.member("mask").path()) : ImageU8();
    pose.finish();
    std::vector<std::vector<ShadedSample>> more;
    try {
      more = surface_samples(camera, mesh, photos, mask, options.sample_step_px);
    } catch (const InvalidInput& e) {
      throw IoError(json.file(), pose.pointer() + ": " + e.what());
    }
    for (std::size_t k = 0; k < samples.size(); ++k)
      samples[k].insert(samples[k].end(), more[k].begin(), more[k].end());
  }
  json.finish();

  const LambertianLightResult result = lights_from_lambertian(camera, samples, options.lights, control);
  CalibrationOutput output;
  output.camera = camera;
  output.json = std::make_shared<Json>(result_json(CalibrationKind::Lambertian));
  (*output.json)["camera"] = json_of(camera);
  for (std::size_t k = 0; k < result.lights.size(); ++k) {
    const LambertianLight& light = result.lights[k];
    const std::string name = k < names.size() ? names[k] : "light " + std::to_string(k + 1);
    if (light.status != CalibrationStatus::Converged) {
      const std::string known = std::isfinite(light.distance_sd)
                                    ? "its distance is known to " + percent_text(light.distance_sd, 2) + " only"
                                    : "its distance is open";
      throw CannotComplete(name + " is " + calibration_status_text(light.status) + ": " + known +
                           " against its strength; photograph the object in more poses, tilted to all sides");
    }
    output.lights.push_back(light.light);
    output.lights.back().name = name;
    const Vec3& p = light.light.position;
    const double sd = std::sqrt(light.covariance.topLeftCorner<3, 3>().trace());
    output.lines.push_back(name + ": at " + short_number_text(rounded(p.x(), 5)) + ", " +
                           short_number_text(rounded(p.y(), 5)) + ", " + short_number_text(rounded(p.z(), 5)) +
                           " mm, +- " + short_number_text(rounded(sd, 2)) + " mm (" +
                           std::to_string(light.num_samples) + " samples)");
  }
  (*output.json)["lights"] = json_of(output.lights);
  (*output.json)["report"] = lambertian_report(result, options.lights);
  return output;
}

}  // namespace patinate::capture
