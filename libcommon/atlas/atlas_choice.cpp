#include <algorithm>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/unwrap.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

std::string rule_text(UvLayoutRule rule, std::size_t count) {
  const std::string number = std::to_string(count);
  switch (rule) {
    case UvLayoutRule::Udim:
      return number + (count == 1 ? " UDIM tile" : " UDIM tiles");
    case UvLayoutRule::Material:
      return "a tile for each of its " + number + " materials";
    case UvLayoutRule::Node:
      return "a tile for each of its " + number + " nodes";
    case UvLayoutRule::Surface:
      return "a tile for each of its " + number + " pairs of node and material";
    case UvLayoutRule::Square:
      break;
  }
  return "one square";
}

void note_tiles(AtlasMesh& atlas, const std::string& remark) {
  if (atlas.rule == UvLayoutRule::Square) {
    if (!remark.empty()) atlas.notes.push_back(remark);
    return;
  }
  constexpr std::size_t kMaxListed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMaxListed, atlas.tiles.size()); ++i)
    list += (i == 0 ? "" : ", ") + atlas.tiles[i].name;
  if (atlas.tiles.size() > kMaxListed) list += ", ...";
  atlas.notes.push_back("the atlas has " + rule_text(atlas.rule, atlas.tiles.size()) + " (" + list + ")" +
                        (remark.empty() ? "" : ": " + remark) +
                        (atlas.rule == UvLayoutRule::Udim ? "" : "; --node or --material chooses some of them"));
}

AtlasMesh unwrapped(const Mesh& mesh, int resolution, const std::string& reason, const RunControl& control) {
  UnwrapResult result = unwrap(mesh, {.resolution = resolution}, control);
  AtlasMesh atlas;
  atlas.mesh = std::move(result.mesh);
  atlas.tiles.assign(1, {});
  atlas.triangle_tile.assign(atlas.mesh.triangles.size(), 0);
  atlas.is_unwrapped = true;
  atlas.notes.push_back("unwrapped" + (reason.empty() ? std::string() : ", as " + reason) + ": " +
                        std::to_string(result.num_charts) + (result.num_charts == 1 ? " chart" : " charts") + " on " +
                        percent_text(result.packing) + " of the atlas, lengths within a factor of " +
                        short_number_text(rounded(result.stretch.p95, 3)) + " for 95 % of the area");
  return atlas;
}

}  // namespace

AtlasMesh make_atlas_mesh(Mesh mesh, AtlasMethod method, int resolution, const RunControl& control) {
  if (method == AtlasMethod::Unwrap) return unwrapped(mesh, resolution, "", control);
  UvLayout layout = find_uv_layout(mesh);
  if (method == AtlasMethod::Auto && !layout.problem.empty())
    return unwrapped(mesh, resolution, layout.problem, control);
  if (layout.tiles.empty()) throw InvalidInput(layout.problem + "; --atlas unwrap makes new ones");
  const std::string remark = layout.remark, problem = layout.problem;
  const double overlap = layout.overlap_share;
  AtlasMesh atlas = atlas_mesh_of(std::move(mesh), std::move(layout));
  note_tiles(atlas, remark);
  if (!problem.empty()) {
    atlas.notes.push_back(
        problem + "; places that share a texel age alike, and places without a texel get no color of their own");
  } else if (overlap > 0.001) {
    atlas.notes.push_back(
        percent_text(overlap) +
        " of its texels belong to more than one place; they age alike (--atlas unwrap keeps them apart)");
  }
  control.report(1.0);
  return atlas;
}

}  // namespace patinate
