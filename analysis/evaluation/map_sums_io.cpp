#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "analysis/evaluation/map_figures.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kLongestPicture = 1600;       ///< Of the whole sheet, pixels.
constexpr float kGrayBetweenTiles = 0.18f;  ///< Between tiles.
constexpr int kGap = 2;

/// Bytes as they lie in memory; of whole numbers, runs of zeros are told by their length.
class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void operator()(const std::string& text) {
    (*this)(text.size());
    bytes_ += text;
  }
  void operator()(const std::vector<std::string>& texts) {
    (*this)(texts.size());
    for (const std::string& text : texts) (*this)(text);
  }
  void operator()(const std::vector<std::int64_t>& numbers) {
    (*this)(numbers.size());
    for (std::size_t i = 0; i < numbers.size();) {
      std::size_t end = i;
      while (end < numbers.size() && numbers[end] == 0) ++end;
      (*this)(static_cast<std::uint32_t>(end - i));
      if (end < numbers.size()) (*this)(numbers[end++]);
      i = end;
    }
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(std::string file, std::string bytes) : file_(std::move(file)), bytes_(std::move(bytes)) {}
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    take(&value, sizeof(T));
  }
  void operator()(std::string& text) {
    text.resize(size(1));
    take(text.data(), text.size());
  }
  void operator()(std::vector<std::string>& texts) {
    texts.resize(size(sizeof(std::size_t)));
    for (std::string& text : texts) (*this)(text);
  }
  void operator()(std::vector<std::int64_t>& numbers) {
    std::size_t count = 0;
    (*this)(count);
    if (count > kMost) fail();
    numbers.assign(count, 0);
    for (std::size_t i = 0; i < count;) {
      std::uint32_t zeros = 0;
      (*this)(zeros);
      if (zeros > count - i) fail();
      i += zeros;
      if (i < count) (*this)(numbers[i++]);
    }
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    values.resize(size(sizeof(T)));
    take(values.data(), values.size() * sizeof(T));
  }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 31;
  [[noreturn]] void fail() const { throw IoError(file_, "is damaged, or was made by another version"); }
  /// A count of elements of at least so many bytes each.
  std::size_t size(std::size_t bytes) {
    std::size_t count = 0;
    (*this)(count);
    if (count > (bytes_.size() - at_) / bytes) fail();
    return count;
  }
  void take(void* to, std::size_t count) {
    if (count > bytes_.size() - at_) fail();
    if (count > 0) std::memcpy(to, bytes_.data() + at_, count);
    at_ += count;
  }
  std::string file_, bytes_;
  std::size_t at_ = 0;
};

/// Size of a tile's picture.
struct TileSize {
  int width = 0, height = 0;
};
TileSize tile_size(const Sheet& sheet) {
  const int columns = std::max(sheet.columns, sheet.rows());
  const int longest = std::max(1, kLongestPicture / columns - kGap),
            side = std::max(sheet.tile_width, sheet.tile_height);
  const auto limited = [&](int n) {
    return side <= longest ? n : std::max(1, static_cast<int>(std::int64_t{n} * longest / side));
  };
  return {limited(sheet.tile_width), limited(sheet.tile_height)};
}

}  // namespace

ImageF tile_picture(ImageF picture, const Sheet& sheet, const RunControl& control) {
  if (sheet.num_tiles() == 1) return picture;
  const TileSize size = tile_size(sheet);
  picture = crop(picture, sheet.margin(), sheet.margin(), sheet.tile_width, sheet.tile_height);
  return size.width == sheet.tile_width ? picture : downscale_area(picture, size.width, size.height, control);
}

std::vector<Picture> sheet_pictures(std::vector<std::vector<Picture>> parts, const Sheet& sheet) {
  if (sheet.num_tiles() == 1) return std::move(parts.front());
  const TileSize size = tile_size(sheet);
  std::vector<Picture> out;
  for (std::size_t p = 0; p < parts.front().size(); ++p) {
    Picture whole{.name = parts.front()[p].name,
                  .caption = parts.front()[p].caption,
                  .image = ImageF(sheet.columns * (size.width + kGap) - kGap,
                                  sheet.rows() * (size.height + kGap) - kGap, 3, kGrayBetweenTiles)};
    if (size.width < sheet.tile_width)
      whole.caption += " (tiles of " + size_text(sheet.tile_width, sheet.tile_height) + ", shown at " +
                       size_text(size.width, size.height) + ")";
    for (std::size_t tile = 0; tile < parts.size(); ++tile) {
      const int x0 = static_cast<int>(tile) % sheet.columns * (size.width + kGap),
                y0 = static_cast<int>(tile) / sheet.columns * (size.height + kGap);
      const ImageF& from = parts[tile][p].image;
      for (int y = 0; y < from.height(); ++y)
        std::copy(from.row(y).begin(), from.row(y).end(), whole.image.pixel(x0, y0 + y).data());
    }
    out.push_back(std::move(whole));
  }
  return out;
}

void write_map_sums(const std::filesystem::path& file, MapSums sums) {
  Writer writer;
  sums.visit_members([&](auto& member) { writer(member); });
  writer(sums.pictures.size());
  for (const std::vector<Picture>& list : sums.pictures) {
    writer(list.size());
    for (const Picture& p : list) {
      writer(p.name), writer(p.caption), writer(p.image.width()), writer(p.image.height());
      writer(std::vector<float>(p.image.values().begin(), p.image.values().end()));
    }
  }
  write_atomically(file, writer.bytes());
}

MapSums read_map_sums(const std::filesystem::path& file) {
  Reader reader(file.string(), read_file(file));
  MapSums sums;
  sums.visit_members([&](auto& member) { reader(member); });
  std::size_t num_lists = 0;
  reader(num_lists);
  for (std::size_t i = 0; i < num_lists; ++i) {
    std::size_t num_pictures = 0;
    reader(num_pictures);
    std::vector<Picture> list;
    for (std::size_t k = 0; k < num_pictures; ++k) {
      Picture p;
      int width = 0, height = 0;
      std::vector<float> values;
      reader(p.name), reader(p.caption), reader(width), reader(height), reader(values);
      if (width < 0 || height < 0 ||
          values.size() != 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        throw IoError(file.string(), "is damaged, or was made by another version");
      p.image = ImageF(width, height, 3);
      std::copy(values.begin(), values.end(), p.image.values().begin());
      list.push_back(std::move(p));
    }
    sums.pictures.push_back(std::move(list));
  }
  return sums;
}

}  // namespace patinate::analysis
