#include <algorithm>
#include <string>

#include "libcommon/core/file_name.h"
#include "libcommon/image/image_source.h"
#include "libcommon/image/media_module.h"

namespace patinate {

std::unique_ptr<ImageEncoder> create_encoder(const EncodedFormat& format, ByteSink& sink) {
  const std::string extension = lower_extension(format.name);
  const bool is_coded = format.values == EncodedFormat::Values::Codes;
  if (extension == ".png" && is_coded) return create_png_encoder(format, sink);
  if (extension == ".exr" && !is_coded) return create_exr_encoder(format, sink);
  return media_module().create_encoder(format, sink);
}

std::string encoded(const EncodedFormat& format, const void* values) {
  MemorySink sink;
  const std::unique_ptr<ImageEncoder> encoder = create_encoder(format, sink);
  encoder->write(format.height, values);
  encoder->finish();
  return std::move(sink.bytes);
}

}  // namespace patinate
