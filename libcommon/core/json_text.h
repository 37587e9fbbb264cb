/// \file
/// JSON of others: the one place where text that we did not write becomes JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "patinate/core/json.h"

namespace patinate {

struct JsonTextLimits {
  int depth = 64;                 ///< Levels of arrays and objects; whoever walks or frees the value recurses so deep.
  std::size_t members = 4096;     ///< Members of one object: looking for one takes time with their number.
  bool may_have_comments = true;  ///< `//` and `/* */`.
};

/// @param name  Of the file or message, with which an error begins.
/// @throws IoError with line and column for what is no JSON; with the JSON pointer for a key that is given twice, of
/// which other readers would take the first or the last; and for what passes a limit.
[[nodiscard]] Json parse_json(const std::string& name, std::string_view text, const JsonTextLimits& limits = {});

/// The text of an object with one member of it set, in its place, or added behind the others. All else stays as it is
/// written, comments too.
/// @param text  What parse_json() takes, an object. @param name  Plain ASCII. @param value  As JSON.
/// @throws InvalidInput if it is no object.
[[nodiscard]] std::string with_member(std::string_view text, std::string_view name, std::string_view value);
/// The text without one member of the object and the comma that it needs; comments stay. It may be missing.
/// @throws InvalidInput if it is no object.
[[nodiscard]] std::string without_member(std::string_view text, std::string_view name);

}  // namespace patinate
