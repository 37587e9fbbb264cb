/// \file
/// Commands that make one image per tile of an atlas.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/output/output_work.h"
#include "patinate/core/json.h"
#include "patinate/image/image.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// The file of each tile (tile_path()).
[[nodiscard]] std::vector<std::filesystem::path> tile_files(const std::filesystem::path& output,
                                                            const std::vector<std::string>& tile_names);

/// Whether the images of all tiles are to be made, as CommandRun::check_file() says of one: Done when one is missing,
/// UpToDate when all have the key.
/// @throws CannotComplete if one is there with another key, without --force.
[[nodiscard]] std::optional<JobStatus> check_tile_files(CommandRun& run,
                                                        const std::vector<std::filesystem::path>& files,
                                                        const std::string& key);

/// Outputs that are to be made, all checked before anything is written. To a plan each is an item.
/// @param pieces  Not empty. @param key  Of the whole command. @param output  As it was given, for what is said of all.
/// @returns indices; nothing when the command has no more to do than to return 0.
/// @throws CannotComplete if one is there with another key, without --force.
[[nodiscard]] std::optional<std::vector<std::size_t>> unfinished_pieces(CommandRun& run,
                                                                        const std::filesystem::path& output,
                                                                        const std::string& key,
                                                                        const std::vector<app::OutputPiece>& pieces);

/// CommandRun::report_output() of all files: one line, and with --json a member `files`.
void report_tile_files(CommandRun& run, JobStatus status, const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& files, Json more);

}  // namespace patinate::cli
