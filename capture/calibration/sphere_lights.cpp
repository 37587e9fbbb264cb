#include "patinate/capture/sphere_lights.h"

#include <cmath>
#include <numbers>

#include "capture/calibration/sphere_lights_problem.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kDegPerRadian = 180.0 / std::numbers::pi;

std::string sphere_name(const MirrorSphere& sphere, std::size_t index) {
  return sphere.name.empty() ? "sphere " + std::to_string(index + 1) : "sphere `" + sphere.name + "`";
}

std::vector<SphereFit> fit_spheres(const Camera& camera, const std::vector<MirrorSphere>& spheres) {
  std::vector<SphereFit> fits;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    fits.push_back(fit_sphere(camera, spheres[i]));
    if (fits[i].status == SphereFitStatus::OutOfPicture)
      throw InvalidInput(sphere_name(spheres[i], i) + " is out of the picture");
    if (fits[i].status == SphereFitStatus::NoSphere) {
      throw InvalidInput(sphere_name(spheres[i], i) +
                         ": its outline is not that of a sphere; expected points around it, in pixels");
    }
  }
  return fits;
}

/// The point nearest to rays, and whether they meet in front of all of them.
struct Meeting {
  Vec3 point = Vec3::Zero();
  bool is_ahead = false;
};
Meeting meet(const std::vector<MirroredRay>& rays) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vec3 right = Vec3::Zero();
  for (const MirroredRay& ray : rays) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    normal += across;
    right += across * ray.point;
  }
  const SymmetricEigen<Eigen::Matrix3d> eigen = symmetric_eigen(normal);
  // Least eigenvalue of the rays' normal matrix: parallel rays do not meet.
  constexpr double kParallel = 1e-10;
  Meeting meeting;
  if (!(eigen.values[0] > kParallel)) return meeting;
  meeting.point = solve_ldlt(normal, right);
  meeting.is_ahead = true;
  for (const MirroredRay& ray : rays)
    meeting.is_ahead = meeting.is_ahead && (meeting.point - ray.point).dot(ray.direction) > 0;
  return meeting;
}

Vec3 mean_direction(const std::vector<MirroredRay>& rays) {
  Vec3 sum = Vec3::Zero();
  for (const MirroredRay& ray : rays) sum += ray.direction;
  return sum.normalized();
}

double worst_sd(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, symmetric_eigen(covariance).values[2]));
}

/// How well a near light's distance and direction are known from `eye`.
void describe_near(SphereLight& light, const Vec3& eye) {
  const Vec3 to_light = light.light.position - eye;
  const double distance = to_light.norm();
  const Vec3 along = to_light / distance;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
  light.position_sd_mm = worst_sd(light.covariance);
  light.direction_sd_deg = kDegPerRadian * worst_sd(across * light.covariance * across) / distance;
  light.distance_sd = std::sqrt(std::max(0.0, along.dot(light.covariance * along))) / distance;
}

void check_highlights(const std::vector<MirrorSphere>& spheres, const Highlights& highlights) {
  if (spheres.empty()) throw InvalidInput("lights from spheres need at least one sphere");
  if (highlights.empty()) throw InvalidInput("lights from spheres need at least one light");
  for (const auto& row : highlights) {
    if (row.size() != spheres.size()) throw InvalidInput("highlights must be given for each sphere");
  }
}

}  // namespace

void describe(OptionVisitor& v, SphereLightOptions& o) {
  v.visit({"outline_sigma", "noise of the points on the spheres' outlines", "px", above(0)}, o.outline_sigma_px);
  v.visit({"highlight_sigma", "noise of the highlights", "px", above(0)}, o.highlight_sigma_px);
  v.visit({"max_distance_sd", "a light whose distance is known worse than this share of it is given as a direction", "",
           above(0)},
          o.max_distance_sd);
}

std::string sphere_light_status_text(SphereLightStatus status) {
  switch (status) {
    case SphereLightStatus::Position:
      return "position";
    case SphereLightStatus::DirectionOnly:
      return "direction only";
    case SphereLightStatus::NoHighlight:
      return "no highlight";
  }
  return "";
}

