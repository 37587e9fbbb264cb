/// \file
/// Any history as a folder.
#pragma once

#include <filesystem>
#include <string>

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"

namespace patinate {

/// Writes all of a history, wherever it is kept, as a new folder (or one that is empty), which appears when it is
/// whole. Colors become half floats.
/// @param force  Another history that lies there gives way to it.
/// @throws CannotComplete if the folder holds something already or cannot be written; as History; Canceled.
void write_history(const std::filesystem::path& folder, const History& history, const RunControl& control = {},
                   bool force = false);

/// The same into a folder that is there. @param key  Content key that its manifest names; "": none.
void write_history_files(const std::filesystem::path& folder, const History& history, const std::string& key,
                         const RunControl& control = {});

}  // namespace patinate
