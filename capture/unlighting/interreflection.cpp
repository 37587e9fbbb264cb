#include "capture/unlighting/interreflection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/unlighting/cast_shadows.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/nearest_points.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kRaysAcross = 16;             ///< Strata of the hemisphere, along either side.
constexpr double kMaxGathers = 16'000.0;    ///< Texels that rays start from; the light between them is smooth.
constexpr double kMaxSources = 400'000.0;   ///< Texels that rays may end at.
constexpr int kReach = 2;                   ///< Steps of the grid that a texel is interpolated over, each way.
constexpr double kSameSurfaceCosine = 0.8;  ///< Between normals of what counts as one surface.
constexpr std::uint32_t kPurpose = 0x17e4;

std::int64_t count_surface(const UnlightWork& work) {
  std::int64_t count = 0;
  for (int y = 0; y < work.height; ++y) {
    for (int x = 0; x < work.width; ++x) count += work.is_surface(x, y) ? 1 : 0;
  }
  return count;
}

/// So that at most about `most` of the surface's texels are left.
int step_for(std::int64_t num_surface, double most) {
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(num_surface) / most))));
}

Vec3 median_albedo(const UnlightResult& fitted) {
  const int channels = fitted.albedo.channels();
  Vec3 albedo = Vec3::Zero();
  for (int c = 0; c < channels; ++c) {
    std::vector<float> values;
    for (std::int64_t i = 0; i < fitted.mask.num_pixels(); ++i) {
      if (fitted.mask.data()[i] != 0) values.push_back(fitted.albedo.data()[i * channels + c]);
    }
    if (!values.empty()) albedo[c] = static_cast<double>(median(std::move(values)));
  }
  return albedo;
}

/// A texel where rays may end.
struct Source {
  int x = 0;
  int y = 0;
  double reach_mm = 0.0;  ///< A ray that ends farther away does not end at it.
};

/// The light that leaves every place of the surface.
class Surface {
 public:
  Surface(const UnlightWork& work, const UnlightResult& fitted)
      : work_(work),
        fitted_(fitted),
        scene_(*work.input.blockers),
        offset_(work.options.shadow_offset_mm.value_or(median_edge(*work.input.blockers))),
        beyond_(4.0 * bounding_box(*work.input.blockers).diagonal()),
        albedo_(median_albedo(fitted)),
        step_(step_for(count_surface(work), kMaxSources)),
        sources_(find_sources()),
        nearest_(points()) {}

  enum class Met { Nothing, Seen, Unseen };
  /// Adds what comes along one ray to `sum` (L C).
  Met add_ray(const Vec3& from, const Vec3& direction, std::vector<double>& sum) const {
    const auto hit = scene_.first_hit(from, direction);
    if (!hit) return Met::Nothing;
    const Vec3 place = from + hit->distance * direction;
    const auto near = nearest_.nearest_below(place, largest_reach_);
    if (near.index >= 0) {
      const Source& source = sources_[near.index];
      if (near.squared_distance <= source.reach_mm * source.reach_mm &&
          vector_of(work_.normal, source.x, source.y).dot(direction) < 0.0) {
        add_seen(source.x, source.y, sum);
        return Met::Seen;
      }
    }
    add_unseen(place, facing(hit->triangle, direction), sum);
    return Met::Unseen;
  }

  [[nodiscard]] double offset() const { return offset_; }

 private:
  /// Distance to the nearer one of two neighbors; 0 where both are no surface.
  [[nodiscard]] double spacing(int x, int y, int dx, int dy) const {
    double least = 0.0;
    for (const int sign : {-1, 1}) {
      const int nx = x + sign * dx, ny = y + sign * dy;
      if (nx < 0 || ny < 0 || nx >= work_.width || ny >= work_.height || !work_.is_surface(nx, ny)) continue;
      const double distance = (work_.position(nx, ny) - work_.position(x, y)).norm();
      if (least == 0.0 || distance < least) least = distance;
    }
    return least;
  }

