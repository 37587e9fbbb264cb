#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/image/color_encoding.h"
#include "libcommon/image/exr_picture.h"
#include "libcommon/image/file_words.h"
#include "libcommon/image/image_decoder.h"
#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

std::optional<std::uint32_t> read_u32(std::istream& in) {
  std::array<unsigned char, 4> bytes{};
  if (!in.read(reinterpret_cast<char*>(bytes.data()), bytes.size())) return std::nullopt;
  return bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 | std::uint32_t{bytes[3]} << 24;
}

std::optional<std::string> read_name(std::istream& in) {
  constexpr std::size_t kLongest = 255;
  std::string name;
  for (char c = 0; in.get(c);) {
    if (c == '\0') return name;
    name.push_back(c);
    if (name.size() > kLongest) return std::nullopt;
  }
  return std::nullopt;
}

/// Sizes that a header states.
struct Extent {
  std::int64_t width = 0, height = 0;            ///< Size of the data window; 0 = not said.
  std::int64_t tile_width = 0, tile_height = 0;  ///< 0 = rows.
  std::int64_t num_chunks = 0;
};

/// The value of an attribute. @returns false if it cannot be read.
bool read_extent(std::istream& in, const std::string& name, const std::string& type, std::uint32_t size,
                 Extent& extent) {
  const std::streampos begin = in.tellg();
  std::array<std::int64_t, 4> numbers{};
  const bool is_window = name == "dataWindow" && type == "box2i" && size == 16;
  const bool is_tiles = name == "tiles" && type == "tiledesc" && size >= 8;
  const bool is_count = name == "chunkCount" && type == "int" && size == 4;
  for (std::size_t i = 0; i < (is_window ? 4U : is_tiles ? 2U : is_count ? 1U : 0U); ++i) {
    const auto number = read_u32(in);
    if (!number) return false;
    numbers[i] = static_cast<std::int32_t>(*number);
  }
  if (is_window) {
    extent.width = numbers[2] - numbers[0] + 1;
    extent.height = numbers[3] - numbers[1] + 1;
  }
  if (is_tiles) {
    extent.tile_width = numbers[0];
    extent.tile_height = numbers[1];
    if (numbers[0] < 1 || numbers[1] < 1) return false;
  }
  if (is_count) extent.num_chunks = numbers[0];
  in.seekg(begin + static_cast<std::streamoff>(size));
  return static_cast<bool>(in);
}

/// Whether the table of places that OpenEXR makes is no larger than the file may hold.
bool is_small(const Extent& extent, std::int64_t file_size) {
  constexpr std::int64_t kPlace = 8;
  if (extent.width < 1 || extent.height < 1 || extent.width > kMaxImageSide || extent.height > kMaxImageSide)
    return false;
  const auto parts = [](std::int64_t all, std::int64_t part) { return (all + part - 1) / part; };
  const std::int64_t num_tiles =
      extent.tile_width == 0 ? 0 : parts(extent.width, extent.tile_width) * parts(extent.height, extent.tile_height);
  return num_tiles <= file_size / kPlace && extent.num_chunks >= 0 && extent.num_chunks <= file_size / kPlace;
}

/// One header up to the empty name behind it. @returns nothing if it cannot be read.
std::optional<Extent> read_header_extent(std::istream& in, std::string name) {
  Extent extent;
  while (!name.empty()) {
    const auto type = read_name(in);
    const auto size = read_u32(in);
    if (!type || !size || !read_extent(in, name, *type, *size, extent)) return std::nullopt;
    const auto next = read_name(in);
    if (!next) return std::nullopt;
    name = *next;
  }
  return extent;
}

