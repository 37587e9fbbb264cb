/// \file
/// Smoothing and resampling of float images. Same bits for any number of threads.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// Exact Gaussian, separable, cut at 4 sigma; at the border the weights inside the image are brought to sum 1.
/// @param in        H x W x C, finite.
/// @param sigma_px  >= 0, finite; 0 copies.
/// @throws InvalidInput if sigma_px is out of range.
/// Cost: O(H W C sigma_px).
[[nodiscard]] ImageF gaussian_blur(const ImageF& in, double sigma_px, const RunControl& control = {});

/// Normalized convolution [Knutsson and Westin 1993]: sum of G in over pixels inside `mask` / sum of G over them. What
/// lies outside the mask has no influence. 0 where no pixel of the mask is within 4 sigma.
/// @param mask  H x W, 0 = outside; may be empty (everything inside).
/// @throws InvalidInput if sizes differ or sigma_px is out of range.
[[nodiscard]] ImageF gaussian_blur(const ImageF& in, const ImageU8& mask, double sigma_px,
                                   const RunControl& control = {});

/// Every output pixel is the mean of `in` over the rectangle that it covers: constants and (at whole factors) means
/// stay.
/// @param width,height  in [1, in.width()] and [1, in.height()]. @throws InvalidInput
[[nodiscard]] ImageF downscale_area(const ImageF& in, int width, int height, const RunControl& control = {});

/// Bilinear interpolation; pixel edges of both images coincide, so x_in = (x_out + 0.5) W_in / W_out - 0.5, clamped to
/// the outermost pixel centers. @param width,height  >= 1. @throws InvalidInput
[[nodiscard]] ImageF resize_bilinear(const ImageF& in, int width, int height, const RunControl& control = {});

/// The pixels [x, x + width) x [y, y + height). @throws InvalidInput if they are not all in the image.
template <class T>
[[nodiscard]] Image<T> crop(const Image<T>& in, int x, int y, int width, int height);

/// Two values of the sorted list of values inside `mask` (nearest rank, no interpolation).
struct Percentiles {
  float low = 0.0f;
  float high = 0.0f;
};
/// @param in    H x W x 1. @param mask  may be empty.
/// @param low,high  ranks in [0, 1], low <= high. @throws InvalidInput if out of range or the mask covers nothing.
[[nodiscard]] Percentiles percentiles(const ImageF& in, const ImageU8& mask, double low, double high);

extern template ImageF crop(const ImageF&, int, int, int, int);
extern template ImageU8 crop(const ImageU8&, int, int, int, int);

}  // namespace patinate
