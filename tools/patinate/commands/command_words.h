/// \file
/// What commands say alike, while their work is made ready and when it is made.
#pragma once

#include <filesystem>

#include "app/request/words.h"
#include "patinate/core/json.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// With --verbose which it is, why others are not taken, and how long it calculated; that it has failed always; and its
/// name in run.json. @param run  Must outlive what is opened.
[[nodiscard]] app::Words words_of(CommandRun& run);

/// How many frames a history has that was made, and from when to when. @param folder  The history. @throws IoError
[[nodiscard]] Json frames_json(const std::filesystem::path& folder);

}  // namespace patinate::cli
