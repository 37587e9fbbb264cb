#include <zlib.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/image/file_bytes.h"
#include "libcommon/image/file_words.h"

namespace patinate {

namespace {

using std::string_view_literals::operator""sv;

void set_orientation(std::uint64_t value, FileWords& words) {
  if (value >= 1 && value <= 8) {
    words.orientation = static_cast<int>(value);
  } else {
    words.problems.push_back("its orientation " + std::to_string(value) + " is none of EXIF's 1 to 8 and is not used");
  }
}

/// The entries of a TIFF's directories, of 32 or 64 bits.
class TiffBytes {
 public:
  struct Entry {
    unsigned type = 0;
    std::uint64_t count = 0;
    std::uint64_t at = 0;  ///< Offset of its values.
  };
  using Directory = std::map<unsigned, Entry>;

  explicit TiffBytes(std::span<const unsigned char> bytes) : bytes_(bytes, FileBytes(bytes).starts_with("II")) {
    const std::uint64_t magic = bytes_.number(2, 2);
    is_big_ = magic == 43;
    const bool has_order = bytes_.starts_with("II") || bytes_.starts_with("MM");
    // 42, 43 and what cameras put there (Olympus, Panasonic).
    first_ = has_order ? (is_big_ ? bytes_.number(8, 8) : bytes_.number(4, 4)) : 0;
  }
  [[nodiscard]] Directory first() const { return directory(first_); }
  /// Directories of all pages.
  [[nodiscard]] std::vector<Directory> pages() const {
    constexpr std::size_t kMaxPages = 4096;
    std::vector<Directory> pages;
    std::set<std::uint64_t> known;  // A chain may be closed to a ring.
    const unsigned word = is_big_ ? 8 : 4, head = is_big_ ? 8 : 2, size = is_big_ ? 20 : 12;
    for (std::uint64_t at = first_; at != 0 && known.insert(at).second && pages.size() < kMaxPages;) {
      pages.push_back(directory(at));
      at = bytes_.number(at + head + size * std::min<std::uint64_t>(bytes_.number(at, head), 4096), word);
    }
    return pages;
  }
  [[nodiscard]] Directory directory(std::uint64_t at) const {
    Directory found;
    if (at == 0) return found;
    const unsigned word = is_big_ ? 8 : 4, head = is_big_ ? 8 : 2, size = is_big_ ? 20 : 12;
    const std::uint64_t count = std::min<std::uint64_t>(bytes_.number(at, head), 4096);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t entry = at + head + i * size;
      if (!bytes_.holds(entry, size)) break;
      Entry e{static_cast<unsigned>(bytes_.number(entry + 2, 2)), bytes_.number(entry + 4, word), entry + 4 + word};
      if (e.count > bytes_.size()) continue;
      if (e.count * size_of(e.type) > word) e.at = bytes_.number(e.at, word);
      found.emplace(static_cast<unsigned>(bytes_.number(entry, 2)), e);
    }
    return found;
  }
  /// The first value of an entry of whole numbers, or the one at `index`.
  [[nodiscard]] std::optional<std::uint64_t> number(const Directory& in, unsigned tag, std::uint64_t index = 0) const {
    const auto found = in.find(tag);
    if (found == in.end() || found->second.count <= index) return {};
    const unsigned size = size_of(found->second.type);
    const std::uint64_t at = found->second.at + index * size;
    if (!(size == 1 || size == 2 || size == 4 || size == 8) || !bytes_.holds(at, size)) return {};
    return bytes_.number(at, size);
  }
  [[nodiscard]] std::uint64_t count(const Directory& in, unsigned tag) const {
    const auto found = in.find(tag);
    return found == in.end() ? 0 : found->second.count;
  }
  [[nodiscard]] std::span<const unsigned char> part(std::uint64_t at, std::uint64_t count) const {
    return bytes_.part(at, count);
  }
  /// Positive fractions; nothing if one of them is none.
  [[nodiscard]] std::vector<double> fractions(const Directory& in, unsigned tag) const {
    constexpr unsigned kRational = 5;
    const auto found = in.find(tag);
    std::vector<double> values;
    if (found == in.end() || found->second.type != kRational || found->second.count > 16) return values;
    for (std::uint64_t i = 0; i < found->second.count; ++i) {
      const std::uint64_t above = bytes_.number(found->second.at + 8 * i, 4),
                          below = bytes_.number(found->second.at + 8 * i + 4, 4);
      if (below == 0) return {};
      values.push_back(static_cast<double>(above) / static_cast<double>(below));
    }
    return values;
  }
  [[nodiscard]] std::string_view text(const Directory& in, unsigned tag) const {
    const auto found = in.find(tag);
    return found == in.end() ? ""sv : bytes_.text(found->second.at, found->second.count * size_of(found->second.type));
  }

