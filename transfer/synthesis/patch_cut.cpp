#include "transfer/synthesis/patch_cut.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

namespace patinate::transfer {

namespace {

constexpr std::int32_t kOnePixel = PixelNeighbor::kOne;
/// Texels of the rim and of the window that are compared for a candidate.
constexpr int kNumRim = 160, kNumSpread = 16;
constexpr int kApart_px = 4;            // Candidates nearer to each other are one.
constexpr int kNumCommon = 4;           // Pieces that are in the patch already.
constexpr std::int32_t kMaxOff = 1200;  // A rim texel that differs by more is no worse: the cut goes round it.
constexpr std::int32_t kAmountCost =
    200;  // Price of a look that has twice its share; half or twice as much: docs/benchmarks.md.
constexpr std::int32_t kReuseCost = 40;  // Reuse cost of a piece that is there twice as often as it should be.
constexpr std::int32_t kNearbyCost =
    300;  // Price of each copy too many near by, where there is no structure that it could
          // break. Chosen on copper from 40, 120, 300 and 800: docs/benchmarks.md.
constexpr std::int32_t kNever = 1'000'000;  // Cost of a texel where nothing can be copied.

FixedPoint operator-(const FixedPoint& a, const FixedPoint& b) { return {a.x - b.x, a.y - b.y}; }
bool is_near(const PieceCenter& a, const PieceCenter& b, std::int32_t most) {
  constexpr int kAlike = kFullTurn / 64;  // Turns by less are one.
  return std::abs(a.point.x - b.point.x) <= most && std::abs(a.point.y - b.point.y) <= most &&
         std::abs(difference_of(a.turn, b.turn)) <= kAlike;
}
/// The center of the piece that shows a place at a texel of a patch. @param turn  Of the piece at the center.
PieceCenter center_of(const FixedPoint& point, const FixedPoint& offset, Turn turn) {
  return {point - turned(offset, turn), turn};
}
FixedPoint middle_of(std::int32_t pixel, std::int32_t width) {
  return {pixel % width * kOnePixel, pixel / width * kOnePixel};
}

/// Every count-th of n things, evenly.
template <class Visit>
void for_each_of(std::size_t n, std::size_t count, const Visit& visit) {
  count = std::min(n, count);
  for (std::size_t i = 0; i < count; ++i) visit(i * n / count);
}

}  // namespace

std::int32_t PatchCut::unary(TexelId texel, const Place& place, std::int32_t from) const {
  if (place.pixel < 0) return kNever;
  const auto target = task_.destination.target(texel);
  // A new place is one copy more.
  const bool is_counted = from >= 0 && task_.nearby.is_one_cell(place.pixel, from);
  const std::int32_t too_many =
      std::max(0, task_.nearby.copies(texel, place.pixel) - (is_counted ? NearbyUses::kOneCopy : 0));
  return task_.control_cost.at(target, place.pixel) +
         (kAmountCost * task_.amounts.price(target, place.pixel) + kReuseCost * task_.amounts.reuse(place.pixel) +
          kNearbyCost * too_many) /
             256;
}

void PatchCut::begin(const SurfacePatch& patch, const PlaceMap& places) {
  current_.clear();
  unary_cost_.clear();
  outside_.clear();
  seam_cost_.clear();
  for (const PatchTexel& t : patch.texels) {
    current_.push_back(places.at(t.texel));
    unary_cost_.push_back(unary(t.texel, current_.back(), current_.back().pixel));
  }
  for (const PatchEdge& e : patch.edges) {
    const Place& first = current_[e.first];
    outside_.push_back(e.second < 0 ? places.at(e.outside) : Place{});
    const Place& second = e.second < 0 ? outside_.back() : current_[e.second];
    seam_cost_.push_back(e.weight * task_.features.seam(first, second, e.step, e.turn));
  }
}

std::int64_t PatchCut::score(const PieceCenter& center, std::int64_t bound) const {
  std::int64_t sum = 0;
  for (const ControlSample& s : spread_) {
    const FixedPoint at = center.at(s.offset);
    const std::int32_t pixel = task_.features.pixel_at(at.x, at.y);
    sum += spread_weight_ * (pixel < 0 ? kMaxOff : task_.control_cost.at(task_.destination.target(s.texel), pixel));
  }
  for (auto s = telling_rim_.begin(); s != telling_rim_.end() && sum < bound; ++s) {
    const FixedPoint at = center.at(s->offset);
    const std::int32_t pixel = task_.features.pixel_at(at.x, at.y);
    sum += rim_weight_ * (pixel < 0 ? 2 * kMaxOff : std::min(kMaxOff, task_.features.distance(pixel, s->pixel)));
  }
  return sum;
}

void PatchCut::consider(const PieceCenter& center) {
  const auto num_kept = static_cast<std::size_t>(task_.num_tried);
  const std::int64_t bound = best_.size() < num_kept ? std::numeric_limits<std::int64_t>::max() : best_.back().score;
  for (const Candidate& c : best_) {
    if (is_near(c.center, center, kOnePixel / 2)) return;
  }
  const Candidate candidate{center, score(center, bound)};
  if (candidate.score >= bound) return;
  for (auto it = best_.begin(); it != best_.end(); ++it) {
    if (!is_near(it->center, center, kApart_px * kOnePixel)) continue;
    if (it->score <= candidate.score) return;
    best_.erase(it);
    break;
  }
  const auto at = std::upper_bound(best_.begin(), best_.end(), candidate.score,
                                   [](std::int64_t s, const Candidate& c) { return s < c.score; });
  best_.insert(at, candidate);
  if (best_.size() > num_kept) best_.pop_back();
}

/// To the least score near it, by steps of 2 and 1 pixels.
void PatchCut::settle(Candidate& candidate) const {
  for (int step : {2, 1}) {
    bool moved = true;
    for (int round = 0; moved && round < 3; ++round) {
      moved = false;
      const PieceCenter from = candidate.center;
      for (const FixedPoint& d :
           {FixedPoint{step, 0}, FixedPoint{-step, 0}, FixedPoint{0, step}, FixedPoint{0, -step}}) {
        const PieceCenter center{{from.point.x + d.x * kOnePixel, from.point.y + d.y * kOnePixel}, from.turn};
        const std::int64_t s = score(center, candidate.score);
        if (s >= candidate.score) continue;
        candidate = {center, s};
        moved = true;
      }
    }
  }
}

std::vector<PieceCenter> PatchCut::common_centers(const SurfacePatch& patch) const {
  struct Vote {
    std::int64_t key;
    std::size_t texel;
  };
  const auto center_at = [&](std::size_t i) {
    const PatchTexel& t = patch.texels[i];
    return center_of(current_[i].point, t.offset, difference_of(current_[i].turn, t.turn));
  };
  std::vector<Vote> votes;
  for_each_of(patch.texels.size(), 1024, [&](std::size_t i) {
    const FixedPoint center = center_at(i).point;
    votes.push_back({(std::int64_t{whole_pixels(center.y)} << 32) + whole_pixels(center.x), i});
  });
  std::stable_sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) { return a.key < b.key; });
  std::vector<std::pair<std::size_t, std::size_t>> counted;  // How often, where first.
  for (std::size_t i = 0; i < votes.size();) {
    std::size_t end = i;
    while (end < votes.size() && votes[end].key == votes[i].key) ++end;
    counted.emplace_back(end - i, votes[i].texel);
    i = end;
  }
  std::stable_sort(counted.begin(), counted.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<PieceCenter> centers;
  for (const auto& [count, i] : counted) {
    if (centers.size() == kNumCommon || count < 8) break;
    centers.push_back(center_at(i));
  }
  return centers;
}

