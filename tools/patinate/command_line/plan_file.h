/// \file
/// A plan as a file: a command, and its work as data.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "tools/patinate/command_line/plan_request.h"

namespace patinate::cli {

struct PlanFile {
  std::vector<std::string> command;  ///< The verb and its arguments.
  PlanIdentity identity;
};

[[nodiscard]] Json plan_json(const std::vector<std::string>& command, const PlannedWork& work);
[[nodiscard]] Json plan_schema();
/// The same for people, several lines without an end of line.
[[nodiscard]] std::string plan_text(const PlannedWork& work);
/// @throws IoError, also where another version of patinate made it.
[[nodiscard]] PlanFile read_plan_file(const std::filesystem::path& file);

}  // namespace patinate::cli
