#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/panel_marks.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kScribeStream = 1510, kCreepStream = 1511, kCrackStream = 1516;  // Streams of random numbers.
constexpr std::int64_t kScribeRows = 16;
constexpr double kScribeWidthMm = 0.5;  ///< Width of common scribing tools [ISO 17872: 0.2 to 1 mm].
constexpr double kScribeLength = 0.9;   ///< Share of the test area's height.
/// Angle from upright of two scribes that cross; ours: laboratories cut an X by hand.
constexpr double kCrossLean = 40.0 * std::numbers::pi / 180.0;
constexpr double kProfileStepMm = 0.05;  ///< Between values of the profile of creep.
constexpr double kTaperMm = 1.5;         ///< Within which creep grows from nothing at the ends.
constexpr double kMinCreep = 0.02;       ///< In units of the mean.
constexpr double kCrackStepMm = 0.2;
constexpr double kCrackMm = 9.0;  ///< Mean length of a crack.

/// Steps between the values of the profile of creep.
int profile_steps(double length_mm) { return static_cast<int>(std::ceil(length_mm / kProfileStepMm)); }

/// Uneven creep along a side, nothing at both ends, whose mean over the length is creep_mm.
std::vector<double> creep_profile(const PanelOptions& o, double length_mm, std::uint32_t side) {
  const auto seed = static_cast<std::uint64_t>(o.seed);
  const SmoothNoise broad(seed, kCreepStream + 2 * side, length_mm, 1.0, 3.5, 1.0);
  const SmoothNoise fine(seed, kCreepStream + 2 * side + 1, length_mm, 1.0, 0.8, 1.0);
  const int num_steps = profile_steps(length_mm);
  std::vector<double> profile;
  double sum = 0.0;
  for (int i = 0; i <= num_steps; ++i) {
    const double s = length_mm * i / num_steps;
    const double taper = smooth_step(0.0, std::min(kTaperMm, 0.5 * length_mm), std::min(s, length_mm - s));
    profile.push_back(taper * std::max(kMinCreep, 1.0 + 1.6 * broad(s, 0.5) + 0.7 * fine(s, 0.5)));
    sum += profile.back();
  }
  for (double& value : profile) value *= o.creep_mm * num_steps / sum;
  return profile;
}

double profile_at(const std::vector<double>& profile, double place) {
  const double at = std::clamp(place, 0.0, static_cast<double>(profile.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(at), profile.size() - 2);
  const double f = at - static_cast<double>(i);
  return (1.0 - f) * profile[i] + f * profile[i + 1];
}

double steepest(const std::vector<double>& profile) {
  double most = 0.0;
  for (std::size_t i = 1; i < profile.size(); ++i) most = std::max(most, std::abs(profile[i] - profile[i - 1]));
  return most;
}

/// How far a crack's points may be drawn at a time: whole steps, and a share of the next.
double crack_steps(const PanelCrack& crack, double hours, double end_h) {
  return mark_growth(hours, crack.start_h, end_h) * static_cast<double>(crack.points_mm.size() - 1);
}

/// Calls `use(from, to)` with the pieces of a crack that are there at a time, mm.
template <class Use>
void for_pieces(const PanelCrack& crack, double hours, double end_h, const Use& use) {
  const double steps = crack_steps(crack, hours, end_h);
  for (std::size_t i = 0; i + 1 < crack.points_mm.size() && static_cast<double>(i) < steps; ++i) {
    const Vec2 &a = crack.points_mm[i], &b = crack.points_mm[i + 1];
    use(a, Vec2(a + std::min(1.0, steps - static_cast<double>(i)) * (b - a)));
  }
}

/// A walk from a place in the test area, by steps of one length, until it leaves the panel or is long enough.
PanelCrack walk_crack(const PanelOptions& o, std::uint64_t item) {
  RandomStream random(static_cast<std::uint64_t>(o.seed), item, kCrackStream);
  PanelCrack crack;
  const Vec2 size(o.width_mm(), o.height_mm());
  Vec2 place;
  for (int i = 0; i < 2; ++i) place[i] = o.edge_mm + random.uniform() * (size[i] - 2.0 * o.edge_mm);
  const double heading = 2.0 * std::numbers::pi * random.uniform();
  double bend = 0.0;
  const double length = kCrackMm * (0.4 + 1.2 * random.uniform());
  crack.width_mm = std::exp(0.25 * random.normal());
  crack.start_h = o.hours * (0.05 + 0.6 * random.uniform());
  crack.points_mm.push_back(place);
  while (crack.length_mm < length) {
    bend = 0.93 * bend + 0.14 * random.normal();
    place += kCrackStepMm * Vec2(std::cos(heading + bend), std::sin(heading + bend));
    if (place.minCoeff() < 0.0 || (size - place).minCoeff() < 0.0) break;
    crack.points_mm.push_back(place);
    crack.length_mm += kCrackStepMm;
  }
  return crack;
}

/// Shortens a crack by what lies beyond `most_mm` in the test area; returns what is left there.
double cut_crack(PanelCrack& crack, const PanelOptions& o, double most_mm) {
  double inside = 0.0;
  for (std::size_t i = 0; i + 1 < crack.points_mm.size(); ++i) {
    const Vec2& a = crack.points_mm[i];
    Vec2& b = crack.points_mm[i + 1];
    if (!in_test_area(o, 0.5 * (a + b))) continue;
    inside += kCrackStepMm;
    if (inside < most_mm) continue;
    const double f = 1.0 - (inside - most_mm) / kCrackStepMm;
    b = a + f * (b - a);
    crack.points_mm.resize(i + 2);
    crack.length_mm = (static_cast<double>(i) + f) * kCrackStepMm;
    return most_mm;
  }
  return inside;
}

}  // namespace

