#include "analysis/fit/held_out_report.h"

#include <algorithm>
#include <limits>

#include "libcommon/core/text.h"

namespace patinate::analysis {

std::string until_text(double until, const std::string& time_unit) {
  return figure_text(until) + (time_unit.empty() ? "" : " " + time_unit);
}

void add_held_out(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  if (!o.held_out) return;
  const HeldOut& h = *o.held_out;
  const std::string until = until_text(*task.objective.until, h.time_unit);
  page.heading("Held-out frames");
  page.paragraph("Only frames up to " + until + " were fitted. The objective at the " + std::to_string(h.num_times) +
                 " compared times after it measures how well the model predicts. A model that is no better than "
                 "holding the last fitted frame predicts nothing.");
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const std::optional<double>& v : h.other_seeds) {
    if (v) least = std::min(least, *v), most = std::max(most, *v);
  }
  std::vector<std::string> header{"", "objective after " + until};
  std::vector<std::vector<std::string>> rows{
      {"starting values", figure_text(h.before)},
      {"best values", figure_text(h.after)},
      {"best values, other seeds", least <= most ? figure_text(least) + " to " + figure_text(most) : "-"},
      {"the last frame seen, held", figure_text(h.last_frame)}};
  if (h.captures.size() > 1) {
    header.back() += ", mean";
    for (const HeldOutCapture& c : h.captures) {
      header.push_back(c.name);
      for (const auto& [row, value] : {std::pair{0, c.before}, {1, c.after}, {3, c.last_frame}})
        rows[row].push_back(figure_text(value));
      rows[2].emplace_back("-");  // Seeds are drawn for all captures together.
    }
  }
  page.table(header, rows);
  if (h.after && h.last_frame)
    page.paragraph(*h.after < *h.last_frame ? "The best values come nearer than the last frame does."
                                            : "The best values come no nearer than the last frame does.");
}

}  // namespace patinate::analysis
