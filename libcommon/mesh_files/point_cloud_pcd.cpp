#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/mesh_files/point_cloud_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::uint64_t kMaxPoints = std::uint64_t{1} << 28;
constexpr std::size_t kMaxFields = 64;

struct Field {
  std::string name;
  std::size_t size = 4;
  char type = 'F';
  std::size_t count = 1;
  std::size_t offset = 0;       ///< In a point, bytes.
  std::size_t first_value = 0;  ///< In an ASCII line.
};

/// PCD v0.5 to 0.7.
class PcdReader {
 public:
  explicit PcdReader(const std::filesystem::path& path)
      : file_(path.string()), bytes_(read_file(path)), rest_(bytes_) {}

  PointCloud read() {
    read_header();
    if (form_ == "ascii") {
      read_ascii();
    } else if (form_ == "binary") {
      read_binary(rest_, false);
    } else {
      read_compressed();
    }
    if (height_ > 1) {
      PointCloud::Grid grid{static_cast<int>(width_), static_cast<int>(height_), {}};
      for (std::uint64_t i = 0; i < num_points_; ++i) grid.cell.push_back(static_cast<int>(i));
      builder_.set_grid(std::move(grid));
    }
    PointCloud cloud = builder_.finish(file_);
    if (height_ > 1 || !viewpoint_.isZero()) cloud.scanner = viewpoint_;
    return cloud;
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw IoError(file_, problem); }

