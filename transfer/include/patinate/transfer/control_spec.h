/// \file
/// The `--control` grammar: `[SOURCE=]DESTINATION[:weight[:mapping]]`.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "patinate/history/history_value.h"

namespace patinate::transfer {

/// How destination values become source values.
enum class ControlMapping {
  Rank,      ///< Match the distributions: the share of texels below equals the share of pixels below.
  Linear,    ///< Match the ranges: least to least, greatest to greatest.
  Physical,  ///< Same unit on both sides.
};
inline constexpr std::array<std::string_view, 3> kControlMappingNames{"rank", "linear", "physical"};

struct ControlSpec {
  std::string source;       ///< Control of the history; "" = its only one.
  std::string destination;  ///< A map file, a kind, or an expression of them.
  double weight = 1.0;      ///< > 0
  ControlMapping mapping = ControlMapping::Rank;
  bool has_mapping = false;  ///< It was said.
};

/// @throws ParseError saying which part is wrong.
[[nodiscard]] ControlSpec parse_control_spec(std::string_view text);
/// The history's control that a spec names, or its only one; of a library the only one beside kLibraryControl.
/// @throws InvalidInput if it has no such control; ParseError if none is named and it has several, or none.
[[nodiscard]] std::string source_control(const History& history, const ControlSpec& spec);

}  // namespace patinate::transfer
