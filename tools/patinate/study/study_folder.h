/// \file
/// The folder of a study: `cells.json`, and for each cell `cells/NAME` with what its steps make, `done/STEP/NAME` when
/// a step is done, and `logs/STEP/NAME.txt` with what it said. Whoever runs a step, `patinate study run` or Snakemake,
/// leaves the same.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/patinate/study/study.h"

namespace patinate::cli {

inline constexpr const char* kCellsFile = "cells.json";

/// A cell as its folder knows it.
struct PlacedCell {
  std::string name;
  std::vector<std::pair<std::string, std::string>> factors;
  std::vector<std::string> commands;  ///< Of each step, as a shell takes it, to be given in the study's folder.
};

struct PlacedPart {
  std::string name;
  std::vector<StudyStep> steps;
  std::vector<PlacedCell> cells;
};

struct StudyFolder {
  std::filesystem::path path;
  std::string name;
  std::vector<PlacedPart> parts;
};

enum class StepStatus { NotRun, Done, Failed };

/// How a step of a cell has ended.
struct StepState {
  StepStatus status = StepStatus::NotRun;
  std::string message;  ///< Of a failed one: its one line.
};

/// Makes or updates a study's folder: cells.json, folders and scenes. What cells have made stays; what is no cell any
/// more stays too, and is in no report.
/// @throws CannotComplete if the folder holds other things; IoError for a scene.
StudyFolder place_study(const Study& study, const std::filesystem::path& folder);
/// @throws IoError unless it is the folder of a study.
[[nodiscard]] StudyFolder read_study_folder(const std::filesystem::path& folder);

/// Relative to the study's folder.
[[nodiscard]] std::filesystem::path done_file(const StudyStep& step, const PlacedCell& cell);
[[nodiscard]] std::filesystem::path log_file(const StudyStep& step, const PlacedCell& cell);
[[nodiscard]] std::filesystem::path made_path(const StudyStep& step, const PlacedCell& cell);
[[nodiscard]] StepState step_state(const StudyFolder& study, const StudyStep& step, const PlacedCell& cell);

}  // namespace patinate::cli
