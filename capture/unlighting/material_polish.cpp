// Lobes of materials by what foretells left-out lamps.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "capture/unlighting/material_maps.h"
#include "capture/unlighting/specular_choice.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kManyTexels = 240;  ///< Texels of a material that are looked at.
constexpr std::size_t kFewTexels = 80;    ///< Texels of one that is looked at again.
constexpr double kMember = 0.5;           ///< Share of a material from which a texel tells of it.
constexpr double kMaxOfMinerals = 0.2;    ///< Reflectance that no mineral has: diamond has 0.17.
constexpr double kBare = 0.9;             ///< Metalness from which what is not told from metal is taken for it.
constexpr double kPolishStep = 1e-5;      ///< Step of a fit; samples are uncertain by half a percent and more.
constexpr std::int64_t kPlacesAChunk = 16;

class Polish {
 public:
  Polish(const UnlightWork& work, std::vector<std::pair<int, int>> places, const RunControl& control)
      : work_(work), options_(work.fit_options()), places_(std::move(places)), control_(control.silent()) {
    options_.small_step = kPolishStep;
  }

  /// Cost of each texel's left-out lamps; negative where nothing is predicted.
  [[nodiscard]] std::vector<double> costs(const SurfaceMaterial& material) const {
    std::vector<double> found(places_.size());
    parallel_for(static_cast<std::int64_t>(places_.size()), kPlacesAChunk, control_,
                 [&](std::int64_t begin, std::int64_t end) {
                   TexelSamples texel;
                   for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                     const auto [x, y] = places_[i];
                     work_.load_raw(x, y, texel);
                     give(texel, material, x, y);
                     found[i] = left_out_mean(texel, options_, x + y,
                                              [&](const TexelFit& fit, int lamp) { return off_of(texel, fit, lamp); });
                   }
                 });
    return found;
  }

  /// Median over texels of their mean albedo under this lobe.
  [[nodiscard]] double albedo(const SurfaceMaterial& material) const {
    std::vector<double> found;
    TexelSamples texel;
    for (const auto& [x, y] : places_) {
      work_.load_raw(x, y, texel);
      give(texel, material, x, y);
      const TexelFit fit = fit_texel(texel, options_);
      if (fit.is_determined) found.push_back((fit.albedo[0] + fit.albedo[1] + fit.albedo[2]) / work_.num_channels);
    }
    return found.empty() ? 0.0 : median(std::move(found));
  }

 private:
  /// Error of a photograph, in deviations; far off counts in proportion. The model's part is the same for what is
  /// foretold too bright and too dark by one factor: a share of what is seen alone would draw lobes down.
  [[nodiscard]] double off_of(const TexelSamples& texel, const TexelFit& fit, int lamp) const {
    // Error of the form, as a share of the value; the largest noise, of the stated one.
    constexpr double kShare = 0.05, kMaxNoise = 3.0;
    const double noise = std::min(kMaxNoise, work_.noise_scale);
    const double cosine = std::max(0.0, fit.normal.dot(texel.direction[lamp]));
    double cost = 0.0;
    for (int c = 0; c < work_.num_channels; ++c) {
      const auto at = texel.index(lamp, c);
      const double seen = texel.value[at], said = fit.albedo[c] * (texel.irradiance[at] * cosine + texel.ambient[at]) +
                                                  fit.gain * highlight_value(texel, lamp, c, fit.normal);
      const double variance =
          noise * noise * work_.variance_of(seen) + kShare * kShare * seen * std::max(said, 0.1 * seen);
      cost += std::sqrt(1.0 + (said - seen) * (said - seen) / variance) - 1.0;
    }
    return cost;
  }
  void give(TexelSamples& texel, const SurfaceMaterial& material, int x, int y) const {
    const double strength = material.strength.mean();
    if (!(strength > 0.0)) return;
    texel.highlight = {
        .strength = strength,
        .roughness = material.roughness,
        .form = work_.form,
        .tint = {material.strength[0] / strength, material.strength[1] / strength, material.strength[2] / strength},
        .to_camera = work_.to_camera(x, y),
        .freedom = work_.highlight_freedom,
        .metal = material.kind == MaterialKind::Metal ? 1.0 : 0.0};
    work_.add_highlight_variance(texel, texel.normal);
  }

  const UnlightWork& work_;
  TexelFitOptions options_;
  std::vector<std::pair<int, int>> places_;
  RunControl control_;
};

/// Excess cost of one over another, in all and its standard deviation.
std::pair<double, double> excess(const std::vector<double>& one, const std::vector<double>& other) {
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (one[i] < 0.0 || other[i] < 0.0) continue;
    sum += one[i] - other[i];
    squares += (one[i] - other[i]) * (one[i] - other[i]);
  }
  return {sum, std::sqrt(squares)};
}

SurfaceMaterial changed(const SurfaceMaterial& material, double strength, double roughness) {
  SurfaceMaterial out = material;
  out.strength = (strength * out.strength).cwiseMin(2.0);
  out.roughness = std::clamp(roughness * out.roughness, kLobeRoughness.front(), kLobeRoughness.back());
  return out;
}

/// A lobe and what each place costs with it.
struct Judged {
  SurfaceMaterial material;
  std::vector<double> cost;
};

