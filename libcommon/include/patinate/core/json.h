/// \file
/// Reading our JSON files with errors that name the file, the JSON pointer, what was found and what was expected; and
/// writing them so that equal content gives equal bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"

namespace patinate {

using Json = nlohmann::ordered_json;  ///< Members keep the order they were written in.

/// Parses a file; `//` comments are allowed. At most 64 MB and 64 levels deep.
/// @throws IoError with line and column.
[[nodiscard]] Json load_json(const std::filesystem::path& path);
/// Indented by two, ends with a newline; replaced atomically. @throws CannotComplete
void save_json(const std::filesystem::path& path, const Json& json);

/// The number, or null.
[[nodiscard]] Json optional_json(const std::optional<double>& value);

/// A word of a format with the spelling of an older version.
struct OldSpelling {
  std::string_view before, now;
};
/// Brings a document of ours from `version` to the next: members, and texts that are exactly such a word, get their new
/// spelling; `"version"` is raised. Documents of other versions stay as they are.
void update_spelling(Json& document, int version, std::initializer_list<OldSpelling> words);

/// One JSON value and where it stands. Objects remember which members were asked for, so that finish() can name the
/// others, and which ones were looked for with has(), so that it can suggest them.
class JsonReader {
 public:
  /// @param json  Must outlive the reader.
  JsonReader(std::string file, const Json& json, std::string pointer = "");

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }

  [[nodiscard]] bool has(std::string_view key) const;
  /// Names of an object's members, in their order. @throws IoError if this is not an object.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] bool is_string() const;
  [[nodiscard]] bool is_object() const;
  [[nodiscard]] bool is_number() const;
  [[nodiscard]] bool is_array() const;
  [[nodiscard]] bool is_null() const;

  /// Member of an object. @throws IoError if this is no object or it is missing.
  [[nodiscard]] JsonReader member(std::string_view key);
  /// Elements of an array of at most `max_size`.
  [[nodiscard]] std::vector<JsonReader> elements(std::size_t max_size = 1'000'000) const;

  [[nodiscard]] double number(const Range& range = {}) const;
  [[nodiscard]] std::int64_t integer(const Range& range = {}) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string string() const;
  /// One of `names`; gives its index.
  [[nodiscard]] int choice(std::span<const std::string_view> names) const;
  /// Array of exactly `count` numbers.
  [[nodiscard]] std::vector<double> numbers(std::size_t count, const Range& range = {}) const;
  /// A path, relative to the folder of the JSON file.
  [[nodiscard]] std::filesystem::path path() const;

  /// Checks `"format"` and `"version"` of a file of ours.
  void expect_format(std::string_view format, int version);
  /// @throws IoError naming the first member that nobody asked for, with a did-you-mean.
  void finish() const;
  /// @throws IoError: FILE: POINTER: found X; expected Y.
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  std::string file_;
  const Json* json_;
  std::string pointer_;
  std::set<std::string, std::less<>> asked_;
  mutable std::set<std::string, std::less<>> looked_for_;
};

}  // namespace patinate
