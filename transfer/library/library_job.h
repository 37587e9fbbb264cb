/// \file
/// A library as a job: several histories become one folder that is a history, for everything that takes one.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "libcommon/job/job.h"
#include "transfer/library/library_layout.h"

namespace patinate::transfer {

struct LibraryTask {
  std::vector<std::filesystem::path> histories;
  std::vector<LibraryControl> controls = {};  ///< Controls as lay_out_library().
  LibraryOptions options = {};
};

/// The histories of a library, opened, and how they lie in it.
struct OpenLibrary {
  LibraryTask task;
  std::vector<HistoryReader> readers;
  std::vector<LibrarySource> sources;
  LibraryLayout layout;
};
/// @throws IoError; InvalidInput as lay_out_library().
[[nodiscard]] std::shared_ptr<const OpenLibrary> open_library(LibraryTask task);

/// One item a frame, a control, and the mask. history.json names the parts in its member `library`.
[[nodiscard]] JobPlan plan_library(const std::shared_ptr<const OpenLibrary>& library,
                                   const std::filesystem::path& output);

}  // namespace patinate::transfer
