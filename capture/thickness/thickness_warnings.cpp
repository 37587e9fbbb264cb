#include "capture/thickness/thickness_warnings.h"

#include <cmath>

#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr double kClear = 0.9;      ///< Share of the brightest light: what lets this much through is no paint.
constexpr double kMuchWeak = 0.05;  ///< Share of the layer, from where on the 95th percentile of the error is spoiled.

HistoryWarning hole_warning(const LayerEvidence& e, const std::string& photo) {
  const bool is_gone = e.hole_light >= kClear * e.brightest;
  const std::string width = short_number_text(std::round(e.hole_width_px));
  HistoryWarning warning{.about = WarningSubject::Control, .text = "", .cure = "", .share = e.hole_share};
  warning.photos = {photo};
  warning.text = photo + ": the layer is " + (is_gone ? "missing" : "missing or much thinner") + " in " +
                 fixed_percent_text(e.hole_share) + " of its area. These places are up to " + width +
                 " px wide, too wide for the window, so their thickness is that of the holes";
  if (e.filling_sigma_px > 0.0) {
    warning.cure = "--spatial-sigma " + short_number_text(e.filling_sigma_px) +
                   " fills them from their surroundings; mask the places that must not be filled";
  } else {
    warning.cure = "exclude these places with the mask; no wider window fills them without changing the rest";
  }
  return warning;
}

HistoryWarning weak_warning(const LayerEvidence& e, const std::string& photo, const ModeFilterOptions& options) {
  HistoryWarning warning{.about = WarningSubject::Control, .text = "", .cure = "", .share = e.weak_share};
  warning.photos = {photo};
  warning.text = photo + ": the thickness is uncertain in " + fixed_percent_text(e.weak_share) +
                 " of the layer, where the most frequent value covers less than half of its window (" +
                 fixed_percent_text(e.share) + " in the median)";
  if (e.noise > options.range_sigma) {
    warning.cure = "--range-sigma " + short_number_text(rounded(e.noise, 2)) + ", which is the photograph's noise";
  } else {
    warning.cure =
        "a larger --spatial-sigma where cracks are wide, a smaller one where the layer slopes, and a mask that leaves "
        "only the layer";
  }
  return warning;
}

}  // namespace

std::vector<HistoryWarning> thickness_warnings(const LayerEvidence& evidence, const std::string& photo,
                                               const ThicknessOptions& options) {
  std::vector<HistoryWarning> warnings;
  if (evidence.hole_share >= kNamedHoleShare) warnings.push_back(hole_warning(evidence, photo));
  if (evidence.weak_share >= kMuchWeak) warnings.push_back(weak_warning(evidence, photo, options.mode_filter));
  sort_warnings(warnings);
  return warnings;
}

std::string layer_window_text(const LayerWindow& window) {
  if (!window.is_chosen) return "";
  return "chose a window of " + short_number_text(window.sigma_px) +
         " px; it predicts the light of held-out squares of " + std::to_string(window.gap_px) +
         " px with an error of " + fixed_percent_text(window.foretold_to) + " (set another with --spatial-sigma)";
}

}  // namespace patinate::capture
