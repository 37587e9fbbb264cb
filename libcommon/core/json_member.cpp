#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/json_text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::string_view kJsonBlanks = " \t\r\n";

/// Walks through the text of a document that is known to be right.
class MemberScan {
 public:
  explicit MemberScan(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] char now() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void step() { ++at_; }

  /// Blanks and comments.
  void skip_blanks() {
    while (at_ < text_.size()) {
      if (kJsonBlanks.find(now()) != std::string_view::npos) {
        ++at_;
      } else if (text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.size(), text_.find('\n', at_));
      } else if (text_.substr(at_, 2) == "/*") {
        const std::size_t end = text_.find("*/", at_ + 2);
        at_ = end == std::string_view::npos ? text_.size() : end + 2;
      } else {
        return;
      }
    }
  }
  void skip_string() {
    for (++at_; at_ < text_.size() && now() != '"'; ++at_) {
      if (now() == '\\') ++at_;
    }
    ++at_;
  }
  void skip_value() {
    int depth = 0;
    while (at_ < text_.size()) {
      if (now() == '"') {
        skip_string();
      } else if (now() == '{' || now() == '[') {
        ++depth, ++at_;
      } else if (now() == '}' || now() == ']') {
        --depth, ++at_;
      } else if (depth > 0) {
        const std::size_t before = at_;
        skip_blanks();
        if (at_ == before) ++at_;
        continue;
      } else {
        at_ = std::min(text_.size(), text_.find_first_of(" \t\r\n,]}/", at_));
      }
      if (depth == 0) return;
    }
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

/// Where a member stands in the text of an object.
struct MemberPlace {
  std::size_t key = 0, value = 0, end = 0;
  std::size_t before = 0;  ///< End of the member before it, or behind the brace.
  std::size_t comma = 0;   ///< Behind the member before it; 0 = it is the first.
  std::size_t next = 0;    ///< Of the member behind it, or of a comment before that; 0 = it is the last.
  bool is_there = false;
};

/// @returns if it is not there, the end of the last member as `before`.
MemberPlace find_member(std::string_view text, std::string_view name) {
  MemberScan scan(text);
  scan.skip_blanks();
  if (scan.now() != '{') throw InvalidInput("a JSON object is needed to set \"" + std::string(name) + "\" in");
  scan.step();
  MemberPlace place{.before = scan.at()};
  for (scan.skip_blanks(); scan.now() == '"'; scan.skip_blanks()) {
    place.key = scan.at();
    scan.skip_string();
    place.is_there = Json::parse(text.substr(place.key, scan.at() - place.key)).get<std::string>() == name;
    scan.skip_blanks();
    scan.step();  // The colon.
    scan.skip_blanks();
    place.value = scan.at();
    scan.skip_value();
    place.end = scan.at();
    scan.skip_blanks();
    const bool has_comma = scan.now() == ',';
    if (place.is_there) {
      if (has_comma) place.next = text.find_first_not_of(kJsonBlanks, scan.at() + 1);
      return place;
    }
    place.before = place.end;
    place.comma = scan.at();
    if (has_comma) scan.step();
  }
  return place;
}

}  // namespace

std::string with_member(std::string_view text, std::string_view name, std::string_view value) {
  const MemberPlace place = find_member(text, name);
  if (place.is_there)
    return std::string(text.substr(0, place.value)) + std::string(value) + std::string(text.substr(place.end));
  const std::string separator = text.find('\n') == std::string_view::npos ? " " : "\n  ";
  return std::string(text.substr(0, place.before)) + (place.comma > 0 ? "," + separator : std::string()) + "\"" +
         std::string(name) + "\": " + std::string(value) + std::string(text.substr(place.before));
}

std::string without_member(std::string_view text, std::string_view name) {
  const MemberPlace place = find_member(text, name);
  if (!place.is_there) return std::string(text);
  const std::string before(text.substr(0, place.key));
  if (place.next > 0) return before + std::string(text.substr(place.next));
  const std::string behind(text.substr(place.end));
  if (place.comma == 0) return before + behind;
  const std::string between = before.substr(place.comma + 1);  // Its comments stay, and the ends of their lines.
  const bool is_blank = between.find_first_not_of(kJsonBlanks) == std::string::npos;
  return before.substr(0, place.comma) + (is_blank ? std::string() : between) + behind;
}

}  // namespace patinate
