#include "capture/calibration/surface_samples.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "libcommon/core/text.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/error.h"

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

}  // namespace

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

Mesh plane_mesh(const Vec3& middle, const Vec3& normal, double side) {
  if (!(normal.norm() > 0) || !normal.allFinite() || !(side > 0))
    throw InvalidInput("a plane needs a normal of a length above 0");
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

}  // namespace patinate::capture
