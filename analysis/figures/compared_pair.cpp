#include "analysis/figures/compared_pair.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::array<std::string_view, 2> kClockNames{"absolute", "span"};
constexpr std::array<std::string_view, 2> kPlacesNames{"auto", "never"};

std::string span_text(const HistoryFacts& m) {
  return short_number_text(m.frames.front().time) + " to " + short_number_text(m.frames.back().time) + " " +
         time_unit_text(m.time_unit);
}

std::vector<double> evenly(double low, double high, int count) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(i + 1 == count ? high : low + (high - low) * i / (count - 1));
  return times;
}

/// The frames' times in [low, high] with the ends, or evenly spaced ones when they are too many.
std::vector<double> clock_times(const std::vector<double>& frames, double low, double high, int most) {
  if (low == high || most == 1) return {high};
  std::vector<double> times{low};
  for (double t : frames) {
    if (t > low && t < high) times.push_back(t);
  }
  times.push_back(high);
  return times.size() <= static_cast<std::size_t>(most) ? times : evenly(low, high, most);
}

}  // namespace

void describe(OptionVisitor& v, CompareOptions& o) {
  v.visit({"size", "Longer side at which the surfaces are compared; 0 = as they are", "px", between(0, 65536)}, o.size);
  v.visit({"num_times", "Times at which they are compared, at most", "", between(1, 1024)}, o.num_times);
  v.visit_choice({"clock", "Compare at equal times, or at equal shares of each history's span"}, o.clock, kClockNames);
  v.visit_choice({"places", "Whether equal pixels show equal places when the sizes agree"}, o.places, kPlacesNames);
  v.visit({"visible_delta_e", "A change of color from here on is seen", "Delta E 1976", above(0)}, o.visible_delta_e);
  v.visit({"num_classes", "Classes of a control", "", between(1, 50)}, o.num_classes);
  v.visit({"num_blocks", "Blocks per side, for intervals and for a surface split in two", "", between(2, 64)},
          o.num_blocks);
  v.visit({"num_resamples", "Resamples of the bootstrap; 0 = no intervals", "", between(0, 100000)}, o.num_resamples);
  v.visit({"cracks", "Measure dark lines at the last common time: share, width, cells, angles"}, o.cracks);
}

CommonTimes common_times(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options) {
  std::vector<double> frames;
  const double start_a = a.frames.front().time, span_a = a.frames.back().time - start_a;
  const double start_b = b.frames.front().time, span_b = b.frames.back().time - start_b;
  CommonTimes common;
  if (options.clock == Clock::Span) {
    for (const FrameFacts& f : a.frames) frames.push_back(span_a > 0.0 ? (f.time - start_a) / span_a : 0.0);
    common.clock = clock_times(frames, 0.0, span_a > 0.0 && span_b > 0.0 ? 1.0 : 0.0, options.num_times);
    for (double t : common.clock) {
      common.times_a.push_back(t == 1.0 ? a.frames.back().time : start_a + t * span_a);
      common.times_b.push_back(t == 1.0 ? b.frames.back().time : start_b + t * span_b);
    }
    return common;
  }
  const double factor = seconds_per(b.time_unit) / seconds_per(a.time_unit);
  const double low = std::max(start_a, start_b * factor),
               high = std::min(start_a + span_a, (start_b + span_b) * factor);
  if (low > high) {
    throw InvalidInput("compare: A covers " + span_text(a) + ", B " + span_text(b) +
                       ": no time in common; --clock span compares by shares of each span");
  }
  for (const FrameFacts& f : a.frames) frames.push_back(f.time);
  common.clock = clock_times(frames, low, high, options.num_times);
  common.times_a = common.clock;
  for (double t : common.clock) common.times_b.push_back(t / factor);
  return common;
}

ComparedPair load_pair(TextureSeries a, TextureSeries b, const CompareOptions& options, const RunControl& control) {
  const CommonTimes times = common_times(a.facts(), b.facts(), options);
  ColorStack stack_a = load_stack(a, times.times_a, options.size, control.part(0.0, 0.5));
  ColorStack stack_b = load_stack(b, times.times_b, options.size, control.part(0.5, 1.0));
  stack_a.times = times.clock;
  stack_b.times = times.clock;
  const std::string unit = options.clock == Clock::Span ? "spans" : time_unit_text(a.facts().time_unit);
  ComparedPair pair{.series_a = std::move(a),
                    .series_b = std::move(b),
                    .a = std::move(stack_a),
                    .b = std::move(stack_b),
                    .time_name = options.clock == Clock::Span ? "share of the span" : "time (" + unit + ")",
                    .time_unit = unit,
                    .places_problem = "",
                    .shared_a = {},
                    .shared_b = {},
                    .blocks_a = {},
                    .blocks_b = {}};
  pair.blocks_a = make_blocks(pair.a, options.num_blocks);
  pair.blocks_b = make_blocks(pair.b, options.num_blocks);
  if (options.places == Places::Never) {
    pair.places_problem = "--places never says that equal pixels do not show equal places";
  } else if (pair.series_a.width() != pair.series_b.width() || pair.series_a.height() != pair.series_b.height()) {
    pair.places_problem = "A has " + size_text(pair.series_a.width(), pair.series_a.height()) + " pixels, B " +
                          size_text(pair.series_b.width(), pair.series_b.height()) +
                          ": no pixel of one belongs to one of the other; --through TRANSFER looks A up at B's texels";
  } else {
    std::vector<std::uint32_t> shared;
    std::set_intersection(pair.a.texels.begin(), pair.a.texels.end(), pair.b.texels.begin(), pair.b.texels.end(),
                          std::back_inserter(shared));
    if (shared.empty()) {
      pair.places_problem = "the masks of A and B have no texel in common";
    } else {
      pair.shared_a = restricted(pair.a, shared);
      pair.shared_b = restricted(pair.b, shared);
    }
  }
  return pair;
}

}  // namespace patinate::analysis
