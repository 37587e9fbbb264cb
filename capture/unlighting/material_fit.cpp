#include "capture/unlighting/material_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "capture/unlighting/color_clusters.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kMaxMaterials = 6;  ///< See docs/algorithms/materials.md.
constexpr int kMaterialRounds = 12;       ///< See docs/algorithms/materials.md, step 1.
constexpr double kMinShare = 0.01;        ///< Share of the texels; smaller classes go to the others.
constexpr double kDistrust = 4.0;         ///< Chi-square counts a fourth: errors of the model are alike among samples.
constexpr double kMaxOff = 60.0;          ///< Chi-square of one texel: more says no more.
constexpr double kNeighbor = 1.0;         ///< Weight of a neighbor of the same color.
constexpr std::int64_t kMaterialTexelsAChunk = 256;

/// Chi-square of a texel under a material, with a penalty for albedos of its own; not more than kMaxOff above the
/// best, which the caller sees to.
double cost_of(const TexelEvidence& texel, const SurfaceMaterial& material, std::size_t roughness) {
  const double penalty = 3.0 * std::log(std::max(4.0, static_cast<double>(texel.num_values)));
  if (material.kind == MaterialKind::Matt) return texel.matt + penalty;
  if (material.kind == MaterialKind::Metal || texel.is_black_beside(material.strength, roughness))
    return texel.black - texel.metal[roughness].gain(material.strength);
  return texel.matt - texel.glossy[roughness].gain(material.strength) + penalty;
}

/// Nonnegative least squares of strengths, channel by channel in turn; a channel that tells nothing is 0.
Vec3 tinted_strength(const ChannelLobe& sums, double least_own) {
  Vec3 s = Vec3::Zero();
  for (int round = 0; round < 50; ++round) {
    for (int c = 0; c < 3; ++c) {
      if (!(sums.lobe(c, c) > least_own * sums.whole[c]) || !(sums.lobe(c, c) > 0.0)) continue;
      const double rest = sums.value[c] - sums.lobe.row(c).dot(s) + sums.lobe(c, c) * s[c];
      s[c] = std::clamp(rest / sums.lobe(c, c), 0.0, 2.0);
    }
  }
  const bool is_gray = !(sums.whole[1] > 0.0) && !(sums.whole[2] > 0.0);
  return is_gray ? Vec3::Constant(s[0]) : s;
}

Vec3 white_strength(const ChannelLobe& sums, double least_own) {
  const double ll = sums.lobe.sum(), lv = sums.value.sum();
  if (!(ll > least_own * sums.whole.sum()) || !(ll > 0.0)) return Vec3::Zero();
  return std::clamp(lv / ll, 0.0, 1.0) * Vec3::Ones();
}

struct Candidate {
  SurfaceMaterial material;
  double cost = 0.0;
};

/// The lobe of a kind that explains most of pooled sums.
/// @param sums  For each roughness.
Candidate best_of(MaterialKind kind, const std::vector<ChannelLobe>& sums, double without) {
  Candidate best{{.kind = kind}, std::numeric_limits<double>::infinity()};
  const double least_own = kind == MaterialKind::Metal ? 0.0 : kMinOwn;
  std::vector<double> gains(sums.size());
  std::vector<Vec3> strengths(sums.size());
  std::size_t at = 0;
  for (std::size_t r = 0; r < sums.size(); ++r) {
    strengths[r] =
        kind == MaterialKind::Dielectric ? white_strength(sums[r], least_own) : tinted_strength(sums[r], least_own);
    gains[r] = sums[r].gain(strengths[r]);
    if (gains[r] > gains[at]) at = r;
  }
  if (!(gains[at] > kSignificantGain)) return best;
  best.cost = without - gains[at];
  best.material.strength = strengths[at];
  best.material.roughness = kLobeRoughness[at];
  if (at > 0 && at + 1 < gains.size()) {  // A parabola through the best and its neighbors.
    const double left = gains[at - 1], right = gains[at + 1], bend = left - 2.0 * gains[at] + right;
    const double shift = bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
    const std::size_t other = shift < 0.0 ? at - 1 : at + 1;
    best.material.roughness += std::abs(shift) * (kLobeRoughness[other] - kLobeRoughness[at]);
    best.material.strength += std::abs(shift) * (strengths[other] - strengths[at]);
  }
  return best;
}

