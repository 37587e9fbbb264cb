/// \file
/// Settings of a comparison.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "patinate/core/options.h"

namespace patinate::analysis {

enum class Clock { Absolute, Span };
inline constexpr std::array<std::string_view, 2> kClockNames{"absolute", "span"};
enum class Places { Auto, Equal, Never };

struct CompareOptions {
  int size = 256;                 ///< Longer side at which the surfaces are compared, px; 0 = as they are.
  int num_times = 33;             ///< Times at which they are compared, at most; [1, 1024].
  Clock clock = Clock::Absolute;  ///< Equal times, or equal shares of each history's own span.
  Places places =
      Places::Auto;  ///< Do equal pixels show equal places? Auto: yes if sizes agree and the pictures prove it.
  double visible_delta_e = 5.0;  ///< A change from here on is seen; Delta E 1976, > 0.
  int num_classes = 5;           ///< Number of classes of a control; [1, 50].
  int num_blocks = 0;            ///< Blocks per side for intervals and for the split; [2, 64], 0 = of at least four
                                 ///< features of the pattern, 3 to 8 of them.
  int num_resamples = 200;       ///< Number of bootstrap resamples; 0 = no intervals.
  bool cracks = false;           ///< Dark lines are measured too.
  std::uint64_t seed = 0;        ///< Not described: it comes from the command.
};
void describe(OptionVisitor& v, CompareOptions& o);

}  // namespace patinate::analysis
