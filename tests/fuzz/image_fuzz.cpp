#include <array>
#include <cmath>
#include <cstdint>

#include "libcommon/image/image_decoder.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// The first byte chooses the file name's extension.
PATINATE_FUZZ_TARGET(image) {
  static constexpr std::array<const char*, 6> kNames{"a.png", "a.exr", "a.jpg", "a.tif", "a.gif", "a.webp"};
  if (bytes.empty()) return;
  const auto file = fuzz::fuzz_file(kNames[bytes[0] % kNames.size()], bytes.subspan(1));
  const ImageInfo info = probe_image(file);
  fuzz::require(info.width > 0 && info.height > 0, "an image has a size");
  const auto num_values =
      static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height) * info.channels.size();
  if (num_values > kMaxImageValues) {
    bool is_refused = false;
    try {
      (void)read_color(file);
    } catch (const IoError&) {
      is_refused = true;
    }
    fuzz::require(is_refused, "what is too large to be decoded is refused by its header");
  }
  if (std::int64_t{info.width} * info.height > 1 << 20) return;  // Decoding large images finds nothing new.
  const ImageF color = read_color(file);
  for (float v : color.values()) fuzz::require(std::isfinite(v), "colors are finite");
  (void)read_gray(file);
  (void)read_mask(file);
}
