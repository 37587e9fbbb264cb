#include "libcommon/geometry/opencv_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 20;
constexpr std::size_t kMaxNames = 1000;
constexpr std::size_t kMaxNumbers = 10'000;
constexpr std::size_t kMaxDepth = 64;
constexpr std::string_view kBlanks = " \t\r\n";

/// Reason why a file is unreadable; caught where the path is known.
struct Unreadable {};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The line without a comment; `#` counts after a blank, outside of quotes.
std::string_view without_comment(std::string_view line) {
  char quote = '\0';
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote != '\0') {
      if (line[i] == '\\' && quote == '"') {
        ++i;
      } else if (line[i] == quote) {
        quote = '\0';
      }
    } else if (line[i] == '"' || line[i] == '\'') {
      quote = line[i];
    } else if (line[i] == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) {
      return line.substr(0, i);
    }
  }
  return line;
}

/// Position after `name:` (or `"name":`) of a map in `text`; npos when there is none.
std::size_t after_key(std::string_view text, std::string_view name) {
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    std::size_t end = at + name.size();
    const bool begins = at == 0 || std::string_view(" \t\r\n{,\"").find(text[at - 1]) != std::string_view::npos;
    if (end < text.size() && text[end] == '"') ++end;
    if (begins && end < text.size() && text[end] == ':') return end + 1;
  }
  return std::string_view::npos;
}

/// `text` up to the bracket that closes its first one.
std::string_view bracketed(std::string_view text) {
  std::size_t depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '[' && ++depth > kMaxDepth) throw Unreadable();
    if (text[i] == ']' && --depth == 0) return text.substr(0, i + 1);
  }
  throw Unreadable();
}

/// The first word after a key.
std::string scalar_after(std::string_view text, std::string_view name) {
  const std::size_t at = after_key(text, name);
  if (at == std::string_view::npos) return "";
  const std::string_view rest = trimmed(text.substr(at));
  return std::string(rest.substr(0, rest.find_first_of(" \t\r\n,}")));
}

}  // namespace

OpenCvFile::OpenCvFile(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxBytes);
  try {
    std::string_view text = bytes;
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    text = trimmed(text);
    if (text.starts_with("<")) {
      read_xml(text);
    } else if (text.starts_with("{")) {
      read_json(path);
    } else {
      read_yaml(text);
    }
    if (values_.empty()) throw Unreadable();
  } catch (const Unreadable&) {
    throw IoError(path.string(),
                  "is no OpenCV calibration that can be read; expected YAML that begins with %YAML:1.0, or XML");
  }
}

std::string OpenCvFile::word(const std::string& name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return "";
  std::string_view text = trimmed(found->second.text);
  if (text.size() >= 2 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0])
    text = text.substr(1, text.size() - 2);
  return std::string(text);
}

std::optional<std::vector<double>> OpenCvFile::numbers(const std::string& name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return std::nullopt;
  const Value& value = found->second;
  std::vector<double> numbers;
  constexpr std::string_view kBetween = " \t\r\n,[]";
  for (std::size_t at = value.text.find_first_not_of(kBetween); at != std::string::npos;) {
    const std::size_t end = value.text.find_first_of(kBetween, at);
    const std::string_view word = std::string_view(value.text).substr(at, end == std::string::npos ? end : end - at);
    at = value.text.find_first_not_of(kBetween, std::min(end, value.text.size()));
    if (word == "-") continue;  // A line of a list.
    const std::optional<double> number = parse_number(word.starts_with('+') ? word.substr(1) : word);
    if (!number || numbers.size() == kMaxNumbers) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.empty()) return std::nullopt;
  if (!value.rows.empty() || !value.columns.empty()) {
    const std::optional<double> rows = parse_number(value.rows), columns = parse_number(value.columns);
    if (!rows || !columns || *rows * *columns != static_cast<double>(numbers.size())) return std::nullopt;
  }
  return numbers;
}

