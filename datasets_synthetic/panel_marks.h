/// \file
/// What marks a coated panel, as shapes of known area and length: spots of rust, a scribe with what creeps from it, and
/// cracks. Places are in pixels from the picture's upper left corner.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "datasets_synthetic/sample_cover.h"
#include "patinate/core/run_control.h"
#include "patinate/datasets/panel.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// Share of a mark's final extent that it has at a time: ((t - start) / (end - start))^0.6, between growth at an even
/// rate and growth that diffusion slows; 0 before.
[[nodiscard]] double mark_growth(double hours, double start_h, double end_h);

/// r(angle) = radius * (1 + sum over k = 2, 3, ... of Re(bends[k - 2] e^(i k angle))).
struct SpotOutline {
  static constexpr int kNumBends = 8;
  double x_px = 0.0;
  double y_px = 0.0;
  double radius_px = 0.0;  ///< At the end.
  std::array<std::complex<double>, kNumBends> bends{};
  double start_h = 0.0;
  bool is_edge = false;
  double reach = 1.0;  ///< Largest r / radius, or more.
  double slope = 1.0;  ///< Bound of how steeply the radius of an outline of this shape changes from place to place.

  /// pi radius^2 (1 + sum |bends|^2 / 2), of the end.
  [[nodiscard]] double area_px2() const;
};
/// An outline whose bends come from the stream; without a place and a radius.
[[nodiscard]] SpotOutline bent_outline(std::uint64_t seed, std::uint64_t item);

/// Marks of one kind at a time.
struct Marks {
  SampleImage samples = {};
  ImageF inside_px = {};  ///< How deep a pixel's center lies inside of marks; <= 0 where it lies in none. May be empty.
};

/// Spots of one kind at a time. @param scale  Factor of all radii. @param wants_inside  Makes `inside_px`, too.
[[nodiscard]] Marks draw_spots(const std::vector<SpotOutline>& spots, const PanelOptions& o, bool is_edge, double hours,
                               double scale, bool wants_inside, const RunControl& control);

/// Scribes at the test area's middle: none, one a few degrees from upright, or two that cross. Their creep is uneven,
/// and tapers off at their ends.
[[nodiscard]] std::vector<PanelScribe> make_scribes(const PanelOptions& o);
/// Largest creep of both sides at the end, mm.
[[nodiscard]] double largest_creep(const PanelScribe& scribe);
/// The cuts and what has crept from them. @param scribes  At least one.
[[nodiscard]] Marks draw_scribes(const std::vector<PanelScribe>& scribes, const PanelOptions& o, double hours,
                                 const RunControl& control);

/// Cracks that wander through the test area; they end at the panel's edges. Their length within the test area at the
/// end is the one asked for.
[[nodiscard]] std::vector<PanelCrack> make_cracks(const PanelOptions& o);
/// Length within the test area at a time, mm.
[[nodiscard]] double crack_length(const std::vector<PanelCrack>& cracks, const PanelOptions& o, double hours);
[[nodiscard]] SampleImage draw_cracks(const std::vector<PanelCrack>& cracks, const PanelOptions& o, double hours);

/// Whether a place lies in the test area.
[[nodiscard]] bool in_test_area(const PanelOptions& o, const Vec2& place_mm);

}  // namespace patinate::datasets
