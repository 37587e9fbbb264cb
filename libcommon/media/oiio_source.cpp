#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/media/cmyk_jpeg.h"
#include "libcommon/media/oiio.h"
#include "patinate/core/error.h"

namespace patinate::media {

namespace {

/// Color as the file has it, not multiplied by alpha; RAW as light. Other formats ignore the hints for RAW.
OIIO::ImageSpec open_hints(bool has_raw_color) {
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);
  if (has_raw_color) hints.attribute("oiio:RawColor", 1);
  hints.attribute("raw:ColorSpace", "sRGB-linear");
  hints.attribute("raw:auto_bright", 0);
  hints.attribute("raw:adjust_maximum_thr", 0.0f);  // It would move the white point with each picture's content.
  hints.attribute("raw:use_camera_wb", 0);
  hints.attribute("raw:use_camera_matrix", 1);
  hints.attribute("raw:HighlightMode", 0);
  hints.attribute("raw:Demosaic", "AHD");
  return hints;
}

/// Tells losses that OpenImageIO nevertheless counts as read: rows that are missing (TIFF, JPEG, IFF), but
/// for JPEG also what cameras do that costs no pixel. @param problem  Lines of text.
bool is_loss(const std::string& problem, std::string_view format) {
  if (format != "jpeg") return !problem.empty();
  std::istringstream lines(problem);
  for (std::string line; std::getline(lines, line);) {
    const auto says = [&](const char* words) { return line.find(words) != std::string::npos; };
    if (says("Premature end") || (says("Corrupt JPEG data") && !says("extraneous bytes"))) return true;
  }
  return false;
}

OIIO::TypeDesc type_desc(CodedImage::Type type) {
  switch (type) {
    case CodedImage::Type::UInt8:
      return OIIO::TypeDesc::UINT8;
    case CodedImage::Type::UInt16:
      return OIIO::TypeDesc::UINT16;
    case CodedImage::Type::Float:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

/// Exposure in the photograph's EXIF data; numbers that make no sense count as not said.
ImageExposure exposure_of(const OIIO::ImageSpec& spec) {
  const auto number = [&](const char* name) {
    const double value = static_cast<double>(spec.get_float_attribute(name));
    return std::isfinite(value) && value > 0.0 ? value : 0.0;
  };
  ImageExposure exposure{.time_s = number("ExposureTime"),
                         .f_number = number("FNumber"),
                         .iso = static_cast<double>(spec.get_int_attribute("Exif:PhotographicSensitivity"))};
  if (exposure.time_s == 0.0) exposure.time_s = number("Exif:ExposureTime");
  if (exposure.f_number == 0.0) exposure.f_number = number("Exif:FNumber");
  if (!(exposure.iso > 0.0)) exposure.iso = number("Exif:ISOSpeedRatings");
  const int white_balance = spec.get_int_attribute("Exif:WhiteBalance", -1);
  if (white_balance == 0) exposure.white_balance = ImageExposure::WhiteBalance::Auto;
  if (white_balance == 1) exposure.white_balance = ImageExposure::WhiteBalance::Manual;
  return exposure;
}

/// DateTimeOriginal or DateTimeDigitized, with its fraction of a second and its offset from UTC.
std::string exif_date(const OIIO::ImageSpec& spec, const std::string& kind) {
  const std::string date(spec.get_string_attribute("Exif:DateTime" + kind));
  if (date.empty()) return "";
  // The names without a kind belong to the date of the last change, which is this one in an unchanged file.
  const bool is_unchanged = spec.get_string_attribute("DateTime") == date;
  const auto companion = [&](const std::string& name) {
    const std::string own(spec.get_string_attribute(name + kind));
    return !own.empty() || !is_unchanged ? own : std::string(spec.get_string_attribute(name));
  };
  std::string fraction = companion("Exif:SubsecTime"), offset = companion("Exif:OffsetTime");
  fraction.erase(std::find_if_not(fraction.begin(), fraction.end(), is_digit), fraction.end());
  return date + (fraction.empty() ? "" : "." + fraction) + offset;
}

/// Blank picture to decode into, its bytes made.
CodedImage blank(const OIIO::ImageSpec& spec, int height) {
  CodedImage coded{spec.width, height, spec.nchannels, CodedImage::Type::Float, -1, {}};
  if (spec.format == OIIO::TypeDesc::UINT8) coded.type = CodedImage::Type::UInt8;
  if (spec.format == OIIO::TypeDesc::UINT16) coded.type = CodedImage::Type::UInt16;
  const int alpha = spec.channelindex("A");  // The GIF reader's own number points behind the channels.
  if (alpha >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0) coded.associated_alpha = alpha;
  coded.bytes.resize(static_cast<std::size_t>(coded.width) * static_cast<std::size_t>(height) *
                     static_cast<std::size_t>(coded.channels) * bytes_per_value(coded.type));
  return coded;
}

bool is_cmyk_file(const OIIO::ImageSpec& spec) {
  const std::string tiff = spec.get_string_attribute("tiff:ColorSpace"),
                    jpeg = spec.get_string_attribute("jpeg:ColorSpace");
  return tiff == "CMYK" || jpeg == "CMYK" || jpeg == "YCbCrK";
}

/// OpenImageIO opens more than it reads, or reads it wrongly: FITS from below to above with a scale of its own, inks
/// in a TIFF's JPEG inverted. @throws IoError that says what it is and what to do.
void require_readable(const std::filesystem::path& path, const OIIO::ImageInput& input) {
  const OIIO::ImageSpec& spec = input.spec();
  const std::string_view format = input.format_name();
  if (format == "fits") throw IoError(path.string(), "is a FITS image, which is not read; save it as EXR or TIFF");
  if (spec.deep) throw IoError(path.string(), "is a deep EXR, with several samples a pixel; flatten it");
  if (format != "tiff" || !is_cmyk_file(spec)) return;
  if (spec.get_string_attribute("compression") == "jpeg")
    throw IoError(path.string(),
                  "is a CMYK TIFF compressed as JPEG, which is not read; save it with another compression");
  if (spec.format.is_floating_point())
    throw IoError(path.string(), "is a CMYK TIFF of floating point numbers, which is not read; save it with 16 bits");
}

/// Subimages of a file that are pictures, and what the others are.
struct FilePages {
  std::vector<int> pictures;  ///< Empty: all.
  std::string text;
};

/// TIFF marks reduced copies and masks.
FilePages pages_of(OIIO::ImageInput& input) {
  FilePages pages;
  if (std::string_view(input.format_name()) == "psd") {  // The picture, then its layers.
    pages.pictures = {0};
    return pages;
  }
  if (std::string_view(input.format_name()) == "heif") {  // The primary picture, then others of the same moment.
    int num_pictures = 1;
    while (num_pictures < kMaxImageFrames && input.seek_subimage(num_pictures, 0)) ++num_pictures;
    (void)input.geterror();
    pages.pictures = {0};
    if (num_pictures > 1) pages.text = "the primary picture of " + std::to_string(num_pictures);
    return pages;
  }
  if (std::string_view(input.format_name()) != "tiff") return pages;
  constexpr int kReduced = 1, kMask = 4;
  int num_pages = 0;
  std::string others;
  for (; num_pages < kMaxImageFrames && input.seek_subimage(num_pages, 0); ++num_pages) {
    const int kind = input.spec().get_int_attribute("tiff:subfiletype");
    if ((kind & (kReduced | kMask)) == 0) {
      pages.pictures.push_back(num_pages);
    } else {
      others += (others.empty() ? "page " : ", page ") + std::to_string(num_pages + 1) +
                ((kind & kMask) != 0 ? " is a mask" : " is a reduced copy");
    }
  }
  (void)input.geterror();
  if (pages.pictures.empty() || static_cast<int>(pages.pictures.size()) == num_pages) return {};
  if (pages.pictures.size() == 1)
    pages.text = std::to_string(pages.pictures.front() + 1) + "; " + others;
  else
    pages.text = std::to_string(pages.pictures.size()) + " pages; " + others;
  return pages;
}

std::string picture_size_text(const OIIO::ImageSpec& spec) {
  return std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels of " +
         std::to_string(spec.nchannels) + (spec.nchannels == 1 ? " channel" : " channels");
}

class OiioSource final : public ImageSource {
 public:
  OiioSource(const std::filesystem::path& path, const std::filesystem::path& name, bool has_raw_color)
      : path_(path), has_raw_color_(has_raw_color) {
    const OIIO::ImageSpec hints = open_hints(has_raw_color);
    input_ = OIIO::ImageInput::open(name.string(), &hints);
    if (!input_) {
      (void)OIIO::geterror();
      if (path.extension().empty())
        throw IoError(path.string(),
                      "is no readable image; if it is something else, give it the extension of its "
                      "format (a mesh: .obj, .ply, .stl, .gltf or .glb)");
      throw IoError(path.string(), "is no readable image (damaged, or not an image format that is known)");
    }
    require_readable(path, *input_);
    if (input_->spec().depth > 1) throw IoError(path.string(), "has an unusable size; at most 65536 x 65536 pixels");
    pages_ = pages_of(*input_);
  }

  [[nodiscard]] ImageInfo first_info() const override {
    const OIIO::ImageSpec spec = first_spec();
    ImageInfo info;
    info.width = spec.width;
    info.height = spec.height;
    info.channels = spec.channelnames;
    info.is_integer = !spec.format.is_floating_point();
    info.is_raw = std::string_view(input_->format_name()) == "raw";
    set_words(info, spec.get_string_attribute(kImageKeyAttribute), spec.get_string_attribute("ImageDescription"));
    info.date_time = exif_date(spec, "Original");
    info.digitized = exif_date(spec, "Digitized");
    // LibRaw passes on what the camera says, and nothing else.
    if (info.is_raw && info.date_time.empty()) info.date_time = spec.get_string_attribute("DateTime");
    info.exposure = exposure_of(spec);
    // Set for movies as a rational number.
    const float rate = spec.get_float_attribute("FramesPerSecond");
    if (std::isfinite(rate) && rate > 0.0f) info.frame_rate = static_cast<double>(rate);
    int rational[2] = {0, 0};
    if (spec.getattribute("FramesPerSecond", OIIO::TypeRational, rational) && rational[0] > 0 && rational[1] > 0) {
      info.frame_rate = static_cast<double>(rational[0]) / rational[1];
    }
    info.facts.page = pages_.text;
    // LibRaw has turned it, and counts as dcraw does.
    const int flip = spec.get_int_attribute("raw:flip");
    if (info.is_raw && flip != 0)
      info.facts.orientation = flip == 3   ? "turned by 180 degrees (camera RAW)"
                               : flip == 6 ? "turned by 90 degrees clockwise (camera RAW)"
                               : flip == 5 ? "turned by 90 degrees counterclockwise (camera RAW)"
                                           : "turned as the camera RAW says";
    return info;
  }

  [[nodiscard]] int count_frames() override {
    if (!pages_.pictures.empty()) return static_cast<int>(pages_.pictures.size());
    int num_frames = 1;
    while (num_frames < kMaxImageFrames && input_->seek_subimage(num_frames, 0)) ++num_frames;
    (void)input_->geterror();
    return num_frames;
  }

  [[nodiscard]] CodedImage read(int frame) override {
    const std::string where = frame == 0 ? "" : "image " + std::to_string(frame) + " ";
    if (frame < 0 || !input_->seek_subimage(subimage_of(frame), 0))
      throw IoError(path_.string(), "has no image " + std::to_string(frame) + " that can be read");
    const OIIO::ImageSpec spec = input_->spec(), first = first_spec();
    if (spec.width != first.width || spec.height != first.height || spec.nchannels != first.nchannels) {
      throw IoError(path_.string(), where + "is of " + picture_size_text(spec) + " and the first of " +
                                        picture_size_text(first) +
                                        "; if one of them is the photograph, save it as a file of its own");
    }
    if (has_raw_color_ && std::string_view(input_->format_name()) == "jpeg") return read_cmyk_jpeg(path_);
    CodedImage coded = blank(spec, spec.height);
    check(input_->read_image(subimage_of(frame), 0, 0, spec.nchannels, type_desc(coded.type), coded.bytes.data()),
          where);
    return coded;
  }

  [[nodiscard]] CodedImage read_rows(int begin, int end) override {
    const OIIO::ImageSpec spec = first_spec();
    if (has_raw_color_ && std::string_view(input_->format_name()) == "jpeg") {
      CodedImage rows = read_cmyk_jpeg(path_);
      const std::ptrdiff_t row = std::ptrdiff_t{4} * rows.width;
      rows.bytes = {rows.bytes.begin() + row * begin, rows.bytes.begin() + row * end};
      rows.height = end - begin;
      return rows;
    }
    CodedImage coded = blank(spec, end - begin);
    check(input_->read_scanlines(subimage_of(0), 0, spec.y + begin, spec.y + end, 0, 0, spec.nchannels,
                                 type_desc(coded.type), coded.bytes.data()),
          "");
    return coded;
  }

  [[nodiscard]] int orientation() const override {
    const int said = first_spec().get_int_attribute("Orientation", 1);
    return said >= 1 && said <= 8 ? said : 1;
  }

  [[nodiscard]] ColorModel color_model() const override {
    constexpr int kLab = 8, kIccLab = 9;
    const OIIO::ImageSpec spec = first_spec();
    const int photometric = spec.get_int_attribute("tiff:PhotometricInterpretation", -1);
    if (photometric == kLab) return ColorModel::Lab;
    if (photometric == kIccLab) return ColorModel::IccLab;
    return is_cmyk_file(spec) ? ColorModel::Cmyk : ColorModel::Rgb;
  }

  [[nodiscard]] std::string profile() const override {
    const OIIO::ImageSpec spec = first_spec();
    const OIIO::ParamValue* found = spec.find_attribute("ICCProfile");
    if (found == nullptr || found->type().basetype != OIIO::TypeDesc::UINT8) return "";
    return {static_cast<const char*>(found->data()), static_cast<std::size_t>(found->datasize())};
  }

 private:
  [[nodiscard]] int subimage_of(int frame) const {
    if (pages_.pictures.empty()) return frame;
    const auto at = static_cast<std::size_t>(frame);
    return at < pages_.pictures.size() ? pages_.pictures[at] : kMaxImageFrames;
  }
  [[nodiscard]] OIIO::ImageSpec first_spec() const { return input_->spec(subimage_of(0), 0); }

  /// @throws IoError unless pixels were read, all of them. @param where  "image 3 " or "".
  void check(bool is_read, const std::string& where) const {
    const std::string problem = input_->geterror();
    if (is_read && !is_loss(problem, input_->format_name())) return;
    throw IoError(path_.string(), where + "is damaged or truncated (" + one_line(problem) + ")");
  }

  std::filesystem::path path_;
  bool has_raw_color_;
  std::unique_ptr<OIIO::ImageInput> input_;
  FilePages pages_;
};

}  // namespace

void configure_image_library() {
  static std::once_flag flag;
  std::call_once(flag, [] {
    // One thread inside OpenImageIO: our loops are parallel already, and its pool outlives a caller's settings.
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::attribute("limits:channels", kMaxImageChannels);
    OIIO::attribute("limits:imagesize_MB", 32768);
  });
}

std::string one_line(std::string text) {
  const std::size_t end = text.find('\n');
  if (end != std::string::npos) text.resize(end);
  return text;
}

std::unique_ptr<ImageSource> open_image(const std::filesystem::path& path, const std::filesystem::path& name,
                                        bool has_raw_color) {
  return std::make_unique<OiioSource>(path, name, has_raw_color);
}

}  // namespace patinate::media