void OpenCvFile::read_yaml(std::string_view text) {
  std::vector<std::pair<std::string, std::string>> sections;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = without_comment(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (trimmed(line).empty() || line[0] == '%' || line.starts_with("---") || line.starts_with("...")) continue;
    const std::size_t colon = line.find(':');
    const bool begins = std::string_view(" \t-[]{}").find(line[0]) == std::string_view::npos &&
                        colon != std::string_view::npos &&
                        (colon + 1 == line.size() || kBlanks.find(line[colon + 1]) != std::string_view::npos);
    if (begins) {
      std::string_view name = trimmed(line.substr(0, colon));
      if (name.size() >= 2 && (name[0] == '"' || name[0] == '\'') && name.back() == name[0])
        name = name.substr(1, name.size() - 2);
      if (sections.size() == kMaxNames) throw Unreadable();
      sections.emplace_back(name, line.substr(colon + 1));
    } else if (sections.empty()) {
      throw Unreadable();
    } else {
      sections.back().second.append("\n").append(line);
    }
  }
  for (const auto& [name, body] : sections) {
    std::string_view rest = trimmed(body);
    if (rest.starts_with('!')) rest = trimmed(rest.substr(std::min(rest.find_first_of(kBlanks), rest.size())));
    Value value;
    const std::size_t data = after_key(rest, "data");
    if (data != std::string_view::npos) {
      value.rows = scalar_after(rest, "rows"), value.columns = scalar_after(rest, "cols");
      rest = trimmed(rest.substr(data));
    }
    value.text = rest.starts_with('[') ? bracketed(rest) : rest;
    values_.try_emplace(name, std::move(value));
  }
}

void OpenCvFile::read_xml(std::string_view text) {
  std::vector<std::string> open;
  while (!text.empty()) {
    const std::size_t tag = text.find('<');
    const std::string_view words = text.substr(0, tag);
    if (open.size() >= 2 && !trimmed(words).empty()) {
      if (!values_.contains(open[1]) && values_.size() == kMaxNames) throw Unreadable();
      Value& value = values_[open[1]];
      const std::string& inner = open.back();
      std::string& into = open.size() == 3 && inner == "rows"   ? value.rows
                          : open.size() == 3 && inner == "cols" ? value.columns
                                                                : value.text;
      const bool is_known = open.size() == 2 || inner == "_" || inner == "data" || &into != &value.text;
      if (is_known) into.append(" ").append(trimmed(words));
      if (!is_known && inner != "dt") value.text += " ?";
    }
    if (tag == std::string_view::npos) break;
    text.remove_prefix(tag);
    const bool is_comment = text.starts_with("<!--");
    const std::size_t end = is_comment ? text.find("-->") : text.find('>');
    if (end == std::string_view::npos) throw Unreadable();
    const std::string_view inside = text.substr(1, end - 1);
    text.remove_prefix(end + (is_comment ? 3 : 1));
    if (is_comment || inside.starts_with('?') || inside.starts_with('!')) continue;
    if (inside.starts_with('/')) {
      if (open.empty() || trimmed(inside.substr(1)) != open.back()) throw Unreadable();
      open.pop_back();
    } else if (!inside.ends_with('/')) {
      if (open.size() == kMaxDepth) throw Unreadable();
      open.emplace_back(inside.substr(0, inside.find_first_of(kBlanks)));
    }
  }
  if (!open.empty()) throw Unreadable();
  for (auto& [name, value] : values_) {
    value.rows = trimmed(value.rows), value.columns = trimmed(value.columns);
  }
}

void OpenCvFile::read_json(const std::filesystem::path& path) {
  Json json;
  try {
    json = load_json(path);
  } catch (const IoError&) {
    throw Unreadable();
  }
  if (!json.is_object() || json.size() > kMaxNames) throw Unreadable();
  for (const auto& [name, content] : json.items()) {
    Value value;
    const bool is_matrix = content.is_object() && content.contains("data");
    const auto text_of = [&content = content](const char* key) {
      return content.contains(key) ? content.at(key).dump() : std::string();
    };
    if (is_matrix) value.rows = text_of("rows"), value.columns = text_of("cols");
    const Json& numbers = is_matrix ? content.at("data") : content;
    const bool has_text = numbers.is_number() || numbers.is_array() || numbers.is_string() || numbers.is_boolean();
    value.text = has_text ? numbers.dump() : "?";
    values_.try_emplace(name, std::move(value));
  }
}

}  // namespace patinate
