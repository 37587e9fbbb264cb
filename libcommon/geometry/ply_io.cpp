#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/geometry/mesh_builder.h"
#include "libcommon/geometry/mesh_formats.h"

namespace patinate {

namespace {

enum class Number { I8, U8, I16, U16, I32, U32, F32, F64 };
enum class Form { Ascii, LittleEndian, BigEndian };

std::size_t size_of(Number type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::optional<Number> number_of(std::string_view name) {
  constexpr std::string_view kNames[] = {"char", "uchar", "short", "ushort", "int",   "uint",   "float",   "double",
                                         "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  const auto* found = std::find(std::begin(kNames), std::end(kNames), name);
  if (found == std::end(kNames)) return std::nullopt;
  return static_cast<Number>((found - std::begin(kNames)) % 8);
}

struct Property {
  std::string name;
  Number type = Number::F32;
  std::optional<Number> count_type;  ///< Only of lists.
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  /// Position of the first property with one of these names; -1 = none.
  [[nodiscard]] int find(std::initializer_list<std::string_view> names) const {
    for (std::string_view wanted : names) {
      for (std::size_t i = 0; i < properties.size(); ++i) {
        if (properties[i].name == wanted) return static_cast<int>(i);
      }
    }
    return -1;
  }
  /// Bytes that one row takes at least.
  [[nodiscard]] std::uint64_t min_row_bytes(Form form) const {
    std::uint64_t bytes = 0;
    for (const Property& p : properties) bytes += form == Form::Ascii ? 2 : size_of(p.count_type.value_or(p.type));
    return bytes;
  }
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r\n"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path)
      : file_(path.string()), bytes_(read_file(path)), rest_(bytes_), builder_(file_) {}

  Mesh read() {
    read_header();
    bool has_faces = false;
    for (const Element& e : elements_) {
      element_ = &e;
      const std::uint64_t min_bytes = e.min_row_bytes(form_);
      // The last ASCII value needs no blank behind it.
      if (min_bytes > 0 && e.count > (rest_.size() + 1) / min_bytes) fail_truncated(0);
      if (e.name == "vertex") {
        read_vertices();
      } else if (e.name == "face" || e.name == "tristrips") {
        has_faces = has_faces || e.count > 0;
        read_faces(e.name == "tristrips");
      } else {
        for (row_ = 0; min_bytes > 0 && row_ < e.count; ++row_) read_row();
      }
    }
    if (!has_faces) {
      throw IoError(
          file_, "no faces, only " + std::to_string(vertices_.size()) + " points (a point cloud); a surface is needed");
    }
    return builder_.finish();
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw IoError(file_, problem); }
  [[noreturn]] void fail_truncated(std::uint64_t row) const {
    fail("truncated: ends in element `" + element_->name + "`, row " + std::to_string(row) + " of " +
         std::to_string(element_->count));
  }

  std::string_view next_line() {
    const std::size_t end = rest_.find_first_of("\r\n");
    if (end == std::string_view::npos) fail("truncated: the PLY header has no end_header");
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + (rest_.substr(end, 2) == "\r\n" ? 2 : 1));
    return line;
  }

  void read_header() {
    if (rest_.substr(0, 3) != "ply") fail("is not a PLY file; its first line must be `ply`");
    next_line();
    bool has_format = false;
    while (true) {
      const std::vector<std::string_view> words = words_of(next_line());
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format") {
        read_format(words);
        has_format = true;
      } else if (words[0] == "element") {
        read_element(words);
      } else if (words[0] == "property") {
        read_property(words);
      }
    }
    if (!has_format) fail("the PLY header has no `format` line");
  }

  void read_format(const std::vector<std::string_view>& words) {
    const std::string_view name = words.size() > 1 ? words[1] : "";
    if (name == "ascii") {
      form_ = Form::Ascii;
    } else if (name == "binary_little_endian") {
      form_ = Form::LittleEndian;
    } else if (name == "binary_big_endian") {
      form_ = Form::BigEndian;
    } else {
      fail("PLY format `" + std::string(name) + "` is unknown; use ascii, binary_little_endian or binary_big_endian");
    }
  }

  void read_element(const std::vector<std::string_view>& words) {
    Element element;
    if (words.size() < 3 ||
        std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count).ec != std::errc()) {
      fail("PLY header: `element` needs a name and a count");
    }
    element.name = words[1];
    elements_.push_back(element);
  }

  void read_property(const std::vector<std::string_view>& words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (elements_.empty() || words.size() < (is_list ? 5u : 3u)) fail("PLY header: a `property` line is not complete");
    const auto type = number_of(words[is_list ? 3 : 1]);
    const auto count_type = is_list ? number_of(words[2]) : std::nullopt;
    if (!type || (is_list && !count_type))
      fail("PLY header: property `" + std::string(words.back()) + "` has no known type");
    elements_.back().properties.push_back({std::string(words.back()), *type, count_type});
  }

  double next_value(Number type) {
    if (form_ == Form::Ascii) return next_ascii();
    const std::size_t size = size_of(type);
    if (rest_.size() < size) fail_truncated(row_);
    char raw[8] = {};
    std::memcpy(raw, rest_.data(), size);
    rest_.remove_prefix(size);
    if ((form_ == Form::BigEndian) != (std::endian::native == std::endian::big)) std::reverse(raw, raw + size);
    const auto as = [&raw](auto value) {
      std::memcpy(&value, raw, sizeof(value));
      return static_cast<double>(value);
    };
    switch (type) {
      case Number::I8:
        return as(std::int8_t{});
      case Number::U8:
        return as(std::uint8_t{});
      case Number::I16:
        return as(std::int16_t{});
      case Number::U16:
        return as(std::uint16_t{});
      case Number::I32:
        return as(std::int32_t{});
      case Number::U32:
        return as(std::uint32_t{});
      case Number::F32:
        return as(float{});
      case Number::F64:
        return as(double{});
    }
    return 0.0;
  }

