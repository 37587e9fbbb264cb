#include <cstring>

#include "libcommon/image/decoder_wire.h"
#include "patinate/core/error.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// Answers of a decoder that has gone wrong.
PATINATE_FUZZ_TARGET(decoder_answer) {
  std::size_t at = 0;
  const WireRead read = [&](void* to, std::size_t size) {
    if (size > bytes.size() - at) throw IoError("decoder", "ends in the middle of an answer");
    std::memcpy(to, bytes.data() + at, size);
    at += size;
  };
  const ImageInfo info = read_info(read);
  fuzz::require(info.width > 0 && info.height > 0 && !info.channels.empty(), "an image has a size and channels");
  const CodedImage coded = read_coded(read);
  fuzz::require(coded.bytes.size() == static_cast<std::size_t>(coded.width) * static_cast<std::size_t>(coded.height) *
                                          static_cast<std::size_t>(coded.channels) * bytes_per_value(coded.type),
                "a frame has all of its bytes");
  (void)decoded(coded, info, "answer");
}
