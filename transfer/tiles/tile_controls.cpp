#include "transfer/tiles/tile_controls.h"

#include <algorithm>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "transfer/guidance/compared_control.h"
#include "transfer/guidance/control_matcher.h"
#include "transfer/synthesis/pyramid.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {

std::vector<float> covered_values(const TexelMap& map, const TexelRect& rect, std::span<const float> values) {
  std::vector<float> covered;
  auto value = values.begin();
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x, ++value) {
      if (map.is_covered(TexelId{y} * map.width() + x)) covered.push_back(*value);
    }
  }
  return covered;
}

namespace {

/// How many values of a whole atlas are below each of some, and how many up to it.
struct Ranks {
  std::vector<float> values;  ///< Ascending, each once.
  std::vector<std::int64_t> below, up_to;

  explicit Ranks(std::span<const float> sorted) {
    std::unique_copy(sorted.begin(), sorted.end(), std::back_inserter(values));
    below.resize(values.size());
    up_to.resize(values.size());
  }
  /// Counts more of them. @param sorted  Those of a tile.
  void add(std::span<const float> sorted) {
    std::size_t num_below = 0, num_up_to = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      while (num_below < sorted.size() && sorted[num_below] < values[i]) ++num_below;
      num_up_to = std::max(num_up_to, num_below);
      while (num_up_to < sorted.size() && !(values[i] < sorted[num_up_to])) ++num_up_to;
      below[i] += static_cast<std::int64_t>(num_below);
      up_to[i] += static_cast<std::int64_t>(num_up_to);
    }
  }
  [[nodiscard]] std::size_t index_of(float value) const {
    return static_cast<std::size_t>(std::lower_bound(values.begin(), values.end(), value) - values.begin());
  }
};

}  // namespace

void write_control_files(const ControlFiles& files, int tile, const TexelMap& map, const TexelRect& rect,
                         std::span<const float> values, const RunControl& control) {
  write_array(files.values(tile), values);
  std::vector<float> sorted = covered_values(map, rect, values);
  sort_values(sorted, control);
  write_array(files.sorted(tile), std::span<const float>(sorted));
}

ImageF match_tile(const ControlFiles& files, int tile, int num_tiles, const TexelMap& map, const TexelRect& rect,
                  const TransferControl& control, const History& history, const ImageU8& source_mask,
                  const RunControl& run) {
  const MappedFile own_file(files.sorted(tile));
  Ranks ranks(control.mapping == ControlMapping::Rank ? own_file.all<float>() : std::span<const float>());
  ControlValues all;
  for (int other = 0; other < num_tiles; ++other) {
    run.throw_if_stopped();
    const MappedFile file(files.sorted(other));
    const auto sorted = file.all<float>();
    if (sorted.empty()) continue;
    all.least = all.count == 0 ? sorted.front() : std::min(all.least, sorted.front());
    all.greatest = all.count == 0 ? sorted.back() : std::max(all.greatest, sorted.back());
    all.count += static_cast<std::int64_t>(sorted.size());
    ranks.add(sorted);
  }
  const ControlFacts& facts = history.control(control.source);
  const ControlMatcher matched(all, control.range, compared_control(history, control.source, source_mask, run),
                               source_mask, {facts.low, facts.high, facts.unit}, control.mapping, run);
  const MappedFile value_file(files.values(tile));
  const auto values = value_file.values<float>(0, static_cast<std::size_t>(rect.num_texels()));
  ImageF out(rect.width(), rect.height());
  parallel_for(rect.height(), 8, run, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < rect.width(); ++x) {
        if (!map.is_covered(TexelId{rect.y0 + y} * map.width() + rect.x0 + x)) continue;
        const float value = values[std::int64_t{y} * rect.width() + x];
        const std::size_t i = matched.needs_ranks() ? ranks.index_of(value) : 0;
        out.at(x, y) = matched.needs_ranks() ? matched(value, ranks.below[i], ranks.up_to[i]) : matched(value, 0, 0);
      }
    }
  });
  return out;
}

