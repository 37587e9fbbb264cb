/// \file
/// The images that a pixel's appearance is made of: colors over time, and what is known of its material beside them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "patinate/history/history_value.h"
#include "patinate/transfer/appearance_space.h"
#include "transfer/exemplar/principal_components.h"

namespace patinate::transfer {

/// Whether frames or maps of this name count beside color: `specular`, `metalness`, and the `height` of frames. (A
/// constant height is the object's shape.)
[[nodiscard]] bool is_compared(const std::string& name, bool is_of_frame);

/// A frame's color or one of its maps, or a map of the whole history.
struct ComparedLayer {
  std::function<ImageF()> read;  ///< H x W x num_channels.
  int num_channels = 0;
  std::optional<std::size_t> material = {};  ///< Kind of material map; nothing: color.
  double weight = 1.0;

  /// Square root of color, so that dark differences count as the eye sees them; of others weight times the value.
  [[nodiscard]] double value(const ImageF& image, std::int64_t pixel, int channel) const;
};

/// Frame by frame, color first; constant maps last. Of height only relief counts: less its mean
/// around (Gaussian of 8 pixels), in pixels, or in mm where a pixel's size is not known.
/// @param history,mask  Must outlive the result. @param control  Of reading, without progress.
[[nodiscard]] std::vector<ComparedLayer> compared_layers(const History& history, const ImageU8& mask,
                                                         const AppearanceOptions& options,
                                                         const RunControl& control = {});

/// Sets weights so that every kind of material map has the same variance over the samples, all together `share` of the
/// colors'; but 1 at most, so that what hardly varies stays what it is. @param samples  A column for each channel of
/// the layers, in their order: weighted afterwards.
void weigh_materials(std::vector<ComparedLayer>& layers, SampleMatrix& samples, double share);

}  // namespace patinate::transfer
