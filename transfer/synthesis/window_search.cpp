#include "transfer/synthesis/window_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace patinate {

namespace {

/// Least so far; the lower index among equals, as a search row by row finds it.
struct Best {
  WindowOptimum optimum{-1, std::numeric_limits<std::int64_t>::max()};

  /// What a cost must stay below for `pixel` to win.
  [[nodiscard]] std::int64_t bound(std::int32_t pixel) const {
    return optimum.pixel < 0 ? std::numeric_limits<std::int64_t>::max() : optimum.cost + (pixel < optimum.pixel ? 1 : 0);
  }
  void offer(const TexelCost& cost, std::int32_t pixel) {
    const std::int64_t limit = bound(pixel);
    const std::int64_t c = cost.total(pixel, limit);
    if (c < limit) optimum = {pixel, c};
  }
};

}  // namespace

WindowSearch::WindowSearch(const SourceLevel& source) : source_(source), squares_x_((source.width() + kSquare - 1) / kSquare) {
  const int squares_y = (source.height() + kSquare - 1) / kSquare;
  for (int sy = 0; sy < squares_y; ++sy) {
    for (int sx = 0; sx < squares_x_; ++sx) {
      begin_.push_back(static_cast<std::int32_t>(pixels_.size()));
      for (int y = sy * kSquare; y < std::min(source.height(), (sy + 1) * kSquare); ++y) {
        for (int x = sx * kSquare; x < std::min(source.width(), (sx + 1) * kSquare); ++x) {
          const std::int32_t p = y * source.width() + x;
          if (source.is_usable[static_cast<std::size_t>(p)] != 0) pixels_.push_back(p);
        }
      }
      const auto value = [&](std::int32_t p) { return source.controls.data()[std::int64_t{p} * source.controls.channels()]; };
      std::stable_sort(pixels_.begin() + begin_.back(), pixels_.end(), [&](std::int32_t a, std::int32_t b) { return value(a) < value(b); });
      for (auto i = static_cast<std::size_t>(begin_.back()); i < pixels_.size(); ++i) controls_.push_back(value(pixels_[i]));
    }
  }
  begin_.push_back(static_cast<std::int32_t>(pixels_.size()));
}

SearchWindow WindowSearch::window(std::int64_t x, std::int64_t y, int side) const {
  const std::int64_t x0 = std::clamp<std::int64_t>(x - side / 2, 0, std::max(0, source_.width() - side));
  const std::int64_t y0 = std::clamp<std::int64_t>(y - side / 2, 0, std::max(0, source_.height() - side));
  return {static_cast<int>(x0), static_cast<int>(y0), static_cast<int>(std::min<std::int64_t>(source_.width(), x0 + side)),
          static_cast<int>(std::min<std::int64_t>(source_.height(), y0 + side))};
}

WindowOptimum WindowSearch::find(const TexelCost& cost, const SearchWindow& window, std::span<const std::int32_t> likely) const {
  Best best;
  const auto is_in = [&](std::int32_t p) {
    const int x = p % source_.width(), y = p / source_.width();
    return x >= window.x0 && x < window.x1 && y >= window.y0 && y < window.y1;
  };
  for (std::int32_t p : likely) {
    if (p >= 0 && source_.is_usable[static_cast<std::size_t>(p)] != 0 && is_in(p)) best.offer(cost, p);
  }
  for (int sy = window.y0 / kSquare; sy * kSquare < window.y1; ++sy) {
    for (int sx = window.x0 / kSquare; sx * kSquare < window.x1; ++sx) {
      const auto square = static_cast<std::size_t>(sy * squares_x_ + sx);
      const bool is_whole = sx * kSquare >= window.x0 && (sx + 1) * kSquare <= window.x1 && sy * kSquare >= window.y0 && (sy + 1) * kSquare <= window.y1;
      const auto first = controls_.begin() + begin_[square], last = controls_.begin() + begin_[square + 1];
      const ControlInterval allowed = cost.first_control_within(best.optimum.pixel < 0 ? std::numeric_limits<std::int64_t>::max() : best.optimum.cost);
      for (auto at = std::lower_bound(first, last, allowed.low); at != last && *at <= allowed.high; ++at) {
        const std::int32_t p = pixels_[static_cast<std::size_t>(at - controls_.begin())];
        if (is_whole || is_in(p)) best.offer(cost, p);
      }
    }
  }
  return best.optimum;
}

WindowOptimum WindowSearch::find_exhaustively(const TexelCost& cost, const SearchWindow& window) const {
  Best best;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x) {
      const std::int32_t p = y * source_.width() + x;
      if (source_.is_usable[static_cast<std::size_t>(p)] != 0) best.offer(cost, p);
    }
  }
  return best.optimum;
}

}  // namespace patinate
