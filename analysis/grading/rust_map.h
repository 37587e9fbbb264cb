/// \file
/// Where a surface rusts, from photographs over time: rust appears, stays, and has a color of its own; a stain that
/// runs from it is translucent. Areas count parts of pixels, so that blur changes no area.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "analysis/grading/grade_rules.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Photographs of one surface in the order of their times.
struct GradedFrames {
  int num_frames = 0;
  std::function<ImageF(int)> color = {};  ///< H x W x 3, linear; called by one thread.
  ImageU8 mask = {};                      ///< H x W, 0 = not the surface, at any time.
  /// The frame that shows the surface before it was exposed; without one the commonest color around each place stands
  /// for it.
  std::optional<int> unexposed = 0;
};

struct RustSpot {
  double x = 0.0, y = 0.0;  ///< Center, pixels.
  double area_px = 0.0;     ///< With parts of pixels.
  double edge_px = 0.0;     ///< Pixels along its edge.
  bool is_sure = true;      ///< Its color is nearer to rust than to a stain.
};

/// One photograph.
struct RustFrame {
  ImageF coverage;              ///< H x W, share of each pixel that is rust, <= 1; by noise it may be a little below 0.
  std::vector<int> labels;      ///< W x H: which spot each share belongs to, -1 = none.
  std::vector<RustSpot> spots;  ///< At least `least_area_px` large.
};

/// Opacity of rust at every pixel and time, of which spots are made.
class RustMap {
 public:
  /// Reads every frame once or twice. Memory: two bytes a pixel and frame. Cost: linear in both.
  /// @throws InvalidInput if the mask is empty everywhere, or a frame has another size.
  RustMap(const GradedFrames& frames, const RustRule& rule, const RunControl& control = {});

  [[nodiscard]] RustFrame at(int frame) const;
  /// Linear color that most rust has in the end; nothing where there is none.
  [[nodiscard]] const std::optional<std::array<double, 3>>& rust_color() const { return rust_color_; }

 private:
  [[nodiscard]] double opacity(int frame, std::size_t pixel) const;
  void find_rust_color(const ImageF& color, const ImageF& background);
  void find_noise();
  void find_onsets();
  /// Spots whose blurred image never reaches a half. @param steps  From the spots that `out` has.
  void add_faint_spots(int frame, const std::vector<int>& steps, RustFrame& out) const;

  RustRule rule_;
  int width_ = 0, height_ = 0, num_frames_ = 0;
  ImageU8 mask_;
  std::optional<std::array<double, 3>> rust_color_;
  std::vector<std::uint8_t> opacity_;     ///< Frame by frame.
  std::vector<std::uint8_t> is_colored_;  ///< Frame by frame: has the color of rust.
  std::vector<double> noise_;             ///< Standard deviation of opacities, by frame.
  std::vector<std::uint16_t> onset_;      ///< First frame with rust; num_frames = never.
};

}  // namespace patinate::analysis
