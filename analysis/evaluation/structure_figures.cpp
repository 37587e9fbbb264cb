#include "analysis/evaluation/structure_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>

#include "analysis/evaluation/source_lines.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr int kBins = static_cast<int>(ControlCounts{}.size());

constexpr int kScaleDigits = 4;  ///< Digits of sizes: rounding is no scale.

/// The source's nearest pixel for each texel of a plane.
template <class T>
Image<T> at_texels(const Image<T>& in, double pixels_per_texel) {
  if (in.empty() || pixels_per_texel == 1.0) return in;
  const auto length = [&](int n) { return std::max(1, static_cast<int>(std::floor(n / pixels_per_texel))); };
  const auto pixel = [&](int i, int n) {
    return std::clamp(static_cast<int>(std::floor((i + 0.5) * pixels_per_texel)), 0, n - 1);
  };
  Image<T> out(length(in.width()), length(in.height()));
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) out.at(x, y) = in.at(pixel(x, in.width()), pixel(y, in.height()));
  }
  return out;
}

using Structures = LineStructures;

/// One of the figures: how it is read from sums.
struct LineFigure {
  std::string name, title, unit, undefined;
  std::function<std::optional<double>(const LineStructure&)> value;
};

std::vector<LineFigure> figures_at(double texel_mm, bool has_quarters) {
  const double mm = texel_mm, mm2 = mm * mm;
  const auto over = [](double a, double b) { return b > 0.0 ? std::optional(a / b) : std::nullopt; };
  const auto times = [](std::optional<double> v, double f) { return v ? std::optional(*v * f) : std::nullopt; };
  std::vector<LineFigure> list = {{"line_share", "share of the area", "", "nothing is covered",
                                   [](const auto& s) { return std::optional(s.share()); }},
                                  {"dead_ends", "dead ends", "1/mm", "no lines are away from borders",
                                   [=](const auto& s) { return times(s.ends_per_px(), 1.0 / mm); }},
                                  {"closed_share", "area in closed cells", "", "nothing is covered",
                                   [](const auto& s) { return std::optional(s.closed_share()); }},
                                  {"line_length", "length", "mm/mm2", "nothing is covered",
                                   [=](const auto& s) { return over(s.length_px, s.surface_px * mm); }},
                                  {"median_cell", "closed cell, median", "mm2", "there are no closed cells",
                                   [=](const auto& s) { return times(s.median_cell_px(), mm2); }}};
  list.push_back({"junctions", "junctions", "1/mm2", "nothing is covered",
                  [=](const auto& s) { return over(static_cast<double>(s.num_junctions), s.surface_px * mm2); }});
  for (std::size_t q = 0; q < 4 && has_quarters; ++q) {
    list.push_back({"line_length_q" + std::to_string(q + 1),
                    "length where the control is in the source's quarter " + std::to_string(q + 1), "mm/mm2",
                    "no control is in that quarter",
                    [=](const auto& s) { return over(s.quarter_length_px[q], s.quarter_surface_px[q] * mm); }});
  }
  return list;
}

Figure one_figure(const std::string& name, const std::string& title, const LineFigure& f, std::optional<double> value,
                  std::optional<double> split) {
  return {.name = name,
          .title = title,
          .unit = f.unit,
          .value = value,
          .split = split,
          .undefined = value ? "" : f.undefined};
}

/// A factor of the source's figure by threshold.
using Factors = std::array<double, kNumLineThresholds>;
constexpr Factors kAsMeasured = {1.0, 1.0, 1.0};

