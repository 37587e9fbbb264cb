#include "tools/studio/material_plane.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/output/aging_mesh.h"
#include "libcommon/output/occlusion.h"
#include "libcommon/output/relief.h"
#include "simulation/job/frame_maps.h"

namespace patinate::studio {

namespace {

std::uint8_t code(double share) { return static_cast<std::uint8_t>(255.0 * std::clamp(share, 0.0, 1.0) + 0.5); }

constexpr int kMaxRays = 6'400'000;  ///< 64 of `render` for 100,000 vertices; finer meshes get fewer for each.
constexpr int kMinSamples = 8;

/// Puts values of a triangle's corners into the texels that it covers, and those beside it that nothing covers better.
class Raster {
 public:
  explicit Raster(const simulation::SurfaceAtlas& surface)
      : surface_(surface),
        beside_(surface.grid().num_texels(), static_cast<float>(kBeside)),
        values_(surface.grid().num_texels(), 0.0f) {}

  void add(const std::array<Vec2, 3>& uvs, const std::array<float, 3>& values) {
    const simulation::TileGrid& grid = surface_.grid();
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = Vec2(uvs[k].x() * grid.width - 0.5, (1.0 - uvs[k].y()) * grid.height - 0.5);
    const Vec2 a = p[1] - p[0], b = p[2] - p[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    if (!(std::abs(area) > 1e-12)) return;
    const Vec2 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    const auto begin = [](double v) { return std::max(0, static_cast<int>(std::floor(v - kBeside))); };
    const auto end = [](double v, int size) { return std::min(size - 1, static_cast<int>(std::ceil(v + kBeside))); };
    for (int y = begin(low.y()); y <= end(high.y(), grid.height); ++y) {
      for (int x = begin(low.x()); x <= end(high.x(), grid.width); ++x) {
        const Vec2 q = Vec2(x, y) - p[0];
        Vec3 weight(0.0, (q.x() * b.y() - q.y() * b.x()) / area, (a.x() * q.y() - a.y() * q.x()) / area);
        weight.x() = 1.0 - weight.y() - weight.z();
        const Vec3 inside = weight.cwiseMax(0.0) / weight.cwiseMax(0.0).sum();
        const double off = (inside.x() * p[0] + inside.y() * p[1] + inside.z() * p[2] - Vec2(x, y)).norm();
        const simulation::TexelIndex t = grid.index(x, y);
        if (!(off < static_cast<double>(beside_[t])) || !surface_.is_covered(t)) continue;
        beside_[t] = static_cast<float>(off);
        values_[t] = 0.0f;
        for (std::size_t k = 0; k < 3; ++k) values_[t] += static_cast<float>(inside[static_cast<int>(k)]) * values[k];
      }
    }
  }
  [[nodiscard]] const std::vector<float>& values() const { return values_; }

 private:
  static constexpr double kBeside = 2.0;  ///< Texels.
  const simulation::SurfaceAtlas& surface_;
  std::vector<float> beside_, values_;
};

/// By TexelIndex, as `render` finds it at the vertices of a refined mesh.
std::vector<std::uint8_t> hidden_light(const simulation::Simulation& simulation, const RunControl& control) {
  RenderOptions options;
  const Mesh mesh = refined_for_occlusion(with_shared_positions(with_normals(simulation.mesh())), options);
  options.occlusion_samples = std::clamp(kMaxRays / std::max(1, static_cast<int>(mesh.positions.size())), kMinSamples,
                                         options.occlusion_samples);
  const std::vector<float> open =
      occlusion_at_vertices(mesh, RayScene(mesh), bounding_box(mesh).diagonal(), options, control);
  Raster raster(simulation.atlas().surface());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec2, 3> uvs;
    std::array<float, 3> hidden{};
    for (std::size_t k = 0; k < 3; ++k) {
      uvs[k] = mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[t][k])];
      hidden[k] = 1.0f - open[static_cast<std::size_t>(mesh.triangles[t][k])];
    }
    raster.add(uvs, hidden);
  }
  std::vector<std::uint8_t> codes;
  for (const float v : raster.values()) codes.push_back(code(static_cast<double>(v)));
  return codes;
}

}  // namespace

MaterialPlane::MaterialPlane(const simulation::Simulation& simulation, const ScreenLayout& layout,
                             const RunControl& control)
    : layout_(&layout),
      has_metal_(simulation::TexelMetal::is_in(simulation.scene())),
      film_(film_of(simulation.scene())),
      plant_(simulation::plant_material(simulation.scene())),
      hidden_(hidden_light(simulation, control)),
      bytes_(std::size_t{layout.num_tiles()} * kTileBytes, 0) {}

int MaterialPlane::film_of(const simulation::Scene& scene) {
  return scene.tracing.bounce_normal == simulation::BounceNormal::Mesh ? simulation::film_material(scene) : -1;
}

std::vector<ScreenTile> MaterialPlane::update(const simulation::Simulation& simulation) {
  std::vector<ScreenTile> tiles;
  if (seen_ < 0) {
    tiles.resize(layout_->num_tiles());
    std::iota(tiles.begin(), tiles.end(), ScreenTile{0});
  } else {
    tiles = layout_->showing(simulation.dirty_since(seen_));
  }
  seen_ = simulation.iteration();
  const simulation::MaterialAtlas& atlas = simulation.atlas();
  const simulation::TexelMetal metal(simulation);
  const auto amount = [&](int material, simulation::TexelIndex t) {
    return static_cast<double>(atlas.amount(material, t)) / simulation::kAmountOne;
  };
  std::vector<ScreenTile> changed;
  for (const ScreenTile tile : tiles) {
    const std::array<simulation::TexelIndex, 64> sources = layout_->sources(tile);
    std::array<std::uint8_t, kTileBytes> now{};
    for (std::size_t i = 0; i < 64; ++i) {
      const simulation::TexelIndex t = sources[i];
      if (t == simulation::kNoTexel || !atlas.surface().is_covered(t)) continue;
      if (has_metal_) now[4 * i] = code(static_cast<double>(metal.at(t)));
      if (film_ >= 0) now[4 * i + 1] = code(amount(film_, t) / app::kWetFilm);
      if (plant_ >= 0) now[4 * i + 2] = code(amount(plant_, t));
      now[4 * i + 3] = hidden_[t];
    }
    std::uint8_t* old = &bytes_[std::size_t{tile} * kTileBytes];
    if (std::equal(now.begin(), now.end(), old)) continue;
    std::copy(now.begin(), now.end(), old);
    changed.push_back(tile);
  }
  return changed;
}

}  // namespace patinate::studio
