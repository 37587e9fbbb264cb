#include "libcommon/image/response_io.h"

#include <array>
#include <nlohmann/json.hpp>

namespace patinate {

Response read_response(JsonReader json) {
  Response response;
  if (json.is_object()) {
    response.kind = Response::Kind::Gamma;
    response.gamma = json.member("gamma").number({0, 10, true});
    json.finish();
    return response;
  }
  constexpr std::array<std::string_view, 2> kNames{"srgb", "linear"};
  if (!json.is_string()) json.fail("\"srgb\", \"linear\" or {\"gamma\": 2.2}");
  response.kind = json.choice(kNames) == 0 ? Response::Kind::Srgb : Response::Kind::Linear;
  return response;
}

Json json_of(const Response& response) {
  if (response.kind == Response::Kind::Gamma) return Json{{"gamma", response.gamma}};
  return response.kind == Response::Kind::Srgb ? "srgb" : "linear";
}

}  // namespace patinate
