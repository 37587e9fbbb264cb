#include "analysis/evaluation/coherence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kCoherenceChunk = 16384;
constexpr int kNear = 4, kFar = 64;                  // Distances of rep64, texels.
constexpr int kShortestSpan = 8, kLongestSpan = 32;  // Texels: whole pixels measure the longest to a few percent.
constexpr double kLargestStep = 5.0;  // Source pixels of a step inside a piece: UVs squeezed by 4, and rounding.
constexpr double kLogarithmBin = 1.0 / 65536.0;  ///< Width of a bin of logarithms, in which medians are found.
constexpr double kStepTolerance = 0.99;          // In units: both places are rounded to half of one.
constexpr std::pair<int, int> kSteps[] = {{1, 0}, {0, 1}};
constexpr std::pair<int, int> kFartherSteps[] = {{1, 0}, {0, 1},  {1, 1}, {1, -1}, {2, 0}, {0, 2},
                                                 {2, 1}, {1, -2}, {3, 0}, {0, 3},  {4, 1}, {1, -4}};

/// Sets that are joined; the smallest member stands for each.
class Pieces {
 public:
  explicit Pieces(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  std::int32_t find(std::int32_t i) {
    while (parent_[i] != i) {
      std::int32_t& up = parent_[i];
      up = parent_[up];
      i = up;
    }
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
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

/// Bin of PairsByDistance; nothing for pairs farther apart than all of them.
std::optional<std::size_t> distance_bin(const TexelPair& pair, double texel_mm) {
  const double bin = std::floor(pair.offset_mm.norm() / (texel_mm / 2) + 0.5);
  return bin < static_cast<double>(PairsByDistance{}.size()) ? std::optional(static_cast<std::size_t>(bin))
                                                             : std::nullopt;
}

void add_each(PairsByDistance& sums, const PairsByDistance& others) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i].add(others[i]);
}

/// Length of a span in the source over that on the surface; nothing where it leaves a piece.
std::optional<double> span_ratio(const TexelMap& surface, const SourceIndices& source, const SourceScale& scale,
                                 TexelId t, int dx, int dy) {
  double length_mm = 0.0;
  TexelId at = t;
  for (int k = 0; k < kLongestSpan; ++k) {
    const std::optional<TexelPair> pair = interior_pair(surface, scale.axes, at, dx, dy);
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

void CoherenceSums::add(const CoherenceSums& o) {
  pairs += o.pairs, coherent += o.coherent, texels += o.texels, pieces += o.pieces;
}

double CoherenceSums::coherent_share() const {
  return pairs > 0 ? static_cast<double>(coherent) / static_cast<double>(pairs) : 1.0;
}

double CoherenceSums::texels_per_piece() const {
  return pieces > 0 ? static_cast<double>(texels) / static_cast<double>(pieces) : 0.0;
}

CoherenceSums measure_coherence(const MapPart& part, const SourceScale& scale) {
  Pieces pieces(static_cast<std::size_t>(part.num_texels()));
  CoherenceSums sums;
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    for (const auto& [dx, dy] : kSteps) {
      const std::optional<TexelPair> pair = interior_pair(part.surface, scale.axes, t, dx, dy);
      if (!pair) continue;
      ++sums.pairs;
      if (!follows_surface(part.indices, *pair, scale)) continue;
      ++sums.coherent;
      pieces.join(static_cast<std::int32_t>(i), static_cast<std::int32_t>(part.place(pair->second)));
    }
  });
  part.for_each_covered([&](TexelId, std::int64_t i) {
    ++sums.texels;
    sums.pieces += pieces.find(static_cast<std::int32_t>(i)) == i ? 1 : 0;
  });
  return sums;
}

void ReuseSums::add(const ReuseSums& other) {
  texels += other.texels, repeated += other.repeated;
  if (uses.size() < other.uses.size()) uses.resize(other.uses.size());
  for (std::size_t i = 0; i < other.uses.size(); ++i) uses[i] += other.uses[i];
}

double ReuseSums::rep64() const {
  return texels > 0 ? static_cast<double>(repeated) / static_cast<double>(texels) : 0.0;
}

double ReuseSums::used_share(std::int64_t num_usable) const {
  const auto used = static_cast<std::int64_t>(uses.size()) - std::count(uses.begin(), uses.end(), 0);
  return num_usable > 0 ? static_cast<double>(used) / static_cast<double>(num_usable) : 0.0;
}

ReuseSums measure_reuse(const MapPart& part, std::int64_t num_pixels, ImageF& is_repeated) {
  const std::int64_t w = part.rect.width();
  const SourceIndices& source = part.indices;
  ReuseSums sums;
  sums.uses.resize(num_pixels);
  std::vector<std::int64_t> order;  // Places in the part.
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    order.push_back(i);
    ++sums.uses[source.of(t)];
  });
  const auto shown = [&](std::int64_t i) { return source.of(part.texel(i)); };
  std::stable_sort(order.begin(), order.end(), [&](std::int64_t a, std::int64_t b) { return shown(a) < shown(b); });
  is_repeated = ImageF(part.rect.width(), part.rect.height());
  const auto is_near = [&](std::int64_t a, std::int64_t b) {
    const std::int64_t dx = a % w - b % w, dy = a / w - b / w, d2 = dx * dx + dy * dy;
    return d2 >= kNear * kNear && d2 <= kFar * kFar;
  };
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    for (end = begin; end < order.size() && shown(order[end]) == shown(order[begin]);) ++end;
    for (std::size_t i = begin; i < end; ++i) {  // Texels of one source are in rows: only 64 of those are looked at.
      bool found = false;
      for (std::size_t j = i; j-- > begin && !found && order[i] / w - order[j] / w <= kFar;)
        found = is_near(order[i], order[j]);
      for (std::size_t j = i + 1; j < end && !found && order[j] / w - order[i] / w <= kFar; ++j)
        found = is_near(order[i], order[j]);
      is_repeated.data()[order[i]] = found ? 1.0f : 0.0f;
      sums.repeated += found ? 1 : 0;
    }
  }
  sums.texels = static_cast<std::int64_t>(order.size());
  return sums;
}

