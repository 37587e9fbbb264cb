/// \file
/// Which parameters the data determine, and how closely.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace patinate::analysis {

/// A place in the box [0, 1]^n of all parameters, and the objective there.
struct BoxPoint {
  std::vector<double> at;
  double objective = 0.0;
};

enum class Determination {
  Determined,     ///< Both ends of the interval lie inside the range.
  AtLeast,        ///< Only the lower end does.
  AtMost,         ///< Only the upper end does.
  Undetermined,   ///< Neither: every value of the range is as good.
  WithoutEffect,  ///< Neither, and nothing changes at all over the range.
  NotExamined     ///< There is no scan.
};
inline constexpr std::array<std::string_view, 6> kDeterminationNames{"determined",   "at_least",       "at_most",
                                                                     "undetermined", "without_effect", "not_examined"};

struct ParameterVerdict {
  Determination determination = Determination::Undetermined;
  double low = 0.0, high = 1.0;  ///< Values that the figures cannot tell from the best; in [0, 1].
  double effect = 0.0;           ///< By how much the objective changes at most over the range, the others held.
};

/// The shape of the objective near the best, from the least-squares quadratic with Hessian H through the points of
/// least objective, twice as many as it has coefficients.
struct Valley {
  /// [i][j], of H^-1: near +-1, only a combination of two parameters is determined.
  std::vector<std::vector<double>> correlation;
  /// [i][j]: by how much j has to move for each move of i, so that the objective rises least; [i][i] = 1.
  std::vector<std::vector<double>> slopes;
  double explained = 0.0;  ///< Share of the variance that the quadratic explains, per degree of freedom.
};
/// @param problem  Why there is none: the points are too few, or less than half of their variance is explained.
[[nodiscard]] std::optional<Valley> valley_of(const BoxPoint& best, std::span<const BoxPoint> points,
                                              std::string& problem);

/// Points along every parameter, by place, in any order, without the best itself.
using BoxScans = std::vector<std::vector<BoxPoint>>;

/// The interval of a parameter is where the least of what was found at a place, the others held or moved, stays within
/// `threshold` of the best, interpolated between places; and as far as any point that was tried stays within it. So it
/// rests on surfaces that were made, never on a formula that continues beyond them, and is never wider than what was
/// seen; where the others could make up for more than was tried, it is too narrow.
/// @param tried     Whatever was tried. @param scans  Along each parameter, the others as at the best. @param profiles
/// The same with others moved; may be empty.
/// @param threshold >= 0: differences of the objective up to here mean nothing.
/// @throws InvalidInput unless there is one scan and one profile a parameter, and all points have as many coordinates
/// as the best.
[[nodiscard]] std::vector<ParameterVerdict> determine(const BoxPoint& best, std::span<const BoxPoint> tried,
                                                      const BoxScans& scans, const BoxScans& profiles,
                                                      double threshold);

/// Offsets of a scan to each side of the best, as shares of the way to the range's end: 1, 0.3, 0.09, ...; `count` in
/// all, half to each side, the last of an odd number to the wider one. A side that is no way is excluded. @returns
/// places along the parameter, in [0, 1].
[[nodiscard]] std::vector<double> scan_places(double best, int count);

}  // namespace patinate::analysis
