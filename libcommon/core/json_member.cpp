#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/json_text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

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
      if (std::string_view(" \t\r\n").find(now()) != std::string_view::npos) {
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

}  // namespace

std::string with_member(std::string_view text, std::string_view name, std::string_view value) {
  MemberScan scan(text);
  scan.skip_blanks();
  if (scan.now() != '{') throw InvalidInput("a JSON object is needed to set \"" + std::string(name) + "\" in");
  scan.step();
  std::size_t end = scan.at();  // End of the last member.
  bool has_members = false;
  for (scan.skip_blanks(); scan.now() == '"'; scan.skip_blanks()) {
    const std::size_t key = scan.at();
    scan.skip_string();
    const bool is_it = Json::parse(text.substr(key, scan.at() - key)).get<std::string>() == name;
    scan.skip_blanks();
    scan.step();  // The colon.
    scan.skip_blanks();
    const std::size_t begin = scan.at();
    scan.skip_value();
    end = scan.at();
    has_members = true;
    if (is_it) return std::string(text.substr(0, begin)) + std::string(value) + std::string(text.substr(end));
    scan.skip_blanks();
    if (scan.now() == ',') scan.step();
  }
  const std::string separator = text.find('\n') == std::string_view::npos ? " " : "\n  ";
  return std::string(text.substr(0, end)) + (has_members ? "," + separator : std::string()) + "\"" + std::string(name) +
         "\": " + std::string(value) + std::string(text.substr(end));
}

}  // namespace patinate
