#include "capture/chart/judge_chart.h"

#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

/// CIEDE2000 of a patch that something lies over: twice what a 3 x 3 matrix leaves of the worst patch of real cameras.
constexpr double kHidden = 12.0;
/// Mean CIEDE2000 of a chart that is not the table's: twice what a 3 x 3 matrix leaves under the worst lamps.
constexpr double kMaxMean = 5.0;
constexpr std::size_t kMaxNamed = 4;  ///< Patches that a message names.

std::vector<std::string> hidden_patches(const ChartFit& fit, std::size_t photo, const ChartTable& table) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::vector<double> all;
    for (const ChartResidual& residual : fit.residuals) all.push_back(residual.patches[i]);
    const double usual = all.size() > 2 ? median(all) : 0.0;
    if (fit.residuals[photo].patches[i] > kHidden + usual) names.push_back(table[i].name);
  }
  return names;
}

}  // namespace

std::string judge_chart(const ChartFit& fit, std::size_t photo, const ChartTable& table) {
  const std::vector<std::string> hidden = hidden_patches(fit, photo, table);
  if (!hidden.empty() && 2 * hidden.size() < table.size()) {
    std::string names;
    for (std::size_t i = 0; i < std::min(kMaxNamed, hidden.size()); ++i) names += (i == 0 ? "" : ", ") + hidden[i];
    if (hidden.size() > kMaxNamed) names += " and " + std::to_string(hidden.size() - kMaxNamed) + " more";
    return "shows its chart partly hidden, wet, dirty or in a highlight, or it is of another make: " + names +
           (hidden.size() == 1 ? " does not have its color" : " do not have their colors");
  }
  const double mean = fit.residuals[photo].mean;
  if (hidden.empty() && mean <= kMaxMean) return "";
  return "shows a chart whose colors differ from the table's by CIEDE2000 " + short_number_text(rounded(mean, 2)) +
         " on average, more than " + short_number_text(kMaxMean) + ": another make, or uneven light over it";
}

}  // namespace patinate::capture