/// Over thresholds at which both sides have a value, or else each over its own.
std::array<std::optional<double>, 2> means_of(const LineFigure& f, const Structures& a, const Structures& b,
                                              const Factors& of_b = kAsMeasured) {
  std::array<double, 4> sums = {};
  std::array<int, 4> counts = {};
  const auto add = [&](std::size_t to, double v) {
    sums[to] += v;
    ++counts[to];
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::optional<double> x = f.value(a[i]);
    std::optional<double> y = f.value(b[i]);
    if (y) *y *= of_b[i];
    if (x && y) {
      add(0, *x);
      add(1, *y);
    }
    if (x) add(2, *x);
    if (y) add(3, *y);
  }
  const auto mean = [&](std::size_t i) { return counts[i] > 0 ? std::optional(sums[i] / counts[i]) : std::nullopt; };
  return counts[0] > 0 ? std::array{mean(0), mean(1)} : std::array{mean(2), mean(3)};
}

/// By threshold: share of the area where lines are as frequent as in the source; nothing without controls.
using WantedShares = std::array<std::optional<double>, kNumLineThresholds>;

Figure wanted_figure(const std::string& prefix, const std::string& title, std::optional<double> value) {
  return {.name = prefix + "line_share_wanted",
          .title = title,
          .unit = "",
          .value = value,
          .undefined = value ? "" : "no control is known on both sides"};
}

std::optional<double> mean_of(const WantedShares& shares) {
  double sum = 0.0;
  for (const std::optional<double>& share : shares) {
    if (!share) return std::nullopt;
    sum += *share / static_cast<double>(shares.size());
  }
  return sum;
}

/// What the source's lines are expected to be for the controls of two sets of places.
struct ExpectedShares {
  WantedShares wanted;               ///< On the charts.
  Factors in_windows = kAsMeasured;  ///< In the surface's windows over in the source's.
};

void add_figures(const SourceLines& source, const LineSums& sums, const ExpectedShares& expected, double texel_mm,
                 bool has_quarters, StructureFigures& out) {
  const Structures &made = sums.made, &crops = sums.crops;
  const bool is_dark = source.kind == LineKind::Dark;
  const std::string prefix = is_dark ? "" : "bright_", kind = is_dark ? "Dark lines" : "Bright lines";
  std::string at;
  for (const double t : source.thresholds) at += (at.empty() ? "" : ", ") + short_number_text(t);
  const auto named = [&](const LineFigure& f, const std::string& suffix) { return prefix + f.name + suffix; };
  std::array<LineFigures, kNumLineThresholds> apart;
  for (std::size_t i = 0; i < apart.size(); ++i) apart[i] = {source.kind, source.thresholds[i], {}};
  for (const LineFigure& f : figures_at(texel_mm, has_quarters)) {
    const auto title = [&](const std::string& of, const std::string& where) {
      return kind + ", " + f.title + of + " (M11, " + where + " L*)";
    };
    const bool has_crops = f.name == "dead_ends" || f.name == "closed_share" || f.name == "median_cell";
    const bool has_windows = f.name == "line_share" || f.name == "dead_ends" || f.name == "closed_share";
    const std::string cut = " of the source cut to the same charts", across = " in windows across seams";
    const auto [value, split] = means_of(f, made, source.structures);
    out.figures.push_back(one_figure(named(f, ""), title("", "mean at " + at), f, value, split));
    if (has_crops)
      out.figures.push_back(
          one_figure(named(f, "_crops"), title(cut, "mean at " + at), f, means_of(f, crops, crops)[0], {}));
    const Factors& factors = f.name == "line_share" ? expected.in_windows : kAsMeasured;
    if (has_windows) {
      const auto [on_surface, in_source] = means_of(f, sums.windows, sums.source_windows, factors);
      out.figures.push_back(one_figure(named(f, "_surface"), title(across, "mean at " + at), f, on_surface, in_source));
    }
    const std::string as_wanted = " if they were as frequent as in the source where the same control is wanted";
    if (f.name == "line_share")
      out.figures.push_back(wanted_figure(prefix, title(as_wanted, "mean at " + at), mean_of(expected.wanted)));
    for (std::size_t i = 0; i < apart.size(); ++i) {
      const std::string where = short_number_text(source.thresholds[i]);
      apart[i].figures.push_back(
          one_figure(named(f, ""), title("", where), f, f.value(made[i]), f.value(source.structures[i])));
      if (has_crops)
        apart[i].figures.push_back(one_figure(named(f, "_crops"), title(cut, where), f, f.value(crops[i]), {}));
      if (has_windows) {
        std::optional<double> in_source = f.value(sums.source_windows[i]);
        if (in_source) *in_source *= factors[i];
        apart[i].figures.push_back(
            one_figure(named(f, "_surface"), title(across, where), f, f.value(sums.windows[i]), in_source));
      }
      if (f.name == "line_share")
        apart[i].figures.push_back(wanted_figure(prefix, title(as_wanted, where), expected.wanted[i]));
    }
  }
  out.lines.insert(out.lines.end(), apart.begin(), apart.end());
}

}  // namespace

