/// \file
/// What `patinate info` tells of a path, by its kind. @throws IoError, each of them.
#pragma once

#include <filesystem>

#include "tools/patinate/command_line/facts.h"

namespace patinate::cli {

[[nodiscard]] Facts history_facts(const std::filesystem::path& path);
[[nodiscard]] Facts transfer_facts(const std::filesystem::path& path);
[[nodiscard]] Facts capture_facts(const std::filesystem::path& path);
[[nodiscard]] Facts simulation_facts(const std::filesystem::path& path);
[[nodiscard]] Facts factorization_facts(const std::filesystem::path& path);
[[nodiscard]] Facts fit_facts(const std::filesystem::path& path);
[[nodiscard]] Facts explanation_facts(const std::filesystem::path& path);
/// Facts of a comparison, of replicates, or an evaluation.
[[nodiscard]] Facts report_facts(const std::filesystem::path& path);
void check_report(const std::filesystem::path& path);
[[nodiscard]] Facts mesh_facts(const std::filesystem::path& path);
[[nodiscard]] Facts image_facts(const std::filesystem::path& path);

}  // namespace patinate::cli
