/// \file
/// Transfers of several tiles, evaluated tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "analysis/evaluation/evaluation_job.h"
#include "transfer/exemplar/appearance_cache.h"
#include "transfer/synthesis/audit.h"

namespace patinate::cli {

/// Nothing for a transfer of one tile, or of a library that says which history applies where: that is matched over the
/// whole atlas. Parameters as transfer_item()'s.
[[nodiscard]] std::optional<analysis::TilesToEvaluate> transfer_tiles(const std::filesystem::path& transfer,
                                                                      const analysis::EvaluationOptions& options,
                                                                      std::uint64_t seed,
                                                                      const transfer::CacheOptions& cache);

}  // namespace patinate::cli
