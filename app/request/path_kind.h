/// \file
/// What a path given on the command line is.
#pragma once

#include <filesystem>
#include <string>

namespace patinate::app {

enum class PathKind {
  History,
  Transfer,
  Capture,
  Simulation,
  Registration,
  Unlit,
  Calibration,
  Factorization,
  Fit,
  Explanation,
  Report,  ///< Report of a comparison, of replicates, or an evaluation.
  Mesh,
  Image
};

/// A folder or manifest by its `"format"`, a file by its extension. Its content is not checked.
/// @throws IoError if it does not exist or is none of these.
[[nodiscard]] PathKind kind_of(const std::filesystem::path& path);

/// @throws IoError if `path` does not exist, with what its folder holds that is named nearly so.
void require_exists(const std::filesystem::path& path);

/// @throws InvalidInput unless `path` is a transfer; of a history it says what makes one of it.
void require_transfer(const std::filesystem::path& path);

/// The history that a path stands for: its own `history` for a simulation or factorization, the folder of
/// `library:NAME`, else the path itself.
[[nodiscard]] std::filesystem::path history_place(const std::filesystem::path& path);

}  // namespace patinate::app
