#include "analysis/cracks/crack_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kDx[8] = {0, 1, 1, 1, 0, -1, -1, -1}, kDy[8] = {-1, -1, 0, 1, 1, 1, 0, -1};  // Clockwise from above.
constexpr int kJunctionReach = 2;  ///< Pixels around a junction in which its arms touch each other.
constexpr double kSmallestCell = 16.0;
constexpr double kRadians = std::numbers::pi / 180.0;

struct Place {
  int x = 0, y = 0;
};

bool is_set(const ImageU8& image, int x, int y) { return image.contains(x, y) && image.at(x, y) != 0; }

std::array<bool, 8> neighbors(const ImageU8& image, int x, int y) {
  std::array<bool, 8> n{};
  for (std::size_t k = 0; k < 8; ++k) n[k] = is_set(image, x + kDx[k], y + kDy[k]);
  return n;
}

/// Times that a walk around a pixel enters the set.
int entries(const std::array<bool, 8>& n) {
  int count = 0;
  for (std::size_t k = 0; k < 8; ++k) count += !n[k] && n[(k + 1) % 8] ? 1 : 0;
  return count;
}

/// Pixels of every connected part of `image`.
std::vector<std::vector<Place>> parts_of(const ImageU8& image, bool with_diagonals) {
  ImageU8 left = image;
  std::vector<std::vector<Place>> parts;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (left.at(x, y) == 0) continue;
      std::vector<Place> part{{x, y}};
      left.at(x, y) = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        for (std::size_t k = 0; k < 8; k += with_diagonals ? 1 : 2) {
          const Place next{part[i].x + kDx[k], part[i].y + kDy[k]};
          if (!is_set(left, next.x, next.y)) continue;
          left.at(next.x, next.y) = 0;
          part.push_back(next);
        }
      }
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

/// Length of center lines: steps along and across the grid, weighted so that straight lines of all directions come out
/// right on average [Vossepoel and Smeulders 1982].
double length_of(const ImageU8& lines) {
  double length = 0.0;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) == 0) continue;
      const bool right = is_set(lines, x + 1, y), below = is_set(lines, x, y + 1);
      length += 0.948 * (right + below);
      if (!right && !below && is_set(lines, x + 1, y + 1)) length += 1.340;
      if (is_set(lines, x - 1, y + 1) && !is_set(lines, x - 1, y) && !below) length += 1.340;
    }
  }
  return length;
}

/// Groups of junction pixels no further apart than `reach`.
std::vector<Place> junction_centers(const ImageU8& lines, double reach, std::vector<std::vector<Place>>& groups) {
  ImageU8 near(lines.width(), lines.height());
  std::vector<Place> pixels;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) != 0 && entries(neighbors(lines, x, y)) >= 3) pixels.push_back({x, y});
    }
  }
  std::vector<bool> is_taken(pixels.size());
  std::vector<Place> centers;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (is_taken[i]) continue;
    std::vector<Place> group{pixels[i]};
    is_taken[i] = true;
    for (std::size_t g = 0; g < group.size(); ++g) {
      // Pixels are in reading order: those near in y stand together.
      for (std::size_t j = i + 1; j < pixels.size() && pixels[j].y <= group[g].y + reach; ++j) {
        if (is_taken[j] || std::hypot(pixels[j].x - group[g].x, pixels[j].y - group[g].y) > reach) continue;
        is_taken[j] = true;
        group.push_back(pixels[j]);
      }
    }
    double sx = 0.0, sy = 0.0;
    for (const Place& p : group) sx += p.x, sy += p.y;
    const auto n = static_cast<double>(group.size());
    centers.push_back({static_cast<int>(std::lround(sx / n)), static_cast<int>(std::lround(sy / n))});
    groups.push_back(std::move(group));
  }
  return centers;
}

