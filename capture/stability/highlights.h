/// \file
/// Pixels that show the lamp and not the surface: saturated ones, and the highlight of a flash that stands still.
#pragma once

#include <functional>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct HighlightOptions {
  double width_share = 0.25;  ///< (0, 1]. A highlight is narrower than this share of the picture's shorter side; wider
                              ///< is white material.
  double extent = 0.2;  ///< [0, 1]. A highlight reaches as far as it keeps this share of its height above the ground.
  double core_rise = 2.0;  ///< > 1. A highlight's core is so many times as bright as what is usual around it, and
                           ///< nearly saturated.
};
void describe(OptionVisitor& v, HighlightOptions& o);

/// Pixels of a photograph that are saturated in any channel (with a pixel around them where they are more than specks),
/// unless they are white material, whose color is known well enough:
/// - a wide white area: where at least 60 % of a window (of width_share) is saturated, the window's saturated pixels
/// and
///   what is connected to them are material or a white background;
/// - specks where the middle value of the brightest channel around them is at least 1/1.3 of the level: the brightest
///   grains of a bright texture;
/// - patches (1.6 % of the shorter side across or more) where besides that 15 % of what lies beside them, as far as
/// they
///   are wide, are at least 0.93 of the level, cracks left out. A lamp's reflection ends in darker material.
/// @param photo  H x W x C, linear. @param level  Value that counts as saturated; infinity = none does.
/// @returns H x W, 255 = saturated. @throws InvalidInput if an option is out of range.
[[nodiscard]] ImageU8 find_saturated(const ImageF& photo, float level, const HighlightOptions& options = {});

/// The highlight of a lamp that moves with the camera: it stands at one place of the picture from the first frame on,
/// is brighter than the material around it, and its core is clipped. Whatever grows there later (white crystals) does
/// not count, nor what is as wide as width_share, nor white material.
///
/// Seen is the darkest that each pixel is in the first 3 % of the frames (at least two; of one the one). ground = what
/// is usual: the median luminance of a window twice as wide as width_share, or the blurred opening by width_share where
/// that is brighter. The core lies core_rise above the ground and near saturation in every channel, is 1.6 % of the
/// shorter side across (wet grains glint in smaller spots), and is no wide white area (find_saturated()); around it,
/// connected pixels belong to the highlight that keep `extent` of the core's height above the ground. Where those reach
/// farther than a width, they are not the highlight's skirt but material, and more of the height is asked for. A core
/// of which less than half is clipped must have a skirt of a quarter of its half width: white paint ends sharply.
/// @param read_frame  Frame i, H x W x 3, linear. At most 16 are read, one at a time.
/// @param saturation  Value of a saturated channel, usually 1.
/// @returns H x W, 255 = highlight. @throws InvalidInput if num_frames < 1 or an option is out of range.
[[nodiscard]] ImageU8 find_standing_highlight(int num_frames, const std::function<ImageF(int)>& read_frame,
                                              float saturation, const HighlightOptions& options = {},
                                              const RunControl& control = {});

}  // namespace patinate::capture