SphereLightResult lights_from_spheres(const Camera& camera, const std::vector<MirrorSphere>& spheres,
                                      const Highlights& highlights, const SphereLightOptions& options,
                                      const RunControl& control) {
  check_ranges(options);
  check_highlights(spheres, highlights);
  SphereLightResult result;
  result.spheres = fit_spheres(camera, spheres);
  const std::size_t num_lights = highlights.size();
  result.lights.resize(num_lights);
  SphereLightProblem problem;
  problem.is_near.assign(num_lights, false);
  problem.is_used.assign(num_lights, false);
  for (const SphereFit& fit : result.spheres) problem.centers.push_back(fit.center);
  std::vector<Vec3> eyes;
  for (std::size_t k = 0; k < num_lights; ++k) {
    std::vector<MirroredRay> rays;
    Vec3 eye = Vec3::Zero();
    for (std::size_t s = 0; s < spheres.size(); ++s) {
      if (!highlights[k][s]) continue;
      const auto ray = mirrored_ray(camera, result.spheres[s].center, spheres[s].radius_mm, *highlights[k][s]);
      if (!ray)
        throw InvalidInput("light " + std::to_string(k + 1) + ": its highlight lies beside " +
                           sphere_name(spheres[s], s));
      rays.push_back(*ray);
      eye += ray->point;
    }
    result.lights[k].num_spheres = static_cast<int>(rays.size());
    problem.is_used[k] = !rays.empty();
    eyes.push_back(rays.empty() ? eye : Vec3(eye / static_cast<double>(rays.size())));
    const Meeting meeting = rays.size() > 1 ? meet(rays) : Meeting();
    problem.is_near[k] = meeting.is_ahead;
    problem.lights.push_back(rays.empty() ? Vec3(0, 0, 1) : meeting.is_ahead ? meeting.point : mean_direction(rays));
  }
  control.throw_if_stopped();
  // Lights whose distance the first solution leaves open become directions for the second.
  SphereLightSolution solution;
  for (int round = 0; round < 2; ++round) {
    solution = refine_sphere_lights(camera, spheres, highlights, options, problem);
    bool is_changed = false;
    for (std::size_t k = 0; k < num_lights; ++k) {
      if (!problem.is_near[k]) continue;
      SphereLight& light = result.lights[k];
      light.light.position = problem.lights[k];
      light.covariance = solution.covariances[k];
      describe_near(light, eyes[k]);
      if (solution.is_determined && light.distance_sd <= options.max_distance_sd) continue;
      problem.is_near[k] = false;
      problem.lights[k] = (problem.lights[k] - eyes[k]).normalized();
      is_changed = true;
    }
    if (!is_changed) break;
  }
  result.has_converged = solution.has_converged && solution.is_determined;
  for (std::size_t s = 0; s < spheres.size(); ++s) result.spheres[s].center = problem.centers[s];
  for (std::size_t k = 0; k < num_lights; ++k) {
    SphereLight& light = result.lights[k];
    if (!problem.is_used[k]) continue;
    light.covariance = solution.covariances[k];
    light.rms_px = solution.rms_px[k];
    light.light.is_intensity_known = false;
    light.light.kind = problem.is_near[k] ? Light::Kind::Near : Light::Kind::Directional;
    if (problem.is_near[k]) {
      light.status = SphereLightStatus::Position;
      light.light.position = problem.lights[k];
      describe_near(light, eyes[k]);
    } else {
      light.status = SphereLightStatus::DirectionOnly;
      light.light.position = Vec3::Zero();
      light.light.direction = problem.lights[k].normalized();
      light.direction_sd_deg = kDegPerRadian * worst_sd(light.covariance);
      light.position_sd_mm = 0.0;
    }
  }
  return result;
}

Camera distant_camera(int width, int height) {
  CameraParameters p;
  p.width = width, p.height = height;
  constexpr double kFarPx = 1e6;  // Focal length that stands for an orthographic camera.
  p.fx = p.fy = kFarPx;
  p.cx = 0.5 * (width - 1), p.cy = 0.5 * (height - 1);
  return Camera(p);
}

}  // namespace patinate::capture
