/// \file
/// What may be opened for reading. A pipe or a device may never end, or never begin: whoever opens one waits for ever.
#pragma once

#include <filesystem>

namespace patinate {

/// Call before any file that somebody else named is opened, by us or by a library. `/dev/stdin` and the files of
/// process substitution count as what stands behind them: a file that was redirected is one, a pipe is none.
/// Notes the file as an input (input_watch.h).
/// @throws IoError unless `path` is a regular file, or a link to one.
void require_regular_file(const std::filesystem::path& path);

}  // namespace patinate
