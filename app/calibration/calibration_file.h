/// \file
/// What a calibration found, as the files that `patinate calibrate` and the Python module write.
#pragma once

#include <filesystem>

#include "app/output/output_work.h"
#include "capture/calibration/calibrate.h"

namespace patinate::app {

/// @param output  .json, .yml or .lp; empty: no file. @param picture  .png; may be empty. @throws UsageError
void require_calibration_names(const std::filesystem::path& output, const std::filesystem::path& picture);
/// The file in the form that its extension asks for: .json, which projects take; .yml for a camera; .lp for directions
/// of lights; and the picture. @param output, picture  One of them may be empty.
/// @throws UsageError if what was found has no such form, or the kind draws no picture.
[[nodiscard]] OutputWork calibration_work(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                                          const std::filesystem::path& output, const std::filesystem::path& picture);

}  // namespace patinate::app