/// Texels beside each: at most four of its step, and its place in the steps before and after.
class Neighbors {
 public:
  explicit Neighbors(const std::vector<TexelEvidence>& texels) : texels_(texels), of_(texels.size()) {
    std::map<std::tuple<int, int, int>, int> rows, columns, times;
    for (std::size_t i = 0; i < texels.size(); ++i) {
      const TexelEvidence& t = texels[i];
      link(rows, {t.step, t.y, 0}, static_cast<int>(i));
      link(columns, {t.step, t.x, 1}, static_cast<int>(i));
      link(times, {t.x, t.y, 2}, static_cast<int>(i));
    }
  }
  /// Adds the shares of neighbors, as far as they are of the texel's color.
  void add(std::size_t i, const MaterialShares& shares, std::vector<double>& score) const {
    for (const int j : of_[i]) {
      const double weight = kNeighbor * likeness(texels_[i].color, texels_[j].color);
      for (std::size_t k = 0; k < score.size(); ++k) score[k] += weight * shares[j][k];
    }
  }

 private:
  using Key = std::tuple<int, int, int>;
  /// Texels come row by row, step by step: the last of a row, a column or a place is the neighbor.
  void link(std::map<Key, int>& last, const Key& key, int i) {
    const auto [found, is_new] = last.try_emplace(key, i);
    if (is_new) return;
    of_[i].push_back(found->second);
    of_[found->second].push_back(i);
    found->second = i;
  }
  const std::vector<TexelEvidence>& texels_;
  std::vector<std::vector<int>> of_;
};

/// One round of shares. @param before  Of the round before; empty at first.
MaterialShares assigned(const std::vector<TexelEvidence>& texels, const std::vector<SurfaceMaterial>& materials,
                        const std::vector<std::size_t>& at, const Neighbors& neighbors, const MaterialShares& before,
                        const RunControl& control) {
  MaterialShares shares(texels.size());
  parallel_for(static_cast<std::int64_t>(texels.size()), kMaterialTexelsAChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   std::vector<double> belief(materials.size(), 0.0);
                   if (!before.empty()) neighbors.add(i, before, belief);
                   shares[i] = shares_of_texel(texels[i], materials, at, std::move(belief));
                 }
               });
  return shares;
}

MaterialShares clusters_of_color(const std::vector<TexelEvidence>& texels) {
  std::vector<Vec3> colors;
  for (const TexelEvidence& t : texels) colors.push_back(t.color);
  const ColorClusters clusters = color_clusters(colors, kMaxMaterials);
  MaterialShares shares(texels.size(), std::vector<double>(clusters.centers.size(), 0.0));
  for (std::size_t i = 0; i < texels.size(); ++i) shares[i][clusters.of[i]] = 1.0;
  return shares;
}

/// Material of the texels by their share in class `k`: its lobe, kind, color.
/// @param last  What it was before; nothing at first.
SurfaceMaterial material_of(const std::vector<TexelEvidence>& texels, const MaterialShares& shares, std::size_t k,
                            const SurfaceMaterial* last) {
  const bool has_last = last != nullptr && last->strength.sum() > 0.0;
  const std::size_t last_at = has_last ? nearest_lobe_roughness(last->roughness) : 0;
  std::vector<ChannelLobe> glossy(kLobeRoughness.size()), metal(kLobeRoughness.size());
  double matt = 0.0, black = 0.0, beside = 0.0, penalty = 0.0, count = 0.0;
  Vec3 color = Vec3::Zero(), squares = Vec3::Zero();
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const TexelEvidence& t = texels[i];
    const double share = shares[i][k];
    if (!(share > 1e-4)) continue;
    const bool is_black = has_last && t.is_black_beside(last->strength, last_at);
    const double numbers = share * 3.0 * std::log(std::max(4.0, static_cast<double>(t.num_values)));
    for (std::size_t r = 0; r < kLobeRoughness.size(); ++r) {
      glossy[r].add(share, is_black ? t.metal[r] : t.glossy[r]);
      metal[r].add(share, t.metal[r]);
    }
    beside += share * (is_black ? t.black : t.matt);
    matt += share * t.matt + numbers;
    black += share * t.black;
    if (!is_black) penalty += numbers;
    count += share;
    color += share * t.color;
    squares += share * t.color.cwiseAbs2();
  }
  if (!(count > 0.0)) return {};
  std::vector<Candidate> found{{{.kind = MaterialKind::Matt}, matt}};
  Candidate dielectric = best_of(MaterialKind::Dielectric, glossy, beside + penalty),
            mixed = best_of(MaterialKind::Mixed, glossy, beside + penalty),
            metallic = best_of(MaterialKind::Metal, metal, black);
  mixed.cost += kSignificantGain;  // Two more numbers, and clearly.
  found.insert(found.end(), {dielectric, mixed, metallic});
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  SurfaceMaterial material = found[0].material;
  material.evidence = found[1].cost - found[0].cost;
  material.share = count / static_cast<double>(texels.size());
  material.color = color / count;
  material.spread = (squares / count - material.color.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  return material;
}

