#include "analysis/evaluation/surface_windows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "libcommon/atlas/raster.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::analysis {

namespace {

constexpr int kHalf = kWindowSide / 2;
constexpr std::uint64_t kSeed = 113;
constexpr std::uint32_t kDrawPurpose = 1, kCutPurpose = 2;
constexpr int kNumCandidates = 64;     // Windows of the source that are looked at for one of the surface.
constexpr int kControlStep = 8;        // Their control is looked at in every eighth row and column.
constexpr double kLargestTexel = 4.0;  // In median areas: larger texels are drawn no more often than that.

/// Place and turn by which one window is drawn.
struct DrawnWindow {
  TexelId middle = -1;
  double turn = 0.0;
};

double texel_area_mm2(const TexelMap& surface, TexelId t) {
  const Eigen::Matrix<double, 3, 2> m = surface.mm_per_texel(surface.triangle(t));
  return m.col(0).cross(m.col(1)).norm();
}

double random_turn(RandomStream& random) { return 2.0 * std::numbers::pi * random.uniform(); }

/// Texels are drawn by their number in the whole map, and kept by their area: kNumWindows where all are of the median
/// area. Those of them that lie in the part.
std::vector<DrawnWindow> draw_windows(const MapPart& part, const PartCounts& before, const PartCounts& all) {
  std::vector<TexelId> covered;
  part.for_each_covered([&](TexelId t, std::int64_t) { covered.push_back(t); });
  const double largest = kLargestTexel * std::pow(part.surface.median_texel_size_mm(), 2);
  std::vector<DrawnWindow> drawn;
  for (int k = 0; k < static_cast<int>(kLargestTexel * kNumWindows); ++k) {
    RandomStream random(kSeed, static_cast<std::uint64_t>(k), kDrawPurpose);
    const auto number = static_cast<std::int64_t>(random.uniform() * static_cast<double>(all.texels)) - before.texels;
    if (number < 0 || number >= static_cast<std::int64_t>(covered.size())) continue;
    const TexelId middle = covered[number];
    if (random.uniform() * largest < texel_area_mm2(part.surface, middle))
      drawn.push_back({middle, random_turn(random)});
  }
  return drawn;
}

/// Bilinear between the texels of the point's chart.
std::optional<float> value_at(const MapPart& part, const ImageF& values, const SurfacePoint& p) {
  if (p.triangle < 0) return std::nullopt;
  const TexelId nearest = part.surface.texel_of(p);
  if (nearest < 0) return std::nullopt;
  const Mesh& mesh = part.surface.mesh();
  const Triangle& corners = mesh.uv_triangles[p.triangle];
  const auto uv = [&](std::size_t k) -> const Vec2& { return mesh.uvs[corners[k]]; };
  const Vec2 at = texel_from_uv((1.0 - p.b1 - p.b2) * uv(0) + p.b1 * uv(1) + p.b2 * uv(2), part.surface.width(),
                                part.surface.height());
  const int x0 = static_cast<int>(std::floor(at.x())), y0 = static_cast<int>(std::floor(at.y()));
  const int chart = part.surface.chart(nearest);
  double sum = 0.0, weight = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int x = x0 + k % 2, y = y0 + k / 2;
    if (!part.rect.contains(x, y)) continue;
    const TexelId t = TexelId{y} * part.surface.width() + x;
    if (part.surface.chart(t) != chart) continue;
    const double w = (1.0 - std::abs(at.x() - x)) * (1.0 - std::abs(at.y() - y));
    sum += w * static_cast<double>(values.data()[part.place(t)]);
    weight += w;
  }
  if (!(weight > 0.0)) return std::nullopt;
  return static_cast<float>(sum / weight);
}

/// A point of a window on the surface, and which way the window's x axis runs there.
struct WindowPoint {
  SurfacePoint at;
  Vec3 x_axis = Vec3::Zero();  ///< Unit, in the triangle's plane.
  [[nodiscard]] bool is_found() const { return at.triangle >= 0; }
};