  std::string_view next_line() {
    if (rest_.empty()) fail("truncated: the PCD header has no DATA line");
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return line;
  }
  static std::string_view next_word(std::string_view& line) {
    const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
  }
  std::uint64_t whole_number(std::string_view word, std::uint64_t most, const char* what) const {
    std::uint64_t value = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || result.ec != std::errc() || result.ptr != word.data() + word.size() || value > most) {
      fail(std::string("PCD header: ") + what + " `" + std::string(word) + "`; expected a whole number up to " +
           std::to_string(most));
    }
    return value;
  }

  void read_header() {
    while (form_.empty()) {
      std::string_view line = next_line();
      if (line.starts_with('#')) continue;
      const std::string_view keyword = next_word(line);
      if (keyword == "FIELDS" || keyword == "COLUMNS") {
        for (std::string_view w = next_word(line); !w.empty(); w = next_word(line)) {
          if (fields_.size() == kMaxFields) fail("PCD header: more than 64 fields");
          fields_.push_back({.name = std::string(w)});
        }
      } else if (keyword == "SIZE") {
        for (Field& f : fields_) f.size = whole_number(next_word(line), 8, "SIZE");
      } else if (keyword == "TYPE") {
        for (Field& f : fields_) {
          const std::string_view word = next_word(line);
          f.type = word.size() == 1 ? word[0] : '?';
        }
      } else if (keyword == "COUNT") {
        for (Field& f : fields_) f.count = whole_number(next_word(line), 4096, "COUNT");
      } else if (keyword == "WIDTH") {
        width_ = whole_number(next_word(line), kMaxPoints, "WIDTH");
      } else if (keyword == "HEIGHT") {
        height_ = whole_number(next_word(line), kMaxPoints, "HEIGHT");
      } else if (keyword == "POINTS") {
        num_points_ = whole_number(next_word(line), kMaxPoints, "POINTS");
      } else if (keyword == "VIEWPOINT") {
        for (int k = 0; k < 3; ++k) viewpoint_[k] = parse_number(next_word(line)).value_or(0.0);
      } else if (keyword == "DATA") {
        form_ = next_word(line);
      } else if (keyword != "VERSION" && !keyword.empty()) {
        fail("is not a PCD file: its header holds `" + std::string(keyword.substr(0, 40)) + "`");
      }
    }
    if (form_ != "ascii" && form_ != "binary" && form_ != "binary_compressed") {
      fail("PCD data form `" + form_.substr(0, 40) + "` is unknown; expected ascii, binary or binary_compressed");
    }
    lay_out();
  }

  void lay_out() {
    if (num_points_ == 0) num_points_ = width_ * height_;
    if (width_ == 0) width_ = num_points_;
    if (width_ * height_ != num_points_) {
      fail("PCD header: WIDTH x HEIGHT is " + std::to_string(width_) + " x " + std::to_string(height_) + ", POINTS " +
           std::to_string(num_points_));
    }
    for (Field& f : fields_) {
      const bool is_known = f.type == 'F' ? f.size == 4 || f.size == 8
                                          : (f.type == 'I' || f.type == 'U') &&
                                                (f.size == 1 || f.size == 2 || f.size == 4 || f.size == 8);
      if (!is_known || f.count == 0) fail("PCD header: field `" + f.name + "` has no known type, size or count");
      f.offset = point_bytes_;
      f.first_value = num_values_;
      point_bytes_ += f.size * f.count;
      num_values_ += f.count;
    }
    for (std::size_t k = 0; k < 3; ++k) xyz_[k] = find(std::array<const char*, 3>{"x", "y", "z"}[k]);
    for (std::size_t k = 0; k < 3; ++k)
      normal_[k] = find(std::array<const char*, 3>{"normal_x", "normal_y", "normal_z"}[k]);
    rgb_ = find("rgb") >= 0 ? find("rgb") : find("rgba");
    if (xyz_[0] < 0 || xyz_[1] < 0 || xyz_[2] < 0) fail("PCD header: no fields x, y and z");
    if (rgb_ >= 0 && fields_[rgb_].size != 4) rgb_ = -1;
  }
  [[nodiscard]] int find(std::string_view name) const {
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (fields_[i].name == name) return static_cast<int>(i);
    }
    return -1;
  }

  /// @param value  Of a field, by its index. @param packed  The four bytes of rgb.
  template <class Value, class Packed>
  void add_point(const Value& value, const Packed& packed) {
    std::optional<Vec3> normal, color;
    if (normal_[0] >= 0 && normal_[1] >= 0 && normal_[2] >= 0)
      normal = Vec3(value(normal_[0]), value(normal_[1]), value(normal_[2]));
    if (rgb_ >= 0) {
      const std::uint32_t code = packed(rgb_);
      color = Vec3((code >> 16) & 255u, (code >> 8) & 255u, code & 255u) / 255.0;
    }
    builder_.add_point(Vec3(value(xyz_[0]), value(xyz_[1]), value(xyz_[2])), normal, color);
  }

  void read_ascii() {
    if (num_points_ > rest_.size() / 2 + 1) fail_truncated(0);
    std::vector<std::string_view> words;
    for (std::uint64_t row = 0; row < num_points_; ++row) {
      words.clear();
      while (words.empty()) {
        if (rest_.empty()) fail_truncated(row);
        std::string_view line = next_line();
        for (std::string_view w = next_word(line); !w.empty(); w = next_word(line)) words.push_back(w);
      }
      if (words.size() < num_values_)
        fail("point " + std::to_string(row) + " has " + std::to_string(words.size()) + " values; expected " +
             std::to_string(num_values_));
      const auto value = [&](int field) {
        std::string_view word = words[fields_[field].first_value];
        if (word.front() == '+') word.remove_prefix(1);
        double number = 0.0;
        const auto result = std::from_chars(word.data(), word.data() + word.size(), number);
        if (word.empty() || result.ec != std::errc() || result.ptr != word.data() + word.size()) {
          fail("point " + std::to_string(row) + ": `" + std::string(word.substr(0, 40)) + "` is not a number");
        }
        return number;
      };
      add_point(value, [&](int field) {
        const double number = value(field);
        if (fields_[field].type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(number));
        return number >= 0.0 && number < 4294967296.0 ? static_cast<std::uint32_t>(number) : 0u;
      });
    }
  }

  /// @param by_field  All values of the first field, then all of the second, as in binary_compressed.
  void read_binary(std::string_view data, bool by_field) {
    if (data.size() / point_bytes_ < num_points_) fail_truncated(data.size() / point_bytes_);
    for (std::uint64_t row = 0; row < num_points_; ++row) {
      const auto raw = [&](int field) {
        const Field& f = fields_[field];
        return data.data() +
               (by_field ? f.offset * num_points_ + row * f.size * f.count : row * point_bytes_ + f.offset);
      };
      add_point([&](int field) { return number_at(fields_[field], raw(field)); },
                [&](int field) {
                  std::uint32_t code = 0;
                  std::memcpy(&code, raw(field), sizeof code);
                  return code;
                });
    }
  }

  static double number_at(const Field& f, const char* raw) {
    const auto as = [raw](auto value) {
      std::memcpy(&value, raw, sizeof value);
      return static_cast<double>(value);
    };
    if (f.type == 'F') return f.size == 4 ? as(float{}) : as(double{});
    if (f.type == 'I')
      return f.size == 1   ? as(std::int8_t{})
             : f.size == 2 ? as(std::int16_t{})
             : f.size == 4 ? as(std::int32_t{})
                           : as(std::int64_t{});
    return f.size == 1   ? as(std::uint8_t{})
           : f.size == 2 ? as(std::uint16_t{})
           : f.size == 4 ? as(std::uint32_t{})
                         : as(std::uint64_t{});
  }

  void read_compressed() {
    std::uint32_t sizes[2] = {};
    if (rest_.size() < sizeof sizes) fail_truncated(0);
    std::memcpy(sizes, rest_.data(), sizeof sizes);
    const std::string_view data = rest_.substr(sizeof sizes);
    if (sizes[0] > data.size())
      fail("truncated: " + std::to_string(data.size()) + " bytes of compressed points; the file says " +
           std::to_string(sizes[0]));
    if (sizes[1] / point_bytes_ != num_points_ || sizes[1] % point_bytes_ != 0) {
      fail("compressed points take " + std::to_string(sizes[1]) + " bytes; expected " + std::to_string(num_points_) +
           " x " + std::to_string(point_bytes_));
    }
    std::string raw;
    try {
      raw = lzf_decompress(data.substr(0, sizes[0]), sizes[1]);
    } catch (const InvalidInput& e) {
      fail(e.what());
    }
    read_binary(raw, true);
  }

  [[noreturn]] void fail_truncated(std::uint64_t row) const {
    fail("truncated: ends in point " + std::to_string(row) + " of " + std::to_string(num_points_));
  }

  std::string file_;
  std::string bytes_;
  std::string_view rest_;
  std::string form_;
  std::vector<Field> fields_;
  std::uint64_t width_ = 0, height_ = 1, num_points_ = 0;
  std::size_t point_bytes_ = 0, num_values_ = 0;
  std::array<int, 3> xyz_{-1, -1, -1}, normal_{-1, -1, -1};
  int rgb_ = -1;
  Vec3 viewpoint_ = Vec3::Zero();
  PointCloudBuilder builder_;
};

}  // namespace

