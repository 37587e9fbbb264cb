/// \file
/// The fall-off of a lamp over the picture: from a photograph of a uniform surface, or from the photographs themselves.
#pragma once

#include <functional>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Linear light that is neither black nor saturated says something of the lamp.
inline constexpr float kBlackField = 0.001f, kWhiteField = 0.96f;

struct FlatFieldOptions {
  int order = 4;  ///< [1, 6]. Degree of the polynomial in x and y that stands for the logarithm of the light.
  double smoothing_share =
      0.01;  ///< [0, 0.5]. Gaussian over a photograph of a uniform surface, in shorter sides, against its noise.
};
void describe(OptionVisitor& v, FlatFieldOptions& o);

/// Gain that makes a uniform surface uniform: mean / blurred(light), per channel, so that its mean stays.
/// @param light  H x W x 3, linear: a uniform surface under the same lamp.
/// @returns H x W x 3, within [1/50, 50]. @throws InvalidInput if an option is out of range or a channel is black.
[[nodiscard]] ImageF flat_field_from_image(const ImageF& light, const FlatFieldOptions& options = {},
                                           const RunControl& control = {});

/// Estimates the gain without such a photograph: a polynomial is fitted to the median over time of each pixel's log
/// luminance, robustly (Tukey weights), so that grains, crystals and streaks that stand out of the slow fall-off do not
/// count. What the surface itself does slowly over the whole picture cannot be told from the lamp.
/// @param read_frame  Frame i as H x W x 3, linear. At most 32 evenly spaced frames are read, one at a time.
/// @param mask  Of the frames' view, at any size; 0 = ignored, what lies around the surface says nothing about the
/// lamp. May be empty.
/// @returns width x height x 1, the same for all channels, within [1/50, 50]. Outside the mask it is kept within the
/// range that it has inside.
/// @throws InvalidInput if num_frames < 1, an option is out of range, or more than half of the pixels inside the mask
/// are black or saturated.
[[nodiscard]] ImageF estimate_flat_field(int num_frames, const std::function<ImageF(int)>& read_frame,
                                         const ImageU8& mask, const FlatFieldOptions& options = {},
                                         const RunControl& control = {});

/// mean / light, within [1/50, 50].
[[nodiscard]] float bounded_gain(double mean, double light);
/// Whether a mask of any size has all of pixel (x, y) of a picture of width x height pixels; an empty one has all.
[[nodiscard]] bool has_whole_pixel(const ImageU8& mask, int x, int y, int width, int height);

/// Multiplies by a gain of one or as many channels. @throws InvalidInput if sizes differ.
void apply_gain(ImageF& image, const ImageF& gain);

}  // namespace patinate::capture
