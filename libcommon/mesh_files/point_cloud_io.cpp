#include "patinate/mesh_files/point_cloud_io.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/point_cloud_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

template <class Value>
void append_bytes(std::string& bytes, Value value) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof(Value));
  bytes.append(raw, sizeof(Value));
}

}  // namespace

void PointCloudBuilder::add_point(const Vec3& point, const std::optional<Vec3>& normal,
                                  const std::optional<Vec3>& color) {
  if (!point.allFinite()) {
    new_index_.push_back(-1);
    return;
  }
  new_index_.push_back(cloud_.num_points());
  cloud_.points.push_back(point);
  if (normal && normal->allFinite() && normal->norm() > 0.0) cloud_.normals.push_back(normal->normalized());
  if (color) cloud_.colors.push_back(*color);
}

void PointCloudBuilder::add_polygon(std::span<const std::size_t> corners) {
  if (corners.size() < 3) return;
  std::vector<int> kept;
  for (const std::size_t corner : corners) kept.push_back(new_index_[corner]);
  if (std::find(kept.begin(), kept.end(), -1) != kept.end()) return;
  std::vector<Vec3> positions;
  positions.reserve(kept.size());
  for (const int i : kept) positions.push_back(cloud_.points[i]);
  for (const Triangle& t : triangulate_polygon(positions)) {
    const Triangle triangle{kept[t[0]], kept[t[1]], kept[t[2]]};
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
      cloud_.triangles.push_back(triangle);
  }
}

PointCloud PointCloudBuilder::finish(const std::string& file) {
  if (cloud_.points.empty()) throw IoError(file, new_index_.empty() ? "no points" : "no point of it is finite");
  if (cloud_.normals.size() != cloud_.points.size()) cloud_.normals.clear();
  if (cloud_.colors.size() != cloud_.points.size()) cloud_.colors.clear();
  if (cloud_.grid) {
    for (int& cell : cloud_.grid->cell) cell = cell < 0 ? -1 : new_index_[cell];
  }
  return std::move(cloud_);
}

PointCloud read_point_cloud(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension != ".obj" && extension != ".ply" && extension != ".pcd") {
    throw IoError(path.string(), "no scan format has the extension `" + extension + "`; use .ply, .pcd or .obj");
  }
  require_regular_file(path);
  std::error_code error;
  if (fs::file_size(path, error) == 0 && !error) throw IoError(path.string(), "the file is empty (0 bytes)");
  if (extension == ".obj") return read_obj_cloud(path);
  return extension == ".ply" ? read_ply_cloud(path) : read_pcd_cloud(path);
}

void write_point_cloud(const fs::path& path, const PointCloud& cloud) {
  const bool has_normals = !cloud.normals.empty(), has_colors = !cloud.colors.empty();
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(cloud.points.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) bytes += std::string("property double ") + name + "\n";
  if (has_normals) bytes += "property double nx\nproperty double ny\nproperty double nz\n";
  if (has_colors) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!cloud.triangles.empty()) {
    bytes += "element face " + std::to_string(cloud.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  }
  bytes += "end_header\n";
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) append_bytes(bytes, cloud.points[i][k]);
    for (int k = 0; has_normals && k < 3; ++k) append_bytes(bytes, cloud.normals[i][k]);
    for (int k = 0; has_colors && k < 3; ++k) {
      append_bytes(bytes, static_cast<std::uint8_t>(std::lround(std::clamp(cloud.colors[i][k], 0.0, 1.0) * 255.0)));
    }
  }
  for (const Triangle& t : cloud.triangles) {
    append_bytes(bytes, std::uint8_t{3});
    for (const int corner : t) append_bytes(bytes, std::int32_t{corner});
  }
  write_atomically(path, bytes);
}

}  // namespace patinate
