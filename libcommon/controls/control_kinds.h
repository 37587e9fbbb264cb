/// \file
/// Every kind of control map by name, for command lines and files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/controls/accessibility.h"
#include "libcommon/controls/facing.h"
#include "libcommon/controls/spray.h"

namespace patinate {

/// The options of all kinds. Paths stand here because a kind chosen by name reads its own input.
struct ControlKindOptions {
  AccessibilityOptions accessibility;
  FacingOptions facing;
  SprayOptions spray;
  std::string spray_path;  ///< CSV of read_spray_path(); "" = default_spray_path().
  std::string image;       ///< Image of the kind `image`.
};
void describe(OptionVisitor& visitor, ControlKindOptions& options);

/// "accessibility", "facing", "spray", "image".
[[nodiscard]] const std::vector<std::string>& control_kind_names();

/// Files that make_control() would read: part of what its result depends on.
[[nodiscard]] std::vector<std::filesystem::path> control_input_files(const std::string& kind,
                                                                     const ControlKindOptions& options);

/// @throws UsageError for a kind that does not exist (with a did-you-mean) or whose input is not given; what the kind
/// throws.
[[nodiscard]] ControlMap make_control(const std::string& kind, const TexelMap& map,
                                      const ControlKindOptions& options = {}, const RunControl& control = {});

/// A ready-made map: image_map() of a file's channel `Y`, its only one, or the mean of its colours.
/// @throws IoError
[[nodiscard]] ControlMap read_control_file(const std::filesystem::path& path, const TexelMap& map);

/// An expression of kinds and files (ControlExpression). @throws UsageError, and what its parts throw.
[[nodiscard]] ControlMap make_control_expression(std::string_view expression, const TexelMap& map,
                                                 const ControlKindOptions& options = {},
                                                 const RunControl& control = {});

}  // namespace patinate
