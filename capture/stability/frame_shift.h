/// \file
/// How far a photograph is shifted against another one of the same scene.
#pragma once

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// A photograph made ready for comparison: what stays of it when lighting and exposure change. See prepare_frame().
struct PreparedFrame {
  ImageF detail;  ///< h x w x 1: encoded luminance less its local mean; its longer side is at most kPreparedSide.
  ImageF light;   ///< About 128 pixels on the longer side x 3: linear color, for exposure and change.
  double scale_x = 1.0;  ///< Pixels of the photograph for one of `detail`.
  double scale_y = 1.0;
};
inline constexpr int kPreparedSide = 1024;  ///< px (docs/algorithms/stability.md).

/// @param color  H x W x 3, linear, finite.
[[nodiscard]] PreparedFrame prepare_frame(const ImageF& color, const RunControl& control = {});

enum class ShiftStatus {
  Measured,   ///< One shift explains most of the picture.
  NotGlobal,  ///< A best shift exists, but too few parts of the picture follow it: content moved, not the camera.
  NoTexture,  ///< Nothing to compare.
};
[[nodiscard]] const char* shift_status_text(ShiftStatus status);

struct FrameShift {
  double x = 0.0;  ///< x_in_frame = x_in_reference + x, pixels of the photograph; positive = content moved right.
  double y = 0.0;  ///< Positive = content moved down.
  double agreement = 0.0;  ///< Share of the picture's textured parts that follow it, [0, 1].
  double peak = 0.0;       ///< Height of the correlation's peak: 1 = the frames are equal but for the shift.
  ShiftStatus status = ShiftStatus::NoTexture;
};

/// Shift by phase correlation [Kuglin and Hines 1975], between pixels from the peak's shape [Foroosh et al. 2002],
/// checked part by part.
///
/// The cross-power spectrum of the two windowed frames is whitened, with a Gaussian weight against noise, so that its
/// transform is a Gaussian at the shift: a parabola through the logarithms around the maximum finds its center. A
/// second round compares only what both frames show. Then the picture is cut into 6 x 6 parts; a part follows the shift
/// s when s explains it better than -s does (both interpolate alike, so that blur favours neither). A camera moves all
/// parts; growth does not.
/// @param reference,frame  Prepared from photographs of one size. @throws InvalidInput if sizes differ.
/// Precision: 0.05 px of `detail` on textured scenes. Largest shift: a quarter of each side. Same bits for any number
/// of threads.
[[nodiscard]] FrameShift measure_shift(const PreparedFrame& reference, const PreparedFrame& frame);

}  // namespace patinate::capture
