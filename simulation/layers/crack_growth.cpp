#include "simulation/layers/crack_growth.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "simulation/layers/chart_walk.h"
#include "simulation/layers/crack_relief.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kWeakPurpose = 0x7765616Bu, kBeginPurpose = 0x62656769u, kTurnPurpose = 0x7475726Eu;
constexpr std::uint32_t kTexelsAWeakPlace = 4;
constexpr double kSpread = 0.1;        ///< Weak places are up to this much stronger than the layer's strength.
constexpr double kRunningShare = 0.2;  ///< A crack runs on down to this share of the stress at which it begins.
constexpr float kCloseRelief = 0.74F;  ///< exp(-0.3): no crack begins closer to another than 0.3 relief lengths.
constexpr double kTurn = 1.5;          ///< Radians a relief length, where one axis is relieved wholly.
constexpr double kWander = 0.25;       ///< Deviation of a way after a relief length, radians.
constexpr float kMostTurn = 0.5F;      ///< Radians a texel.
constexpr int kMostCode = 255;

std::array<float, 2> middle_of(const TileGrid& grid, TexelIndex texel) {
  constexpr float kHalf = 0.5F;
  return {static_cast<float>(grid.x(texel)) + kHalf, static_cast<float>(grid.y(texel)) + kHalf};
}

SurfaceVector unit(const SurfaceVector& v) {
  const float length = std::sqrt(v[0] * v[0] + v[1] * v[1]);
  return {v[0] / length, v[1] / length};
}

/// @param angle  Small, radians.
SurfaceVector rotated(const SurfaceVector& v, float angle) { return unit({v[0] - angle * v[1], v[1] + angle * v[0]}); }

}  // namespace

struct CrackGrowth::Begin {
  double ratio = 0.0;  ///< Of the largest tension and the strength; 0 where no crack can begin.
  std::uint16_t next_look = 0;
  SurfaceVector way{1.0F, 0.0F};
};

CrackGrowth::CrackGrowth(LayerAtlas& layers, std::uint64_t seed) : layers_(&layers), seed_(seed) {
  weak_.resize(layers.num_layers());
  pull_.fill(1.0);
  const std::uint32_t num_texels = layers.surface().grid().num_texels();
  for (int object = 0; object < layers.num_objects(); ++object) {
    for (int l = 1; l < layers.num_layers(object); ++l) {
      const std::optional<LayerCracks>& cracks = layers.cracks(object, l);
      if (cracks) weak_[l].resize(num_texels);
      if (cracks && cracks->tension) pull_[l] = std::max(pull_[l], cracks->tension->ratio);
    }
  }
  for (int l = 1; l < layers.num_layers(); ++l) {
    parallel_for(static_cast<std::int64_t>(weak_[l].size()), 1 << 16, {}, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<TexelIndex>(begin); t < end; ++t) {
        const double random = random_at(l, t, kWeakPurpose) * kTexelsAWeakPlace;
        if (random < 1.0) weak_[l][t] = static_cast<std::uint8_t>(1 + static_cast<int>(random * kMostCode));
      }
    });
  }
}

double CrackGrowth::random_at(int layer, TexelIndex texel, std::uint32_t purpose) const {
  return RandomStream(seed_, texel, purpose + static_cast<std::uint32_t>(layer)).uniform();
}

double CrackGrowth::strength_at(int layer, TexelIndex texel) const {
  return layers_->strength().amount(layer, texel) * (1.0 + kSpread * (weak_[layer][texel] - 1) / (kMostCode - 1));
}

void CrackGrowth::find_seeds(TileIndex tile, std::vector<LayerTexel>& out) const {
  const TexelIndex first = tile * TileGrid::kTileTexels;
  for (int l = 1; l < layers_->num_layers(); ++l) {
    const std::span<const std::uint16_t> stress = layers_->stress().tile(l, tile);
    if (weak_[l].empty() || stress.empty()) continue;
    const std::span<const std::uint16_t> next = layers_->next_look().tile(l, tile);
    for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
      if (weak_[l][first + i] == 0 || stress[i] == 0 || (!next.empty() && stress[i] < next[i])) continue;
      if (pull_[l] * stress[i] > strength_at(l, first + i) && !layers_->is_open(l, first + i))
        out.push_back({.texel = first + i, .layer = static_cast<std::uint32_t>(l)});
    }
  }
}

CrackGrowth::Begin CrackGrowth::begin_at(const LayerTexel& seed) const {
  const int layer = static_cast<int>(seed.layer);
  const bool is_there = layers_->thickness().amount(layer, seed.texel) != 0 && !layers_->is_open(layer, seed.texel);
  const bool does_crack =
      layers_->cracks(layers_->surface().object(layers_->surface().triangle(seed.texel)), layer).has_value();
  if (!is_there || !does_crack) return {};
  const Relief relief = relief_at(*layers_, layer, seed.texel, middle_of(layers_->surface().grid(), seed.texel),
                                  relief_length_mm(*layers_, layer, seed.texel));
  const double left = relief.nearest > kCloseRelief ? 0.0 : 1.0 - static_cast<double>(relief.least);
  const double strength = strength_at(layer, seed.texel), needed = left > 0.0 ? strength / left : kMaxAmount;
  const double ratio = layers_->stress().amount(layer, seed.texel) * left / std::max(1.0, strength);
  // The less the tensions along the axes differ, the more does chance decide.
  const SineCosine turn = portable_sine_cosine(random_at(layer, seed.texel, kBeginPurpose));
  const SurfaceVector random{static_cast<float>(turn.cosine), static_cast<float>(turn.sine)};
  const float sure = std::min(1.0F, relief.most - relief.least);
  const float sign = relief.across[0] * random[0] + relief.across[1] * random[1] < 0.0F ? -1.0F : 1.0F;
  return {.ratio = ratio,
          .next_look = static_cast<std::uint16_t>(std::min<double>(needed, kMaxAmount)),
          .way = unit({sure * sign * relief.across[0] + (1.0F - sure) * random[0],
                       sure * sign * relief.across[1] + (1.0F - sure) * random[1]})};
}