  [[nodiscard]] std::vector<Source> find_sources() {
    std::vector<Source> sources;
    std::vector<double> spacings;
    for (int y = step_ / 2; y < work_.height; y += step_) {
      for (int x = step_ / 2; x < work_.width; x += step_) {
        if (!work_.is_surface(x, y)) continue;
        const double across = spacing(x, y, step_, 0), down = spacing(x, y, 0, step_);
        sources.push_back({x, y, across > 0.0 && down > 0.0 ? std::hypot(across, down) : 0.0});
        if (sources.back().reach_mm > 0.0) spacings.push_back(sources.back().reach_mm);
      }
    }
    if (sources.empty()) throw InvalidInput("interreflection: the mask leaves no surface");
    const double usual = spacings.empty() ? offset_ : median(std::move(spacings));
    constexpr double kSteepest = 8.0;  // Beyond it neighbors are on both sides of an edge.
    for (Source& s : sources) {
      s.reach_mm = (s.reach_mm > 0.0 ? std::min(s.reach_mm, kSteepest * usual) : usual) + offset_;
      largest_reach_ = std::max(largest_reach_, s.reach_mm);
    }
    return sources;
  }

  [[nodiscard]] std::vector<Vec3> points() const {
    std::vector<Vec3> points;
    for (const Source& s : sources_) points.push_back(work_.position(s.x, s.y));
    return points;
  }

  [[nodiscard]] Vec3 facing(int triangle, const Vec3& direction) const {
    const Mesh& mesh = *work_.input.blockers;
    const Triangle& t = mesh.triangles[triangle];
    const auto corner = [&](std::size_t i) { return mesh.positions[t[i]]; };
    const Vec3 n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    return n.dot(direction) > 0.0 ? Vec3(-n) : n;
  }

  /// Irradiance over pi of a surface facing the lamp.
  [[nodiscard]] Vec3 lamp(std::size_t k, const Vec3& p) const {
    const Vec3 light = light_at(work_.input.lights[k], p).cwiseProduct(work_.strengths[k]) / std::numbers::pi;
    return work_.num_channels == 1 ? Vec3::Constant(light.mean()) : light;
  }

  void add_seen(int x, int y, std::vector<double>& sum) const {
    const bool is_determined = fitted_.mask.at(x, y) != 0;
    const Vec3 p = work_.position(x, y), n = vector_of(fitted_.normal, x, y);
    for (std::size_t k = 0; k < work_.input.lights.size(); ++k) {
      const auto state = static_cast<SampleState>(fitted_.samples.at(x, y, static_cast<int>(k)));
      const bool is_photographed = work_.input.valid.empty() || work_.input.valid[k].at(x, y) != 0;
      const bool is_lit = state != SampleState::Unlit && state != SampleState::CastShadow;
      const double cosine = is_lit ? std::max(0.0, n.dot(direction_to(work_.input.lights[k], p))) : 0.0;
      const Vec3 light = lamp(k, p) * cosine;
      for (int c = 0; c < work_.num_channels; ++c) {
        const double albedo = is_determined ? static_cast<double>(fitted_.albedo.at(x, y, c)) : albedo_[c];
        double& total = sum[k * static_cast<std::size_t>(work_.num_channels) + static_cast<std::size_t>(c)];
        if (is_photographed && state != SampleState::Brighter)
          total +=
              static_cast<double>(work_.input.photos[k].at(x, y, c)) - albedo * work_.ambient[c] / std::numbers::pi;
        else
          total += albedo * light[c];
      }
    }
  }

