#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/stability/survey.h"
#include "capture/timelapse/repair.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// survey.json of a history, and the pairs that a resumed run reads back.
PATINATE_FUZZ_TARGET(survey) {
  const auto file = fuzz::fuzz_file("survey.json", bytes);
  const capture::SurveyReport report = capture::read_survey_report(file.parent_path());
  fuzz::require(report.masked_share >= 0.0 && report.masked_share <= 1.0, "a share lies in [0, 1]");
  for (const HistoryWarning& warning : capture::light_warnings(report.light, "", 3))
    fuzz::require(!warning.text.empty() && warning.share >= 0.0 && warning.share <= 1.0, "a warning says something");
  for (const std::string& note : capture::light_notes(report.light)) fuzz::require(!note.empty(), "a note has a text");
  const Json json = load_json(file);
  std::vector<capture::FramePair> pairs;
  for (const JsonReader& pair : JsonReader(file.string(), json).member("pairs").elements())
    pairs.push_back(capture::pair_from_json(pair));
  for (const capture::FrameFinding& finding : capture::judge_frames(pairs, 64, 48))
    fuzz::require(!capture::finding_text(finding).empty(), "a finding has a text");
}
