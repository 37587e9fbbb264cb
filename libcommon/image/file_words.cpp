#include "libcommon/image/file_words.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "libcommon/core/file_name.h"
#include "libcommon/core/mapped_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/file_bytes.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using std::string_view_literals::operator""sv;

constexpr int kMostPieces = 100'000;  ///< Most pieces of a file that is followed from piece to piece.
constexpr std::size_t kLargestWords = std::size_t{64} << 20;

/// A zlib stream, as far as it is no larger than words may be.
std::optional<std::string> inflated(std::span<const unsigned char> from) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = const_cast<Bytef*>(from.data());
  stream.avail_in = static_cast<uInt>(from.size());
  std::string all;
  int state = Z_OK;
  while (state == Z_OK && all.size() < kLargestWords) {
    std::array<char, 16384> part{};
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = part.size();
    state = inflate(&stream, Z_NO_FLUSH);
    all.append(part.data(), part.size() - stream.avail_out);
    if (stream.avail_in == 0 && stream.avail_out == part.size()) break;
  }
  (void)inflateEnd(&stream);
  if (state != Z_STREAM_END) return {};
  return all;
}

void read_png_profile(const FileBytes& chunk, FileWords& words) {
  const std::string_view all = chunk.text(0, chunk.size());
  const std::size_t name = all.find('\0');
  const auto profile = name == std::string_view::npos ? std::nullopt : inflated(chunk.part(name + 2, chunk.size()));
  if (profile) words.icc = *profile;
  if (!profile) words.problems.emplace_back("its ICC profile is damaged and is not used");
}

/// Hexadecimal EXIF data, as ImageMagick puts it into a text: a line feed, "exif", the size, then digits.
std::string exif_of_text(std::string_view text) {
  std::string bytes;
  int high = -1;
  int line = 0;
  for (const char c : text) {
    line += c == '\n';
    const auto digit = "0123456789abcdef"sv.find(c);
    if (line < 3 || digit == std::string_view::npos) continue;
    if (high < 0) {
      high = static_cast<int>(digit);
    } else {
      bytes.push_back(static_cast<char>(16 * high + static_cast<int>(digit)));
      high = -1;
    }
  }
  constexpr std::string_view kHead = "Exif\0\0"sv;
  return bytes.starts_with(kHead) ? bytes.substr(kHead.size()) : bytes;
}