 private:
  static unsigned size_of(unsigned type) {
    constexpr std::array<unsigned, 19> kSizes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    return type < kSizes.size() ? kSizes[type] : 0;
  }
  FileBytes bytes_;
  bool is_big_ = false;
  std::uint64_t first_ = 0;
};

void read_exif_directory(const TiffBytes& tiff, const TiffBytes::Directory& first, FileWords& words) {
  constexpr unsigned kOrientation = 274, kExif = 34665, kColorSpace = 40961, kInterop = 40965, kIndex = 1;
  if (const auto value = tiff.number(first, kOrientation)) set_orientation(*value, words);
  const TiffBytes::Directory exif = tiff.directory(tiff.number(first, kExif).value_or(0));
  const auto space = tiff.number(exif, kColorSpace);
  const TiffBytes::Directory interop = tiff.directory(tiff.number(exif, kInterop).value_or(0));
  const std::string_view index = tiff.text(interop, kIndex);
  constexpr std::uint64_t kSrgb = 1, kAdobe = 2;  // 2 is no standard, but what some cameras write.
  words.is_adobe_rgb = (index.starts_with("R03") && space != kSrgb) || space == kAdobe;
  words.is_srgb = space == kSrgb;
}

/// How many bytes a stream of zlib holds, counted up to `most`; nothing where it is damaged.
std::optional<std::uint64_t> inflated_size(std::span<const unsigned char> packed, std::uint64_t most) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  std::vector<unsigned char> out(std::size_t{1} << 16);
  std::uint64_t size = 0;
  int status = Z_OK;
  while (status == Z_OK && size < most) {
    if (stream.avail_in == 0) {
      constexpr std::size_t kPart = std::size_t{1} << 30;
      const std::size_t count = std::min(packed.size(), kPart);
      stream.next_in = const_cast<unsigned char*>(packed.data());  // zlib does not write there.
      stream.avail_in = static_cast<uInt>(count);
      packed = packed.subspan(count);
    }
    stream.next_out = out.data();
    stream.avail_out = static_cast<uInt>(out.size());
    status = inflate(&stream, Z_NO_FLUSH);
    size += out.size() - stream.avail_out;
  }
  inflateEnd(&stream);
  if (status == Z_OK || status == Z_STREAM_END) return size;
  return {};
}

/// The height that a JPEG stream states; nothing where it states none.
std::optional<std::uint64_t> jpeg_height(const FileBytes& stream) {
  if (!stream.starts_with("\xff\xd8")) return {};
  for (std::uint64_t at = 2; stream.number(at, 1) == 0xff && stream.holds(at, 9);) {
    const std::uint64_t marker = stream.number(at + 1, 1);
    const bool is_frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) return stream.number(at + 5, 2);
    at += 2 + stream.number(at + 2, 2);
  }
  return {};
}

/// How the pixels of a page are cut up.
struct TiffStrips {
  std::uint64_t width = 0, height = 0, rows_per_strip = 0;
  std::uint64_t num_planes = 1;         ///< Each has strips of its own.
  std::uint64_t samples_per_plane = 1;  ///< Samples per plane of a pixel.
  std::uint64_t bits = 1;               ///< Bits of a sample.
  [[nodiscard]] std::uint64_t strips_per_plane() const { return (height + rows_per_strip - 1) / rows_per_strip; }
  [[nodiscard]] std::uint64_t last_rows() const { return height - (strips_per_plane() - 1) * rows_per_strip; }
  [[nodiscard]] std::uint64_t row_bytes() const { return (width * samples_per_plane * bits + 7) / 8; }
};

