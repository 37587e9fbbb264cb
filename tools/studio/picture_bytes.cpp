#include "tools/studio/picture_bytes.h"

#include <xxhash.h>

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "libcommon/image/image_source.h"

namespace patinate::studio {

namespace {

EncodedFormat format_of(const ImageU8& codes, const char* name) {
  return {.name = name,
          .width = codes.width(),
          .height = codes.height(),
          .channels = std::vector<std::string>(static_cast<std::size_t>(codes.channels())),
          .has_facts = false,
          .is_srgb = true};
}

}  // namespace

std::string png_of(const ImageU8& codes) {
  EncodedFormat format = format_of(codes, "picture.png");
  format.png_level = 4;
  return encoded(format, codes.data());
}

std::string jpeg_of(const ImageU8& codes, int quality) {
  EncodedFormat format = format_of(codes, "picture.jpg");
  format.jpeg_quality = quality;
  return encoded(format, codes.data());
}

std::string xxh64(std::string_view bytes) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH64(bytes.data(), bytes.size(), 0)));
  return text.data();
}

}  // namespace patinate::studio
