#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/file_words.h"
#include "libcommon/image/image_source.h"
#include "libcommon/image/media_module.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

namespace fs = std::filesystem;

/// A link to the file whose name has only the extension in common. @throws CannotComplete
fs::path link_to(const fs::path& path, const fs::path& folder) {
  const std::string extension = path.extension().string();
  fs::path link = folder / "image";
  if (extension.find('?') == std::string::npos) link += extension;
  std::error_code error;
  fs::create_symlink(fs::absolute(path), link, error);
  if (error) throw CannotComplete(link.string() + ": cannot be made; " + error.message());
  return link;
}

/// The first channels of each pixel.
CodedImage first_channels(const CodedImage& image, int count) {
  CodedImage part{image.width, image.height, count, image.type, -1, {}};
  const std::size_t from = static_cast<std::size_t>(image.channels) * bytes_per_value(image.type),
                    to = static_cast<std::size_t>(count) * bytes_per_value(image.type),
                    num_pixels = image.bytes.size() / from;
  part.bytes.resize(num_pixels * to);
  for (std::size_t i = 0; i < num_pixels; ++i)
    std::memcpy(part.bytes.data() + i * to, image.bytes.data() + i * from, to);
  return part;
}

/// Codes of 16 bits whose largest value is another than 65535, as if it were that.
void scale_codes_to_full(CodedImage& coded, int largest_value) {
  constexpr double kLargest = 65535.0;
  for (std::size_t i = 0; i + 1 < coded.bytes.size(); i += 2) {
    std::uint16_t code = 0;
    std::memcpy(&code, &coded.bytes[i], sizeof code);
    code = static_cast<std::uint16_t>(std::lround(std::min(kLargest, kLargest / largest_value * code)));
    std::memcpy(&coded.bytes[i], &code, sizeof code);
  }
}

void divide_light(CodedImage& coded, double exposure) {
  for (std::size_t i = 0; i + sizeof(float) <= coded.bytes.size(); i += sizeof(float)) {
    float value = 0.0f;
    std::memcpy(&value, &coded.bytes[i], sizeof value);
    value = static_cast<float>(static_cast<double>(value) / exposure);
    std::memcpy(&coded.bytes[i], &value, sizeof value);
  }
}

/// L*, a* and b* from shares of a TIFF's largest code, in place [TIFF 6.0, section 23; for ICC L*a*b* Adobe's TIFF
/// technical notes of 2002].
void make_lab(ImageF& values, bool is_icc, bool is_16_bit) {
  const double largest = is_16_bit ? 65535.0 : 255.0, unit = is_16_bit ? 256.0 : 1.0;
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    float* v = values.data() + 3 * i;
    const double full_light = is_icc && is_16_bit ? 65280.0 : largest;
    v[0] = static_cast<float>(100.0 * static_cast<double>(v[0]) * largest / full_light);
    for (int c = 1; c < 3; ++c) {
      const double code = static_cast<double>(v[c]) * largest / unit;
      v[c] = static_cast<float>(is_icc ? code - 128.0 : code >= 128.0 ? code - 256.0 : code);
    }
  }
}

class WordedSource final : public ImageSource {
 public:
  explicit WordedSource(const fs::path& path) : path_(path) {
    fs::path name = path;
    // OpenImageIO takes what follows a question mark for options: such a file is opened by another name for it.
    if (path.string().find('?') != std::string::npos) {
      alias_.emplace(fs::temp_directory_path(), "patinate_image");
      name = link_to(path, alias_->path());
    }
    if (const auto whole = tga_with_whole_palette(path)) {
      if (!alias_) alias_.emplace(fs::temp_directory_path(), "patinate_image");
      name = alias_->path() / "palette.tga";
      write_atomically(name, *whole);
    }
    try {
      source_ = media_module().open_image(path, name, false);
    } catch (const IoError&) {
      if (const FileWords words = read_file_words(path); !words.refusal.empty())
        throw IoError(path.string(), words.refusal);
      throw;
    }
    stored_ = source_->first_info();
    if (stored_.is_raw || is_decoded_apart(path)) return;
    words_ = read_file_words(path);
    if (!words_.refusal.empty()) throw IoError(path.string(), words_.refusal);
    if (words_.icc.empty()) words_.icc = source_->profile();
    model_ = source_->color_model();
    if (model_ == ColorModel::Cmyk) inks_ = color_of_cmyk_profile(words_.icc);
    // CMYK without a profile is left to OpenImageIO.
    is_converted_ = model_ != ColorModel::Rgb && (model_ != ColorModel::Cmyk || inks_.encoding != nullptr);
    if (!is_converted_) return;
    source_ = media_module().open_image(path, name, true);
  }

