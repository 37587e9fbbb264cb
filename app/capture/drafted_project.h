/// \file
/// A drafted capture project as an output: capture.json, and hints beside it.
#pragma once

#include <filesystem>

#include "app/output/output_work.h"
#include "capture/project/draft_project.h"

namespace patinate::app {

/// Writes `project` (.json) and the .hints.txt of its name. Its report has `found` and `check`, lists of lines.
[[nodiscard]] OutputWork drafted_project_work(const capture::ProjectDraft& draft, const std::filesystem::path& project);
/// Why `ingest` will refuse it as it is; "" if it does not. @param project  Written.
[[nodiscard]] std::string draft_refusal(const std::filesystem::path& project);

}  // namespace patinate::app
