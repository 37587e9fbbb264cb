#include "datasets_synthetic/crackle_growth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets_synthetic/crackle_relax.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/random.h"

namespace patinate::datasets {

namespace {

constexpr double kStep = 0.5;          // px
constexpr int kTile = 32;              // px
constexpr std::uint32_t kGrowth = 11;  // Purposes of random streams.
constexpr std::uint32_t kVariation = 12;
constexpr std::uint32_t kHairline = 13;
constexpr double kGrainAngle = std::numbers::pi / 2.0;  // Vertical.

struct Point {
  double x, y;
};

struct Walk {
  std::vector<Point> points;
  int ends_on = -1;  // Crack, or -1: the border (or nothing).
};

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

// State of the growing network: distance to the nearest crack, and which crack owns a pixel.
class Network {
 public:
  Network(const CrackleField& field, double grain, std::uint64_t seed)
      : field_(field),
        grain_(grain),
        width_(field.spacing_px.width()),
        height_(field.spacing_px.height()),
        distance_(height_, width_, CV_32F),
        is_clear_(height_, width_, CV_8U, cv::Scalar(255)),
        owner_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), -1),
        variation_(width_, height_),
        tiles_x_((width_ + kTile - 1) / kTile),
        tiles_y_((height_ + kTile - 1) / kTile),
        tile_best_(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_)),
        tile_max_(tile_best_.size()) {
    const SmoothNoise noise(seed, kVariation, width_, height_, 14.0, 14.0);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        // The border of the plate is a weaker free edge than a crack.
        const double border = std::min({x + 1, y + 1, width_ - x, height_ - y});
        distance_.at<float>(y, x) = static_cast<float>(border + 0.3 * static_cast<double>(spacing(x, y)));
        variation_.at(x, y) = static_cast<float>(std::exp(0.8 * noise(x, y)));
      }
    }
    update_tiles(0, 0, width_ - 1, height_ - 1);
  }

  struct Site {
    double ratio = 0.0;  // Half the free width over half the spacing.
    int x = 0, y = 0;
  };
  [[nodiscard]] Site best_site() const {
    Site best;
    for (const Site& s : tile_best_) {
      if (s.ratio > best.ratio) best = s;
    }
    return best;
  }

  // A crack through (x, y): across the cell the short way.
  [[nodiscard]] std::pair<Walk, Walk> walk_both_ways(const Site& site, RandomStream& random) const {
    const double angle = short_way(site, random);
    const Point start{site.x + random.uniform() - 0.5, site.y + random.uniform() - 0.5};
    return {walk(start, angle, 1e9, random), walk(start, angle + std::numbers::pi, 1e9, random)};
  }

  [[nodiscard]] Walk walk(Point p, double heading, double max_length, RandomStream& random) const {
    Walk walk;
    const double base = heading;
    const double limit = std::min(max_length, 4.0 * (width_ + height_));
    for (double length = 0.0; length < limit; length += kStep) {
      walk.points.push_back(p);
      const int x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
      if (x < 0 || y < 0 || x >= width_ || y >= height_) return walk;
      const double distance = static_cast<double>(distance_.at<float>(y, x));
      if (distance < 1.0 && length > 2.0) {
        walk.ends_on = nearest_owner(x, y);
        return walk;
      }
      heading += turn(x, y, distance, heading, base, random);
      p.x += kStep * std::cos(heading);
      p.y += kStep * std::sin(heading);
    }
    return walk;
  }

  // Marks the crack's pixels and brings distances up to date where they can have changed.
  void add(const std::vector<std::array<double, 2>>& points, int crack) {
    int x0 = width_, y0 = height_, x1 = -1, y1 = -1;
    for (const auto& p : points) {
      const int x = static_cast<int>(std::lround(p[0])), y = static_cast<int>(std::lround(p[1]));
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
      x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
      std::int32_t& owner = owner_[index(x, y)];
      if (owner < 0) owner = crack;
      is_clear_.at<std::uint8_t>(y, x) = 0;
    }
    if (x1 < 0) return;
    // A pixel that the new crack is nearest to was no farther than that from the older ones.
    const int r = static_cast<int>(max_distance_) + 2;
    x0 = std::max(0, x0 - r), y0 = std::max(0, y0 - r), x1 = std::min(width_ - 1, x1 + r),
    y1 = std::min(height_ - 1, y1 + r);
    const cv::Rect box(x0, y0, x1 - x0 + 1, y1 - y0 + 1);
    cv::Mat fresh;
    cv::distanceTransform(is_clear_(box), fresh, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::Mat old = distance_(box);
    cv::min(old, fresh, old);
    update_tiles(x0, y0, x1, y1);
  }

  [[nodiscard]] double spacing(int x, int y) const { return static_cast<double>(field_.spacing_px.at(x, y)); }
  [[nodiscard]] bool contains(int x, int y) const { return field_.spacing_px.contains(x, y); }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  [[nodiscard]] double clear_length(Point p, double angle) const {
    const double dx = std::cos(angle), dy = std::sin(angle);
    double length = 0.0;
    while (true) {
      const int x = static_cast<int>(std::lround(p.x + length * dx)),
                y = static_cast<int>(std::lround(p.y + length * dy));
      if (!contains(x, y)) return length;
      const double d = static_cast<double>(distance_.at<float>(y, x));
      if (d < 1.0) return length;
      length += std::max(0.7, 0.7 * d);  // Sphere tracing; the border's bonus makes it an upper bound only there.
    }
  }

  // Direction in which the crack through a cell is shortest, first cracks with a liking for the grain.
  [[nodiscard]] double short_way(const Site& site, RandomStream& random) const {
    constexpr int kDirections = 24;
    const Point p{static_cast<double>(site.x), static_cast<double>(site.y)};
    const double turned = random.uniform();
    const double liking = grain_ * std::clamp(0.5 * (site.ratio - 1.2), 0.0, 1.0);
    double best = 1e300, best_angle = 0.0;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = std::numbers::pi * (k + turned) / kDirections;
      const double chord = clear_length(p, angle) + clear_length(p, angle + std::numbers::pi);
      const double across = std::sin(angle - kGrainAngle);
      const double cost = chord * (1.0 + 6.0 * liking * across * across) * (1.0 + 0.35 * random.uniform());
      if (cost < best) best = cost, best_angle = angle;
    }
    return best_angle;
  }

  // Change of heading over one step: unsteadiness, a pull back to the crack's own direction, and near an older crack a
  // turn toward meeting it at a right angle, since the stress along that crack is gone.
  [[nodiscard]] double turn(int x, int y, double distance, double heading, double base, RandomStream& random) const {
    const double wander = static_cast<double>(field_.unsteadiness.at(x, y));
    double change = (0.022 + 0.13 * wander * wander) * std::sqrt(kStep) * random.normal();
    change -= (0.012 + 0.05 * wander) * kStep * wrapped(heading - base);
    const double radius = (0.2 + 0.22 * wander * wander) * spacing(x, y);  // Thick paint: straight, and turning late.
    if (distance < radius && distance > 0.0) {
      const double gx = slope(x + 1, y, x - 1, y), gy = slope(x, y + 1, x, y - 1);
      const double toward = -(gx * std::cos(heading) + gy * std::sin(heading));
      if (gx * gx + gy * gy > 0.05 && toward > 0.15) {
        const double weight = 1.0 - distance / radius;
        const double off = wrapped(std::atan2(-gy, -gx) - heading);
        change += std::min(0.9, 1.3 * weight / (distance + 1.0) * kStep * 2.0) * off;
      }
    }
    return change;
  }
  [[nodiscard]] double slope(int xa, int ya, int xb, int yb) const {
    const auto at = [&](int x, int y) {
      return static_cast<double>(distance_.at<float>(std::clamp(y, 0, height_ - 1), std::clamp(x, 0, width_ - 1)));
    };
    return 0.5 * (at(xa, ya) - at(xb, yb));
  }

  [[nodiscard]] int nearest_owner(int x, int y) const {
    for (int radius = 0; radius <= 2; ++radius) {
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          if (contains(x + dx, y + dy) && owner_[index(x + dx, y + dy)] >= 0) return owner_[index(x + dx, y + dy)];
        }
      }
    }
    return -1;
  }

  void update_tiles(int x0, int y0, int x1, int y1) {
    for (int ty = y0 / kTile; ty <= y1 / kTile; ++ty) {
      for (int tx = x0 / kTile; tx <= x1 / kTile; ++tx) update_tile(tx, ty);
    }
    max_distance_ = *std::max_element(tile_max_.begin(), tile_max_.end());
  }
  void update_tile(int tx, int ty) {
    Site best;
    float farthest = 0.0f;
    for (int y = ty * kTile; y < std::min(height_, (ty + 1) * kTile); ++y) {
      const float* distance = distance_.ptr<float>(y);
      for (int x = tx * kTile; x < std::min(width_, (tx + 1) * kTile); ++x) {
        const double ratio = 2.0 * static_cast<double>(distance[x] * variation_.at(x, y)) / spacing(x, y);
        if (ratio > best.ratio) best = {ratio, x, y};
        farthest = std::max(farthest, distance[x]);
      }
    }
    const std::size_t tile =
        static_cast<std::size_t>(ty) * static_cast<std::size_t>(tiles_x_) + static_cast<std::size_t>(tx);
    tile_best_[tile] = best;
    tile_max_[tile] = farthest;
  }

  const CrackleField& field_;
  double grain_;
  int width_, height_;
  cv::Mat distance_;
  cv::Mat is_clear_;
  std::vector<std::int32_t> owner_;
  ImageF variation_;
  int tiles_x_, tiles_y_;
  std::vector<Site> tile_best_;
  std::vector<float> tile_max_;  // Largest distance in a tile.
  float max_distance_ = 0.0f;
};