ControlCounts count_wanted(const MapPart& part) {
  ControlCounts counts{};
  part.for_each_covered([&](TexelId, std::int64_t i) { ++counts[control_bin(part.control.data()[i])]; });
  return counts;
}

std::optional<double> wanted_share(const ImageU8& feature, const ImageF& control, const ImageU8& mask,
                                   const ControlCounts& wanted) {
  std::array<double, kBins> covered{}, area{};
  for (std::int64_t i = 0; i < feature.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const std::size_t bin = control_bin(control.data()[i]);
    area[bin] += 1.0;
    covered[bin] += feature.data()[i] != 0 ? 1.0 : 0.0;
  }
  double num_texels = 0.0, sum = 0.0;
  for (int b = 0; b < kBins; ++b) {
    const auto asked = static_cast<double>(wanted[b]);
    if (asked == 0.0) continue;
    num_texels += asked;
    int nearest = -1;
    for (int other = 0; other < kBins; ++other) {
      if (area[other] == 0.0) continue;
      if (nearest < 0 || std::abs(other - b) < std::abs(nearest - b)) nearest = other;
    }
    if (nearest < 0) return std::nullopt;
    const auto n = static_cast<std::size_t>(nearest);
    sum += asked * covered[n] / area[n];
  }
  return num_texels > 0.0 ? std::optional(sum / num_texels) : std::nullopt;
}

void LineSums::add(const LineSums& other) {
  for (std::size_t i = 0; i < kNumLineThresholds; ++i) {
    made[i] += other.made[i];
    crops[i] += other.crops[i];
    windows[i] += other.windows[i];
    source_windows[i] += other.source_windows[i];
    lines_there[i] += other.lines_there[i];
    lines_found[i] += other.lines_found[i];
  }
}

void StructureSums::add(const StructureSums& other) {
  if (kinds.size() < other.kinds.size()) kinds.resize(other.kinds.size());
  for (std::size_t i = 0; i < other.kinds.size(); ++i) kinds[i].add(other.kinds[i]);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] += other.wanted[i];
    windows_control[i] += other.windows_control[i];
    source_windows_control[i] += other.source_windows_control[i];
  }
}

struct SourceStructure::Found {
  const SynthesisSource& source;
  double pixels_per_texel;
  LineScale scale;
  bool has_quarters = false;
  std::array<float, 3> ends = {};  ///< Ends of the control's quarters.
  ImageF lightness;                ///< Lightness of the source's own pixels.
  Ground ground;                   ///< The source at the texels' size.
  ImageF control;                  ///< Control of the source's own pixels.
  std::vector<SourceLines> kinds;

  Found(const SynthesisSource& from, double pixels) : source(from), pixels_per_texel(pixels), scale(pixels) {}
};

