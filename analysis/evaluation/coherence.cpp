#include "analysis/evaluation/coherence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kChunk = 16384;
constexpr int kNear = 4, kFar = 64;                  // Of rep64.
constexpr int kShortestSpan = 8, kLongestSpan = 32;  // Texels: whole pixels measure the longest to a few percent.
constexpr double kLargestStep = 5.0;     // Source pixels of a step inside a piece: UVs squeezed by 4, and rounding.
constexpr double kStepTolerance = 0.99;  // Of a unit: both places are rounded to half of one.
constexpr std::pair<int, int> kSteps[] = {{1, 0}, {0, 1}};
constexpr std::pair<int, int> kFartherSteps[] = {{1, 0}, {0, 1},  {1, 1}, {1, -1}, {2, 0}, {0, 2},
                                                 {2, 1}, {1, -2}, {3, 0}, {0, 3},  {4, 1}, {1, -4}};

/// Sets that are joined; the smallest member stands for each.
class Pieces {
 public:
  explicit Pieces(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  std::int32_t find(std::int32_t i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      std::int32_t& up = parent_[static_cast<std::size_t>(i)];
      up = parent_[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

Vec2 source_step(const SourceIndices& source, TexelId a, TexelId b) {
  return {source.x(b) - source.x(a), source.y(b) - source.y(a)};
}

double color_difference(const ImageF& frame, std::int32_t a, std::int32_t b) {
  const float* p = frame.data() + std::int64_t{a} * 3;
  const float* q = frame.data() + std::int64_t{b} * 3;
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double d = static_cast<double>(p[c]) - static_cast<double>(q[c]);
    sum += d * d;
  }
  return std::sqrt(sum);
}

struct PairSums {
  std::int64_t count = 0, following = 0;
  double difference = 0.0, distance = 0.0;

  void add(const TexelPair& pair, const SourceIndices& source, const SynthesisSource& frames,
           const SourceScale& scale) {
    ++count;
    following += follows_surface(source, pair, scale) ? 1 : 0;
    for (const ImageF& frame : frames.frames)
      difference += color_difference(frame, source.of(pair.first), source.of(pair.second));
    distance += pair.offset_mm.norm() * static_cast<double>(frames.frames.size());
  }
  static PairSums merge(PairSums a, const PairSums& b) {
    return {a.count + b.count, a.following + b.following, a.difference + b.difference, a.distance + b.distance};
  }
  [[nodiscard]] double gradient() const { return distance > 0.0 ? difference / distance : 0.0; }
  [[nodiscard]] double following_share() const { return static_cast<double>(following) / static_cast<double>(count); }
};

/// Pairs by how far they are apart: a texture's differences do not grow with the distance, so that only pairs of equal
/// distance can be compared.
class PairsByDistance {
 public:
  explicit PairsByDistance(double texel_mm) : bin_mm_(texel_mm / 2) {}

  void add(const TexelPair& pair, const SourceIndices& source, const SynthesisSource& frames,
           const SourceScale& scale) {
    const double bin = std::floor(pair.offset_mm.norm() / bin_mm_ + 0.5);
    if (bin < static_cast<double>(sums_.size())) sums_[static_cast<std::size_t>(bin)].add(pair, source, frames, scale);
  }
  static PairsByDistance merge(PairsByDistance a, const PairsByDistance& b) {
    for (std::size_t i = 0; i < a.sums_.size(); ++i) a.sums_[i] = PairSums::merge(a.sums_[i], b.sums_[i]);
    return a;
  }
  /// Against pairs of the same distance, or where there are few of those, of the nearest distance that has more.
  [[nodiscard]] SeamFigures against(const PairsByDistance& inside) const {
    SeamFigures figures;
    double difference = 0.0, expected_difference = 0.0, following = 0.0, expected_following = 0.0;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      figures.num_pairs += sums_[i].count;
      const PairSums* same = inside.nearest(i);
      if (sums_[i].count == 0 || same == nullptr) continue;
      difference += sums_[i].difference;
      expected_difference += same->gradient() * sums_[i].distance;
      following += static_cast<double>(sums_[i].following);
      expected_following += same->following_share() * static_cast<double>(sums_[i].count);
    }
    if (expected_difference > 0.0) figures.gradient_ratio = difference / expected_difference;
    if (expected_following > 0.0) figures.coherence_ratio = following / expected_following;
    return figures;
  }

 private:
  static constexpr std::int64_t kEnough = 100;
  [[nodiscard]] const PairSums* nearest(std::size_t bin) const {
    for (std::size_t d = 0; d < sums_.size(); ++d) {
      for (const std::size_t i : {bin + d, bin - d}) {
        if (i < sums_.size() && sums_[i].count >= kEnough) return &sums_[i];
      }
    }
    return nullptr;
  }

  double bin_mm_;
  std::array<PairSums, 12> sums_ = {};  ///< Around multiples of half a texel.
};

/// Length of a span in the source over that on the surface; nothing where it leaves a piece.
std::optional<double> span_ratio(const TexelMap& surface, const SourceIndices& source, const SourceScale& scale,
                                 TexelId t, int dx, int dy) {
  double length_mm = 0.0;
  TexelId at = t;
  for (int k = 0; k < kLongestSpan; ++k) {
    const std::optional<TexelPair> pair = interior_pair(surface, scale.frames, at, dx, dy);
    const Vec2 made = pair ? source_step(source, pair->first, pair->second) : Vec2(0, 0);
    const bool leaves =
        !pair || made.cwiseAbs().maxCoeff() > kLargestStep * scale.unit_px ||
        (made.squaredNorm() > 0.0 && made.dot(pair->offset_mm) <= 0.5 * made.norm() * pair->offset_mm.norm());
    if (leaves && k < kShortestSpan) return std::nullopt;
    if (leaves) break;
    length_mm += pair->offset_mm.norm();
    at = pair->second;
  }
  const double made_mm = source_step(source, t, at).norm() * scale.pixel_mm;
  return made_mm > 0.0 && length_mm > 0.0 ? std::optional(made_mm / length_mm) : std::nullopt;
}

}  // namespace

bool follows_surface(const SourceIndices& source, const TexelPair& pair, const SourceScale& scale) {
  const Vec2 error = source_step(source, pair.first, pair.second) - pair.offset_mm / scale.pixel_mm;
  return error.cwiseAbs().maxCoeff() <= kStepTolerance * scale.unit_px;
}

CoherenceFigures measure_coherence(const TexelMap& surface, const SourceIndices& source, const SourceScale& scale) {
  Pieces pieces(static_cast<std::size_t>(surface.num_texels()));
  std::int64_t pairs = 0, coherent = 0;
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    for (const auto& [dx, dy] : kSteps) {
      const std::optional<TexelPair> pair = interior_pair(surface, scale.frames, t, dx, dy);
      if (!pair) continue;
      ++pairs;
      if (!follows_surface(source, *pair, scale)) continue;
      ++coherent;
      pieces.join(static_cast<std::int32_t>(t), static_cast<std::int32_t>(pair->second));
    }
  }
  CoherenceFigures figures;
  figures.coherent_share = pairs > 0 ? static_cast<double>(coherent) / static_cast<double>(pairs) : 1.0;
  figures.piece.assign(static_cast<std::size_t>(surface.num_texels()), -1);
  std::int32_t num_pieces = 0;
  for (TexelId t = 0; t < surface.num_texels(); ++t) {  // The smallest member comes first.
    if (!surface.is_covered(t)) continue;
    const std::int32_t root = pieces.find(static_cast<std::int32_t>(t));
    figures.piece[static_cast<std::size_t>(t)] =
        root == t ? num_pieces++ : figures.piece[static_cast<std::size_t>(root)];
  }
  figures.texels_per_piece = num_pieces > 0 ? static_cast<double>(surface.num_covered()) / num_pieces : 0.0;
  return figures;
}

