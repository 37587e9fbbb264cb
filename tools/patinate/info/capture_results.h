/// \file
/// What `info` tells and `validate` checks of registrations, unlit steps and calibrations.
#pragma once

#include <filesystem>

#include "tools/patinate/command_line/facts.h"

namespace patinate::cli {

/// @param path  The folder, or its registration.json. @throws IoError
[[nodiscard]] Facts registration_facts(const std::filesystem::path& path);
/// @param path  The folder, or its unlight.json. @throws IoError
[[nodiscard]] Facts unlit_facts(const std::filesystem::path& path);
/// @param path  The .json. @throws IoError
[[nodiscard]] Facts calibration_facts(const std::filesystem::path& path);

/// Statuses are known, matrices are rigid, pairs name scans. @throws IoError
void check_registration(const std::filesystem::path& path);
/// Every map can be read and has the size that is said. @throws IoError
void check_unlit(const std::filesystem::path& path);
/// Camera and lights can be read as a project reads them. @throws IoError
void check_calibration(const std::filesystem::path& path);

}  // namespace patinate::cli
