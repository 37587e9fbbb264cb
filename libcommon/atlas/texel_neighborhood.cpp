#include "libcommon/atlas/texel_neighborhood.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

constexpr TexelId kNoStep = std::numeric_limits<TexelId>::min();
constexpr int kLook = 4096;  // Texels or triangles between two looks at the stop.

/// Rows of texels of which some threads each take a band.
constexpr std::int64_t kBand = 256;

/// Marks each texel of a rectangle: 0 outside the charts, 1 beside another chart, the outside or what lies beyond the
/// rectangle, else `farthest`.
void mark_border(const TexelMap& map, const TexelRect& rect, std::uint8_t farthest, std::span<std::uint8_t> distance,
                 const RunControl& control) {
  const int w = rect.width(), h = rect.height();
  const auto chart = [&](int x, int y) { return map.chart(TexelId{rect.y0 + y} * map.width() + rect.x0 + x); };
  parallel_for(h, 16, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < w; ++x) {
        const int own = chart(x, y);
        bool is_border = own < 0 || x == 0 || y == 0 || x == w - 1 || y == h - 1;
        for (int dy = -1; dy <= 1 && !is_border; ++dy) {
          for (int dx = -1; dx <= 1 && !is_border; ++dx) is_border = chart(x + dx, y + dy) != own;
        }
        distance[TexelId{y} * w + x] = is_border ? static_cast<std::uint8_t>(own < 0 ? 0 : 1) : farthest;
      }
    }
  });
}

/// Spreads distances over rows of `w` texels, down and up.
void spread_distance(std::span<std::uint8_t> distance, int w) {
  const auto h = static_cast<int>(distance.size() / static_cast<std::size_t>(w));
  const auto at = [&](int x, int y) -> std::uint8_t& { return distance[TexelId{y} * w + x]; };
  const auto relax = [&](int x, int y, int dx, int dy) {
    const int qx = x + dx, qy = y + dy;
    if (qx < 0 || qy < 0 || qx >= w || qy >= h) return;
    at(x, y) = static_cast<std::uint8_t>(std::min<int>(at(x, y), at(qx, qy) + 1));
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) relax(x, y, dx, dy);
    }
  }
  for (int y = h - 1; y >= 0; --y) {
    for (int x = w - 1; x >= 0; --x) {
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
    }
  }
}

/// Chebyshev distance from each texel to the nearest texel of another chart (or the outside), as far as `farthest`.
/// Bands of rows by themselves, with as many rows around each.
std::vector<std::uint8_t> distance_to_border(const TexelMap& map, std::uint8_t farthest, const RunControl& control) {
  const TexelRect rect = map.rect();
  const auto w = static_cast<std::size_t>(rect.width());
  const std::int64_t h = rect.height();
  std::vector<std::uint8_t> border(static_cast<std::size_t>(rect.num_texels())), distance(border.size());
  if (border.empty()) return distance;
  mark_border(map, rect, farthest, border, control);
  parallel_for(h, kBand, control, [&](std::int64_t begin, std::int64_t end) {
    const auto first = static_cast<std::size_t>(std::max<std::int64_t>(0, begin - farthest)),
               last = static_cast<std::size_t>(std::min<std::int64_t>(h, end + farthest));
    std::vector<std::uint8_t> band(border.begin() + static_cast<std::ptrdiff_t>(first * w),
                                   border.begin() + static_cast<std::ptrdiff_t>(last * w));
    spread_distance(band, static_cast<int>(w));
    const auto skipped = (static_cast<std::size_t>(begin) - first) * w;
    std::copy_n(band.begin() + static_cast<std::ptrdiff_t>(skipped), (end - begin) * static_cast<std::int64_t>(w),
                distance.begin() + begin * static_cast<std::int64_t>(w));
  });
  return distance;
}

/// floor(v + 0.5) for |v| < 2^20, without a call.
std::int32_t nearest(double v) {
  constexpr std::int32_t kUp = 1 << 20;
  return static_cast<std::int32_t>(v + 0.5 + kUp) - kUp;
}