ReuseFigures measure_reuse(const TexelMap& surface, const SourceIndices& source, std::int64_t num_usable) {
  const int w = surface.width();
  std::vector<TexelId> order;
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (surface.is_covered(t)) order.push_back(t);
  }
  std::stable_sort(order.begin(), order.end(), [&](TexelId a, TexelId b) { return source.of(a) < source.of(b); });
  ReuseFigures figures;
  figures.is_repeated.assign(static_cast<std::size_t>(surface.num_texels()), 0);
  std::int64_t repeated = 0, used = 0;
  const auto is_near = [&](TexelId a, TexelId b) {
    const std::int64_t dx = a % w - b % w, dy = a / w - b / w, d2 = dx * dx + dy * dy;
    return d2 >= kNear * kNear && d2 <= kFar * kFar;
  };
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    for (end = begin; end < order.size() && source.of(order[end]) == source.of(order[begin]);) ++end;
    ++used;
    for (std::size_t i = begin; i < end; ++i) {  // Texels of one source are in rows: only 64 of those are looked at.
      bool found = false;
      for (std::size_t j = i; j-- > begin && !found && order[i] / w - order[j] / w <= kFar;)
        found = is_near(order[i], order[j]);
      for (std::size_t j = i + 1; j < end && !found && order[j] / w - order[i] / w <= kFar; ++j)
        found = is_near(order[i], order[j]);
      figures.is_repeated[static_cast<std::size_t>(order[i])] = found ? 1 : 0;
      repeated += found ? 1 : 0;
    }
  }
  figures.rep64 = order.empty() ? 0.0 : static_cast<double>(repeated) / static_cast<double>(order.size());
  figures.used_share = num_usable > 0 ? static_cast<double>(used) / static_cast<double>(num_usable) : 0.0;
  return figures;
}

