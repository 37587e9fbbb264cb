#include <algorithm>
#include <array>
#include <limits>

#include "libcommon/core/text.h"
#include "libcommon/mesh_files/ply_parser.h"
#include "libcommon/mesh_files/point_cloud_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 28;

bool all_there(const std::array<int, 3>& properties) {
  return std::all_of(properties.begin(), properties.end(), [](int i) { return i >= 0; });
}

void read_vertices(PlyParser& ply, const PlyParser::Element& e, PointCloudBuilder& builder) {
  const std::array<int, 3> xyz{e.find({"x"}), e.find({"y"}), e.find({"z"})};
  const std::array<int, 3> normal{e.find({"nx"}), e.find({"ny"}), e.find({"nz"})};
  const std::array<int, 3> color{e.find({"red", "diffuse_red", "r"}), e.find({"green", "diffuse_green", "g"}),
                                 e.find({"blue", "diffuse_blue", "b"})};
  if (!all_there(xyz)) ply.fail("element `vertex` has no x, y and z");
  if (e.count > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) ply.fail("more points than 2^31");
  const auto vector = [&](const std::array<int, 3>& p) {
    return Vec3(ply.scalar(p[0]), ply.scalar(p[1]), ply.scalar(p[2]));
  };
  const auto is_code = [&](int p) { return e.properties[p].type == PlyParser::Number::U8; };
  const bool has_colors = all_there(color);
  const double color_scale = has_colors && is_code(color[0]) ? 1.0 / 255.0 : 1.0;
  for (std::uint64_t row = 0; row < e.count; ++row) {
    ply.read_row();
    builder.add_point(vector(xyz), all_there(normal) ? std::optional(vector(normal)) : std::nullopt,
                      has_colors ? std::optional<Vec3>(vector(color) * color_scale) : std::nullopt);
  }
}

void read_faces(PlyParser& ply, const PlyParser::Element& e, PointCloudBuilder& builder) {
  const int corners = e.find({"vertex_indices", "vertex_index"});
  if (corners < 0 || !e.properties[corners].count_type)
    ply.fail("element `" + e.name + "` has no list `vertex_indices`");
  std::vector<std::size_t> polygon;
  for (std::uint64_t row = 0; row < e.count; ++row) {
    ply.read_row();
    const std::vector<double>& list = ply.list(corners);
    polygon.clear();
    if (e.name != "tristrips") {
      for (const double value : list) polygon.push_back(ply.index(value, builder.num_added()));
      builder.add_polygon(polygon);
      continue;
    }
    for (const double value : list) {  // -1 starts again, every second triangle is turned.
      if (value == -1.0) {
        polygon.clear();
        continue;
      }
      polygon.push_back(ply.index(value, builder.num_added()));
      const std::size_t n = polygon.size();
      if (n < 3) continue;
      const std::size_t turn = (n - 3) % 2;
      builder.add_polygon(std::array{polygon[n - 3 + turn], polygon[n - 2 - turn], polygon[n - 1]});
    }
  }
}

/// A cell is a list of no or one index (of more, the first counts).
PointCloud::Grid read_grid(PlyParser& ply, const PlyParser::Element& e, std::size_t num_points) {
  const auto size = [&](std::string_view name) -> std::int64_t {
    const std::optional<double> value = parse_number(ply.obj_info(name));
    if (!value || !(*value >= 1.0 && *value <= 65536.0))
      ply.fail("a range_grid needs `obj_info " + std::string(name) + "` between 1 and 65536");
    return static_cast<std::int64_t>(*value);
  };
  const std::int64_t width = size("num_cols"), height = size("num_rows");
  if (width * height > kMaxCells || static_cast<std::uint64_t>(width * height) != e.count) {
    ply.fail("the range_grid has " + std::to_string(e.count) + " cells; num_cols and num_rows say " +
             size_text(static_cast<int>(width), static_cast<int>(height)));
  }
  const int indices = e.find({"vertex_indices", "vertex_index"});
  if (indices < 0 || !e.properties[indices].count_type) ply.fail("element `range_grid` has no list `vertex_indices`");
  PointCloud::Grid grid{static_cast<int>(width), static_cast<int>(height), {}};
  grid.cell.reserve(e.count);
  for (std::uint64_t row = 0; row < e.count; ++row) {
    ply.read_row();
    const std::vector<double>& list = ply.list(indices);
    grid.cell.push_back(list.empty() ? -1 : static_cast<int>(ply.index(list.front(), num_points)));
  }
  return grid;
}

}  // namespace

PointCloud read_ply_cloud(const std::filesystem::path& path) {
  PlyParser ply(path);
  PointCloudBuilder builder;
  for (const PlyParser::Element& e : ply.elements()) {
    ply.begin(e);
    if (e.name == "vertex") {
      read_vertices(ply, e, builder);
    } else if (e.name == "face" || e.name == "tristrips") {
      read_faces(ply, e, builder);
    } else if (e.name == "range_grid") {
      builder.set_grid(read_grid(ply, e, builder.num_added()));
    } else {
      for (std::uint64_t row = 0; ply.has_rows() && row < e.count; ++row) ply.read_row();
    }
  }
  ply.finish();
  PointCloud cloud = builder.finish(ply.file());
  if (cloud.grid) cloud.toward_scanner = Vec3(0, 0, 1);
  return cloud;
}

}  // namespace patinate
