#include "simulation/flakes/lifted_flakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulation/layers/crack_relief.h"

namespace patinate::simulation {

namespace {

constexpr std::array<std::array<int, 2>, 4> kBeside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
constexpr double kMmPerQuantum = 1e-3 / LayerAtlas::kQuantaPerUm;

/// f(index) for texels around one, diagonal ones too.
template <class F>
void for_each_around(const LiftedFlakes& all, int x, int y, F&& f) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx != 0 || dy != 0) && all.is_inside(x + dx, y + dy)) f(all.index(x + dx, y + dy));
    }
  }
}

/// What layers are at a texel, without flakes. @returns the lifted layer; 0 = none.
int read_texel(const LayerAtlas& layers, TexelIndex t, std::size_t i, LiftedFlakes& all) {
  const SurfaceAtlas& surface = layers.surface();
  if (!surface.is_covered(t)) return 0;
  const int triangle = surface.triangle(t), object = surface.object(triangle), top = layers.tops()[t];
  all.chart[i] = surface.charts()[triangle];
  const unsigned loose = layers.loose()[t], cracked = layers.cracked()[t];
  for (int l = 1; l <= top; ++l) {
    if (layers.cracks(object, l) && ((loose | cracked) >> l & 1U) == 0) all.holds[i] |= 1U << l;
  }
  if (top == 0 || !layers.cracks(object, top)) return 0;
  if ((cracked >> top & 1U) != 0) {
    all.cracked[i] = static_cast<std::uint8_t>(top);
    const double share = crack_width_mm(layers, top, t) / surface.median_texel_size_mm();
    all.crack_share[i] = static_cast<float>(std::min(1.0, share));
    return 0;
  }
  return (loose >> top & 1U) != 0 ? top : 0;
}

/// Sums over a flake's texels, in their order.
struct Sums {
  std::int64_t area = 0, thickness = 0, stress = 0;
  double shrinkage = 0.0;
};

class Finder {
 public:
  explicit Finder(const LayerAtlas& layers) : layers_(layers), grid_(layers.surface().grid()) {
    all_.width = grid_.width;
    all_.height = grid_.height;
    const auto n = static_cast<std::size_t>(all_.width) * static_cast<std::size_t>(all_.height);
    all_.flake.assign(n, -1);
    all_.chart.assign(n, -1);
    all_.holds.assign(n, 0);
    all_.cracked.assign(n, 0);
    all_.crack_share.assign(n, 0.0F);
    all_.lifted.assign(n, 0);
    all_.bare.assign(n, 0);
    free_.assign(n, 0);
  }

  LiftedFlakes find() {
    if (!layers_.has_cracks()) return std::move(all_);
    for_each_texel([&](int x, int y, std::size_t i) {
      all_.lifted[i] = static_cast<std::uint8_t>(read_texel(layers_, grid_.index(x, y), i, all_));
    });
    for_each_texel([&](int x, int y, std::size_t) { free_wide_parts(x, y); });
    for_each_texel([&](int x, int y, std::size_t i) {
      if (free_[i] != 0) add_piece(x, y);
    });
    for_each_texel([&](int x, int y, std::size_t) { mark_bare_crack(x, y); });
    return std::move(all_);
  }

 private:
  template <class F>
  void for_each_texel(F&& f) {
    for (int y = 0; y < all_.height; ++y) {
      for (int x = 0; x < all_.width; ++x) f(x, y, all_.index(x, y));
    }
  }

  /// Frees what is lifted in the square of three texels around one, if nothing there is missing.
  void free_wide_parts(int x, int y) {
    if (x == 0 || y == 0 || x + 1 == all_.width || y + 1 == all_.height) return;
    const std::size_t at = all_.index(x, y);
    for (int layer = 1; layer < layers_.num_layers(); ++layer) {
      const auto is_there = [&](std::size_t i) {
        return all_.chart[i] == all_.chart[at] && (all_.lifted[i] == layer || (all_.holds[i] >> layer & 1U) != 0);
      };
      bool is_whole = is_there(at);
      for_each_around(all_, x, y, [&](std::size_t i) { is_whole = is_whole && is_there(i); });
      if (!is_whole) continue;
      const auto free = [&](std::size_t i) {
        if (all_.lifted[i] == layer) free_[i] = all_.lifted[i];
      };
      free(at);
      for_each_around(all_, x, y, free);
    }
  }