/// Lays a window flat on a surface: from its middle outward each point is found from those beside it that are laid
/// already, by a step along their axes, and lies in the mean of where they lead. Ways around a bump differ; what they
/// differ by is spread.
class WindowLayer {
 public:
  explicit WindowLayer(const TexelMap& surface) : surface_(surface) {
    for (const Triangle& t : surface.mesh().triangles) {
      const auto corner = [&](std::size_t k) { return surface.mesh().positions[t[k]]; };
      normals_.push_back((corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized());
    }
    for (int i = 0; i < kWindowSide * kWindowSide; ++i) outward_.push_back(i);
    const auto distance = [](int i) {
      const int x = i % kWindowSide - kHalf, y = i / kWindowSide - kHalf;
      return x * x + y * y;
    };
    std::stable_sort(outward_.begin(), outward_.end(), [&](int a, int b) { return distance(a) < distance(b); });
  }

  /// Row by row; not found where the surface ends.
  [[nodiscard]] std::vector<WindowPoint> lay(const WindowPoint& middle, double step_mm) const {
    std::vector<WindowPoint> points(outward_.size());
    points[outward_[0]] = middle;
    for (std::size_t k = 1; k < outward_.size(); ++k) {
      const int x = outward_[k] % kWindowSide, y = outward_[k] / kWindowSide;
      std::vector<WindowPoint> led;
      for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= kWindowSide || y + dy >= kWindowSide) continue;
        const WindowPoint& from = points[(y + dy) * kWindowSide + x + dx];
        if (!from.is_found()) continue;
        if (const WindowPoint p = stepped(from, -dx * step_mm, -dy * step_mm); p.is_found()) led.push_back(p);
      }
      if (!led.empty()) points[outward_[k]] = mean_of(led);
    }
    return points;
  }

 private:
  [[nodiscard]] const Vec3& normal(const SurfacePoint& p) const { return normals_[p.triangle]; }
  [[nodiscard]] Vec3 position(const SurfacePoint& p) const {
    const Triangle& t = surface_.mesh().triangles[p.triangle];
    const auto corner = [&](std::size_t k) { return surface_.mesh().positions[t[k]]; };
    return (1.0 - p.b1 - p.b2) * corner(0) + p.b1 * corner(1) + p.b2 * corner(2);
  }
  /// Tilted from one plane into another, the shortest way.
  [[nodiscard]] static Vec3 tilted(const Vec3& v, const Vec3& from, const Vec3& to) {
    const Vec3 axis = from.cross(to), across = axis.cross(v);
    const Vec3 turned = v + across + axis.cross(across) / std::max(1e-3, 1.0 + from.dot(to));
    const Vec3 inside = turned - to * to.dot(turned);
    return inside.norm() > 0.0 ? Vec3(inside.normalized()) : inside;
  }
  [[nodiscard]] WindowPoint stepped(const WindowPoint& from, double x_mm, double y_mm) const {
    const Vec3 step = x_mm * from.x_axis + y_mm * from.x_axis.cross(normal(from.at));
    const SurfacePoint to = surface_.walk(from.at, step);
    if (to.triangle < 0) return {};
    return {to, tilted(from.x_axis, normal(from.at), normal(to))};
  }
  [[nodiscard]] WindowPoint mean_of(const std::vector<WindowPoint>& led) const {
    Vec3 sum = Vec3::Zero(), axis = Vec3::Zero();
    for (const WindowPoint& p : led) sum += position(p.at);
    const WindowPoint& first = led.front();
    const Vec3 off = sum / static_cast<double>(led.size()) - position(first.at), n = normal(first.at);
    const SurfacePoint at = surface_.walk(first.at, off - n * n.dot(off));
    if (at.triangle < 0) return first;
    for (const WindowPoint& p : led) axis += tilted(p.x_axis, normal(p.at), normal(at));
    return axis.norm() > 0.0 ? WindowPoint{at, axis.normalized()} : first;
  }

  const TexelMap& surface_;
  std::vector<Vec3> normals_;
  std::vector<int> outward_;  ///< The window's points, the middle first.
};

/// Control of a window, in every eighth row and column.
struct WindowControl {
  double sum = 0.0;
  std::int64_t count = 0;
  ControlCounts counts = {};

  void add(float value) {
    sum += static_cast<double>(value);
    ++count;
    ++counts[control_bin(value)];
  }
  [[nodiscard]] double mean(double without) const { return count > 0 ? sum / static_cast<double>(count) : without; }
};

/// @param lightness  L* of the part's rectangle. @param wanted  Is given the part's control, if that has one.
Ground cut_made(const MapPart& part, const WindowLayer& layer, const ImageF& lightness, const DrawnWindow& drawn,
                WindowControl& wanted) {
  Ground out{ImageF(kWindowSide, kWindowSide), ImageU8(kWindowSide, kWindowSide), {}, 0, 0};
  const SurfacePoint middle = part.surface.point(drawn.middle);
  const Vec3 x_axis = part.frames[middle.triangle] * Vec2(std::cos(drawn.turn), std::sin(drawn.turn));
  const std::vector<WindowPoint> points = layer.lay({middle, x_axis}, part.surface.median_texel_size_mm());
  for (int y = 0; y < kWindowSide; ++y) {
    for (int x = 0; x < kWindowSide; ++x) {
      const SurfacePoint& p = points[y * kWindowSide + x].at;
      const std::optional<float> value = value_at(part, lightness, p);
      if (!value) continue;
      out.lightness.at(x, y) = *value;
      out.mask.at(x, y) = 255;
      if (part.control.empty() || x % kControlStep != 0 || y % kControlStep != 0) continue;
      wanted.add(value_at(part, part.control, p).value_or(0.0f));
    }
  }
  return out;
}

