/// \file
/// Movies and camera RAW made at test time: plain bytes of known pixels.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::testing_support {

/// Uncompressed AVI (24 bit). @param frames  RGB, all of one size; the width a multiple of 4.
void write_avi(const std::filesystem::path& file, const std::vector<ImageU8>& frames, int frames_per_second);
/// An animated GIF or WebP, as the extension says, through OpenImageIO. @returns false if it cannot write that format.
bool write_animation(const std::filesystem::path& file, const std::vector<ImageU8>& frames);
/// Uncompressed DNG with an RGGB mosaic of a camera whose primaries are those of Rec.709.
/// @param linear  H x W x 3 in [0, 1]; even size.
void write_dng(const std::filesystem::path& file, const ImageF& linear);

}  // namespace patinate::testing_support
