#include <nlohmann/json.hpp>

#include "libcommon/core/json.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(json) {
  const Json json = load_json(fuzz::fuzz_file("a.json", bytes));
  const std::filesystem::path copy = fuzz::fuzz_folder() / "b.json";
  save_json(copy, json);
  const std::string once = load_json(copy).dump(2, ' ', false, Json::error_handler_t::replace);
  fuzz::require(once == json.dump(2, ' ', false, Json::error_handler_t::replace), "what is saved reads as it was");
  JsonReader reader("a.json", json);
  if (reader.is_object() && reader.has("format")) reader.expect_format("patinate.history", 1);
  reader.finish();
}
