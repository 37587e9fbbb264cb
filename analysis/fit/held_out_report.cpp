#include "analysis/fit/held_out_report.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

std::optional<double> read_misfit_or_null(const JsonReader& v) {
  return v.is_null() ? std::nullopt : std::optional<double>(v.number(at_least(0)));
}

}  // namespace

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

Json held_out_json(const FitTask& task, const FitOutcome& o) {
  if (!o.held_out) return nullptr;
  const HeldOut& h = *o.held_out;
  Json seeds = Json::array();
  for (const std::optional<double>& v : h.other_seeds) seeds.push_back(optional_json(v));
  Json json{{"until", *task.objective.until},
            {"unit", h.time_unit},
            {"times", h.num_times},
            {"before", optional_json(h.before)},
            {"after", optional_json(h.after)},
            {"other_seeds", seeds},
            {"last_frame", optional_json(h.last_frame)}};
  if (h.captures.size() == 1) json["shown"] = h.captures.front().shown;
  for (const HeldOutCapture& c : h.captures) {
    if (h.captures.size() == 1) break;
    json["captures"].push_back({{"name", c.name},
                                {"before", optional_json(c.before)},
                                {"after", optional_json(c.after)},
                                {"last_frame", optional_json(c.last_frame)},
                                {"shown", c.shown}});
  }
  return json;
}

std::optional<HeldOutFrames> read_held_out(JsonReader json) {
  if (json.is_null()) return std::nullopt;
  HeldOutFrames frames{.until = json.member("until").number(),
                       .num_times = static_cast<int>(json.member("times").integer(at_least(1))),
                       .after = read_misfit_or_null(json.member("after")),
                       .other_seeds = {},
                       .last_frame = read_misfit_or_null(json.member("last_frame"))};
  for (const JsonReader& seed : json.member("other_seeds").elements()) {
    if (const std::optional<double> v = read_misfit_or_null(seed)) frames.other_seeds.push_back(*v);
  }
  // Fits of earlier versions lack the members below.
  if (json.has("unit")) frames.time_unit = json.member("unit").string();
  if (json.has("shown"))
    frames.captures.push_back({.name = "", .after = frames.after, .shown = json.member("shown").string()});
  if (json.has("captures")) {
    for (JsonReader& c : json.member("captures").elements())
      frames.captures.push_back({.name = c.member("name").string(),
                                 .after = read_misfit_or_null(c.member("after")),
                                 .last_frame = read_misfit_or_null(c.member("last_frame")),
                                 .shown = c.member("shown").string()});
  }
  return frames;
}

}  // namespace patinate::analysis
