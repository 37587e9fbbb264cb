/// \file
/// A step of a study as a process.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

namespace patinate::cli {

/// Exit code of a command that was asked to stop.
inline constexpr int kStepInterrupted = 130;

/// Gives a command to a shell in `folder`, with what it says on stderr in a file there and nothing on stdout, and
/// waits. Asked to stop, it asks the command to, and waits for it.
/// @returns the exit code; 128 + N for a process that signal N has ended.
/// @throws CannotComplete if it cannot be started.
int run_step(const std::string& command, const std::filesystem::path& folder, const std::filesystem::path& log,
             const std::stop_token& stop);

/// This program's own file, as a word of a command.
[[nodiscard]] std::string this_program();

}  // namespace patinate::cli