  void add_unseen(const Vec3& place, const Vec3& n, std::vector<double>& sum) const {
    const Vec3 from = place + offset_ * n;
    for (std::size_t k = 0; k < work_.input.lights.size(); ++k) {
      const Light& light = work_.input.lights[k];
      const double cosine = n.dot(direction_to(light, place));
      if (!(cosine > 0.0)) continue;
      const Vec3 to = light.kind == Light::Kind::Near ? light.position : Vec3(from + beyond_ * light.direction);
      if (scene_.is_blocked(from, to, offset_)) continue;
      const Vec3 value = albedo_.cwiseProduct(lamp(k, place)) * cosine;
      for (int c = 0; c < work_.num_channels; ++c)
        sum[k * static_cast<std::size_t>(work_.num_channels) + static_cast<std::size_t>(c)] += value[c];
    }
  }

  const UnlightWork& work_;
  const UnlightResult& fitted_;
  RayScene scene_;
  double offset_;
  double beyond_;
  Vec3 albedo_;
  int step_;
  double largest_reach_ = 0.0;
  std::vector<Source> sources_;
  NearestPoints nearest_;
};

struct RayCount {
  std::int64_t seen = 0;
  std::int64_t unseen = 0;
};

/// The light from the hemisphere over one texel, cosine-weighted rays of equal weight.
RayCount gather_texel(const UnlightWork& work, const Surface& surface, int x, int y, std::vector<double>& sum,
                      ImageF& out) {
  RayCount count;
  std::fill(sum.begin(), sum.end(), 0.0);
  const Vec3 n = vector_of(work.normal, x, y);
  if (!(n.squaredNorm() > 0.5)) return count;
  const Vec3 from = work.position(x, y) + surface.offset() * n,
             t = n.cross(std::abs(n.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).normalized(), b = n.cross(t);
  RandomStream random(
      0, static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(work.width) + static_cast<std::uint64_t>(x),
      kPurpose);
  for (int i = 0; i < kRaysAcross; ++i) {
    for (int j = 0; j < kRaysAcross; ++j) {
      const double u = (i + random.uniform()) / kRaysAcross, v = (j + random.uniform()) / kRaysAcross,
                   radius = std::sqrt(u), angle = 2.0 * std::numbers::pi * v;
      const Vec3 direction = radius * std::cos(angle) * t + radius * std::sin(angle) * b + std::sqrt(1.0 - u) * n;
      const Surface::Met met = surface.add_ray(from, direction.normalized(), sum);
      count.seen += met == Surface::Met::Seen ? 1 : 0;
      count.unseen += met == Surface::Met::Unseen ? 1 : 0;
    }
  }
  for (int i = 0; i < out.channels(); ++i) {
    const double mean = sum[i] / (kRaysAcross * kRaysAcross);
    out.at(x, y, i) = static_cast<float>(std::max(0.0, mean));
  }
  return count;
}

/// Means over the grid's texels near, of the same surface. @returns false where there are none.
bool interpolate(const UnlightWork& work, const ImageF& gathered, int step, int x, int y, ImageF& out) {
  const Vec3 n = vector_of(work.normal, x, y), p = work.position(x, y);
  const int gx = x / step, gy = y / step;
  double total = 0.0;
  std::vector<double> sum(static_cast<std::size_t>(out.channels()), 0.0);
  for (int j = gy - kReach; j <= gy + kReach; ++j) {
    for (int i = gx - kReach; i <= gx + kReach; ++i) {
      const int sx = i * step + step / 2, sy = j * step + step / 2;
      if (sx < 0 || sy < 0 || sx >= work.width || sy >= work.height || !work.is_surface(sx, sy)) continue;
      const double across = std::abs(sx - x) / (static_cast<double>(kReach) * step),
                   down = std::abs(sy - y) / (static_cast<double>(kReach) * step);
      const Vec3 away = work.position(sx, sy) - p;
      const double cosine = n.dot(vector_of(work.normal, sx, sy));
      const bool is_across_an_edge = std::abs(n.dot(away)) > 0.5 * away.norm();
      if (across >= 1.0 || down >= 1.0 || cosine <= kSameSurfaceCosine || is_across_an_edge) continue;
      const double w = (1.0 - across) * (1.0 - down) * (cosine - kSameSurfaceCosine);
      total += w;
      for (int c = 0; c < out.channels(); ++c) sum[c] += w * static_cast<double>(gathered.at(sx, sy, c));
    }
  }
  if (!(total > 0.0)) return false;
  for (int c = 0; c < out.channels(); ++c) out.at(x, y, c) = static_cast<float>(sum[c] / total);
  return true;
}

}  // namespace