void CrackGrowth::note(const LayerTexel& seed, const Begin& begin) {
  const std::span<std::uint16_t> looks =
      layers_->next_look().writable_tile(static_cast<int>(seed.layer), TileGrid::tile_of(seed.texel));
  looks[seed.texel % TileGrid::kTileTexels] = begin.next_look;
}

void CrackGrowth::open(const LayerTexel& at) {
  layers_->add_crack(static_cast<int>(at.layer), at.texel);
  changed_.push_back(TileGrid::tile_of(at.texel));
}

bool CrackGrowth::touches(const CrackTip& tip, TexelIndex before) const {
  for (const TexelIndex n : layers_->surface().neighbors(tip.texel)) {
    if (n != kNoTexel && n != before && layers_->is_open(static_cast<int>(tip.layer), n)) return true;
  }
  return false;
}

CrackGrowth::Move CrackGrowth::move(CrackTip& tip, double length_mm) {
  const int layer = static_cast<int>(tip.layer);
  const std::uint16_t stress = layers_->stress().amount(layer, tip.texel);
  if (static_cast<float>(stress) < tip.waits_for) return Move::Wait;
  const Relief relief = relief_at(*layers_, layer, tip.texel, tip.place, length_mm, &tip.way);
  constexpr double kLeastLeft = 1e-3;
  tip.waits_for = static_cast<float>(kRunningShare * layers_->strength().amount(layer, tip.texel) /
                                     std::max(kLeastLeft, 1.0 - static_cast<double>(relief.least)));
  if (static_cast<float>(stress) < tip.waits_for) return Move::Wait;
  const ChartWalk straight(layers_->surface(), tip.texel, tip.place, tip.way);
  const auto step = static_cast<float>(static_cast<double>(straight.step_mm()) / length_mm);
  const float cosine = tip.way[0] * relief.across[0] + tip.way[1] * relief.across[1];
  const float sine = tip.way[0] * relief.across[1] - tip.way[1] * relief.across[0];
  const float turn = static_cast<float>(kTurn) * (relief.most - relief.least) * 2.0F * sine * cosine * step;
  constexpr double kRange = 3.4641016151377544;  // sqrt(12): of a uniform number with deviation 1.
  const auto chance = static_cast<float>((random_at(layer, tip.texel, kTurnPurpose) - 0.5) * kRange * kWander);
  tip.way = rotated(tip.way, std::clamp(turn + chance * std::sqrt(step), -kMostTurn, kMostTurn));
  ChartWalk walk(layers_->surface(), tip.texel, tip.place, tip.way);
  if (!walk.advance()) return Move::End;
  const TexelIndex before = std::exchange(tip.texel, walk.texel());
  tip.place = walk.place();
  tip.way = walk.way();
  tip.waits_for = 0.0F;
  if (tip.texel == before) return Move::On;
  if (layers_->is_open(layer, tip.texel)) return Move::End;
  open({.texel = tip.texel, .layer = tip.layer});
  return touches(tip, before) ? Move::End : Move::On;
}

bool CrackGrowth::run(CrackTip& tip) {
  const double length_mm = relief_length_mm(*layers_, static_cast<int>(tip.layer), tip.texel);
  for (double mm = 0.0; mm < length_mm; mm += layers_->surface().median_texel_size_mm()) {
    const Move moved = move(tip, length_mm);
    if (moved != Move::On) return moved == Move::Wait;
  }
  return true;
}

std::vector<TileIndex> CrackGrowth::grow(std::span<const LayerTexel> seeds, const RunControl& control) {
  changed_.clear();
  std::vector<CrackTip>& tips = layers_->tips();
  std::erase_if(tips, [&](CrackTip& tip) { return !run(tip); });
  struct Ranked {
    LayerTexel seed;
    Begin begin;
  };
  std::vector<Ranked> ranked(seeds.size());
  parallel_for(static_cast<std::int64_t>(seeds.size()), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) ranked[i] = {seeds[i], begin_at(seeds[i])};
  });
  for (const Ranked& each : ranked) note(each.seed, each.begin);
  std::erase_if(ranked, [](const Ranked& each) { return !(each.begin.ratio > 1.0); });
  std::sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
    return a.begin.ratio != b.begin.ratio ? a.begin.ratio > b.begin.ratio : a.seed < b.seed;
  });
  for (const Ranked& each : ranked) {
    const Begin begin = begin_at(each.seed);
    note(each.seed, begin);
    if (!(begin.ratio > 1.0)) continue;
    open(each.seed);
    for (const float sign : {1.0F, -1.0F}) {
      CrackTip tip{.texel = each.seed.texel,
                   .layer = each.seed.layer,
                   .place = middle_of(layers_->surface().grid(), each.seed.texel),
                   .way = {sign * begin.way[0], sign * begin.way[1]}};
      if (run(tip)) tips.push_back(tip);
    }
  }
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  return changed_;
}

}  // namespace patinate::simulation