std::span<const std::uint16_t> StoredTargets::at(int x, int y) {
  const int tile = grid_.tile_of(level_, x, y);
  if (tile >= grid_.num_tiles()) return {};
  auto found = files_.find(tile);
  if (found == files_.end()) found = files_.emplace(tile, MappedFile(folder_ / tile_file::targets(level_, tile))).first;
  const TexelRect rect = grid_.rect(level_, tile);
  const auto n = static_cast<std::size_t>(num_controls_);
  const auto i = static_cast<std::size_t>(std::int64_t{y - rect.y0} * rect.width() + x - rect.x0);
  return found->second.values<std::uint16_t>(2 * n * i, n);
}

ControlImage StoredTargets::image(const TexelRect& rect) {
  ControlImage out(rect.width(), rect.height(), num_controls_);
  for (int y = 0; y < rect.height(); ++y) {
    for (int x = 0; x < rect.width(); ++x) {
      const auto values = at(rect.x0 + x, rect.y0 + y);
      std::copy(values.begin(), values.end(), out.pixel(x, y).begin());
    }
  }
  return out;
}

void StoredTargets::load(const TexelRect& rect, std::span<const TexelId> others, LevelPart& part) {
  const int width = grid_.width(level_);
  part.num_controls = num_controls_;
  part.targets = ZeroedVector<std::uint16_t>(static_cast<std::size_t>(grid_.num_texels(level_) * num_controls_));
  const auto put = [&](TexelId t, int x, int y) {
    const auto values = at(x, y);
    std::copy(values.begin(), values.end(), part.targets.begin() + t * num_controls_);
  };
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) put(TexelId{y} * width + x, x, y);
  }
  for (const TexelId t : others) put(t, static_cast<int>(t % width), static_cast<int>(t / width));
}

ControlImage halve_tile(StoredTargets& fine, const TexelMap& fine_map, const TexelMap& map, const TexelRect& rect,
                        const RunControl& control) {
  constexpr int kAround = 4;  // Fine texels: the nearest one of a coarse texel lies within two.
  const TexelRect around{std::max(0, 2 * rect.x0 - kAround), std::max(0, 2 * rect.y0 - kAround),
                         std::min(fine_map.width(), 2 * rect.x1 + kAround),
                         std::min(fine_map.height(), 2 * rect.y1 + kAround)};
  const ControlImage values = fine.image(around);
  const ControlImage coarse = halve(
      values, (around.width() + 1) / 2, (around.height() + 1) / 2,
      [&](int x, int y) { return fine_map.is_covered(TexelId{around.y0 + y} * fine_map.width() + around.x0 + x); },
      control);
  ControlImage out(rect.width(), rect.height(), values.channels());
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const auto from = coarse.pixel(x - around.x0 / 2, y - around.y0 / 2);
      std::copy(from.begin(), from.end(), out.pixel(x - rect.x0, y - rect.y0).begin());
    }
  }
  for_each_uncovered(
      map, fine_map, rect,
      [&](int x, int y, TexelId near) {
        const auto from = values.pixel(static_cast<int>(near % fine_map.width()) - around.x0,
                                       static_cast<int>(near / fine_map.width()) - around.y0);
        std::copy(from.begin(), from.end(), out.pixel(x - rect.x0, y - rect.y0).begin());
      },
      control);
  return out;
}

TiledPlaces::TiledPlaces(const std::filesystem::path& folder, const TileGrid& grid, std::size_t level, int pass)
    : grid_(grid),
      level_(level),
      stored_([=](int tile) { return folder / tile_file::places(level, pass, tile); },
              [&grid, level](int tile) { return grid.rect(level, tile); }) {}

void TiledPlaces::load(std::span<const TexelId> texels, PlaceMap& places, std::span<std::uint8_t> changed_near) {
  const int width = grid_.width(level_);
  for (const TexelId t : texels) {
    const int x = static_cast<int>(t % width), y = static_cast<int>(t / width);
    stored_.load(grid_.tile_of(level_, x, y), t, x, y, places, changed_near);
  }
}

void TiledPlaces::load_part(const TexelRect& rect, PlaceMap& places) {
  for (int tile = 0; tile < grid_.num_tiles(); ++tile) {
    const TexelRect own = grid_.rect(level_, tile);
    if (own.x0 < rect.x1 && rect.x0 < own.x1 && own.y0 < rect.y1 && rect.y0 < own.y1)
      stored_.load(tile, rect, grid_.width(level_), places, {});
  }
}

}  // namespace patinate::transfer