std::span<const unsigned char> bytes_of(std::string_view text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

/// Pixels a length, across and down.
void note_density(double across, double down, FileWords& words) {
  if (std::string problem = across > 0.0 ? pixel_shape_problem(down / across) : ""; !problem.empty())
    words.problems.push_back(std::move(problem));
}

void read_png_chunk(std::string_view type, const FileBytes& chunk, FileWords& words) {
  constexpr double kScale = 1e5;
  if (type == "iCCP") read_png_profile(chunk, words);
  if (type == "sRGB") words.is_srgb = true;
  if (type == "eXIf") read_exif_words(chunk.part(0, chunk.size()), words);
  if (type == "cICP" && chunk.size() >= 4) {
    words.code_points = ColorCodePoints{static_cast<int>(chunk.number(0, 1)), static_cast<int>(chunk.number(1, 1)),
                                        chunk.number(3, 1) != 0};
  }
  if (type == "gAMA") {
    const double gamma = static_cast<double>(chunk.number(0, 4)) / kScale;
    constexpr double kLeast = 0.01, kMost = 100.0;
    if (gamma >= kLeast && gamma <= kMost) words.png_gamma = gamma;
    if (!words.png_gamma) words.problems.emplace_back("its gAMA " + short_number_text(gamma) + " is not used");
  }
  if (type == "cHRM" && chunk.size() >= 32) {
    const auto xy = [&](unsigned i) {
      return std::array{static_cast<double>(chunk.number(8 * i, 4)) / kScale,
                        static_cast<double>(chunk.number(8 * i + 4, 4)) / kScale};
    };
    words.primaries = Chromaticities{{xy(1), xy(2), xy(3), xy(0)}};  // The chunk begins with white.
    words.primaries_by = "PNG cHRM";
  }
  // Pixels a length, across and down.
  if (type == "pHYs" && chunk.size() >= 8)
    note_density(static_cast<double>(chunk.number(0, 4)), static_cast<double>(chunk.number(4, 4)), words);
  const std::uint64_t num_pictures = type == "acTL" ? chunk.number(0, 4) : 1;
  if (num_pictures > 1)
    words.refusal = "is an animated PNG of " + std::to_string(num_pictures) +
                    " pictures, which is not read; save them as files of their own, as a GIF or as a movie";
  // OpenImageIO reads XMP where the orientation is an element, not an attribute.
  constexpr std::string_view kXmp = "XML:com.adobe.xmp", kOrientation = "tiff:Orientation=\"";
  const std::string_view international = type == "iTXt" ? chunk.text(0, chunk.size()) : ""sv;
  if (const std::size_t at = international.find(kOrientation);
      international.starts_with(kXmp) && at != std::string_view::npos && words.orientation == 1) {
    const std::string_view value = international.substr(at + kOrientation.size(), 2);
    if (value.size() == 2 && value[0] >= '1' && value[0] <= '8' && value[1] == '"') words.orientation = value[0] - '0';
  }
  if (international.starts_with(kXmp)) read_xmp_words(international, words);
  constexpr std::string_view kText = "Raw profile type ";
  const std::string_view text = type == "zTXt" ? chunk.text(0, chunk.size()) : ""sv;
  const std::size_t end = text.find('\0');
  if (text.starts_with(kText) && (text.substr(kText.size(), 4) == "exif" || text.substr(kText.size(), 4) == "APP1") &&
      end != std::string_view::npos) {
    if (const auto inner = inflated(chunk.part(end + 2, chunk.size())))
      read_exif_words(bytes_of(exif_of_text(*inner)), words);
  }
}

void read_png_words(const FileBytes& file, FileWords& words) {
  constexpr std::uint64_t kSignature = 8, kHead = 8, kCheck = 4;
  std::uint64_t at = kSignature;
  for (int i = 0; i < kMostPieces && file.holds(at, kHead + kCheck); ++i) {
    const std::uint64_t size = file.number(at, 4);
    const std::string_view type = file.text(at + 4, 4);
    if (!file.holds(at + kHead, size + kCheck) || type == "IEND") return;
    constexpr std::array kWords{"iCCP"sv, "sRGB"sv, "eXIf"sv, "cICP"sv, "gAMA"sv,
                                "cHRM"sv, "zTXt"sv, "iTXt"sv, "acTL"sv, "pHYs"sv};
    if (std::find(kWords.begin(), kWords.end(), type) != kWords.end() && size <= kLargestWords) {
      const auto checked = file.part(at + 4, size + 4);
      if (::crc32(0, checked.data(), static_cast<uInt>(checked.size())) == file.number(at + kHead + size, 4))
        read_png_chunk(type, FileBytes(file.part(at + kHead, size)), words);
      else
        words.problems.push_back("its " + std::string(type) + " chunk is damaged and is not used");
    }
    at += kHead + size + kCheck;
  }
}

/// The index of a JPEG with further pictures behind the first: previews, a gain map, the other eye.
void note_pictures(const FileBytes& index, FileWords& words) {
  constexpr std::uint64_t kCountTag = 0xb001;
  const FileBytes tiff(index.part(0, index.size()), index.starts_with("II"));
  const std::uint64_t directory = tiff.number(4, 4), num_entries = tiff.number(directory, 2);
  for (std::uint64_t i = 0; i < num_entries && tiff.holds(directory, 2 + 12 * (i + 1)); ++i) {
    const std::uint64_t entry = directory + 2 + 12 * i, count = tiff.number(entry + 8, 4);
    if (tiff.number(entry, 2) == kCountTag && count > 1)
      words.page = "the first picture of " + std::to_string(count) + " (MPF)";
  }
}

/// The segments before the picture; an ICC profile in pieces, each with its number.
void read_jpeg_words(const FileBytes& file, FileWords& words) {
  constexpr std::uint64_t kApp0 = 0xe0, kApp1 = 0xe1, kApp2 = 0xe2, kStartOfScan = 0xda, kEnd = 0xd9;
  constexpr std::string_view kExif = "Exif\0\0"sv, kProfile = "ICC_PROFILE\0"sv,
                             kXmp = "http://ns.adobe.com/xap/1.0/\0"sv, kPictures = "MPF\0"sv;
  std::map<std::uint64_t, std::string> pieces;
  std::uint64_t num_pieces = 0, at = 2;
  for (int i = 0; i < kMostPieces && file.holds(at, 4); ++i) {
    if (file.number(at, 1) != 0xff) break;
    const std::uint64_t marker = file.number(at + 1, 1);
    if (marker == 0xff) {  // A fill byte.
      ++at;
      continue;
    }
    if (marker == kStartOfScan || marker == kEnd) break;
    const std::uint64_t size = file.number(at + 2, 2), data = at + 4;
    if (size < 2) break;
    if (marker == kApp0 && file.starts_with("JFIF\0"sv, data))
      note_density(static_cast<double>(file.number(data + 8, 2)), static_cast<double>(file.number(data + 10, 2)),
                   words);
    if (marker == kApp1 && file.starts_with(kExif, data))
      read_exif_words(file.part(data + kExif.size(), size - 2 - kExif.size()), words);
    if (marker == kApp1 && file.starts_with(kXmp, data))
      read_xmp_words(file.text(data + kXmp.size(), size - 2 - std::min<std::uint64_t>(size - 2, kXmp.size())), words);
    if (marker == kApp2 && file.starts_with(kProfile, data) && size > 2 + kProfile.size() + 2) {
      const std::uint64_t head = data + kProfile.size();
      num_pieces = file.number(head + 1, 1);
      pieces.emplace(file.number(head, 1), file.text(head + 2, size - 2 - kProfile.size() - 2));
    }
    if (marker == kApp2 && file.starts_with(kPictures, data))
      note_pictures(FileBytes(file.part(data + kPictures.size(), size - 2 - kPictures.size())), words);
    at += 2 + size;
  }
  if (pieces.empty()) return;
  if (pieces.size() != num_pieces || pieces.begin()->first != 1 || pieces.rbegin()->first != num_pieces) {
    words.problems.emplace_back("its ICC profile lacks pieces and is not used");
    return;
  }
  for (const auto& [number, piece] : pieces) words.icc += piece;
}

void read_webp_words(const FileBytes& big, FileWords& words) {
  const FileBytes file(big.part(0, big.size()), true);
  constexpr std::uint64_t kHead = 8;
  constexpr std::string_view kExif = "Exif\0\0"sv;
  std::uint64_t at = 12;
  for (int i = 0; i < kMostPieces && file.holds(at, kHead); ++i) {
    const std::string_view type = file.text(at, 4);
    const std::uint64_t size = file.number(at + 4, 4);
    if (type == "ICCP") words.icc = file.text(at + kHead, size);
    if (type == "XMP ") read_xmp_words(file.text(at + kHead, size), words);
    if (type == "EXIF") {
      const std::uint64_t skip = file.starts_with(kExif, at + kHead) ? kExif.size() : 0;
      if (size > skip) read_exif_words(file.part(at + kHead + skip, size - skip), words);
    }
    at += kHead + size + size % 2;
  }
  read_webp_animation(file, words);
}

/// OpenImageIO reads inks without their profile, and others not at all.
void read_psd_words(const FileBytes& file, FileWords& words) {
  constexpr std::uint64_t kMode = 24;
  constexpr std::array kNames{""sv, ""sv, ""sv, ""sv, "CMYK"sv, ""sv, ""sv, "multichannel"sv, "duotone"sv, "Lab"sv};
  const std::uint64_t mode = file.number(kMode, 2);
  if (mode < kNames.size() && !kNames[mode].empty())
    words.refusal = "is a PSD in " + std::string(kNames[mode]) + " mode, which is not read; save it in RGB mode";
}

/// 32 bits a pixel of which a header of version 3 says nothing, or that has no mask for alpha.
void read_bmp_words(const FileBytes& big, FileWords& words) {
  const FileBytes file(big.part(0, big.size()), true);
  constexpr std::uint64_t kHeader = 14, kBitFields = 3, kAlphaBitFields = 6, kMasked = 56;
  const std::uint64_t header = file.number(kHeader, 4), bits = file.number(kHeader + 14, 2),
                      compression = file.number(kHeader + 16, 4);
  if (bits != 32) return;
  const bool has_masks = header >= kMasked || compression == kAlphaBitFields;
  const bool is_masked = compression == kBitFields || compression == kAlphaBitFields;
  if (!is_masked || !has_masks || file.number(kHeader + 52, 4) == 0)
    words.unused_alpha = "the BMP header declares no alpha";
}

/// By the attribute bits of the header, or what the area behind the picture (TGA 2.0) says of them.
void read_tga_words(const FileBytes& big, FileWords& words) {
  const FileBytes file(big.part(0, big.size()), true);
  constexpr std::uint64_t kFooter = 26, kAttributes = 494;
  const std::uint64_t footer = file.size() >= kFooter ? file.size() - kFooter : 0;
  if (file.starts_with("TRUEVISION-XFILE", footer + 8)) {
    const std::uint64_t extension = file.number(footer, 4);
    if (extension != 0 && file.number(extension, 2) > kAttributes) {
      constexpr std::uint64_t kUseful = 3, kPremultiplied = 4;
      const std::uint64_t kind = file.number(extension + kAttributes, 1);
      if (kind != kUseful && kind != kPremultiplied) words.unused_alpha = "the TGA declares its fourth byte no alpha";
      return;
    }
  }
  if ((file.number(17, 1) & 0x0f) == 0) words.unused_alpha = "the TGA header declares no attribute bits";
}

bool is_tga(const FileBytes& big, const std::filesystem::path& path) {
  const FileBytes file(big.part(0, big.size()), true);
  const std::string extension = lower_extension(path);
  constexpr std::array kTypes{1U, 2U, 3U, 9U, 10U, 11U};
  const bool is_type = std::find(kTypes.begin(), kTypes.end(), file.number(2, 1)) != kTypes.end();
  return is_type && (extension == ".tga" || extension == ".tpic" || extension == ".icb" || extension == ".vda" ||
                     extension == ".vst");
}

}  // namespace

