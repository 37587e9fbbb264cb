#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "patinate/core/json.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

void require_unique_keys(const Json& json) {
  if (json.is_object()) {
    std::set<std::string> keys;
    for (const auto& [key, value] : json.items()) fuzz::require(keys.insert(key).second, "no key is given twice");
  }
  for (const Json& child : json) {
    if (child.is_structured()) require_unique_keys(child);
  }
}

}  // namespace

PATINATE_FUZZ_TARGET(json) {
  const Json json = load_json(fuzz::fuzz_file("a.json", bytes));
  require_unique_keys(json);
  const std::filesystem::path copy = fuzz::fuzz_folder() / "b.json";
  save_json(copy, json);
  const std::string once = load_json(copy).dump(2, ' ', false, Json::error_handler_t::replace);
  fuzz::require(once == json.dump(2, ' ', false, Json::error_handler_t::replace), "what is saved reads as it was");
  JsonReader reader("a.json", json);
  if (reader.is_object() && reader.has("format")) reader.expect_format("patinate.history", 1);
  reader.finish();
}
