/// \file
/// Controls that look at no other place than a texel's own: over a part of an atlas as over all of it.
#pragma once

#include <string>

#include "patinate/controls/control_kinds.h"

namespace patinate {

/// facing_map(), of a part. @returns values of its size.
[[nodiscard]] ControlMap facing_part(const TexelMap& map, const FacingOptions& options, const TexelRect& part,
                                     const RunControl& control = {});
/// height_map(), of a part.
[[nodiscard]] ControlMap height_part(const TexelMap& map, const std::array<double, 3>& up, const TexelRect& part,
                                     const RunControl& control = {});

/// @throws ParseError for an expression with a kind that looks at the whole atlas, or a file.
void require_part_control(const std::string& expression);

/// make_control_expression() of a part: the values that the whole map has there.
/// @throws as require_part_control().
[[nodiscard]] ControlMap make_part_control(const std::string& expression, const TexelMap& map, const TexelRect& part,
                                           const ControlKindOptions& options, const RunControl& control = {});

}  // namespace patinate
