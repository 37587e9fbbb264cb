#include "patinate/datasets/panel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>

#include "datasets_synthetic/panel_frame.h"
#include "datasets_synthetic/panel_look.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate::datasets {

namespace {

constexpr int kMinTestSide = 8;        ///< Pixels.
constexpr double kWhite = 1.0 + 1e-6;  ///< L* = 100, but for rounding.

/// @throws InvalidInput if the paint is no color that a photograph holds.
void check_color(const std::string& option, const std::array<double, 3>& lab) {
  const std::array<double, 3> rgb = linear_from_lab(lab);
  for (const double value : rgb) {
    if (value >= 0.0 && value <= kWhite) continue;
    throw InvalidInput(option + ": L*a*b* " + number_text(lab[0]) + ", " + number_text(lab[1]) + ", " +
                       number_text(lab[2]) + " is outside of sRGB; use a paler color");
  }
}

/// Mean of straight lines between the values, which are 0 at both ends.
double mean_of(const std::vector<double>& profile) {
  return std::accumulate(profile.begin(), profile.end(), 0.0) / static_cast<double>(profile.size() - 1);
}

double percent(std::int64_t part, double all) { return 100.0 * static_cast<double>(part) / all; }

/// Shares of rust, and of rust with the scribe.
void add_rust(PanelFigures& figures, const PanelLayout& layout, const PanelMarks& marks) {
  const PanelOptions& o = layout.options;
  const double all = static_cast<double>(o.width) * o.height * kSamplesPerPixel;
  const auto in_test = static_cast<double>(layout.test_area.num_samples());
  SampleImage samples = marks.rust.samples;
  figures.rust_percent = percent(count_samples(samples), all);
  figures.rust_test_percent = percent(count_samples(samples, layout.test_area), in_test);
  if (marks.scribe) {
    for (std::size_t i = 0; i < samples.values().size(); ++i) samples.values()[i] |= marks.scribe->samples.values()[i];
  }
  figures.rusted_percent = percent(count_samples(samples), all);
  figures.rusted_test_percent = percent(count_samples(samples, layout.test_area), in_test);
}

}  // namespace

