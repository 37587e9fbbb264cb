/// \file
/// Two surfaces brought to one resolution and one clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/color_stack.h"
#include "patinate/analysis/compare_options.h"

namespace patinate::analysis {

/// Both sides at the same times.
struct ComparedPair {
  TextureSeries series_a, series_b;
  ColorStack a, b;                ///< Their `times` are those of the common clock.
  std::string time_name;          ///< "time (min)", "share of the span".
  std::string time_unit;          ///< "min", "spans".
  std::string places_problem;     ///< Why equal pixels do not show equal places; "" when they do.
  ColorStack shared_a, shared_b;  ///< Texels of both; when places_problem is "".
  BlockGrid blocks_a, blocks_b;
};

/// Times on the common clock: those of A's frames where both have frames, else evenly spaced.
struct CommonTimes {
  std::vector<double> clock;             ///< In A's unit, or shares of the span.
  std::vector<double> times_a, times_b;  ///< In each history's own unit.
};
/// @throws InvalidInput if the histories have no time in common.
[[nodiscard]] CommonTimes common_times(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options);

/// A history's frames on that clock. @param a  The history whose unit it has.
[[nodiscard]] std::vector<double> frames_on_clock(const HistoryFacts& history, const HistoryFacts& a,
                                                  const CompareOptions& options);

/// One of several histories that are compared at the same times.
struct NamedFacts {
  std::string name;  ///< "A", for what is said about it.
  const HistoryFacts* facts = nullptr;
};
/// Common times of any number of histories, the first of which is A.
struct GroupTimes {
  std::vector<double> clock;
  std::vector<std::vector<double>> of;  ///< [history]: in its own unit.
};
/// @throws InvalidInput if they have no time in common, or there is none.
[[nodiscard]] GroupTimes common_times(const std::vector<NamedFacts>& histories, const CompareOptions& options);

/// Warns where a comparison is likely not meant: less than half of a side's time is compared.
[[nodiscard]] std::vector<std::string> pair_warnings(const HistoryFacts& a, const HistoryFacts& b,
                                                     const CompareOptions& options);
/// Warns in the same way about any number of histories.
[[nodiscard]] std::vector<std::string> time_warnings(const std::vector<NamedFacts>& histories,
                                                     const CompareOptions& options);

/// Facts that decide at which size a surface is compared.
struct SurfaceExtent {
  int width = 0;
  int height = 0;
  std::optional<double> pixel_mm = {};
};
/// Longer sides at which both sides are compared.
struct CommonSizes {
  int a = 0;
  int b = 0;
};
/// At most `size` (0: as they are); of surfaces of different sizes equal ones, or equal lengths a pixel where both know
/// theirs. @param has_equal_places  Equal pixels are known to show equal places: surfaces of one size stay as they are.
[[nodiscard]] CommonSizes common_sizes(const SurfaceExtent& a, const SurfaceExtent& b, int size, bool has_equal_places);

/// Surfaces of different sizes are compared at equal lengths a pixel where both know theirs, else at equal sizes.
/// @throws InvalidInput, IoError. Cost: two frames read for each time and side.
[[nodiscard]] ComparedPair load_pair(TextureSeries a, TextureSeries b, const CompareOptions& options,
                                     const RunControl& control = {});
/// The pair of two surfaces that are loaded already. @param stack_a,stack_b  Their times are those of the common clock.
/// @param unit  Of the clock with --clock absolute. @throws InvalidInput if num_blocks is 1.
[[nodiscard]] ComparedPair joined_pair(TextureSeries a, TextureSeries b, ColorStack stack_a, ColorStack stack_b,
                                       TimeUnit unit, const CompareOptions& options);

}  // namespace patinate::analysis