bool in_test_area(const PanelOptions& o, const Vec2& place_mm) {
  return std::min(place_mm.minCoeff(), (Vec2(o.width_mm(), o.height_mm()) - place_mm).minCoeff()) >= o.edge_mm;
}

double largest_creep(const PanelScribe& scribe) {
  return std::max(*std::max_element(scribe.left_mm.begin(), scribe.left_mm.end()),
                  *std::max_element(scribe.right_mm.begin(), scribe.right_mm.end()));
}

std::vector<PanelScribe> make_scribes(const PanelOptions& o) {
  if (!o.scribe) return {};
  RandomStream random(static_cast<std::uint64_t>(o.seed), 0, kScribeStream);
  const double tilt = (2.0 * random.uniform() - 1.0) * 3.0 * std::numbers::pi / 180.0;
  const double side = o.cross ? std::min(o.width_mm(), o.height_mm()) : o.height_mm();
  const double length = kScribeLength * (side - 2.0 * o.edge_mm);
  const Vec2 middle(0.5 * o.width_mm(), 0.5 * o.height_mm());
  std::vector<PanelScribe> scribes;
  for (const double lean : o.cross ? std::vector{kCrossLean, -kCrossLean} : std::vector{0.0}) {
    const double angle = tilt + lean;
    const Vec2 half = 0.5 * length * Vec2(std::sin(angle), std::cos(angle));
    const auto first_side = static_cast<std::uint32_t>(10 * scribes.size());
    scribes.push_back({.from_mm = middle - half,
                       .to_mm = middle + half,
                       .width_mm = kScribeWidthMm,
                       .step_mm = length / profile_steps(length),
                       .left_mm = creep_profile(o, length, first_side),
                       .right_mm = creep_profile(o, length, first_side + 1)});
  }
  return scribes;
}

