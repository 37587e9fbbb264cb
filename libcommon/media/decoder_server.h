/// \file
/// The other side of decoder_process.h.
#pragma once

#include <filesystem>

namespace patinate {

/// Serves `patinate-decode`: answers requests for frames of `path` until its input ends.
/// @param in,out  File descriptors. @returns the process's exit code.
int serve_decoder(const std::filesystem::path& path, int in, int out);

}  // namespace patinate
