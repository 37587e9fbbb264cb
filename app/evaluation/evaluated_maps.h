/// \file
/// Coordinate maps to evaluate: transfers, and what other tools leave.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evaluation/evaluation_job.h"
#include "patinate/transfer/age.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/exemplar/appearance_cache.h"
#include "transfer/synthesis/audit.h"

namespace patinate::app {

/// Options that a map needs that is no transfer.
struct ForeignMapOptions {
  std::filesystem::path history;  ///< History that the tool copied from.
  std::string control;  ///< [SOURCE=]MAP: what the tool followed, in the values of the history's control; "" = none.
  std::filesystem::path picture;  ///< The picture that the tool made, of the history's last frame; "" = none.
};

/// "[SOURCE=]MAP" with the map's name only.
[[nodiscard]] std::string named_control(const std::string& spec);

/// Source that maps are measured against: frames evenly spread over the history, the last among them, as codes.
/// @param control  Of the history; "" = none.
[[nodiscard]] analysis::SynthesisSource evaluated_source(const History& history, const std::string& control,
                                                         double pixel_mm, int num_times);
/// The energy that a transfer recorded, and its audit.
[[nodiscard]] std::vector<analysis::Figure> transfer_figures(const transfer::TransferManifest& manifest,
                                                             const std::optional<transfer::OptimumAudit>& audit);

/// A transfer: its history, its first control, its energy, which is audited with its own coherence share and controls.
/// @param options  Times and audits. @param seed  Of the audits. @param cache  Of the appearance that audits need.
[[nodiscard]] analysis::EvaluationItem transfer_item(const std::filesystem::path& transfer,
                                                     const analysis::EvaluationOptions& options, std::uint64_t seed,
                                                     const transfer::CacheOptions& cache);
/// Map of a transfer in memory, measured as a transfer's folder would be.
[[nodiscard]] analysis::MapToEvaluate aged_map(const std::string& name, const transfer::AgedMesh& aged,
                                               const analysis::EvaluationOptions& options, std::uint64_t seed,
                                               const RunControl& control = {});
/// A coordinate map of another tool, over a flat picture: EXR or TIFF with channels source.x and source.y (or its first
/// two), 16-bit PNG (R = x, G = y), or
/// `.nnf`: int32 x, y for every pixel, row by row, little-endian, of the size of the control map or the picture.
/// Audited, where there is a control, with the energy of a transfer's default options.
/// @throws IoError, InvalidInput, UsageError
[[nodiscard]] analysis::EvaluationItem foreign_item(const std::filesystem::path& map, const ForeignMapOptions& foreign,
                                                    const analysis::EvaluationOptions& options, std::uint64_t seed,
                                                    const transfer::CacheOptions& cache);

}  // namespace patinate::app