namespace {

Marks draw_scribe(const PanelScribe& scribe, const PanelOptions& o, double hours, const RunControl& control) {
  const double grown = mark_growth(hours, 0.0, o.hours), mm = o.pixel_mm;
  const double length = (scribe.to_mm - scribe.from_mm).norm();
  const Vec2 along = (scribe.to_mm - scribe.from_mm) / length;
  const double steep = grown * std::max(steepest(scribe.left_mm), steepest(scribe.right_mm)) / scribe.step_mm;
  // The two sides differ along the middle; that the value is 0 there lets it change by no jump.
  const auto depth = [&](double x_px, double y_px) {
    const Vec2 place = mm * Vec2(x_px, y_px) - scribe.from_mm;
    const double s = place.dot(along), n = place.x() * along.y() - place.y() * along.x();
    const std::vector<double>& profile = n < 0.0 ? scribe.left_mm : scribe.right_mm;
    const double half = 0.5 * scribe.width_mm + grown * profile_at(profile, s / scribe.step_mm);
    const double inside = std::min({half - std::abs(n), s, length - s});
    return std::pair(std::min(inside, std::abs(n)) / mm, inside / mm);
  };
  Marks marks{.samples = SampleImage(o.width, o.height), .inside_px = ImageF(o.width, o.height, 1, -1.0f)};
  const double slope = std::hypot(1.0, steep), half = 0.5 * scribe.width_mm + grown * largest_creep(scribe);
  const double left = std::min(scribe.from_mm.x(), scribe.to_mm.x());
  const double right = std::max(scribe.from_mm.x(), scribe.to_mm.x());
  const PixelBox box = pixel_box((left - half) / mm, 0.0, (right + half) / mm, o.height, o.width, o.height);
  parallel_for(o.height, kScribeRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        const auto [even, inside] = depth(x + 0.5, y + 0.5);
        marks.inside_px.at(x, y) = static_cast<float>(inside);
        marks.samples.at(x, y) =
            samples_inside(x, y, slope, even, [&](double px, double py) { return depth(px, py).first; });
      }
    }
  });
  return marks;
}

}  // namespace

Marks draw_scribes(const std::vector<PanelScribe>& scribes, const PanelOptions& o, double hours,
                   const RunControl& control) {
  Marks marks = draw_scribe(scribes.front(), o, hours, control);
  for (std::size_t k = 1; k < scribes.size(); ++k) {
    const Marks other = draw_scribe(scribes[k], o, hours, control);
    for (std::size_t i = 0; i < marks.samples.values().size(); ++i) {
      marks.samples.values()[i] |= other.samples.values()[i];
      marks.inside_px.data()[i] = std::max(marks.inside_px.data()[i], other.inside_px.data()[i]);
    }
  }
  return marks;
}

std::vector<PanelCrack> make_cracks(const PanelOptions& o) {
  const double wanted = o.crack_density * o.test_area_mm2();
  std::vector<PanelCrack> cracks;
  double inside = 0.0, widths = 0.0;
  for (std::uint64_t i = 0; inside < wanted; ++i) {
    PanelCrack crack = walk_crack(o, i);
    const double length = cut_crack(crack, o, wanted - inside);
    inside += length;
    widths += length * crack.width_mm;
    cracks.push_back(std::move(crack));
  }
  for (PanelCrack& crack : cracks) crack.width_mm *= o.crack_width_mm * inside / widths;
  return cracks;
}

double crack_length(const std::vector<PanelCrack>& cracks, const PanelOptions& o, double hours) {
  double sum = 0.0;
  for (const PanelCrack& crack : cracks) {
    for_pieces(crack, hours, o.hours, [&](const Vec2& a, const Vec2& b) {
      if (in_test_area(o, 0.5 * (a + b))) sum += (b - a).norm();
    });
  }
  return sum;
}

SampleImage draw_cracks(const std::vector<PanelCrack>& cracks, const PanelOptions& o, double hours) {
  SampleImage samples(o.width, o.height);
  for (const PanelCrack& crack : cracks) {
    const double half = 0.5 * crack.width_mm / o.pixel_mm;
    for_pieces(crack, hours, o.hours, [&](const Vec2& a, const Vec2& b) {
      const Vec2 start = a / o.pixel_mm, way = (b - a) / o.pixel_mm;
      const double squared = way.squaredNorm();
      const auto depth = [&](double x, double y) {
        const Vec2 place = Vec2(x, y) - start;
        const double f = squared > 0.0 ? std::clamp(place.dot(way) / squared, 0.0, 1.0) : 0.0;
        return half - (place - f * way).norm();
      };
      const Vec2 low = start.cwiseMin(start + way), high = start.cwiseMax(start + way);
      const PixelBox box =
          pixel_box(low.x() - half, low.y() - half, high.x() + half, high.y() + half, o.width, o.height);
      cover(samples, box, 1.0, depth);
    });
  }
  return samples;
}

}  // namespace patinate::datasets
