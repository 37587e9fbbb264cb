#include "tools/studio/outside_json.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/json_text.h"

namespace patinate::studio {

Json parse_outside_json(const std::string& text) {
  return parse_json("message", text, {.depth = 32, .may_have_comments = false});
}

}  // namespace patinate::studio
