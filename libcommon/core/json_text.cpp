#include "libcommon/core/json_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "patinate/core/error.h"

namespace patinate {

namespace {

/// "line 3, column 14" of a byte offset.
std::string line_and_column(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_start + 1);
}

/// Follows the parser through a document, and stops it where a limit is passed or a key comes again.
class Watch {
 public:
  Watch(const std::string& name, const JsonTextLimits& limits) : name_(name), limits_(limits) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    using Event = Json::parse_event_t;
    if (depth > limits_.depth)
      throw IoError(name_, "is nested more than " + std::to_string(limits_.depth) + " levels deep");
    switch (event) {
      case Event::object_start:
        begin(true);
        break;
      case Event::array_start:
        begin(false);
        break;
      case Event::object_end:
      case Event::array_end:
        open_.pop_back();
        break;
      case Event::key:
        add_key(parsed.get_ref<const std::string&>());
        break;
      case Event::value:
        count();
        break;
    }
    return true;
  }

 private:
  struct Open {
    bool is_object = false;
    std::size_t num_elements = 0;
    std::string key;
    std::set<std::string, std::less<>> keys;
  };

  void begin(bool is_object) {
    count();
    open_.emplace_back().is_object = is_object;
  }
  void count() {
    if (!open_.empty()) ++open_.back().num_elements;
  }
  void add_key(const std::string& key) {
    Open& object = open_.back();
    object.key = key;
    if (!object.keys.insert(key).second) throw IoError(name_, pointer() + ": is given twice; keep one of them");
    if (object.keys.size() > limits_.members) {
      object.key.clear();
      throw IoError(name_, pointer() + ": has more than " + std::to_string(limits_.members) + " members");
    }
  }
  /// Where the parser stands.
  [[nodiscard]] std::string pointer() const {
    std::string text;
    for (const Open& o : open_) {
      if (!o.is_object)
        text += "/" + std::to_string(o.num_elements - 1);
      else if (!o.key.empty() || &o != &open_.back())
        text += "/" + o.key;
    }
    return text.empty() ? "/" : text;
  }

  const std::string& name_;
  const JsonTextLimits& limits_;
  std::vector<Open> open_;
};

}  // namespace

Json parse_json(const std::string& name, std::string_view text, const JsonTextLimits& limits) {
  Watch watch(name, limits);
  try {
    return Json::parse(
        text, [&watch](int depth, Json::parse_event_t event, Json& parsed) { return watch(depth, event, parsed); },
        /*allow_exceptions=*/true, limits.may_have_comments);
  } catch (const nlohmann::json::parse_error& e) {
    throw IoError(name, "is no valid JSON at " + line_and_column(text, e.byte > 0 ? e.byte - 1 : 0) +
                            (text.empty() ? " (the file is empty)" : ""));
  } catch (const nlohmann::json::out_of_range&) {
    throw IoError(name, "is no valid JSON: it holds a number too large for a computer");
  } catch (const nlohmann::json::exception&) {
    throw IoError(name, "is no valid JSON");
  }
}

}  // namespace patinate