SeamFigures measure_seams(const TexelMap& surface, const SourceIndices& source, std::span<const TexelPair> seams,
                          const SynthesisSource& frames, const SourceScale& scale, const RunControl& control) {
  const PairsByDistance none(surface.median_texel_size_mm());
  if (seams.empty()) return {};
  PairsByDistance over = none;
  for (const TexelPair& pair : seams) over.add(pair, source, frames, scale);
  const PairsByDistance inside = parallel_reduce(
      surface.num_texels(), kChunk, control, none,
      [&](std::int64_t begin, std::int64_t end) {
        PairsByDistance part = none;
        for (TexelId t = begin; t < end; ++t) {
          if (!surface.is_covered(t)) continue;
          for (const auto& [dx, dy] : kFartherSteps) {
            if (const auto pair = interior_pair(surface, scale.frames, t, dx, dy))
              part.add(*pair, source, frames, scale);
          }
        }
        return part;
      },
      PairsByDistance::merge);
  return over.against(inside);
}

ForeshorteningFigures measure_foreshortening(const TexelMap& surface, const SourceIndices& source,
                                             const SourceScale& scale, const RunControl& control) {
  using Ratios = std::vector<double>;
  Ratios errors = parallel_reduce(
      surface.num_texels(), kChunk, control, Ratios{},
      [&](std::int64_t begin, std::int64_t end) {
        Ratios part;
        for (TexelId t = begin; t < end; ++t) {
          if (!surface.is_covered(t)) continue;
          for (const auto& [dx, dy] : kSteps) {
            if (const auto ratio = span_ratio(surface, source, scale, t, dx, dy))
              part.push_back(std::exp2(std::abs(std::log2(*ratio))) - 1.0);
          }
        }
        return part;
      },
      [](Ratios a, const Ratios& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
  ForeshorteningFigures figures;
  figures.num_spans = static_cast<std::int64_t>(errors.size());
  if (errors.empty()) return figures;
  std::sort(errors.begin(), errors.end());
  const auto at = [&](double rank) {
    return errors[static_cast<std::size_t>(rank * static_cast<double>(errors.size() - 1))];
  };
  figures.median = at(0.5);
  figures.p99 = at(0.99);
  return figures;
}

}  // namespace patinate::analysis
