#include "tests/benchmarks/capture/bunny.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "libcommon/core/random.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::benchmarks {

namespace {

Bunny read_bunny(const std::filesystem::path& folder) {
  Bunny bunny;
  for (ScanPose pose : read_scan_poses(folder / "data/bun.conf")) {
    pose.world_from_scan.translation *= 1000.0;
    bunny.names.push_back(pose.scan.stem().string());
    bunny.published.push_back(pose.world_from_scan);
    bunny.scans.push_back(read_point_cloud(pose.scan));
    scale_cloud(bunny.scans.back(), 1000.0);
  }
  bunny.derived.resize(bunny.names.size());
  std::ifstream joint(folder / "derived_reference/joint_bunny.txt");
  for (std::string line; std::getline(joint, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    const std::size_t k = bunny.index(std::filesystem::path(name).stem().string());
    if (k == bunny.names.size()) continue;
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 12; ++i) words >> m(i / 4, i % 4);
    bunny.derived[k] = rigid_transform(m);
  }
  std::ifstream pair(folder / "derived_reference/ref_bun000_bun045.txt");
  Eigen::Matrix4d m;
  for (int i = 0; i < 16; ++i) pair >> m(i / 4, i % 4);
  bunny.pair = rigid_transform(m);
  return bunny;
}

Vec3 middle_of(const PointCloud& cloud) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : cloud.points) sum += p;
  return sum / cloud.num_points();
}

Vec3 any_direction(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Vec3(x, y, z).normalized();
}

}  // namespace

std::size_t Bunny::index(const std::string& name) const {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::optional<Bunny> find_bunny() {
  const char* data = std::getenv("PATINATE_DATA");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "scans/bunny")) {
    std::puts("PATINATE_DATA names no folder with scans/bunny; nothing measured");
    return std::nullopt;
  }
  return read_bunny(std::filesystem::path(data) / "scans/bunny");
}

RigidTransform perturbed(const RigidTransform& pose, const PointCloud& source, double angle_deg, double shift_mm,
                         std::uint64_t item) {
  RandomStream random(11, item);
  const Vec3 at = pose.apply(middle_of(source));
  RigidTransform by{rotation_of(any_direction(random) * (angle_deg * kDegree)), Vec3::Zero()};
  by.translation = at + shift_mm * any_direction(random) - by.rotation * at;
  return by * pose;
}

Gap gap(const RigidTransform& a, const RigidTransform& b, const PointCloud& source) {
  const Vec3 middle = middle_of(source);
  return {angle_between_deg(a.rotation, b.rotation), (a.apply(middle) - b.apply(middle)).norm()};
}

}  // namespace patinate::benchmarks
