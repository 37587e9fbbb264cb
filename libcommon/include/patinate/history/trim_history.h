/// \file
/// Part of a history's frames, as a history.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"

namespace patinate {

struct TrimOptions {
  std::optional<double> from = std::nullopt;   ///< First time that stays, in the history's unit.
  std::optional<double> until = std::nullopt;  ///< Last time that stays.
  int every = 1;                               ///< Of those, every n-th frame stays, the first among them; >= 1.
};
/// Visits every field.
void describe(OptionVisitor& v, TrimOptions& o);

/// A history, and the files that it takes from another one.
struct TrimmedHistory {
  struct File {
    std::filesystem::path from, to;  ///< Relative to the old and the new folder.
  };
  HistoryManifest manifest;
  std::vector<File> files;
};
/// Times, controls, maps, mask and warnings stay as they are: a control that was made from all frames still is.
/// @throws InvalidInput if no frame would be left, or on options out of range.
[[nodiscard]] TrimmedHistory trim_history(const HistoryManifest& history, const TrimOptions& options);

/// Copies them. Folders are made. @throws std::filesystem::filesystem_error; Canceled.
void copy_history_files(const std::filesystem::path& from, const std::vector<TrimmedHistory::File>& files,
                        const std::filesystem::path& to, const RunControl& control = {});

}  // namespace patinate