/// Whether it is an EXR without deep pixels whose parts have at most kMaxImageSide along each side, and no more tiles
/// than the file has place for.
bool is_plain_exr(const std::filesystem::path& path) {
  constexpr std::uint32_t kMagic = 20000630, kVersion = 2, kVersionBits = 0xff, kTiled = 0x200, kLongNames = 0x400,
                          kMultiPart = 0x1000;
  std::ifstream in(path, std::ios::binary);
  in.seekg(0, std::ios::end);
  const std::int64_t file_size = in ? static_cast<std::int64_t>(in.tellg()) : 0;
  in.seekg(0);
  const auto magic = read_u32(in), version = read_u32(in);
  if (!version || *magic != kMagic || (*version & kVersionBits) != kVersion ||
      (*version & ~(kVersionBits | kTiled | kLongNames | kMultiPart)) != 0)
    return false;
  constexpr int kMostParts = 4096;
  for (int part = 0; part < kMostParts; ++part) {
    const auto name = read_name(in);
    if (!name) return false;
    if (name->empty()) return part > 0;  // Behind the last header of several.
    const auto extent = read_header_extent(in, *name);
    if (!extent || !is_small(*extent, file_size)) return false;
    if ((*version & kMultiPart) == 0) return true;
  }
  return false;
}

/// The text of the first attribute with one of the names, whatever their case, up to a zero.
std::string text_of(const Imf::Header& header, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    for (auto it = header.begin(); it != header.end(); ++it) {
      if (::strcasecmp(it.name(), name) != 0 || std::string_view(it.attribute().typeName()) != "string") continue;
      return static_cast<const Imf::StringAttribute&>(it.attribute()).value().c_str();
    }
  }
  return "";
}

/// Meaning of 0 and 1, unless the header lacks a number or has one that is not finite.
std::optional<ValueScale> scale_of(const Imf::Header& header) {
  const auto* low = header.findTypedAttribute<Imf::DoubleAttribute>(kImageLowAttribute);
  const auto* high = header.findTypedAttribute<Imf::DoubleAttribute>(kImageHighAttribute);
  if (low == nullptr || high == nullptr || !std::isfinite(low->value()) || !std::isfinite(high->value())) return {};
  return ValueScale{low->value(), high->value(), text_of(header, {kImageUnitAttribute})};
}

double frame_rate_of(const Imf::Header& header) {
  const auto* rate = header.findTypedAttribute<Imf::RationalAttribute>("framesPerSecond");
  return rate != nullptr && rate->value().n > 0 && rate->value().d > 0 ? double{rate->value()} : 0.0;
}

/// Reads the header's statements, whoever wrote it.
void read_exr_words(const Imf::Header& header, ImageInfo& info) {
  set_words(info, text_of(header, {kImageKeyAttribute}), text_of(header, {"ImageDescription", "comments"}));
  info.scale = scale_of(header);
  info.frame_rate = frame_rate_of(header);
}

/// Colors that are not of Rec. 709 [Kai2013].
void read_exr_color(const Imf::Header& header, ImageInfo& info) {
  if (!Imf::hasChromaticities(header)) return;
  const Imf::Chromaticities& c = Imf::chromaticities(header);
  const auto xy = [](const Imath::V2f& v) { return std::array{static_cast<double>(v.x), static_cast<double>(v.y)}; };
  const Chromaticities primaries{{xy(c.red), xy(c.green), xy(c.blue), xy(c.white)}};
  SaidColor color = light_of_primaries(primaries_name(primaries) + " (EXR chromaticities)", primaries);
  info.facts.color = color.name;
  info.encoding = std::move(color.encoding);
  if (!color.problem.empty()) info.facts.problem = color.problem + " and are not used";
}

class ExrSource final : public ImageSource {
 public:
  explicit ExrSource(const std::filesystem::path& path)
      : path_(path), file_(path.c_str(), 0) {}  // On the thread that calls.

