/// \file
/// The figures that the steps of a study leave.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace patinate::cli {

/// A name, with the step's before it, and a number.
using StudyFigure = std::pair<std::string, double>;

/// What the manifest or report of a finished output says: a transfer's energies, a simulation's ledger and change, the
/// figures of evaluations and comparisons, what a fit has
/// found. None for pictures and other files.
/// @throws IoError if it is damaged.
[[nodiscard]] std::vector<StudyFigure> figures_of(const std::filesystem::path& made);

}  // namespace patinate::cli