  [[nodiscard]] ImageInfo first_info() const override {
    ImageInfo info = stored_;
    if (info.is_raw || is_decoded_apart(path_)) return info;
    if (has_unused_alpha()) {
      info.channels.pop_back();
      info.facts.alpha = "not used: " + words_.unused_alpha;
    }
    if (info.date_time.empty()) info.date_time = words_.xmp_original;
    if (info.digitized.empty()) info.digitized = words_.xmp_digitized;
    info.facts.orientation = words_.turn;
    if (info.facts.page.empty()) info.facts.page = words_.page;
    info.frame_times_s = words_.frame_times_s;
    FileWords words = words_;
    if (model_ != ColorModel::Rgb) words.icc.clear();
    set_color_words(info, words);
    if (model_ == ColorModel::Cmyk) {
      info.facts.color = inks_.encoding != nullptr ? inks_.name : "CMYK without a profile, taken as (1 - C)(1 - K)";
      if (!inks_.problem.empty()) info.facts.problem = inks_.problem + " and is not used";
    } else if (model_ != ColorModel::Rgb) {
      info.facts.color = "CIE L*a*b*";
    }
    if (is_converted_) {
      info.channels = {"R", "G", "B"};
      info.is_integer = false;
    }
    if (words_.exposure != 1.0)
      info.facts.color += (info.facts.color.empty() ? "light divided by its EXPOSURE " : ", divided by its EXPOSURE ") +
                          short_number_text(words_.exposure);
    if (words_.largest_value)
      info.facts.color +=
          (info.facts.color.empty() ? "codes up to " : ", codes up to ") + std::to_string(*words_.largest_value);
    return info;
  }

  [[nodiscard]] int count_frames() override { return source_->count_frames(); }
  [[nodiscard]] CodedImage read(int frame) override { return as_said(source_->read(frame)); }
  [[nodiscard]] CodedImage read_rows(int begin, int end) override { return as_said(source_->read_rows(begin, end)); }
  [[nodiscard]] int orientation() const override {
    return words_.orientation != 1 ? words_.orientation : source_->orientation();
  }

 private:
  [[nodiscard]] bool has_unused_alpha() const {
    return !words_.unused_alpha.empty() && stored_.channels.size() > 1 && stored_.channels.back() == "A";
  }

  [[nodiscard]] CodedImage as_said(CodedImage coded) const {
    if (is_converted_) return converted(coded);
    if (has_unused_alpha()) coded = first_channels(coded, coded.channels - 1);
    if (words_.exposure != 1.0 && coded.type == CodedImage::Type::Float) divide_light(coded, words_.exposure);
    if (words_.largest_value && coded.type == CodedImage::Type::UInt16)
      scale_codes_to_full(coded, *words_.largest_value);
    return coded;
  }

  /// Converts what is no RGB to linear Rec. 709.
  [[nodiscard]] CodedImage converted(const CodedImage& coded) const {
    const int num_channels = model_ == ColorModel::Cmyk ? 4 : 3;
    if (coded.channels < num_channels) throw IoError(path_.string(), "has fewer channels than its kind of color");
    ImageInfo plain;
    plain.channels.resize(num_channels);
    ImageF values = decoded(first_channels(coded, num_channels), plain, path_).values;
    if (model_ != ColorModel::Cmyk)
      make_lab(values, model_ == ColorModel::IccLab, coded.type == CodedImage::Type::UInt16);
    const ImageF rgb = model_ == ColorModel::Cmyk ? inks_.encoding->to_linear(values)
                                                  : linear_from_lab(values, words_.white.value_or(kD50White));
    CodedImage light{rgb.width(), rgb.height(), 3, CodedImage::Type::Float, -1, {}};
    const auto bytes = std::as_bytes(rgb.values());
    light.bytes.assign(bytes.begin(), bytes.end());
    return light;
  }

  fs::path path_;
  std::optional<TemporaryFolder> alias_;
  std::unique_ptr<ImageSource> source_;
  ImageInfo stored_;
  FileWords words_;
  ColorModel model_ = ColorModel::Rgb;
  InkColor inks_ = {.name = ""};
  bool is_converted_ = false;
};

}  // namespace

std::unique_ptr<ImageSource> open_worded(const fs::path& path) { return std::make_unique<WordedSource>(path); }

}  // namespace patinate
