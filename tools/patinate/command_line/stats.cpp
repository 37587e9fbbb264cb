#include "tools/patinate/command_line/stats.h"

#include <nlohmann/json.hpp>

#include "analysis/figures/compared_pair.h"
#include "analysis/statistics/history_statistics.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

namespace {

std::string cell(const std::string& text) { return std::string(text.size() < 10 ? 10 - text.size() : 1, ' ') + text; }
std::string cell(double v) { return cell(short_number_text(rounded(v, 4) + 0.0)); }

Json quartiles_json(const std::optional<analysis::TimeQuartiles>& q) {
  if (!q) return Json{{"undefined", "no place ages visibly"}};
  return Json{{"q25", q->q25}, {"median", q->median}, {"q75", q->q75}};
}

std::string quartiles_text(const std::string& name, const std::optional<analysis::TimeQuartiles>& q,
                           const std::string& unit) {
  if (!q) return "\n" + name + ": no place ages visibly";
  return "\n" + name + ": median " + short_number_text(rounded(q->median, 4)) + " " + unit +
         ", half of the places between " + short_number_text(rounded(q->q25, 4)) + " and " +
         short_number_text(rounded(q->q75, 4));
}

Json json_of(const analysis::HistoryStatistics& s, const std::vector<analysis::ColorClass>& classes,
             const std::string& unit) {
  Json frames = Json::array();
  for (std::size_t t = 0; t < s.times.size(); ++t) {
    Json frame{{"time", s.times[t]},
               {"mean_lab", s.mean_lab[t]},
               {"correlation_length", s.correlation_length[t] ? Json(*s.correlation_length[t]) : Json(nullptr)}};
    if (!s.covered.empty()) frame["covered"] = s.covered[t];
    for (std::size_t k = 0; k < classes.size(); ++k) frame["classes"][classes[k].name] = s.class_shares[t][k];
    frames.push_back(std::move(frame));
  }
  return Json{{"kind", "statistics"},
              {"time_unit", unit},
              {"length_unit", s.is_metric ? "mm" : "px"},
              {"frames", frames},
              {"ages_share", s.ages_share},
              {"onset", quartiles_json(s.onset)},
              {"saturation", quartiles_json(s.saturation)}};
}

std::string text_of(const analysis::HistoryStatistics& s, const std::vector<analysis::ColorClass>& classes,
                    const std::string& unit) {
  std::string text = cell("time " + unit) + cell("L*") + cell("a*") + cell("b*") + cell("covered") +
                     cell(s.is_metric ? "corr. mm" : "corr. px");
  for (const analysis::ColorClass& c : classes) text += cell(c.name);
  for (std::size_t t = 0; t < s.times.size(); ++t) {
    text += "\n" + cell(s.times[t]);
    for (double v : s.mean_lab[t]) text += cell(v);
    text += s.covered.empty() ? cell("-") : cell(s.covered[t]);
    text += s.correlation_length[t] ? cell(*s.correlation_length[t]) : cell("-");
    for (std::size_t k = 0; k < classes.size(); ++k) text += cell(s.class_shares[t][k]);
  }
  text += "\nages visibly: " + percent_text(s.ages_share) + " of the places";
  return text + quartiles_text("onset", s.onset, unit) + quartiles_text("saturation", s.saturation, unit);
}

}  // namespace

void StatsArgument::declare(CommandLine& line) {
  line.flag(
      "stats",
      "What the frames of a history or transfer say: mean color, covered share, correlation length, onset, saturation",
      is_asked);
  line.repeated("class", "NAME=#RRGGBB", "With --stats: the share of pixels nearest to this color, of those given",
                classes);
}

int report_stats(CommandRun& run, const StatsArgument& stats, const std::filesystem::path& subject) {
  const PathKind kind = kind_of(subject);
  if (kind != PathKind::History && kind != PathKind::Transfer)
    throw InvalidInput(subject.string() + ": is no history or transfer, and has no frames");
  std::vector<analysis::ColorClass> classes;
  for (const std::string& text : stats.classes) {
    try {
      classes.push_back(analysis::parse_color_class(text));
    } catch (const InvalidInput& e) {
      throw UsageError(std::string("--class: ") + e.what());
    }
  }
  const analysis::CompareOptions options;
  const analysis::TextureSeries series = analysis::open_series(subject).series;
  const analysis::HistoryStatistics found =
      analysis::history_statistics(series, classes, options.size, options.visible_delta_e, run.control("statistics"));
  const std::string unit = time_unit_text(series.facts().time_unit);
  note_history_warnings(run, subject.string(), series.facts().warnings);
  run.report(json_of(found, classes, unit), text_of(found, classes, unit));
  return 0;
}

}  // namespace patinate::cli
