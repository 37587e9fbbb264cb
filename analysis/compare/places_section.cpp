// Two surfaces place by place.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "analysis/compare/sections.h"
#include "analysis/figures/aging.h"
#include "analysis/figures/pixel_difference.h"
#include "analysis/figures/time_warp.h"
#include "libcommon/core/text.h"
#include "libcommon/output/map_legend.h"

namespace patinate::analysis {

namespace {

std::vector<std::optional<double>> column(const std::vector<PixelDifference>& differences,
                                          double PixelDifference::*member) {
  std::vector<std::optional<double>> out;
  for (const PixelDifference& d : differences) out.emplace_back(d.*member);
  return out;
}

double mean(const std::vector<PixelDifference>& differences, double PixelDifference::*member) {
  double sum = 0.0;
  for (const PixelDifference& d : differences) sum += d.*member;
  return sum / static_cast<double>(differences.size());
}

std::vector<std::optional<double>> optionals(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Figures over every place and time, in one number each.
std::vector<Figure> figures_of(const std::vector<PixelDifference>& differences) {
  return {{.name = "ciede2000_mean",
           .title = "CIEDE2000, mean over places and times",
           .unit = "Delta E 2000",
           .value = mean(differences, &PixelDifference::ciede2000_mean)},
          {.name = "ciede2000_p95",
           .title = "CIEDE2000, 95th percentile of places, mean over times",
           .unit = "Delta E 2000",
           .value = mean(differences, &PixelDifference::ciede2000_p95)},
          {.name = "ssim_mean",
           .title = "SSIM of lightness, mean over places and times",
           .unit = "",
           .value = mean(differences, &PixelDifference::ssim)},
          {.name = "absolute_mean",
           .title = "Absolute difference of linear color",
           .unit = "",
           .value = mean(differences, &PixelDifference::absolute)}};
}

void add_differences(const ComparedPair& pair, const std::vector<PixelDifference>& differences, Section& section) {
  for (Figure& figure : figures_of(differences)) section.figures.push_back(std::move(figure));
  Curve ciede{.name = "ciede2000",
              .title = "Color difference, place by place",
              .x_name = pair.time_name,
              .y_name = "CIEDE2000",
              .x = pair.a.times,
              .columns = {}};
  ciede.columns.push_back({"mean", column(differences, &PixelDifference::ciede2000_mean)});
  ciede.columns.push_back({"median", column(differences, &PixelDifference::ciede2000_median)});
  ciede.columns.push_back({"95th percentile", column(differences, &PixelDifference::ciede2000_p95)});
  section.curves.push_back(std::move(ciede));
  section.curves.push_back({.name = "ssim",
                            .title = "Structural similarity of lightness",
                            .x_name = pair.time_name,
                            .y_name = "SSIM",
                            .x = pair.a.times,
                            .columns = {{"SSIM", column(differences, &PixelDifference::ssim)}}});
  section.curves.push_back({.name = "absolute",
                            .title = "Absolute difference of linear color",
                            .x_name = pair.time_name,
                            .y_name = "mean |A - B|",
                            .x = pair.a.times,
                            .columns = {{"absolute", column(differences, &PixelDifference::absolute)}}});
}

void add_stated_noise(const ComparedPair& pair, const CompareOptions& options, const RunControl& control,
                      Section& section) {
  const std::optional<StatedNoise> noise = stated_noise(pair.shared_a, pair.shared_b, options.seed, control);
  if (!noise) return;
  section.figures.push_back({.name = "ciede2000_stated",
                             .title = "CIEDE2000 that the deviations stated with the captures make by themselves",
                             .unit = "Delta E 2000",
                             .value = noise->ciede2000});
  section.figures.push_back(
      {.name = "beyond_stated",
       .title = "Share of places and times that differ by more than those deviations explain (99 %)",
       .unit = "",
       .value = noise->beyond_share});
}

void add_maps(const ComparedPair& pair, double top, Section& section) {
  const ImageU8 mask = pair.shared_a.mask();
  const double high = std::max(2.0, std::ceil(top));
  const std::string caption =
      "CIEDE2000: dark blue 0, yellow " + short_number_text(high) + "; gray, not seen on both sides";
  Picture maps = picture_strip(
      "ciede2000", caption, pair, spread_indices(pair.a.num_times(), kPicturesInARow), [&](std::size_t t) {
        return ramp_picture(pair.shared_a.value_image(ciede2000_at(pair.shared_a, t, pair.shared_b, t)), mask, 0.0,
                            high, ColorRamp::Sequential);
      });
  maps.image = with_legend(maps.image, {.ramp = ColorRamp::Sequential, .high = high, .unit = "Delta E 2000"});
  section.pictures.push_back(std::move(maps));
}

double mean_deviation(const TimeWarp& warp) {
  double deviation = 0.0;
  for (std::size_t i = 0; i < warp.times.size(); ++i)
    deviation += std::abs(warp.warped[i] - warp.times[i]) / static_cast<double>(warp.times.size());
  return deviation;
}

/// The clock of the whole surface; with intervals where blocks of it could be drawn.
struct CommonClock {
  TimeWarp warp;
  std::optional<std::vector<FigureInterval>> warped;  ///< By time.
  std::optional<std::vector<FigureInterval>>
      distances;  ///< Distances of the deviation, and of the residuals before and after.
};

CommonClock find_clock(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  constexpr std::int64_t kMaxBytes = std::int64_t{256} << 20;  // Longer series: no interval.
  constexpr std::uint32_t kPurpose = 0x70;
  BlockGrid grid = make_blocks(pair.shared_a, pair.blocks_a.columns);
  if (BlockWarps::memory_bytes(pair.shared_a.num_times(), grid) > kMaxBytes) grid = make_blocks(pair.shared_a, 1);
  const BlockWarps warps(pair.shared_a, pair.shared_b, grid, 8, control);
  CommonClock clock{.warp = warps.warp(grid.all()), .warped = {}, .distances = {}};
  const auto distances_of = [](const TimeWarp& warp) {
    return std::vector{mean_deviation(warp), rms(warp.before), rms(warp.after)};
  };
  const RunControl quiet = control.silent();
  const BootstrapOptions bootstrap{
      .resamples = options.num_resamples, .seed = options.seed, .purpose = kPurpose, .is_paired = true};
  clock.warped = block_ranges(
      grid, grid, clock.warp.warped,
      [&](const std::vector<int>& weights, const std::vector<int>&) { return warps.warp(weights).warped; }, bootstrap,
      quiet);
  clock.distances = block_intervals(
      grid, grid, distances_of(clock.warp),
      [&](const std::vector<int>& weights, const std::vector<int>&) { return distances_of(warps.warp(weights)); },
      bootstrap, quiet);
  return clock;
}

void add_warp(const ComparedPair& pair, const CompareOptions& options, const RunControl& control, Section& section) {
  const CommonClock clock = find_clock(pair, options, control);
  const TimeWarp& warp = clock.warp;
  std::vector<Figure> figures{{.name = "warp_deviation",
                               .title = "Mean distance of the best common clock from equal times",
                               .unit = pair.time_unit,
                               .value = mean_deviation(warp)},
                              {.name = "residual_before_warp",
                               .title = "Difference at equal times, root mean square",
                               .unit = "Delta E 1976",
                               .value = rms(warp.before)},
                              {.name = "residual_after_warp",
                               .title = "What is left after the best common clock",
                               .unit = "Delta E 1976",
                               .value = rms(warp.after)}};
  for (std::size_t k = 0; k < figures.size(); ++k) {
    if (clock.distances) {
      figures[k].low = (*clock.distances)[k].low;
      figures[k].high = (*clock.distances)[k].high;
    }
    section.figures.push_back(std::move(figures[k]));
  }
  CurveColumn best{.name = "best clock", .values = optionals(warp.warped)};
  if (clock.warped) {
    for (const FigureInterval& interval : *clock.warped) best.band.emplace_back(interval.low, interval.high);
  }
  section.curves.push_back({.name = "time_warp",
                            .title = "The common clock: when B shows what A shows",
                            .x_name = "A: " + pair.time_name,
                            .y_name = "B: " + pair.time_name,
                            .x = warp.times,
                            .columns = {std::move(best), {"equal times", optionals(warp.times), {}, true}}});
  section.curves.push_back(
      {.name = "warp_residual",
       .title = "Difference before and after the best common clock",
       .x_name = pair.time_name,
       .y_name = "RMS Delta E 1976",
       .x = warp.times,
       .columns = {{"equal times", optionals(warp.before)}, {"best clock", optionals(warp.after)}}});
}

void add_shift(const ComparedPair& pair, const CompareOptions& options, const RunControl& control, Section& section) {
  const TexelAging aging_a = texel_aging(pair.shared_a, options.visible_delta_e, control),
                   aging_b = texel_aging(pair.shared_b, options.visible_delta_e, control);
  std::vector<std::uint8_t> known(aging_a.ages.size());
  for (std::size_t i = 0; i < known.size(); ++i) known[i] = aging_a.ages[i] != 0 && aging_b.ages[i] != 0;
  const TimeShift shift = find_time_shift(pair.shared_a, pair.shared_b, known, control);
  std::vector<float> values;
  ImageU8 mask(pair.shared_a.width, pair.shared_a.height);
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i] == 0) continue;
    values.push_back(shift.shift[i]);
    mask.data()[pair.shared_a.texels[i]] = 255;
  }
  Figure median{
      .name = "time_shift_median", .title = "How much later B ages, median of places", .unit = pair.time_unit};
  Figure spread{
      .name = "time_shift_spread", .title = "Half of what 68 % of the places differ by in it", .unit = pair.time_unit};
  Figure share{.name = "time_shift_known",
               .title = "Share of places that age visibly on both sides",
               .unit = "",
               .value = static_cast<double>(values.size()) / static_cast<double>(known.size())};
  if (values.empty()) {
    median.undefined = spread.undefined =
        "no place ages visibly on both sides (--visible-delta-e " + short_number_text(options.visible_delta_e) + ")";
  } else {
    std::sort(values.begin(), values.end());
    const auto at = [&](double s) {
      return static_cast<double>(
          values[std::min(values.size() - 1, static_cast<std::size_t>(s * static_cast<double>(values.size())))]);
    };
    median.value = at(0.5);
    spread.value = (at(0.84) - at(0.16)) / 2.0;
    const double reach =
        std::max({std::abs(at(0.02)), std::abs(at(0.98)), 1e-9 + 0.02 * (pair.a.times.back() - pair.a.times.front())});
    const std::string text = short_number_text(rounded(reach, 3)) + " " + pair.time_unit;
    section.pictures.push_back(
        {"time_shift",
         "Time shift: blue, B ages " + text + " earlier; white, together; orange, " + text + " later; gray, not known",
         with_legend(ramp_picture(pair.shared_a.value_image(shift.shift), mask, -reach, reach, ColorRamp::Diverging),
                     {.ramp = ColorRamp::Diverging, .low = -reach, .high = reach, .unit = pair.time_unit})});
  }
  for (Figure* f : {&median, &spread, &share}) section.figures.push_back(std::move(*f));
}

}  // namespace

