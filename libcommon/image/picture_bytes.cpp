#include "libcommon/image/picture_bytes.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>
// Wants cstdio first.
#include <jpeglib.h>

#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// libjpeg into memory. A page's pictures do not go through image/media_module.h, whose libraries take longer to load
/// (0.25 s) than most commands take to run.
class JpegBytes {
 public:
  JpegBytes() {
    jpeg_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = [](j_common_ptr jpeg) { std::longjmp(reinterpret_cast<Errors*>(jpeg->err)->back, 1); };
    errors_.base.output_message = [](j_common_ptr) {};
  }
  ~JpegBytes() {
    jpeg_destroy_compress(&jpeg_);
    std::free(bytes_);  // NOLINT(cppcoreguidelines-no-malloc): libjpeg's.
  }
  JpegBytes(const JpegBytes&) = delete;
  JpegBytes& operator=(const JpegBytes&) = delete;

  /// libjpeg leaves it by longjmp(): it has nothing to destroy.
  [[nodiscard]] bool write(const ImageU8& codes, int quality) {
    if (setjmp(errors_.back) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg's way.
    jpeg_create_compress(&jpeg_);
    jpeg_mem_dest(&jpeg_, &bytes_, &size_);
    jpeg_.image_width = static_cast<JDIMENSION>(codes.width());
    jpeg_.image_height = static_cast<JDIMENSION>(codes.height());
    jpeg_.input_components = codes.channels();
    jpeg_.in_color_space = codes.channels() == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&jpeg_);
    jpeg_set_quality(&jpeg_, quality, TRUE);
    jpeg_start_compress(&jpeg_, TRUE);
    const std::size_t row_bytes = static_cast<std::size_t>(codes.width()) * static_cast<std::size_t>(codes.channels());
    while (jpeg_.next_scanline < jpeg_.image_height) {
      JSAMPROW row = const_cast<JSAMPROW>(codes.data() + jpeg_.next_scanline * row_bytes);
      (void)jpeg_write_scanlines(&jpeg_, &row, 1);
    }
    jpeg_finish_compress(&jpeg_);
    return true;
  }
  [[nodiscard]] std::string bytes() const { return {reinterpret_cast<const char*>(bytes_), size_}; }

 private:
  struct Errors {
    jpeg_error_mgr base{};
    std::jmp_buf back{};
  };
  jpeg_compress_struct jpeg_{};
  Errors errors_;
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

std::string png_of(const ImageU8& codes) {
  const EncodedFormat format{.name = "picture.png",
                             .width = codes.width(),
                             .height = codes.height(),
                             .channels = std::vector<std::string>(static_cast<std::size_t>(codes.channels())),
                             .has_facts = false,
                             .is_srgb = true,
                             .png_level = 4};
  return encoded(format, codes.data());
}

std::string jpeg_of(const ImageU8& codes, int quality) {
  JpegBytes jpeg;
  if (!jpeg.write(codes, quality)) throw CannotComplete("picture.jpg: cannot be written; is there enough memory?");
  return jpeg.bytes();
}

}  // namespace patinate
