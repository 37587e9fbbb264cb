#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/history/history_shelf.h"
#include "app/request/history_library.h"
#include "app/request/path_kind.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/filters.h"
#include "libcommon/image/picture_bytes.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

constexpr int kThumbnailSide_px = 160;
constexpr std::size_t kThumbnails = 5;

std::string duration_text(const app::ShelfEntry& entry) {
  return short_number_text(rounded(entry.duration(), 4)) + " " + shown_time_unit(entry.facts().time_unit);
}

std::string controls_text(const app::ShelfEntry& entry) {
  std::string text;
  for (const ControlFacts& control : entry.facts().controls) text += (text.empty() ? "" : ", ") + control.name;
  return text.empty() ? "none" : text;
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

std::string shelf_text(const std::vector<app::ShelfEntry>& entries) {
  std::vector<std::vector<std::string>> rows{{"name", "frames", "duration", "controls", "license", "what"}};
  for (const app::ShelfEntry& entry : entries) {
    rows.push_back({entry.name, std::to_string(entry.facts().frames.size()), duration_text(entry), controls_text(entry),
                    entry.card ? entry.card->license : "not stated", entry.title()});
  }
  return table_text(rows) + "\n\npatinate transfer library:" + entries.front().name +
         " MESH --control accessibility -o aged";
}

HtmlPicture thumbnails_of(const app::ShelfEntry& entry) {
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
  const ImageF strip = contact_strip(pictures, app::time_labels(times, facts.time_unit));
  return {data_uri(jpeg_of(srgb8_from_linear(strip)), "image/jpeg"), entry.title()};
}

void save_page(const std::filesystem::path& path, const std::vector<app::ShelfEntry>& entries,
               const RunControl& control) {
  HtmlPage page("Histories to start from");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    control.throw_if_stopped();
    const app::ShelfEntry& entry = entries[i];
    page.heading("library:" + entry.name);
    if (entry.card && !entry.card->about.empty()) page.paragraph(entry.card->about);
    page.picture(thumbnails_of(entry));
    page.paragraph(std::to_string(entry.facts().frames.size()) + " frames over " + duration_text(entry) +
                   "; controls: " + controls_text(entry));
    if (entry.card) page.paragraph(credit_text(*entry.card) + ". " + entry.card->source);
    control.report(static_cast<double>(i + 1) / static_cast<double>(entries.size()));
  }
  page.save(path);
}

Json json_of(const std::vector<app::Likeness>& ranking, const std::vector<app::ShelfEntry>& entries) {
  Json list = Json::array();
  for (const app::Likeness& likeness : ranking) {
    Json json{{"name", entries[likeness.entry].name}};
    json.update(likeness.json());
    list.push_back(std::move(json));
  }
  return list;
}

std::string ranking_text(const std::vector<app::Likeness>& ranking, const std::vector<app::ShelfEntry>& entries) {
  const auto number = [](const std::optional<double>& value) {
    return value ? short_number_text(rounded(*value, 3)) : std::string("-");
  };
  std::vector<std::vector<std::string>> rows{
      {"name", "distance", "colors (Delta E)", "structure (octaves)", "rates (spans)", "what"}};
  for (const app::Likeness& l : ranking) {
    const app::ShelfEntry& entry = entries[l.entry];
    rows.push_back({entry.name, number(l.how.total), number(l.how.colors), number(l.how.structure), number(l.how.rates),
                    entry.title()});
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
  run.line.written();
  run.line.without({"seed", "dry_run"});
  run.line.example("history library");
  run.line.example("history library --thumbnails library.html");
  run.line.example("history library --like rusty_fence.jpg");
  run.line.example("transfer library:copper bust.obj --control accessibility -o aged");
  if (!run.parse()) return 0;
  if (!like.empty()) app::require_exists(like);
  const std::vector<app::ShelfEntry> entries = app::history_shelf();
  if (entries.empty()) throw CannotComplete(app::missing_library_text());
  Json json{{"histories", Json::array()}};
  for (const app::ShelfEntry& entry : entries) json["histories"].push_back(entry.json());
  if (!thumbnails.empty()) {
    (void)run.check_file(thumbnails, "", "page");
    save_page(thumbnails, entries, run.control("thumbnails"));
    json["thumbnails"] = thumbnails.string();
  }
  if (like.empty()) {
    run.report(json, thumbnails.empty() ? shelf_text(entries) : thumbnails.string() + ": pictures of every history");
    return 0;
  }
  const std::vector<app::Likeness> ranking =
      app::rank_by_likeness(app::series_or_photograph(like), entries, run.control("library"));
  json["like"] = json_of(ranking, entries);
  run.report(json, ranking_text(ranking, entries));
  return 0;
}

}  // namespace patinate::cli