SourceStructure::SourceStructure(const SynthesisSource& source, double texel_size_px, bool has_wanted,
                                 const RunControl& control) {
  const double pixels_per_texel = rounded(texel_size_px, kScaleDigits);
  auto found = std::make_unique<Found>(source, pixels_per_texel);
  found->has_quarters = !source.control.empty() && has_wanted;
  if (found->has_quarters) {
    found->ends = quarters_of(source.control, source.mask);
    found->control = at_texels(source.control, pixels_per_texel);
  }
  found->lightness = lightness_of(source.frames.back());
  const ImageU8 quarter = found->has_quarters ? in_quarters(source.control, found->ends) : ImageU8();
  found->ground = {.lightness = at_texels(found->lightness, pixels_per_texel),
                   .mask = at_texels(source.mask, pixels_per_texel),
                   .quarter = at_texels(quarter, pixels_per_texel)};
  for (const LineKind kind : {LineKind::Dark, LineKind::Bright}) {
    if (auto lines = lines_of(found->ground, kind, found->scale, control)) found->kinds.push_back(std::move(*lines));
  }
  found_ = std::move(found);
}

SourceStructure::~SourceStructure() = default;

StructureSums SourceStructure::measure(const MapPart& part, const PartCounts& before, const PartCounts& all,
                                       std::vector<Picture>& pictures, const RunControl& control) const {
  StructureSums sums;
  if (found_->has_quarters) sums.wanted = count_wanted(part);
  if (found_->kinds.empty()) return sums;
  const ImageF lightness = part.looked_up(found_->lightness), no_control;
  const std::vector<Ground> charts =
      charts_of(part, lightness, found_->has_quarters ? in_quarters(part.control, found_->ends) : ImageU8());
  const SurfaceWindows windows = cut_windows(part, lightness,
                                             {.lightness = found_->lightness,
                                              .mask = found_->source.mask,
                                              .control = found_->has_quarters ? found_->source.control : no_control,
                                              .pixels_per_texel = found_->pixels_per_texel},
                                             before, all, control);
  sums.windows_control = windows.made_control;
  sums.source_windows_control = windows.source_control;
  for (const SourceLines& lines : found_->kinds) {
    const CutSource cut =
        measured_crops(charts, before.charts, all.charts, found_->ground, lines, found_->scale, control);
    sums.kinds.push_back({.made = measured(charts, lines, found_->scale, control),
                          .crops = cut.structures,
                          .windows = measured(windows.made, lines, found_->scale, control),
                          .source_windows = measured(windows.source, lines, found_->scale, control),
                          .lines_there = cut.there,
                          .lines_found = cut.found});
    pictures.push_back(line_picture(charts, lines, part.rect, found_->scale, control));
  }
  return sums;
}

StructureFigures SourceStructure::figures(const StructureSums& sums, double texel_mm) const {
  StructureFigures out;
  for (std::size_t k = 0; k < found_->kinds.size(); ++k) {
    const SourceLines& lines = found_->kinds[k];
    const LineSums made = k < sums.kinds.size() ? sums.kinds[k] : LineSums{};
    ExpectedShares expected;
    for (std::size_t i = 0; i < expected.wanted.size() && found_->has_quarters; ++i) {
      const auto share = [&](const ControlCounts& at) {
        return wanted_share(lines.masks[i], found_->control, found_->ground.mask, at);
      };
      expected.wanted[i] = share(sums.wanted);
      if (expected.wanted[i] && made.lines_there[i] > 0)
        *expected.wanted[i] *= static_cast<double>(made.lines_found[i]) / static_cast<double>(made.lines_there[i]);
      const std::optional<double> asked = share(sums.windows_control), there = share(sums.source_windows_control);
      if (asked && there && *there > 0.0) expected.in_windows[i] = *asked / *there;
    }
    add_figures(lines, made, expected, texel_mm, found_->has_quarters, out);
  }
  const bool has_dark = !out.lines.empty() && out.lines.front().kind == LineKind::Dark;
  if (has_dark) return out;
  std::vector<Figure> none;
  for (const LineFigure& f : figures_at(texel_mm, false)) {
    none.push_back({.name = f.name,
                    .title = "Dark lines, " + f.title + " (M11)",
                    .unit = f.unit,
                    .undefined = out.lines.empty() ? "the source has no lines" : "the source has no dark lines"});
  }
  out.figures.insert(out.figures.begin(), none.begin(), none.end());
  return out;
}

}  // namespace patinate::analysis
