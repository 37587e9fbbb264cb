// Files of a step: scans, photographs, the reference patch.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/relit/relit_work.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/scan_mesh.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr float kSaturatedCode = 253.5f / 255.0f;  ///< Codes from 254 on count as saturated.
constexpr double kBlackPatch = 1e-4;               ///< Linear value; a code of 8 bits is 3e-4 near black.

/// The surface of ready-made maps: a grid of the photographs' pixels.
PointCloud ready_cloud(const RelitProject& project, const RelitStep::Ready& ready) {
  const ImageF position = read_channels(ready.position, {"X", "Y", "Z"}),
               normal = read_channels(ready.normal, {"X", "Y", "Z"});
  PointCloud cloud;
  PointCloud::Grid grid{position.width(), position.height(), {}};
  for (std::int64_t i = 0; i < position.num_pixels(); ++i) {
    const auto vector_of = [i](const ImageF& image) {
      const float* v = image.data() + 3 * i;
      return Vec3(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    };
    const Vec3 p = vector_of(position), n = vector_of(normal);
    if (!(p.norm() > 0.0) || !(n.norm() > 0.0)) {
      grid.cell.push_back(-1);
      continue;
    }
    grid.cell.push_back(cloud.num_points());
    cloud.points.push_back(project.mm_per_unit * p);
    cloud.normals.push_back(n.normalized());
  }
  if (cloud.points.empty())
    throw IoError(ready.position.string(), "is 0 everywhere, or the normals are; it must hold the surface's positions");
  cloud.grid = std::move(grid);
  cloud.scanner = project.camera_mm.center();
  return cloud;
}

bool is_in_polygon(const std::vector<Vec2>& polygon, double x, double y) {
  bool is_inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[i], &b = polygon[j];
    if ((a.y() > y) != (b.y() > y) && x < (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()) + a.x())
      is_inside = !is_inside;
  }
  return is_inside;
}

template <class Visit>
void visit_patch(const RelitProject& project, const Visit& visit) {
  const std::vector<Vec2>& polygon = project.patch->polygon;
  Vec2 low = polygon.front(), high = polygon.front();
  for (const Vec2& corner : polygon) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  for (int y = std::max(0, static_cast<int>(std::ceil(low.y())));
       y <= std::min(project.height() - 1, static_cast<int>(high.y())); ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(low.x())));
         x <= std::min(project.width() - 1, static_cast<int>(high.x())); ++x) {
      if (is_in_polygon(polygon, x, y)) visit(x, y);
    }
  }
}

}  // namespace

PointCloud read_step_scan(const RelitProject& project, const RelitStep& step) {
  if (step.ready) return ready_cloud(project, *step.ready);
  PointCloud cloud = read_point_cloud(*step.scan);
  scale_cloud(cloud, project.mm_per_unit);
  return cloud;
}

Mesh read_step_mesh(const RelitProject& project, const RelitStep& step) {
  const PointCloud cloud = read_step_scan(project, step);
  try {
    return with_scan_normals(mesh_of_scan(cloud));
  } catch (const InvalidInput& e) {
    throw IoError((step.ready ? step.ready->position : *step.scan).string(), e.what());
  }
}

StepPhoto read_step_photo(const RelitProject& project, const fs::path& file) {
  const ImageInfo info = probe_image(file);
  StepPhoto photo{read_color(file, project.response), std::numeric_limits<float>::infinity()};
  if (photo.values.width() != project.width() || photo.values.height() != project.height()) {
    throw IoError(file.string(), "is " + size_text(photo.values.width(), photo.values.height()) + " pixels; expected " +
                                     size_text(project.width(), project.height()));
  }
  if (info.is_raw) {
    photo.saturation = kSaturatedCode;
  } else if (info.is_integer) {
    photo.saturation = project.response.linear_from_code(kSaturatedCode);
  }
  return photo;
}

ImageF read_step_ambient(const RelitProject& project, const RelitStep& step) {
  if (!step.ambient) return ImageF(project.width(), project.height(), 3);
  return read_step_photo(project, *step.ambient).values;
}

void subtract_ambient(ImageF& photo, const ImageF& ambient) {
  for (std::size_t i = 0; i < photo.values().size(); ++i) photo.values()[i] -= ambient.values()[i];
}

Vec3 patch_mean(const RelitProject& project, const StepPhoto& photo, const ImageF& ambient, const fs::path& file) {
  Vec3 sum = Vec3::Zero();
  int count = 0, num_saturated = 0;
  visit_patch(project, [&](int x, int y) {
    bool is_saturated = false;
    for (int c = 0; c < 3; ++c) {
      is_saturated = is_saturated || !(photo.values.at(x, y, c) < photo.saturation);
      sum[c] += static_cast<double>(photo.values.at(x, y, c)) - static_cast<double>(ambient.at(x, y, c));
    }
    num_saturated += is_saturated ? 1 : 0;
    ++count;
  });
  if (count == 0)
    throw IoError(project.file.string(), "/reference_patch/polygon: covers no pixel's center; give a larger one");
  if (50 * num_saturated > count)
    throw IoError(file.string(),
                  "is saturated on the reference patch: a shorter exposure is needed, or no `reference_patch`");
  sum /= count;
  if (!(sum.minCoeff() > kBlackPatch))
    throw IoError(file.string(),
                  "is black on the reference patch: its light does not reach it, or `polygon` lies elsewhere");
  return sum;
}

void find_patch_target(const RelitProject& project, RelitReference& reference) {
  if (!project.patch || project.steps[project.reference].photos.empty()) return;
  const RelitStep& step = project.steps[project.reference];
  // Where the scan shows the patch, its albedo says what it should show.
  bool is_on_scan = project.has_shape();
  int count = 0;
  std::vector<Vec3> expected(project.lights.size(), Vec3::Zero());
  visit_patch(project, [&](int x, int y) {
    is_on_scan = is_on_scan && reference.view.seen.at(x, y) != 0;
    if (!is_on_scan) return;
    Vec3 p, n;
    for (int c = 0; c < 3; ++c) {
      p[c] = static_cast<double>(reference.view.position_mm.at(x, y, c));
      n[c] = static_cast<double>(reference.view.normal.at(x, y, c));
    }
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double cosine = std::max(0.0, n.dot(direction_to(project.lights[i], p)));
      expected[i] += cosine / std::numbers::pi * project.patch->albedo.cwiseProduct(light_at(project.lights[i], p));
    }
    ++count;
  });
  reference.is_patch_absolute = is_on_scan && count > 0;
  const ImageF ambient = read_step_ambient(project, step);
  for (std::size_t i = 0; i < project.lights.size(); ++i) {
    const Vec3 shown = patch_mean(project, read_step_photo(project, step.photos[i]), ambient, step.photos[i]);
    reference.patch_target.push_back(
        reference.is_patch_absolute && expected[i].minCoeff() > 0.0 ? Vec3(expected[i] / count) : shown);
  }
}

}  // namespace patinate::capture
