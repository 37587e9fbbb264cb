#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "capture/calibration/calibrate_kinds.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/geometry/ray_scene.h"
#include "libcommon/image/response_io.h"
#include "patinate/capture/lambertian_lights.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/geometry/mesh.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::capture {

namespace {

struct SeenPoint {
  Vec3 point;
  Vec3 normal;
};

class SeenMesh {
 public:
  SeenMesh(const Camera& camera, const Mesh& mesh)
      : camera_(camera), mesh_(mesh), normals_(vertex_normals(mesh)), scene_(mesh) {}

  [[nodiscard]] std::optional<SeenPoint> at(const Vec2& pixel) const {
    const auto ray = camera_.ray(pixel);
    if (!ray) return std::nullopt;
    const auto hit = scene_.first_hit(ray->origin, ray->direction);
    if (!hit) return std::nullopt;
    const Triangle& t = mesh_.triangles[hit->triangle];
    const double weights[3] = {1.0 - hit->b1 - hit->b2, hit->b1, hit->b2};
    SeenPoint found{Vec3::Zero(), Vec3::Zero()};
    for (std::size_t i = 0; i < 3; ++i) {
      found.point += weights[i] * mesh_.positions[t[i]];
      found.normal += weights[i] * normals_[t[i]];
    }
    const double length = found.normal.norm();
    if (!(length > 1e-6)) return std::nullopt;
    found.normal /= found.normal.dot(ray->direction) > 0 ? -length : length;
    return found;
  }

 private:
  const Camera& camera_;
  const Mesh& mesh_;
  std::vector<Vec3> normals_;
  RayScene scene_;
};

/// Squares of step_px x step_px pixels whose pixels all see one smooth piece of the mesh (their normals within 10
/// degrees of the middle one's): the middle's point and normal, and the mean of the photograph there. The side that the
/// camera sees is the outside, however triangles are wound.
/// @param photos  The same view under each light, linear, H x W x 3, the camera's size. @param mask  May be empty.
/// @returns samples[light]; the same places for each. @throws InvalidInput if sizes differ, step_px is not in [1,
/// 1000], or nothing of the mesh is seen.
std::vector<std::vector<ShadedSample>> surface_samples(const Camera& camera, const Mesh& mesh,
                                                       const std::vector<ImageF>& photos, const ImageU8& mask,
                                                       int step) {
  if (step < 1 || step > 1000) throw InvalidInput("the step of samples must be 1 to 1000 pixels");
  if (photos.empty()) throw InvalidInput("a pose needs a photograph for each light");
  const CameraParameters& p = camera.parameters();
  for (const ImageF& photo : photos) {
    if (photo.width() != p.width || photo.height() != p.height || photo.channels() != 3) {
      throw InvalidInput("a photograph has " + size_text(photo.width(), photo.height()) + " pixels; the camera " +
                         size_text(p.width, p.height));
    }
  }
  if (!mask.empty() && !mask.same_size(photos[0])) throw InvalidInput("the mask has another size than the photographs");
  const SeenMesh seen(camera, mesh);
  constexpr double kSmooth = 0.985;  // cos 10 degrees
  std::vector<std::vector<ShadedSample>> samples(photos.size());
  for (int y0 = 0; y0 + step <= p.height; y0 += step) {
    for (int x0 = 0; x0 + step <= p.width; x0 += step) {
      const Vec2 middle(x0 + 0.5 * (step - 1), y0 + 0.5 * (step - 1));
      const auto at = seen.at(middle);
      bool is_whole = at.has_value();
      for (int y = y0; y < y0 + step && is_whole; ++y) {
        for (int x = x0; x < x0 + step && is_whole; ++x) is_whole = is_inside(mask, x, y);
      }
      for (int corner = 0; corner < 4 && is_whole; ++corner) {
        const int column = corner % 2, row = corner / 2;
        const auto there = seen.at({x0 + column * (step - 1.0), y0 + row * (step - 1.0)});
        is_whole = there && there->normal.dot(at->normal) > kSmooth;
      }
      if (!is_whole) continue;
      for (std::size_t k = 0; k < photos.size(); ++k) {
        Vec3 sum = Vec3::Zero();
        for (int y = y0; y < y0 + step; ++y) {
          for (int x = x0; x < x0 + step; ++x) {
            for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(photos[k].at(x, y, c));
          }
        }
        samples[k].push_back({at->point, at->normal, middle, sum / (step * step)});
      }
    }
  }
  if (samples[0].empty()) throw InvalidInput("the camera sees nothing of the object; check `unit` and poses");
  return samples;
}

/// A square of a plane as two triangles. @param normal  Of any length > 0.
Mesh plane_mesh(const Vec3& middle, const Vec3& normal, double side) {
  if (!(normal.norm() > 0) || !normal.allFinite() || !(side > 0))
    throw InvalidInput("the normal of a plane must be longer than 0");
  const Vec3 n = normal.normalized(), u = n.unitOrthogonal(), v = n.cross(u);
  Mesh mesh;
  for (const auto& [a, b] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.5), std::pair(0.5, 0.5), std::pair(-0.5, 0.5)}) {
    mesh.positions.push_back(middle + side * (a * u + b * v));
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_surface = {0, 0};
  mesh.surfaces.resize(1);
  return mesh;
}

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
