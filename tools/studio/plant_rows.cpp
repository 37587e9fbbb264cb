#include "tools/studio/plant_rows.h"

#include <algorithm>
#include <array>
#include <vector>

#include "libcommon/output/plantlets.h"

namespace patinate::studio {

std::string plant_rows(const PartedMesh& mesh) {
  std::vector<int> part_of(mesh.mesh.triangles.size(), -1);
  for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
    for (const int t : mesh.parts[p].triangles) part_of[static_cast<std::size_t>(t)] = static_cast<int>(p);
  }
  std::string rows;
  for (const PlantPlace& place : plant_places(mesh.mesh, RenderOptions{}, SurfaceOptions{})) {
    const Plant& plant = place.plant;
    std::array<float, kPlantRow> row{};
    std::size_t n = 0;
    const auto add = [&](double value) { row[n++] = static_cast<float>(value); };
    add(part_of[static_cast<std::size_t>(place.triangle)]);
    add(plant.kind);
    for (const double c : plant.root) add(c);
    for (const double c : plant.up) add(c);
    add(plant.uv.x());
    add(1.0 - plant.uv.y());
    for (const double v : {plant.size, plant.turn, place.threshold, place.share_below}) add(v);
    for (const double c : place.own_color) add(c);
    rows.append(reinterpret_cast<const char*>(row.data()), sizeof(row));
  }
  return rows;
}

}  // namespace patinate::studio
