#include "capture/timelapse/align_warnings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "capture/project/given_transforms.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/ingest_warnings.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr double kMaxResidual_px = 1.0;  ///< Half of it is blur that a person sees.
constexpr double kMinFineness = 0.5;     ///< A detail of one of the reference's pixels is lost.
constexpr double kMinShown = 0.5;        ///< Share of the reference (docs/capture.md, Photographs from the hand).
constexpr const char* kClicked = "`landmarks` (`patinate studio` lets you click them)";

/// Photographs for which `value` is on the wrong side, the worst first.
struct Chosen {
  std::vector<std::string> names;
  double worst = 0.0;
};

Chosen choose(const Json& photos, const char* member, const std::function<bool(double)>& is_wrong, bool is_high_worse) {
  std::vector<std::pair<double, std::string>> found;
  for (const Json& photo : photos) {
    if (!photo.contains(member) || !is_wrong(photo.at(member).get<double>())) continue;
    found.emplace_back(photo.at(member).get<double>(), photo.at("photo").get<std::string>());
  }
  std::stable_sort(found.begin(), found.end(),
                   [&](const auto& a, const auto& b) { return is_high_worse ? a.first > b.first : a.first < b.first; });
  Chosen chosen;
  for (const auto& [value, name] : found) chosen.names.push_back(name);
  if (!found.empty()) chosen.worst = found.front().first;
  return chosen;
}

/// A verb of one photograph and of several.
struct What {
  std::string one, many;
};

/// "5 of 17 photographs WHAT (names); the worst is X: VALUE", or "X WHAT: VALUE".
std::string text_of(const Chosen& chosen, std::size_t num_photos, const What& what, const std::string& value) {
  if (chosen.names.size() == 1) return chosen.names.front() + " " + what.one + ": " + value;
  return std::to_string(chosen.names.size()) + " of " + std::to_string(num_photos) + " photographs " + what.many +
         " (" + photo_list(chosen.names) + "); the worst is " + chosen.names.front() + ": " + value;
}

/// Whether one of the named photographs was laid by a similarity, so that another view may fit better.
bool is_any_similarity(const Json& photos, const std::vector<std::string>& names) {
  return std::any_of(photos.begin(), photos.end(), [&](const Json& photo) {
    return photo.value("model", "") == "similarity" &&
           std::find(names.begin(), names.end(), photo.at("photo").get<std::string>()) != names.end();
  });
}

}  // namespace

std::vector<HistoryWarning> report_alignment(const IngestWork& work, const fs::path& folder) {
  std::vector<HistoryWarning> warnings;
  if (!needs_alignment(work)) return warnings;
  const Json alignment = load_json(folder / kAlignmentFile);
  const Json& photos = alignment.at("photos");
  if (fs::exists(folder / "survey.json")) {
    Json survey = load_json(folder / "survey.json");
    survey["alignment"] = {
        {"reference", alignment.at("reference")}, {"method", alignment.at("method")}, {"photos", photos}};
    save_json(folder / "survey.json", survey);
  }
  const auto add = [&](WarningSubject about, const Chosen& chosen, const What& what, const std::string& value,
                       const std::string& cure, double share) {
    if (chosen.names.empty()) return;
    warnings.push_back(
        {.about = about,
         .text = text_of(chosen, photos.size(), what, value),
         .cure = cure,
         .share = std::clamp(share * static_cast<double>(chosen.names.size()) / static_cast<double>(photos.size()), 0.0,
                             1.0),
         .photos = chosen.names});
  };
  Chosen failed;
  for (const Json& photo : photos) {
    if (!photo.contains("transform")) failed.names.push_back(photo.at("photo").get<std::string>());
  }
  add(WarningSubject::Series, failed, {"cannot be aligned with the others", "cannot be aligned with the others"},
      "left out of the history",
      "mark points in them (`patinate studio`, or a table as `landmarks`), or give their `transform`", 1.0);
  const Chosen loose = choose(
      photos, "residual_px", [](double v) { return v > kMaxResidual_px; }, true);
  const bool is_by_outline = work.project.align.method == AlignMethod::Outline;
  add(WarningSubject::Motion, loose, {"fits the others only roughly", "are aligned with the others only roughly"},
      std::string(is_by_outline ? "its outline disagrees by " : "its details disagree by ") + hundredths(loose.worst) +
          " px of the reference photograph",
      is_by_outline
          ? std::string("nothing if the object itself changes its shape; else ") + kClicked +
                ", or `align` \"features\""
          : std::string(is_any_similarity(photos, loose.names) ? "`align_model` \"homography\" for a tilted view; "
                                                               : "") +
                kClicked + "; or a coarser photograph as `align_to`",
      0.5);
  const Chosen coarse = choose(
      photos, "pixels_per_reference_pixel", [](double v) { return v < kMinFineness; }, false);
  add(WarningSubject::Series, coarse,
      {"is much coarser than the reference photograph", "are much coarser than the reference photograph"},
      hundredths(coarse.worst) + " of its pixels for one of the reference's, so it is soft in the history",
      "a coarser photograph as `align_to`, or a `scale` of the history", 0.3);
  const Chosen little = choose(
      photos, "shown_share", [](double v) { return v < kMinShown; }, false);
  add(WarningSubject::Mask, little,
      {"shows less than half of the reference photograph's frame",
       "show less than half of the reference photograph's frame"},
      fixed_percent_text(little.worst),
      "a `roi` on what all of them show, a reference photograph that shows less (`align_to`), or leave them out "
      "(`exclude`)",
      1.0 - little.worst);
  return warnings;
}

}  // namespace patinate::capture
