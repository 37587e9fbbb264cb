#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/panel_marks.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kScribeStream = 1510, kCreepStream = 1511, kCrackStream = 1516;  // Of random streams.
constexpr std::int64_t kScribeRows = 16;
constexpr double kScribeWidthMm = 0.5;   ///< As of common scribing tools [ISO 17872: 0.2 to 1 mm].
constexpr double kScribeLength = 0.6;    ///< Of the test area's height.
constexpr double kProfileStepMm = 0.05;  ///< Between values of the profile of creep.
constexpr double kTaperMm = 1.5;         ///< Within which creep grows from nothing at the ends.
constexpr double kCrackStepMm = 0.2;
constexpr double kCrackMm = 9.0;  ///< Mean length of a crack.

/// Uneven creep along a side, whose mean is `mean_mm`.
std::vector<double> creep_profile(const PanelOptions& o, double length_mm, std::uint32_t side) {
  const auto seed = static_cast<std::uint64_t>(o.seed);
  const SmoothNoise broad(seed, kCreepStream + 2 * side, length_mm, 1.0, 3.5, 1.0);
  const SmoothNoise fine(seed, kCreepStream + 2 * side + 1, length_mm, 1.0, 0.8, 1.0);
  const int count = static_cast<int>(length_mm / kProfileStepMm) + 1;
  std::vector<double> profile;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const double s = i * kProfileStepMm;
    const double taper = smooth_step(0.0, kTaperMm, std::min(s, length_mm - s));
    profile.push_back(taper * std::max(0.0, 1.0 + 1.3 * broad(s, 0.5) + 0.5 * fine(s, 0.5)));
    sum += profile.back();
  }
  for (double& value : profile) value *= sum > 0.0 ? o.creep_mm * count / sum : 0.0;
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
    const std::array<double, 2> a = crack.points_mm[i], b = crack.points_mm[i + 1];
    const double f = std::min(1.0, steps - static_cast<double>(i));
    use(a, std::array<double, 2>{a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])});
  }
}

/// A walk from a place in the test area, by steps of one length, until it leaves the panel or is long enough.
PanelCrack walk_crack(const PanelOptions& o, std::uint64_t item) {
  RandomStream random(static_cast<std::uint64_t>(o.seed), item, kCrackStream);
  PanelCrack crack;
  std::array<double, 2> place{o.edge_mm + random.uniform() * (o.width_mm() - 2.0 * o.edge_mm),
                              o.edge_mm + random.uniform() * (o.height_mm() - 2.0 * o.edge_mm)};
  double angle = 2.0 * std::numbers::pi * random.uniform(), bend = 0.0;
  const double length = kCrackMm * (0.4 + 1.2 * random.uniform());
  crack.width_mm = std::exp(0.25 * random.normal());
  crack.start_h = o.hours * (0.05 + 0.6 * random.uniform());
  crack.points_mm.push_back(place);
  while (crack.length_mm < length) {
    bend = 0.8 * bend + 0.12 * random.normal();
    angle += bend;
    place = {place[0] + kCrackStepMm * std::cos(angle), place[1] + kCrackStepMm * std::sin(angle)};
    if (place[0] < 0.0 || place[1] < 0.0 || place[0] > o.width_mm() || place[1] > o.height_mm()) break;
    crack.points_mm.push_back(place);
    crack.length_mm += kCrackStepMm;
  }
  return crack;
}

/// Shortens a crack by what lies beyond `most_mm` in the test area; returns what is left there.
double cut_crack(PanelCrack& crack, const PanelOptions& o, double most_mm) {
  double inside = 0.0;
  for (std::size_t i = 0; i + 1 < crack.points_mm.size(); ++i) {
    std::array<double, 2>&a = crack.points_mm[i], &b = crack.points_mm[i + 1];
    if (!in_test_area(o, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))) continue;
    inside += kCrackStepMm;
    if (inside < most_mm) continue;
    const double f = 1.0 - (inside - most_mm) / kCrackStepMm;
    b = {a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])};
    crack.points_mm.resize(i + 2);
    crack.length_mm = (static_cast<double>(i) + f) * kCrackStepMm;
    return most_mm;
  }
  return inside;
}

}  // namespace

bool in_test_area(const PanelOptions& o, double x_mm, double y_mm) {
  return std::min({x_mm, y_mm, o.width_mm() - x_mm, o.height_mm() - y_mm}) >= o.edge_mm;
}

double largest_creep(const PanelScribe& scribe) {
  return std::max(*std::max_element(scribe.left_mm.begin(), scribe.left_mm.end()),
                  *std::max_element(scribe.right_mm.begin(), scribe.right_mm.end()));
}

