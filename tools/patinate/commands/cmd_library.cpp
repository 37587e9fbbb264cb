#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/similarity/similarity.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_card.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/history_library.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/commands.h"
#include "tools/studio/picture_bytes.h"

namespace patinate::cli {

namespace {

constexpr int kThumbnailSide_px = 160;
constexpr std::size_t kThumbnails = 5;

struct Entry {
  std::string name;
  std::shared_ptr<const HistoryReader> history;
  std::optional<HistoryCard> card;

  [[nodiscard]] const HistoryFacts& facts() const { return history->facts(); }
  [[nodiscard]] double duration() const { return facts().frames.back().time - facts().frames.front().time; }
  [[nodiscard]] std::string duration_text() const {
    return short_number_text(rounded(duration(), 4)) + " " + time_unit_text(facts().time_unit);
  }
  [[nodiscard]] std::string title() const { return card ? card->title : facts().name; }
  [[nodiscard]] std::string controls_text() const {
    std::string text;
    for (const ControlFacts& control : facts().controls) text += (text.empty() ? "" : ", ") + control.name;
    return text.empty() ? "none" : text;
  }
};

Json json_of(const Entry& entry) {
  const HistoryFacts& facts = entry.facts();
  Json controls = Json::array();
  for (const ControlFacts& control : facts.controls) controls.push_back(control.name);
  Json json{{"name", entry.name},
            {"folder", entry.history->folder().string()},
            {"title", entry.title()},
            {"origin", facts.origin},
            {"width", facts.width},
            {"height", facts.height},
            {"texel_size_mm", facts.texel_size_mm ? Json(*facts.texel_size_mm) : Json(nullptr)},
            {"frames", facts.frames.size()},
            {"duration", entry.duration()},
            {"time_unit", time_unit_text(facts.time_unit)},
            {"controls", controls}};
  if (entry.card) {
    json["about"] = entry.card->about;
    json["license"] = entry.card->license;
    json["attribution"] = entry.card->attribution;
    json["source"] = entry.card->source;
  }
  return json;
}

/// Columns of equal width, two blanks apart; the last one as long as it is.
std::string table_text(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += row[c];
      if (c + 1 < row.size()) line.append(widths[c] - row[c].size() + 2, ' ');
    }
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

std::string list_text(const std::vector<Entry>& entries) {
  std::vector<std::vector<std::string>> rows{{"name", "frames", "duration", "controls", "license", "what"}};
  for (const Entry& entry : entries) {
    rows.push_back({entry.name, std::to_string(entry.facts().frames.size()), entry.duration_text(),
                    entry.controls_text(), entry.card ? entry.card->license : "not stated", entry.title()});
  }
  return table_text(rows) + "\n\npatinate transfer library:" + entries.front().name +
         " MESH --control accessibility -o aged";
}

HtmlPicture thumbnails_of(const Entry& entry) {
  const HistoryFacts& facts = entry.facts();
  const double scale =
      std::min(1.0, static_cast<double>(kThumbnailSide_px) / static_cast<double>(std::max(facts.width, facts.height)));
  const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(scale * side))); };
  std::vector<double> times;
  std::vector<ImageF> pictures;
  for (std::size_t i = 0; i < std::min(kThumbnails, facts.frames.size()); ++i) {
    const std::size_t frame = i * (facts.frames.size() - 1) / std::max<std::size_t>(1, kThumbnails - 1);
    times.push_back(facts.frames[std::min(frame, facts.frames.size() - 1)].time);
    if (times.size() > 1 && times.back() == times[times.size() - 2]) {
      times.pop_back();
      continue;
    }
    pictures.push_back(downscale_area(entry.history->sample(times.back()), scaled(facts.width), scaled(facts.height)));
  }
  const ImageF strip = contact_strip(pictures, time_labels(times, facts.time_unit));
  return {data_uri(studio::jpeg_of(srgb8_from_linear(strip)), "image/jpeg"), entry.title()};
}

