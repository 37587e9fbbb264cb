/// \file
/// Where patinate's own programs and modules lie.
#pragma once

#include <filesystem>

namespace patinate {

/// The folder of the running program, or the one that was set; empty where the system does not say. Thread-safe.
[[nodiscard]] std::filesystem::path programs_folder();
/// For a process whose program is none of ours, as an interpreter that loads our libraries. Call it before anything
/// else.
void set_programs_folder(const std::filesystem::path& folder);

}  // namespace patinate
