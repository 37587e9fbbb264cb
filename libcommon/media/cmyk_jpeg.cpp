#include "libcommon/media/cmyk_jpeg.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
// Wants cstdio first.
#include <jpeglib.h>

#include "patinate/core/error.h"

namespace patinate::media {

namespace {

/// libjpeg on one file. It leaves a function of its own by longjmp() when something is wrong: what calls it here has
/// nothing on the stack that would have to be destroyed.
class CmykJpeg {
 public:
  explicit CmykJpeg(const std::filesystem::path& path) : file_(std::fopen(path.c_str(), "rb")) {
    jpeg_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = [](j_common_ptr jpeg) {
      auto* errors = reinterpret_cast<Errors*>(jpeg->err);
      errors->base.format_message(jpeg, errors->text.data());
      std::longjmp(errors->back, 1);
    };
    errors_.base.output_message = [](j_common_ptr) {};
    jpeg_create_decompress(&jpeg_);
  }
  ~CmykJpeg() {
    jpeg_destroy_decompress(&jpeg_);
    if (file_ != nullptr) (void)std::fclose(file_);
  }
  CmykJpeg(const CmykJpeg&) = delete;
  CmykJpeg& operator=(const CmykJpeg&) = delete;

  [[nodiscard]] bool open() {
    if (file_ == nullptr || setjmp(errors_.back) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg's way.
    jpeg_stdio_src(&jpeg_, file_);
    (void)jpeg_read_header(&jpeg_, TRUE);
    jpeg_.out_color_space = JCS_CMYK;
    (void)jpeg_start_decompress(&jpeg_);
    return jpeg_.output_components == 4;
  }
  [[nodiscard]] bool read_row(std::byte* to) {
    if (setjmp(errors_.back) != 0) return false;  // NOLINT(cert-err52-cpp)
    auto* row = reinterpret_cast<JSAMPROW>(to);
    return jpeg_read_scanlines(&jpeg_, &row, 1) == 1;
  }
  [[nodiscard]] int width() const { return static_cast<int>(jpeg_.output_width); }
  [[nodiscard]] int height() const { return static_cast<int>(jpeg_.output_height); }
  [[nodiscard]] bool is_inverted() const { return jpeg_.saw_Adobe_marker != 0; }
  [[nodiscard]] bool has_loss() const { return errors_.base.num_warnings > 0; }
  [[nodiscard]] const char* problem() const { return errors_.text.data(); }

 private:
  struct Errors {
    jpeg_error_mgr base{};
    std::jmp_buf back{};
    std::array<char, JMSG_LENGTH_MAX> text{};
  };
  std::FILE* file_;
  jpeg_decompress_struct jpeg_{};
  Errors errors_;
};

}  // namespace

CodedImage read_cmyk_jpeg(const std::filesystem::path& path) {
  CmykJpeg jpeg(path);
  const auto fail = [&] {
    throw IoError(path.string(), std::string("is damaged or truncated (") + jpeg.problem() + ")");
  };
  if (!jpeg.open()) fail();
  CodedImage inks{jpeg.width(), jpeg.height(), 4, CodedImage::Type::UInt8, -1, {}};
  const std::size_t row = 4 * static_cast<std::size_t>(inks.width);
  inks.bytes.resize(row * static_cast<std::size_t>(inks.height));
  for (int y = 0; y < inks.height; ++y) {
    if (!jpeg.read_row(inks.bytes.data() + row * static_cast<std::size_t>(y))) fail();
  }
  if (jpeg.has_loss()) fail();
  if (jpeg.is_inverted())
    std::transform(inks.bytes.begin(), inks.bytes.end(), inks.bytes.begin(), [](std::byte b) { return ~b; });
  return inks;
}

}  // namespace patinate::media