  void add_piece(int x, int y) {
    const int layer = free_[all_.index(x, y)];
    std::vector<std::array<int, 2>> texels{{x, y}};
    free_[all_.index(x, y)] = 0;
    for (std::size_t k = 0; k < texels.size(); ++k) {
      const auto [px, py] = texels[k];
      for (const auto& [dx, dy] : kBeside) {
        if (!all_.is_inside(px + dx, py + dy)) continue;
        const std::size_t beside = all_.index(px + dx, py + dy);
        if (free_[beside] != layer || all_.chart[beside] != all_.chart[all_.index(x, y)]) continue;
        free_[beside] = 0;
        texels.push_back({px + dx, py + dy});
      }
    }
    std::vector<std::array<int, 2>> bare;
    bool has_hinge = false;
    for (const auto& [px, py] : texels) {
      const bool is_beside = is_beside_hold(px, py, layer);
      has_hinge = has_hinge || is_beside;
      if (!is_beside) bare.push_back({px, py});
    }
    // Narrower than two texels: nothing lies off the row that is beside what holds.
    if (!has_hinge || bare.empty()) return;
    const auto number = static_cast<std::int32_t>(all_.flakes.size());
    Sums sums;
    for (const auto& [px, py] : texels) {
      all_.flake[all_.index(px, py)] = number;
      add_to(sums, grid_.index(px, py), layer);
    }
    for (const auto& [px, py] : bare) all_.bare[all_.index(px, py)] = 1;
    const double area = static_cast<double>(sums.area);
    const double thickness = static_cast<double>(sums.thickness) / area * kMmPerQuantum;
    const double strain = sums.shrinkage * static_cast<double>(sums.stress) / area / kAmountOne;
    all_.flakes.push_back({.layer = layer,
                           .num_texels = static_cast<std::int64_t>(texels.size()),
                           .thickness_mm = thickness,
                           .radius_mm = strain > 0.0 ? thickness / strain : std::numeric_limits<double>::infinity()});
  }

  void add_to(Sums& sums, TexelIndex t, int layer) const {
    const SurfaceAtlas& surface = layers_.surface();
    const std::int64_t weight = surface.weight(t);
    sums.area += weight;
    sums.thickness += weight * layers_.thickness().amount(layer, t);
    sums.stress += weight * layers_.stress().amount(layer, t);
    sums.shrinkage = layers_.cracks(surface.object(surface.triangle(t)), layer)->shrinkage;
  }

  [[nodiscard]] bool is_beside_hold(int x, int y, int layer) const {
    bool holds = false;
    const int chart = all_.chart[all_.index(x, y)];
    for_each_around(all_, x, y, [&](std::size_t i) {
      holds = holds || (all_.chart[i] == chart && (all_.holds[i] >> layer & 1U) != 0);
    });
    return holds;
  }

  void mark_bare_crack(int x, int y) {
    const std::size_t at = all_.index(x, y);
    if (all_.cracked[at] == 0) return;
    for_each_around(all_, x, y, [&](std::size_t i) {
      if (all_.bare[i] != 0 && all_.flake[i] >= 0 && all_.chart[i] == all_.chart[at] &&
          all_.flakes[static_cast<std::size_t>(all_.flake[i])].layer == all_.cracked[at])
        all_.bare[at] = 1;
    });
  }

  const LayerAtlas& layers_;
  const TileGrid& grid_;
  LiftedFlakes all_;
  std::vector<std::uint8_t> free_;  ///< The layer that may be a flake and is in no piece yet; 0 = none.
};

}  // namespace

LiftedFlakes find_lifted_flakes(const LayerAtlas& layers) { return Finder(layers).find(); }

}  // namespace patinate::simulation