PanelScribe make_scribe(const PanelOptions& o) {
  RandomStream random(static_cast<std::uint64_t>(o.seed), 0, kScribeStream);
  const double tilt = (2.0 * random.uniform() - 1.0) * 3.0 * std::numbers::pi / 180.0;
  const double length = kScribeLength * (o.height_mm() - 2.0 * o.edge_mm);
  const double dx = 0.5 * length * std::sin(tilt), dy = 0.5 * length * std::cos(tilt);
  const double x = 0.5 * o.width_mm(), y = 0.5 * o.height_mm();
  return {.from_mm = {x - dx, y - dy},
          .to_mm = {x + dx, y + dy},
          .width_mm = kScribeWidthMm,
          .step_mm = kProfileStepMm,
          .left_mm = creep_profile(o, length, 0),
          .right_mm = creep_profile(o, length, 1)};
}

Marks draw_scribe(const PanelScribe& scribe, const PanelOptions& o, double hours, const RunControl& control) {
  const double grown = mark_growth(hours, 0.0, o.hours), mm = o.pixel_mm;
  const double length = std::hypot(scribe.to_mm[0] - scribe.from_mm[0], scribe.to_mm[1] - scribe.from_mm[1]);
  const double along_x = (scribe.to_mm[0] - scribe.from_mm[0]) / length;
  const double along_y = (scribe.to_mm[1] - scribe.from_mm[1]) / length;
  const double steep = grown * std::max(steepest(scribe.left_mm), steepest(scribe.right_mm)) / scribe.step_mm;
  // The two sides differ along the middle; that the value is 0 there lets it change by no jump.
  const auto depth = [&](double x_px, double y_px) {
    const double x = mm * x_px - scribe.from_mm[0], y = mm * y_px - scribe.from_mm[1];
    const double s = x * along_x + y * along_y, n = x * along_y - y * along_x;
    const std::vector<double>& profile = n < 0.0 ? scribe.left_mm : scribe.right_mm;
    const double half = 0.5 * scribe.width_mm + grown * profile_at(profile, s / scribe.step_mm);
    const double inside = std::min({half - std::abs(n), s, length - s});
    return std::pair(std::min(inside, std::abs(n)) / mm, inside / mm);
  };
  Marks marks{.samples = SampleImage(o.width, o.height), .inside_px = ImageF(o.width, o.height, 1, -1.0f)};
  const double slope = std::hypot(1.0, steep), half = 0.5 * scribe.width_mm + grown * largest_creep(scribe);
  const double left = std::min(scribe.from_mm[0], scribe.to_mm[0]),
               right = std::max(scribe.from_mm[0], scribe.to_mm[0]);
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

std::vector<PanelCrack> make_cracks(const PanelOptions& o) {
  const double wanted = o.crack_density * (o.width_mm() - 2.0 * o.edge_mm) * (o.height_mm() - 2.0 * o.edge_mm);
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
    for_pieces(crack, hours, o.hours, [&](const std::array<double, 2>& a, const std::array<double, 2>& b) {
      if (in_test_area(o, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))) sum += std::hypot(b[0] - a[0], b[1] - a[1]);
    });
  }
  return sum;
}

SampleImage draw_cracks(const std::vector<PanelCrack>& cracks, const PanelOptions& o, double hours) {
  SampleImage samples(o.width, o.height);
  for (const PanelCrack& crack : cracks) {
    const double half = 0.5 * crack.width_mm / o.pixel_mm;
    for_pieces(crack, hours, o.hours, [&](const std::array<double, 2>& a, const std::array<double, 2>& b) {
      const double ax = a[0] / o.pixel_mm, ay = a[1] / o.pixel_mm;
      const double dx = b[0] / o.pixel_mm - ax, dy = b[1] / o.pixel_mm - ay, squared = dx * dx + dy * dy;
      const auto depth = [&](double x, double y) {
        const double f = squared > 0.0 ? std::clamp(((x - ax) * dx + (y - ay) * dy) / squared, 0.0, 1.0) : 0.0;
        return half - std::hypot(x - ax - f * dx, y - ay - f * dy);
      };
      const PixelBox box = pixel_box(std::min(ax, ax + dx) - half, std::min(ay, ay + dy) - half,
                                     std::max(ax, ax + dx) + half, std::max(ay, ay + dy) + half, o.width, o.height);
      cover(samples, box, 1.0, depth);
    });
  }
  return samples;
}

}  // namespace patinate::datasets