std::string lzf_decompress(std::string_view compressed, std::size_t size) {
  constexpr std::size_t kMaxGrowth = 300;  // A back reference of 3 bytes gives at most 264.
  if (size / kMaxGrowth > compressed.size()) throw InvalidInput("compressed data is too short for what it should hold");
  const auto fail = [] { throw InvalidInput("compressed data is damaged"); };
  std::string out;
  out.reserve(size);
  const auto byte = [&](std::size_t at) -> std::size_t {
    if (at >= compressed.size()) fail();
    return static_cast<unsigned char>(compressed[at]);
  };
  for (std::size_t at = 0; at < compressed.size();) {
    const std::size_t control = byte(at++);
    if (control < 32) {  // So many bytes and one as they are.
      if (at + control + 1 > compressed.size() || out.size() + control + 1 > size) fail();
      out.append(compressed.substr(at, control + 1));
      at += control + 1;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) length += byte(at++);
    const std::size_t back = ((control & 31) << 8) + byte(at++) + 1;
    if (back > out.size() || out.size() + length + 2 > size) fail();
    for (std::size_t k = 0; k < length + 2; ++k) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) fail();
  return out;
}

PointCloud read_pcd_cloud(const std::filesystem::path& path) { return PcdReader(path).read(); }

}  // namespace patinate
