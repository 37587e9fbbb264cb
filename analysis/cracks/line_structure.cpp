#include "analysis/cracks/line_structure.h"

#include <algorithm>
#include <cmath>

#include "analysis/cracks/line_pixels.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

/// px2 and px: smaller cells are holes in a line; nearer junctions are one.
constexpr double kSmallestLineCell = 16.0, kLineJunctionReach = 3.0;

/// The tip of a line, not a lone pixel: its neighbors are one, or two that touch each other.
bool is_end(const ImageU8& lines, int x, int y) {
  const std::array<bool, 8> n = set_neighbors(lines, x, y);
  return std::count(n.begin(), n.end(), true) <= 2 && num_branches(n) == 1;
}

/// Pixels from an end up to a junction (excluded) or another end, or nothing where there are more than `most`.
std::vector<PixelPlace> short_branch(const ImageU8& lines, PixelPlace from, double most) {
  std::vector<PixelPlace> path{from};
  const auto is_known = [&](int x, int y) {
    return std::any_of(path.begin(), path.end(), [&](const PixelPlace& p) { return p.x == x && p.y == y; });
  };
  for (;;) {
    const PixelPlace at = path.back();
    std::size_t next = 8;
    for (const std::size_t k : {0u, 2u, 4u, 6u, 1u, 3u, 5u, 7u}) {  // Stairs are walked step by step.
      const int x = at.x + kAroundX[k], y = at.y + kAroundY[k];
      if (is_set(lines, x, y) && !is_known(x, y)) {
        next = k;
        break;
      }
    }
    if (next == 8) return path;
    const PixelPlace step{at.x + kAroundX[next], at.y + kAroundY[next]};
    if (num_branches(set_neighbors(lines, step.x, step.y)) >= 3) return path;
    if (static_cast<double>(path.size() + 1) >= most) return {};
    path.push_back(step);
  }
}

/// Pixels more than `reach` away, along x and along y, from every pixel outside. 0 / 255.
ImageU8 away_from_borders(const ImageU8& mask, int width, int height, int reach) {
  ImageU8 out(width, height, 1, 255);
  const auto w = static_cast<std::size_t>(width);
  // In a row, then in a column of what is left: the last place outside, seen from both sides.
  for (int y = 0; y < height; ++y) {
    for (int x = 0, outside = -1; x < width; ++x) {
      if (!is_inside(mask, x, y)) outside = x;
      if (x - outside <= reach) out.at(x, y) = 0;
    }
    for (int x = width - 1, outside = width; x >= 0; --x) {
      if (!is_inside(mask, x, y)) outside = x;
      if (outside - x <= reach) out.at(x, y) = 0;
    }
  }
  const ImageU8 rows = out;
  std::vector<int> above(w, -1), below(w, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int& last = above[x];
      if (rows.at(x, y) == 0) last = y;
      if (y - last <= reach) out.at(x, y) = 0;
    }
  }
  for (int y = height; y-- > 0;) {
    for (int x = 0; x < width; ++x) {
      int& last = below[x];
      if (rows.at(x, y) == 0) last = y;
      if (last - y <= reach) out.at(x, y) = 0;
    }
  }
  return out;
}

/// Adds the cells between center lines. Pixels outside belong to the cells that they touch, which are open for that.
void add_cells(const ImageU8& lines, const ImageU8& mask, LineStructure& out) {
  ImageU8 cells(lines.width(), lines.height());
  for (std::int64_t i = 0; i < cells.num_pixels(); ++i) cells.data()[i] = lines.data()[i] == 0 ? 255 : 0;
  for (const std::vector<PixelPlace>& cell : parts_of(cells, false)) {
    const bool is_open = std::any_of(cell.begin(), cell.end(), [&](const PixelPlace& p) {
      return p.x == 0 || p.y == 0 || p.x + 1 == lines.width() || p.y + 1 == lines.height() ||
             !is_inside(mask, p.x, p.y);
    });
    const auto area = static_cast<double>(cell.size());
    if (is_open || area < kSmallestLineCell) continue;
    out.closed_px += area;
    out.cells_px.push_back(area);
  }
}

}  // namespace

