/// \file
/// Which control of a history a destination's values stand for (`[SOURCE=]DESTINATION[:weight[:mapping]]`), and how
/// they are brought into its range.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// How destination values become source values.
enum class ControlMapping {
  Rank,      ///< Match the distributions: the share of texels below equals the share of pixels below.
  Linear,    ///< Match the ranges: least to least, greatest to greatest.
  Physical,  ///< Same unit on both sides.
};
inline constexpr std::array<std::string_view, 3> kControlMappingNames{"rank", "linear", "physical"};

struct ControlSpec {
  std::string source;                          ///< Control of the history; "" = its only one.
  std::string destination;                     ///< A map file, a kind, or an expression of them.
  double weight = 1.0;                         ///< > 0
  std::optional<ControlMapping> mapping = {};  ///< None: `auto`. Rank; of map files, suited_mapping() of their
                                               ///< values.
};

/// @throws ParseError saying which part is wrong.
[[nodiscard]] ControlSpec parse_control_spec(std::string_view text);
/// The history's control that a spec names, or its only one; of a library the only one beside kLibraryControl.
/// @throws InvalidInput if it has no such control; ParseError if none is named and it has several, or none.
[[nodiscard]] std::string source_control(const History& history, const ControlSpec& spec);

/// A control map as normalized values with what 0 and 1 stand for.
struct ControlRange {
  double low = 0.0;
  double high = 1.0;
  std::string unit;
};

/// The mapping that a map's values suggest. Rank matching gives all texels with one value the middle of their ranks: if
/// half of the surface is unpainted, it would age like the lower middle of the source.
struct SuitedMapping {
  ControlMapping mapping = ControlMapping::Rank;  ///< Linear where few values are shared by most of the surface.
  double tied_share = 0.0;  ///< Share of the texels whose value is shared by at least a tenth of all texels.
};
/// Linear where at least half of the texels are tied, or a quarter of all have one value; else rank: ranks of a tenth
/// are off by a twentieth at most. Up to 2^19 texels are looked at, evenly chosen.
/// @param mask  0 = not counted; empty: all count.
[[nodiscard]] SuitedMapping suited_mapping(const ImageF& values, const ImageU8& mask);

/// Destination values mapped into the source's normalized [0, 1].
///
/// Rank keeps order: the result's distribution over `destination_mask` equals the source's over `source_mask`; equal
/// values stay equal (each gets the middle of their ranks). Linear maps least to least and greatest to greatest.
/// Physical converts units of measure by the ranges.
/// @param destination  H x W, [0, 1]; @param source  h x w, [0, 1]; masks 0 = not counted.
/// A destination without unit (a map file) is taken to be in the source's.
/// @throws InvalidInput for Physical when the units differ or the source has none, or when a mask is empty.
[[nodiscard]] ImageF match_control(const ImageF& destination, const ImageU8& destination_mask,
                                   const ControlRange& destination_range, const ImageF& source,
                                   const ImageU8& source_mask, const ControlRange& source_range, ControlMapping mapping,
                                   const RunControl& control = {});

/// match_control() label by label: texels of one label are matched with the pixels of that label alone, as if each were
/// a history of its own.
/// @param destination_labels,source_labels  0 = not counted, else a label, as masks are.
/// @throws InvalidInput also when a label has texels but no pixels.
[[nodiscard]] ImageF match_control_by_label(const ImageF& destination, const ImageU8& destination_labels,
                                            const ControlRange& destination_range, const ImageF& source,
                                            const ImageU8& source_labels, const ControlRange& source_range,
                                            ControlMapping mapping, const RunControl& control = {});

}  // namespace patinate::transfer