std::vector<Figure> difference_figures(const ComparedPair& pair, const RunControl& control) {
  if (!pair.places_problem.empty()) return {};
  return figures_of(pixel_differences(pair.shared_a, pair.shared_b, control));
}

Section places_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "places",
                  .title = "Place by place",
                  .paragraphs = {},
                  .figures = {},
                  .curves = {},
                  .pictures = {},
                  .undefined = pair.places_problem};
  if (!section.undefined.empty()) return section;
  section.paragraphs.push_back("Equal pixels are taken to show equal places; " +
                               std::to_string(pair.shared_a.num_texels()) +
                               " texels are seen on both sides at every time.");
  const std::vector<PixelDifference> differences =
      pixel_differences(pair.shared_a, pair.shared_b, control.part(0.0, 0.4));
  add_differences(pair, differences, section);
  add_stated_noise(pair, options, control.part(0.4, 0.5), section);
  double top = 0.0;
  for (const PixelDifference& d : differences) top = std::max(top, d.ciede2000_p95);
  add_maps(pair, top, section);
  if (pair.a.num_times() < 2) {
    for (const char* name : {"warp_deviation", "residual_after_warp", "time_shift_median"}) {
      section.figures.push_back(
          {.name = name,
           .title = std::string(name) == "time_shift_median" ? "How much later B ages" : "The best common clock",
           .unit = pair.time_unit,
           .undefined = "there is only one common time"});
    }
    return section;
  }
  add_warp(pair, options, control.part(0.5, 0.7), section);
  add_shift(pair, options, control.part(0.7, 1.0), section);
  return section;
}

}  // namespace patinate::analysis