  [[nodiscard]] bool open() {
    const std::optional<ExrPicture> found = find_exr_picture(file_);
    if (!found) return false;
    picture_ = *found;
    const Imf::Header& header = file_.header(picture_.part);
    window_ = header.displayWindow();
    data_ = header.dataWindow();
    info_.width = window_.max.x - window_.min.x + 1;
    info_.height = window_.max.y - window_.min.y + 1;
    info_.is_integer = false;
    for (const ExrChannel& channel : picture_.channels) info_.channels.push_back(channel.name);
    info_.color_layer = picture_.layer;
    info_.color_problem = picture_.problem;
    info_.facts.layer = picture_.text;
    read_exr_words(header, info_);
    read_exr_color(header, info_);
    if (const std::string problem = pixel_shape_problem(static_cast<double>(header.pixelAspectRatio()));
        !problem.empty())
      info_.facts.problem += (info_.facts.problem.empty() ? "" : "; ") + problem;
    find_alpha(header);
    if (!data_.intersects(window_))
      info_.color_problem = "shows nothing: its data lie outside of its display window; save it with data inside";
    if (picture_.is_luminance_chroma) {
      rgba_.emplace(path_.c_str(), picture_.layer.substr(0, picture_.layer.size() - (picture_.layer.empty() ? 0 : 1)),
                    0);
    } else {
      part_.emplace(file_, picture_.part);
    }
    return true;
  }

  [[nodiscard]] ImageInfo first_info() const override { return info_; }
  [[nodiscard]] int count_frames() override { return 1; }

  [[nodiscard]] CodedImage read(int frame) override {
    if (frame != 0) throw IoError(path_.string(), "has no image " + std::to_string(frame) + " that can be read");
    return read_rows(0, info_.height);
  }

  [[nodiscard]] CodedImage read_rows(int begin, int end) override {
    CodedImage coded{info_.width, end - begin, static_cast<int>(info_.channels.size()), CodedImage::Type::Float,
                     alpha_,      {}};
    coded.bytes.resize(info_.channels.size() * static_cast<std::size_t>(info_.width) *
                       static_cast<std::size_t>(end - begin) * sizeof(float));
    try {
      if (data_ == window_) {
        read_data(window_.min.y + begin, window_.min.y + end - 1, coded.bytes.data());
      } else {
        read_part_of_window(begin, end, coded);
      }
    } catch (const std::exception& e) {
      const std::string problem = e.what();
      throw IoError(path_.string(), "is damaged or truncated (" + problem.substr(0, problem.find('\n')) + ")");
    }
    return coded;
  }

 private:
  /// Alpha is there, or what the display window shows beside the data is transparent.
  void find_alpha(const Imf::Header& header) {
    const bool is_covered = data_.min.x <= window_.min.x && data_.min.y <= window_.min.y &&
                            data_.max.x >= window_.max.x && data_.max.y >= window_.max.y;
    if (data_ != window_)
      info_.facts.window = "display window, " + size_text(info_.width, info_.height) + ", of data of " +
                           size_text(data_.max.x - data_.min.x + 1, data_.max.y - data_.min.y + 1) + " from (" +
                           std::to_string(data_.min.x - window_.min.x) + ", " +
                           std::to_string(data_.min.y - window_.min.y) + ")" +
                           (is_covered ? "" : "; what no data covers is transparent");
    auto found = std::find(info_.channels.begin(), info_.channels.end(), info_.color_layer + "A");
    if (found == info_.channels.end() && picture_.has_color) {
      found = std::find_if(info_.channels.begin(), info_.channels.end(),
                           [&](const std::string& name) { return is_color_channel(name, info_.color_layer, "A"); });
    }
    const auto* separate = header.findTypedAttribute<Imf::IntAttribute>("oiio:UnassociatedAlpha");
    const bool is_associated = separate == nullptr || separate->value() == 0;
    if (found != info_.channels.end()) {
      if (is_associated) alpha_ = static_cast<int>(found - info_.channels.begin());
    } else if (!is_covered && picture_.has_color) {
      info_.channels.push_back(info_.color_layer + "A");
      has_made_alpha_ = true;
    }
  }