constexpr unsigned kTiffOffsets = 273, kTiffByteCounts = 279;

/// Rows that the last strip lacks, where decoders take them for black without a word.
std::uint64_t missing_rows(const TiffBytes& tiff, const TiffBytes::Directory& page, const TiffStrips& strips,
                           std::uint64_t strip) {
  constexpr unsigned kCompression = 259, kPhotometric = 262;
  constexpr std::uint64_t kJpeg = 7, kDeflate = 8, kOldDeflate = 32946, kYCbCr = 6;
  const std::uint64_t compression = tiff.number(page, kCompression).value_or(1), rows = strips.last_rows();
  const auto bytes = tiff.part(tiff.number(page, kTiffOffsets, strip).value_or(0),
                               tiff.number(page, kTiffByteCounts, strip).value_or(0));
  if (compression == kJpeg) return rows - std::min(rows, jpeg_height(FileBytes(bytes)).value_or(rows));
  const bool is_deflate = compression == kDeflate || compression == kOldDeflate;
  if (!is_deflate || strips.row_bytes() == 0 || tiff.number(page, kPhotometric) == kYCbCr) return 0;
  constexpr std::uint64_t kMost = 1U << 28U;  // Limit of one strip; half a second.
  const std::uint64_t size = rows * strips.row_bytes();
  if (size > kMost) return 0;
  const auto held = inflated_size(bytes, size);
  return held ? rows - std::min(rows, *held / strips.row_bytes()) : 0;
}

/// Problem of a page that holds fewer rows than it says; "" where there is none.
std::string rows_damage(const TiffBytes& tiff, const TiffBytes::Directory& page) {
  constexpr unsigned kWidth = 256, kHeight = 257, kBits = 258, kSamples = 277, kRows = 278, kPlanar = 284,
                     kTileWidth = 322, kTileHeight = 323, kTileOffsets = 324;
  constexpr std::uint64_t kLargest = 1U << 16U;  // Limit of any side; what is larger is refused elsewhere.
  TiffStrips s{.width = tiff.number(page, kWidth).value_or(0), .height = tiff.number(page, kHeight).value_or(0)};
  if (s.width == 0 || s.height == 0 || s.width > kLargest || s.height > kLargest) return "";
  const std::uint64_t samples = std::clamp<std::uint64_t>(tiff.number(page, kSamples).value_or(1), 1, 4096);
  const bool is_planar = tiff.number(page, kPlanar) == 2U;
  s.num_planes = is_planar ? samples : 1;
  s.samples_per_plane = is_planar ? 1 : samples;
  s.bits = std::min<std::uint64_t>(tiff.number(page, kBits).value_or(1), 64);
  const std::string says = "says that it has " + std::to_string(s.height) + " rows and ";
  if (page.contains(kTileOffsets)) {
    const std::uint64_t w = tiff.number(page, kTileWidth).value_or(0), h = tiff.number(page, kTileHeight).value_or(0);
    if (w == 0 || h == 0) return "";
    const std::uint64_t needed = ((s.width + w - 1) / w) * ((s.height + h - 1) / h) * s.num_planes;
    const std::uint64_t there = tiff.count(page, kTileOffsets);
    if (there >= needed) return "";
    return says + "holds " + std::to_string(there) + " of their " + std::to_string(needed) + " tiles";
  }
  if (!page.contains(kTiffOffsets)) return "";
  s.rows_per_strip = std::clamp<std::uint64_t>(tiff.number(page, kRows).value_or(s.height), 1, s.height);
  const std::uint64_t needed = s.strips_per_plane() * s.num_planes;
  const std::uint64_t there = tiff.count(page, kTiffOffsets);
  if (there < needed) {
    const std::uint64_t rows = std::min(s.height, there / s.num_planes * s.rows_per_strip);
    return says + "holds " + std::to_string(rows);
  }
  const std::uint64_t missing = missing_rows(tiff, page, s, needed - 1);
  return missing == 0 ? "" : says + "holds " + std::to_string(s.height - missing);
}

