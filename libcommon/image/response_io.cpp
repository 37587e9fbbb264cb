#include "libcommon/image/response_io.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "libcommon/core/text.h"

namespace patinate {

Response read_response(JsonReader json) {
  Response response;
  if (json.is_object()) {
    response.kind = Response::Kind::Gamma;
    response.gamma = json.member("gamma").number({0, 10, true});
    json.finish();
    return response;
  }
  const std::array<std::string, 2> kNames{"srgb", "linear"};
  const std::string word = json.is_string() ? json.string() : "";
  if (word != kNames[0] && word != kNames[1])
    json.fail("\"srgb\", \"linear\" or {\"gamma\": 2.2}" + did_you_mean(word, kNames));
  response.kind = word == kNames[0] ? Response::Kind::Srgb : Response::Kind::Linear;
  return response;
}

Json json_of(const Response& response) {
  if (response.kind == Response::Kind::Gamma) return Json{{"gamma", response.gamma}};
  return response.kind == Response::Kind::Srgb ? "srgb" : "linear";
}

}  // namespace patinate