Crack joined(const Walk& forward, const Walk& backward) {
  Crack crack;
  for (std::size_t i = backward.points.size(); i-- > 1;) {
    crack.points_px.push_back({backward.points[i].x, backward.points[i].y});
  }
  crack.origin = static_cast<int>(crack.points_px.size());
  for (const Point& p : forward.points) crack.points_px.push_back({p.x, p.y});
  return crack;
}

// Hairlines that leave older cracks at right angles and stop inside a cell.
void add_dead_ends(const Network& network, std::uint64_t seed, std::vector<Crack>& cracks,
                   std::vector<std::array<int, 2>>& ends_on) {
  const int num_parents = static_cast<int>(cracks.size());
  for (int parent = 0; parent < num_parents; ++parent) {
    RandomStream random(seed, static_cast<std::uint64_t>(parent), kHairline);
    const std::size_t size = cracks[parent].points_px.size();
    const double length_px = kStep * static_cast<double>(size);
    for (double at = 0.0; at < length_px;) {
      const std::size_t i = static_cast<std::size_t>(at / kStep);
      const auto p = cracks[parent].points_px[std::min(i, size - 1)];
      const int x = static_cast<int>(std::lround(p[0])), y = static_cast<int>(std::lround(p[1]));
      const double spacing = network.contains(x, y) ? network.spacing(x, y) : 20.0;
      at += spacing * (0.5 + 3.0 * random.uniform());
      const bool is_left = random.uniform() < 0.5;
      const double length = spacing * (0.15 + 0.4 * random.uniform());
      if (!network.contains(x, y) || i + 4 >= size || i < 4) continue;
      const auto& a = cracks[parent].points_px[i - 4];
      const auto& b = cracks[parent].points_px[i + 4];
      const double along = std::atan2(b[1] - a[1], b[0] - a[0]);
      const double away = along + (is_left ? 0.5 : -0.5) * std::numbers::pi + 0.25 * random.normal();
      const Walk walk = network.walk({p[0] + 1.5 * std::cos(away), p[1] + 1.5 * std::sin(away)}, away, length, random);
      if (walk.points.size() < 8 || walk.ends_on >= 0) continue;
      Crack crack = joined(walk, {});
      crack.is_dead_end = true;
      crack.level = cracks[parent].level + 1;
      cracks.push_back(std::move(crack));
      ends_on.push_back({parent, -1});
    }
  }
}

}  // namespace

