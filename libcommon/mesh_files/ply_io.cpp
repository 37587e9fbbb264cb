#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "libcommon/mesh_files/ply_parser.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Surfaces in PLY files.
class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path) : ply_(path), builder_(ply_.file()) {}

  Mesh read() {
    bool has_faces = false;
    for (const PlyParser::Element& e : ply_.elements()) {
      element_ = &e;
      ply_.begin(e);
      if (e.name == "vertex") {
        read_vertices();
      } else if (e.name == "face" || e.name == "tristrips") {
        has_faces = has_faces || e.count > 0;
        read_faces(e.name == "tristrips");
      } else {
        for (std::uint64_t row = 0; ply_.has_rows() && row < e.count; ++row) ply_.read_row();
      }
    }
    ply_.finish();
    if (!has_faces) {
      ply_.fail("no faces, only " + std::to_string(vertices_.size()) + " points (a point cloud); a surface is needed");
    }
    return builder_.finish();
  }

 private:
  void read_vertices() {
    const auto& e = *element_;
    const std::array<int, 3> xyz{e.find({"x"}), e.find({"y"}), e.find({"z"})};
    const std::array<int, 3> n{e.find({"nx"}), e.find({"ny"}), e.find({"nz"})};
    const std::array<int, 2> uv{e.find({"s", "u", "texture_u"}), e.find({"t", "v", "texture_v"})};
    const auto all = [](const auto& indices) {
      return std::all_of(indices.begin(), indices.end(), [](int i) { return i >= 0; });
    };
    if (!all(xyz)) ply_.fail("element `vertex` has no x, y and z");
    const auto value = [this](int i) { return ply_.scalar(i); };
    for (std::uint64_t row = 0; row < e.count; ++row) {
      ply_.read_row();
      MeshBuilder::Corner& corner = vertices_.emplace_back();
      corner.position = {value(xyz[0]), value(xyz[1]), value(xyz[2])};
      if (all(n)) corner.normal = Vec3(value(n[0]), value(n[1]), value(n[2]));
      if (all(uv)) corner.uv = Vec2(value(uv[0]), value(uv[1]));
    }
  }

  const MeshBuilder::Corner& vertex(double index) const { return vertices_[ply_.index(index, vertices_.size())]; }

  void read_faces(bool is_strips) {
    const int corners = element_->find({"vertex_indices", "vertex_index"});
    const int texcoord = element_->find({"texcoord"});
    if (corners < 0 || !element_->properties[corners].count_type) {
      ply_.fail("element `" + element_->name + "` has no list `vertex_indices`");
    }
    for (std::uint64_t row = 0; row < element_->count; ++row) {
      ply_.read_row();
      const std::vector<double>& indices = ply_.list(corners);
      if (is_strips) {
        add_strips(indices);
        continue;
      }
      polygon_.clear();
      for (double i : indices) polygon_.push_back(vertex(i));
      if (texcoord >= 0) {
        const std::vector<double>& uv = ply_.list(texcoord);
        for (std::size_t k = 0; k < polygon_.size() && uv.size() == 2 * polygon_.size(); ++k) {
          polygon_[k].uv = Vec2(uv[2 * k], uv[2 * k + 1]);
        }
      }
      builder_.add_polygon(polygon_);
    }
  }

  /// Stanford's strips: -1 starts again, every second triangle is turned.
  void add_strips(const std::vector<double>& indices) {
    std::size_t start = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] == -1.0) {
        start = i + 1;
      } else if (i >= start + 2) {
        const bool is_turned = (i - start) % 2 == 1;
        polygon_ = {vertex(indices[i - (is_turned ? 1 : 2)]), vertex(indices[i - (is_turned ? 2 : 1)]),
                    vertex(indices[i])};
        builder_.add_polygon(polygon_);
      }
    }
  }

  PlyParser ply_;
  MeshBuilder builder_;
  const PlyParser::Element* element_ = nullptr;
  std::vector<MeshBuilder::Corner> vertices_, polygon_;
};

}  // namespace

Mesh read_ply(const std::filesystem::path& path) { return PlyReader(path).read(); }

}  // namespace patinate
