#include "capture/registration/registration_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kMargin = 0.05;
constexpr double kSlice = 0.012;  ///< Thickness of the slice, of the object's size.
constexpr float kBackground = 0.92f;
/// Linear; told apart by people who see colors differently as well [Okabe and Ito 2008].
constexpr std::array<std::array<float, 3>, 8> kColors{{{0.79f, 0.09f, 0.01f},
                                                       {0.01f, 0.17f, 0.45f},
                                                       {0.0f, 0.34f, 0.17f},
                                                       {0.80f, 0.35f, 0.0f},
                                                       {0.60f, 0.19f, 0.39f},
                                                       {0.09f, 0.45f, 0.81f},
                                                       {0.62f, 0.55f, 0.05f},
                                                       {0.12f, 0.12f, 0.12f}}};

struct Dot {
  Vec3 at;  ///< Right, up, towards the viewer.
  int scan;
};

std::vector<Dot> placed(std::span<const PointCloud> scans, std::span<const RigidTransform> poses,
                        const Eigen::Matrix3d& view) {
  std::vector<Dot> dots;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    for (const Vec3& p : scans[k].points) dots.push_back({view * poses[k].apply(p), static_cast<int>(k)});
  }
  return dots;
}

Box box_of(const std::vector<Dot>& dots) {
  Box box;
  for (const Dot& d : dots) {
    box.low = box.low.cwiseMin(d.at);
    box.high = box.high.cwiseMax(d.at);
  }
  return box;
}

/// Dots as discs, the nearest on top; darker where the surface they make falls away from the viewer.
ImageF splat(const std::vector<Dot>& dots, int size, double radius_px, bool is_shaded) {
  const Box box = box_of(dots);
  const double extent = std::max({box.high.x() - box.low.x(), box.high.y() - box.low.y(), 1e-300});
  const double scale = (1.0 - 2.0 * kMargin) * size / extent;
  const double nothing = -std::numeric_limits<double>::infinity();
  Image<double> depth(size, size, 1, nothing);
  Image<int> owner(size, size, 1, -1);
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (const Dot& d : dots) {
    const double x = 0.5 * size + (d.at.x() - box.center().x()) * scale,
                 y = 0.5 * size - (d.at.y() - box.center().y()) * scale;
    const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (!depth.contains(cx + dx, cy + dy) || dx * dx + dy * dy > radius_px * radius_px) continue;
        if (d.at.z() * scale <= depth.at(cx + dx, cy + dy)) continue;
        depth.at(cx + dx, cy + dy) = d.at.z() * scale;
        owner.at(cx + dx, cy + dy) = d.scan;
      }
    }
  }
  ImageF picture(size, size, 3, kBackground);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (owner.at(x, y) < 0) continue;
      double light = 1.0;
      if (is_shaded) {
        const auto slope = [&](int dx, int dy) {
          double sum = 0.0;
          for (int k = 1; k <= 3; ++k) {
            if (!depth.contains(x + k * dx, y + k * dy) || !depth.contains(x - k * dx, y - k * dy)) continue;
            const double a = depth.at(x + k * dx, y + k * dy), b = depth.at(x - k * dx, y - k * dy);
            if (a > nothing && b > nothing) sum += std::clamp((a - b) / (2.0 * k), -3.0, 3.0) / 3.0;
          }
          return sum;
        };
        const Vec3 normal = Vec3(-slope(1, 0), slope(0, 1), 1.0).normalized();
        light = 0.25 + 0.75 * std::max(0.0, normal.dot(Vec3(-0.4, 0.5, 0.77)));
      }
      const auto& color = kColors[static_cast<std::size_t>(owner.at(x, y)) % kColors.size()];
      for (int c = 0; c < 3; ++c)
        picture.at(x, y, c) = static_cast<float>(light * (0.15 + 0.85 * static_cast<double>(color[c])));
    }
  }
  return picture;
}

/// What lies within a thin slice through the middle, seen from above.
ImageF slice(std::span<const PointCloud> scans, std::span<const RigidTransform> poses, int size) {
  Eigen::Matrix3d from_above;
  from_above << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<Dot> dots = placed(scans, poses, from_above);
  std::vector<double> heights;
  for (const Dot& d : dots) heights.push_back(d.at.z());
  const double middle = median(std::move(heights)), half = 0.5 * kSlice * box_of(dots).diagonal();
  std::erase_if(dots, [&](const Dot& d) { return std::abs(d.at.z() - middle) > half; });
  return splat(dots, size, 1.0, false);
}

}  // namespace

ImageF registration_picture(std::span<const PointCloud> scans, std::span<const RigidTransform> before,
                            std::span<const RigidTransform> after, const RegistrationPictureOptions& options) {
  if (scans.size() != before.size() || scans.size() != after.size())
    throw InvalidInput("registration picture: as many poses as scans are needed");
  if (scans.empty() || scans.front().points.empty()) throw InvalidInput("registration picture: there is no point");
  const Vec3 toward = direction_to_scanner(scans.front(), bounding_box(scans.front()).center()).value_or(Vec3(0, 0, 1));
  const double heading = std::atan2(toward.x(), toward.z());
  const Eigen::Matrix3d view = rotation_of(Vec3(options.tilt_deg * kDegree, 0, 0)) *
                               rotation_of(Vec3(0, -heading - options.turn_deg * kDegree, 0));
  const double dot_px = std::max(1.0, options.panel_px / 260.0);
  const std::array<ImageF, 4> panels{splat(placed(scans, before, view), options.panel_px, dot_px, true),
                                     splat(placed(scans, after, view), options.panel_px, dot_px, true),
                                     slice(scans, before, options.panel_px), slice(scans, after, options.panel_px)};
  const std::array<std::string, 4> labels{"before", "after", "before, cut through", "after, cut through"};
  return contact_strip(panels, labels, {.columns = 2});
}

}  // namespace patinate::capture
