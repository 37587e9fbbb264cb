/// \file
/// Image files; all but PNG and EXR through OpenImageIO, loaded when needed. Channels are found by name; equal images
/// give equal bytes (no time stamps). Camera RAW and movies are decoded in a process of their own (decoder_process.h).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/image/color.h"
#include "patinate/image/image.h"

namespace patinate {

/// How a photograph was exposed, as its EXIF data says; nominal values, up to some 5 % from what the camera did.
struct ImageExposure {
  enum class WhiteBalance { Unknown, Auto, Manual };
  double time_s = 0.0;    ///< 0 = not said; as with the others.
  double f_number = 0.0;  ///< 0 also for a lens that tells the camera nothing.
  double iso = 0.0;
  WhiteBalance white_balance = WhiteBalance::Unknown;

  /// Light that makes a code, against other photographs: time * iso / f_number^2; 0 where time or iso is not said, and
  /// an f_number that is not counts as 1.
  [[nodiscard]] double amount() const { return time_s * iso / (f_number > 0.0 ? f_number * f_number : 1.0); }
  friend bool operator==(const ImageExposure&, const ImageExposure&) = default;
};

/// What 0 and 1 of a map's channel stand for.
struct ValueScale {
  double low = 0.0;   ///< Physical value of 0; finite.
  double high = 1.0;  ///< Physical value of 1; finite.
  std::string unit;   ///< "1/mm", "relative", ...; "" = none.

  friend bool operator==(const ValueScale&, const ValueScale&) = default;
};

/// Statements of an image file about how to display its picture, as patinate understood them; one line each, "" = none.
struct ImageFacts {
  std::string color;        ///< "Display P3 (ICC profile)"; nothing: codes are sRGB, other values linear Rec. 709.
  std::string orientation;  ///< "turned by 90 degrees clockwise (EXIF orientation 6)"; width and height are the turned.
  std::string alpha;        ///< Why what stands where alpha does is not used.
  std::string window;       ///< Of an EXR whose display window is not what it holds.
  std::string layer;        ///< Of an EXR: which part, view and layer the picture is.
  std::string page;         ///< "page 1; page 2 is a reduced copy".
  std::string problem;      ///< Statements of the file that are not used, and why.

  /// Name and text of each that is not empty.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> named() const;
  friend bool operator==(const ImageFacts&, const ImageFacts&) = default;
};

class ColorEncoding;

/// What an image file says about itself, read without decoding pixels.
struct ImageInfo {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< As stored, e.g. "R", "G", "B", "A", "source.x".
  bool is_integer = true;             ///< 8 or 16 bit codes; false for half and float.
  bool is_raw = false;                ///< Camera RAW: linear light, no response applies.
  int num_frames = 1;                 ///< Sub-images (movies, animated files, pages).
  double frame_rate = 0.0;            ///< Frames per second of playback; 0 = the file does not say.
  /// When a movie shows its frames, in s from the first one on, rising; empty = the file does not say it of each.
  std::vector<double> frame_times_s;
  /// When it was taken, by EXIF: DateTimeOriginal with SubSecTime and OffsetTime, "YYYY:MM:DD HH:MM:SS[.SS][+HH:MM]";
  /// "" = not said. Dates at which a file was written or changed are none.
  std::string date_time;
  std::string digitized;            ///< DateTimeDigitized in the same form.
  ImageExposure exposure;           ///< Of a photograph.
  std::string key;                  ///< Content key that patinate wrote into the file, or "".
  std::optional<ValueScale> scale;  ///< What 0 and 1 stand for, in an EXR that write_scaled_exr() made.
  ImageFacts facts;
  std::string color_layer;    ///< "ViewLayer.Combined." before R, G, B and A, where an EXR has its color in a layer.
  std::string color_problem;  ///< Why no picture in color can be told among several; "" = it can.
  std::shared_ptr<const ColorEncoding> encoding;  ///< Of colors that are not sRGB codes or linear Rec. 709.

  /// Alpha, by its name or in `color_layer`.
  [[nodiscard]] bool has_alpha() const;
};

/// At most 65536 x 65536 pixels and 64 channels.
/// @throws IoError if it is missing, empty, no image, or too large.
[[nodiscard]] ImageInfo probe_image(const std::filesystem::path& path);

/// Color as 3 linear Rec. 709 channels (gray is repeated, alpha dropped, RGBA unassociated), as the file says that it
/// is. A `response` that is not Response::Kind::File decodes integer codes instead, whatever the file says.
/// @throws IoError also when truncated, when a value is NaN or infinite, or, by its header, when it holds more than
/// 2^30 values; CannotComplete when memory ends.
[[nodiscard]] ImageF read_color(const std::filesystem::path& path, const Response& response = {});
/// One channel of raw values: codes / 255 (or / 65535) for integers, values for floats. `channel` "" means "Y", the
/// only one, or the mean of R, G, B.
[[nodiscard]] ImageF read_gray(const std::filesystem::path& path, const std::string& channel = "");
/// Named channels in the order asked for; raw values. @throws IoError naming a missing channel and those there are.
[[nodiscard]] ImageF read_channels(const std::filesystem::path& path, const std::vector<std::string>& channels);
/// 8-bit mask: 0 outside, 255 inside. The opaque part of an object that is cut out; what is not black of labels in
/// color; else codes from 128 on. @throws IoError also for a picture that is no mask, or says two things.
[[nodiscard]] ImageU8 read_mask(const std::filesystem::path& path);

enum class ExrDepth { Half, Float };

/// EXR with the given channel names, in values; ZIP, no date. @throws CannotComplete if it cannot be written;
/// InvalidInput on NaN, infinity, or (Half) overflow.
void write_exr(const std::filesystem::path& path, const ImageF& image, const std::vector<std::string>& channels,
               ExrDepth depth, const std::string& key = "");
/// A map of one channel, "Y", in floats, whose header says what 0 and 1 stand for: `patinate:low`, `patinate:high`
/// (doubles) and `patinate:unit`. @throws as write_exr(); InvalidInput also if the scale is not finite.
void write_scaled_exr(const std::filesystem::path& path, const ImageF& map, const ValueScale& scale,
                      const std::string& key = "");
/// RGB linear values into an 8-bit sRGB image; the format follows the extension (.png, .jpg, .tif).
void write_srgb8(const std::filesystem::path& path, const ImageF& linear, const std::string& key = "");
/// Codes as they are: gray, RGB or RGBA PNG.
void write_codes(const std::filesystem::path& path, const ImageU8& codes, const std::string& key = "");
/// .exr -> half RGB in values, others -> 8-bit sRGB. @throws ParseError on an unknown extension.
void write_color(const std::filesystem::path& path, const ImageF& linear, const std::string& key = "");

}  // namespace patinate