/// Downhill from a material of one kind, with steps that become smaller. A stronger and narrower lobe leaves its tails
/// alone, so that the search goes along such pairs too.
Judged best_near(const Polish& polish, const SurfaceMaterial& start) {
  constexpr int kMaxTurns = 3;  // It ends earlier where no number moves.
  Judged best{start, polish.costs(start)};
  for (const double step : {1.35, 1.15, 1.06}) {
    const double narrow = std::cbrt(step);
    bool has_moved = true;
    for (int turn = 0; turn < kMaxTurns && has_moved; ++turn) {
      has_moved = false;
      for (const auto& [strength, roughness] :
           {std::pair{step, 1.0}, std::pair{1.0 / step, 1.0}, std::pair{1.0, narrow}, std::pair{1.0, 1.0 / narrow},
            std::pair{step, 1.0 / narrow}, std::pair{1.0 / step, narrow}}) {
        Judged next{changed(best.material, strength, roughness), {}};
        next.cost = polish.costs(next.material);
        if (!(excess(next.cost, best.cost).first < 0.0)) continue;
        best = std::move(next);
        has_moved = true;
      }
    }
  }
  return best;
}

/// By how many standard deviations one foretells worse than another; negative: better.
double deviations_worse(const std::vector<double>& one, const std::vector<double>& other) {
  const auto [more, deviation] = excess(one, other);
  return deviation > 0.0 ? more / deviation : 0.0;
}

SurfaceMaterial as_kind(const SurfaceMaterial& found, MaterialKind kind) {
  SurfaceMaterial out = found;
  out.kind = kind;
  if (kind == MaterialKind::Matt) {
    out.strength.setZero();
    out.roughness = 0.0;
    return out;
  }
  if (!(out.strength.sum() > 0.0)) {
    out.strength = Vec3::Constant(0.04);
    out.roughness = 0.5;
  }
  if (kind == MaterialKind::Dielectric) out.strength = Vec3::Constant(std::min(0.15, out.strength.mean()));
  return out;
}

/// The simplest that is not told apart from a richer one: matt, then a white lobe that a mineral may have, then one of
/// a color over an albedo, then metal.
Judged simplest(const Polish& polish, const SurfaceMaterial& found) {
  Judged best = best_near(polish, as_kind(found, MaterialKind::Dielectric));
  const Judged mixed = best_near(polish, as_kind(found, MaterialKind::Mixed)),
               metal = best_near(polish, as_kind(found, MaterialKind::Metal));
  const auto is_better = [&](const Judged& one, const Judged& other) {
    return deviations_worse(one.cost, other.cost) < -kTold;
  };
  const double told = deviations_worse(metal.cost, mixed.cost);
  const bool is_metal = told < -kTold || (told < kTold && metal_share(polish.albedo(mixed.material),
                                                                      mixed.material.strength.mean()) > kBare);
  const bool is_no_mineral = best.material.strength.mean() > kMaxOfMinerals;
  if (is_no_mineral || is_better(mixed, best) || is_better(metal, best)) best = is_metal ? metal : mixed;
  best.material.evidence = std::abs(told);
  Judged matt{as_kind(found, MaterialKind::Matt), {}};
  matt.cost = polish.costs(matt.material);
  const double told_matt = deviations_worse(best.cost, matt.cost);
  if (told_matt < -kTold) return best;
  matt.material.evidence = std::max(0.0, told_matt);
  return matt;
}

/// Places that tell of each material.
std::vector<std::vector<std::pair<int, int>>> places_of(const std::vector<TexelEvidence>& texels,
                                                        const MaterialShares& shares, std::size_t num_materials,
                                                        std::size_t max_count) {
  std::vector<std::vector<std::pair<int, int>>> all(num_materials);
  for (std::size_t k = 0; k < num_materials; ++k) {
    std::vector<std::pair<int, int>> members;
    for (std::size_t i = 0; i < texels.size(); ++i)
      if (shares[i][k] > kMember) members.emplace_back(texels[i].x, texels[i].y);
    const std::size_t count = std::min(max_count, members.size());
    for (std::size_t i = 0; i < count; ++i) all[k].push_back(members[i * members.size() / count]);
  }
  return all;
}

/// Among materials that have a lobe already, the one of which a smaller one is not told apart; or its own.
SurfaceMaterial shared_or_own(const Polish& polish, const std::vector<SurfaceMaterial>& larger, const Judged& own) {
  SurfaceMaterial chosen = own.material;
  double least = kTold;
  for (const SurfaceMaterial& other : larger) {
    SurfaceMaterial lent = other;
    lent.share = own.material.share;
    lent.color = own.material.color;
    lent.spread = own.material.spread;
    const double worse = deviations_worse(polish.costs(lent), own.cost);
    if (!(worse < least)) continue;
    least = worse;
    chosen = lent;
  }
  return chosen;
}

}  // namespace

void polish_materials(const UnlightWork& work, const std::vector<TexelEvidence>& texels,
                      std::vector<SurfaceMaterial>& materials, bool is_last, const RunControl& control) {
  constexpr std::size_t kLeastPlaces = 20;  // See docs/algorithms/materials.md, step 4.
  if (texels.empty() || materials.empty()) return;
  std::vector<std::size_t> at;
  for (const SurfaceMaterial& m : materials) at.push_back(nearest_lobe_roughness(m.roughness));
  const MaterialShares shares = shares_of_materials(texels, materials, at, control.part(0.0, 0.1));
  const auto places = places_of(texels, shares, materials.size(), is_last ? kManyTexels : kFewTexels);
  std::vector<std::size_t> order(materials.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return materials[a].share > materials[b].share; });
  std::vector<SurfaceMaterial> larger;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t k = order[i];
    control.report(0.1 + 0.9 * static_cast<double>(i) / static_cast<double>(order.size()));
    if (places[k].size() < kLeastPlaces && !larger.empty()) continue;  // Too few to tell: others take them.
    const Polish polish(work, places[k], control);
    materials[k] = shared_or_own(polish, larger, simplest(polish, materials[k]));
    larger.push_back(materials[k]);
  }
  materials = std::move(larger);
  control.report(1.0);
}

}  // namespace patinate::capture
