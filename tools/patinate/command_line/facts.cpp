#include "tools/patinate/command_line/facts.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace patinate::cli {

Facts::Facts(const std::string& kind) : json_(std::make_shared<Json>()), text_(kind) { (*json_)["kind"] = kind; }

void Facts::add(const std::string& name, const Json& value, const std::string& shown) {
  (*json_)[name] = value;
  if (shown.empty()) return;
  std::string label = name + ":";
  std::replace(label.begin(), label.end(), '_', ' ');
  label.resize(std::max<std::size_t>(label.size() + 1, 20), ' ');
  text_ += "\n  " + label + shown;
}
void Facts::add(const std::string& name, const std::string& value) { add(name, Json(value), value); }
void Facts::add(const std::string& name, std::int64_t value) { add(name, Json(value), std::to_string(value)); }
void Facts::report(CommandRun& run) const { run.report(*json_, text_); }

}  // namespace patinate::cli
