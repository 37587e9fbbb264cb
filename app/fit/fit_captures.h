/// \file
/// Histories and scenes as what a fit is given: which numbers they share, and which are each one's own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/fit/fit_job.h"
#include "app/fit/fit_scene.h"

namespace patinate::app {

/// A history to come close to, and the scene that is to.
struct FitSource {
  std::filesystem::path history;  ///< Or a transfer.
  std::string name;               ///< For reports, where there are several; they differ.
  std::filesystem::path scene;
};

/// Short names of histories that differ: their folders' names, or all of what was given where two are alike.
[[nodiscard]] std::vector<std::string> capture_names(const std::vector<std::string>& given);

/// The scene of one of several captures, whose simulation has a seed of its own. @throws what FitScene does
[[nodiscard]] FitScene scene_of_capture(std::size_t capture, const std::filesystem::path& file,
                                        const std::vector<analysis::FitRange>& ranges,
                                        const std::vector<std::string>& controls, const RunControl& control);

/// A number for all captures where they share the range, else one for each. @param scenes, names  One a capture.
[[nodiscard]] std::vector<analysis::FitParameter> joint_parameters(const std::vector<FitScene>& scenes,
                                                                   const std::vector<analysis::FitRange>& ranges,
                                                                   const std::vector<std::string>& names);

/// Gives a task its captures, parameters, name and inputs. A range that all share begins at the first scene's value,
/// one that is each one's own at each scene's. Every capture's simulation has a seed of its own.
/// @param sources  At least one. @param output  Folder of the fit in the end. @returns what the scenes' readers note.
/// @throws what FitScene does; IoError.
std::vector<std::string> add_captures(analysis::FitTask& task, const std::vector<FitSource>& sources,
                                      const std::vector<analysis::FitRange>& ranges,
                                      const std::filesystem::path& output, const RunControl& control);

}  // namespace patinate::app
