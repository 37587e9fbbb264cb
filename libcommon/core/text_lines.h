/// \file
/// Text files that hold a table: lines with their numbers, and words between blanks.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace patinate {

/// A file's lines without line ends (LF, CRLF) and without a byte order mark.
class TextLines {
 public:
  struct Line {
    std::size_t number = 0;  ///< From 1.
    std::string_view text;   ///< Blanks at both ends are cut.
    /// Whether nothing stands in it, or a comment: `#` or `%` comes first.
    [[nodiscard]] bool is_empty() const { return text.empty() || text[0] == '#' || text[0] == '%'; }
  };

  /// @throws IoError if the file cannot be read, holds more than `max_bytes`, or a byte 0 (then it is no text).
  explicit TextLines(const std::filesystem::path& path, std::uint64_t max_bytes = std::uint64_t{1} << 26);
  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;

  [[nodiscard]] std::span<const Line> lines() const { return lines_; }
  /// @throws IoError "FILE: line 12: problem".
  [[noreturn]] void fail(const Line& line, const std::string& problem) const;
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  std::string file_;
  std::string bytes_;
  std::vector<Line> lines_;
};

/// `bytes` without UTF-8's byte order mark. @throws IoError if they begin with that of UTF-16 or UTF-32.
[[nodiscard]] std::string_view without_byte_order_mark(const std::string& file, std::string_view bytes);

/// Words between blanks, at most `max_words`; the last one is then the rest of the text.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view text, std::size_t max_words = 1'000'000);

}  // namespace patinate
