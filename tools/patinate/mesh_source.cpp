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
}

std::optional<std::string> MeshSource::unit_or_none() const {
  if (unit.empty()) return std::nullopt;
  (void)mm_per_unit(unit);
  return unit;
}

void declare_mesh(CommandLine& line, MeshSource& source) {
  line.positional("MESH", "OBJ, PLY, glTF or GLB with UVs", source.path);
  line.option("unit", "um|mm|cm|m", "Length unit of the mesh file; without, sizes are relative", source.unit);
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
