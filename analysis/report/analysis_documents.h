/// \file
/// What analyses write: JSON Schemas, and files that are checked.
#pragma once

#include <filesystem>

#include "patinate/core/json.h"

namespace patinate::analysis {

[[nodiscard]] Json compare_schema();
[[nodiscard]] Json evaluation_schema();
[[nodiscard]] Json explanation_schema();
[[nodiscard]] Json factorization_schema();
[[nodiscard]] Json field_schema();
[[nodiscard]] Json fit_schema();
[[nodiscard]] Json grade_groups_schema();
[[nodiscard]] Json grade_schema();
[[nodiscard]] Json ranking_schema();
[[nodiscard]] Json replicates_schema();

/// Reads such a file and checks that it holds what it should. @throws IoError
void check_compare_report(const std::filesystem::path& file);
void check_evaluation(const std::filesystem::path& file);
void check_grade_groups(const std::filesystem::path& file);
void check_grade_report(const std::filesystem::path& file);
void check_replicates_report(const std::filesystem::path& file);

}  // namespace patinate::analysis