void describe(OptionVisitor& v, PanelOptions& o) {
  v.visit({"width", "Width of the photographs, which the panel fills", "px", between(32, 8192)}, o.width);
  v.visit({"height", "Height of the photographs", "px", between(32, 8192)}, o.height);
  v.visit({"pixel", "Length on the panel that a pixel shows", "mm", above(0)}, o.pixel_mm);
  v.visit({"num_frames", "Photographs over time, the first before exposure", "", between(2, 10000)}, o.num_frames);
  v.visit({"hours", "Time of exposure", "h", above(0)}, o.hours);
  v.visit({"edge", "Band along the panel's edges that is not part of the test area", "mm", at_least(0)}, o.edge_mm);
  v.visit_choice({"pattern", "How rust is distributed, as ASTM D610 tells it"}, o.pattern, kRustPatternNames);
  v.visit({"rust", "Rusted area at the end, of the test area", "%", between(0, 60)}, o.rust);
  v.visit({"spot", "Mean diameter of rust spots at the end; not given: 3, 1.5 or 0.5 by pattern", "mm", above(0)},
          o.spot_mm);
  v.visit({"edge_rust", "Rusted area at the end of the band along the edges, of the band", "%", between(0, 60)},
          o.edge_rust);
  v.visit({"stains", "Area at the end that rust-colored stains tint, of the test area", "%", between(0, 40)}, o.stains);
  v.visit({"scribe", "Cut through the paint from which corrosion creeps"}, o.scribe);
  v.visit({"cross", "Cut a second scribe across the first"}, o.cross);
  v.visit({"creep", "Mean creep at the end from each side of the scribe", "mm", at_least(0)}, o.creep_mm);
  v.visit({"cracks", "Length of cracks at the end in each square millimeter", "mm/mm2", between(0, 2)},
          o.crack_density);
  v.visit({"crack_width", "Mean width of cracks", "mm", above(0)}, o.crack_width_mm);
  v.visit({"paint", "L*, a*, b* of the paint before exposure", "", between(-128, 128)}, std::span<double>(o.paint));
  v.visit({"color_change", "Change of L*, a*, b* until the end", "", between(-128, 128)},
          std::span<double>(o.color_change));
  v.visit({"roughness", "Roughness of the paint's gloss before exposure", "", between(0.05, 1)}, o.roughness);
  v.visit({"roughness_end", "Roughness of the paint's gloss at the end", "", between(0.05, 1)}, o.roughness_end);
  v.visit({"blur", "Standard deviation of the lens's blur", "px", between(0, 10)}, o.blur_px);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

void check_panel(const PanelOptions& o) {
  check_ranges(o);
  const double side_mm = std::min(o.width_mm(), o.height_mm()) - 2.0 * o.edge_mm;
  if (!(side_mm >= kMinTestSide * o.pixel_mm)) {
    throw InvalidInput("edge: " + number_text(o.edge_mm) + " mm leave no test area on a panel of " +
                       number_text(o.width_mm()) + " x " + number_text(o.height_mm()) + " mm; use less");
  }
  if (o.cross && !o.scribe) throw InvalidInput("cross: needs a scribe");
  if (o.edge_rust > 0.0 && !(o.edge_mm > 0.0)) throw InvalidInput("edge_rust: needs an edge wider than 0 mm");
  check_color("paint", o.paint);
  check_color("color_change", paint_lab(o, o.hours));
}

PanelFigures panel_figures(const PanelLayout& layout, const PanelMarks& marks, double hours) {
  const PanelOptions& o = layout.options;
  const auto in_test = static_cast<double>(layout.test_area.num_samples());
  PanelFigures figures{.hours = hours, .paint = paint_lab(o, hours)};
  figures.roughness = o.roughness + hours / o.hours * (o.roughness_end - o.roughness);
  add_rust(figures, layout, marks);
  if (!marks.stain.empty()) figures.stain_test_percent = stained_percent(marks.stain, layout.test_area);
  if (!marks.cracks.empty()) {
    figures.crack_mm_per_mm2 = crack_length(layout.cracks, o, hours) / o.test_area_mm2();
    figures.crack_area_percent = percent(count_samples(marks.cracks, layout.test_area), in_test);
  }
  const double grown = mark_growth(hours, 0.0, o.hours);
  for (const PanelScribe& scribe : layout.scribes) {
    const double part = grown / static_cast<double>(layout.scribes.size());
    figures.creep_left_mm += part * mean_of(scribe.left_mm);
    figures.creep_right_mm += part * mean_of(scribe.right_mm);
    figures.creep_max_mm = std::max(figures.creep_max_mm, grown * largest_creep(scribe));
  }
  return figures;
}

PanelFrame panel_frame(const PanelLayout& layout, int frame, const RunControl& control) {
  const PanelOptions& o = layout.options;
  const double hours = o.hour(frame);
  PanelMarks marks = marks_at(layout, hours, control.silent());
  PanelFrame out;
  out.photo = panel_photo(panel_light(layout, marks, hours, control.silent()), o, frame, control.silent());
  out.rust = sample_shares(marks.rust.samples);
  if (marks.scribe) out.scribe = sample_shares(marks.scribe->samples);
  if (!marks.cracks.empty()) out.cracks = sample_shares(marks.cracks);
  out.figures = panel_figures(layout, marks, hours);
  out.stain = std::move(marks.stain);
  return out;
}

std::vector<PanelSpot> panel_spots(const PanelLayout& layout) {
  const double mm = layout.options.pixel_mm;
  std::vector<PanelSpot> spots;
  for (const SpotOutline& spot : layout.spots)
    spots.push_back({mm * spot.x_px, mm * spot.y_px, mm * mm * spot.area_px2(), spot.start_h, spot.is_edge});
  return spots;
}

ImageF test_area_shares(const PanelLayout& layout) {
  ImageF out(layout.options.width, layout.options.height);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) out.at(x, y) = static_cast<float>(sample_share(layout.test_area.at(x, y)));
  }
  return out;
}

Panel make_panel(const PanelOptions& options, const RunControl& control) {
  PanelLayout layout = lay_out_panel(options, control);
  Panel panel{.options = options, .spots = panel_spots(layout), .cracks = layout.cracks, .scribes = layout.scribes};
  panel.test_area = test_area_shares(layout);
  for (int i = 0; i < options.num_frames; ++i) {
    panel.frames.push_back(panel_frame(layout, i, control));
    control.report(static_cast<double>(i + 1) / options.num_frames);
  }
  return panel;
}

}  // namespace patinate::datasets
