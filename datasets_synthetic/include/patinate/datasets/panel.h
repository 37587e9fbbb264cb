/// \file
/// A coated steel panel in an exposure test whose rust, stains, cracks, creep, color and gloss are known at every
/// photograph: the truth for grades of ISO 4628 and ASTM D610.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// How rust is distributed [ASTM D610-08, sec. 4].
enum class RustPattern {
  Spot,     ///< Large spots in a few places.
  General,  ///< Spots of many sizes anywhere.
  Pinpoint  ///< Small specks of one size anywhere.
};
inline constexpr std::array<std::string_view, 3> kRustPatternNames{"spot", "general", "pinpoint"};

/// Settings of make_panel(). The panel fills the photographs: width x height pixels of pixel_mm. Its test area is what
/// lies at least edge_mm from its edges.
struct PanelOptions {
  int width = 600;        ///< [32, 8192].
  int height = 400;       ///< [32, 8192].
  double pixel_mm = 0.1;  ///< Length on the panel that a pixel shows; > 0.
  int num_frames = 9;     ///< Photographs at equal intervals, the first before exposure; [2, 10000].
  double hours = 480.0;   ///< From the first photograph to the last; > 0.
  double edge_mm = 10.0;  ///< >= 0; leaves a test area of at least 8 x 8 pixels.
  RustPattern pattern = RustPattern::General;
  double rust = 1.0;                ///< Rusted area at the end, percent of the test area; [0, 60].
  std::optional<double> spot_mm{};  ///< Mean diameter of spots at the end; > 0. Nothing: 3, 1.5 or 0.5, by pattern.
  double edge_rust = 0.0;           ///< Edge rust on what is not test area, at the end, percent of that; [0, 60].
  double stains = 0.0;              ///< Share of the test area that rust-colored stains tint, percent; [0, 40].
  bool scribe = false;              ///< A cut through the paint, 0.5 mm wide and 0.9 times the test area's height long.
  bool cross = false;               ///< A second cut of that length across it; each 40 degrees from upright.
  double creep_mm = 2.0;            ///< Mean corrosion at the end beside the scribe, each side; >= 0.
  double crack_density = 0.0;       ///< Length of cracks at the end, mm per mm2 of the test area; [0, 2].
  double crack_width_mm = 0.2;      ///< Mean width of cracks; > 0.
  std::array<double, 3> paint{78.0, -2.0, 4.0};       ///< L*, a*, b* of the paint before exposure.
  std::array<double, 3> color_change{2.0, 0.0, 3.0};  ///< Until the end; chalking raises L*, yellowing b*.
  double roughness = 0.15;                            ///< GGX of the paint's gloss before exposure; [0.05, 1].
  double roughness_end = 0.35;                        ///< And at the end.
  double blur_px = 0.7;   ///< Standard deviation of the lens's blur, of linear light; [0, 10].
  double noise = 0.005;   ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;  ///< >= 0.

  [[nodiscard]] double width_mm() const { return width * pixel_mm; }
  [[nodiscard]] double height_mm() const { return height * pixel_mm; }
  [[nodiscard]] double test_area_mm2() const { return (width_mm() - 2.0 * edge_mm) * (height_mm() - 2.0 * edge_mm); }
  [[nodiscard]] double hour(int frame) const { return frame * hours / (num_frames - 1); }
};
void describe(OptionVisitor& v, PanelOptions& o);
/// Ranges, and what must hold between options. @throws InvalidInput
void check_panel(const PanelOptions& options);

/// A rust spot. Places are mm right of and below the panel's upper left corner.
struct PanelSpot {
  double x_mm = 0.0;
  double y_mm = 0.0;
  double area_mm2 = 0.0;  ///< Area of the outline at the end, in closed form; outlines may overlap and leave the panel.
  double start_h = 0.0;   ///< From then on its radius grows as (t - start)^0.6.
  bool is_edge = false;   ///< Edge rust, of which only what lies outside the test area is drawn.
};

struct PanelCrack {
  std::vector<Vec2> points_mm;  ///< At the end; it grows from the first one on.
  double length_mm = 0.0;       ///< At the end.
  double width_mm = 0.0;
  double start_h = 0.0;
};

/// The cut, and how far corrosion creeps from its sides at the end.
struct PanelScribe {
  Vec2 from_mm = Vec2::Zero();
  Vec2 to_mm = Vec2::Zero();
  double width_mm = 0.0;
  double step_mm = 0.0;         ///< Between values of the profiles, along the cut from `from_mm` on.
  std::vector<double> left_mm;  ///< Beyond the cut's edge, left of the way from `from_mm` to `to_mm` as seen.
  std::vector<double> right_mm;
};

/// Figures of a photograph. Areas are sums of coverage before blur and noise: 64 samples a pixel.
struct PanelFigures {
  double hours = 0.0;
  double rust_percent = 0.0;         ///< Spots and edge rust, of the whole panel.
  double rust_test_percent = 0.0;    ///< Of the test area.
  double rusted_percent = 0.0;       ///< The same with the scribe and what has crept from it.
  double rusted_test_percent = 0.0;  ///< Of the test area.
  double stain_test_percent = 0.0;  ///< Share of the test area where stains hide at least kVisibleStain, rusted or not.
  double crack_mm_per_mm2 = 0.0;    ///< Of the test area.
  double crack_area_percent = 0.0;  ///< Of the test area.
  double creep_left_mm = 0.0;       ///< Mean over the length of the scribe, or of both.
  double creep_right_mm = 0.0;
  double creep_max_mm = 0.0;  ///< Largest creep of both sides.
  std::array<double, 3>
      paint{};             ///< L*, a*, b* of the mean linear light of the test area's paint, without marks on it.
  double roughness = 0.0;  ///< GGX of its gloss.
  static constexpr double kVisibleStain = 0.1;
  static constexpr double kF0 = 0.05;  ///< Reflectance of its gloss at normal incidence.
};

/// One photograph and what is on the panel then, before blur and noise; all H x W.
struct PanelFrame {
  ImageU8 photo;  ///< 3 channels, sRGB.
  ImageF rust;    ///< Share of each pixel that spots and edge rust cover.
  ImageF scribe;  ///< Share that scribes and what has crept from them cover; empty without a scribe.
  ImageF stain;   ///< Opacity of stains, [0, 1); empty without stains.
  ImageF cracks;  ///< Share of each pixel that cracks cover; empty without cracks.
  PanelFigures figures;
};

/// The panel over time.
struct Panel {
  PanelOptions options;
  std::vector<PanelSpot> spots;
  std::vector<PanelCrack> cracks;
  std::vector<PanelScribe> scribes;  ///< None, one, or two that cross.
  ImageF test_area = {};             ///< Share of each pixel that lies in the test area.
  std::vector<PanelFrame> frames = {};
};

/// Makes the panel. Spots are drawn as outlines r(angle), with a start and a size each, whose sizes are scaled until
/// the union covers what was asked for at the end. Same bytes for any number of threads. Cost: about 0.2 s for 600 x
/// 400 pixels and 9 photographs.
/// @throws InvalidInput if options do not fit.
[[nodiscard]] Panel make_panel(const PanelOptions& options, const RunControl& control = {});

}  // namespace patinate::datasets
