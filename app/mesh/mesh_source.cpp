#include "app/mesh/mesh_source.h"

#include <string>
#include <utility>
#include <vector>

#include "app/request/failure.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_repair.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::app {

namespace {
/// Adds the file's name in front of what is wrong with the mesh.
template <class Make>
auto naming_file(const MeshSource& source, Make&& make) {
  try {
    return make();
  } catch (const InvalidInput& e) {
    throw IoError(source.path.string(), e.what());
  } catch (...) {
    rethrow_naming(source.path);
  }
}

}  // namespace

std::optional<std::string> MeshSource::unit_or_none() const {
  if (unit.empty() && is_gltf_file(path)) return "m";  // By the standard.
  if (unit.empty()) return std::nullopt;
  (void)mm_per_unit(unit);
  return unit;
}

Mesh load_mesh(const MeshSource& source, const Words& say) {
  (void)source.unit_or_none();
  return naming_file(source, [&] {
    std::vector<std::string> notes;
    Mesh mesh = read_mesh(source.path, &notes);
    for (const std::string& note : notes) say.note(source.path.string() + ": " + note);
    if (!source.node.empty() || !source.material.empty()) mesh = select_surfaces(mesh, source.node, source.material);
    RepairedMesh repaired = repair_mesh(std::move(mesh));
    if (const std::string text = repaired.repairs.text(); !text.empty()) say.note(source.path.string() + ": " + text);
    return with_normals(std::move(repaired.mesh));
  });
}

Range resolution_range() { return between(16, 16384); }

void describe(OptionVisitor& v, AtlasOptions& o) {
  v.visit({"resolution", "Texels along each side of the atlas, or of each of its tiles", "", resolution_range()},
          o.resolution);
  v.visit_choice(
      {"atlas", "auto: use the mesh's UVs if each place has its own texel, else unwrap; uv, unwrap: always do so"},
      o.method, kAtlasMethodNames);
}

AtlasMesh make_atlas(const MeshSource& source, Mesh mesh, const AtlasOptions& options, const RunControl& control) {
  return naming_file(source,
                     [&] { return make_atlas_mesh(std::move(mesh), options.method, options.resolution, control); });
}

void note_atlas(const MeshSource& source, const AtlasMesh& atlas, const Words& say) {
  for (const std::string& note : atlas.notes) say.note(source.path.string() + ": " + note);
}

TexelMap make_texel_map(const MeshSource& source, const AtlasMesh& atlas, int resolution, const RunControl& control) {
  return naming_file(source, [&] { return make_texel_map(atlas, resolution, control); });
}

}  // namespace patinate::app