void read_xmp_words(std::string_view packet, FileWords& words) {
  const auto value = [&](std::string_view name, std::string& to) {
    constexpr std::size_t kLongest = 64;
    for (const bool is_attribute : {true, false}) {
      const std::string begin = is_attribute ? " " + std::string(name) + "=\"" : "<" + std::string(name) + ">";
      const std::size_t at = packet.find(begin);
      if (at == std::string_view::npos || !to.empty()) continue;
      const std::string_view rest = packet.substr(at + begin.size(), kLongest);
      const std::size_t end = rest.find(is_attribute ? '"' : '<');
      if (end != std::string_view::npos) to = rest.substr(0, end);
    }
  };
  value("exif:DateTimeOriginal", words.xmp_original);
  value("exif:DateTimeDigitized", words.xmp_digitized);
}

FileWords read_file_words(const std::filesystem::path& path) {
  FileWords words;
  const MappedFile mapped(path);
  const FileBytes file(mapped.all<unsigned char>());
  if (file.starts_with("\x89PNG\r\n\x1a\n")) read_png_words(file, words);
  if (file.starts_with("\xff\xd8")) read_jpeg_words(file, words);
  if (file.starts_with("II*\0"sv) || file.starts_with("MM\0*"sv) || file.starts_with("II+\0"sv) ||
      file.starts_with("MM\0+"sv))
    read_tiff_words(file.part(0, file.size()), words);
  if (file.starts_with("RIFF") && file.starts_with("WEBP", 8)) read_webp_words(file, words);
  if (file.starts_with("GIF8")) read_gif_words(file, words);
  if (file.starts_with("\0\0\0\x0cjP  "sv)) read_jpeg_2000_words(file, words);
  if (file.starts_with("ftyp", 4)) read_heif_words(file, words);
  if (file.starts_with("8BPS")) read_psd_words(file, words);
  if (file.starts_with("BM")) read_bmp_words(file, words);
  if (file.starts_with("#?RADIANCE") || file.starts_with("#?RGBE")) read_radiance_words(file, words);
  if (is_tga(file, path)) read_tga_words(file, words);
  return words;
}

