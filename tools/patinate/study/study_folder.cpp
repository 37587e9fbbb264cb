#include "tools/patinate/study/study_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/services/fit_scene.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFormat = "patinate.cells";
constexpr std::string_view kErrorMark = "patinate: error: ";
constexpr std::uint64_t kMostOfLog = 1 << 24;

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw CannotComplete(path.string() + ": cannot be made; " + error.message());
}

/// What makes a step's output, but for the beginning "patinate run".
std::string command_of(const StudyStep& step, const StudyCell& cell, const std::vector<std::string>& words) {
  std::string text = step.verb;
  for (const std::string& word : words) text += " " + shell_word(word);
  return text + " -o " + shell_word("cells/" + cell.name + "/" + step.file);
}

void write_scene(const StudyCell& cell, const fs::path& folder) {
  std::vector<analysis::FitRange> ranges;
  for (std::size_t i = 0; i < cell.scene.pointers.size(); ++i) {
    ranges.push_back({.name = cell.scene.pointers[i], .low = cell.scene.values[i], .high = cell.scene.values[i]});
    ranges.back().place = cell.scene.file.string();
  }
  FitScene(cell.scene.file, ranges, {}, {}).write(folder, "scene", folder, cell.scene.values);
}

Json part_json(const PlacedPart& part) {
  Json steps = Json::array(), cells = Json::array();
  for (const StudyStep& s : part.steps) {
    steps.push_back({{"name", s.name}, {"command", s.verb}, {"makes", s.file}});
    if (s.in_items) steps.back()["in_items"] = true;
  }
  for (const PlacedCell& cell : part.cells) {
    Json factors = Json::object(), commands = Json::object();
    for (const auto& [name, value] : cell.factors) factors[name] = value;
    for (std::size_t s = 0; s < part.steps.size(); ++s) commands[part.steps[s].name] = cell.commands[s];
    cells.push_back({{"name", cell.name}, {"factors", factors}, {"commands", commands}});
  }
  return {{"name", part.name}, {"steps", steps}, {"cells", cells}};
}

PlacedPart read_part(JsonReader json) {
  PlacedPart part{.name = json.member("name").string(), .steps = {}, .cells = {}};
  for (JsonReader& step : json.member("steps").elements()) {
    part.steps.push_back({step.member("name").string(), step.member("command").string(), step.member("makes").string(),
                          step.has("in_items") && step.member("in_items").boolean()});
  }
  for (JsonReader& cell : json.member("cells").elements()) {
    PlacedCell& placed = part.cells.emplace_back();
    placed.name = cell.member("name").string();
    JsonReader factors = cell.member("factors"), commands = cell.member("commands");
    for (const std::string& name : factors.keys()) placed.factors.emplace_back(name, factors.member(name).string());
    for (const StudyStep& step : part.steps) placed.commands.push_back(commands.member(step.name).string());
  }
  return part;
}

/// Nothing is there, a study, or what was left where one was begun.
bool is_free(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) || fs::exists(folder / kCellsFile, error)) return true;
  if (!fs::is_directory(folder, error)) return false;
  const auto is_begun = [](const fs::directory_entry& entry) {
    const fs::path name = entry.path().filename();
    return is_temporary(name) || name == "cells" || name == "done" || name == "logs";
  };
  const fs::directory_iterator entries(folder, error);
  return !error && std::all_of(begin(entries), end(entries), is_begun);
}

void make_folders(const StudyPart& part, const fs::path& folder) {
  for (const StudyCell& cell : part.cells) {
    make_folder(folder / "cells" / cell.name);
    if (!cell.scene.file.empty()) write_scene(cell, folder / "cells" / cell.name);
  }
  for (const StudyStep& step : part.steps) {
    make_folder(folder / "done" / step.name);
    make_folder(folder / "logs" / step.name);
  }
}

}  // namespace

StudyFolder place_study(const Study& study, const fs::path& folder) {
  if (!is_free(folder)) {
    throw CannotComplete(folder.string() + ": exists and is no study's folder, so it is left untouched; give another");
  }
  StudyFolder placed{.path = folder, .name = study.name, .parts = {}};
  Json parts = Json::array();
  for (const StudyPart& part : study.parts) {
    PlacedPart& p = placed.parts.emplace_back(PlacedPart{.name = part.name, .steps = part.steps, .cells = {}});
    for (const StudyCell& cell : part.cells) {
      PlacedCell& c = p.cells.emplace_back(PlacedCell{.name = cell.name, .factors = cell.factors, .commands = {}});
      for (std::size_t s = 0; s < part.steps.size(); ++s)
        c.commands.push_back(command_of(part.steps[s], cell, cell.words[s]));
    }
    parts.push_back(part_json(p));
  }
  // First, so that a folder that was begun is known to be a study's.
  make_folder(folder);
  save_json(folder / kCellsFile, Json{{"format", kFormat}, {"version", 1}, {"name", study.name}, {"parts", parts}});
  for (const StudyPart& part : study.parts) make_folders(part, folder);
  return placed;
}

StudyFolder read_study_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / kCellsFile, error))
    throw IoError(folder.string(), "is no study's folder; `patinate study run` or `study export` makes one");
  const Json root = load_json(folder / kCellsFile);
  JsonReader json((folder / kCellsFile).string(), root);
  json.expect_format(kFormat, 1);
  StudyFolder study{.path = folder, .name = json.member("name").string(), .parts = {}};
  for (const JsonReader& part : json.member("parts").elements()) study.parts.push_back(read_part(part));
  return study;
}

fs::path done_file(const StudyStep& step, const PlacedCell& cell) { return fs::path("done") / step.name / cell.name; }
fs::path log_file(const StudyStep& step, const PlacedCell& cell) {
  return fs::path("logs") / step.name / (cell.name + ".txt");
}
fs::path made_path(const StudyStep& step, const PlacedCell& cell) { return fs::path("cells") / cell.name / step.file; }

StepState step_state(const StudyFolder& study, const StudyStep& step, const PlacedCell& cell) {
  std::error_code error;
  if (fs::exists(study.path / done_file(step, cell), error)) return {StepStatus::Done, ""};
  const fs::path log = study.path / log_file(step, cell);
  if (!fs::is_regular_file(log, error)) return {};
  const std::string text = read_file(log, kMostOfLog);
  const std::size_t at = text.rfind(kErrorMark);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + kErrorMark.size();
  return {StepStatus::Failed, text.substr(begin, text.find('\n', begin) - begin)};
}

}  // namespace patinate::cli
