/// \file
/// How a command ends when it is asked to: soon, with one line, and with nothing half-written.
#pragma once

#include <chrono>
#include <stop_token>

namespace patinate::cli {

inline constexpr int kInterruptedExitCode = 130;

/// From now on Ctrl-C, SIGTERM and SIGHUP (the terminal is gone), unless ignored, ask the work to stop. Work that does
/// not end within 25 ms (a library's call cannot be interrupted), or is asked again, is ended as it is: temporary files
/// are removed, and a job resumes from what it has finished. Call before any thread starts.
void stop_on_signals(const std::stop_source& asked);

/// For a command whose work is not resumed from files but holds what a person has done: so long it may take to end in
/// order. Asked again it still ends at once. Call before the work begins.
void take_time_to_end(std::chrono::nanoseconds longest);

/// Says once that the work was interrupted. @returns kInterruptedExitCode
int report_interruption();

}  // namespace patinate::cli
