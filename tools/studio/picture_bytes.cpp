#include "tools/studio/picture_bytes.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <xxhash.h>

#include <array>
#include <memory>

#include "patinate/core/error.h"

namespace patinate::studio {

namespace {

std::string encoded(const ImageU8& codes, const std::string& name, const OIIO::ImageSpec& spec) {
  OIIO::Filesystem::IOVecOutput bytes;
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(name, &bytes);
  if (!out || !out->open(name, spec) || !out->write_image(OIIO::TypeDesc::UINT8, codes.data()) || !out->close()) {
    throw CannotComplete("a picture could not be encoded: " + (out ? out->geterror() : OIIO::geterror()));
  }
  return {bytes.buffer().begin(), bytes.buffer().end()};
}

OIIO::ImageSpec spec_of(const ImageU8& codes) {
  OIIO::ImageSpec spec(codes.width(), codes.height(), codes.channels(), OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  return spec;
}

}  // namespace

std::string png_of(const ImageU8& codes) {
  OIIO::ImageSpec spec = spec_of(codes);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("png:compressionLevel", 4);
  return encoded(codes, "picture.png", spec);
}

std::string jpeg_of(const ImageU8& codes, int quality) {
  OIIO::ImageSpec spec = spec_of(codes);
  spec.attribute("Compression", "jpeg:" + std::to_string(quality));
  return encoded(codes, "picture.jpg", spec);
}

std::string xxh64(std::string_view bytes) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH64(bytes.data(), bytes.size(), 0)));
  return text.data();
}

}  // namespace patinate::studio