std::optional<std::string> tga_with_whole_palette(const std::filesystem::path& path) {
  const MappedFile mapped(path);
  const FileBytes big(mapped.all<unsigned char>());
  const FileBytes file(big.part(0, big.size()), true);
  constexpr std::uint64_t kHeader = 18, kFooter = 26;
  const std::uint64_t first = file.number(3, 2), count = file.number(5, 2), bits = file.number(7, 1);
  const bool has_palette = file.number(1, 1) == 1 && (file.number(2, 1) == 1 || file.number(2, 1) == 9);
  if (!is_tga(big, path) || !has_palette || first == 0 || first + count > 0xffff) return std::nullopt;
  const std::uint64_t palette = kHeader + file.number(0, 1);
  std::uint64_t end = file.size();
  if (end > kFooter && file.starts_with("TRUEVISION-XFILE", end - kFooter + 8)) end -= kFooter;  // It counts bytes.
  if (palette > end) return std::nullopt;
  std::string whole(file.text(0, palette));
  whole.append(first * ((bits + 7) / 8), '\0').append(file.text(palette, end - palette));
  whole[3] = whole[4] = '\0';
  whole[5] = static_cast<char>((first + count) & 0xff);
  whole[6] = static_cast<char>((first + count) >> 8);
  return whole;
}

}  // namespace patinate
