/// \file
/// What makes a thickness map doubtful, as warnings of a history.
#pragma once

#include <string>
#include <vector>

#include "patinate/capture/thickness.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// None for a layer whose cracks are narrower than the window.
/// @param photo    Name of the transmission photograph, without folders.
/// @param options  Those that the map was made with.
[[nodiscard]] std::vector<HistoryWarning> thickness_warnings(const LayerEvidence& evidence, const std::string& photo,
                                                             const ThicknessOptions& options);

/// The window that a layer has chosen, and how well it foretells the layer; "" where it was given.
[[nodiscard]] std::string layer_window_text(const LayerWindow& window);

}  // namespace patinate::capture
