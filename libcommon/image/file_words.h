/// \file
/// What image files say about their pictures beside the pixels, whoever decodes those: EXIF, color profiles, and what
/// headers declare. Inside of image input only.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/image/color_encoding.h"
#include "libcommon/image/file_bytes.h"

namespace patinate {

/// Color code points of ITU-T H.273.
struct ColorCodePoints {
  int primaries = 2;
  int transfer = 2;
  bool is_full_range = true;
};

/// Statements as the file has them; damaged ones are left out, and named in `problems`.
struct FileWords {
  int orientation = 1;  ///< EXIF's, [1, 8]; 1 where the format turns pictures itself.
  std::string turn;     ///< Turn that the format itself makes, in words; "" = none.
  std::string icc;      ///< An embedded profile.
  std::optional<ColorCodePoints> code_points;
  bool is_srgb = false;       ///< PNG's sRGB, EXIF's color space 1.
  bool is_adobe_rgb = false;  ///< EXIF: not sRGB, and interoperability "R03".
  std::optional<double> png_gamma;
  double exposure = 1.0;  ///< Radiance: the light is the values divided by it.
  std::optional<Chromaticities> primaries;
  std::string primaries_by;                    ///< "PNG cHRM", "TIFF" or "Radiance PRIMARIES".
  std::optional<std::array<double, 2>> white;  ///< CIE xy of a TIFF's white.
  std::string unused_alpha;                    ///< Why a channel that stands where alpha does is none; "" = it is.
  std::optional<int> largest_value;            ///< Largest of codes of 16 bits, where it is not 65535: 12 bits in 16.
  std::string xmp_original, xmp_digitized;  ///< exif:DateTimeOriginal and exif:DateTimeDigitized in XMP; "" = not said.
  std::vector<double> frame_times_s;        ///< ImageInfo's.
  std::string page;                         ///< Picture of several that it is, in words; "" = the only one.
  std::vector<std::string> problems;
  /// Why the picture is not to be read, though decoders read something of it: rows that lack, pictures of which they
  /// show the first alone. "" = it is. To the name of the file.
  std::string refusal;
};

/// PNG, JPEG, TIFF, GIF, WebP, JPEG 2000, HEIF and AVIF, BMP, TGA and Radiance; nothing of other files, and of damaged
/// ones what stands before the damage.
[[nodiscard]] FileWords read_file_words(const std::filesystem::path& path);

/// For a TGA whose palette does not begin with the first color, which OpenImageIO reads as if it did: the same with the
/// colors that lack before it. Nothing for other files.
[[nodiscard]] std::optional<std::string> tga_with_whole_palette(const std::filesystem::path& path);

/// Color that the words state. @param channels  Of color: 1 or 3. @param is_light  Primaries are of values that are
/// light, not of codes.
[[nodiscard]] SaidColor said_color(const FileWords& words, int channels, bool is_light);
/// Problem of pixels that are not square, which are taken as if they were. @param width  Of a pixel whose height is 1;
/// what is not > 0 says nothing. @returns "" for a width within 1 % of 1.
[[nodiscard]] std::string pixel_shape_problem(double width);

/// "turned by 90 degrees clockwise". @param orientation  EXIF's, [1, 8].
[[nodiscard]] std::string orientation_words(int orientation);
/// "turned by 90 degrees clockwise (EXIF orientation 6)"; "" for 1.
[[nodiscard]] std::string orientation_text(int orientation);

/// Readers of one format each, which set what it says.
void read_tiff_words(std::span<const unsigned char> bytes, FileWords& words);
void read_jpeg_2000_words(const FileBytes& file, FileWords& words);
void read_heif_words(const FileBytes& file, FileWords& words);
void read_radiance_words(const FileBytes& file, FileWords& words);
void read_gif_words(const FileBytes& file, FileWords& words);
/// @param little  Reads numbers with the least byte first, as all of WebP has them.
void read_webp_animation(const FileBytes& little, FileWords& words);
/// An XMP packet. Sets dates that no earlier packet gave.
void read_xmp_words(std::string_view packet, FileWords& words);
/// EXIF data (a TIFF without pixels). Sets orientation and color space.
void read_exif_words(std::span<const unsigned char> bytes, FileWords& words);

}  // namespace patinate