/// Follows the lines from a junction to the circle around it. @returns no arms when another junction lies inside.
CrackJunction junction_at(const ImageU8& lines, const ImageU8& others, const std::vector<Place>& group, Place center,
                          double radius) {
  CrackJunction junction{.x = static_cast<double>(center.x), .y = static_cast<double>(center.y)};
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  ImageU8 seen(2 * reach + 1, 2 * reach + 1), ring(2 * reach + 1, 2 * reach + 1);
  std::vector<Place> walk = group;
  for (const Place& p : group) {
    if (seen.contains(p.x - center.x + reach, p.y - center.y + reach))
      seen.at(p.x - center.x + reach, p.y - center.y + reach) = 255;
  }
  for (std::size_t i = 0; i < walk.size(); ++i) {
    for (std::size_t k = 0; k < 8; ++k) {
      const int x = walk[i].x + kDx[k], y = walk[i].y + kDy[k], u = x - center.x + reach, v = y - center.y + reach;
      const double d = std::hypot(x - center.x, y - center.y);
      if (d > radius || !is_set(lines, x, y) || !seen.contains(u, v) || seen.at(u, v) != 0) continue;
      if (is_set(others, x, y) &&
          std::none_of(group.begin(), group.end(), [&](const Place& p) { return p.x == x && p.y == y; }))
        return junction;
      seen.at(u, v) = 255;
      if (d > radius - 1.5) ring.at(u, v) = 255;
      walk.push_back({x, y});
    }
  }
  for (const std::vector<Place>& arm : parts_of(ring, true)) {
    double sx = 0.0, sy = 0.0;
    for (const Place& p : arm) sx += p.x - reach, sy += p.y - reach;
    const double angle = std::atan2(-sy, sx) / kRadians;
    junction.arms_deg.push_back(angle < 0.0 ? angle + 360.0 : angle);
  }
  std::sort(junction.arms_deg.begin(), junction.arms_deg.end());
  return junction;
}

/// @returns nothing for what is shorter than `least_px`, or closed.
std::optional<CrackSegment> segment_of(const std::vector<Place>& pixels, double least_px) {
  const auto farthest = [&](const Place& from) {
    return *std::max_element(pixels.begin(), pixels.end(), [&](const Place& a, const Place& b) {
      return std::hypot(a.x - from.x, a.y - from.y) < std::hypot(b.x - from.x, b.y - from.y);
    });
  };
  const Place a = farthest(pixels.front()), b = farthest(a);
  const double chord = std::hypot(b.x - a.x, b.y - a.y);
  if (chord < least_px || static_cast<double>(pixels.size()) > 2.0 * chord) return std::nullopt;
  CrackSegment segment{.chord_px = chord};
  double squares = 0.0;
  const auto n = static_cast<double>(pixels.size());
  for (const Place& p : pixels) {
    const double off =
        ((p.x - a.x) * static_cast<double>(b.y - a.y) - (p.y - a.y) * static_cast<double>(b.x - a.x)) / chord;
    squares += off * off, segment.x += p.x / n, segment.y += p.y / n;
  }
  segment.waviness = std::sqrt(squares / n) / chord;
  return segment;
}

/// Largest (or smallest) value in a square around every pixel, inside the mask.
ImageF extreme(const ImageF& in, const ImageU8& mask, int reach, bool is_largest) {
  const float none = is_largest ? -1e30f : 1e30f;
  const auto better = [&](float a, float b) { return is_largest ? std::max(a, b) : std::min(a, b); };
  ImageF rows(in.width(), in.height(), 1, none), out = rows;
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      for (int i = std::max(0, x - reach); i <= std::min(in.width() - 1, x + reach); ++i) {
        if (is_inside(mask, i, y)) rows.at(x, y) = better(rows.at(x, y), in.at(i, y));
      }
    }
  }
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      for (int j = std::max(0, y - reach); j <= std::min(in.height() - 1, y + reach); ++j)
        out.at(x, y) = better(out.at(x, y), rows.at(x, j));
    }
  }
  return out;
}

