#include "capture/timelapse/ingest_warnings.h"

#include <algorithm>

#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

/// Findings of one kind as one warning; the largest change is quoted.
void add_group(std::vector<HistoryWarning>& warnings, const std::vector<const SurveyFinding*>& group, int num_frames,
               WarningSubject about, const std::string& what, const std::string& cure) {
  if (group.empty()) return;
  HistoryWarning warning{.about = about, .text = "", .cure = cure};
  for (const SurveyFinding* f : group) warning.photos.push_back(f->photo);
  const SurveyFinding& worst = **std::max_element(
      group.begin(), group.end(), [](const SurveyFinding* a, const SurveyFinding* b) { return a->size < b->size; });
  if (group.size() == 1) {
    warning.text = worst.photo + " (time " + short_number_text(worst.time) + "): " + worst.problem;
  } else {
    warning.text = std::to_string(group.size()) + " of " + std::to_string(num_frames) + " photographs " + what + " (" +
                   photo_list(warning.photos) + "); the worst is " + worst.photo + " (time " +
                   short_number_text(worst.time) + "), " + worst.problem;
  }
  warning.share = std::min(1.0, static_cast<double>(group.size()) / num_frames);
  warnings.push_back(std::move(warning));
}

}  // namespace

std::string photo_list(const std::vector<std::string>& photos, std::size_t most) {
  std::string list;
  const std::size_t shown = photos.size() <= most + 1 ? photos.size() : most;  // "and 1 more" is no shorter.
  for (std::size_t i = 0; i < shown; ++i) list += (i == 0 ? "" : ", ") + photos[i];
  return shown == photos.size() ? list : list + " and " + std::to_string(photos.size() - shown) + " more";
}

std::vector<HistoryWarning> survey_warnings(const SurveyReport& survey, int num_frames) {
  std::vector<HistoryWarning> warnings;
  std::vector<const SurveyFinding*> moved, exposed, jumping, unclear;
  for (const SurveyFinding& f : survey.findings) {
    if (f.is_shifted && !survey.is_stabilized) moved.push_back(&f);
    if (f.is_exposure_changed && !survey.is_deflickered) exposed.push_back(&f);
    if (f.is_light_unclear && !f.is_jump) unclear.push_back(&f);
    if (f.is_jump) jumping.push_back(&f);
  }
  add_group(warnings, moved, num_frames, WarningSubject::Motion, "are moved against the ones before",
            "--stabilize lays them over one another");
  add_group(warnings, exposed, num_frames, WarningSubject::Light, "are exposed differently from the ones before",
            "--deflicker takes it out; where one photograph alone differs, `exclude` it");
  add_group(warnings, unclear, num_frames, WarningSubject::Light,
            "are brighter or darker than the ones before, by the light or by the surface itself",
            "look at them; --deflicker leaves what most of the picture does not share");
  add_group(warnings, jumping, num_frames, WarningSubject::Series, "do not follow from the ones before",
            "look at them, and `exclude` what shows something else");
  return warnings;
}

}  // namespace patinate::capture
