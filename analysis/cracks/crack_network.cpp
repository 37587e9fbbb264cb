#include "analysis/cracks/crack_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "analysis/cracks/line_pixels.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kJunctionReach = 2;       ///< Pixels around a junction in which its arms touch each other.
constexpr double kSmallestCell = 16.0;  ///< px2; smaller cells are holes in a crack.
constexpr double kRadians = std::numbers::pi / 180.0;

double length_of(const ImageU8& lines) {
  double length = 0.0;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) length += lines.at(x, y) != 0 ? length_from(lines, x, y) : 0.0;
  }
  return length;
}

/// Follows the lines from a junction to the circle around it. @returns no arms when another junction lies inside.
CrackJunction junction_at(const ImageU8& lines, const ImageU8& others, const std::vector<PixelPlace>& group,
                          PixelPlace center, double radius) {
  CrackJunction junction{.x = static_cast<double>(center.x), .y = static_cast<double>(center.y)};
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  ImageU8 seen(2 * reach + 1, 2 * reach + 1), ring(2 * reach + 1, 2 * reach + 1);
  std::vector<PixelPlace> walk = group;
  for (const PixelPlace& p : group) {
    if (seen.contains(p.x - center.x + reach, p.y - center.y + reach))
      seen.at(p.x - center.x + reach, p.y - center.y + reach) = 255;
  }
  for (std::size_t i = 0; i < walk.size(); ++i) {
    for (std::size_t k = 0; k < 8; ++k) {
      const int x = walk[i].x + kAroundX[k], y = walk[i].y + kAroundY[k], u = x - center.x + reach,
                v = y - center.y + reach;
      const double d = std::hypot(x - center.x, y - center.y);
      if (d > radius || !is_set(lines, x, y) || !seen.contains(u, v) || seen.at(u, v) != 0) continue;
      if (is_set(others, x, y) &&
          std::none_of(group.begin(), group.end(), [&](const PixelPlace& p) { return p.x == x && p.y == y; }))
        return junction;
      seen.at(u, v) = 255;
      if (d > radius - 1.5) ring.at(u, v) = 255;
      walk.push_back({x, y});
    }
  }
  for (const std::vector<PixelPlace>& arm : parts_of(ring, true)) {
    double sx = 0.0, sy = 0.0;
    for (const PixelPlace& p : arm) sx += p.x - reach, sy += p.y - reach;
    const double angle = std::atan2(-sy, sx) / kRadians;
    junction.arms_deg.push_back(angle < 0.0 ? angle + 360.0 : angle);
  }
  std::sort(junction.arms_deg.begin(), junction.arms_deg.end());
  return junction;
}

/// @returns nothing for what is shorter than `least_px`, or closed.
std::optional<CrackSegment> segment_of(const std::vector<PixelPlace>& pixels, double least_px) {
  const auto farthest = [&](const PixelPlace& from) {
    return *std::max_element(pixels.begin(), pixels.end(), [&](const PixelPlace& a, const PixelPlace& b) {
      return std::hypot(a.x - from.x, a.y - from.y) < std::hypot(b.x - from.x, b.y - from.y);
    });
  };
  const PixelPlace a = farthest(pixels.front()), b = farthest(a);
  const double chord = std::hypot(b.x - a.x, b.y - a.y);
  if (chord < least_px || static_cast<double>(pixels.size()) > 2.0 * chord) return std::nullopt;
  CrackSegment segment{.chord_px = chord};
  double squares = 0.0;
  const auto n = static_cast<double>(pixels.size());
  for (const PixelPlace& p : pixels) {
    const double off =
        ((p.x - a.x) * static_cast<double>(b.y - a.y) - (p.y - a.y) * static_cast<double>(b.x - a.x)) / chord;
    squares += off * off, segment.x += p.x / n, segment.y += p.y / n;
  }
  segment.waviness = std::sqrt(squares / n) / chord;
  return segment;
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
  for (const std::vector<PixelPlace>& cell : parts_of(cells, false)) {
    const bool is_open = std::any_of(cell.begin(), cell.end(), [&](const PixelPlace& p) {
      return p.x == 0 || p.y == 0 || p.x + 1 == cracks.width() || p.y + 1 == cracks.height() ||
             !is_inside(mask, p.x, p.y);
    });
    if (is_open || static_cast<double>(cell.size()) < kSmallestCell) continue;
    CrackCell made{.area_px = static_cast<double>(cell.size())};
    for (const PixelPlace& p : cell) made.x += p.x / made.area_px, made.y += p.y / made.area_px;
    network.cells.push_back(made);
  }
  std::vector<std::vector<PixelPlace>> groups;
  const std::vector<PixelPlace> centers =
      junction_centers(lines, std::max(3.0, network.width_px().value_or(0.0)), groups);
  ImageU8 junctions(lines.width(), lines.height());
  for (const auto& group : groups) {
    for (const PixelPlace& p : group) junctions.at(p.x, p.y) = 255;
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
  for (const std::vector<PixelPlace>& part : parts_of(between, true)) {
    if (const std::optional<CrackSegment> segment = segment_of(part, 2.0 * arm_px))
      network.segments.push_back(*segment);
  }
  return network;
}

}  // namespace patinate::analysis
