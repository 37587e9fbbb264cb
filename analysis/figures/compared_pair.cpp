#include "analysis/figures/compared_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "analysis/figures/correspondence.h"
#include "analysis/figures/pattern_blocks.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::array<std::string_view, 2> kClockNames{"absolute", "span"};
constexpr std::array<std::string_view, 3> kPlacesNames{"auto", "equal", "never"};

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
  v.visit_choice({"places", "Whether equal pixels show equal places; auto: where sizes agree and the pictures show it"},
                 o.places, kPlacesNames);
  v.visit({"visible_delta_e", "A change of color from here on is seen", "Delta E 1976", above(0)}, o.visible_delta_e);
  v.visit({"num_classes", "Classes of a control", "", between(1, 50)}, o.num_classes);
  v.visit({"num_blocks",
           "Blocks per side, for intervals and for a surface split in two; 0 = by the size of the pattern's features",
           "", between(0, 64)},
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

CommonSizes common_sizes(const SurfaceExtent& a, const SurfaceExtent& b, int size, bool has_equal_places) {
  const auto longer = [](const SurfaceExtent& s) { return std::max(s.width, s.height); };
  const auto capped = [&](int side) { return size > 0 ? std::min(side, size) : side; };
  CommonSizes sizes{capped(longer(a)), capped(longer(b))};
  const bool are_equal = a.width == b.width && a.height == b.height;
  const auto has_other_pixels = [&] {
    constexpr double kTolerance = 0.05;  // Lengths of texels are medians.
    return a.pixel_mm && b.pixel_mm && std::abs(*a.pixel_mm / *b.pixel_mm - 1.0) > kTolerance;
  };
  if (are_equal && (has_equal_places || !has_other_pixels())) return sizes;
  if (a.pixel_mm && b.pixel_mm) {
    const double mm_a = *a.pixel_mm * longer(a), mm_b = *b.pixel_mm * longer(b);
    const double pixel = std::max(mm_a / sizes.a, mm_b / sizes.b);
    const int side_a = static_cast<int>(std::lround(mm_a / pixel)),
              side_b = static_cast<int>(std::lround(mm_b / pixel));
    constexpr int kLeastSide = 32;  // Of a surface much smaller than the other's pixels nothing would be left.
    if (std::min(side_a, side_b) >= std::min({kLeastSide, sizes.a, sizes.b})) return {side_a, side_b};
  }
  sizes.a = sizes.b = std::min(sizes.a, sizes.b);
  return sizes;
}

namespace {

/// Why equal pixels do not show equal places; "" when they do. @param num_shared  Pixels that both show.
std::string places_problem(const ComparedPair& pair, std::size_t num_shared, const CompareOptions& options) {
  if (options.places == Places::Never) return "--places never says that equal pixels do not show equal places";
  if (pair.series_a.width() != pair.series_b.width() || pair.series_a.height() != pair.series_b.height()) {
    return "A has " + size_text(pair.series_a.width(), pair.series_a.height()) + " pixels, B " +
           size_text(pair.series_b.width(), pair.series_b.height()) +
           ": no pixel of one belongs to one of the other; --through TRANSFER looks A up at B's texels";
  }
  const bool is_one_size = pair.a.width == pair.b.width && pair.a.height == pair.b.height;
  if (is_one_size && num_shared == 0) return "the masks of A and B have no texel in common";
  if (options.places == Places::Equal) return "";
  if (!is_one_size)
    return "A's pixels and B's have other lengths; --places equal says that they show equal places all the same";
  const auto is_atlas = [](const TextureSeries& series) {
    return !series.coordinates().empty() || series.facts().origin == "simulated";
  };
  const bool is_looked_up = !pair.series_a.coordinates().empty() && is_atlas(pair.series_b);
  // Photographs of round things have equal masks, too.
  const bool has_charts = (is_atlas(pair.series_a) || is_atlas(pair.series_b)) && have_same_charts(pair.a, pair.b);
  if (is_looked_up || has_charts) return "";
  const SharedDetail shared = shared_detail(pair.a, pair.b);
  if (shared.is_clear()) return "";
  return "the sizes agree, and nothing in the pictures shows that equal pixels are equal places (detail correlates "
         "by " +
         short_number_text(rounded(shared.correlation, 2)) + ", shifted by up to " +
         short_number_text(rounded(shared.by_chance, 2)) + "); --places equal says that they are";
}

}  // namespace

ComparedPair load_pair(TextureSeries a, TextureSeries b, const CompareOptions& options, const RunControl& control) {
  if (options.num_blocks == 1) throw InvalidInput("num_blocks: found 1; expected 0, or a number in [2, 64]");
  const CommonTimes times = common_times(a.facts(), b.facts(), options);
  const auto extent = [](const TextureSeries& s) { return SurfaceExtent{s.width(), s.height(), s.pixel_mm()}; };
  const CommonSizes sizes = common_sizes(extent(a), extent(b), options.size, options.places == Places::Equal);
  ColorStack stack_a = load_stack(a, times.times_a, sizes.a, control.part(0.0, 0.5));
  ColorStack stack_b = load_stack(b, times.times_b, sizes.b, control.part(0.5, 1.0));
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
  const int blocks =
      options.num_blocks > 0 ? options.num_blocks : std::min(pattern_blocks(pair.a), pattern_blocks(pair.b));
  pair.blocks_a = make_blocks(pair.a, blocks);
  pair.blocks_b = make_blocks(pair.b, blocks);
  std::vector<std::uint32_t> shared;
  if (pair.a.width == pair.b.width && pair.a.height == pair.b.height) {
    std::set_intersection(pair.a.texels.begin(), pair.a.texels.end(), pair.b.texels.begin(), pair.b.texels.end(),
                          std::back_inserter(shared));
  }
  pair.places_problem = places_problem(pair, shared.size(), options);
  if (!pair.places_problem.empty()) return pair;
  pair.shared_a = restricted(pair.a, shared);
  pair.shared_b = restricted(pair.b, shared);
  return pair;
}

std::vector<std::string> pair_warnings(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options) {
  if (options.clock == Clock::Span) return {};
  CompareOptions ends = options;
  ends.num_times = 2;  // From where both have frames to where one ends.
  const CommonTimes times = common_times(a, b, ends);
  constexpr double kLeastShare = 0.5;
  std::vector<std::string> warnings;
  const auto add = [&](const char* name, const HistoryFacts& of, const std::vector<double>& compared) {
    const double span = of.frames.back().time - of.frames.front().time;
    if (!(span > 0.0)) return;
    const double share = (compared.back() - compared.front()) / span;
    if (share >= kLeastShare) return;
    warnings.push_back("only " + short_number_text(rounded(100.0 * share, 2)) + " % of " + name +
                       "'s time is compared: A covers " + span_text(a) + ", B " + span_text(b) +
                       "; --clock span compares equal shares of both");
  };
  add("A", a, times.times_a);
  add("B", b, times.times_b);
  return warnings;
}

}  // namespace patinate::analysis
