/// \file
/// The part of OpenCV's YAML, XML and JSON (cv::FileStorage) that calibrations use: numbers under names. A reader of
/// our own, because OpenCV's parsers call themselves for every level of nesting and can be made to overflow the stack.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace patinate {

/// Never calls itself, whatever a file holds; at most 1 MB, 1,000 names and 10,000 numbers under each.
class OpenCvFile {
 public:
  /// @throws IoError if it is no such file, is cut off, or goes deeper than 64 levels.
  explicit OpenCvFile(const std::filesystem::path& path);

  [[nodiscard]] bool has(const std::string& name) const { return values_.contains(name); }
  /// The text that stands there, without quotes; "" = nothing. Of numbers and words.
  [[nodiscard]] std::string word(const std::string& name) const;
  /// Numbers of a value, of a list (of lists), or of an `opencv-matrix`, row by row. Nothing when something else stands
  /// there, a number is not finite, or rows x cols is another count.
  [[nodiscard]] std::optional<std::vector<double>> numbers(const std::string& name) const;

 private:
  struct Value {
    std::string text;  ///< Numbers between blanks, commas and brackets; "?" when it is something else.
    std::string rows;  ///< Rows of a matrix.
    std::string columns;
  };
  void read_yaml(std::string_view text);
  void read_xml(std::string_view text);
  void read_json(const std::filesystem::path& path);

  std::map<std::string, Value> values_;
};

}  // namespace patinate
