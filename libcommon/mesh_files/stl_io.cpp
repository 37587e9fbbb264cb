#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "libcommon/core/files.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFacetBytes = 50;
constexpr std::string_view kBlanks = " \t\r\n\f\v";

/// Programs write keywords in either case. @param keyword  In lower case.
bool is_keyword(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b; });
}

/// The words of an ASCII file, with the line that each stands in.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  /// "" at the end.
  std::string_view next() {
    skip(rest_.find_first_not_of(kBlanks));
    const std::size_t size = std::min(rest_.find_first_of(kBlanks), rest_.size());
    const std::string_view word = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return word;
  }
  /// Rest of the line, without blanks around it.
  std::string_view rest_of_line() {
    std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
    rest_.remove_prefix(line.size());
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    return line.substr(0, line.find_last_not_of(kBlanks) + 1);
  }
  [[nodiscard]] int line() const { return line_; }

 private:
  void skip(std::size_t count) {
    const std::string_view blanks = rest_.substr(0, count);
    line_ += static_cast<int>(std::count(blanks.begin(), blanks.end(), '\n'));
    rest_.remove_prefix(blanks.size());
  }

  std::string_view rest_;
  int line_ = 1;
};

class StlReader {
 public:
  explicit StlReader(const std::filesystem::path& path)
      : file_(path.string()), text_(read_file(path)), builder_(file_) {}

  Mesh read() {
    // Many binary files begin with `solid` too: only the size tells.
    if (is_binary()) {
      read_binary();
    } else {
      const std::string_view text = without_byte_order_mark(file_, text_);
      if (!is_keyword(Words(text).next(), "solid") || text.find('\0') != std::string::npos) fail_kind();
      read_ascii(text);
    }
    if (num_facets_ == 0) throw IoError(file_, "no facets");
    return builder_.finish();
  }

 private:
  [[nodiscard]] std::size_t stated_facets() const {
    std::uint32_t count = 0;
    std::memcpy(&count, text_.data() + kHeaderBytes, sizeof count);
    return count;
  }
  [[nodiscard]] static std::size_t bytes_of(std::size_t facets) {
    return kHeaderBytes + sizeof(std::uint32_t) + facets * kFacetBytes;
  }
  [[nodiscard]] bool is_binary() const {
    return text_.size() >= bytes_of(0) && text_.size() == bytes_of(stated_facets());
  }
  [[noreturn]] void fail_kind() const {
    if (text_.size() < bytes_of(0)) throw IoError(file_, "is no STL file: neither `solid` nor a binary header");
    throw IoError(file_, "is no STL file, or cut off: it says that it holds " + std::to_string(stated_facets()) +
                             " facets, which take " + std::to_string(bytes_of(stated_facets())) + " bytes, and has " +
                             std::to_string(text_.size()));
  }

  void add_facet(const std::array<MeshBuilder::Corner, 3>& corners) {
    builder_.add_polygon(corners);
    ++num_facets_;
  }

  void read_binary() {
    for (std::size_t at = bytes_of(0); at < text_.size(); at += kFacetBytes) {
      std::array<float, 12> numbers;  // The facet's normal first, which follows from its corners.
      std::memcpy(numbers.data(), text_.data() + at, sizeof numbers);
      std::array<MeshBuilder::Corner, 3> corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k].position = {numbers[3 * k + 3], numbers[3 * k + 4], numbers[3 * k + 5]};
      add_facet(corners);
    }
  }

  [[noreturn]] void fail(const Words& words, const std::string& problem) const {
    throw IoError(file_, "line " + std::to_string(words.line()) + ": " + problem);
  }
  void expect(Words& words, std::string_view expected) const {
    const std::string_view found = words.next();
    if (is_keyword(found, expected)) return;
    fail(words, found.empty() ? "the file ends where `" + std::string(expected) + "` should follow"
                              : "found `" + std::string(found) + "`; expected `" + std::string(expected) + "`");
  }
  [[nodiscard]] Vec3 vector(Words& words) const {
    Vec3 v;
    for (double& value : v) {
      const std::string_view word = words.next();
      const char* const begin = word.data() + (word.starts_with('+') ? 1 : 0);
      const char* const end = word.data() + word.size();
      const auto [stop, problem] = std::from_chars(begin, end, value);
      if (problem != std::errc() || stop != end || word.empty())
        fail(words, word.empty() ? "the file ends where a number should follow"
                                 : "found `" + std::string(word) + "`; expected a number");
    }
    return v;
  }

  void read_ascii(std::string_view text) {
    Words words(text);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      if (!is_keyword(word, "solid")) fail(words, "found `" + std::string(word) + "`; expected `solid`");
      builder_.set_surface(std::string(words.rest_of_line()), "");
      read_solid(words);
    }
  }
  void read_solid(Words& words) {
    for (std::string_view word = words.next(); !is_keyword(word, "endsolid"); word = words.next()) {
      if (word.empty()) fail(words, "the file ends before `endsolid`: it is cut off");
      if (!is_keyword(word, "facet")) fail(words, "found `" + std::string(word) + "`; expected `facet` or `endsolid`");
      read_facet(words);
    }
    (void)words.rest_of_line();
  }
  void read_facet(Words& words) {
    expect(words, "normal");
    for (int i = 0; i < 3; ++i) (void)words.next();  // Some write nan for a facet without area.
    expect(words, "outer");
    expect(words, "loop");
    std::array<MeshBuilder::Corner, 3> corners;
    for (MeshBuilder::Corner& corner : corners) {
      expect(words, "vertex");
      corner.position = vector(words);
    }
    expect(words, "endloop");
    expect(words, "endfacet");
    add_facet(corners);
  }

  std::string file_;
  std::string text_;
  MeshBuilder builder_;
  std::size_t num_facets_ = 0;
};

}  // namespace

Mesh read_stl(const std::filesystem::path& path) { return StlReader(path).read(); }

}  // namespace patinate
