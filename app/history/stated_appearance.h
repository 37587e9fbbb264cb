/// \file
/// `patinate history material` as a job: a history with maps of what its material is stated to be.
#pragma once

#include <filesystem>
#include <optional>

#include "libcommon/history/appearance.h"
#include "libcommon/job/job.h"
#include "patinate/core/options.h"

namespace patinate::app {

/// Numbers for the whole history.
struct PlainAppearance {
  std::optional<double> metalness, roughness, specular;
  [[nodiscard]] bool is_empty() const { return !metalness && !roughness && !specular; }
};
void describe(OptionVisitor& v, PlainAppearance& o);

/// @param file  Says it by color, over time, or by control or mask; empty: the numbers do.
/// @throws InvalidInput unless one of the two is given; IoError
[[nodiscard]] Appearance appearance_of(const std::filesystem::path& file, const PlainAppearance& plain);

/// @param history  A history's folder. @throws IoError, InvalidInput if it knows its material already, or lacks a
/// control that `appearance` names.
[[nodiscard]] JobPlan plan_appearance(const std::filesystem::path& history, const Appearance& appearance,
                                      const std::filesystem::path& output);

}  // namespace patinate::app
