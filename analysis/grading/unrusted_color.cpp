#include "analysis/grading/unrusted_color.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/median.h"

namespace patinate::analysis {

namespace {

constexpr int kBlocksAlong = 24;    // Along the longer side.
constexpr int kMinBlock_px = 12;    ///< Least side of a block whose color is taken.
constexpr int kBlurredEdge_px = 2;  ///< Rim of rust that the lens's blur mixes with paint.
constexpr double kMinClean = 0.1;   // Share of a block that must be clean to tell its color.

/// Numbers on a coarse grid, in between bilinear.
struct Grid {
  int width = 0, height = 0;
  double step_x = 1.0, step_y = 1.0;
  std::vector<std::array<double, 3>> values = {};
  std::vector<char> is_known = {};

  [[nodiscard]] std::array<double, 3> at(int x, int y) const {
    const double u = std::clamp((x + 0.5) / step_x - 0.5, 0.0, width - 1.0),
                 v = std::clamp((y + 0.5) / step_y - 0.5, 0.0, height - 1.0);
    const int left = std::min(static_cast<int>(u), std::max(0, width - 2)),
              top = std::min(static_cast<int>(v), std::max(0, height - 2));
    const int right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
    const double a = u - left, b = v - top;
    std::array<double, 3> out{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto value = [&](int i, int j) { return values[static_cast<std::size_t>(j) * width + i][c]; };
      out[c] = (1 - b) * ((1 - a) * value(left, top) + a * value(right, top)) +
               b * ((1 - a) * value(left, bottom) + a * value(right, bottom));
    }
    return out;
  }
};

/// Blocks that nothing tells get the means of their known neighbors, ring by ring.
void fill_unknown(Grid& grid) {
  for (bool has_unknown = true; has_unknown;) {
    has_unknown = false;
    const std::vector<char> known = grid.is_known;
    bool has_filled = false;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * grid.width + x;
        if (known[i]) continue;
        has_unknown = true;
        std::array<double, 3> sum{};
        int count = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const int nx = x + dx, ny = y + dy;
            if (nx < 0 || ny < 0 || nx >= grid.width || ny >= grid.height) continue;
            const std::size_t k = static_cast<std::size_t>(ny) * grid.width + nx;
            if (!known[k]) continue;
            for (std::size_t c = 0; c < 3; ++c) sum[c] += grid.values[k][c];
            ++count;
          }
        }
        if (count == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) grid.values[i][c] = sum[c] / count;
        grid.is_known[i] = 1;
        has_filled = true;
      }
    }
    if (has_unknown && !has_filled) return;  // Nothing is known anywhere.
  }
}

/// The blurred edge of rust is neither: what is near it counts as rust.
ImageU8 with_blurred_edge(const ImageU8& is_rust) {
  ImageU8 out(is_rust.width(), is_rust.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (is_rust.at(x, y) == 0) continue;
      for (int j = std::max(0, y - kBlurredEdge_px); j <= std::min(out.height() - 1, y + kBlurredEdge_px); ++j) {
        for (int i = std::max(0, x - kBlurredEdge_px); i <= std::min(out.width() - 1, x + kBlurredEdge_px); ++i)
          out.at(i, j) = 255;
      }
    }
  }
  return out;
}

/// Medians over the clean pixels of blocks. @param value  Of a pixel: three numbers.
template <class Value>
Grid block_medians(int width, int height, const ImageU8& mask, const ImageU8& is_rust, const Value& value) {
  const int block = std::max(kMinBlock_px, std::max(width, height) / kBlocksAlong);
  const ImageU8 near_rust = with_blurred_edge(is_rust);
  Grid grid{.width = std::max(1, width / block), .height = std::max(1, height / block)};
  grid.step_x = static_cast<double>(width) / grid.width;
  grid.step_y = static_cast<double>(height) / grid.height;
  grid.values.assign(static_cast<std::size_t>(grid.width) * grid.height, {1.0, 1.0, 1.0});
  grid.is_known.assign(grid.values.size(), 0);
  for (int by = 0; by < grid.height; ++by) {
    for (int bx = 0; bx < grid.width; ++bx) {
      std::array<std::vector<double>, 3> found;
      std::size_t inside = 0;
      for (int y = static_cast<int>(by * grid.step_y); y < static_cast<int>((by + 1) * grid.step_y); ++y) {
        for (int x = static_cast<int>(bx * grid.step_x); x < static_cast<int>((bx + 1) * grid.step_x); ++x) {
          const std::size_t i = static_cast<std::size_t>(y) * width + x;
          if (mask.data()[i] == 0) continue;
          ++inside;
          if (near_rust.data()[i] != 0) continue;
          const std::array<double, 3> v = value(i);
          for (std::size_t c = 0; c < 3; ++c) found[c].push_back(v[c]);
        }
      }
      if (inside == 0 || static_cast<double>(found[0].size()) < kMinClean * static_cast<double>(inside)) continue;
      const std::size_t b = static_cast<std::size_t>(by) * grid.width + bx;
      for (std::size_t c = 0; c < 3; ++c) grid.values[b][c] = median(found[c]);
      grid.is_known[b] = 1;
    }
  }
  fill_unknown(grid);
  return grid;
}

}  // namespace

ImageF unrusted_color(const ImageF& unexposed, const ImageF& color, const ImageU8& mask, const ImageU8& is_rust) {
  const int width = color.width(), height = color.height();
  constexpr double kDark = 1e-3;  // Below it a ratio is noise.
  const Grid gain = block_medians(width, height, mask, is_rust, [&](std::size_t i) {
    const std::array<double, 3> now = pixel_of(color, i), before = pixel_of(unexposed, i);
    std::array<double, 3> ratio{};
    for (std::size_t c = 0; c < 3; ++c) ratio[c] = (now[c] + kDark) / (before[c] + kDark);
    return ratio;
  });
  ImageF out(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::array<double, 3> g = gain.at(x, y);
      for (int c = 0; c < 3; ++c)
        out.at(x, y, c) =
            static_cast<float>(g[static_cast<std::size_t>(c)] * static_cast<double>(unexposed.at(x, y, c)));
    }
  }
  return out;
}

ImageF common_color(const ImageF& color, const ImageU8& mask, const ImageU8& is_rust) {
  const Grid common =
      block_medians(color.width(), color.height(), mask, is_rust, [&](std::size_t i) { return pixel_of(color, i); });
  ImageF out(color.width(), color.height(), 3);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      const std::array<double, 3> c = common.at(x, y);
      for (int k = 0; k < 3; ++k) out.at(x, y, k) = static_cast<float>(c[static_cast<std::size_t>(k)]);
    }
  }
  return out;
}

}  // namespace patinate::analysis
