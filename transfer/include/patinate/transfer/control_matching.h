/// \file
/// Brings a destination's control values into the range of the history's.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/transfer/control_spec.h"

namespace patinate::transfer {

/// A control map as normalized values with what 0 and 1 stand for.
struct ControlRange {
  double low = 0.0;
  double high = 1.0;
  std::string unit;
};

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