  /// Rows of the data, whole. @param first,last  In the file's own count.
  void read_data(int first, int last, std::byte* to) {
    const std::size_t num_channels = info_.channels.size();
    const int width = data_.max.x - data_.min.x + 1;
    const std::size_t pixel = num_channels * sizeof(float), row = pixel * static_cast<std::size_t>(width);
    if (picture_.is_luminance_chroma) {
      read_luminance_chroma(first, last, to);
      return;
    }
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < picture_.channels.size(); ++c) {
      // OpenEXR wants the place of the pixel (0, 0), which may lie outside.
      buffer.insert(picture_.channels[c].name,
                    Imf::Slice::Make(Imf::FLOAT, to + c * sizeof(float), Imath::V2i(data_.min.x, first), width,
                                     last - first + 1, pixel, row));
    }
    part_->setFrameBuffer(buffer);
    part_->readPixels(first, last);
    if (!has_made_alpha_) return;
    constexpr float kOpaque = 1.0f;
    const std::size_t num_pixels = static_cast<std::size_t>(last - first + 1) * static_cast<std::size_t>(width);
    for (std::size_t i = 0; i < num_pixels; ++i)
      std::memcpy(to + i * pixel + (num_channels - 1) * sizeof(float), &kOpaque, sizeof kOpaque);
  }

  /// By OpenEXR, which filters the chroma between its samples.
  void read_luminance_chroma(int first, int last, std::byte* to) {
    const std::size_t num_channels = info_.channels.size();
    const int width = data_.max.x - data_.min.x + 1;
    std::vector<Imf::Rgba> row(static_cast<std::size_t>(width));
    for (int y = first; y <= last; ++y) {
      rgba_->setFrameBuffer(row.data() - data_.min.x - std::ptrdiff_t{y} * width, 1, static_cast<std::size_t>(width));
      rgba_->readPixels(y);
      for (const Imf::Rgba& value : row) {
        const std::array<float, 4> four{value.r, value.g, value.b, value.a};
        std::memcpy(to, four.data(), std::min<std::size_t>(num_channels, 4) * sizeof(float));
        to += num_channels * sizeof(float);
      }
    }
  }

  /// The rows of the display window, 0 where there are no data.
  void read_part_of_window(int begin, int end, CodedImage& coded) {
    const Imath::Box2i seen(
        Imath::V2i(std::max(data_.min.x, window_.min.x), std::max(data_.min.y, window_.min.y + begin)),
        Imath::V2i(std::min(data_.max.x, window_.max.x), std::min(data_.max.y, window_.min.y + end - 1)));
    if (seen.isEmpty()) return;
    const std::size_t pixel = info_.channels.size() * sizeof(float);
    const auto width = [&](const Imath::Box2i& box) { return static_cast<std::size_t>(box.max.x - box.min.x + 1); };
    std::vector<std::byte> row(width(data_) * pixel);
    for (int y = seen.min.y; y <= seen.max.y; ++y) {
      read_data(y, y, row.data());
      const std::size_t to = static_cast<std::size_t>(y - window_.min.y - begin) * width(window_) +
                             static_cast<std::size_t>(seen.min.x - window_.min.x);
      std::memcpy(coded.bytes.data() + to * pixel,
                  row.data() + static_cast<std::size_t>(seen.min.x - data_.min.x) * pixel, width(seen) * pixel);
    }
  }

  std::filesystem::path path_;
  Imf::MultiPartInputFile file_;
  ExrPicture picture_;
  std::optional<Imf::InputPart> part_;
  std::optional<Imf::RgbaInputFile> rgba_;  ///< Reader of luminance and chroma.
  Imath::Box2i data_, window_;
  ImageInfo info_;
  int alpha_ = -1;
  bool has_made_alpha_ = false;
};

}  // namespace

std::unique_ptr<ImageSource> open_exr(const std::filesystem::path& path) {
  if (!is_plain_exr(path)) return nullptr;
  try {
    auto source = std::make_unique<ExrSource>(path);
    if (source->open()) return source;
  } catch (const std::exception&) {  // OpenImageIO's words for what is damaged.
  }
  return nullptr;
}

}  // namespace patinate
