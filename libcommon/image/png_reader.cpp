#include <png.h>

#include <array>
#include <bit>
#include <cctype>
#include <csetjmp>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

bool equal_but_for_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [&](char x, char y) { return lower(x) == lower(y); });
}

/// libpng on one file. libpng leaves a function of its own by longjmp() when something is wrong: what calls it here has
/// nothing on the stack that would have to be destroyed, and nothing that changes after setjmp() and is looked at
/// behind the jump.
class PngFile {
 public:
  explicit PngFile(const std::filesystem::path& path) : file_(std::fopen(path.c_str(), "rb")) {}
  ~PngFile() {
    close();
    if (file_ != nullptr) (void)std::fclose(file_);
  }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  [[nodiscard]] const char* problem() const { return problem_.data(); }
  [[nodiscard]] int width() const { return static_cast<int>(png_get_image_width(png_, info_)); }
  [[nodiscard]] int height() const { return static_cast<int>(png_get_image_height(png_, info_)); }
  [[nodiscard]] int channels() const { return png_get_channels(png_, info_); }
  [[nodiscard]] bool is_16_bit() const { return png_get_bit_depth(png_, info_) == 16; }
  [[nodiscard]] std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  [[nodiscard]] int row() const { return row_; }
  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }

  /// Reads up to the pixels, from the beginning of the file. @returns false if it cannot be read.
  [[nodiscard]] bool open() {
    close();
    if (file_ == nullptr || std::fseek(file_, 0, SEEK_SET) != 0) return false;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_ == nullptr) return false;
    info_ = png_create_info_struct(png_);
    if (info_ == nullptr) return false;
    return read_header();
  }

  /// The next row. @returns false if it cannot be read: problem() says why.
  [[nodiscard]] bool read_row(std::byte* to) {
    if (setjmp(png_jmpbuf(png_))) return false;  // NOLINT(cert-err52-cpp): libpng's way.
    png_read_row(png_, reinterpret_cast<png_bytep>(to), nullptr);
    ++row_;
    return true;
  }

 private:
  static void on_error(png_structp png, png_const_charp message) {
    auto* self = static_cast<PngFile*>(png_get_error_ptr(png));
    (void)std::snprintf(self->problem_.data(), self->problem_.size(), "%s", message);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep to, std::size_t size) {
    auto* self = static_cast<PngFile*>(png_get_io_ptr(png));
    if (std::fread(to, 1, size, self->file_) != size) png_error(png, "it ends early");
  }

  [[nodiscard]] bool read_header() {
    if (setjmp(png_jmpbuf(png_))) return false;  // NOLINT(cert-err52-cpp)
    png_set_read_fn(png_, this, on_read);
    png_read_info(png_, info_);
    png_set_expand(png_);  // 1, 2 and 4 bits become 8, palettes RGB, transparency alpha.
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  void close() {
    if (png_ != nullptr) png_destroy_read_struct(&png_, &info_, nullptr);
    png_ = nullptr;
    info_ = nullptr;
    row_ = 0;
  }

  std::FILE* file_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int row_ = 0;  ///< The next.
  std::array<char, 128> problem_{};
};

/// Reads the file's words; false if it says what OpenImageIO understands and this does not.
bool read_words(const PngFile& file, ImageInfo& info) {
  std::string key, description;
  png_textp texts = nullptr;
  const int num_texts = png_get_text(file.png(), file.info(), &texts, nullptr);
  constexpr std::array<std::string_view, 7> kElsewhere{
      "XML:com.adobe.xmp", "Raw profile type exif", "DateTime",        "Exif:DateTimeOriginal",
      "ImageDescription",  "FramesPerSecond",       kImageKeyAttribute};
  for (int i = 0; i < num_texts; ++i) {
    const std::string_view name = texts[i].key;
    if (equal_but_for_case(name, "Description")) {
      description = texts[i].text;
    } else if (name == kImageKeyAttribute) {
      key = texts[i].text;
    } else {
      for (std::string_view other : kElsewhere) {
        if (equal_but_for_case(name, other)) return false;
      }
    }
  }
  set_words(info, std::move(key), description);
  return true;
}

class PngSource final : public ImageSource {
 public:
  explicit PngSource(const std::filesystem::path& path) : path_(path), file_(path) {}

  [[nodiscard]] bool open() {
    if (!file_.open() || png_get_interlace_type(file_.png(), file_.info()) != PNG_INTERLACE_NONE) return false;
    png_uint_32 exif_size = 0;
    png_bytep exif = nullptr;
    if (png_get_eXIf_1(file_.png(), file_.info(), &exif_size, &exif) != 0) return false;
    if (png_get_image_width(file_.png(), file_.info()) > kMaxImageSide ||
        png_get_image_height(file_.png(), file_.info()) > kMaxImageSide)
      return false;
    info_.width = file_.width();
    info_.height = file_.height();
    static const std::array<std::vector<std::string>, 4> kNames{
        {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}};
    if (file_.channels() < 1 || file_.channels() > 4) return false;
    info_.channels = kNames[file_.channels() - 1];
    if (!read_words(file_, info_)) return false;
    const FileWords words = read_file_words(path_);
    if (!words.refusal.empty()) throw IoError(path_.string(), words.refusal);
    set_color_words(info_, words);
    return true;
  }

  [[nodiscard]] ImageInfo first_info() const override { return info_; }
  [[nodiscard]] int count_frames() override { return 1; }

  [[nodiscard]] CodedImage read(int frame) override {
    if (frame != 0) throw IoError(path_.string(), "has no image " + std::to_string(frame) + " that can be read");
    return read_rows(0, info_.height);
  }

  [[nodiscard]] CodedImage read_rows(int begin, int end) override {
    if (file_.row() > begin && !file_.open()) fail();
    CodedImage coded{info_.width,
                     end - begin,
                     file_.channels(),
                     file_.is_16_bit() ? CodedImage::Type::UInt16 : CodedImage::Type::UInt8,
                     -1,
                     {}};
    const std::size_t row_bytes = file_.row_bytes();
    coded.bytes.resize(row_bytes * static_cast<std::size_t>(end - begin));
    while (file_.row() < begin) read_row(coded.bytes.data());  // Over what is not asked for.
    for (int y = begin; y < end; ++y) read_row(coded.bytes.data() + row_bytes * static_cast<std::size_t>(y - begin));
    return coded;
  }

 private:
  void read_row(std::byte* to) {
    if (!file_.read_row(to)) fail();
  }
  [[noreturn]] void fail() {
    const std::string problem = file_.problem();
    (void)file_.open();  // libpng goes on nowhere behind an error.
    throw IoError(path_.string(), "is damaged or truncated (PNG read error: " + problem + ")");
  }

  std::filesystem::path path_;
  PngFile file_;
  ImageInfo info_;
};

}  // namespace

std::unique_ptr<ImageSource> open_png(const std::filesystem::path& path) {
  auto source = std::make_unique<PngSource>(path);
  return source->open() ? std::move(source) : nullptr;
}

}  // namespace patinate