/// Problem of the pages that are pictures.
std::string rows_damage(const TiffBytes& tiff) {
  constexpr unsigned kKind = 254;
  constexpr std::uint64_t kReduced = 1, kMask = 4;
  for (const TiffBytes::Directory& page : tiff.pages()) {
    if ((tiff.number(page, kKind).value_or(0) & (kReduced | kMask)) != 0) continue;
    if (std::string damage = rows_damage(tiff, page); !damage.empty()) return damage;
  }
  return "";
}

/// Some programs write the colors of a palette as 8 bits where TIFF has 16: decoders show them as black.
bool has_palette_of_bytes(const TiffBytes& tiff, const TiffBytes::Directory& page) {
  constexpr unsigned kPhotometric = 262, kColorMap = 320;
  constexpr std::uint64_t kPalette = 3, kLargestByte = 255;
  if (tiff.number(page, kPhotometric) != kPalette) return false;
  std::uint64_t largest = 0;
  for (std::uint64_t i = 0; i < tiff.count(page, kColorMap); ++i)
    largest = std::max(largest, tiff.number(page, kColorMap, i).value_or(0));
  return largest > 0 && largest <= kLargestByte;
}

}  // namespace

void read_tiff_words(std::span<const unsigned char> bytes, FileWords& words) {
  const TiffBytes tiff(bytes);
  const TiffBytes::Directory first = tiff.first();
  read_exif_directory(tiff, first, words);
  constexpr unsigned kBits = 258, kSamples = 277, kMaxSample = 281, kExtra = 338, kProfile = 34675, kWhite = 318,
                     kPrimaries = 319, kTransfer = 301, kXmp = 700, kAcross = 282, kDown = 283;
  words.icc = tiff.text(first, kProfile);
  read_xmp_words(tiff.text(first, kXmp), words);
  if (const std::string damage = rows_damage(tiff); !damage.empty())
    words.refusal = damage + "; it is damaged or was cut off";
  if (has_palette_of_bytes(tiff, first))
    words.refusal = "has a palette of 8 bits where TIFF has 16, so that it would be black; save it without a palette";
  const auto across = tiff.fractions(first, kAcross), down = tiff.fractions(first, kDown);
  if (across.size() == 1 && down.size() == 1 && across[0] > 0.0) {
    if (std::string problem = pixel_shape_problem(down[0] / across[0]); !problem.empty())
      words.problems.push_back(std::move(problem));
  }
  // The tag says what the largest value is, not how it looks; 4095 and such are how many bits a code has.
  const std::uint64_t largest = tiff.number(first, kMaxSample).value_or(0);
  if (tiff.number(first, kBits) == 16U && largest > 0xff && largest < 0xffff && ((largest + 1) & largest) == 0)
    words.largest_value = static_cast<int>(largest);
  const auto white = tiff.fractions(first, kWhite), primaries = tiff.fractions(first, kPrimaries);
  if (white.size() == 2 && white[0] > 0.0 && white[1] > 0.0) words.white = {white[0], white[1]};
  if (primaries.size() == 6) {
    const auto xy = [&](std::size_t i) { return std::array{primaries[i], primaries[i + 1]}; };
    words.primaries = Chromaticities{{xy(0), xy(2), xy(4), kRec709.xy[3]}};
    if (words.white) words.primaries->xy[3] = *words.white;
    words.primaries_by = "TIFF";
  }
  if (first.contains(kTransfer)) words.problems.emplace_back("its TransferFunction is not used");
  if (tiff.number(first, kSamples).value_or(1) > 1 && tiff.number(first, kExtra) == 0)
    words.unused_alpha = "the TIFF does not say that its extra channel is alpha";
}

void read_exif_words(std::span<const unsigned char> bytes, FileWords& words) {
  const TiffBytes tiff(bytes);
  read_exif_directory(tiff, tiff.first(), words);
}

}  // namespace patinate