void PairSums::add(const TexelPair& pair, const SourceIndices& source, const SynthesisSource& frames,
                   const SourceScale& scale) {
  ++count;
  following += follows_surface(source, pair, scale) ? 1 : 0;
  for (const ImageF& frame : frames.frames)
    difference += color_difference(frame, source.of(pair.first), source.of(pair.second));
  distance += pair.offset_mm.norm() * static_cast<double>(frames.frames.size());
}

void PairSums::add(const PairSums& o) {
  count += o.count, following += o.following, difference += o.difference, distance += o.distance;
}

void SeamSums::add(const SeamSums& other) {
  add_each(over, other.over);
  add_each(inside, other.inside);
}

SeamFigures SeamSums::figures() const {
  constexpr std::int64_t kEnough = 100;  // Pairs that a distance needs.
  const auto nearest = [&](std::size_t bin) -> const PairSums* {
    for (std::size_t d = 0; d < inside.size(); ++d) {
      for (const std::size_t i : {bin + d, bin - d}) {
        if (i < inside.size() && inside[i].count >= kEnough) return &inside[i];
      }
    }
    return nullptr;
  };
  SeamFigures figures;
  double difference = 0.0, expected_difference = 0.0, following = 0.0, expected_following = 0.0;
  for (std::size_t i = 0; i < over.size(); ++i) {
    figures.num_pairs += over[i].count;
    const PairSums* same = nearest(i);
    if (over[i].count == 0 || same == nullptr) continue;
    difference += over[i].difference;
    expected_difference += same->gradient() * over[i].distance;
    following += static_cast<double>(over[i].following);
    expected_following += same->following_share() * static_cast<double>(over[i].count);
  }
  if (expected_difference > 0.0) figures.gradient_ratio = difference / expected_difference;
  if (expected_following > 0.0) figures.coherence_ratio = following / expected_following;
  return figures;
}

SeamSums measure_seams(const MapPart& part, std::span<const TexelPair> seams, const SynthesisSource& frames,
                       const SourceScale& scale, const RunControl& control) {
  const double texel_mm = part.surface.median_texel_size_mm();
  SeamSums sums;
  if (seams.empty() && part.surface.sheet().num_tiles() == 1) return sums;
  for (const TexelPair& pair : seams) {
    if (const auto bin = distance_bin(pair, texel_mm)) sums.over[*bin].add(pair, part.indices, frames, scale);
  }
  sums.inside = parallel_reduce(
      part.num_texels(), kCoherenceChunk, control, PairsByDistance{},
      [&](std::int64_t begin, std::int64_t end) {
        PairsByDistance inside{};
        for (std::int64_t i = begin; i < end; ++i) {
          const TexelId t = part.texel(i);
          if (!part.surface.is_covered(t)) continue;
          for (const auto& [dx, dy] : kFartherSteps) {
            const auto pair = interior_pair(part.surface, scale.axes, t, dx, dy);
            if (!pair) continue;
            if (const auto bin = distance_bin(*pair, texel_mm)) inside[*bin].add(*pair, part.indices, frames, scale);
          }
        }
        return inside;
      },
      [](PairsByDistance a, const PairsByDistance& b) {
        add_each(a, b);
        return a;
      });
  return sums;
}

ValueCounts measure_foreshortening(const MapPart& part, const SourceScale& scale, const RunControl& control) {
  using Logarithms = std::vector<double>;
  constexpr std::int64_t kRows = 256;  // At a time: what is found in them is kept in a list until it is counted.
  ValueCounts counts(kLogarithmBin);
  for (int row = 0; row < part.rect.height(); row += kRows) {
    const std::int64_t first = std::int64_t{row} * part.rect.width(),
                       last = std::min(first + kRows * part.rect.width(), part.num_texels());
    const Logarithms found = parallel_reduce(
        last - first, kCoherenceChunk, control, Logarithms{},
        [&](std::int64_t begin, std::int64_t end) {
          Logarithms some;
          for (std::int64_t i = first + begin; i < first + end; ++i) {
            const TexelId t = part.texel(i);
            if (!part.surface.is_covered(t)) continue;
            for (const auto& [dx, dy] : kSteps) {
              if (const auto ratio = span_ratio(part.surface, part.indices, scale, t, dx, dy))
                some.push_back(std::abs(std::log2(*ratio)));
            }
          }
          return some;
        },
        [](Logarithms a, const Logarithms& b) {
          a.insert(a.end(), b.begin(), b.end());
          return a;
        });
    for (const double v : found) counts.add(v);
  }
  return counts;
}

ForeshorteningFigures foreshortening_of(const ValueCounts& logarithms) {
  if (logarithms.total() == 0) return {};
  const auto error_at = [&](double share) {
    const auto rank = static_cast<std::int64_t>(share * static_cast<double>(logarithms.total() - 1));
    return std::exp2(logarithms.at_rank(rank)) - 1.0;
  };
  return {.median = error_at(0.5), .p99 = error_at(0.99)};
}

}  // namespace patinate::analysis