LineStructure& LineStructure::operator+=(const LineStructure& other) {
  surface_px += other.surface_px, line_px += other.line_px, closed_px += other.closed_px;
  length_px += other.length_px, inner_length_px += other.inner_length_px;
  num_ends += other.num_ends, num_junctions += other.num_junctions;
  cells_px.insert(cells_px.end(), other.cells_px.begin(), other.cells_px.end());
  for (std::size_t k = 0; k < 4; ++k) {
    quarter_length_px[k] += other.quarter_length_px[k];
    quarter_surface_px[k] += other.quarter_surface_px[k];
  }
  return *this;
}

std::optional<double> LineStructure::ends_per_px() const {
  return inner_length_px > 0.0 ? std::optional(static_cast<double>(num_ends) / inner_length_px) : std::nullopt;
}

std::optional<double> LineStructure::median_cell_px() const {
  if (cells_px.empty()) return std::nullopt;
  std::vector<double> sorted = cells_px;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  return (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0;
}

ImageU8 pruned(const ImageU8& lines, double spur_px) {
  ImageU8 out = lines;
  for (bool is_changed = true; is_changed;) {
    std::vector<PixelPlace> spurs;  // All of one round at once: which of two that meet is shorter does not matter.
    for (int y = 0; y < out.height(); ++y) {
      for (int x = 0; x < out.width(); ++x) {
        if (out.at(x, y) == 0) continue;
        const std::array<bool, 8> n = set_neighbors(out, x, y);
        const bool is_alone = std::count(n.begin(), n.end(), true) == 0;
        if (is_alone && spur_px > 1.0) spurs.push_back({x, y});
        if (is_alone || !is_end(out, x, y)) continue;
        const std::vector<PixelPlace> branch = short_branch(out, {x, y}, spur_px);
        spurs.insert(spurs.end(), branch.begin(), branch.end());
      }
    }
    for (const PixelPlace& p : spurs) out.at(p.x, p.y) = 0;
    is_changed = !spurs.empty();
  }
  return out;
}

ImageU8 dead_ends(const ImageU8& lines, const ImageU8& mask, int border_px) {
  ImageU8 out = away_from_borders(mask, lines.width(), lines.height(), border_px);
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) == 0 || !is_end(lines, x, y)) out.at(x, y) = 0;
    }
  }
  return out;
}

LineStructure measure_structure(const ImageU8& lines, const ImageU8& mask, const ImageU8& quarter,
                                const LineStructureOptions& options, const RunControl& control) {
  if ((!mask.empty() && !mask.same_size(lines)) || (!quarter.empty() && !quarter.same_size(lines)))
    throw InvalidInput("lines: the mask or the quarters have another size");
  if (!(options.spur_px >= 0.0) || options.border_px < 0)
    throw InvalidInput("lines: the spur and the border must be >= 0 px");
  const int w = lines.width(), h = lines.height();
  LineStructure out;
  ImageU8 inside = lines;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (!is_inside(mask, x, y)) inside.at(x, y) = 0;
    }
  }
  control.throw_if_stopped();
  const ImageU8 centers = pruned(thinned(inside), options.spur_px);
  control.throw_if_stopped();
  const ImageU8 inner = away_from_borders(mask, w, h, options.border_px);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (!is_inside(mask, x, y)) continue;
      const double length = centers.at(x, y) != 0 ? length_from(centers, x, y) : 0.0;
      out.surface_px += 1.0;
      out.line_px += inside.at(x, y) != 0 ? 1.0 : 0.0;
      out.length_px += length;
      out.inner_length_px += inner.at(x, y) != 0 ? length : 0.0;
      out.num_ends += centers.at(x, y) != 0 && inner.at(x, y) != 0 && is_end(centers, x, y) ? 1 : 0;
      if (quarter.empty() || quarter.at(x, y) > 3) continue;
      out.quarter_length_px[quarter.at(x, y)] += length;
      out.quarter_surface_px[quarter.at(x, y)] += 1.0;
    }
  }
  std::vector<std::vector<PixelPlace>> groups;
  out.num_junctions = static_cast<std::int64_t>(junction_centers(centers, kLineJunctionReach, groups).size());
  control.throw_if_stopped();
  add_cells(centers, mask, out);
  return out;
}

}  // namespace patinate::analysis
