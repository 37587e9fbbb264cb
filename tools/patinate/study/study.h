/// \file
/// A study: one command on many inputs with many options, and what is made of each result.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace patinate::cli {

/// A command of every cell of a part: the one that makes its subject, or one that looks at that.
struct StudyStep {
  std::string name;  ///< Unique in the study, of letters, digits, `_`: "transfer", "transfer_strip".
  std::string verb;
  std::string file;       ///< What it makes, in the cell's folder.
  bool in_items = false;  ///< Snakemake runs its plan's items, each as a job: a fit, or a transfer by tile.
};

/// A scene of a cell, with other numbers than the file has.
struct StudyScene {
  std::filesystem::path file;
  std::vector<std::string> pointers;  ///< JSON pointers.
  std::vector<double> values;
};

/// One combination of what a study varies.
struct StudyCell {
  std::string name;                                          ///< Unique, a file name.
  std::vector<std::pair<std::string, std::string>> factors;  ///< What it is, for tables: ("mesh", "bust").
  /// Of each step, the words after the verb; paths relative to the study's folder, without -o.
  std::vector<std::vector<std::string>> words;
  StudyScene scene;  ///< Where it is not empty, written to the cell's folder before the first step.
};

/// All cells that share their steps: the transfers, or the simulations.
struct StudyPart {
  std::string name;  ///< "transfer" or "simulate".
  std::vector<StudyStep> steps;
  std::vector<StudyCell> cells;
};

struct Study {
  std::string name;
  std::vector<StudyPart> parts;
};

}  // namespace patinate::cli
