/// \file
/// Time-lapses as they are: surveying a project's photographs, repairing them on request, and masking what shows the
/// lamp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/project/capture_project.h"
#include "capture/stability/deflicker.h"
#include "capture/stability/fill.h"
#include "capture/stability/flat_field.h"
#include "capture/stability/highlights.h"
#include "capture/stability/restless_light.h"
#include "capture/stability/survey.h"
#include "capture/timelapse/light_report.h"
#include "patinate/core/options.h"

namespace patinate::capture {

enum class HighlightRule { Mask, Keep };
enum class StaticLightRule { Auto, Keep };

struct RepairOptions {
  bool stabilize = false;       ///< Lay moved photographs over the first one.
  bool deflicker = false;       ///< Take changes of exposure out.
  std::string flat_field = "";  ///< "" = none, "estimate", "first", or the path of a photograph of a uniform surface.
  HighlightRule highlights = HighlightRule::Mask;
  StaticLightRule static_light = StaticLightRule::Auto;  ///< Not beside a flat field.
  SurveyOptions survey = {};
  DeflickerOptions deflicker_options = {};
  FlatFieldOptions flat_field_options = {};
  HighlightOptions highlight_options = {};
  FillOptions fill = {};
};
void describe(OptionVisitor& v, RepairOptions& o);

/// The file of a history that says what the survey found.
inline constexpr const char* kSurveyFile = "survey.json";

/// A photograph as survey.json names it.
struct SurveyPhoto {
  std::string name;  ///< Without its folder; of a file with many images "copper.webp, image 57".
  double time = 0.0;
  int number = 0;  ///< Number as `exclude` counts.
};
/// SurveyProblem::size of one that cannot be laid over its neighbor: worse than any jump.
inline constexpr double kUnmatchedSize = 1e9;
/// One kind of thing that is wrong with a photograph.
struct SurveyProblem {
  std::string text;   ///< "" = nothing is wrong.
  double size = 0.0;  ///< How large it is among its like: px, log gain, or times the neighbors' change.
};
/// One thing that survey.json names.
struct SurveyFinding {
  SurveyPhoto photo;    ///< The one that stands out.
  std::string against;  ///< Name of the neighbor that it stands out from; "" in older files.
  std::string problem;  ///< finding_text().
  SurveyProblem moved = {}, exposed = {};
  SurveyProblem unclear = {};  ///< The light or the surface.
  SurveyProblem jump = {};     ///< Or it cannot be laid over the one before.
};
/// A photograph that cannot be laid over most of the others.
struct SurveyOutsider {
  SurveyPhoto photo;
  std::optional<double> similarity =
      {};                 ///< Similarity of its detail with the best of the others that it was laid over, [-1, 1].
  bool is_plain = false;  ///< It shows too little detail to be laid, and nothing says another view.
};
/// Content of a history's survey.json.
struct SurveyReport {
  std::vector<SurveyFinding> findings;
  std::vector<SurveyOutsider> unlinked;
  std::vector<SurveyPhoto> better_order;  ///< In which they follow one another much better; empty: in none.
  double detour = 1.0;                    ///< How much more followers differ than in that order.
  std::vector<int> excluded;              ///< Numbers that `exclude` of the project lists.
  bool is_stabilized = false;
  bool is_deflickered = false;
  std::optional<RestlessLight> restless_light;
  SeriesLight light;
  double masked_share = 0.0;  ///< Masked share of all pixels of all frames: saturated, highlight, out of view.
  double outside_share =
      0.0;  ///< Share of the pixels that are not known in every frame, so outside the history's mask.
};
/// @throws IoError. A history without the file gives an empty report.
[[nodiscard]] SurveyReport read_survey_report(const std::filesystem::path& history);

}  // namespace patinate::capture
