#include <algorithm>
#include <array>
#include <map>
#include <span>
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
    std::uint64_t at = 0;  ///< Of its values.
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
  /// The first value of an entry of whole numbers.
  [[nodiscard]] std::optional<std::uint64_t> number(const Directory& in, unsigned tag) const {
    const auto found = in.find(tag);
    if (found == in.end() || found->second.count == 0) return {};
    const unsigned size = size_of(found->second.type);
    if (!(size == 1 || size == 2 || size == 4 || size == 8) || !bytes_.holds(found->second.at, size)) return {};
    return bytes_.number(found->second.at, size);
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

}  // namespace

void read_tiff_words(std::span<const unsigned char> bytes, FileWords& words) {
  const TiffBytes tiff(bytes);
  const TiffBytes::Directory first = tiff.first();
  read_exif_directory(tiff, first, words);
  constexpr unsigned kBits = 258, kSamples = 277, kMaxSample = 281, kExtra = 338, kProfile = 34675, kWhite = 318,
                     kPrimaries = 319, kTransfer = 301;
  words.icc = tiff.text(first, kProfile);
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
