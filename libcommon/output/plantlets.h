/// \file
/// Small plants where much has grown [Guenther et al. 2012, sec. 4.5]. Each has its place, its size and the amount from
/// which on it shows, by hashes: a place does not move when the amounts change, and its plant grows with them.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "patinate/output/render_surface.h"

namespace patinate {

inline constexpr int kNumPlantKinds = 3;  ///< Shoots, tufts, rosettes.

struct Plant {
  std::uint64_t place = 0;  ///< Number of the place where it grows: equal for all amounts.
  Vec3 root = Vec3::Zero();
  Vec3 up = Vec3::UnitY();
  Vec2 uv = Vec2::Zero();
  int kind = 0;               ///< Below kNumPlantKinds.
  double size = 1.0;          ///< Height.
  double turn = 0.0;          ///< Around `up`, radians.
  Vec3 color = Vec3::Zero();  ///< Linear, of the middle of its leaves.
};

/// A place where a plant grows as soon as there is enough.
struct PlantPlace {
  Plant plant;                    ///< Full-grown, its root on the smooth surface; without a color.
  Vec3 normal = Vec3::UnitZ();    ///< Of the smooth surface.
  double threshold = 0.0;         ///< Amount from which on it shows, as a seedling.
  Vec3 own_color = Vec3::Zero();  ///< Part of the plant's color that does not depend on what it grows on.
  double share_below = 0.0;       ///< How much of the color of what it grows on is added.
  int triangle = 0;

  /// Height of the plant, of what it grows to: 0 below the threshold.
  [[nodiscard]] double height_at(double amount) const;
};
/// All places of a surface, whatever its amounts. At most 100,000.
[[nodiscard]] std::vector<PlantPlace> plant_places(const Mesh& mesh, const RenderOptions& options,
                                                   const SurfaceOptions& surface);

/// Plants of a surface with their roots on its relief: 1.5 for each square of `plant_size`, times `plants`, where the
/// amount suffices; at most 100,000 places. None without a map.
[[nodiscard]] std::vector<Plant> find_plants(const Mesh& mesh, const SurfaceMaps& maps, const RenderOptions& options,
                                             const SurfaceOptions& surface);

/// One plant of a kind, of height 1 at most, around an upright stem along z.
struct PlantShape {
  std::vector<Vec3> positions;
  std::vector<double> shades;  ///< By position: factor of the plant's color.
  std::vector<Triangle> triangles;
};
[[nodiscard]] PlantShape plant_shape(int kind);
/// Columns: where the shape's x, y and z point for a plant, unit.
[[nodiscard]] Eigen::Matrix3d plant_frame(const Vec3& up, double turn);

/// Triangles of a mesh that are leaves.
class PlantField {
 public:
  PlantField() = default;
  PlantField(std::size_t first, std::vector<Vec3> colors) : first_(first), colors_(std::move(colors)) {}
  [[nodiscard]] bool is_leaf(std::size_t triangle) const { return !colors_.empty() && triangle >= first_; }
  /// Linear, at a point of a leaf.
  [[nodiscard]] Vec3 color(std::size_t triangle, double b1, double b2) const;

 private:
  std::size_t first_ = 0;
  std::vector<Vec3> colors_;  ///< Colors of plants.
};

/// Appends the leaves to a mesh with UVs and normals. @param open  Ambient visibility of its positions; gets 1 for
/// the leaves, whose shades know that stems are in the dark.
[[nodiscard]] PlantField add_plants(Mesh& mesh, const std::vector<Plant>& plants, std::vector<float>& open);

}  // namespace patinate
