#include "patinate/controls/wood_grain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/controls/noise.h"

namespace patinate {

namespace {

// Purposes of random streams.
constexpr std::uint32_t kPith = 51, kYear = 52, kKnot = 53;

constexpr double kFarthestPith = 2.2;    ///< In half widths of a board, along both sides of a square.
constexpr double kMaxTilt = 0.0175;      ///< Tangent of 1 degree.
constexpr double kRise = 0.25;           ///< Share of a ring that is its light wood.
constexpr double kFall = 0.08;           ///< Share of a ring over which it falls to the next.
constexpr double kMinLate = 0.5;         ///< Share of the darkest ring's late wood that the palest has.
constexpr double kFiberShare = 0.2;      ///< Share of the pattern.
constexpr double kKnotDark = 0.35;       ///< By which the middle of a knot is darker.
constexpr double kTipSpeed = 3.0;        ///< Speed of a branch, over the speed at which the trunk gets thicker.
constexpr double kBranchRises = 0.25;    ///< Tangent.
constexpr double kDeadSpeed = 0.15;      ///< At which a dead branch still counts, so that nothing ends at once.
constexpr double kKnotFlow = 0.3;        ///< Rings flow around a knot over this share of the years.
constexpr double kNoiseDeviation = 0.2;  ///< Deviation of noise_at().

double step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Continuous and without a kink where both are within `width`.
double smooth_min(double a, double b, double width) {
  const double near = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - 0.25 * near * near * width;
}

/// A place in the tree: across from the pith, and along it.
struct TreePlace {
  Vec2 across = Vec2::Zero();
  double along = 0.0;
};

TreePlace place_in_tree(const Vec3& position, const Board& board, const WoodGrainOptions& options) {
  RandomStream random(static_cast<std::uint64_t>(options.seed), static_cast<std::uint64_t>(board.number), kPith);
  const auto symmetric = [&](double most) { return (2.0 * random.uniform() - 1.0) * most; };
  const Vec2 pith(symmetric(kFarthestPith * board.half_width_mm), symmetric(kFarthestPith * board.half_width_mm));
  const Vec2 tilt(symmetric(kMaxTilt), symmetric(kMaxTilt));
  const Vec3& axis = board.along;
  const Vec3 other = std::abs(axis.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 side = axis.cross(other).normalized(), third = axis.cross(side);
  const Vec3 rel = position - board.middle_mm;
  TreePlace place;
  place.along = rel.dot(axis);
  place.across = Vec2(rel.dot(side), rel.dot(third)) - pith - place.along * tilt;
  return place;
}

/// Years of a place's wood, and by how much it is a branch's, [0, 1].
struct Grown {
  double years = 0.0;
  double knot = 0.0;
};

Grown grown(const TreePlace& at, double trunk_years, const Board& board, const WoodGrainOptions& options) {
  Grown result{.years = trunk_years};
  if (!(options.knots_per_meter > 0.0)) return result;
  const double spacing = 1000.0 / options.knots_per_meter;
  const double cell = std::floor(at.along / spacing);
  for (int k = -1; k <= 1; ++k) {
    const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + k);
    RandomStream random(static_cast<std::uint64_t>(options.seed) + 0x9E3779B97F4A7C15u * number,
                        static_cast<std::uint64_t>(board.number), kKnot);
    const double root = (cell + k + random.uniform()) * spacing;
    Vec2 direction(2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0);
    direction = direction.norm() > 1e-3 ? Vec2(direction.normalized()) : Vec2(1, 0);
    const double thickening = 0.15 + 0.25 * random.uniform();
    const double length = (0.5 + 3.5 * random.uniform()) * board.half_width_mm;
    const double out = at.across.dot(direction);
    if (!(out > 0.0)) continue;
    const double side = at.across.x() * direction.y() - at.across.y() * direction.x();
    const double up = at.along - root - kBranchRises * out;
    const double away = std::sqrt(side * side + up * up);
    const double years = away / (options.ring_mm * thickening) + out / (options.ring_mm * kTipSpeed) +
                         std::max(0.0, out - length) / (options.ring_mm * kDeadSpeed);
    result.knot =
        std::max(result.knot, std::clamp((trunk_years - years) / (0.3 * std::max(0.0, trunk_years) + 0.1), 0.0, 1.0));
    result.years = smooth_min(result.years, years, 1.0 + kKnotFlow * std::max(0.0, trunk_years));
  }
  return result;
}

/// Value of a ring, or its mean where texels are too coarse for it.
double ring_value(double years, const Board& board, const WoodGrainOptions& options, double least_mm) {
  const double year = std::floor(years), share = years - year;
  RandomStream random(
      static_cast<std::uint64_t>(options.seed),
      static_cast<std::uint64_t>(board.number) * 0x10001u + static_cast<std::uint64_t>(static_cast<std::int64_t>(year)),
      kYear);
  const double late = kMinLate + (1.0 - kMinLate) * random.uniform();
  const double fall = std::clamp(0.5 * least_mm / options.ring_mm, kFall, 0.5);
  const double value = late * std::min(step(kRise, 1.0 - fall, share), (1.0 - share) / fall);
  const double mean = 0.5 * (1.0 + kMinLate) * (0.5 * (1.0 - fall - kRise) + 0.5 * fall);
  const double seen = least_mm > 0.0 ? std::clamp(options.ring_mm / least_mm - 1.0, 0.0, 1.0) : 1.0;
  return mean + seen * (value - mean);
}

}  // namespace

void describe(OptionVisitor& v, WoodGrainOptions& o) {
  v.visit({"wood_grain_ring", "width of a year's ring of `wood_grain`", "mm", between(1e-3, 1e9)}, o.ring_mm);
  v.visit(
      {"wood_grain_stretch", "how much longer along the trunk than across it `wood_grain` varies", "", between(1, 1e4)},
      o.stretch);
  v.visit({"wood_grain_waviness", "how far rings stray, in rings", "", between(0, 10)}, o.waviness);
  v.visit({"wood_grain_knots_per_meter", "knots in a meter of a trunk", "", between(0, 100)}, o.knots_per_meter);
  v.visit({"wood_grain_seed", "another seed is another tree", "", between(0, 9e15)}, o.seed);
}

double wood_grain_at(const Vec3& position_mm, const Board& board, const WoodGrainOptions& options, double least_mm) {
  const TreePlace at = place_in_tree(position_mm, board, options);
  const auto noise = [&](double wavelength, double stretch, int octaves, std::int64_t seed) {
    const NoiseOptions wanted{.wavelength_mm = wavelength, .octaves = octaves, .seed = seed};
    return noise_at({at.across.x(), at.across.y(), at.along / stretch}, wanted, least_mm) - 0.5;
  };
  const std::int64_t seed = options.seed % 1000000007 * 4096 + board.number * 2;
  const double stray = options.waviness * noise(8.0 * options.ring_mm, options.stretch, 3, seed) / kNoiseDeviation;
  const Grown tree = grown(at, at.across.norm() / options.ring_mm + stray, board, options);
  const double ring = ring_value(tree.years, board, options, least_mm);
  const double fiber = noise(0.4 * options.ring_mm, 2.0 * options.stretch, 2, seed + 1) / (4.0 * kNoiseDeviation);
  return std::clamp((1.0 - kFiberShare) * ring + kFiberShare * (0.5 + fiber) + kKnotDark * tree.knot, 0.0, 1.0);
}

}  // namespace patinate
