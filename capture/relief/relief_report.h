/// \file
/// What a relief says, for programs and for people. Inside of relief only.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/relief/relief_job.h"

namespace patinate::capture {

/// change/0001.exr, and with another extension its picture.
[[nodiscard]] std::filesystem::path change_file(std::size_t scan, const std::string& extension);
/// Warnings for the user before the figures are used, about the change of `name`.
[[nodiscard]] std::vector<HistoryWarning> relief_warnings(const ReliefChange& change, const std::string& name,
                                                          bool has_stable);
/// Writes kReliefFile, kReliefTableFile, kReliefPageFile, and change_file() of every scan but the reference.
/// @throws CannotComplete
void write_relief_report(const std::filesystem::path& folder, const ReliefTask& task, const Relief& relief,
                         const std::vector<HistoryWarning>& warnings, const std::string& key);

}  // namespace patinate::capture
