#include "transfer/exemplar/appearance_io.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <ios>
#include <span>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/read_limit.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kKeySize = 32;
constexpr std::size_t kPiece = std::size_t{1} << 20;  // Bytes between two looks at the stop.
constexpr int kMaxLevels = 31;

/// Without gaps, as it stands in the file.
struct Header {
  std::array<char, 16> format;
  std::array<char, kKeySize> key;
  std::int32_t width, height, num_asked, num_levels;
  double explained_variance;
};
static_assert(sizeof(Header) == 72);
constexpr std::array<char, 16> kFormat{'p', 'a', 't', 'i', 'n', 'a', 't', 'e', '.', 'l', 'o', 'o', 'k', '0', '0', '1'};

std::uint64_t level_bytes(std::uint64_t num_pixels, int level) {
  return sizeof(double) + num_pixels * kAppearanceSize * sizeof(std::int16_t) + (level > 0 ? num_pixels : 0);
}

int halved(int side) { return std::max(1, side / 2); }

/// Passes bytes to or from a file, and into their key.
class Passage {
 public:
  explicit Passage(const RunControl& control) : control_(control) {}
  template <class Pass>
  void run(std::span<const std::byte> bytes, const Pass& pass) {
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
      control_.throw_if_stopped();
      const std::size_t size = std::min(kPiece, bytes.size() - at);
      pass(at, static_cast<std::streamsize>(size));
      hash_.add(bytes.subspan(at, size));
    }
  }
  [[nodiscard]] std::string key() const { return hash_.hex(); }

 private:
  const RunControl& control_;
  ContentHash hash_;
};

template <class T>
std::span<const T, 1> one(const T& value) {
  return std::span<const T, 1>(&value, 1);
}

/// @throws IoError unless the level's values can be an appearance: whoever compares them relies on it.
void check_level(const fs::path& file, const AppearanceImage& level, double variance) {
  const auto is_valid = [](std::int16_t v) { return v >= -kAppearanceLimit && v <= kAppearanceLimit; };
  if (std::isfinite(variance) && variance >= 0.0 && std::all_of(level.values().begin(), level.values().end(), is_valid))
    return;
  throw IoError(file.string(), "holds values that are no appearance");
}

}  // namespace

std::uint64_t appearance_file_size(int width, int height, int num_levels) {
  std::uint64_t size = sizeof(Header) + kKeySize;
  for (int l = 0; l < num_levels; ++l, width = halved(width), height = halved(height)) {
    size += level_bytes(static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height), l);
  }
  return size;
}

void write_appearance(const fs::path& file, const KeptAppearance& kept, const RunControl& control) {
  const AppearanceSpace& space = kept.space;
  Header header{kFormat,
                {},
                space.levels[0].width(),
                space.levels[0].height(),
                kept.num_asked,
                static_cast<std::int32_t>(space.levels.size()),
                space.explained_variance};
  if (kept.key.size() != kKeySize) throw InvalidInput("appearance: its key has not 32 digits");
  std::copy(kept.key.begin(), kept.key.end(), header.key.begin());

  AtomicFile place(file);
  std::ofstream out(place.temporary(), std::ios::binary);
  Passage passage(control);
  const auto put = [&](std::span<const std::byte> bytes) {
    passage.run(bytes, [&](std::size_t at, std::streamsize size) {
      if (!out.write(reinterpret_cast<const char*>(bytes.data()) + at, size))
        throw CannotComplete(file.string() + ": cannot be written");
    });
  };
  put(std::as_bytes(one(header)));
  for (std::size_t l = 0; l < space.levels.size(); ++l) {
    put(std::as_bytes(one(space.variances[l])));
    put(std::as_bytes(space.levels[l].values()));
    if (l > 0) put(std::as_bytes(space.masks[l].values()));
  }
  const std::string key = passage.key();
  out.write(key.data(), static_cast<std::streamsize>(key.size()));
  out.close();
  if (!out) throw CannotComplete(file.string() + ": cannot be written");
  place.finish_unsynced();
}

AppearanceSpace read_appearance(const fs::path& file, const std::string& key, int num_levels, const ImageU8& mask,
                                const RunControl& control) {
  check_may_read(file);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) throw IoError(file.string(), "is no file");
  const std::uint64_t size = fs::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  Passage passage(control);
  const auto get = [&](std::span<std::byte> bytes) {
    passage.run(bytes, [&](std::size_t at, std::streamsize part) {
      if (!in.read(reinterpret_cast<char*>(bytes.data()) + at, part)) throw IoError(file.string(), "ends too early");
    });
  };
  Header header{};
  get(std::as_writable_bytes(std::span(&header, 1)));
  if (header.format != kFormat || !std::equal(header.key.begin(), header.key.end(), key.begin(), key.end()))
    throw IoError(file.string(), "belongs to something else");
  const bool is_one = header.width == mask.width() && header.height == mask.height() && header.num_levels >= 1 &&
                      header.num_levels <= kMaxLevels && header.explained_variance >= 0.0 &&
                      header.explained_variance <= 1.0;
  if (error || !is_one || size != appearance_file_size(header.width, header.height, header.num_levels))
    throw IoError(file.string(), "is not as long as its levels");
  if (header.num_asked < num_levels) throw IoError(file.string(), "holds fewer levels than are asked for");

  AppearanceSpace space;
  space.explained_variance = header.explained_variance;
  for (int l = 0, width = header.width, height = header.height; l < header.num_levels;
       ++l, width = halved(width), height = halved(height)) {
    space.variances.emplace_back();
    get(std::as_writable_bytes(std::span(&space.variances.back(), 1)));
    get(std::as_writable_bytes(space.levels.emplace_back(width, height, kAppearanceSize).values()));
    space.masks.push_back(l == 0 ? mask : ImageU8(width, height));
    if (l > 0) get(std::as_writable_bytes(space.masks.back().values()));
    check_level(file, space.levels.back(), space.variances.back());
  }
  std::array<char, kKeySize> written{};
  if (!in.read(written.data(), written.size()) || std::string_view(written.data(), written.size()) != passage.key())
    throw IoError(file.string(), "is damaged");
  const auto kept = static_cast<std::size_t>(std::min(num_levels, header.num_levels));
  space.levels.resize(kept);
  space.masks.resize(kept);
  space.variances.resize(kept);
  return space;
}

}  // namespace patinate::transfer
