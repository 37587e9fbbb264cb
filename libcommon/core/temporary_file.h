/// \file
/// What an AtomicFile writes under until it is whole.
#pragma once

#include <filesystem>

namespace patinate {

/// The name is one that an AtomicFile writes under, on this machine or another:
/// `.STEM.tmpMACHINE-PID-PROCESS-NUMBER.EXTENSION`.
[[nodiscard]] bool is_temporary(const std::filesystem::path& path);

}  // namespace patinate
