/// \file
/// The pixels of a library: images of several histories side by side.
#pragma once

#include <span>

#include "patinate/image/image.h"
#include "transfer/library/library_layout.h"

namespace patinate::transfer {

/// An image of the library. What lies beside a history repeats its outermost pixels, so that its border looks to
/// filters as the border of an image does.
/// @param images  One a part, any channels (equal); of another size than its part: resampled (areas where it becomes
/// smaller, else bilinear).
/// @throws InvalidInput if their number is not that of the parts, or channels differ.
[[nodiscard]] ImageF lay_side_by_side(const LibraryLayout& layout, std::span<const ImageF> images);

/// Masks of the library: 0 beside the histories. A resampled pixel is inside when all that it is made of is. @throws
/// InvalidInput as above.
[[nodiscard]] ImageU8 lay_masks_side_by_side(const LibraryLayout& layout, std::span<const ImageU8> masks);

/// H x W x 1: the index of the part that a pixel belongs to; of what lies beside them, that of the nearest.
[[nodiscard]] ImageF library_index_image(const LibraryLayout& layout);

/// Color of the library at one of its frames: H x W x 3. A history's own frames as they are, to the bit; between them
/// HistoryReader::sample().
[[nodiscard]] ImageF library_frame(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                                   const LibraryFrame& frame);

/// Where the frames that make up a frame of the library show the surface.
[[nodiscard]] ImageU8 library_frame_mask(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                                         const LibraryFrame& frame);

/// A control of the library, normalized to its range.
[[nodiscard]] ImageF library_control(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                                     const LibraryControl& control);

/// Extras (kFrameExtraNames but stddev) of the library's frames: those that frames of any
/// history have.
[[nodiscard]] std::vector<std::string> library_extras(std::span<const HistoryReader> readers);
/// One of them at a frame of the library, as HistoryWriter::write_frame_extra() takes it: sample_material_map() of each
/// history, so that normals are in tangent space. Where a history does not know: normals stand upright, all else is 0.
[[nodiscard]] ImageF library_extra(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                                   const LibraryFrame& frame, const std::string& name);

}  // namespace patinate::transfer