constexpr std::array<std::array<int, 2>, TexelNeighborhood::kNumAdjacent> kAdjacent{
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

}  // namespace

TexelNeighborhood::TexelNeighborhood(const TexelMap& map, std::vector<Vec2> offsets_mm,
                                     std::shared_ptr<const FlowFrames> frames, double pixel_mm,
                                     const RunControl& control)
    : map_(map), offsets_mm_(std::move(offsets_mm)), frames_(std::move(frames)), pixel_mm_(pixel_mm) {
  std::vector<int> reach(map.mesh().triangles.size());  // Largest texel step of any offset, per triangle.
  for (std::size_t t = 0; t < reach.size(); ++t) {
    if (t % kLook == 0) control.throw_if_stopped();
    const Eigen::Matrix2d to_texels = map.texels_per_mm(static_cast<int>(t), (*frames_)[t]);
    double largest = 1.0;
    for (const Vec2& offset : offsets_mm_) largest = std::max(largest, (to_texels * offset).cwiseAbs().maxCoeff());
    reach[t] = static_cast<int>(std::min(std::ceil(largest), 1e6));
  }
  {
    const int farthest = reach.empty() ? 1 : *std::max_element(reach.begin(), reach.end());
    const std::vector<std::uint8_t> away =
        distance_to_border(map, static_cast<std::uint8_t>(std::min(farthest + 1, 255)), control);
    band_ = TexelSet(
        map.num_texels(), [&](TexelId t) { return map.is_covered(t) && away[t] <= reach[map.triangle(t)]; }, control);
  }
  if (size() > kMaxNeighbors)
    throw InvalidInput("neighborhood: " + std::to_string(size()) + " neighbors; at most " +
                       std::to_string(kMaxNeighbors));
  find_all_steps(control);
  const std::vector<bool> follows_grid = follow_their_grid(reach);
  chunks_.resize((band_.size() + kChunk - 1) / kChunk);
  parallel_for(static_cast<std::int64_t>(chunks_.size()), 1, control,
               [&](std::int64_t chunk, std::int64_t) { store(static_cast<std::size_t>(chunk), follows_grid); });
}

/// For each triangle: it has so many texels that its steps are found for several of them at a time, and steps that are
/// whole numbers.
std::vector<bool> TexelNeighborhood::follow_their_grid(const std::vector<int>& reach) const {
  constexpr std::int32_t kFewTexels = 64;
  constexpr int kLargestGridStep = 255;
  const std::vector<std::int64_t> num_texels = map_.count_texels();
  std::vector<bool> follows(reach.size());
  for (std::size_t t = 0; t < reach.size(); ++t)
    follows[t] = num_texels[t] >= kFewTexels && reach[t] <= kLargestGridStep;
  return follows;
}

void TexelNeighborhood::store(std::size_t chunk, const std::vector<bool>& follows_grid) {
  Chunk& out = chunks_[chunk];
  const std::size_t begin = chunk * kChunk, end = std::min(band_.size(), begin + kChunk);
  out.rows.reserve(end - begin);
  std::vector<TexelNeighbor> found(size());
  std::vector<Vec2> offsets = offsets_mm_;
  offsets.resize(size());
  Cursor grid(*this);
  auto at = band_.from(begin);
  for (std::size_t i = begin; i < end; ++i, ++at) {
    const int triangle = map_.triangle(*at);
    const Eigen::Matrix2d to_mm = pixels_per_texel(triangle) * pixel_mm_;
    for (std::size_t k = 0; k < kNumAdjacent; ++k)
      offsets[first_adjacent() + k] = to_mm * Vec2(kAdjacent[k][0], kAdjacent[k][1]);
    map_.gather(*at, *frames_, offsets, found);
    const bool has_grid = follows_grid[triangle];
    if (has_grid) grid.follow_grid(*at);
    Row row{.begin = static_cast<std::uint32_t>(out.stored.size())};
    for (std::size_t k = 0; k < size(); ++k) {
      const PixelNeighbor n = in_pixels(found[k]);
      if (has_grid && n == grid.found_[k]) continue;
      row.is_stored[k / 64] |= std::uint64_t{1} << (k % 64);
      out.stored.push_back(n.texel >= 0 ? Stored{static_cast<std::uint32_t>(n.texel), n.x, n.y} : Stored{});
    }
    out.rows.push_back(row);
  }
  out.stored.shrink_to_fit();
}

