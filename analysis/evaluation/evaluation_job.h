/// \file
/// An evaluation of several coordinate maps as a job: `evaluation.html`, `evaluation.json`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evaluation/evaluation.h"
#include "analysis/evaluation/map_figures.h"
#include "libcommon/job/job.h"

namespace patinate::analysis {

inline constexpr const char* kEvaluationFile = "evaluation.json";
inline constexpr const char* kEvaluationPageFile = "evaluation.html";

/// A map with all that it is measured against.
struct MapToEvaluate {
  SynthesisSource source;
  SynthesizedMap map;
  std::optional<MadePicture> made;
  std::vector<Figure> more;  ///< Further figures that its maker knows: energy, audit (M1). Shown first.
};

/// One map that is opened when its turn comes.
struct EvaluationItem {
  std::string name;   ///< Unique; for people.
  std::string about;  ///< One line: file, source, control.
  std::string key;    ///< Key of all that it depends on.
  std::function<MapToEvaluate(const RunControl& control)> open;
};

struct EvaluationTask {
  std::vector<EvaluationItem> maps;  ///< At least one.
  EvaluationOptions options;
  std::uint64_t seed = 1;
  std::string command;  ///< Command that repeats it, for the report; no part of the key.
};

/// An item a map.
/// @throws InvalidInput if there is no map or a name occurs twice.
[[nodiscard]] JobPlan plan_evaluation(EvaluationTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