void PatchCut::find_candidates(const SurfacePatch& patch, RandomStream random) {
  rim_.clear();
  spread_.clear();
  best_.clear();
  std::vector<std::size_t> rim;
  const std::int32_t inner = patch.half_px * kOnePixel * 3 / 5;
  for (std::size_t i = 0; i < patch.texels.size(); ++i) {
    const FixedPoint& o = patch.texels[i].offset;
    if (std::max(std::abs(o.x), std::abs(o.y)) >= inner) rim.push_back(i);
  }
  std::vector<std::size_t> rim_texels;
  for_each_of(rim.size(), kNumRim, [&](std::size_t i) {
    rim_.push_back({patch.texels[rim[i]].offset, current_[rim[i]].pixel});
    rim_texels.push_back(rim[i]);
  });
  telling_rim_ = rim_;
  std::stable_sort(telling_rim_.begin(), telling_rim_.end(), [&](const RimSample& a, const RimSample& b) {
    return task_.features.magnitude(a.pixel) > task_.features.magnitude(b.pixel);
  });
  for_each_of(patch.texels.size(), kNumSpread, [&](std::size_t i) {
    spread_.push_back({patch.texels[i].offset, patch.texels[i].texel});
  });
  // An estimate of what the whole piece would cost: its border, about as long as the patch is round, and its texels.
  rim_weight_ = std::max<std::int64_t>(
      1, 12 * 8 * patch.half_px / static_cast<std::int64_t>(std::max<std::size_t>(1, rim_.size())));
  spread_weight_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(patch.texels.size() / spread_.size()));

  const std::int32_t width = task_.source.width();
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    const std::int32_t pixel = rim_[i].pixel;
    const Place& place = current_[rim_texels[i]];
    const Turn turn = difference_of(place.turn, patch.texels[rim_texels[i]].turn);
    consider(center_of(place.point, rim_[i].offset, turn));
    for (std::int32_t other : task_.similar[pixel]) {
      if (other >= 0) consider(center_of(middle_of(other, width), rim_[i].offset, turn));
    }
  }
  const auto alike = task_.source.similar(task_.destination.target(patch.texels[0].texel), 2 * kSimilarTolerance);
  for (int i = 0; i < task_.num_random; ++i) {
    const std::size_t like = rim_texels.empty() ? 0 : rim_texels[static_cast<std::size_t>(i) % rim_texels.size()];
    const FixedPoint point = middle_of(alike[random.below(static_cast<std::uint32_t>(alike.size()))], width);
    consider({point, difference_of(current_[like].turn, patch.texels[like].turn)});
  }
  for (Candidate& c : best_) settle(c);
}