Interreflection gather_interreflection(const UnlightWork& work, const UnlightResult& fitted,
                                       const RunControl& control) {
  if (work.input.blockers == nullptr || work.input.blockers->triangles.empty())
    throw InvalidInput(
        "--interreflection needs a scan: the light that a surface throws onto itself follows from its shape");
  const Surface surface(work, fitted);
  const int step = step_for(count_surface(work), kMaxGathers), rows = (work.height + step - 1) / step;
  const int channels = work.num_lights * work.num_channels;
  ImageF gathered(work.width, work.height, channels);
  const auto gather_rows = [&](std::int64_t begin, std::int64_t end) {
    RayCount count;
    std::vector<double> sum(static_cast<std::size_t>(channels));
    for (std::int64_t row = begin; row < end; ++row) {
      const int y = static_cast<int>(row) * step + step / 2;
      for (int x = step / 2; x < work.width && y < work.height; x += step) {
        if (!work.is_surface(x, y)) continue;
        const RayCount texel = gather_texel(work, surface, x, y, sum, gathered);
        count.seen += texel.seen, count.unseen += texel.unseen;
      }
    }
    return count;
  };
  const RayCount count = parallel_reduce(std::int64_t{rows}, 1, control.part(0.0, 0.8), RayCount{}, gather_rows,
                                         [](RayCount a, const RayCount& b) {
                                           return RayCount{a.seen + b.seen, a.unseen + b.unseen};
                                         });
  Interreflection result{.irradiance = ImageF(work.width, work.height, channels)};
  parallel_for(work.height, 1, control.part(0.8, 1.0), [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> sum(static_cast<std::size_t>(channels));
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < work.width; ++x) {
        if (work.is_surface(x, y) && !interpolate(work, gathered, step, x, y, result.irradiance))
          gather_texel(work, surface, x, y, sum, result.irradiance);
      }
    }
  });
  const std::int64_t met = count.seen + count.unseen;
  result.unseen_share = met > 0 ? static_cast<double>(count.unseen) / static_cast<double>(met) : 0.0;
  return result;
}

InterreflectionReport interreflection_shares(const UnlightWork& work, const UnlightResult& result) {
  // Texels that the gathered share is reported from, evenly picked.
  constexpr std::int64_t kMaxTexels = 20'000;
  std::vector<double> shares;
  for (const std::int64_t at : work.spread_texels(kMaxTexels)) {
    const int x = static_cast<int>(at % work.width), y = static_cast<int>(at / work.width);
    if (result.mask.at(x, y) == 0) continue;
    double indirect = 0.0, value = 0.0;
    for (int k = 0; k < work.num_lights; ++k) {
      if (result.samples.at(x, y, k) != static_cast<std::uint8_t>(SampleState::Clean)) continue;
      for (int c = 0; c < work.num_channels; ++c) {
        indirect += static_cast<double>(result.albedo.at(x, y, c)) *
                    static_cast<double>(work.indirect.at(x, y, k * work.num_channels + c));
        value += static_cast<double>(work.input.photos[k].at(x, y, c));
      }
    }
    if (value > 0.0) shares.push_back(indirect / value);
  }
  if (shares.empty()) return {};
  constexpr double kRank = 0.95;  // Percentile that is reported.
  const auto rank = static_cast<std::size_t>(kRank * static_cast<double>(shares.size() - 1));
  InterreflectionReport report{.p95 = value_at_rank(shares, rank)};
  report.median = median(std::move(shares));
  return report;
}

}  // namespace patinate::capture
