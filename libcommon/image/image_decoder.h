/// \file
/// Decoding of one image file in this process. Inside of image input only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "libcommon/image/decoded_image.h"
#include "patinate/image/image_io.h"

namespace patinate {

inline constexpr int kMaxImageSide = 65536;
inline constexpr int kMaxImageChannels = 64;
/// Limit of an image that is read as a whole: 4 GiB as floats, 16384 x 16384 pixels of four channels. Rows can be read
/// of larger ones.
inline constexpr std::uint64_t kMaxImageValues = std::uint64_t{1} << 30;
inline constexpr int kMaxImageFrames = 100'000;

/// Pixels in the type that the file stores, as small as they come.
struct CodedImage {
  enum class Type { UInt8, UInt16, Float };
  int width = 0;
  int height = 0;
  int channels = 0;
  Type type = Type::UInt8;
  int associated_alpha = -1;     ///< Channel that the others are multiplied by; -1 = none.
  std::vector<std::byte> bytes;  ///< Row by row.
};
[[nodiscard]] constexpr std::size_t bytes_per_value(CodedImage::Type type) {
  return type == CodedImage::Type::UInt8 ? 1 : type == CodedImage::Type::UInt16 ? 2 : 4;
}
/// Codes as values. `info` is that of the file. @throws IoError naming `path` if a value is NaN or infinite.
[[nodiscard]] DecodedImage decoded(const CodedImage& coded, const ImageInfo& info, const std::filesystem::path& path);

/// An open image file. Frames are cheap to read in order; going back may decode from the first one.
/// Pictures are upright: turned as their file's orientation says. Camera RAW is developed to linear Rec.709 light with
/// the camera's daylight white balance, no automatic exposure, and highlights clipped, so that equal light gives equal
/// values in every frame.
class ImageDecoder {
 public:
  /// @throws IoError if it is missing, empty, no image, or too large.
  explicit ImageDecoder(std::filesystem::path path);
  ~ImageDecoder();
  ImageDecoder(const ImageDecoder&) = delete;
  ImageDecoder& operator=(const ImageDecoder&) = delete;

  /// Facts of the file, with one frame.
  [[nodiscard]] ImageInfo first_info() const;
  /// Facts with the frames counted, which an animated file may have to be decoded for.
  [[nodiscard]] ImageInfo info();
  /// @throws IoError if there is no such frame, it is damaged, or has more than kMaxImageValues values, before any is
  /// decoded.
  [[nodiscard]] CodedImage read(int frame);
  /// Rows [begin, end) of the first image alone; cheap in order, for formats that are stored by rows.
  /// @throws IoError if they are not there or damaged.
  [[nodiscard]] CodedImage read_rows(int begin, int end);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
