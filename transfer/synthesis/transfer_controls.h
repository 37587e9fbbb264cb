/// \file
/// The controls of a transfer: made of what a user asks for, and matched with the history's; in a library history by
/// history.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "patinate/controls/control_map.h"
#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

/// A control pair of a spec and the map that was made of its destination. Unless the spec says how it is matched, it
/// is by rank; a map file, or an expression with one, as suited_mapping() says.
///
/// A library's kLibraryControl is matched by `physical` unless the spec says otherwise. The map's values then are
/// indices where a file's values leave [0, 1] (a float image of 0, 1, 2); else 0 is the first history, 1 the last, and
/// the others lie evenly between: black, grays, white.
/// @param coverage  Of the atlas.
[[nodiscard]] TransferControl make_transfer_control(const History& history, const ControlSpec& spec, ControlMap made,
                                                    const ImageU8& coverage);

/// Controls as a user writes them. @throws ParseError, also for a typo in a destination.
[[nodiscard]] std::vector<ControlSpec> parse_controls(std::span<const std::string> texts);
/// Pairs controls with their history: each source by its name. @throws ParseError for a control that the history does
/// not have, or that is given twice.
[[nodiscard]] std::vector<ControlSpec> with_sources(const History& history, std::vector<ControlSpec> specs);
/// Makes the controls of a transfer. @param specs  With their sources.
/// @param make  Makes the map of a destination; it is called once for each spec, in their order.
[[nodiscard]] std::vector<TransferControl> make_transfer_controls(
    const History& history, std::span<const ControlSpec> specs, const ImageU8& coverage,
    const std::function<ControlMap(std::size_t number, const ControlSpec& spec)>& make);

/// The pixels that may be copied: the history's mask and, unless it is empty, `given`.
/// @throws InvalidInput if `given` has another size, or the two have no pixel in common.
[[nodiscard]] ImageU8 usable_mask(const History& history, const ImageU8& given);

/// Values that synthesis compares: a history's controls, and the destination's in their values; all in [0, 1], in the
/// order of the pairs.
struct MatchedControls {
  std::vector<ImageF> source;
  std::vector<ImageF> destination;
  std::vector<std::size_t> asked_histories = {};  ///< Histories of a library that texels ask for by kLibraryControl.
};
/// match_control() of every pair. Where a library's kLibraryControl is one of them, the others are matched history by
/// history, each over the texels nearest to it: ranks and ranges are those of the history that applies.
/// @param source_mask  As usable_mask() gives. @param coverage  Of the atlas.
/// @throws InvalidInput as match_control(); naming a history of the library that has texels, but no pixel in the mask.
[[nodiscard]] MatchedControls match_controls(const History& history, const ImageU8& source_mask,
                                             const std::vector<TransferControl>& controls, const ImageU8& coverage,
                                             const RunControl& control = {});

}  // namespace patinate::transfer