std::int64_t PatchCut::lay(const SurfacePatch& patch, const PieceCenter& center) {
  const std::size_t n = patch.texels.size(), m = patch.edges.size();
  std::vector<Place> laid(n);
  std::vector<std::int32_t> laid_unary(n);
  std::vector<std::uint8_t> is_same(n);  // Pairs that stay as they are cost what they cost.
  bool is_new = false;
  for (std::size_t i = 0; i < n; ++i) {
    laid[i] = place_at(task_.source, center.at(patch.texels[i].offset), sum_of(center.turn, patch.texels[i].turn));
    is_same[i] = laid[i] == current_[i];
    is_new |= is_same[i] == 0;
    laid_unary[i] = unary(patch.texels[i].texel, laid[i], current_[i].pixel);
  }
  if (!is_new) return 0;
  // By edge: the cost where the first, the second, or both are of the new piece.
  struct Costs {
    std::int32_t first = 0, second = 0, both = 0;
  };
  std::vector<Costs> costs(m);
  cv::detail::GCGraph<std::int32_t> graph;
  graph.create(static_cast<unsigned>(n), static_cast<unsigned>(2 * m));
  for (std::size_t i = 0; i < n; ++i) graph.addVtx();
  graph.addEdges(0, 1, 0, 0);                    // A graph without edges is not cut.
  std::vector<std::int32_t> keeps(n), takes(n);  // Costs of a texel alone to stay as it is, and to change.
  for (std::size_t i = 0; i < n; ++i) {
    keeps[i] = unary_cost_[i];
    takes[i] = laid_unary[i];
  }
  for (std::size_t e = 0; e < m; ++e) {
    const PatchEdge& edge = patch.edges[e];
    const auto i = static_cast<std::size_t>(edge.first);
    const bool is_possible = laid[i].pixel >= 0;
    const auto seam = [&](const Place& a, const Place& b) {
      return edge.weight * task_.features.seam(a, b, edge.step, edge.turn);
    };
    if (edge.second < 0) {
      costs[e].first = is_same[i] != 0 ? seam_cost_[e] : is_possible ? seam(laid[i], outside_[e]) : 0;
      keeps[i] += seam_cost_[e];
      takes[i] += costs[e].first;
      continue;
    }
    const auto j = static_cast<std::size_t>(edge.second);
    const bool second_is_possible = laid[j].pixel >= 0;
    if (is_possible) costs[e].first = is_same[i] != 0 ? seam_cost_[e] : seam(laid[i], current_[j]);
    if (second_is_possible) costs[e].second = is_same[j] != 0 ? seam_cost_[e] : seam(current_[i], laid[j]);
    if (is_possible && second_is_possible)
      costs[e].both = is_same[i] != 0 ? costs[e].second : is_same[j] != 0 ? costs[e].first : seam(laid[i], laid[j]);
    // E = keep + (first - keep) x_i + (both - first) x_j + (first + second - keep - both) (1 - x_i) x_j
    const std::int32_t keep = seam_cost_[e], first = costs[e].first, second = costs[e].second, both = costs[e].both;
    takes[i] += first - keep;
    takes[j] += both - first;
    const std::int32_t capacity = std::max(0, first + second - keep - both);
    if (capacity > 0) graph.addEdges(edge.first, edge.second, capacity, 0);
  }
  for (std::size_t i = 0; i < n; ++i) graph.addTermWeights(static_cast<int>(i), takes[i], keeps[i]);
  graph.maxFlow();
  std::vector<std::uint8_t> is_taken(n);
  std::int64_t change = 0;
  for (std::size_t i = 0; i < n; ++i) {
    is_taken[i] = !graph.inSourceSegment(static_cast<int>(i)) && laid[i].pixel >= 0;
    if (is_taken[i] != 0) change += laid_unary[i] - unary_cost_[i];
  }
  const auto cost_of = [&](std::size_t e) {
    const bool first = is_taken[patch.edges[e].first] != 0;
    const bool second = patch.edges[e].second >= 0 && is_taken[patch.edges[e].second] != 0;
    return first && second ? costs[e].both : first ? costs[e].first : second ? costs[e].second : seam_cost_[e];
  };
  for (std::size_t e = 0; e < m; ++e) change += cost_of(e) - seam_cost_[e];
  if (change >= 0) return 0;
  for (std::size_t e = 0; e < m; ++e) seam_cost_[e] = cost_of(e);
  for (std::size_t i = 0; i < n; ++i) {
    if (is_taken[i] == 0) continue;
    current_[i] = laid[i];
    unary_cost_[i] = laid_unary[i];
  }
  return -change;
}

std::int64_t PatchCut::improve(const SurfacePatch& patch, const PlaceMap& places, RandomStream random,
                               const RunControl& control) {
  if (patch.texels.size() < 2) return 0;
  begin(patch, places);
  find_candidates(patch, random);
  std::vector<PieceCenter> centers;
  for (const Candidate& c : best_) centers.push_back(c.center);
  for (const PieceCenter& c : common_centers(patch)) centers.push_back(c);
  std::int64_t gain = 0;
  for (const PieceCenter& center : centers) {
    control.throw_if_stopped();
    gain += lay(patch, center);
  }
  return gain;
}

}  // namespace patinate::transfer
