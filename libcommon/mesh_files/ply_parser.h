/// \file
/// The PLY format itself: header, and rows of values as ASCII or in either byte order. What the elements mean is the
/// readers' business.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace patinate {

/// Reads one PLY file from front to back. Counts are checked against the file's size before anything is allocated for
/// them.
class PlyParser {
 public:
  enum class Number { I8, U8, I16, U16, I32, U32, F32, F64 };
  enum class Form { Ascii, LittleEndian, BigEndian };
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
    [[nodiscard]] int find(std::initializer_list<std::string_view> names) const;
  };

  /// Reads the header. @throws IoError
  explicit PlyParser(const std::filesystem::path& path);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }
  /// Text of an `obj_info NAME VALUE` line; "" = no such line.
  [[nodiscard]] std::string_view obj_info(std::string_view name) const;

  /// Begins the rows of an element; elements come in the order of elements(). @throws IoError if the file is too short
  /// for its rows.
  void begin(const Element& element);
  /// Whether rows of this element take room in the file: one without properties has any number of rows.
  [[nodiscard]] bool has_rows() const { return min_row_bytes() > 0; }
  /// The next row, of ASCII exactly one line: then scalar(i) and list(i) are its values, by property. @throws IoError
  void read_row();
  [[nodiscard]] double scalar(int property) const { return scalars_[property]; }
  [[nodiscard]] const std::vector<double>& list(int property) const { return lists_[property]; }
  /// Call it behind the last row of the last element. @throws IoError if there is more in the file.
  void finish() const;
  /// An error about the row that was read last. @throws IoError always
  [[noreturn]] void fail_row(const std::string& problem) const;
  [[noreturn]] void fail(const std::string& problem) const;
  /// A list's value as an index below `size`. @throws IoError
  [[nodiscard]] std::size_t index(double value, std::size_t size) const;

 private:
  [[noreturn]] void fail_truncated(std::uint64_t row) const;
  [[nodiscard]] std::uint64_t min_row_bytes() const;
  std::string_view next_line();
  void read_header();
  void read_format(const std::vector<std::string_view>& words);
  void read_element(const std::vector<std::string_view>& words);
  void read_property(const std::vector<std::string_view>& words);
  double next_value(Number type);
  double next_ascii();
  void begin_ascii_row();
  void end_ascii_row() const;
  [[nodiscard]] std::size_t line_of(const char* at) const;

  std::string file_;
  std::string bytes_;
  std::string_view rest_;
  Form form_ = Form::Ascii;
  std::vector<Element> elements_;
  std::vector<std::pair<std::string, std::string>> obj_info_;
  const Element* element_ = nullptr;
  std::uint64_t row_ = 0;  ///< Read so far, of this element.
  std::vector<double> scalars_;
  std::vector<std::vector<double>> lists_;
};

}  // namespace patinate
