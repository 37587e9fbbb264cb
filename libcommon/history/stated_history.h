/// \file
/// A history gets the maps that a person states of it.
#pragma once

#include <filesystem>
#include <functional>

#include "libcommon/history/appearance.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"

namespace patinate {

/// @throws InvalidInput if the history has one of the maps already, measured or stated, or lacks a control.
void check_appearance(const HistoryFacts& history, const Appearance& appearance);

/// Reads a mask, [0, 1], of the history's size.
using MaskReader = std::function<ImageF(const std::filesystem::path& file)>;
/// One that throws IoError on another size.
[[nodiscard]] MaskReader mask_reader(const HistoryFacts& history);

/// Adds the maps to a history that is whole but for them: to every frame where they differ from frame to frame, else
/// once. Half floats. The manifest is written last; its key stays.
/// @throws as check_appearance() and `read_mask`; CannotComplete; Canceled.
void state_appearance(const std::filesystem::path& folder, const Appearance& appearance, const MaskReader& read_mask,
                      const RunControl& control = {});

}  // namespace patinate
