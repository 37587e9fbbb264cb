// Two surfaces by their colors, wherever those are.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/compare/sections.h"
#include "analysis/figures/aging.h"
#include "analysis/figures/sliced_distance.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxColorTimes = 13, kMaxColorSamples = 4096;  ///< Times and places, evenly picked.
constexpr std::uint32_t kDistributionPurpose = 101, kOnsetPurpose = 102, kSaturationPurpose = 103,
                        kCoveredPurpose = 104;

std::vector<double> mean_and(std::vector<double> curve) {
  curve.insert(curve.begin(), std::accumulate(curve.begin(), curve.end(), 0.0) / static_cast<double>(curve.size()));
  return curve;
}

/// A curve of the values after the first, which is their mean, with band and with what A against itself shows.
Curve distance_curve(const SplitFigure& f, const std::vector<double>& x, const std::string& name,
                     const std::string& title, const std::string& x_name, const std::string& y_name) {
  Curve curve{.name = name, .title = title, .x_name = x_name, .y_name = y_name, .x = x, .columns = {}};
  CurveColumn between{"A against B", {}}, split{"A against itself split in two", {}, {}, true};
  for (std::size_t i = 0; i < x.size(); ++i) {
    between.values.emplace_back(f.value[i + 1]);
    if (f.intervals) between.band.emplace_back((*f.intervals)[i + 1].low, (*f.intervals)[i + 1].high);
    if (!f.split.empty()) split.values.emplace_back(f.split[i + 1]);
  }
  curve.columns.push_back(std::move(between));
  if (!split.values.empty()) curve.columns.push_back(std::move(split));
  return curve;
}

void add_distribution(const ComparedPair& pair, const CompareOptions& options, const RunControl& control,
                      Section& section) {
  std::vector<SortedColors> a, b;
  std::vector<double> times;
  const auto sample = [&](const ColorStack& stack, const BlockGrid& grid, std::size_t t) {
    std::vector<std::uint32_t> all(stack.num_texels());
    std::iota(all.begin(), all.end(), 0u);
    return SortedColors(stack, t, all, grid.block_of, kMaxColorSamples, options.seed);
  };
  for (const std::size_t t : spread_indices(pair.a.num_times(), kMaxColorTimes)) {
    times.push_back(pair.a.times[t]);
    a.push_back(sample(pair.a, pair.blocks_a, t));
    b.push_back(sample(pair.b, pair.blocks_b, t));
  }
  const auto figure = [](const std::vector<SortedColors>& one, const std::vector<SortedColors>& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      std::vector<double> curve;
      for (std::size_t t = 0; t < one.size(); ++t) {
        const std::optional<double> d = sliced_distance(one[t], wa, other[t], wb);
        if (!d) return std::vector<double>();
        curve.push_back(*d);
      }
      return mean_and(std::move(curve));
    };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kDistributionPurpose, control);
  section.figures.push_back(figure_of(f, 0, "color_distribution",
                                      "Distance between the distributions of color, mean over times", "Delta E 1976",
                                      "no block shows the surface"));
  if (!f.value.empty())
    section.curves.push_back(distance_curve(
        f, times, "color_distribution", "Distance between the distributions of color", pair.time_name, "Delta E 1976"));
}

std::vector<BlockValue> times_of(const TexelAging& aging, const std::vector<float>& values, const BlockGrid& grid) {
  std::vector<BlockValue> out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (aging.ages[i] != 0) out.push_back({values[i], grid.block_of[i]});
  }
  sort_values(out);
  return out;
}

/// The median of a time of one side; between two of its frames it is known as no more than that.
Figure median_figure(const ComparedPair& pair, const std::vector<BlockValue>& list, bool is_a, const std::string& name,
                     const std::string& what, const CompareOptions& options) {
  const std::string side = is_a ? "A" : "B";
  Figure figure{
      .name = name + "_median_" + (is_a ? "a" : "b"), .title = what + ": median of " + side, .unit = pair.time_unit};
  if (!list.empty()) figure.value = quantile(list, (is_a ? pair.blocks_a : pair.blocks_b).all(), 0.5);
  if (!figure.value) figure.undefined = side + " does not age visibly anywhere";
  if (!figure.value) return figure;
  const std::vector<double> frames =
      frames_on_clock((is_a ? pair.series_a : pair.series_b).facts(), pair.series_a.facts(), options);
  const auto [low, high] = seen_between(*figure.value, pair.a.times);
  const double after = seen_between(low, frames).first, before = seen_between(high, frames).second;
  if (after < before) figure.after = after, figure.before = before;
  return figure;
}

/// The distance between the distributions of a time of A and of B, and the medians.
void add_times(const ComparedPair& pair, const std::vector<BlockValue>& a, const std::vector<BlockValue>& b,
               const std::string& name, const std::string& what, const CompareOptions& options, std::uint32_t purpose,
               const RunControl& control, Section& section) {
  const auto figure = [](const std::vector<BlockValue>& one, const std::vector<BlockValue>& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      const std::optional<double> d = quantile_distance(one, wa, other, wb, 1);
      return d ? std::vector<double>{*d} : std::vector<double>();
    };
  };
  const std::string undefined = std::string(a.empty() ? "A" : "B") + " does not age visibly anywhere";
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, purpose, control);
  section.figures.push_back(
      figure_of(f, 0, name + "_distance", what + ": distance between the distributions", pair.time_unit, undefined));
  for (const bool is_a : {true, false})
    section.figures.push_back(median_figure(pair, is_a ? a : b, is_a, name, what, options));
}