std::int64_t TexelNeighborhood::stored_bytes() const {
  std::int64_t bytes = 0;
  for (const Chunk& c : chunks_)
    bytes += static_cast<std::int64_t>(c.rows.size() * sizeof(Row) + c.stored.size() * sizeof(Stored));
  return bytes;
}

PixelNeighbor TexelNeighborhood::in_pixels(const TexelNeighbor& n) const {
  constexpr double kFarthest = 127.0;
  const Vec2 pixels = n.offset_mm / pixel_mm_;
  if (n.texel < 0 || !(pixels.cwiseAbs().maxCoeff() <= kFarthest)) return {};
  const auto fixed = [](double v) { return static_cast<std::int16_t>(nearest(v * PixelNeighbor::kOne)); };
  return {n.texel, fixed(pixels.x()), fixed(pixels.y())};
}

Eigen::Matrix2d TexelNeighborhood::pixels_per_texel(int triangle) const {
  return (*frames_)[triangle].transpose() * map_.mm_per_texel(triangle) / pixel_mm_;
}

/// Finds neighbors as TexelMap::gather() does for a texel far from its chart's border; `texel` is how far on.
void TexelNeighborhood::find_steps(int triangle, std::span<PixelNeighbor> steps) const {
  const FlowFrame& frame = (*frames_)[triangle];
  const Eigen::Matrix2d to_texels = map_.texels_per_mm(triangle, frame),
                        to_mm = frame.transpose() * map_.mm_per_texel(triangle);
  for (std::size_t k = 0; k < size(); ++k) {
    const Vec2 step = k < first_adjacent()
                          ? Vec2(to_texels * offsets_mm_[k])
                          : Vec2(kAdjacent[k - first_adjacent()][0], kAdjacent[k - first_adjacent()][1]);
    const TexelId dx = nearest(step.x()), dy = nearest(step.y());  // At most 255: the border of the chart lies farther.
    steps[k] = in_pixels({0, to_mm * Vec2(static_cast<double>(dx), static_cast<double>(dy))});
    steps[k].texel = steps[k].texel < 0 ? kNoStep : dy * map_.width() + dx;
  }
}

/// Cursors look steps up instead of finding them again for each of a few triangles, where this takes little memory.
void TexelNeighborhood::find_all_steps(const RunControl& control) {
  constexpr std::size_t kMaxSteps = std::size_t{1} << 16;  // 1 MB.
  const std::size_t num_triangles = map_.mesh().triangles.size();
  if (num_triangles * size() > kMaxSteps) return;
  steps_.resize(num_triangles * size());
  parallel_for(static_cast<std::int64_t>(num_triangles), 512, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      find_steps(static_cast<int>(t), std::span(steps_).subspan(static_cast<std::size_t>(t) * size(), size()));
  });
}

