#include <png.h>
#include <zlib.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <string>
#include <utility>

#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// The bytes of OpenImageIO's writer, whose settings these are.
class PngEncoder final : public ImageEncoder {
 public:
  PngEncoder(const EncodedFormat& format, ByteSink& sink)
      : format_(format), sink_(sink), description_(kImageKeyDescription + format.key) {
    if (format_.channels.empty() || format_.channels.size() > 4) {
      fail("PNG only supports 1-4 channels, not " + std::to_string(format_.channels.size()));
    }
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    const bool is_begun = info_ != nullptr && begin();
    if (!is_begun) {
      destroy();
      fail(problem_.data());
    }
  }
  ~PngEncoder() override { destroy(); }
  PngEncoder(const PngEncoder&) = delete;
  PngEncoder& operator=(const PngEncoder&) = delete;

  void write(int num_rows, const void* values) override {
    if (!write_rows(num_rows, static_cast<png_const_bytep>(values))) fail(problem_.data());
  }
  void finish() override {
    if (!end()) fail(problem_.data());
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw CannotComplete(format_.name + ": cannot be written; " +
                         (problem.empty() ? "is there enough memory?" : problem));
  }

  // libpng leaves the next three by longjmp(): they have nothing to destroy.
  [[nodiscard]] bool begin() {
    if (setjmp(png_jmpbuf(png_))) return false;  // NOLINT(cert-err52-cpp): libpng's way.
    png_set_write_fn(png_, this, on_write, on_flush);
    png_set_compression_level(png_, format_.png_level);
    png_set_compression_strategy(png_, Z_DEFAULT_STRATEGY);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_NO_FILTERS);
    constexpr std::array<int, 4> kTypes{PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                        PNG_COLOR_TYPE_RGB_ALPHA};
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(format_.width), static_cast<png_uint_32>(format_.height), 8,
                 kTypes[format_.channels.size() - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_oFFs(png_, info_, 0, 0, PNG_OFFSET_PIXEL);
    if (!format_.has_facts && format_.is_srgb) png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_ABSOLUTE);
    set_words();
    png_write_info(png_, info_);
    return true;
  }
  [[nodiscard]] bool write_rows(int num_rows, png_const_bytep codes) {
    if (setjmp(png_jmpbuf(png_))) return false;  // NOLINT(cert-err52-cpp)
    const std::size_t row_bytes = static_cast<std::size_t>(format_.width) * format_.channels.size();
    for (int y = 0; y < num_rows; ++y) png_write_row(png_, codes + static_cast<std::size_t>(y) * row_bytes);
    return true;
  }
  [[nodiscard]] bool end() {
    if (setjmp(png_jmpbuf(png_))) return false;  // NOLINT(cert-err52-cpp)
    png_write_end(png_, info_);
    return true;
  }

  void set_words() {
    png_text texts[3] = {};
    int num_texts = 0;
    const auto add = [&](const char* name, const char* text) {
      texts[num_texts].compression = PNG_TEXT_COMPRESSION_NONE;
      texts[num_texts].key = const_cast<char*>(name);
      texts[num_texts++].text = const_cast<char*>(text);
    };
    if (!format_.has_facts) {
      if (format_.is_srgb) add("oiio:ColorSpace", "sRGB");  // OpenImageIO's own name for what sRGB, gAMA and cHRM say.
    } else {
      const png_time none{1970, 1, 1, 0, 0, 0};
      png_set_tIME(png_, info_, &none);
      add("Software", kImageSoftware);
      if (!format_.key.empty()) {
        add(kImageKeyAttribute, format_.key.c_str());
        add("Description", description_.c_str());
      }
    }
    if (num_texts > 0) png_set_text(png_, info_, texts, num_texts);
  }

  void destroy() {
    if (png_ != nullptr) png_destroy_write_struct(&png_, &info_);
  }

  static void on_error(png_structp png, png_const_charp message) {
    auto* self = static_cast<PngEncoder*>(png_get_error_ptr(png));
    (void)std::snprintf(self->problem_.data(), self->problem_.size(), "PNG write error: %s", message);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_write(png_structp png, png_bytep bytes, std::size_t size) {
    auto* self = static_cast<PngEncoder*>(png_get_io_ptr(png));
    self->sink_.write(self->offset_, bytes, size);
    self->offset_ += static_cast<std::int64_t>(size);
  }
  static void on_flush(png_structp) {}

  EncodedFormat format_;
  ByteSink& sink_;
  std::string description_;
  std::int64_t offset_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::array<char, 128> problem_{};
};

}  // namespace

std::unique_ptr<ImageEncoder> create_png_encoder(const EncodedFormat& format, ByteSink& sink) {
  return std::make_unique<PngEncoder>(format, sink);
}

}  // namespace patinate
