/// \file
/// Pictures of a relit ingest's report: linear, at most 480 pixels wide. Inside of ingest only.
#pragma once

#include "patinate/image/image.h"

namespace patinate::capture {

/// The color, made smaller.
[[nodiscard]] ImageF report_albedo(const ImageF& color);
/// What became of every sample, one picture a light side by side, in sample_state_color().
/// @param samples  H x W x L of SampleState; empty for ready-made albedo. @param mask  Of what is determined.
[[nodiscard]] ImageF report_samples(const ImageU8& samples, const ImageU8& mask);
/// Standard deviation over albedo: black 0, white 10 % or more; red where nothing is determined.
/// @param surface  Where there is surface.
[[nodiscard]] ImageF report_stddev(const ImageF& albedo, const ImageF& stddev, const ImageU8& surface);

}  // namespace patinate::capture
