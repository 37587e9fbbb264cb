/// \file
/// Two surfaces brought to one resolution and one clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/color_stack.h"
#include "libcommon/core/options.h"

namespace patinate::analysis {

enum class Clock { Absolute, Span };
enum class Places { Auto, Never };

struct CompareOptions {
  int size = 256;                 ///< Longer side at which the surfaces are compared, px; 0 = as they are.
  int num_times = 33;             ///< Times at which they are compared, at most; [1, 1024].
  Clock clock = Clock::Absolute;  ///< Equal times, or equal shares of each history's own span.
  Places places = Places::Auto;   ///< Whether equal pixels show equal places when the sizes agree.
  double visible_delta_e = 5.0;   ///< A change from here on is seen; Delta E 1976, > 0.
  int num_classes = 5;            ///< Of a control; [1, 50].
  int num_blocks = 8;             ///< Blocks per side for intervals and for the split; [2, 64].
  int num_resamples = 200;        ///< Of the bootstrap; 0 = no intervals.
  bool cracks = false;            ///< Dark lines are measured too.
  std::uint64_t seed = 0;         ///< Not described: it comes from the command.
};
void describe(OptionVisitor& v, CompareOptions& o);

/// Both sides at the same times.
struct ComparedPair {
  TextureSeries series_a, series_b;
  ColorStack a, b;             ///< Their `times` are those of the common clock.
  std::string time_name;       ///< "time (min)", "share of the span".
  std::string time_unit;       ///< "min", "spans".
  std::string places_problem;  ///< Why equal pixels do not show equal places; "" when they do.
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

/// @throws InvalidInput, IoError. Cost: two frames read for each time and side.
[[nodiscard]] ComparedPair load_pair(TextureSeries a, TextureSeries b, const CompareOptions& options, const RunControl& control = {});

}  // namespace patinate::analysis