/// Share of the texels with a visible change at every time; empty when no block has weight.
std::vector<double> covered_share(const std::vector<std::vector<double>>& first_covered,
                                  const std::vector<double>& counts, const std::vector<int>& weights) {
  std::vector<double> share(first_covered.empty() ? 0 : first_covered.front().size());
  double total = 0.0;
  for (std::size_t b = 0; b < weights.size(); ++b) {
    total += weights[b] * counts[b];
    for (std::size_t t = 0; t < share.size(); ++t) share[t] += weights[b] * first_covered[b][t];
  }
  if (total == 0.0) return {};
  double sum = 0.0;
  for (double& s : share) {
    sum += s;
    s = sum / total;
  }
  return share;
}

struct Covered {
  std::vector<std::vector<double>> first;  ///< [block][time]: texels that become covered then.
  std::vector<double> counts;              ///< Texels of every block.
};

Covered covered_of(const TexelAging& aging, const BlockGrid& grid, std::size_t num_times) {
  Covered c{std::vector<std::vector<double>>(grid.num_blocks(), std::vector<double>(num_times)),
            std::vector<double>(grid.num_blocks())};
  for (std::size_t i = 0; i < aging.covered_at.size(); ++i) {
    c.counts[grid.block_of[i]] += 1.0;
    if (aging.covered_at[i] < num_times) c.first[grid.block_of[i]][aging.covered_at[i]] += 1.0;
  }
  return c;
}

void add_covered(const ComparedPair& pair, const TexelAging& aging_a, const TexelAging& aging_b,
                 const CompareOptions& options, const RunControl& control, Section& section) {
  const std::size_t num_times = pair.a.num_times();
  const Covered a = covered_of(aging_a, pair.blocks_a, num_times), b = covered_of(aging_b, pair.blocks_b, num_times);
  const auto figure = [](const Covered& one, const Covered& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      const std::vector<double> x = covered_share(one.first, one.counts, wa),
                                y = covered_share(other.first, other.counts, wb);
      if (x.empty() || y.empty()) return std::vector<double>();
      double sum = 0.0;
      for (std::size_t t = 0; t < x.size(); ++t) sum += std::abs(x[t] - y[t]);
      return std::vector<double>{sum / static_cast<double>(x.size())};
    };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kCoveredPurpose, control);
  section.figures.push_back(figure_of(f, 0, "covered_distance",
                                      "Share with a visible change: difference, mean over times", "",
                                      "no block shows the surface"));
  const std::vector<double> x = covered_share(a.first, a.counts, pair.blocks_a.all()),
                            y = covered_share(b.first, b.counts, pair.blocks_b.all());
  section.curves.push_back({.name = "covered",
                            .title = "Share of the surface with a visible change",
                            .x_name = pair.time_name,
                            .y_name = "share",
                            .x = pair.a.times,
                            .columns = {{"A", {x.begin(), x.end()}}, {"B", {y.begin(), y.end()}}}});
}

/// Mean L*, a*, b* of both sides.
void add_means(const ComparedPair& pair, Section& section) {
  constexpr const char* kNames[3] = {"L", "a", "b"};
  for (std::size_t c = 0; c < 3; ++c) {
    Curve curve{.name = std::string("mean_") + kNames[c],
                .title = std::string("Mean ") + kNames[c] + "*",
                .x_name = pair.time_name,
                .y_name = std::string(kNames[c]) + "*",
                .x = pair.a.times,
                .columns = {},
                .from_zero = false};
    for (const ColorStack* stack : {&pair.a, &pair.b}) {
      CurveColumn column{stack == &pair.a ? "A" : "B", {}};
      for (std::size_t t = 0; t < stack->num_times(); ++t) {
        double sum = 0.0;
        for (std::size_t i = 0; i < stack->num_texels(); ++i) sum += static_cast<double>(stack->lab_of(t, i)[c]);
        column.values.emplace_back(sum / static_cast<double>(stack->num_texels()));
      }
      curve.columns.push_back(std::move(column));
    }
    section.curves.push_back(std::move(curve));
  }
}

}  // namespace

Section colors_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "colors", .title = "Colors, wherever they are"};
  section.paragraphs.push_back(
      "Distances are between whole distributions: shifting every color by some Delta E gives exactly that number. A "
      "change is visible from Delta E " +
      short_number_text(options.visible_delta_e) +
      " on; onset and saturation are the times at which a place has made a tenth and nine tenths of its change.");
  add_distribution(pair, options, control.part(0.0, 0.6), section);
  add_means(pair, section);
  if (pair.a.num_times() < 2) {
    for (const char* name : {"onset_distance", "saturation_distance", "covered_distance"})
      section.figures.push_back(
          {.name = name, .title = name, .unit = pair.time_unit, .undefined = "there is only one common time"});
    return section;
  }
  const TexelAging a = texel_aging(pair.a, options.visible_delta_e, control),
                   b = texel_aging(pair.b, options.visible_delta_e, control);
  add_times(pair, times_of(a, a.onset, pair.blocks_a), times_of(b, b.onset, pair.blocks_b), "onset", "Onset", options,
            kOnsetPurpose, control.part(0.6, 0.8), section);
  add_times(pair, times_of(a, a.saturation, pair.blocks_a), times_of(b, b.saturation, pair.blocks_b), "saturation",
            "Saturation", options, kSaturationPurpose, control.part(0.8, 0.95), section);
  add_covered(pair, a, b, options, control.part(0.95, 1.0), section);
  return section;
}

}  // namespace patinate::analysis
