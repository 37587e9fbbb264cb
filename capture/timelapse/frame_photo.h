/// \file
/// Frames' photographs where the reference photograph has them. Inside of ingest only.
#pragma once

#include <filesystem>

#include "capture/timelapse/ingest_work.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// For work inside of one frame: frames run side by side already.
[[nodiscard]] RunControl one_thread();

/// 255 where a photograph is opaque; empty when it is everywhere. Of the photograph's size. @throws IoError
[[nodiscard]] ImageU8 opaque_part(const CapturePhoto& photo);

/// A frame's photograph before the roi is cut out; of a hand-held series where the reference has it. @throws IoError
[[nodiscard]] ImageF read_frame_whole(const IngestWork& work, int index, const std::filesystem::path& folder);

/// The roi of a photograph of a series that is_handheld(): linear color where the reference has it.
/// @param image  As large as the photograph, any channels.
/// @param shown  Becomes 255 where the photograph shows the place, else 0.
[[nodiscard]] ImageF lay_in_roi(const IngestWork& work, int index, const std::filesystem::path& folder,
                                const ImageF& image, ImageU8& shown);
/// Likewise of any part of the reference; of a fixed camera's photographs that part itself, and shown all over.
[[nodiscard]] ImageF lay_in_rectangle(const IngestWork& work, int index, const std::filesystem::path& folder,
                                      const ImageF& image, const PixelRectangle& part, ImageU8& shown);
/// A frame's photograph as a chart says that it shows; as it was taken without one. Before it is laid over another.
[[nodiscard]] ImageF read_colored_photo(const IngestWork& work, int index, const std::filesystem::path& folder);
/// Multiplies a frame's colors by light_gain().
void apply_light_gain(const IngestWork& work, int index, const std::filesystem::path& folder, ImageF& color);
/// Takes off `shown`, of the roi, what is transparent in the photograph.
void keep_opaque(const IngestWork& work, int index, const std::filesystem::path& folder, ImageU8& shown);

/// The roi of a frame in linear color, for looking at it. What a photograph of a hand-held series does not show is
/// taken from the reference photograph, in this one's exposure: there it differs from no other.
/// @throws IoError
[[nodiscard]] ImageF read_frame_roi(const IngestWork& work, int index, const std::filesystem::path& folder);

}  // namespace patinate::capture
