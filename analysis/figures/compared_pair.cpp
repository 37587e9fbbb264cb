#include "analysis/figures/compared_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "analysis/figures/correspondence.h"
#include "analysis/figures/pattern_blocks.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::array<std::string_view, 3> kPlacesNames{"auto", "equal", "never"};

std::string span_text(const HistoryFacts& m) {
  return short_number_text(m.frames.front().time) + " to " + short_number_text(m.frames.back().time) + " " +
         shown_time_unit(m.time_unit);
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
  v.visit_choice({"places", "Do equal pixels show equal places? auto: if sizes agree and the pictures prove it"},
                 o.places, kPlacesNames);
  v.visit({"visible_delta_e", "Smallest visible change of color", "Delta E 1976", above(0)}, o.visible_delta_e);
  v.visit({"num_classes", "Classes of a control", "", between(1, 50)}, o.num_classes);
  v.visit({"num_blocks",
           "Blocks per side, for intervals and for a surface split in two; 0 = by the size of the pattern's features",
           "", between(0, 64)},
          o.num_blocks);
  v.visit({"num_resamples", "Resamples of the bootstrap; 0 = no intervals", "", between(0, 100000)}, o.num_resamples);
  v.visit({"cracks", "Measure dark lines at the last common time: share, width, cells, angles"}, o.cracks);
}

std::vector<double> frames_on_clock(const HistoryFacts& history, const HistoryFacts& a, const CompareOptions& options) {
  const double start = history.frames.front().time, span = history.frames.back().time - start;
  const double factor = seconds_per(history.time_unit) / seconds_per(a.time_unit);
  std::vector<double> times;
  for (const FrameFacts& f : history.frames) {
    const double share = span > 0.0 ? (f.time - start) / span : 0.0;
    times.push_back(options.clock == Clock::Span ? share : f.time * factor);
  }
  return times;
}

GroupTimes common_times(const std::vector<NamedFacts>& histories, const CompareOptions& options) {
  if (histories.empty()) throw InvalidInput("compare: there is no history");
  const auto start = [](const NamedFacts& h) { return h.facts->frames.front().time; };
  const auto span = [&](const NamedFacts& h) { return h.facts->frames.back().time - start(h); };
  const NamedFacts& first = histories.front();
  GroupTimes common;
  const std::vector<double> frames = frames_on_clock(*first.facts, *first.facts, options);
  if (options.clock == Clock::Span) {
    const bool have_spans =
        std::all_of(histories.begin(), histories.end(), [&](const auto& h) { return span(h) > 0.0; });
    common.clock = clock_times(frames, 0.0, have_spans ? 1.0 : 0.0, options.num_times);
    for (const NamedFacts& h : histories) {
      std::vector<double>& times = common.of.emplace_back();
      for (double t : common.clock) times.push_back(t == 1.0 ? h.facts->frames.back().time : start(h) + t * span(h));
    }
    return common;
  }
  const auto factor = [&](const NamedFacts& h) {
    return seconds_per(h.facts->time_unit) / seconds_per(first.facts->time_unit);
  };
  const auto low_of = [&](const NamedFacts& h) { return start(h) * factor(h); };
  const auto high_of = [&](const NamedFacts& h) { return (start(h) + span(h)) * factor(h); };
  const auto last_to_start = std::max_element(histories.begin(), histories.end(),
                                              [&](const auto& x, const auto& y) { return low_of(x) < low_of(y); });
  const auto first_to_end = std::min_element(histories.begin(), histories.end(),
                                             [&](const auto& x, const auto& y) { return high_of(x) < high_of(y); });
  const double low = low_of(*last_to_start), high = high_of(*first_to_end);
  if (low > high) {
    const auto [one, other] = std::minmax(last_to_start, first_to_end);
    throw InvalidInput("compare: " + one->name + " covers " + span_text(*one->facts) + ", " + other->name + " " +
                       span_text(*other->facts) + ": no time in common; --clock span compares by shares of each span");
  }
  common.clock = clock_times(frames, low, high, options.num_times);
  for (const NamedFacts& h : histories) {
    std::vector<double>& times = common.of.emplace_back();
    for (double t : common.clock) times.push_back(t / factor(h));
  }
  return common;
}

CommonTimes common_times(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options) {
  GroupTimes common = common_times({{"A", &a}, {"B", &b}}, options);
  return {std::move(common.clock), std::move(common.of[0]), std::move(common.of[1])};
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
    constexpr int kMinSide = 32;  // px: of a surface much smaller than the other's pixels, nothing would be left.
    if (std::min(side_a, side_b) >= std::min({kMinSide, sizes.a, sizes.b})) return {side_a, side_b};
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
  const CommonTimes times = common_times(a.facts(), b.facts(), options);
  const auto extent = [](const TextureSeries& s) { return SurfaceExtent{s.width(), s.height(), s.pixel_mm()}; };
  const CommonSizes sizes = common_sizes(extent(a), extent(b), options.size, options.places == Places::Equal);
  ColorStack stack_a = load_stack(a, times.times_a, sizes.a, control.part(0.0, 0.5));
  ColorStack stack_b = load_stack(b, times.times_b, sizes.b, control.part(0.5, 1.0));
  stack_a.times = times.clock;
  stack_b.times = times.clock;
  const TimeUnit unit = a.facts().time_unit;
  return joined_pair(std::move(a), std::move(b), std::move(stack_a), std::move(stack_b), unit, options);
}

ComparedPair joined_pair(TextureSeries a, TextureSeries b, ColorStack stack_a, ColorStack stack_b, TimeUnit time_unit,
                         const CompareOptions& options) {
  if (options.num_blocks == 1) throw InvalidInput("num_blocks: found 1; expected 0, or a number in [2, 64]");
  const std::string unit = options.clock == Clock::Span ? "spans" : shown_time_unit(time_unit);
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

std::vector<std::string> time_warnings(const std::vector<NamedFacts>& histories, const CompareOptions& options) {
  if (options.clock == Clock::Span) return {};
  CompareOptions ends = options;
  ends.num_times = 2;  // From where all have frames to where one ends.
  const GroupTimes times = common_times(histories, ends);
  constexpr double kMinShare = 0.5;  // Share of a side's time that is compared, below which it is said.
  std::string covered;
  for (const NamedFacts& h : histories)
    covered += (covered.empty() ? h.name + " covers " : ", " + h.name + " ") + span_text(*h.facts);
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < histories.size(); ++k) {
    const std::vector<FrameFacts>& frames = histories[k].facts->frames;
    const double span = frames.back().time - frames.front().time;
    if (!(span > 0.0)) continue;
    const double share = (times.of[k].back() - times.of[k].front()) / span;
    if (share >= kMinShare) continue;
    warnings.push_back("only " + short_number_text(rounded(100.0 * share, 2)) + " % of " + histories[k].name +
                       "'s time is compared: " + covered + "; --clock span compares equal shares of " +
                       (histories.size() == 2 ? "both" : "all"));
  }
  return warnings;
}

std::vector<std::string> pair_warnings(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options) {
  return time_warnings({{"A", &a}, {"B", &b}}, options);
}

}  // namespace patinate::analysis
