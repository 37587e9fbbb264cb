/// \file
/// What the windows of the mode filter say about a layer: how sure its values are, and where it is gone.
#pragma once

#include "patinate/capture/thickness.h"

namespace patinate::capture {

/// @param light   T that was filtered, finite.
/// @param first   mode_filter_shares() of it.
/// @param last    The same of what the last refinement filtered; `first` when there was none.
/// @param mask    Not empty. @param options  Those of the filter.
/// Cost: where holes are found, up to five more mode filters.
[[nodiscard]] LayerEvidence layer_evidence(const ImageF& light, const ModeFilterResult& first,
                                           const ModeFilterResult& last, const ImageU8& mask,
                                           const ModeFilterOptions& options, const RunControl& control);

}  // namespace patinate::capture