std::vector<Crack> grow_cracks(const CrackleField& field, double grain, std::uint64_t seed, std::vector<double>& onset,
                               std::vector<std::array<int, 2>>& ends_on, const RunControl& control) {
  Network network(field, grain, seed);
  std::vector<Crack> cracks;
  std::vector<double> ratios;
  const std::size_t max_cracks = field.spacing_px.num_pixels() / 8 + 8;
  while (cracks.size() < max_cracks) {
    control.throw_if_stopped();
    const Network::Site site = network.best_site();
    if (!(site.ratio > 1.0)) break;
    const int id = static_cast<int>(cracks.size());
    RandomStream random(seed, static_cast<std::uint64_t>(id), kGrowth);
    const auto [forward, backward] = network.walk_both_ways(site, random);
    Crack crack = joined(forward, backward);
    for (const int end : {forward.ends_on, backward.ends_on}) {
      if (end >= 0) crack.level = std::max(crack.level, cracks[end].level + 1);
    }
    network.add(crack.points_px, id);
    ends_on.push_back({forward.ends_on, backward.ends_on});
    ratios.push_back(ratios.empty() ? site.ratio : std::min(ratios.back(), site.ratio));
    cracks.push_back(std::move(crack));
  }
  const double first = ratios.empty() ? 1.0 : std::log(ratios.front());
  for (const double r : ratios) onset.push_back(first > 0.0 ? 1.0 - std::log(r) / first : 1.0);
  relax_junctions(field, seed, ends_on, cracks);
  Network relaxed(field, grain, seed);
  for (std::size_t k = 0; k < cracks.size(); ++k) relaxed.add(cracks[k].points_px, static_cast<int>(k));
  add_dead_ends(relaxed, seed, cracks, ends_on);
  onset.resize(cracks.size(), 1.0);
  return cracks;
}

}  // namespace patinate::datasets
