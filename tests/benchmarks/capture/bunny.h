/// \file
/// The bunny's ten range scans with the poses that are known of them, and how far two poses are apart.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate::benchmarks {

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;

struct Bunny {
  std::vector<std::string> names;
  std::vector<PointCloud> scans;          ///< mm.
  std::vector<RigidTransform> published;  ///< bun.conf.
  std::vector<RigidTransform> derived;    ///< derived_reference/joint_bunny.txt.
  RigidTransform pair;                    ///< bun000 from bun045, derived.
  [[nodiscard]] std::size_t index(const std::string& name) const;
};
/// Finds $PATINATE_DATA/scans/bunny; nothing, and a line that says so, when it is not there.
[[nodiscard]] std::optional<Bunny> find_bunny();

/// Turned about the source's middle, as `pose` puts it, and shifted, each in any direction.
[[nodiscard]] RigidTransform perturbed(const RigidTransform& pose, const PointCloud& source, double angle_deg,
                                       double shift_mm, std::uint64_t item);

struct Gap {
  double deg = 0.0;
  double mm = 0.0;  ///< Distance of the source's middle.
};
[[nodiscard]] Gap gap(const RigidTransform& a, const RigidTransform& b, const PointCloud& source);

}  // namespace patinate::benchmarks
