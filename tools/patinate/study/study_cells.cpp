#include "tools/patinate/study/study_cells.h"

#include <map>

#include "libcommon/core/text.h"
#include "tools/patinate/study/design.h"

namespace patinate::cli {

namespace {

constexpr std::size_t kMostCells = 1'000'000;
constexpr std::size_t kLongestName = 120;

/// Levels that would give the same cells, a line each.
std::vector<std::string> twins_in(const std::vector<StudyLevel>& factor) {
  std::map<std::string, std::vector<const StudyLevel*>> named;
  for (const StudyLevel& level : factor) {
    if (!level.name.empty()) named[level.name].push_back(&level);
  }
  std::vector<std::string> problems;
  for (const auto& [name, levels] : named) {
    if (levels.size() < 2) continue;
    const StudyLevel &first = *levels[0], &second = *levels[1];
    if (first.file.empty() || first.words.front() == second.words.front()) {
      problems.push_back((first.file.empty() ? "`" + name + "`" : first.file.string()) +
                         " is there twice: say it once, or give one another `name`");
    } else {
      problems.push_back(first.file.string() + " and " + second.file.string() + " would both be `" + name +
                         "` in the names of cells: give one a `name`");
    }
  }
  return problems;
}

StudyCell make_cell(const std::vector<std::vector<StudyLevel>>& factors, const std::vector<std::size_t>& point,
                    const std::vector<std::vector<std::string>>& step_words, const StudyPart& part) {
  StudyCell cell;
  std::vector<std::string> made;
  for (std::size_t f = 0; f < factors.size(); ++f) {
    const StudyLevel& level = factors[f][point[f]];
    if (!level.name.empty()) cell.name += (cell.name.empty() ? "" : "-") + level.name;
    cell.factors.insert(cell.factors.end(), level.shown.begin(), level.shown.end());
    made.insert(made.end(), level.words.begin(), level.words.end());
    cell.scene.pointers.insert(cell.scene.pointers.end(), level.pointers.begin(), level.pointers.end());
    cell.scene.values.insert(cell.scene.values.end(), level.values.begin(), level.values.end());
  }
  cell.name = cell.name.substr(0, kLongestName);
  if (!cell.scene.pointers.empty()) {
    cell.scene.file = factors.front()[point.front()].file;
    made.front() = "cells/" + cell.name + "/scene.json";
  }
  cell.words.push_back(std::move(made));
  for (const auto& words : step_words) {
    cell.words.push_back({"cells/" + cell.name + "/" + part.steps.front().file});
    cell.words.back().insert(cell.words.back().end(), words.begin(), words.end());
  }
  return cell;
}

}  // namespace

std::vector<std::string> make_cells(const std::vector<std::vector<StudyLevel>>& factors,
                                    const std::vector<std::vector<std::string>>& step_words, StudyPart& part) {
  double count = 1.0;
  std::vector<std::size_t> num_levels;
  std::vector<std::string> problems;
  for (const std::vector<StudyLevel>& factor : factors) {
    num_levels.push_back(factor.size());
    count *= static_cast<double>(factor.size());
    for (std::string& problem : twins_in(factor)) problems.push_back(std::move(problem));
  }
  if (count > static_cast<double>(kMostCells)) {
    problems.push_back("makes " + number_text(count) + " cells; at most " + std::to_string(kMostCells));
    return problems;
  }
  const bool is_told = !problems.empty();  // Once each, not once a cell.
  std::map<std::string, std::size_t> uses;
  for (const auto& point : grid_design(num_levels)) {
    StudyCell cell = make_cell(factors, point, step_words, part);
    if (++uses[cell.name] == 2 && !is_told)
      problems.push_back("two cells would be made in `cells/" + cell.name + "`: say it once, or give them a `name`");
    part.cells.push_back(std::move(cell));
  }
  return problems;
}

}  // namespace patinate::cli