  double next_ascii() {
    const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) fail_truncated(row_);
    rest_.remove_prefix(begin);
    const std::string_view word = rest_.substr(0, std::min(rest_.find_first_of(" \t\r\n"), rest_.size()));
    rest_.remove_prefix(word.size());
    const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
    double value = 0.0;
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (result.ec != std::errc() || result.ptr != digits.data() + digits.size()) {
      fail("element `" + element_->name + "`, row " + std::to_string(row_) + ": `" + std::string(word) +
           "` is not a number");
    }
    return value;
  }

  /// The values of the current element's next row: scalars in `scalars_`, lists in `lists_`, by property.
  void read_row() {
    scalars_.resize(element_->properties.size());
    lists_.resize(element_->properties.size());
    for (std::size_t i = 0; i < element_->properties.size(); ++i) {
      const Property& p = element_->properties[i];
      if (!p.count_type) {
        scalars_[i] = next_value(p.type);
        continue;
      }
      const double count = next_value(*p.count_type);
      const std::size_t max_count = rest_.size() / (form_ == Form::Ascii ? 1 : size_of(p.type));
      if (!(count >= 0.0))
        fail("element `" + element_->name + "`, row " + std::to_string(row_) + ": a list has a negative length");
      if (count > static_cast<double>(max_count)) fail_truncated(row_);
      lists_[i].clear();
      for (double k = 0.0; k < count; ++k) lists_[i].push_back(next_value(p.type));
    }
  }

  void read_vertices() {
    const auto& e = *element_;
    const std::array<int, 3> xyz{e.find({"x"}), e.find({"y"}), e.find({"z"})};
    const std::array<int, 3> n{e.find({"nx"}), e.find({"ny"}), e.find({"nz"})};
    const std::array<int, 2> uv{e.find({"s", "u", "texture_u"}), e.find({"t", "v", "texture_v"})};
    const auto all = [](const auto& indices) {
      return std::all_of(indices.begin(), indices.end(), [](int i) { return i >= 0; });
    };
    if (!all(xyz)) fail("element `vertex` has no x, y and z");
    const auto value = [this](int i) { return scalars_[static_cast<std::size_t>(i)]; };
    for (row_ = 0; row_ < e.count; ++row_) {
      read_row();
      MeshBuilder::Corner& corner = vertices_.emplace_back();
      corner.position = {value(xyz[0]), value(xyz[1]), value(xyz[2])};
      if (all(n)) corner.normal = Vec3(value(n[0]), value(n[1]), value(n[2]));
      if (all(uv)) corner.uv = Vec2(value(uv[0]), value(uv[1]));
    }
  }

  const MeshBuilder::Corner& vertex(double index) const {
    if (!(index >= 0.0 && index < static_cast<double>(vertices_.size()))) {
      fail("element `" + element_->name + "`, row " + std::to_string(row_) +
           ": a vertex index is out of range; there are " + std::to_string(vertices_.size()) + " vertices before it");
    }
    return vertices_[static_cast<std::size_t>(index)];
  }

  void read_faces(bool is_strips) {
    const int corners = element_->find({"vertex_indices", "vertex_index"});
    const int texcoord = element_->find({"texcoord"});
    if (corners < 0 || !element_->properties[static_cast<std::size_t>(corners)].count_type) {
      fail("element `" + element_->name + "` has no list `vertex_indices`");
    }
    for (row_ = 0; row_ < element_->count; ++row_) {
      read_row();
      const std::vector<double>& indices = lists_[static_cast<std::size_t>(corners)];
      if (is_strips) {
        add_strips(indices);
        continue;
      }
      polygon_.clear();
      for (double i : indices) polygon_.push_back(vertex(i));
      if (texcoord >= 0) {
        const std::vector<double>& uv = lists_[static_cast<std::size_t>(texcoord)];
        for (std::size_t k = 0; k < polygon_.size() && uv.size() == 2 * polygon_.size(); ++k) {
          polygon_[k].uv = Vec2(uv[2 * k], uv[2 * k + 1]);
        }
      }
      builder_.add_polygon(polygon_);
    }
  }

  /// Stanford's strips: -1 starts anew, every second triangle is turned.
  void add_strips(const std::vector<double>& indices) {
    std::size_t start = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] == -1.0) {
        start = i + 1;
      } else if (i >= start + 2) {
        const bool is_turned = (i - start) % 2 == 1;
        polygon_ = {vertex(indices[i - (is_turned ? 1 : 2)]), vertex(indices[i - (is_turned ? 2 : 1)]),
                    vertex(indices[i])};
        builder_.add_polygon(polygon_);
      }
    }
  }

  std::string file_;
  std::string bytes_;
  std::string_view rest_;
  MeshBuilder builder_;
  Form form_ = Form::Ascii;
  std::vector<Element> elements_;
  const Element* element_ = nullptr;
  std::uint64_t row_ = 0;
  std::vector<double> scalars_;
  std::vector<std::vector<double>> lists_;
  std::vector<MeshBuilder::Corner> vertices_, polygon_;
};

}  // namespace

Mesh read_ply(const std::filesystem::path& path) { return PlyReader(path).read(); }

}  // namespace patinate