FlatNeighbors TexelNeighborhood::flat(const RunControl& control) const {
  using neighbor_kernel::kNoNeighbor;
  using neighbor_kernel::PackedNeighbor;
  if (map_.num_texels() >= std::numeric_limits<std::int32_t>::max())
    throw InvalidInput("neighborhood: an atlas of 2^31 texels and more has no flat tables");
  FlatNeighbors out;
  out.row.assign(static_cast<std::size_t>(map_.num_texels()), -1);
  out.is_stored.reserve(2 * band_.size());
  out.begin.reserve(band_.size());
  for (const Chunk& chunk : chunks_) {
    control.throw_if_stopped();
    const auto first = static_cast<std::uint32_t>(out.stored.size());
    for (const Row& row : chunk.rows) {
      out.is_stored.insert(out.is_stored.end(), row.is_stored.begin(), row.is_stored.end());
      out.begin.push_back(first + row.begin);
    }
    for (const Stored& s : chunk.stored)
      out.stored.push_back({s.texel == Stored::kNone ? kNoNeighbor : static_cast<std::int32_t>(s.texel), s.x, s.y});
  }
  std::int32_t next = 0;
  for (const TexelId t : band_) out.row[t] = next++;

  // Steps of the triangles whose texels lack something in their rows.
  std::vector<std::uint8_t> is_stepping(map_.mesh().triangles.size(), 0);
  parallel_for(map_.num_texels(), 1 << 16, control, [&](TexelId begin, TexelId end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map_.is_covered(t)) continue;
      const std::atomic_ref is_known(is_stepping[map_.triangle(t)]);
      if (is_known.load(std::memory_order_relaxed) != 0) continue;
      if (const std::int32_t row = out.row[t]; row >= 0) {
        const auto at = 2 * static_cast<std::size_t>(row);
        if (std::popcount(out.is_stored[at]) + std::popcount(out.is_stored[at + 1]) == static_cast<int>(size()))
          continue;
      }
      is_known.store(1, std::memory_order_relaxed);
    }
  });
  out.steps_of.assign(is_stepping.size(), -1);
  std::vector<PixelNeighbor> steps(size());
  std::int32_t num_stepping = 0;
  for (std::size_t triangle = 0; triangle < is_stepping.size(); ++triangle) {
    if (is_stepping[triangle] == 0) continue;
    out.steps_of[triangle] = num_stepping++;
    find_steps(static_cast<int>(triangle), steps);
    for (const PixelNeighbor& n : steps)
      out.steps.push_back({n.texel == kNoStep ? kNoNeighbor : static_cast<std::int32_t>(n.texel), n.x, n.y});
  }
  for (std::int32_t& steps_of : out.steps_of) steps_of = std::max(steps_of, 0);  // Those of others are not looked at.
  return out;
}

void TexelNeighborhood::Cursor::follow_grid(TexelId t) {
  const TexelNeighborhood& all = neighborhood_;
  const int triangle = all.map_.triangle(t);
  const auto found_steps = [&]() -> std::span<const PixelNeighbor> {
    if (!all.steps_.empty()) return std::span(all.steps_).subspan(triangle * all.size(), all.size());
    const std::size_t kept = static_cast<std::size_t>(triangle) % kNumKept;
    const auto steps = std::span(steps_).subspan(kept * all.size(), all.size());
    if (triangle != triangles_[kept]) all.find_steps(triangle, steps);
    triangles_[kept] = triangle;
    return steps;
  };
  const std::span<const PixelNeighbor> steps = found_steps();
  for (std::size_t k = 0; k < steps.size(); ++k) {
    found_[k] = steps[k];
    found_[k].texel = steps[k].texel == kNoStep ? -1 : t + steps[k].texel;
  }
}

std::span<const PixelNeighbor> TexelNeighborhood::Cursor::at(TexelId t) {
  const TexelNeighborhood& all = neighborhood_;
  if (!all.band_.contains(t)) {
    follow_grid(t);
    return found_;
  }
  const std::size_t index = all.band_.index_of(t);
  const Chunk& chunk = all.chunks_[index / kChunk];
  const Row& row = chunk.rows[index % kChunk];
  const Stored* next = chunk.stored.data() + row.begin;
  const auto take = [&](std::size_t k) {
    found_[k] = {next->texel == Stored::kNone ? -1 : TexelId{next->texel}, next->x, next->y};
    ++next;
  };
  const std::size_t end =
      index % kChunk + 1 < chunk.rows.size() ? chunk.rows[index % kChunk + 1].begin : chunk.stored.size();
  if (end - row.begin == found_.size()) {
    for (std::size_t k = 0; k < found_.size(); ++k) take(k);
    return found_;
  }
  follow_grid(t);
  for (std::size_t word = 0; word < row.is_stored.size(); ++word) {
    for (std::uint64_t rest = row.is_stored[word]; rest != 0; rest &= rest - 1)
      take(word * 64 + static_cast<std::size_t>(std::countr_zero(rest)));
  }
  return found_;
}

}  // namespace patinate
