#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "libcommon/mesh_files/point_cloud_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Reads one OBJ file, line by line.
class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& path)
      : file_(path.string()), text_(read_file(path)), builder_(file_) {}

  Mesh read() {
    parse();
    if (num_faces_ == 0) {
      throw IoError(file_, positions_.empty() ? "no vertices and no faces; is it an OBJ file?"
                                              : "no faces, only " + std::to_string(positions_.size()) +
                                                    " points (a point cloud); a surface is needed");
    }
    return builder_.finish();
  }

  /// Vertices as they are listed, with faces or without.
  PointCloud read_cloud() {
    is_cloud_ = true;
    parse();
    const bool has_normals = normals_.size() == positions_.size() && !has_other_normal_indices_;
    PointCloudBuilder cloud;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      cloud.add_point(positions_[i], has_normals ? std::optional(normals_[i]) : std::nullopt);
    }
    for (const std::vector<std::size_t>& polygon : polygons_) cloud.add_polygon(polygon);
    return cloud.finish(file_);
  }

 private:
  void parse() {
    (void)without_byte_order_mark(file_, text_);
    if (text_.find('\0') != std::string::npos) throw IoError(file_, "holds binary data; an OBJ file is text");
    join_continued_lines();
    std::string_view rest = without_byte_order_mark(file_, text_);
    while (!rest.empty()) {
      ++line_;
      const std::size_t end = rest.find_first_of("\r\n");
      std::string_view statement = rest.substr(0, end);
      if (end == std::string_view::npos) {
        rest = {};
      } else {
        rest.remove_prefix(end + (rest.substr(end, 2) == "\r\n" ? 2 : 1));
      }
      read_statement(statement.substr(0, statement.find('#')));
    }
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw IoError(file_, "line " + std::to_string(line_) + ": " + problem);
  }

  /// A backslash at a line's end becomes blanks, the line's end with it (lines keep their numbers but for these).
  void join_continued_lines() {
    for (std::size_t i = text_.find('\\'); i != std::string::npos; i = text_.find('\\', i + 1)) {
      std::size_t end = i + 1;
      while (end < text_.size() && (text_[end] == ' ' || text_[end] == '\t')) ++end;
      if (end >= text_.size() || (text_[end] != '\n' && text_[end] != '\r')) continue;
      if (text_.compare(end, 2, "\r\n") == 0) ++end;
      text_.replace(i, end - i + 1, end - i + 1, ' ');
    }
  }

  static std::string_view next_word(std::string_view& rest) {
    const std::size_t begin = rest.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return rest = {};
    rest.remove_prefix(begin);
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(end);
    return word;
  }

  void read_statement(std::string_view rest) {
    const std::string_view keyword = next_word(rest);
    if (keyword == "v") {
      positions_.push_back(read_vector<3>(rest, 3));
    } else if (keyword == "vt") {
      uvs_.push_back(read_vector<2>(rest, 1));
    } else if (keyword == "vn") {
      normals_.push_back(read_vector<3>(rest, 3));
    } else if (keyword == "f") {
      read_face(rest);
    } else if (keyword == "o") {
      node_ = trimmed(rest);
      builder_.set_surface(node_, material_);
    } else if (keyword == "surf" && !is_cloud_) {
      fail("holds a free-form surface (`surf`), which is not read; export polygons");
    } else if (keyword == "usemtl") {
      material_ = trimmed(rest);
      builder_.set_surface(node_, material_);
    }
  }

  static std::string trimmed(std::string_view rest) {
    const std::size_t begin = rest.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return "";
    return std::string(rest.substr(begin, rest.find_last_not_of(" \t") - begin + 1));
  }

  template <int N>
  Eigen::Matrix<double, N, 1> read_vector(std::string_view rest, int num_required) const {
    Eigen::Matrix<double, N, 1> v = Eigen::Matrix<double, N, 1>::Zero();
    for (int i = 0; i < N; ++i) {
      const std::string_view word = next_word(rest);
      if (word.empty() && i < num_required) {
        fail("found " + std::to_string(i) + " numbers; expected " + std::to_string(num_required));
      }
      if (!word.empty()) v[i] = read_number(word);
    }
    return v;
  }

  /// Also 1., +1 and 3.1+e2 (written by some programs, for 3.1e+2).
  double read_number(std::string_view word) const {
    const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
    double value = 0.0;
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const std::string_view rest = digits.substr(static_cast<std::size_t>(result.ptr - digits.data()));
    if (result.ec == std::errc() && (rest.starts_with("+e") || rest.starts_with("-e")) && rest.size() > 2 &&
        is_digit(rest[2]))
      return read_number(std::string(digits.substr(0, digits.size() - rest.size())) + "e" + rest.front() +
                         std::string(rest.substr(2)));
    if (result.ec != std::errc() || !rest.empty() || !std::isfinite(value))
      fail("`" + std::string(word) + "` is not a finite number" +
           (rest.starts_with(',') ? "; decimals begin with a point, not a comma" : ""));
    return value;
  }

  /// Index into an array of `size`, from 1, or from its end when negative; moves past it.
  int read_index(std::string_view& text, std::size_t size, const char* what) const {
    long long index = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
    if (result.ec != std::errc()) fail("`" + std::string(text) + "` is not an index of a face");
    text.remove_prefix(static_cast<std::size_t>(result.ptr - text.data()));
    const long long found = index < 0 ? static_cast<long long>(size) + index : index - 1;
    if (found < 0 || found >= static_cast<long long>(size)) {
      fail(std::string(what) + " index " + std::to_string(index) + " is out of range; there are " +
           std::to_string(size) + " so far");
    }
    return static_cast<int>(found);
  }

  void read_face(std::string_view rest) {
    corners_.clear();
    polygon_.clear();
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      MeshBuilder::Corner corner;
      polygon_.push_back(static_cast<std::size_t>(read_index(word, positions_.size(), "vertex")));
      corner.position = positions_[polygon_.back()];
      if (!word.empty() && word.front() == '/') {
        word.remove_prefix(1);
        if (!word.empty() && word.front() != '/') {
          corner.uv = uvs_[read_index(word, uvs_.size(), "UV")];
        }
        if (!word.empty() && word.front() == '/') {
          word.remove_prefix(1);
          if (!word.empty()) {
            const auto normal = static_cast<std::size_t>(read_index(word, normals_.size(), "normal"));
            corner.normal = normals_[normal];
            has_other_normal_indices_ = has_other_normal_indices_ || normal != polygon_.back();
          }
        }
      }
      if (!word.empty()) fail("`" + std::string(word) + "` follows an index of a face");
      corners_.push_back(corner);
    }
    if (corners_.size() < 3) fail("a face has " + std::to_string(corners_.size()) + " corners; it needs at least 3");
    if (is_cloud_) {
      polygons_.push_back(polygon_);
    } else {
      builder_.add_polygon(corners_);
    }
    ++num_faces_;
  }

  std::string file_;
  std::string text_;
  MeshBuilder builder_;
  int line_ = 0;
  std::int64_t num_faces_ = 0;
  std::string node_, material_;
  std::vector<Vec3> positions_, normals_;
  std::vector<Vec2> uvs_;
  std::vector<MeshBuilder::Corner> corners_;
  std::vector<std::size_t> polygon_;  ///< Corners as indices of positions.
  bool is_cloud_ = false;
  bool has_other_normal_indices_ = false;  ///< Some corner has a normal of another index than its position.
  std::vector<std::vector<std::size_t>> polygons_;
};

}  // namespace

Mesh read_obj(const std::filesystem::path& path) { return ObjReader(path).read(); }
PointCloud read_obj_cloud(const std::filesystem::path& path) { return ObjReader(path).read_cloud(); }

}  // namespace patinate
