/// \file
/// The items of an evaluation by tile.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "analysis/evaluation/evaluation_job.h"

namespace patinate::analysis {

/// What is concluded of a map: handed on when its tiles are measured.
struct ConcludedMap {
  Evaluation evaluation;
  std::vector<Figure> more;
  SynthesisSource source;
};

/// Adds stages of two items a tile, and one that concludes. @param index  Of the map in the task.
/// @param outputs,conclude  Of the last item: its files, and what writes them.
void add_tile_items(
    JobPlan& plan, const std::shared_ptr<const EvaluationTask>& task, std::size_t index,
    std::vector<std::filesystem::path> outputs,
    std::function<void(const std::filesystem::path& folder, ConcludedMap made, const RunControl& control)> conclude);

}  // namespace patinate::analysis
