// Two surfaces by how coarse their structure is.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/compare/sections.h"
#include "analysis/figures/spatial.h"
#include "analysis/figures/spectrum_distance.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxStructureTimes = 9;  ///< Times, evenly picked.
constexpr std::uint32_t kSpectrumPurpose = 201, kLengthPurpose = 202, kContrastPurpose = 203;

Spectrum spectrum_of(const SpatialStructure& structure, std::span<const int> weights) {
  return {structure.frequencies(), structure.spectrum(weights)};
}

struct Structures {
  std::vector<SpatialStructure> at;
  double pixel = 1.0;  ///< mm, or 1.
};

Structures structures_of(const ColorStack& stack, const BlockGrid& grid, const std::vector<std::size_t>& times,
                         double pixel, const RunControl& control) {
  std::vector<std::optional<SpatialStructure>> made(times.size());
  parallel_for(static_cast<std::int64_t>(times.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k)
      made[k].emplace(stack, times[k], grid);
  });
  Structures out{{}, pixel};
  for (auto& m : made) out.at.push_back(std::move(*m));
  return out;
}

void add_contrast(const ComparedPair& pair, const Structures& a, const Structures& b, const CompareOptions& options,
                  const RunControl& control, Section& section) {
  const auto figure = [](const Structures& one, const Structures& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      double sum = 0.0;
      for (std::size_t t = 0; t < one.at.size(); ++t) {
        const std::optional<double> d =
            contrast_between(spectrum_of(one.at[t], wa), one.pixel, spectrum_of(other.at[t], wb), other.pixel);
        if (!d) return std::vector<double>();
        sum += *d;
      }
      return std::vector<double>{sum / static_cast<double>(one.at.size())};
    };
  };
  section.figures.push_back(
      figure_of(split_figure(pair, figure(a, b), figure(a, a), options, kContrastPurpose, control), 0,
                "contrast_distance", "Contrast of lightness by wavelength: distance, mean over times", "L*",
                "no tile of " + std::to_string(a.at.front().tile_px()) +
                    " pixels lies on the surface of both, or they share no frequency"));
}

void add_spectrum(const ComparedPair& pair, const Structures& a, const Structures& b, const std::string& unit,
                  const CompareOptions& options, const RunControl& control, Section& section) {
  const auto figure = [](const Structures& one, const Structures& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      double sum = 0.0;
      for (std::size_t t = 0; t < one.at.size(); ++t) {
        const std::optional<double> d =
            octaves_between(spectrum_of(one.at[t], wa), one.pixel, spectrum_of(other.at[t], wb), other.pixel);
        if (!d) return std::vector<double>();
        sum += *d;
      }
      return std::vector<double>{sum / static_cast<double>(one.at.size())};
    };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kSpectrumPurpose, control);
  section.figures.push_back(
      figure_of(f, 0, "spectrum_distance",
                "Power spectra of lightness: factor between them, mean over frequencies and times", "octaves",
                "no tile of " + std::to_string(a.at.front().tile_px()) +
                    " pixels lies on the surface of both, or they share no frequency"));
  Curve curve{.name = "spectrum",
              .title = "Power spectrum of lightness at the last common time",
              .x_name = "cycles per " + unit,
              .y_name = "power (L*^2 " + unit + "^2)",
              .x = {},
              .columns = {},
              .is_logarithmic = true};
  for (double v : a.at.back().frequencies()) curve.x.push_back(v / a.pixel);
  for (const Structures* s : {&a, &b}) {
    CurveColumn column{s == &a ? "A" : "B", {}};
    const Spectrum spectrum = spectrum_of(s->at.back(), (s == &a ? pair.blocks_a : pair.blocks_b).all());
    for (double frequency : curve.x) {
      const std::optional<double> log = log_power(spectrum, frequency * s->pixel);
      column.values.push_back(log ? std::optional(std::exp2(*log) * s->pixel * s->pixel) : std::nullopt);
    }
    curve.columns.push_back(std::move(column));
  }
  section.curves.push_back(std::move(curve));
}

void add_length(const ComparedPair& pair, const Structures& a, const Structures& b, const std::vector<double>& times,
                const std::string& unit, const CompareOptions& options, const RunControl& control, Section& section) {
  const auto figure = [](const Structures& one, const Structures& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      double sum = 0.0;
      int count = 0;
      for (std::size_t t = 0; t < one.at.size(); ++t) {
        const std::optional<double> x = one.at[t].correlation_length(wa), y = other.at[t].correlation_length(wb);
        if (!x || !y) continue;
        sum += std::abs(std::log2(*x * one.pixel / (*y * other.pixel)));
        ++count;
      }
      return count == 0 ? std::vector<double>() : std::vector<double>{sum / count};
    };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kLengthPurpose, control);
  section.figures.push_back(figure_of(
      f, 0, "correlation_length_distance", "Correlation lengths: factor between them, mean over times", "octaves",
      "at no common time does the lightness of both vary and lose its correlation within a third of the surface"));
  Curve curve{.name = "correlation_length",
              .title = "Correlation length of lightness",
              .x_name = pair.time_name,
              .y_name = unit,
              .x = times,
              .columns = {}};
  for (const Structures* s : {&a, &b}) {
    CurveColumn column{s == &a ? "A" : "B", {}};
    for (const SpatialStructure& at : s->at) {
      const std::optional<double> length = at.correlation_length((s == &a ? pair.blocks_a : pair.blocks_b).all());
      column.values.push_back(length ? std::optional(*length * s->pixel) : std::nullopt);
    }
    curve.columns.push_back(std::move(column));
  }
  section.curves.push_back(std::move(curve));
}

}  // namespace

Section structure_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "structure", .title = "Structure"};
  const bool is_metric = pair.a.pixel_mm && pair.b.pixel_mm;
  const std::string unit = is_metric ? "mm" : "pixel";
  section.paragraphs.push_back(
      is_metric
          ? "Lengths are on the surface."
          : "Lengths are in pixels of the compared size: the surface length of a pixel is not known on both sides.");
  std::vector<double> times;
  const std::vector<std::size_t> indices = spread_indices(pair.a.num_times(), kMaxStructureTimes);
  for (const std::size_t t : indices) times.push_back(pair.a.times[t]);
  const Structures a =
      structures_of(pair.a, pair.blocks_a, indices, is_metric ? *pair.a.pixel_mm : 1.0, control.part(0.0, 0.3));
  const Structures b =
      structures_of(pair.b, pair.blocks_b, indices, is_metric ? *pair.b.pixel_mm : 1.0, control.part(0.3, 0.6));
  add_spectrum(pair, a, b, unit, options, control.part(0.6, 0.7), section);
  add_contrast(pair, a, b, options, control.part(0.7, 0.8), section);
  add_length(pair, a, b, times, unit, options, control.part(0.8, 1.0), section);
  return section;
}

}  // namespace patinate::analysis
