#include "patinate/core/json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/json_text.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Short text of a value for an error: "the string \"abc\"", "an array of 3".
std::string found_text(const Json& json) {
  if (json.is_null()) return "null";
  if (json.is_object()) return "an object";
  if (json.is_array()) return "an array of " + std::to_string(json.size());
  if (json.is_string()) {
    std::string text = json.get<std::string>();
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return "\"" + text + "\"";
  }
  return json.dump();
}

}  // namespace

Json load_json(const std::filesystem::path& path) {
  return parse_json(path.string(), read_file(path, std::uint64_t{64} << 20));
}

void save_json(const std::filesystem::path& path, const Json& json) {
  write_atomically(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

JsonReader::JsonReader(std::string file, const Json& json, std::string pointer)
    : file_(std::move(file)), json_(&json), pointer_(std::move(pointer)) {}

bool JsonReader::has(std::string_view key) const {
  looked_for_.insert(std::string(key));
  return json_->is_object() && json_->contains(key);
}
std::vector<std::string> JsonReader::keys() const {
  if (!json_->is_object()) fail("an object");
  std::vector<std::string> out;
  for (const auto& [key, value] : json_->items()) out.push_back(key);
  return out;
}
bool JsonReader::is_string() const { return json_->is_string(); }
bool JsonReader::is_object() const { return json_->is_object(); }
bool JsonReader::is_number() const { return json_->is_number(); }
bool JsonReader::is_array() const { return json_->is_array(); }
bool JsonReader::is_null() const { return json_->is_null(); }

void JsonReader::fail(const std::string& expected) const {
  throw IoError(file_,
                (pointer_.empty() ? "/" : pointer_) + ": found " + found_text(*json_) + "; expected " + expected);
}

JsonReader JsonReader::member(std::string_view key) {
  if (!json_->is_object()) fail("an object");
  asked_.insert(std::string(key));
  const auto it = json_->find(std::string(key));
  if (it == json_->end()) {
    throw IoError(file_, (pointer_.empty() ? "/" : pointer_) + ": `" + std::string(key) + "` is missing");
  }
  return JsonReader(file_, *it, pointer_ + "/" + std::string(key));
}

std::vector<JsonReader> JsonReader::elements(std::size_t max_size) const {
  if (!json_->is_array()) fail("an array");
  if (json_->size() > max_size) fail("an array of at most " + std::to_string(max_size));
  std::vector<JsonReader> result;
  for (std::size_t i = 0; i < json_->size(); ++i) {
    result.emplace_back(file_, (*json_)[i], pointer_ + "/" + std::to_string(i));
  }
  return result;
}

double JsonReader::number(const Range& range) const {
  const std::string allowed = range.text();
  const std::string expected = allowed.empty() ? "a number" : "a number " + allowed;
  if (!json_->is_number()) fail(expected);
  const double value = json_->get<double>();
  if (!std::isfinite(value) || !range.contains(value)) fail(expected);
  return value;
}

std::int64_t JsonReader::integer(const Range& range) const {
  const std::string allowed = range.text();
  const std::string expected = allowed.empty() ? "an integer" : "an integer " + allowed;
  if (!json_->is_number()) fail(expected);
  const double value = json_->get<double>();
  if (!(std::abs(value) <= 0x1p53) || value != std::floor(value) || !range.contains(value)) fail(expected);
  return static_cast<std::int64_t>(value);
}

bool JsonReader::boolean() const {
  if (!json_->is_boolean()) fail("true or false");
  return json_->get<bool>();
}

std::string JsonReader::string() const {
  if (!json_->is_string()) fail("a string");
  return json_->get<std::string>();
}

int JsonReader::choice(std::span<const std::string_view> names) const {
  std::string list;
  std::vector<std::string> candidates;
  for (std::string_view name : names) {
    list += (list.empty() ? "\"" : ", \"") + std::string(name) + "\"";
    candidates.emplace_back(name);
  }
  if (!json_->is_string()) fail("one of " + list);
  const std::string value = json_->get<std::string>();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == value) return static_cast<int>(i);
  }
  fail("one of " + list + did_you_mean(value, candidates));
}

std::vector<double> JsonReader::numbers(std::size_t count, const Range& range) const {
  if (!json_->is_array() || json_->size() != count) fail("an array of " + std::to_string(count) + " numbers");
  std::vector<double> result;
  for (const JsonReader& element : elements(count)) result.push_back(element.number(range));
  return result;
}

std::filesystem::path JsonReader::path() const {
  const std::string text = string();
  if (text.empty() || text.find('\0') != std::string::npos) fail("a path");
  return std::filesystem::path(file_).parent_path() / text;
}

namespace {

Json respelled(const Json& value, std::initializer_list<OldSpelling> words) {
  const auto now = [&](const std::string& text) {
    for (const OldSpelling& word : words) {
      if (text == word.before) return std::string(word.now);
    }
    return text;
  };
  if (value.is_string()) return now(value.get<std::string>());
  if (!value.is_structured()) return value;
  Json result = value.is_array() ? Json::array() : Json::object();
  for (const auto& [key, member] : value.items()) {
    if (value.is_array()) {
      result.push_back(respelled(member, words));
    } else {
      result[now(key)] = respelled(member, words);
    }
  }
  return result;
}

}  // namespace

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

void update_spelling(Json& document, int version, std::initializer_list<OldSpelling> words) {
  if (!document.is_object() || !document.contains("version") || document["version"] != version) return;
  document = respelled(document, words);
  document["version"] = version + 1;
}

void JsonReader::expect_format(std::string_view format, int version) {
  const JsonReader found = member("format");
  if (found.string() != format) found.fail("\"" + std::string(format) + "\"");
  const JsonReader found_version = member("version");
  if (found_version.integer() != version) found_version.fail("version " + std::to_string(version));
}

void JsonReader::finish() const {
  if (!json_->is_object()) fail("an object");
  std::vector<std::string> unknown;
  for (const auto& [key, value] : json_->items()) {
    if (!asked_.contains(key)) unknown.push_back(key);
  }
  if (unknown.empty()) return;
  std::vector<std::string> known(asked_.begin(), asked_.end());
  known.insert(known.end(), looked_for_.begin(), looked_for_.end());
  std::string hint = did_you_mean(unknown.front(), known);
  if (hint.empty()) {
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    for (const std::string& name : known) hint += (hint.empty() ? "; there is " : ", ") + name;
  }
  for (std::size_t i = 1; i < unknown.size(); ++i)
    hint += (i == 1 ? "; also unknown: `" : ", `") + unknown[i] + "`" + did_you_mean(unknown[i], known);
  throw IoError(file_, pointer_ + "/" + unknown.front() + ": unknown key" + hint);
}

}  // namespace patinate