void save_page(const std::filesystem::path& path, const std::vector<Entry>& entries, const RunControl& control) {
  HtmlPage page("Histories to start from");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    control.throw_if_stopped();
    const Entry& entry = entries[i];
    page.heading("library:" + entry.name);
    if (entry.card && !entry.card->about.empty()) page.paragraph(entry.card->about);
    page.picture(thumbnails_of(entry));
    page.paragraph(std::to_string(entry.facts().frames.size()) + " frames over " + entry.duration_text() +
                   "; controls: " + entry.controls_text());
    if (entry.card) page.paragraph(credit_text(*entry.card) + ". " + entry.card->source);
    control.report(static_cast<double>(i + 1) / static_cast<double>(entries.size()));
  }
  page.save(path);
}

/// A photograph is a history of one frame.
analysis::TextureSeries series_of(const std::filesystem::path& path) {
  if (kind_of(path) != PathKind::Image) return analysis::open_series(history_place(path)).series;
  MemoryHistoryImages images{.name = path.filename().string(), .frames = {}};
  images.frames.push_back({.time = 0.0, .color = read_color(path)});
  return analysis::TextureSeries(std::make_shared<const MemoryHistory>(std::move(images)));
}

struct Likeness {
  const Entry* entry;
  analysis::Dissimilarity how;
};

std::vector<Likeness> ranking_of(const std::filesystem::path& like, const std::vector<Entry>& entries,
                                 const RunControl& control) {
  const double part = 1.0 / static_cast<double>(entries.size() + 1);
  const analysis::SurfaceDescriptor mine = analysis::describe_surface(series_of(like), control.part(0.0, part));
  std::vector<Likeness> ranking;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const RunControl stage = control.part(part * static_cast<double>(i + 1),
                                          i + 1 == entries.size() ? 1.0 : part * static_cast<double>(i + 2));
    const analysis::TextureSeries series(entries[i].history);
    ranking.push_back({&entries[i], analysis::dissimilarity(mine, analysis::describe_surface(series, stage))});
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const Likeness& a, const Likeness& b) { return a.how.total < b.how.total; });
  return ranking;
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const std::vector<Likeness>& ranking) {
  Json list = Json::array();
  for (const Likeness& l : ranking) {
    list.push_back({{"name", l.entry->name},
                    {"total", l.how.total},
                    {"colors_delta_e", l.how.colors},
                    {"structure_octaves", optional_json(l.how.structure)},
                    {"rates_spans", optional_json(l.how.rates)},
                    {"time", l.how.time}});
  }
  return list;
}

std::string ranking_text(const std::vector<Likeness>& ranking) {
  const auto number = [](const std::optional<double>& value) {
    return value ? short_number_text(rounded(*value, 3)) : std::string("-");
  };
  std::vector<std::vector<std::string>> rows{
      {"name", "distance", "colors (Delta E)", "structure (octaves)", "rates (spans)", "what"}};
  for (const Likeness& l : ranking) {
    rows.push_back({l.entry->name, number(l.how.total), number(l.how.colors), number(l.how.structure),
                    number(l.how.rates), l.entry->title()});
  }
  return table_text(rows);
}

}  // namespace

int cmd_library(CommandRun& run) {
  std::filesystem::path like, thumbnails;
  run.line.option("like", "SUBJECT",
                  "Rank by likeness to this history, simulation, transfer or photograph: colors, coarseness, and when "
                  "places change",
                  like);
  run.line.option("thumbnails", "PAGE.html", "Write a page with pictures of every history", thumbnails);
  run.line.without({"seed", "dry_run", "force"});
  run.line.example("library");
  run.line.example("library --thumbnails library.html");
  run.line.example("library --like rusty_fence.jpg");
  run.line.example("transfer library:copper bust.obj --control accessibility -o aged");
  if (!run.parse()) return 0;
  if (!like.empty()) require_exists(like);
  std::vector<Entry> entries;
  for (const LibraryEntry& found : library_entries())
    entries.push_back(
        {found.name, std::make_shared<const HistoryReader>(found.folder), read_history_card(found.folder)});
  if (entries.empty()) throw CannotComplete(missing_library_text());
  Json json{{"histories", Json::array()}};
  for (const Entry& entry : entries) json["histories"].push_back(json_of(entry));
  if (!thumbnails.empty()) save_page(thumbnails, entries, run.control("thumbnails"));
  if (like.empty()) {
    run.report(json, list_text(entries));
    return 0;
  }
  const std::vector<Likeness> ranking = ranking_of(like, entries, run.control("library"));
  json["like"] = json_of(ranking);
  run.report(json, ranking_text(ranking));
  return 0;
}

}  // namespace patinate::cli