std::vector<SurfaceMaterial> materials_of(const std::vector<TexelEvidence>& texels, const MaterialShares& shares,
                                          const std::vector<SurfaceMaterial>& last, const RunControl& control) {
  std::vector<SurfaceMaterial> all(shares.front().size());
  parallel_for(static_cast<std::int64_t>(all.size()), 1, control, [&](std::int64_t k, std::int64_t) {
    all[k] = material_of(texels, shares, static_cast<std::size_t>(k), last.size() == all.size() ? &last[k] : nullptr);
  });
  std::vector<SurfaceMaterial> kept;
  std::copy_if(all.begin(), all.end(), std::back_inserter(kept),
               [](const SurfaceMaterial& m) { return m.share >= kMinShare; });
  return kept;
}

}  // namespace

std::size_t nearest_lobe_roughness(double roughness) {
  const auto near = std::min_element(kLobeRoughness.begin(), kLobeRoughness.end(), [&](double a, double b) {
    return std::abs(a - roughness) < std::abs(b - roughness);
  });
  return static_cast<std::size_t>(near - kLobeRoughness.begin());
}

double likeness(const Vec3& one, const Vec3& other) {
  constexpr double kAlike = 0.025;  // Distance of colors, standard deviation.
  return std::exp(-0.5 * (one - other).squaredNorm() / (kAlike * kAlike));
}

std::vector<double> shares_of_texel(const TexelEvidence& texel, const std::vector<SurfaceMaterial>& materials,
                                    const std::vector<std::size_t>& at, std::vector<double> score) {
  std::vector<double> cost(materials.size());
  for (std::size_t k = 0; k < materials.size(); ++k) cost[k] = cost_of(texel, materials[k], at[k]);
  const double least = *std::min_element(cost.begin(), cost.end());
  for (std::size_t k = 0; k < materials.size(); ++k) {
    const SurfaceMaterial& m = materials[k];
    score[k] += std::log(m.share) - 0.5 * std::min(kMaxOff, cost[k] - least) / kDistrust;
    for (int c = 0; c < 3; ++c) {
      const double spread = std::max(kMinColorSpread, m.spread[c]), off = (texel.color[c] - m.color[c]) / spread;
      score[k] -= 0.5 * std::min(kMaxOff, off * off) + std::log(spread);
    }
  }
  const double most = *std::max_element(score.begin(), score.end());
  double sum = 0.0;
  for (double& s : score) {
    s = std::exp(s - most);
    sum += s;
  }
  for (double& s : score) s /= sum;
  return score;
}

std::vector<SurfaceMaterial> find_materials(const std::vector<TexelEvidence>& texels, const RunControl& control) {
  if (texels.empty()) return {};
  const RunControl silent = control.silent();
  const Neighbors neighbors(texels);
  MaterialShares shares = clusters_of_color(texels);
  std::vector<SurfaceMaterial> materials = materials_of(texels, shares, {}, silent);
  for (int round = 0; round < kMaterialRounds; ++round) {
    std::vector<std::size_t> at;
    for (const SurfaceMaterial& m : materials) at.push_back(nearest_lobe_roughness(m.roughness));
    const bool has_same = !shares.empty() && shares.front().size() == materials.size();
    shares = assigned(texels, materials, at, neighbors, has_same && round > 0 ? shares : MaterialShares{}, silent);
    materials = materials_of(texels, shares, materials, silent);
    control.report(static_cast<double>(round + 1) / kMaterialRounds);
  }
  return materials;
}

MaterialShares shares_of_materials(const std::vector<TexelEvidence>& texels,
                                   const std::vector<SurfaceMaterial>& materials, const std::vector<std::size_t>& at,
                                   const RunControl& control) {
  constexpr int kTurns = 3;  // Turns over neighbors.
  const RunControl silent = control.silent();
  const Neighbors neighbors(texels);
  MaterialShares shares;
  for (int round = 0; round < kTurns; ++round) shares = assigned(texels, materials, at, neighbors, shares, silent);
  control.report(1.0);
  return shares;
}

}  // namespace patinate::capture