/// A window of the source: its middle in pixels, and its axes, one texel long.
struct CutPlace {
  Vec2 middle;
  Eigen::Matrix2d axes;
  [[nodiscard]] Vec2 at(int x, int y) const { return middle + axes * Vec2(x - kHalf, y - kHalf); }
};

CutPlace random_cut(const WindowSource& source, RandomStream& random) {
  const double reach = std::numbers::sqrt2 * kHalf * source.pixels_per_texel;
  const auto along = [&](int size) {
    const double room = size - 1.0 - 2.0 * reach;
    return room > 0.0 ? reach + room * random.uniform() : 0.5 * (size - 1.0);
  };
  const double x = along(source.lightness.width()), y = along(source.lightness.height());
  return {{x, y}, Eigen::Rotation2Dd(random_turn(random)).toRotationMatrix() * source.pixels_per_texel};
}

WindowControl control_of(const WindowSource& source, const CutPlace& cut) {
  WindowControl out;
  for (int y = 0; y < kWindowSide; y += kControlStep) {
    for (int x = 0; x < kWindowSide; x += kControlStep) {
      const Vec2 p = cut.at(x, y);
      const int px = static_cast<int>(std::lround(p.x())), py = static_cast<int>(std::lround(p.y()));
      if (!source.control.contains(px, py) || !is_inside(source.mask, px, py)) continue;
      out.add(source.control.at(px, py));
    }
  }
  return out;
}

/// @param control  Is given the source's control there, if that has one.
Ground cut_source(const WindowSource& source, const ImageU8& shape, double wanted, WindowControl& control,
                  RandomStream& random) {
  CutPlace best = random_cut(source, random);
  if (!source.control.empty()) {
    const auto off = [&](const WindowControl& c) {
      return std::abs(c.mean(std::numeric_limits<double>::infinity()) - wanted);
    };
    control = control_of(source, best);
    for (int k = 1; k < kNumCandidates; ++k) {
      const CutPlace cut = random_cut(source, random);
      const WindowControl there = control_of(source, cut);
      if (off(there) < off(control)) best = cut, control = there;
    }
  }
  Ground out{ImageF(kWindowSide, kWindowSide), shape, {}, 0, 0};
  for (int y = 0; y < kWindowSide; ++y) {
    for (int x = 0; x < kWindowSide; ++x) {
      const Vec2 p = best.at(x, y);
      const int x0 = static_cast<int>(std::floor(p.x())), y0 = static_cast<int>(std::floor(p.y()));
      double sum = 0.0;
      bool is_whole = true;
      for (int k = 0; k < 4; ++k) {
        const int px = x0 + k % 2, py = y0 + k / 2;
        if (!source.lightness.contains(px, py) || !is_inside(source.mask, px, py)) {
          is_whole = false;
          break;
        }
        sum += (1.0 - std::abs(p.x() - px)) * (1.0 - std::abs(p.y() - py)) *
               static_cast<double>(source.lightness.at(px, py));
      }
      out.lightness.at(x, y) = is_whole ? static_cast<float>(sum) : 0.0f;
      if (!is_whole) out.mask.at(x, y) = 0;
    }
  }
  return out;
}

}  // namespace

std::size_t control_bin(float value) {
  constexpr int kBins = static_cast<int>(ControlCounts{}.size());
  const auto bin = static_cast<int>(std::floor(value * static_cast<float>(kBins)));
  return static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1));
}

SurfaceWindows cut_windows(const MapPart& part, const ImageF& lightness, const WindowSource& source,
                           const PartCounts& before, const PartCounts& all, const RunControl& control) {
  const std::vector<DrawnWindow> drawn = draw_windows(part, before, all);
  SurfaceWindows windows;
  windows.made.resize(drawn.size());
  windows.source.resize(drawn.size());
  std::vector<WindowControl> made(drawn.size()), cut(drawn.size());
  const WindowLayer layer(part.surface);
  parallel_for(static_cast<std::int64_t>(drawn.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      windows.made[i] = cut_made(part, layer, lightness, drawn[i], made[i]);
      RandomStream random(kSeed, static_cast<std::uint64_t>(drawn[i].middle), kCutPurpose);
      windows.source[i] = cut_source(source, windows.made[i].mask, made[i].mean(0.0), cut[i], random);
    }
  });
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    for (std::size_t b = 0; b < windows.made_control.size(); ++b) {
      windows.made_control[b] += made[i].counts[b];
      windows.source_control[b] += cut[i].counts[b];
    }
  }
  return windows;
}

}  // namespace patinate::analysis
