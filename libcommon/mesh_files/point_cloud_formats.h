/// \file
/// The readers behind read_point_cloud(), one per format, and what they share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/geometry/point_cloud.h"

namespace patinate {

[[nodiscard]] PointCloud read_ply_cloud(const std::filesystem::path& path);
[[nodiscard]] PointCloud read_obj_cloud(const std::filesystem::path& path);
[[nodiscard]] PointCloud read_pcd_cloud(const std::filesystem::path& path);

/// Collects what a file says about its points, then leaves out those that were not measured.
class PointCloudBuilder {
 public:
  /// Normals and colors count when every point that is finite has one.
  void add_point(const Vec3& point, const std::optional<Vec3>& normal = {}, const std::optional<Vec3>& color = {});
  /// Indices of points in the order they were added; fewer than three are ignored.
  void add_polygon(std::span<const std::size_t> corners);
  /// `cell` holds indices of points in the order they were added, -1 = none.
  void set_grid(PointCloud::Grid grid) { cloud_.grid = std::move(grid); }
  [[nodiscard]] std::size_t num_added() const { return new_index_.size(); }
  /// @param file  For the error. @throws IoError if no point is finite.
  [[nodiscard]] PointCloud finish(const std::string& file);

 private:
  PointCloud cloud_;
  std::vector<int> new_index_;  ///< New index of every point added; -1 = excluded.
};

/// Undoes LZF (M. Lehmann's format, as PCD's binary_compressed has it). @throws InvalidInput if it does not give
/// exactly `size` bytes.
[[nodiscard]] std::string lzf_decompress(std::string_view compressed, std::size_t size);

}  // namespace patinate