/// The threshold that parts values best into two classes, [Otsu 1979], of 256 bins.
double otsu(const std::vector<float>& values) {
  const double high = static_cast<double>(*std::max_element(values.begin(), values.end()));
  if (!(high > 0.0)) return 0.0;
  std::array<double, 256> counts{};
  for (float v : values)
    counts[static_cast<std::size_t>(std::min(255.0, std::max(0.0, static_cast<double>(v)) / high * 256.0))] += 1.0;
  double total = 0.0, weighted = 0.0;
  for (std::size_t k = 0; k < 256; ++k) total += counts[k], weighted += counts[k] * static_cast<double>(k);
  double below = 0.0, below_weighted = 0.0, best = -1.0, threshold = 0.0;
  for (std::size_t k = 0; k + 1 < 256; ++k) {
    below += counts[k];
    below_weighted += counts[k] * static_cast<double>(k);
    if (below == 0.0 || below == total) continue;
    const double d = below_weighted / below - (weighted - below_weighted) / (total - below),
                 between = below * (total - below) * d * d;
    if (between > best) best = between, threshold = static_cast<double>(k + 1) / 256.0 * high;
  }
  return threshold;
}

}  // namespace

double CrackJunction::angle_deg() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < arms_deg.size(); ++i) {
    const double next = i + 1 < arms_deg.size() ? arms_deg[i + 1] : arms_deg[0] + 360.0;
    largest = std::max(largest, next - arms_deg[i]);
  }
  return (360.0 - largest) / (static_cast<double>(arms_deg.size()) - 1.0);
}

ImageU8 thinned(const ImageU8& cracks) {
  ImageU8 lines(cracks.width(), cracks.height());
  for (std::int64_t i = 0; i < cracks.num_pixels(); ++i) lines.data()[i] = cracks.data()[i] != 0 ? 255 : 0;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const bool is_second : {false, true}) {
      std::vector<Place> removed;
      for (int y = 0; y < lines.height(); ++y) {
        for (int x = 0; x < lines.width(); ++x) {
          if (lines.at(x, y) == 0) continue;
          const std::array<bool, 8> n = neighbors(lines, x, y);
          const auto count = std::count(n.begin(), n.end(), true);
          if (count < 2 || count > 6 || entries(n) != 1) continue;
          const bool keeps = is_second ? (n[0] && n[2] && n[6]) || (n[0] && n[4] && n[6])
                                       : (n[0] && n[2] && n[4]) || (n[2] && n[4] && n[6]);
          if (!keeps) removed.push_back({x, y});
        }
      }
      for (const Place& p : removed) lines.at(p.x, p.y) = 0;
      is_changed = is_changed || !removed.empty();
    }
  }
  // What is left of slanted lines are stairs, two pixels a step: their corners go.
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) == 0) continue;
      const std::array<bool, 8> n = neighbors(lines, x, y);
      for (std::size_t k = 0; k < 8; k += 2) {
        if (n[k] && n[(k + 2) % 8] && !n[(k + 4) % 8] && !n[(k + 5) % 8] && !n[(k + 6) % 8]) lines.at(x, y) = 0;
      }
    }
  }
  return lines;
}

