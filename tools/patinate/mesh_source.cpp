#include "tools/patinate/mesh_source.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_io.h"

namespace patinate {

namespace {
constexpr std::array<std::pair<std::string_view, double>, 4> kUnits{{{"um", 0.001}, {"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}}};

/// UVs that lean over the edge of the atlas by up to a quarter are scaled into it; what is farther out is tiled, and refused later.
void fit_uvs(Mesh& mesh) {
  constexpr double kSlack = 0.01, kMost = 0.25;
  Vec2 low(0.0, 0.0), high(1.0, 1.0);
  for (const Triangle& corners : mesh.uv_triangles) {
    for (int corner : corners) {
      low = low.cwiseMin(mesh.uvs[static_cast<std::size_t>(corner)]);
      high = high.cwiseMax(mesh.uvs[static_cast<std::size_t>(corner)]);
    }
  }
  const bool leans = low.minCoeff() < -kSlack || high.maxCoeff() > 1.0 + kSlack;
  if (!leans || low.minCoeff() < -kMost || high.maxCoeff() > 1.0 + kMost) return;
  const double scale = 1.0 / (high - low).maxCoeff();
  for (Vec2& uv : mesh.uvs) uv = (uv - low) * scale;
}

}  // namespace

std::optional<std::string> MeshSource::unit_or_none() const {
  const std::string extension = path.extension().string();
  if (unit.empty() && (extension == ".gltf" || extension == ".glb")) return "m";  // By the standard.
  if (unit.empty()) return std::nullopt;
  (void)mm_per_unit(unit);
  return unit;
}

void declare_mesh(CommandLine& line, MeshSource& source) {
  line.positional("MESH", "OBJ, PLY, glTF or GLB with UVs", source.path);
  line.option("unit", "um|mm|cm|m", "Length unit of the mesh file; glTF is in m, other files do not say: without, sizes are relative", source.unit);
  line.suggestions({"um", "mm", "cm", "m"});
  line.option("node", "NAME", "Only the surfaces of this node", source.node);
  line.option("material", "NAME", "Only the surfaces of this material", source.material);
}

Mesh load_mesh(const MeshSource& source) {
  (void)source.unit_or_none();
  Mesh mesh = read_mesh(source.path);
  if (!source.node.empty() || !source.material.empty()) {
    try {
      mesh = select_surfaces(mesh, source.node, source.material);
    } catch (const InvalidInput& e) {
      throw IoError(source.path.string(), e.what());
    }
  }
  fit_uvs(mesh);
  return with_normals(std::move(mesh));
}

double mm_per_unit(const std::string& unit) {
  const auto it = std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& u) { return u.first == unit; });
  if (it == kUnits.end()) throw UsageError("--unit: found `" + unit + "`; expected one of um, mm, cm, m");
  return it->second;
}

void describe(OptionVisitor& v, AtlasOptions& o) {
  v.visit({"resolution", "Texels along each side of the atlas", "", between(16, 16384)}, o.resolution);
}

TexelMap make_texel_map(const std::filesystem::path& path, const Mesh& mesh, const AtlasOptions& atlas, const RunControl& control) {
  try {
    return TexelMap(mesh, atlas.resolution, atlas.resolution, control);
  } catch (const InvalidInput& e) {
    throw IoError(path.string(), e.what());
  }
}

}  // namespace patinate
