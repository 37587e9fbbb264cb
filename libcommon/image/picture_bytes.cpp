#include "libcommon/image/picture_bytes.h"

#include <string>
#include <vector>

#include "libcommon/image/image_source.h"

namespace patinate {

namespace {

EncodedFormat bare_format(const ImageU8& codes, const char* name) {
  return {.name = name,
          .width = codes.width(),
          .height = codes.height(),
          .channels = std::vector<std::string>(static_cast<std::size_t>(codes.channels())),
          .has_facts = false,
          .is_srgb = true};
}

}  // namespace

std::string png_of(const ImageU8& codes) {
  EncodedFormat format = bare_format(codes, "picture.png");
  format.png_level = 4;
  return encoded(format, codes.data());
}

std::string jpeg_of(const ImageU8& codes, int quality) {
  EncodedFormat format = bare_format(codes, "picture.jpg");
  format.jpeg_quality = quality;
  return encoded(format, codes.data());
}

}  // namespace patinate