CrackNetwork measure_cracks(const ImageU8& cracks, const ImageU8& mask, double arm_px) {
  if (!mask.empty() && !mask.same_size(cracks)) throw InvalidInput("cracks: the mask has another size");
  if (!(arm_px >= 3.0 && arm_px <= 1000.0)) throw InvalidInput("cracks: the arm length must be in [3, 1000] px");
  ImageU8 inside = cracks, cells(cracks.width(), cracks.height());
  CrackNetwork network;
  double surface = 0.0;
  for (int y = 0; y < cracks.height(); ++y) {
    for (int x = 0; x < cracks.width(); ++x) {
      if (!is_inside(mask, x, y)) inside.at(x, y) = 0;
      surface += is_inside(mask, x, y) ? 1.0 : 0.0;
      network.area_px += inside.at(x, y) != 0 ? 1.0 : 0.0;
    }
  }
  if (surface == 0.0) throw InvalidInput("cracks: the mask covers nothing");
  network.share = network.area_px / surface;
  const ImageU8 lines = thinned(inside);
  network.length_px = length_of(lines);
  for (std::int64_t i = 0; i < cells.num_pixels(); ++i) cells.data()[i] = lines.data()[i] == 0 ? 255 : 0;
  for (const std::vector<Place>& cell : parts_of(cells, false)) {
    const bool is_open = std::any_of(cell.begin(), cell.end(), [&](const Place& p) {
      return p.x == 0 || p.y == 0 || p.x + 1 == cracks.width() || p.y + 1 == cracks.height() ||
             !is_inside(mask, p.x, p.y);
    });
    if (is_open || static_cast<double>(cell.size()) < kSmallestCell) continue;
    CrackCell made{.area_px = static_cast<double>(cell.size())};
    for (const Place& p : cell) made.x += p.x / made.area_px, made.y += p.y / made.area_px;
    network.cells.push_back(made);
  }
  std::vector<std::vector<Place>> groups;
  const std::vector<Place> centers = junction_centers(lines, std::max(3.0, network.width_px().value_or(0.0)), groups);
  ImageU8 junctions(lines.width(), lines.height());
  for (const auto& group : groups) {
    for (const Place& p : group) junctions.at(p.x, p.y) = 255;
  }
  for (std::size_t k = 0; k < centers.size(); ++k) {
    CrackJunction junction = junction_at(lines, junctions, groups[k], centers[k], arm_px);
    if (junction.arms_deg.size() >= 3) network.junctions.push_back(std::move(junction));
  }
  // Around a junction its arms touch each other.
  ImageU8 between = lines;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (junctions.at(x, y) == 0) continue;
      for (int j = -kJunctionReach; j <= kJunctionReach; ++j) {
        for (int i = -kJunctionReach; i <= kJunctionReach; ++i) {
          if (between.contains(x + i, y + j)) between.at(x + i, y + j) = 0;
        }
      }
    }
  }
  for (const std::vector<Place>& part : parts_of(between, true)) {
    if (const std::optional<CrackSegment> segment = segment_of(part, 2.0 * arm_px))
      network.segments.push_back(*segment);
  }
  return network;
}

ImageU8 find_cracks(const ImageF& lightness, const ImageU8& mask, const CrackFinder& settings) {
  if (lightness.channels() != 1 || (!mask.empty() && !mask.same_size(lightness)))
    throw InvalidInput("cracks: one channel and a mask of its size are needed");
  if (settings.reach_px < 1 || settings.reach_px > 100 || !(settings.least_contrast > 0.0))
    throw InvalidInput("cracks: the reach must be in [1, 100] px and the contrast > 0");
  const ImageF closed = extreme(extreme(lightness, mask, settings.reach_px, true), mask, settings.reach_px, false);
  std::vector<float> depth;
  for (int y = 0; y < lightness.height(); ++y) {
    for (int x = 0; x < lightness.width(); ++x) {
      if (is_inside(mask, x, y)) depth.push_back(closed.at(x, y) - lightness.at(x, y));
    }
  }
  ImageU8 out(lightness.width(), lightness.height());
  if (depth.empty()) return out;
  const double threshold = std::max(otsu(depth), settings.least_contrast);
  for (int y = 0; y < lightness.height(); ++y) {
    for (int x = 0; x < lightness.width(); ++x)
      out.at(x, y) =
          is_inside(mask, x, y) && static_cast<double>(closed.at(x, y) - lightness.at(x, y)) > threshold ? 255 : 0;
  }
  for (const std::vector<Place>& part : parts_of(out, true)) {
    if (part.size() >= static_cast<std::size_t>(settings.least_area_px)) continue;
    for (const Place& p : part) out.at(p.x, p.y) = 0;
  }
  return out;
}

}  // namespace patinate::analysis
