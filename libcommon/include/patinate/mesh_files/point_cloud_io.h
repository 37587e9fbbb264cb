/// \file
/// Scans from files, in double precision, and where the scans of an object stand. Files are not trusted: every count is
/// bounded before allocating.
#pragma once

#include <filesystem>
#include <vector>

#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate {

/// Reads by extension. Points that are not finite are excluded, and what refers to them with them; nothing is merged or
/// scaled.
///  - .ply: ASCII and both binary forms; vertices with normals (nx ny nz) and colors (red green blue), faces (polygons
///  are fanned),
///    tristrips; Stanford range grids (`obj_info num_cols`, `num_rows`, element `range_grid`), seen from +z.
///  - .obj: v, vn where it has the vertex's index, f.
///  - .pcd: ascii, binary and binary_compressed; x y z, normal_x.., rgb or rgba; an organized cloud keeps its grid, and
///  VIEWPOINT is the
///    scanner (an unorganized cloud with VIEWPOINT 0 0 0 does not say where the scanner stood).
/// @throws IoError if it is missing, truncated, malformed, or holds no finite point.
[[nodiscard]] PointCloud read_point_cloud(const std::filesystem::path& path);
/// Binary PLY of doubles: points, normals, colors (8 bit) and triangles; no date. @throws CannotComplete
void write_point_cloud(const std::filesystem::path& path, const PointCloud& cloud);

/// One `bmesh FILE tx ty tz qx qy qz qw` line of a Stanford .conf: p_world = R(q)^T p + t.
struct ScanPose {
  std::filesystem::path scan;      ///< Relative paths are taken from the .conf's folder.
  RigidTransform world_from_scan;  ///< Translation in the file's unit.
};
/// Lines of other kinds (`camera`) and comments (#) are skipped. @throws IoError naming the line; also if there is
/// no scan.
[[nodiscard]] std::vector<ScanPose> read_scan_poses(const std::filesystem::path& path);
/// Numbers read back to the same transform within rounding. @throws CannotComplete; InvalidInput if a name holds a
/// blank.
void write_scan_poses(const std::filesystem::path& path, const std::vector<ScanPose>& poses);

}  // namespace patinate
